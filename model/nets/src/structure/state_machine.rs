//! The verdict on state machines: live, safe, reversible, decided without playing.
//!
//! Every controller of a station is a strongly connected state machine with one token (seed 002 §5.5.1), so for the
//! controllers themselves this module replaces a search. Conditions are left out: a condition that never holds can
//! still stop a live net.
//!
//! Seed 002 quotes two theorems. Theorem 1: a state machine is live iff it is strongly connected and has a token, and
//! safe iff it has at most one token. Theorem 2: a live state machine is reversible. Read literally, Theorem 1 claims
//! too much: two separate rings with a token each are live and safe though not strongly connected, and a fork in the
//! road with a token at the end of either branch is safe though it has two. The verdict here is exact for *every* state
//! machine, and agrees with both theorems on every strongly connected one that has a transition.

use std::fmt;

use thiserror::Error;

use super::NotStateMachine;
use crate::components::Components;
use crate::{NamedId, Net, PlaceId, TransitionId};

/// Properties of a state machine, with the reason for each that does not hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateMachineVerdict {
    /// From every reachable marking every transition can be enabled again (seed 002 §3.1, Definition 1).
    pub live: Result<(), NotLive>,
    /// No place ever holds more than one token (Definition 1).
    pub safe: Result<(), NotSafe>,
    /// From every reachable marking the initial one can be reached (Definition 1).
    pub reversible: Result<(), NotReversible>,
}

impl StateMachineVerdict {
    /// Whether the net is live, safe and reversible.
    pub fn holds(&self) -> bool {
        self.live.is_ok() && self.safe.is_ok() && self.reversible.is_ok()
    }
}

impl fmt::Display for StateMachineVerdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.live {
            Ok(()) => writeln!(f, "live: every part is strongly connected and has a token")?,
            Err(why) => writeln!(f, "not live: {why}")?,
        }
        match &self.safe {
            Ok(()) => writeln!(f, "safe: no two tokens can meet")?,
            Err(why) => writeln!(f, "not safe: {why}")?,
        }
        match &self.reversible {
            Ok(()) => write!(f, "reversible: every token can return to where it started"),
            Err(why) => write!(f, "not reversible: {why}"),
        }
    }
}

/// Reason why a state machine is not live.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum NotLive {
    /// The transition cannot be undone by others: once every token is behind it, it stays dead.
    #[error("{transition} leads from {from} to {to}, and no path leads back")]
    NoReturn {
        transition: NamedId<TransitionId>,
        /// Its input place.
        from: NamedId<PlaceId>,
        /// Its output place.
        to: NamedId<PlaceId>,
    },
    /// No token is in the part of the net that the transition belongs to.
    #[error("no token can ever reach {transition}")]
    NoToken { transition: NamedId<TransitionId> },
}

/// Reason why a state machine is not safe: two tokens can meet.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{place} can hold two tokens, one that starts on {first} and one that starts on {second}")]
pub struct NotSafe {
    /// Where they meet.
    pub place: NamedId<PlaceId>,
    /// Where one of them is initially.
    pub first: NamedId<PlaceId>,
    /// Where the other is.
    pub second: NamedId<PlaceId>,
}

/// Reason why a state machine is not reversible.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the token on {place} can leave by {transition} for {to}, and no path leads back")]
pub struct NotReversible {
    /// An initially marked place.
    pub place: NamedId<PlaceId>,
    /// The point of no return that its token can reach.
    pub transition: NamedId<TransitionId>,
    /// Where that leads.
    pub to: NamedId<PlaceId>,
}

/// Decides whether a state machine is live, safe and reversible, in time linear in its size.
///
/// The idea of the proof: every transition has one input and one output place, so a token moves on its own, like a
/// walker in the directed graph whose nodes are the places and whose edges are the transitions. Walkers neither help
/// nor hinder each other. A walker can always go on into a *terminal* component of that graph (one that no edge
/// leaves), and never comes out again.
///
/// - **Live** iff no edge leaves its component, and each component with an edge has a walker. *Only if*: let all
///   walkers go into terminal components; an edge that starts elsewhere is dead for ever. *If*: walkers cannot leave
///   their components, and within one each edge can be reached. For a net in one piece this means: strongly connected,
///   with at least one token (Theorem 1).
/// - **Safe** iff no two walkers can reach the same node: if they can, let these two go there and the others wait. In a
///   strongly connected net any two can: at most one token (Theorem 1).
/// - **Reversible** iff every walker starts in a terminal component. *If*: it never left it and can go back alone.
///   *Only if*: send the walker into a terminal component, and all others too; no walker can go where it started. A
///   live net has terminal components only, hence is reversible (Theorem 2).
pub fn state_machine_verdict(net: &Net) -> Result<StateMachineVerdict, NotStateMachine> {
    net.is_state_machine()?;
    let edges = Edges { net };
    let parts = Components::new(net.place_count(), edges.all().map(|(_, from, to)| (from.index(), to.index())));
    Ok(StateMachineVerdict { live: live(edges, &parts), safe: safe(edges), reversible: reversible(edges, &parts) })
}

/// The graph of a state machine: places as nodes, transitions as edges.
#[derive(Clone, Copy)]
struct Edges<'net> {
    net: &'net Net,
}

impl<'net> Edges<'net> {
    fn all(self) -> impl Iterator<Item = (TransitionId, PlaceId, PlaceId)> + Clone + use<'net> {
        self.net.transitions().map(move |t| (t, self.net.preset(t)[0].0, self.net.postset(t)[0].0))
    }

    fn successors(self, place: PlaceId) -> impl Iterator<Item = PlaceId> + use<'net> {
        self.net.consumers(place).iter().map(move |&(t, _)| self.net.postset(t)[0].0)
    }
}

fn live(edges: Edges<'_>, parts: &Components) -> Result<(), NotLive> {
    let net = edges.net;
    if let Some((t, from, to)) = edges.all().find(|(_, from, to)| parts.of(from.index()) != parts.of(to.index())) {
        return Err(NotLive::NoReturn { transition: net.transition(t), from: net.place(from), to: net.place(to) });
    }
    let mut marked = vec![false; parts.count()];
    net.initial_marking().marked().for_each(|place| marked[parts.of(place.index())] = true);
    match edges.all().find(|(_, from, _)| !marked[parts.of(from.index())]) {
        Some((t, ..)) => Err(NotLive::NoToken { transition: net.transition(t) }),
        None => Ok(()),
    }
}

/// Sends every token wherever it can go, and stops where one comes to a place that another has been to.
fn safe(edges: Edges<'_>) -> Result<(), NotSafe> {
    let net = edges.net;
    let meet = |place, first, second| {
        Err(NotSafe { place: net.place(place), first: net.place(first), second: net.place(second) })
    };
    let initial = net.initial_marking();
    let mut visitor: Vec<Option<PlaceId>> = vec![None; net.place_count()];
    let mut ahead = Vec::new();
    for start in initial.marked() {
        if initial.tokens(start) > 1 {
            return meet(start, start, start);
        }
        ahead.push(start);
        while let Some(place) = ahead.pop() {
            match visitor[place.index()] {
                Some(other) if other != start => return meet(place, other, start),
                Some(_) => {}
                None => {
                    visitor[place.index()] = Some(start);
                    ahead.extend(edges.successors(place));
                }
            }
        }
    }
    Ok(())
}

fn reversible(edges: Edges<'_>, parts: &Components) -> Result<(), NotReversible> {
    let net = edges.net;
    let initial = net.initial_marking();
    let Some(place) = initial.marked().find(|place| !parts.is_terminal(parts.of(place.index()))) else {
        return Ok(());
    };
    let home = parts.of(place.index());
    let (t, _, to) = edges
        .all()
        .find(|(_, from, to)| parts.of(from.index()) == home && parts.of(to.index()) != home)
        .expect("an edge leaves a component that is not terminal");
    Err(NotReversible { place: net.place(place), transition: net.transition(t), to: net.place(to) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NetBuilder;

    fn net(tokens: &[u32], edges: &[(usize, usize)]) -> Net {
        let mut b = NetBuilder::new("n");
        let places: Vec<_> = tokens.iter().enumerate().map(|(i, &n)| b.place(format!("p{i}"), n)).collect();
        for &(from, to) in edges {
            let t = b.transition(format!("t{from}{to}"));
            b.input(t, places[from], 1).output(t, places[to], 1);
        }
        b.build().unwrap()
    }

    fn verdict(tokens: &[u32], edges: &[(usize, usize)]) -> String {
        state_machine_verdict(&net(tokens, edges)).unwrap().to_string()
    }

    #[test]
    fn a_ring_with_one_token_has_all_three_properties() {
        assert!(state_machine_verdict(&net(&[0, 1, 0], &[(0, 1), (1, 2), (2, 0)])).unwrap().holds());
    }

    #[test]
    fn a_ring_without_a_token_is_dead_and_with_two_unsafe() {
        let ring = [(0, 1), (1, 0)];
        assert_eq!(
            verdict(&[0, 0], &ring),
            "not live: no token can ever reach transition `t01`\n\
             safe: no two tokens can meet\n\
             reversible: every token can return to where it started"
        );
        assert_eq!(
            verdict(&[1, 1], &ring),
            "live: every part is strongly connected and has a token\n\
             not safe: place `p1` can hold two tokens, one that starts on place `p0` and one that starts on place `p1`\n\
             reversible: every token can return to where it started"
        );
    }

    #[test]
    fn a_way_out_without_return_is_neither_live_nor_reversible() {
        assert_eq!(
            verdict(&[1, 0, 0], &[(0, 1), (1, 0), (1, 2)]),
            "not live: transition `t12` leads from place `p1` to place `p2`, and no path leads back\n\
             safe: no two tokens can meet\n\
             not reversible: the token on place `p0` can leave by transition `t12` for place `p2`, \
             and no path leads back"
        );
    }

    #[test]
    fn what_theorem_1_does_not_cover_is_still_decided() {
        // Two rings side by side, a token each: Theorem 1 read literally would call this neither live nor safe.
        let two_rings = net(&[1, 0, 1, 0], &[(0, 1), (1, 0), (2, 3), (3, 2)]);
        assert!(two_rings.is_strongly_connected().is_err());
        assert!(state_machine_verdict(&two_rings).unwrap().holds());
        // A fork with a token at either end: nothing can move, so nothing can meet.
        let fork = state_machine_verdict(&net(&[1, 0, 1], &[(1, 0), (1, 2)])).unwrap();
        assert!(fork.live.is_err() && fork.safe.is_ok() && fork.reversible.is_ok());
        // The token starts behind the point of no return: dead transitions, yet it always comes home.
        let behind = state_machine_verdict(&net(&[0, 1, 0], &[(0, 1), (1, 2), (2, 1)])).unwrap();
        assert!(behind.live.is_err() && behind.safe.is_ok() && behind.reversible.is_ok());
    }

    #[test]
    fn only_state_machines_get_a_verdict() {
        let mut b = NetBuilder::new("fork");
        let (a, fork) = (b.place("a", 1), b.transition("fork"));
        b.input(fork, a, 1);
        let error = state_machine_verdict(&b.build().unwrap()).unwrap_err();
        assert_eq!(error.to_string(), "transition `fork` has 0 output places, not 1");
    }
}
