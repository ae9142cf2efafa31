//! Hand-mode conditions of the six hand-mode types (seed 002 Figure 21).
//!
//! The drawing of Figure 21 is lost. Its caption has the purpose of each type, and the bracketed entries of Figure 20
//! the conditions a type may add to the common ones; together they leave one reading:
//!
//! | type | t9 | t11 | t4 | t12 |
//! |---|---|---|---|---|
//! | 1 sequence | | h_a | | |
//! | 2 sequence, last | | h_c↑ | | |
//! | 3 reversed, first | h_a↑ | h_a | | |
//! | 4 reversed, middle | | h_a | | h_b |
//! | 5 reversed, last | | h_c↑ | h_b↑ | h_b |
//! | 6 single | h_a↑ | h_c↑ | h_b↑ | |
//!
//! The caption prints the same words for types 2 and 5; Table 3 uses type 2 for the last operation of a sequence
//! that is *not* reversed, and so do we. t12 of the first reversed operation does not exist: the reverse sequence
//! ends there. t3 waits for h_a and t8 for h_b, in all types that have them.

use crate::net::condition::{Conjunction, Literal, Var, off, on};
use crate::{ButtonId, HandMode};

impl HandMode {
    /// Whether pressing `next`, once the operation is complete, is what leads on (t11 with h_c↑).
    fn starts_next_by(&self) -> Literal {
        match self.next() {
            Some(next) => on(Var::Pressed(next)),
            None => on(Var::Held(self.forward())),
        }
    }

    /// t11, to the step `next`.
    pub(super) fn lead_on(&self, next: usize) -> Conjunction {
        vec![self.starts_next_by(), on(Var::Causal(next))]
    }

    /// t4: reverse a completed operation, where the type begins a reverse motion.
    ///
    /// Table 3 gives some operations the same button for h_b and h_c (the two operations of a clamp are each other's
    /// reverse). Which transition such a press means is then decided by the arrows: on to the next operation if its
    /// causes hold, else back. Where the buttons differ and both are pressed in one image, forward wins.
    pub(super) fn reverse(&self, next_step: usize) -> Option<Conjunction> {
        let (back, next) = match *self {
            HandMode::ReversedEnd { back, next, .. } | HandMode::Single { back, next, .. } => (back, next),
            HandMode::Sequence { .. }
            | HandMode::SequenceEnd { .. }
            | HandMode::ReversedStart { .. }
            | HandMode::ReversedMiddle { .. } => return None,
        };
        let not_forward = if back == next { off(Var::Causal(next_step)) } else { off(Var::Pressed(next)) };
        Some(vec![on(Var::Pressed(back)), not_forward])
    }

    /// `h_b`, where pressing it reverses the operation once it is complete (t4 with h_b↑).
    pub fn reverses_from_its_end(&self) -> Option<ButtonId> {
        match *self {
            HandMode::ReversedEnd { back, .. } | HandMode::Single { back, .. } => Some(back),
            HandMode::Sequence { .. }
            | HandMode::SequenceEnd { .. }
            | HandMode::ReversedStart { .. }
            | HandMode::ReversedMiddle { .. } => None,
        }
    }

    /// t9: start again an operation that has been undone.
    pub(super) fn restart(&self) -> Option<Conjunction> {
        self.restarts_by().map(|forward| vec![on(Var::Pressed(forward))])
    }

    /// `h_a`, where pressing it starts an operation again that has been undone (t9 with h_a↑).
    pub fn restarts_by(&self) -> Option<ButtonId> {
        match *self {
            HandMode::ReversedStart { forward, .. } | HandMode::Single { forward, .. } => Some(forward),
            HandMode::Sequence { .. }
            | HandMode::SequenceEnd { .. }
            | HandMode::ReversedMiddle { .. }
            | HandMode::ReversedEnd { .. } => None,
        }
    }

    /// t12: on to reversing the operation before, where the reverse sequence does not end here.
    ///
    /// Whether t12 exists at all, in any mode, follows from the type (seed 002 §6.1.1).
    pub fn reverse_on(&self) -> Option<ButtonId> {
        match *self {
            HandMode::ReversedMiddle { back, .. } | HandMode::ReversedEnd { back, .. } => Some(back),
            HandMode::Sequence { .. }
            | HandMode::SequenceEnd { .. }
            | HandMode::ReversedStart { .. }
            | HandMode::Single { .. } => None,
        }
    }
}
