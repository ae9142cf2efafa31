//! Workcells by chance: one robot or two, some machines, a store of limited room, parts that follow plans.
//!
//! Written as an ordinary net: a place for each part type, step and resource, as the unfolding of a coloured cell has it.
//! Parts enter from a limited supply and leave when their plan is over. No more are inside than the store has room for, so
//! that nothing gets stuck.

use std::collections::{BTreeMap, BTreeSet};

use linewright_coordinator_cell::{OrderKey, PartId};
use linewright_nets::NetBuilder;
use linewright_nets::coloured::ColouredBuilder;

use super::plans::{Compiled, PARTS, TOKENS, alone, ordered};
use super::world::World;
use linewright_random::Random as Dice;

pub struct Workcell {
    machines: usize,
    robots: usize,
    room: u32,
    /// For each part type how many there are, and for each of its steps the machines that can do it.
    plans: Vec<(u32, Vec<Vec<usize>>)>,
}

impl Workcell {
    pub fn random(dice: &mut Dice) -> Self {
        let machines = 2 + dice.below(3);
        let step = |dice: &mut Dice| {
            let mut on: Vec<usize> = (0..1 + dice.below(2)).map(|_| dice.below(machines)).collect();
            on.sort_unstable();
            on.dedup();
            on
        };
        let plan = |dice: &mut Dice| {
            let parts = 1 + dice.below(3) as u32;
            (parts, (0..1 + dice.below(2)).map(|_| step(dice)).collect())
        };
        let plans = (0..1 + dice.below(2)).map(|_| plan(dice)).collect();
        Workcell { machines, robots: 1 + dice.below(2), room: 2 + dice.below(3) as u32, plans }
    }

    /// Robots first, then machines.
    pub fn stations(&self) -> usize {
        self.robots + self.machines
    }

    /// Number of parts in all.
    pub fn parts(&self) -> u32 {
        self.plans.iter().map(|(count, _)| count).sum()
    }

    /// Number of steps of all of them together.
    pub fn steps(&self) -> usize {
        self.plans.iter().map(|(count, steps)| *count as usize * steps.len()).sum()
    }

    fn net(&self) -> ColouredBuilder {
        let mut b = NetBuilder::new("workcell");
        let room = b.place("room", self.room);
        let inside = b.place("permits", self.room);
        let free: Vec<_> = (0..self.machines).map(|m| b.place(format!("free M{m}"), 1)).collect();
        let robots: Vec<_> = (0..self.robots).map(|r| b.place(format!("free R{r}"), 1)).collect();
        for (kind, (count, steps)) in self.plans.iter().enumerate() {
            let supply = b.place(format!("supply {kind}"), *count);
            let stored: Vec<_> = (0..=steps.len()).map(|step| b.place(format!("stored {kind}.{step}"), 0)).collect();
            let (enter, leave) = (b.transition(format!("enter {kind}")), b.transition(format!("leave {kind}")));
            b.input(enter, supply, 1).input(enter, room, 1).input(enter, inside, 1).output(enter, stored[0], 1);
            b.input(leave, stored[steps.len()], 1).output(leave, room, 1).output(leave, inside, 1);
            for (step, on) in steps.iter().enumerate() {
                for &m in on {
                    let loaded = b.place(format!("loaded {kind}.{step} M{m}"), 0);
                    let ready = b.place(format!("ready {kind}.{step} M{m}"), 0);
                    let process = b.transition(format!("process {kind}.{step} M{m}"));
                    b.input(process, loaded, 1).output(process, ready, 1);
                    for (r, &robot) in robots.iter().enumerate() {
                        let [load, unload] =
                            ["load", "unload"].map(|name| b.transition(format!("{name} {kind}.{step} M{m} R{r}")));
                        b.input(load, stored[step], 1).input(load, robot, 1).input(load, free[m], 1);
                        b.output(load, robot, 1).output(load, room, 1).output(load, loaded, 1);
                        b.input(unload, ready, 1).input(unload, robot, 1).input(unload, room, 1);
                        b.output(unload, robot, 1).output(unload, free[m], 1).output(unload, stored[step + 1], 1);
                    }
                }
            }
        }
        ColouredBuilder::from_net(&b.build().unwrap())
    }
}

pub fn compiled(cell: &Workcell) -> Compiled {
    let robots = cell.robots as u16;
    let digit = |name: &str, letter: char| {
        name.split(' ').find_map(|word| word.strip_prefix(letter)).map(|number| number.parse::<u16>().unwrap())
    };
    Compiled::new(
        cell.net().build().unwrap(),
        |name| {
            let is_part = ["stored", "loaded", "ready"].iter().any(|place| name.starts_with(place));
            if is_part { PARTS } else { TOKENS }
        },
        |name| match name.split(' ').next().unwrap() {
            "enter" | "leave" => alone(30),
            "process" => ordered("process", &[robots + digit(name, 'M').unwrap()], 60_000),
            carried => ordered(carried, &[digit(name, 'R').unwrap(), robots + digit(name, 'M').unwrap()], 60_000),
        },
    )
}

/// Result, whichever machine did it: the marking at the end, how many parts have left, and the work on each part, in the
/// order of the keys. A part keeps its number from entering to leaving.
pub fn production(world: &World) -> (Vec<u64>, u64, Vec<Vec<String>>) {
    let mut acts: BTreeMap<PartId, BTreeMap<OrderKey, String>> = BTreeMap::new();
    let mut keys = BTreeSet::new();
    for station in &world.stations {
        for done in &station.done {
            assert!(keys.insert(done.key), "{} was done twice", done.key);
            acts.entry(done.part.unwrap()).or_default().insert(done.key, done.task.to_string());
        }
    }
    assert_eq!(world.state().firings().len(), 0);
    let mut histories: Vec<Vec<String>> = acts.into_values().map(|of| of.into_values().collect()).collect();
    histories.sort();
    (world.state().marking().counts().to_vec(), world.state().left(), histories)
}
