//! Meaning of a colour function for a given domain, in the one form that is computed with.
//!
//! Every composition of the standard functions comes down to the same thing: each component of the result is some
//! component of the argument, so many tones on. A function is then a sum of weighted terms of that form. Two
//! compositions that are equal for this reason have the same form, and like terms are added up; so the commuting
//! functions of the source (seed 000, after definition 21) need no algebra here.

use thiserror::Error;

use super::domain::{BasicDomain, BasicId, DomainShape, show_domain};
use super::function::{Function, FunctionStep, MAX_TERMS};

/// Reason why a function has no meaning for a domain.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FunctionError {
    /// A step names a component that the tuple at hand does not have.
    #[error("`{step}` names component {component}, but what it is applied to is of {domain}")]
    NoComponent {
        step: String,
        /// The component it names, from 1.
        component: u32,
        /// The domain of what it is applied to.
        domain: String,
    },
    /// The terms of a sum lead to different domains.
    #[error("the sum adds colours of {first} and of {other}")]
    Mixed {
        /// Where the first term leads.
        first: String,
        /// Where another leads.
        other: String,
    },
    /// Too many terms, or weights beyond counting.
    #[error("it has more than {MAX_TERMS} terms or steps, or a weight that cannot be counted")]
    TooLarge,
    /// No term is left.
    #[error("empty sum")]
    Empty,
}

/// A component of the result: a component of the argument (from 0), moved on by less than a whole turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct ComponentPick {
    pub(super) from: u32,
    pub(super) shift: u32,
}

/// A weighted term: one colour per colour.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct LinearTerm {
    pub(super) picks: Box<[ComponentPick]>,
    pub(super) weight: i64,
}

impl LinearTerm {
    /// The position of the resulting colour in its domain; tones count from 0.
    pub(super) fn apply(&self, argument: &[u32], target: &DomainShape) -> u32 {
        self.picks
            .iter()
            .zip(&target.sizes)
            .fold(0, |position, (pick, &size)| position * size + turn(argument[pick.from as usize], pick.shift, size))
    }
}

/// `tone` moved on by `shift`; both are less than `size`.
pub(super) fn turn(tone: u32, shift: u32, size: u32) -> u32 {
    // One comparison instead of a division, and no sum that could leave 32 bits.
    if tone < size - shift { tone + shift } else { tone - (size - shift) }
}

/// A function from one domain to another: like terms added up, ordered, none with weight 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct LinearFunction {
    pub(super) target: Vec<BasicId>,
    pub(super) terms: Vec<LinearTerm>,
}

/// The argument after some steps: for each component its domain and its pick.
type Tuple = Vec<(BasicId, ComponentPick)>;

/// The meaning of a function for arguments of `domain`.
pub(super) fn compile(
    function: &Function,
    domain: &[BasicId],
    all: &[BasicDomain],
) -> Result<LinearFunction, FunctionError> {
    if function.too_large {
        return Err(FunctionError::TooLarge);
    }
    let start: Tuple = domain.iter().zip(0..).map(|(&basic, from)| (basic, ComponentPick { from, shift: 0 })).collect();
    let mut target: Option<Vec<BasicId>> = None;
    let mut terms = Vec::new();
    for term in &function.terms {
        for tuple in follow(&term.steps, &start, all)? {
            let basics: Vec<BasicId> = tuple.iter().map(|&(basic, _)| basic).collect();
            let first = target.get_or_insert_with(|| basics.clone());
            if *first != basics {
                let (first, other) = (show_domain(first, all), show_domain(&basics, all));
                return Err(FunctionError::Mixed { first, other });
            }
            terms.push(LinearTerm { picks: tuple.into_iter().map(|(_, pick)| pick).collect(), weight: term.weight });
        }
        if terms.len() > MAX_TERMS {
            return Err(FunctionError::TooLarge);
        }
    }
    let target = target.ok_or(FunctionError::Empty)?;
    Ok(LinearFunction { target, terms: collect(terms).ok_or(FunctionError::TooLarge)? })
}

/// Like terms added up, or none if a weight cannot be counted.
pub(super) fn collect(mut terms: Vec<LinearTerm>) -> Option<Vec<LinearTerm>> {
    terms.sort_unstable();
    let mut sums: Vec<LinearTerm> = Vec::with_capacity(terms.len());
    for term in terms {
        match sums.last_mut() {
            Some(last) if last.picks == term.picks => last.weight = last.weight.checked_add(term.weight)?,
            _ => sums.push(term),
        }
    }
    sums.retain(|term| term.weight != 0);
    Some(sums)
}

/// Applies the steps of one composition. There is one result, except where a ring function makes several.
fn follow(steps: &[FunctionStep], start: &Tuple, all: &[BasicDomain]) -> Result<Vec<Tuple>, FunctionError> {
    let mut tuples = vec![start.clone()];
    for step in steps {
        // All tuples are of the same domain at any time.
        let here: Vec<BasicId> = tuples[0].iter().map(|&(basic, _)| basic).collect();
        let at = |component: u32| {
            let index = (component as usize).wrapping_sub(1);
            let none =
                || FunctionError::NoComponent { step: step.to_string(), component, domain: show_domain(&here, all) };
            if index < here.len() { Ok(index) } else { Err(none()) }
        };
        let size = |index: usize| all[here[index].index()].size;
        match step {
            FunctionStep::Project(components) => {
                let indices = components.iter().map(|&component| at(component)).collect::<Result<Vec<_>, _>>()?;
                tuples.iter_mut().for_each(|tuple| *tuple = indices.iter().map(|&index| tuple[index]).collect());
            }
            FunctionStep::Discolour => tuples.iter_mut().for_each(Vec::clear),
            FunctionStep::Shift { component, by } => {
                let index = at(*component)?;
                let by = by.rem_euclid(size(index).into()) as u32;
                tuples.iter_mut().for_each(|tuple| move_on(&mut tuple[index].1, by, size(index)));
            }
            FunctionStep::Ring(component) => {
                let index = at(*component)?;
                if tuples.len().saturating_mul(size(index) as usize) > MAX_TERMS {
                    return Err(FunctionError::TooLarge);
                }
                let turns = |tuple: Tuple| {
                    (0..size(index)).map(move |by| {
                        let mut tuple = tuple.clone();
                        move_on(&mut tuple[index].1, by, size(index));
                        tuple
                    })
                };
                tuples = tuples.into_iter().flat_map(turns).collect();
            }
        }
    }
    Ok(tuples)
}

fn move_on(pick: &mut ComponentPick, by: u32, size: u32) {
    pick.shift = turn(pick.shift, by, size);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coloured::{abs, id, pred, proj, ring, succ};

    fn domains() -> [BasicDomain; 2] {
        [("A", 2), ("B", 3)].map(|(name, size)| BasicDomain { name: name.into(), size, tones: Vec::new() })
    }

    const AB: [BasicId; 2] = [BasicId(0), BasicId(1)];

    fn refusal(function: Function) -> String {
        compile(&function, &AB, &domains()).unwrap_err().to_string()
    }

    #[test]
    fn successor_and_predecessor_undo_each_other_and_a_whole_turn_is_nothing() {
        let all = domains();
        let meaning = |function: Function| compile(&function, &AB, &all).unwrap();
        assert_eq!(meaning(succ(2, 1).of(pred(2, 1))), meaning(id()));
        assert_eq!(meaning(pred(2, 2).of(succ(2, 2))), meaning(id()));
        assert_eq!(meaning(succ(2, 3)), meaning(id()));
        assert_eq!(meaning(pred(2, 1)), meaning(succ(2, 2)));
        assert_eq!(meaning(succ(1, 1).of(succ(2, 1))), meaning(succ(2, 1).of(succ(1, 1))));
        assert_eq!(meaning(ring(2).of(succ(2, 1))), meaning(ring(2)));
        assert_eq!(meaning(proj([])), meaning(abs()));
        assert_eq!(meaning(id() - 2 * succ(2, 3).of(id()) + 2 * id()), meaning(id()));
        assert!(meaning(id() - id()).terms.is_empty());
    }

    #[test]
    fn what_means_nothing_is_refused_with_its_reason() {
        let far = "`proj(1,3)` names component 3, but what it is applied to is of A*B";
        assert_eq!(refusal(proj([1, 3])), far);
        let zero = "`succ(0_1)` names component 0, but what it is applied to is of A*B";
        assert_eq!(refusal(succ(0, 1)), zero);
        let after = "`succ(2_1)` names component 2, but what it is applied to is of B";
        assert_eq!(refusal(succ(2, 1).of(proj([2]))), after);
        assert_eq!(refusal(proj([1]) + id()), "the sum adds colours of A and of A*B");
        assert_eq!(refusal(abs() + proj([2])), "the sum adds colours of <•> and of B");
        assert_eq!(refusal(Function::zero()), "empty sum");
        let all = [BasicDomain { name: "A".into(), size: u32::MAX, tones: Vec::new() }];
        assert_eq!(compile(&ring(1), &[BasicId(0)], &all), Err(FunctionError::TooLarge));
    }

    #[test]
    fn turning_stays_within_the_ring_at_the_ends_of_what_can_be_counted() {
        assert_eq!(turn(u32::MAX - 1, u32::MAX - 1, u32::MAX), u32::MAX - 2);
        assert_eq!((turn(0, 0, 1), turn(2, 1, 3), turn(1, 1, 3)), (0, 0, 2));
    }
}
