//! Colour functions as they are written: sums of weighted compositions of the standard functions.
//!
//! A function is written down without knowing the tuples it will be applied to; what it means for a given domain, and
//! whether it means anything, is worked out in [`super::linear`]. The standard functions are those of seed 000,
//! definition 21: projection, identity, successor, predecessor and discolouring, their compositions, multiples and sums,
//! and the ring function R.
//!
//! A sum is kept multiplied out, so that nothing nests however it was put together. Sums composed with sums can still
//! explode; beyond [`MAX_TERMS`] a function records only that it is too large.

use std::fmt;
use std::ops::{Add, Mul, Neg, Sub};

/// The most terms of a function after multiplying out, and the most steps of a term. The functions of the source have
/// up to three of either; a ring function has as many terms as its ring has tones.
pub const MAX_TERMS: usize = 4096;

/// One step of a composition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum FunctionStep {
    /// The components with these numbers, from 1.
    Project(Vec<u32>),
    /// So many tones on (or back) in a component.
    Shift {
        component: u32,
        by: i64,
    },
    /// The sum over all shifts of a component.
    Ring(u32),
    Discolour,
}

/// A weighted composition. The steps are in the order in which they are applied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CompositionTerm {
    pub(super) weight: i64,
    pub(super) steps: Vec<FunctionStep>,
}

/// A colour function: it turns a colour into a bag of colours (seed 000, definition 21).
///
/// ```
/// use linewright_nets::coloured::{abs, id, proj, succ};
///
/// // The first component, moved on by one tone; and twice the whole colour.
/// let f = proj([1]).of(succ(1, 1));
/// let g = 2 * id() + abs();
/// assert_eq!(f.to_string(), "proj(1)#succ(1_1)");
/// assert_eq!(g.to_string(), "2*id + abs");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    pub(super) terms: Vec<CompositionTerm>,
    pub(super) too_large: bool,
}

fn single(steps: Vec<FunctionStep>) -> Function {
    Function { terms: vec![CompositionTerm { weight: 1, steps }], too_large: false }
}

/// id: the colour itself.
pub fn id() -> Function {
    single(Vec::new())
}

/// proj(k₁, …, kᵢ): the components with these numbers, from 1. The source has them ascending; any order is possible.
pub fn proj(components: impl IntoIterator<Item = u32>) -> Function {
    single(vec![FunctionStep::Project(components.into_iter().collect())])
}

/// succ(kₓ): component k moved on by x tones, around the ring.
pub fn succ(component: u32, by: u32) -> Function {
    single(vec![FunctionStep::Shift { component, by: by.into() }])
}

/// pred(kₓ): component k moved back by x tones, around the ring.
pub fn pred(component: u32, by: u32) -> Function {
    single(vec![FunctionStep::Shift { component, by: -i64::from(by) }])
}

/// abs: the uncoloured token, whatever the colour.
pub fn abs() -> Function {
    single(vec![FunctionStep::Discolour])
}

/// `R‹k›` = succ(k₀) + succ(k₁) + … + succ(kₛ₋₁): every tone of component k once (seed 000, equation 2.12).
pub fn ring(component: u32) -> Function {
    single(vec![FunctionStep::Ring(component)])
}

impl Function {
    /// The function without a term: the empty bag, whatever the colour.
    pub fn zero() -> Function {
        Function { terms: Vec::new(), too_large: false }
    }

    /// `self`∘`first`: first the other, then this one. The source writes `self.first` or `self#first`.
    pub fn of(&self, first: Function) -> Function {
        let mut result = Function { terms: Vec::new(), too_large: self.too_large || first.too_large };
        let steps = |function: &Function| function.terms.iter().map(|term| term.steps.len()).max().unwrap_or(0);
        let many = self.terms.len().saturating_mul(first.terms.len()) > MAX_TERMS;
        if result.too_large || many || steps(self) + steps(&first) > MAX_TERMS {
            return Function { terms: Vec::new(), too_large: true };
        }
        for last in &self.terms {
            for early in &first.terms {
                let Some(weight) = last.weight.checked_mul(early.weight) else {
                    return Function { terms: Vec::new(), too_large: true };
                };
                let steps = early.steps.iter().chain(&last.steps).cloned().collect();
                result.terms.push(CompositionTerm { weight, steps });
            }
        }
        result
    }
}

impl Add for Function {
    type Output = Function;
    fn add(mut self, mut other: Function) -> Function {
        self.too_large |= other.too_large || self.terms.len() + other.terms.len() > MAX_TERMS;
        if self.too_large {
            self.terms.clear();
        } else {
            self.terms.append(&mut other.terms);
        }
        self
    }
}

impl Mul<Function> for i64 {
    type Output = Function;
    fn mul(self, mut function: Function) -> Function {
        for term in &mut function.terms {
            match term.weight.checked_mul(self) {
                Some(weight) => term.weight = weight,
                None => function.too_large = true,
            }
        }
        function
    }
}

impl Neg for Function {
    type Output = Function;
    fn neg(self) -> Function {
        -1 * self
    }
}

impl Sub for Function {
    type Output = Function;
    fn sub(self, other: Function) -> Function {
        self + -other
    }
}

impl fmt::Display for FunctionStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FunctionStep::Project(components) => {
                let numbers: Vec<_> = components.iter().map(u32::to_string).collect();
                write!(f, "proj({})", numbers.join(","))
            }
            FunctionStep::Shift { component, by } if *by < 0 => write!(f, "pred({component}_{})", by.unsigned_abs()),
            FunctionStep::Shift { component, by } => write!(f, "succ({component}_{by})"),
            FunctionStep::Ring(component) => write!(f, "R<{component}>"),
            FunctionStep::Discolour => f.write_str("abs"),
        }
    }
}

impl fmt::Display for CompositionTerm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.weight {
            1 => {}
            -1 => f.write_str("-")?,
            weight => write!(f, "{weight}*")?,
        }
        if self.steps.is_empty() {
            return f.write_str("id");
        }
        // The step applied last is written first.
        let steps: Vec<_> = self.steps.iter().rev().map(FunctionStep::to_string).collect();
        f.write_str(&steps.join("#"))
    }
}

impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.too_large {
            return f.write_str("(too large)");
        }
        let terms: Vec<_> = self.terms.iter().map(CompositionTerm::to_string).collect();
        f.write_str(if terms.is_empty() { "0".to_owned() } else { terms.join(" + ") }.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compositions_are_multiplied_out() {
        let f = (proj([1]) - 2 * proj([2])).of(3 * succ(1, 1) + id());
        assert_eq!(f.to_string(), "3*proj(1)#succ(1_1) + proj(1) + -6*proj(2)#succ(1_1) + -2*proj(2)");
        assert_eq!((abs() + pred(2, 1) + ring(1)).to_string(), "abs + pred(2_1) + R<1>");
        assert_eq!(Function::zero().to_string(), "0");
    }

    #[test]
    fn a_function_that_explodes_says_so_and_stays_small() {
        let mut sum = id() + id();
        for _ in 0..40 {
            sum = sum.of(sum.clone());
        }
        assert!(sum.too_large && sum.terms.is_empty());
        let mut chain = succ(1, 1);
        for _ in 0..40 {
            chain = chain.of(chain.clone());
        }
        assert!(chain.too_large && chain.terms.is_empty());
        assert!((i64::MAX * (2 * id())).too_large);
        assert!((chain + id()).too_large);
    }
}
