//! Guards: which modes of a transition exist at all, whatever the marking.
//!
//! A guard is a disjunction of clauses, a clause a conjunction of comparisons (seed 000, equation 2.10: G = G&₁ ∨ G&₂ ∨
//! …). The source starts from colours that may be negated and adds comparisons of components with each other and with
//! numbers (definition 36); a colour is the comparison of its component with a number, so one form does for both.
//!
//! A clause may be *scheduled*: then it also needs a decision of the dispatcher (definition 40; the keyword of the
//! source's grammar). Decisions are outside of this module; see [`super::decide`].

use std::fmt;

use super::domain::{BasicDomain, BasicId};
use super::linear::turn;

/// The most clauses of a guard, and the most comparisons of a clause.
pub const MAX_CLAUSES: usize = 4096;

/// Operand of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Operand {
    /// proj(k) of the mode, moved on around its ring.
    Component {
        /// k, from 1.
        component: u32,
        /// Number of tones on; back if negative.
        by: i64,
    },
    Number(i64),
}

impl Operand {
    /// `proj(k)#succ(kₓ)`: so many tones on. A number stays what it is.
    pub fn succ(self, by: u32) -> Operand {
        self.turned(by.into())
    }

    /// `proj(k)#pred(kₓ)`: so many tones back. A number stays what it is.
    pub fn pred(self, by: u32) -> Operand {
        self.turned(-i64::from(by))
    }

    fn turned(self, more: i64) -> Operand {
        match self {
            Operand::Component { component, by } => Operand::Component { component, by: by.saturating_add(more) },
            number => number,
        }
    }
}

/// Comparison of two operands (seed 000, definition 36; ≠ is the negated colour of definition 13).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]

pub enum Comparison {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

impl Comparison {
    fn holds(self, left: i64, right: i64) -> bool {
        match self {
            Comparison::Equal => left == right,
            Comparison::NotEqual => left != right,
            Comparison::Less => left < right,
            Comparison::LessOrEqual => left <= right,
            Comparison::Greater => left > right,
            Comparison::GreaterOrEqual => left >= right,
        }
    }
}

/// One comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Atom {
    /// The left side.
    pub left: Operand,
    /// The relation.
    pub comparison: Comparison,
    /// The right side.
    pub right: Operand,
}

/// proj(k): component k of the mode, from 1.
pub fn component(component: u32) -> Operand {
    Operand::Component { component, by: 0 }
}

pub fn compare(left: Operand, comparison: Comparison, right: Operand) -> Atom {
    Atom { left, comparison, right }
}

/// The colour `tone` in component k.
pub fn colour(k: u32, tone: u32) -> Atom {
    compare(component(k), Comparison::Equal, Operand::Number(tone.into()))
}

/// Any colour but `tone` in component k.
pub fn not_colour(k: u32, tone: u32) -> Atom {
    compare(component(k), Comparison::NotEqual, Operand::Number(tone.into()))
}

/// G&ᵢ: all of these comparisons; and, if scheduled, the dispatcher's decision bdvᵢ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Clause {
    pub(super) atoms: Vec<Atom>,
    pub(super) scheduled: bool,
}

impl Clause {
    /// All of these.
    pub fn all(atoms: impl IntoIterator<Item = Atom>) -> Clause {
        Clause { atoms: atoms.into_iter().collect(), scheduled: false }
    }

    /// The clause, enabled only by a decision of the dispatcher.
    pub fn scheduled(mut self) -> Clause {
        self.scheduled = true;
        self
    }
}

impl<const N: usize> From<[Atom; N]> for Clause {
    fn from(atoms: [Atom; N]) -> Clause {
        Clause::all(atoms)
    }
}

/// G = G&₁ ∨ G&₂ ∨ …
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Guard {
    pub(super) clauses: Vec<Clause>,
}

impl Guard {
    /// Any of these.
    pub fn any<C: Into<Clause>>(clauses: impl IntoIterator<Item = C>) -> Guard {
        Guard { clauses: clauses.into_iter().map(Into::into).collect() }
    }

    /// One clause: all of these comparisons.
    pub fn all(atoms: impl IntoIterator<Item = Atom>) -> Guard {
        Guard::any([Clause::all(atoms)])
    }
}

/// An operand with its component resolved: position from 0 in the mode, and the size of its ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum GuardOperand {
    Component { from: u32, shift: u32, size: u32 },
    Number(i64),
}

impl GuardOperand {
    fn of(self, mode: &[u32]) -> i64 {
        match self {
            GuardOperand::Component { from, shift, size } => i64::from(turn(mode[from as usize], shift, size)) + 1,
            GuardOperand::Number(number) => number,
        }
    }
}

/// A comparison with its operands resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Test {
    pub(super) left: GuardOperand,
    pub(super) comparison: Comparison,
    pub(super) right: GuardOperand,
}

impl Test {
    pub(super) fn holds(&self, mode: &[u32]) -> bool {
        self.comparison.holds(self.left.of(mode), self.right.of(mode))
    }

    pub(super) fn values_mut(&mut self) -> [&mut GuardOperand; 2] {
        [&mut self.left, &mut self.right]
    }
}

/// A clause with its operands resolved.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Case {
    pub(super) tests: Vec<Test>,
    pub(super) scheduled: bool,
}

impl Case {
    pub(super) fn holds(&self, mode: &[u32]) -> bool {
        self.tests.iter().all(|test| test.holds(mode))
    }
}

/// Reason why a guard is meaningless for a domain.
pub(super) enum GuardFault {
    NoComponent { component: u32 },
    NoTone { component: u32, number: i64, size: u32 },
}

/// The meaning of a guard for modes of `domain`, or all its errors.
pub(super) fn compile(guard: &Guard, domain: &[BasicId], all: &[BasicDomain]) -> Result<Vec<Case>, Vec<GuardFault>> {
    let mut faults = Vec::new();
    let mut value = |operand| match operand {
        Operand::Number(number) => GuardOperand::Number(number),
        Operand::Component { component, by } => match domain.get((component as usize).wrapping_sub(1)) {
            None => {
                faults.push(GuardFault::NoComponent { component });
                GuardOperand::Number(0)
            }
            Some(basic) => {
                let size = all[basic.index()].size;
                GuardOperand::Component { from: component - 1, shift: by.rem_euclid(size.into()) as u32, size }
            }
        },
    };
    let mut test = |atom: &Atom| Test { left: value(atom.left), comparison: atom.comparison, right: value(atom.right) };
    let mut case =
        |clause: &Clause| Case { tests: clause.atoms.iter().map(&mut test).collect(), scheduled: clause.scheduled };
    let cases: Vec<Case> = guard.clauses.iter().map(&mut case).collect();
    for test in cases.iter().flat_map(|case| &case.tests) {
        faults.extend(no_tone(test));
    }
    if faults.is_empty() { Ok(cases) } else { Err(faults) }
}

/// A colour that its component cannot have is a slip of the pen, where an order with a number beyond the ring is not.
fn no_tone(test: &Test) -> Option<GuardFault> {
    let (from, size, number) = match (test.left, test.right) {
        (GuardOperand::Component { from, size, .. }, GuardOperand::Number(number))
        | (GuardOperand::Number(number), GuardOperand::Component { from, size, .. }) => (from, size, number),
        _ => return None,
    };
    let named = matches!(test.comparison, Comparison::Equal | Comparison::NotEqual);
    let outside = !(1..=i64::from(size)).contains(&number);
    (named && outside).then_some(GuardFault::NoTone { component: from + 1, number, size })
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Comparison::Equal => "=",
            Comparison::NotEqual => "≠",
            Comparison::Less => "<",
            Comparison::LessOrEqual => "≤",
            Comparison::Greater => ">",
            Comparison::GreaterOrEqual => "≥",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn basics() -> [BasicDomain; 3] {
        [("A", 10), ("B", 13), ("C", 30)].map(|(name, size)| BasicDomain { name: name.into(), size, tones: Vec::new() })
    }

    const ABC: [BasicId; 3] = [BasicId(0), BasicId(1), BasicId(2)];

    fn truth(guard: &Guard, mode: [u32; 3]) -> bool {
        let Ok(cases) = compile(guard, &ABC, &basics()) else { panic!("the guard has a meaning") };
        let mode = mode.map(|tone| tone - 1);
        cases.iter().any(|case| case.holds(&mode))
    }

    /// Seed 000, Fig. 75(a), L3596: `proj(2)=10 or proj(2)=proj(3)#succ(3)`. The text (L3590) has the second component
    /// one *less* than the third, the code one more; the code is taken.
    #[test]
    fn the_guard_of_the_grammar_follows_its_code() {
        let next = compare(component(2), Comparison::Equal, component(3).succ(1));
        let guard = Guard::any([Clause::all([colour(2, 10)]), Clause::all([next])]);
        assert!(truth(&guard, [1, 10, 25]));
        assert!(truth(&guard, [1, 5, 4]));
        assert!(!truth(&guard, [1, 4, 5]));
        assert!(truth(&guard, [1, 1, 30]), "the ring of C closes from 30 to 1");
        assert!(!truth(&guard, [1, 13, 30]));
    }

    /// Seed 000, definition 36, L2210: `(proj(4).succ(4) = 5)`, `(proj(3) > 2)`, `(¬c)`, here on three components.
    #[test]
    fn comparisons_are_those_of_numbers_from_one() {
        let five = Guard::all([compare(component(3).succ(1), Comparison::Equal, Operand::Number(5))]);
        assert!(truth(&five, [1, 1, 4]) && !truth(&five, [1, 1, 5]));
        let more = Guard::all([compare(component(3), Comparison::Greater, Operand::Number(2))]);
        assert!(truth(&more, [1, 1, 3]) && !truth(&more, [1, 1, 2]));
        assert!(!truth(&Guard::all([not_colour(1, 4)]), [4, 1, 1]));
        let at_most = Guard::all([compare(component(1).pred(1), Comparison::LessOrEqual, component(2))]);
        assert!(truth(&at_most, [3, 2, 1]) && !truth(&at_most, [1, 9, 1]), "1 is preceded by 10");
        assert!(truth(&Guard::all([]), [1, 1, 1]), "no condition holds always");
        assert!(!truth(&Guard::any::<Clause>([]), [1, 1, 1]), "no case holds never");
    }

    #[test]
    fn all_faults_are_found() {
        let guard = Guard::any([Clause::all([colour(4, 1), colour(1, 11)]), Clause::all([not_colour(0, 1)])]);
        assert_eq!(compile(&guard, &ABC, &basics()).err().map(|faults| faults.len()), Some(3));
    }
}
