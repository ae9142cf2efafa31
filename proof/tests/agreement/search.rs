//! The plain search: breadth first as far as a limit, or a long random walk.

use std::collections::{HashSet, VecDeque};

use linewright_random::Random;

use super::actions::{Action, apply, possible};
use super::oracle::violation;
use super::world::Setting;

/// Result of a search.
pub struct Found {
    pub states: usize,
    /// The first violation, and the actions that lead there.
    pub counterexample: Option<(String, Vec<Action>)>,
    /// From every state home can be reached; `None` unless the search is exhausted.
    pub home_from_everywhere: Option<bool>,
}

/// Breadth first: the counterexample found is one of the shortest.
pub fn breadth_first(setting: &Setting, states_max: usize) -> Found {
    let mut scratch = Vec::new();
    let start = setting.start();
    let mut number_of = std::collections::HashMap::from([(start.key(setting, &mut scratch), 0u32)]);
    let mut came_by: Vec<(u32, Option<Action>)> = vec![(0, None)];
    let mut edges: Vec<(u32, u32)> = Vec::new();
    let mut homes: Vec<u32> = vec![0];
    let mut queue = VecDeque::from([(0u32, start)]);
    let mut actions = Vec::new();
    let mut exhausted = true;
    while let Some((from, world)) = queue.pop_front() {
        possible(setting, &world, &mut actions);
        for &action in &actions {
            let mut next = world.clone();
            apply(setting, &mut next, action);
            let number = came_by.len() as u32;
            let known = *number_of.entry(next.key(setting, &mut scratch)).or_insert(number);
            edges.push((known, from));
            if known != number {
                continue;
            }
            came_by.push((from, Some(action)));
            if let Some(what) = violation(setting, &next) {
                let counterexample = Some((what, way_to(&came_by, number)));
                return Found { states: came_by.len(), counterexample, home_from_everywhere: None };
            }
            if next.all_at_home() {
                homes.push(number);
            }
            if came_by.len() < states_max {
                queue.push_back((number, next));
            } else {
                exhausted = false;
            }
        }
        if !exhausted {
            break;
        }
    }
    let home_from_everywhere = exhausted.then(|| reaches_all(came_by.len(), edges, homes));
    Found { states: came_by.len(), counterexample: None, home_from_everywhere }
}

/// Whether the arcs, taken backwards, lead from `goals` to every state.
fn reaches_all(states: usize, mut backwards: Vec<(u32, u32)>, goals: Vec<u32>) -> bool {
    backwards.sort_unstable();
    let mut seen: HashSet<u32> = goals.iter().copied().collect();
    let mut open = goals;
    while let Some(state) = open.pop() {
        let begin = backwards.partition_point(|&(to, _)| to < state);
        for &(_, from) in backwards[begin..].iter().take_while(|&&(to, _)| to == state) {
            if seen.insert(from) {
                open.push(from);
            }
        }
    }
    seen.len() == states
}

fn way_to(came_by: &[(u32, Option<Action>)], mut state: u32) -> Vec<Action> {
    let mut way = Vec::new();
    while let (from, Some(action)) = came_by[state as usize] {
        way.push(action);
        state = from;
    }
    way.reverse();
    way
}

/// A long walk, which comes to deep states that breadth first does not; gives what is wrong, and the actions to it.
pub fn random_walk(setting: &Setting, seed: u64, steps: usize) -> Option<(String, Vec<Action>)> {
    let mut world = setting.start();
    let mut random = Random::new(seed);
    let mut way = Vec::new();
    let mut actions = Vec::new();
    for step in 0..steps {
        possible(setting, &world, &mut actions);
        let action = pick(&actions, &mut random)?;
        apply(setting, &mut world, action);
        way.push(action);
        if let Some(what) = violation(setting, &world) {
            return Some((what, way));
        }
        // A long past explains nothing: go on from a fresh line now and then.
        if step % 20_000 == 19_999 {
            world = setting.start();
            way.clear();
        }
    }
    None
}

/// Faults and restarts are rarer than work: a line that only breaks goes nowhere.
fn pick(actions: &[Action], random: &mut Random) -> Option<Action> {
    let weight = |action: &Action| match action {
        Action::Arrive(..) | Action::Deliver { .. } => 24,
        Action::Key(..) | Action::Button(..) => 6,
        Action::Mode(..) | Action::Step(_) => 2,
        Action::Fail(..) | Action::Restart(_) => 1,
    };
    let mut left = random.below(actions.iter().map(weight).sum());
    actions.iter().copied().find(|action| {
        let weight = weight(action);
        let here = left < weight;
        left = left.saturating_sub(weight);
        here
    })
}
