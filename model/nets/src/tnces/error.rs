//! Errors of a system or a composition, in words that name the nodes and ports concerned.

use thiserror::Error;

use super::Interval;
use crate::{NamedId, NetError, PlaceId, TransitionId};

/// One error of the tables beside a net.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TncesError {
    /// A table names a place that the net does not have.
    #[error("{what} names place #{}, but the net has {places} places", place.0)]
    UnknownPlace {
        /// Table and entry.
        what: String,
        place: PlaceId,
        /// Number of places.
        places: usize,
    },
    /// A table names a transition that the net does not have.
    #[error("{what} names transition #{}, but the net has {transitions} transitions", transition.0)]
    UnknownTransition {
        /// Table and entry.
        what: String,
        transition: TransitionId,
        /// Number of transitions.
        transitions: usize,
    },
    /// A condition arc that always holds.
    #[error("the condition arc {place} → {transition} has weight 0")]
    ZeroWeight { place: NamedId<PlaceId>, transition: NamedId<TransitionId> },
    /// The same condition arc twice.
    #[error("the condition arc {place} → {transition} is declared {times} times")]
    DuplicateCondition {
        place: NamedId<PlaceId>,
        transition: NamedId<TransitionId>,
        /// Number of declarations.
        times: usize,
    },
    /// The same event arc twice.
    #[error("the event arc {from} → {to} is declared {times} times")]
    DuplicateEvent {
        /// The source.
        from: NamedId<TransitionId>,
        /// The transition it forces.
        to: NamedId<TransitionId>,
        /// Number of declarations.
        times: usize,
    },
    /// A set of alternative sources with nothing in it: the transition could never fire.
    #[error("{transition} waits for one event of none; name its sources")]
    NoSource { transition: NamedId<TransitionId> },
    /// Event arcs that lead back to where they start: each would wait for the others.
    #[error("the event arcs form a cycle: {}", names(cycle))]
    EventCycle {
        /// The transitions along it; the last one calls the first.
        cycle: Vec<NamedId<TransitionId>>,
    },
    /// An interval where the net has no input arc.
    #[error("the interval {interval} is on {place} → {transition}, which is no arc of the net")]
    NoSuchArc { place: NamedId<PlaceId>, transition: NamedId<TransitionId>, interval: Interval },
    /// DR > DL.
    #[error("the interval {interval} on {place} → {transition} ends before it begins")]
    Reversed { place: NamedId<PlaceId>, transition: NamedId<TransitionId>, interval: Interval },
    /// A bound beyond [`super::TIME_MAX`].
    #[error("the interval {interval} on {place} → {transition} goes beyond {limit}; choose a coarser unit of time")]
    TooLong { place: NamedId<PlaceId>, transition: NamedId<TransitionId>, interval: Interval, limit: u32 },
    /// Two intervals on one arc.
    #[error("{place} → {transition} has {times} intervals")]
    DuplicateInterval {
        place: NamedId<PlaceId>,
        transition: NamedId<TransitionId>,
        /// Number of intervals on the arc.
        times: usize,
    },
    /// A transition that is both forced and left to the environment.
    #[error("{transition} is external, but event arcs force it; leave one of the two out")]
    ExternalForced { transition: NamedId<TransitionId> },
    /// So many forced transitions compete for tokens that the maximal steps cannot be listed.
    #[error("{trigger} forces {contested} transitions that compete for tokens; at most {limit} are possible")]
    TooManyChoices {
        /// The spontaneous transition.
        trigger: NamedId<TransitionId>,
        /// Number of forced transitions that share an input place with another.
        contested: usize,
        limit: usize,
    },
    /// The event arcs, followed from each spontaneous transition, make more entries than fit.
    #[error("the spontaneous transitions force more than {limit} transitions, added up")]
    TooManyForced { limit: usize },
}

fn names(cycle: &[NamedId<TransitionId>]) -> String {
    cycle.iter().map(ToString::to_string).collect::<Vec<_>>().join(" → ")
}

/// One error of a composition. A port is shown as `part.port`, a part within a part as `outer.inner`.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ComposeError {
    /// Two parts of one composite have the same name.
    #[error("two parts of `{composite}` are named `{name}`")]
    DuplicatePart { composite: String, name: String },
    /// Two ports of one direction and kind have the same name.
    #[error("`{owner}` has two {port}")]
    DuplicatePort {
        /// The module or composite.
        owner: String,
        /// Kind, direction and name, as in "condition inputs named `x`".
        port: String,
    },
    /// A connection to a part that was never added.
    #[error("a connection in `{composite}` names part #{part}, but it has {parts} parts")]
    UnknownPart {
        composite: String,
        /// The number of the part.
        part: usize,
        /// Number of parts.
        parts: usize,
    },
    /// A connection to a port that does not exist.
    #[error("`{owner}` has no {port}")]
    UnknownPort {
        /// The module or composite.
        owner: String,
        /// Kind, direction and name, as in "condition input `x`".
        port: String,
    },
    /// The same connection twice, or a condition input with two sources: it carries one signal.
    #[error("{port} has {times} sources: {sources}")]
    DoubleConnection {
        /// The port that is driven.
        port: String,
        /// Number of connections that end there.
        times: usize,
        /// Where they come from.
        sources: String,
    },
    /// A port that nothing drives.
    #[error("{port} is not connected")]
    NotConnected { port: String },
    /// An input that reaches no transition.
    #[error("{port} is an input, but no arc starts at it")]
    Idle { port: String },
    /// A composite input joined to a composite output: no part is between.
    #[error("`{composite}` joins its input `{from}` to its output `{to}`, through no part")]
    PassThrough {
        composite: String,
        /// The input.
        from: String,
        /// The output.
        to: String,
    },
    /// A module that uses the id of another.
    #[error("module `{module}` has {count} {nodes}, but one of its arcs or ports names #{id}")]
    ForeignId {
        module: String,
        /// "places" or "transitions".
        nodes: &'static str,
        /// Number of nodes.
        count: usize,
        /// The number that is none of them.
        id: u32,
    },
    /// Parts within parts, deeper than any drawing.
    #[error("`{composite}` nests parts more than {limit} deep")]
    TooDeep {
        /// The innermost composite that was looked at.
        composite: String,
        limit: usize,
    },
    /// The flat net is not sound.
    #[error(transparent)]
    Net(#[from] NetError),
    /// The flat system is not sound.
    #[error(transparent)]
    Tnces(#[from] TncesError),
}
