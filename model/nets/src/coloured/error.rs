//! Errors of a coloured net under construction: one variant per rule, with what was expected and found.

use std::sync::Arc;

use thiserror::Error;

use super::guard::MAX_CLAUSES;
use super::linear::FunctionError;
use crate::{ArcName, MAX_NODES, NamedId, NetNode, PlaceId, TransitionId};

/// One error of a coloured net.
#[derive(Clone, Debug, PartialEq, Eq, Error)]

pub enum ColouredError {
    /// A net has at least one place or transition.
    #[error("the net has neither a place nor a transition")]
    Empty,
    /// More places, transitions, basic domains or arcs than can be numbered in reason.
    #[error("the net has {count} {what}; at most {MAX_NODES} are possible")]
    TooMany { what: &'static str, count: usize },
    /// Two of a kind have the same name.
    #[error("two {what} are named `{name}`")]
    DuplicateName { what: &'static str, name: Arc<str> },
    /// The unfolded net calls the colours of place `p` `p<1>`, `p<2>` and so on.
    #[error("{node} has a name that ends in `>`, which is how unfolded colours are named; choose another")]
    NameLikeColour { node: NamedId<NetNode> },
    /// A domain without a colour.
    #[error("colour domain `{name}` has no tone; a domain is not empty")]
    EmptyBasic { name: Arc<str> },
    /// Two tones of one domain have the same name.
    #[error("colour domain `{name}` has two tones named `{tone}`")]
    DuplicateTone { name: Arc<str>, tone: Arc<str> },
    /// A name that could not be distinguished from what is around it in `p<a,b>`.
    #[error("colour domain `{name}` has a tone named `{tone}`; the name of a tone is not empty and has none of `<>,`")]
    ToneName { name: Arc<str>, tone: Arc<str> },
    /// A domain that names a basic domain which was not declared.
    #[error("{node} is of colour domain #{basic}, but the net has {basics} basic domains")]
    UnknownBasic { node: NamedId<NetNode>, basic: u32, basics: usize },
    #[error("{node} has a domain with {components} components; at most {most} are possible")]
    TooManyComponents { node: NamedId<NetNode>, components: usize, most: usize },
    /// A place with more colours than can be numbered.
    #[error("{place} has more colours than can be numbered")]
    TooManyColours { place: NamedId<PlaceId> },
    /// The places together have more colours than can be numbered.
    #[error("the places of the net together have more colours than can be numbered, from {place} on")]
    TooManyCells { place: NamedId<PlaceId> },
    /// A transition with more modes than can be enumerated in reason.
    #[error("{transition} has more than {MAX_NODES} modes; let it use fewer components")]
    TooManyModes { transition: NamedId<TransitionId> },
    /// An arc or a token at a place that was not declared.
    #[error("{what} names place #{place}, but the net has {places} places")]
    UnknownPlace { what: String, place: u32, places: usize },
    /// An arc or a guard at a transition that was not declared.
    #[error("{what} names transition #{transition}, but the net has {transitions} transitions")]
    UnknownTransition { what: String, transition: u32, transitions: usize },
    /// The same two nodes are joined more than once in the same direction; a sum is for that.
    #[error("the arc {arc} is declared {times} times; write one arc with the sum of the functions")]
    DuplicateArc { arc: ArcName, times: usize },
    /// A function that has no meaning for the transition's domain.
    #[error("the arc {arc} has the function `{function}`: {error}")]
    Function { arc: ArcName, function: String, error: FunctionError },
    /// A function that leads to another domain than the place's.
    #[error("the arc {arc} has the function `{function}`, which gives colours of {found}; the place is of {expected}")]
    ArcDomain { arc: ArcName, function: String, found: String, expected: String },
    /// A weight that is zero, negative or beyond counting.
    #[error(
        "the arc {arc} has the function `{function}` with a total weight of {weight} in one term; 1 to 4294967295 are possible"
    )]
    Weight { arc: ArcName, function: String, weight: i64 },
    /// Several terms that are too much together.
    #[error("the arc {arc} has the function `{function}`, which moves more tokens than can be counted")]
    Weights { arc: ArcName, function: String },
    /// A transition has two guards.
    #[error("{transition} has two guards; write one, with the clauses of both")]
    DuplicateGuard { transition: NamedId<TransitionId> },
    /// A guard that never holds.
    #[error("the guard of {transition} has no clause, so the transition could never fire")]
    EmptyGuard { transition: NamedId<TransitionId> },
    /// A guard beyond reason.
    #[error("the guard of {transition} has more than {MAX_CLAUSES} clauses, or one of its clauses as many comparisons")]
    TooManyClauses { transition: NamedId<TransitionId> },
    /// A guard that names a component which the transition's domain does not have.
    #[error("the guard of {transition} names component {component}; the transition is of {domain}")]
    GuardComponent { transition: NamedId<TransitionId>, component: u32, domain: String },
    /// A guard that names a colour which its component cannot have.
    #[error("the guard of {transition} names colour {number} of component {component}, which has 1 to {size}")]
    GuardTone { transition: NamedId<TransitionId>, component: u32, number: i64, size: u32 },
    /// An initial token that is no colour of its place.
    #[error("a token {token} is put on {place}, which is of {domain}")]
    TokenArity { token: String, place: NamedId<PlaceId>, domain: String },
    /// An initial token with a tone that its component cannot have.
    #[error("a token {token} is put on {place}: component {component} has the tones 1 to {size}")]
    TokenTone { token: String, place: NamedId<PlaceId>, component: usize, size: u32 },
    /// More initial tokens of one colour than can be counted.
    #[error("{place} starts with more tokens of one colour than can be counted")]
    TooManyTokens { place: NamedId<PlaceId> },
    /// More initial tokens than the place holds by its declaration.
    #[error("{place} starts with {tokens} tokens, but is declared to hold at most {most}")]
    OverCapacity { place: NamedId<PlaceId>, tokens: u64, most: u32 },
    /// Nets that are put together describe the same basic domain differently.
    #[error("colour domain `{name}` has other tones in net `{net}` than in `{other}`")]
    BasicsDiffer { name: Arc<str>, net: String, other: String },
    /// A fusion names a net or a transition that is not there.
    #[error("the fusion `{fusion}` names transition `{transition}` of net #{net}, which does not exist")]
    UnknownPart { fusion: Arc<str>, net: usize, transition: String },
    /// A transition takes part in two fusions, or twice in one.
    #[error("transition `{transition}` of net #{net} takes part in a fusion twice")]
    FusedTwice { net: usize, transition: Arc<str> },
}
