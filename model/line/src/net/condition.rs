//! Conditions of transitions, as data.
//!
//! A condition is a disjunction of [`Conjunction`]s, a term a conjunction of [`Literal`]s over a handful of variables. One
//! transition that several modes share carries (auto ∧ C1) ∨ (hand ∧ C2) ∨ (manual ∧ C3) (seed 002 §4.4, equation 2):
//! here it is one list of terms per mode.
//!
//! The seed writes the completion and fault signals as edges, s↑ and f↑. A level that is already on when the motion
//! starts, or comes on in the very image in which a button is released, would then be lost for good. So
//! [`Var::Fault`] is a level, and [`Var::Arrived`] is the edge s↑ *remembered* from the start of the motion until it
//! is used: the signal is on, and has been seen off since the motion left its other end. A switch that is stuck on
//! therefore never completes a motion that started at the far end: its watchdog finds it.

use crate::net::module::Block;
use crate::{ButtonId, OpId, TaskId};

/// The control mode of the line (seed 002 §5.4, the six places of Figure 18).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ControlMode {
    /// Switched off at the home position.
    Home,
    /// Running operations finish, nothing new starts.
    StandBy,
    /// The chart runs by itself.
    Auto,
    /// One step of the cycle per held button.
    Hand,
    /// Single operations, held at the station's own panel.
    Manual,
    /// Everything off.
    EStop,
}

impl ControlMode {
    /// All six.
    pub const ALL: [ControlMode; 6] = [
        ControlMode::Home,
        ControlMode::StandBy,
        ControlMode::Auto,
        ControlMode::Hand,
        ControlMode::Manual,
        ControlMode::EStop,
    ];

    /// Name for operators: `home`, `stand-by`, `auto`, `hand`, `manual`, `e-stop`.
    pub const fn name(self) -> &'static str {
        match self {
            ControlMode::Home => "home",
            ControlMode::StandBy => "stand-by",
            ControlMode::Auto => "auto",
            ControlMode::Hand => "hand",
            ControlMode::Manual => "manual",
            ControlMode::EStop => "e-stop",
        }
    }

    /// Whether new motion may start in this mode.
    pub const fn enables_motion(self) -> bool {
        matches!(self, ControlMode::Auto | ControlMode::Hand | ControlMode::Manual)
    }
}

impl std::fmt::Display for ControlMode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// A variable of a condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Var {
    /// f: the motion has failed — its fault input is on, its watchdog has run out, or the station's devices are lost.
    Fault(OpId, Block),
    /// s↑, remembered: the motion has arrived.
    Arrived(OpId, Block),
    /// The motion was held by a panel button in manual mode, and manual mode has ended under it.
    HoldLost,
    /// m_a: the panel's advance is held and its return is not.
    Advance,
    /// m_a↑.
    AdvancePressed,
    /// m_r: the panel's return is held and its advance is not.
    Retract,
    /// m_r↑.
    RetractPressed,
    /// h: a hand-mode button is held.
    Held(ButtonId),
    /// h↑.
    Pressed(ButtonId),
    /// Conditions of this step hold: the causal arrows into every operation of it, in the mode of the evaluation; at a
    /// task-driven station the inputs that its operation waits for are on.
    Causal(usize),
    /// The causal arrows hold into every operation after this irreversible one, up to and including home: what its
    /// recovery path skips must be as free as if it were done.
    WayHome(OpId),
    /// The station is on the recovery path of this irreversible operation.
    OnPath(OpId),
    /// The station is on any recovery path.
    OnAnyPath,
    /// A concurrent neighbour is not faulty: its token is in p3 or p6. With it the return command reverses neighbours
    /// together, yet a fault in one is recovered without moving the other (the seed's IVC A, A', B and B' of Figure 26,
    /// whose drawing is lost: this is the weakest condition with which no state of the pair is stuck).
    NeighbourSettled(OpId),
    /// Master stop has been given.
    MasterStop,
    /// The station is to do this task: it has an order for it.
    Ordered(TaskId),
    /// The station is to go back to the rest it came from, as far as it can by itself. It then has no task to do.
    Secure,
}

/// A variable or its negation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Literal {
    /// The variable.
    pub var: Var,
    /// Whether it must be on.
    pub on: bool,
}

/// A conjunction of literals; the empty one holds always ("N.C." in the seed's tables).
pub type Conjunction = Vec<Literal>;

/// The variable must be on.
pub(super) const fn on(var: Var) -> Literal {
    Literal { var, on: true }
}

/// The variable must be off.
pub(super) const fn off(var: Var) -> Literal {
    Literal { var, on: false }
}

impl Literal {
    /// Whether the two can never hold together.
    ///
    /// Beside a variable and its own negation: an edge implies its level, the panel's two commands exclude each other
    /// (held together they count as neither), a station is on one recovery path at most, and it is to do one task at most
    /// or to go back.
    pub fn excludes(self, other: Literal) -> bool {
        self.implies(other.negated()) || other.implies(self.negated())
    }

    fn negated(self) -> Literal {
        Literal { on: !self.on, ..self }
    }

    fn implies(self, other: Literal) -> bool {
        if self == other {
            return true;
        }
        if !self.on {
            return false;
        }
        match (self.var, other.var, other.on) {
            (Var::AdvancePressed, Var::Advance, true) | (Var::RetractPressed, Var::Retract, true) => true,
            (Var::Pressed(a), Var::Held(b), true) => a == b,
            (Var::Advance | Var::AdvancePressed, Var::Retract | Var::RetractPressed, false)
            | (Var::Retract | Var::RetractPressed, Var::Advance | Var::AdvancePressed, false) => true,
            (Var::OnPath(_), Var::OnAnyPath, true) => true,
            (Var::OnPath(a), Var::OnPath(b), false) => a != b,
            (Var::Ordered(a), Var::Ordered(b), false) => a != b,
            (Var::Ordered(_), Var::Secure, false) | (Var::Secure, Var::Ordered(_), false) => true,
            _ => false,
        }
    }
}
