//! Points about time that the source leaves open, as settings with names.
//!
//! Seed 003 §3.2 gives two readings of a clock and none of a deadline. Each enum below quotes the lines for its
//! variants. The default is what makes the source's own examples come out: its plants measure "the time for a
//! transition to be fired after being enabled" (L512), and "automatically, after 100 milliseconds t2 is fired" (L535).

use std::fmt;

/// [DR, DL] of an input arc, both ends included, in the caller's unit of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Interval {
    /// DR: "the minimum time that the token should spend at a particular place before the transition(s) can be fired"
    /// (L403).
    pub earliest: u32,
    /// DL: "the maximum time the place may hold a token for (if all the other conditions for transition firing are
    /// met)" (L404). `None` is without end.
    pub latest: Option<u32>,
}

impl Interval {
    /// [0, ∞): no time on the arc.
    pub const ANY: Interval = Interval { earliest: 0, latest: None };

    /// [DR, ∞).
    pub const fn at_least(earliest: u32) -> Interval {
        Interval { earliest, latest: None }
    }

    /// [DR, DL].
    pub const fn between(earliest: u32, latest: u32) -> Interval {
        Interval { earliest, latest: Some(latest) }
    }

    /// [d, d].
    pub const fn exactly(time: u32) -> Interval {
        Interval::between(time, time)
    }

    /// The first clock value from which on a clock no longer matters to this interval.
    pub(crate) fn horizon(self) -> u32 {
        self.latest.map_or(self.earliest, |latest| latest.saturating_add(1))
    }
}

impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.latest {
            Some(latest) => write!(f, "[{}, {latest}]", self.earliest),
            None => write!(f, "[{}, ∞)", self.earliest),
        }
    }
}

/// Clock that the interval of an arc is compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ArcClock {
    /// The time the token has spent on the place (L403).
    TokenAge,
    /// The time since the transition's input places have been marked (L491: "three seconds after they will be
    /// enabled"), whatever its conditions: "enabled" is about tokens alone (L341, L356).
    SinceMarked,
    /// The time since the input places have been marked and the conditions have held. The only reading in which a
    /// mechanism at rest takes its time when it is switched on: its place has been marked all along, the condition is
    /// what begins the motion (L512, L731).
    #[default]
    SinceEnabled,
}

/// When a spontaneous transition fires.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FiringPolicy {
    /// As soon as its intervals allow: no time passes before (L535 "automatically, after 100 milliseconds").
    #[default]
    Earliest,
    /// At any time its intervals allow (L403 "before the transition(s) *can* be fired").
    Window,
}

/// Effect when DL passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Deadline {
    /// A bound on waiting: once the transition could fire and a clock has reached DL, no time passes before it, or
    /// something that disables it, fires. A transition that was kept from firing until later fires late: DL binds "if
    /// all the other conditions for transition firing are met" (L404).
    #[default]
    Must,
    /// A bound on use: a token older than DL cannot be taken by this transition any more, and nothing is forced. The
    /// token is not removed; another transition may take it, and a younger token on the place serves this one.
    Expires,
}

/// Which fired sources call a forced transition, when several event arcs lead to it. The source shows one event arc per
/// transition and leaves this open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum EventMode {
    /// One of them is enough.
    #[default]
    Any,
    /// All of them, in the same step.
    All,
}

/// One reading of seed 003 §3.2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Semantics {
    /// Clock that intervals are compared with.
    pub clock: ArcClock,
    /// When a spontaneous transition fires.
    pub firing: FiringPolicy,
    /// Meaning of DL.
    pub deadline: Deadline,
}

impl Semantics {
    /// All twelve readings.
    pub fn all() -> impl Iterator<Item = Semantics> {
        let clocks = [ArcClock::TokenAge, ArcClock::SinceMarked, ArcClock::SinceEnabled];
        let firings = [FiringPolicy::Earliest, FiringPolicy::Window];
        let deadlines = [Deadline::Must, Deadline::Expires];
        clocks.into_iter().flat_map(move |clock| {
            firings.into_iter().flat_map(move |firing| {
                deadlines.into_iter().map(move |deadline| Semantics { clock, firing, deadline })
            })
        })
    }
}
