//! Local classes: situations between which a station moves unobserved, as one.
//!
//! An operator presses a key without effect, and lets go of it; a reversible motion runs to and fro while its count is
//! not read. Situations of a station between which such moves of its own lead to and fro form a class: the moves change
//! nothing but the situation, are not observable, and are possible in every state of the rest of the line. So with one
//! member of a class all others can be reached, for each station independently of the others, and what can be reached
//! of the line is whole products of classes. The search keeps one state for each product.
//!
//! Nothing is lost by it. How many states and moves a product stands for is a product itself; all members are checked
//! for violations; a way through products becomes a way through states by walking inside.
//!
//! A class need not be as large as it could be: all that is used is that its members lead to each other. So only so many
//! situations are looked at together, and a station with more of them has several classes where one would do.
//!
//! Taking up a mode other than manual never counts as coming and going, because the way home must do without it.

use std::collections::VecDeque;

use linewright_line::net::ControlMode;
use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::EdgeRef;
use rustc_hash::{FxHashMap, FxHashSet};

use super::setting::{Grants, LineExploration};
use super::station::{Situations, StationAct};
use super::view_key::ViewKeys;

/// Most situations of a station that are compared together to find classes. A station with many operations side by side comes
/// by itself to hundreds of thousands of situations: no limit on states or memory would be heeded before all of them were there.
const TOGETHER_MAX: usize = 4096;

/// Situations of one station between which it comes and goes by itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct LocalClass {
    /// All of them; the first stands for the class.
    pub members: Box<[u32]>,
    /// Moves into other classes of the same station, without effect on others: a member with the number of its act, and
    /// the situation that stands for the other class.
    pub leads: Box<[(MemberAct, u32)]>,
    /// Every other act of every member.
    pub acts: Box<[MemberAct]>,
    /// Members in which the station acts on no mode.
    pub idle: Box<[u32]>,
    /// Number of possible acts, in all members together.
    pub possible: u64,
    /// Members to which nothing can happen by itself.
    pub stuck: u64,
    /// Those of them in which the station acts on no mode.
    pub stuck_idle: u64,
    /// The conflicts of which any member is in the one state.
    pub in_a: u64,
    /// The conflicts of which any member is in the other.
    pub in_b: u64,
    /// Something is wrong with the station by itself in one of them.
    pub wrong: bool,
    /// In one of them the station is at home.
    pub at_home: bool,
}

/// A member, and the number of an act of its.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct MemberAct {
    pub from: u32,
    pub nth: u32,
}

/// The classes of one station while one mode is granted, as far as its situations have been met.
#[derive(Clone, Debug, Default)]
pub(crate) struct Classes {
    /// For each situation the number of its class, [`UNKNOWN`] before it is known.
    of: Vec<u32>,
    all: Vec<LocalClass>,
    /// Bytes in the lists of all classes.
    lists: usize,
}

const UNKNOWN: u32 = u32::MAX;

impl Classes {
    /// The class of a situation that has been met.
    #[inline]
    pub fn at(&self, situation: u32) -> &LocalClass {
        &self.all[self.of[situation as usize] as usize]
    }

    /// The situation that stands for the class of this one, if the class is known.
    #[inline]
    pub fn known(&self, situation: u32) -> Option<u32> {
        let class = *self.of.get(situation as usize)?;
        (class != UNKNOWN).then(|| self.all[class as usize].members[0])
    }

    /// Works out the class of a situation, and of what the station can come to from it by itself.
    pub fn enter(
        &mut self,
        setting: &LineExploration,
        words: &mut [ViewKeys],
        station: &mut Situations,
        granted: usize,
        first: u32,
    ) {
        let mut graph = DiGraph::<u32, MemberAct>::new();
        let mut nodes = FxHashMap::<u32, NodeIndex>::default();
        let mut queue = vec![first];
        nodes.insert(first, graph.add_node(first));
        // Moves into classes that are known already, and moves to situations that are too many to be looked at now.
        let (mut out, mut beyond) = (Vec::<(MemberAct, u32)>::new(), FxHashSet::<MemberAct>::default());
        while let Some(from) = queue.pop() {
            for nth in 0..station.facts[from as usize].acts.len() {
                let act = MemberAct { from, nth: nth as u32 };
                let Some(to) = by_itself(setting, words, station, granted, act) else { continue };
                if let Some(known) = self.known(to) {
                    out.push((act, known));
                    continue;
                }
                if nodes.len() >= TOGETHER_MAX && !nodes.contains_key(&to) {
                    beyond.insert(act);
                    continue;
                }
                let node = *nodes.entry(to).or_insert_with(|| {
                    queue.push(to);
                    graph.add_node(to)
                });
                graph.add_edge(nodes[&from], node, act);
            }
        }
        out.sort_unstable_by_key(|&(act, _)| act.from);
        self.of.resize(station.all.len().max(self.of.len()), UNKNOWN);
        // Those that others lead into come first.
        for component in kosaraju_scc(&graph) {
            let mut members: Vec<u32> = component.iter().map(|&node| graph[node]).collect();
            members.sort_unstable();
            let number = self.all.len() as u32;
            members.iter().for_each(|&member| self.of[member as usize] = number);
            let mut class = LocalClass::of(setting, station, granted, members);
            let edges = component.iter().flat_map(|&node| graph.edges(node));
            let leads = edges.map(|edge| (*edge.weight(), graph[edge.target()]));
            let leads = leads.filter(|&(_, to)| self.of[to as usize] != number);
            let leads = leads.map(|(act, to)| (act, self.all[self.of[to as usize] as usize].members[0]));
            let known = class.members.iter().flat_map(|&member| {
                let begin = out.partition_point(|(act, _)| act.from < member);
                out[begin..].iter().copied().take_while(move |(act, _)| act.from == member)
            });
            let mut leads: Vec<(MemberAct, u32)> = leads.chain(known).collect();
            leads.sort_unstable_by_key(|&(act, to)| (to, act));
            leads.dedup_by_key(|&mut (_, to)| to);
            class.leads = leads.into();
            class.acts = class.other_acts(setting, words, station, granted, &beyond);
            self.lists += class.bytes();
            self.all.push(class);
        }
    }

    /// The acts that lead from one member of a class to another without leaving it, nearest way first.
    pub fn walk(
        &self,
        setting: &LineExploration,
        words: &mut [ViewKeys],
        station: &mut Situations,
        granted: usize,
        (from, to): (u32, u32),
    ) -> Vec<MemberAct> {
        let mut came_by = FxHashMap::<u32, MemberAct>::default();
        let mut queue = VecDeque::from([from]);
        while let Some(here) = queue.pop_front().filter(|_| from != to && !came_by.contains_key(&to)) {
            for nth in 0..station.facts[here as usize].acts.len() {
                let act = MemberAct { from: here, nth: nth as u32 };
                if let Some(next) = by_itself(setting, words, station, granted, act)
                    && self.of.get(next as usize) == self.of.get(from as usize)
                    && next != from
                    && !came_by.contains_key(&next)
                {
                    came_by.insert(next, act);
                    queue.push_back(next);
                }
            }
        }
        let mut way = Vec::new();
        let mut here = to;
        while here != from {
            let act = came_by[&here];
            way.push(act);
            here = act.from;
        }
        way.reverse();
        way
    }

    /// Bytes, about.
    pub fn bytes(&self) -> usize {
        self.of.capacity() * size_of::<u32>() + self.all.capacity() * size_of::<LocalClass>() + self.lists
    }
}

impl LocalClass {
    fn bytes(&self) -> usize {
        let acts = self.acts.len() * size_of::<MemberAct>() + self.leads.len() * size_of::<(MemberAct, u32)>();
        acts + (self.members.len() + self.idle.len()) * size_of::<u32>()
    }

    fn of(setting: &LineExploration, station: &Situations, granted: usize, members: Vec<u32>) -> Self {
        let mut class = LocalClass::default();
        let mut idle = Vec::new();
        for &member in &members {
            let facts = &station.facts[member as usize];
            let possible = facts.acts.iter().filter(|&&act| setting.lets(granted, act)).count() as u64;
            let is_idle = !facts.acts_on_a_mode;
            class.possible += possible;
            class.stuck += u64::from(possible == 0);
            class.stuck_idle += u64::from(possible == 0 && is_idle);
            class.in_a |= facts.in_a;
            class.in_b |= facts.in_b;
            class.wrong |= facts.wrong.is_some();
            class.at_home |= facts.at_home;
            if is_idle {
                idle.push(member);
            }
        }
        class.idle = idle.into();
        class.members = members.into();
        class
    }

    /// Acts of a member that concern other stations, or lead to unexplored situations.
    fn other_acts(
        &self,
        setting: &LineExploration,
        words: &mut [ViewKeys],
        station: &mut Situations,
        granted: usize,
        beyond: &FxHashSet<MemberAct>,
    ) -> Box<[MemberAct]> {
        let mut others = Vec::new();
        for &from in &self.members {
            for nth in 0..station.facts[from as usize].acts.len() {
                let act = MemberAct { from, nth: nth as u32 };
                let lets = setting.lets(granted, station.facts[from as usize].acts[nth]);
                if !lets {
                    continue;
                }
                if beyond.contains(&act) || by_itself(setting, words, station, granted, act).is_none() {
                    others.push(act);
                }
            }
        }
        others.into()
    }
}

/// The situation that an act comes to, if it is possible now and its station's own business alone.
fn by_itself(
    setting: &LineExploration,
    words: &mut [ViewKeys],
    station: &mut Situations,
    granted: usize,
    act: MemberAct,
) -> Option<u32> {
    let what = station.facts[act.from as usize].acts[act.nth as usize];
    // A lost memory does not come back: no class holds both.
    if !setting.lumped || !setting.lets(granted, what) || takes_up_a_mode(setting, what) || what == StationAct::Forget {
        return None;
    }
    let effect = station.effect(setting, words, act.from, act.nth as usize);
    let (before, after) = (act.from as usize, effect.to as usize);
    let hears_the_same = || {
        station.facts[before].holds == station.facts[after].holds && station.all[before].open == station.all[after].open
    };
    (effect.is_local() && hears_the_same()).then_some(effect.to)
}

/// Whether the way home, by manual mode alone, must do without this act.
fn takes_up_a_mode(setting: &LineExploration, act: StationAct) -> bool {
    let StationAct::Mode(mode) = act else { return false };
    setting.grants == Grants::InEpochs && mode != ControlMode::StandBy && mode != ControlMode::Manual
}
