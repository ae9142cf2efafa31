//! Random cells, as text: read like any other description.
//!
//! Every machine is loaded from some store and unloaded to some store, and all stores are joined in a ring, so that
//! every plan can be done; the rest is by chance. Some of these cells get stuck.

use std::fmt::Write;
use std::ops::RangeInclusive;

use super::Random;

/// The kind of cells to generate. Chances are in percent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellShape {
    /// Number of machines and humans, at least one.
    pub machines: RangeInclusive<usize>,
    /// Number of robots and conveyors.
    pub carriers: RangeInclusive<usize>,
    /// Number of stores and buffers, at least one.
    pub stores: RangeInclusive<usize>,
    /// Capacity of each of them, in parts.
    pub room: RangeInclusive<usize>,
    /// Number of part types.
    pub types: RangeInclusive<usize>,
    /// Number of steps of a plan, alternatives not counted.
    pub steps: RangeInclusive<usize>,
    /// Number of parts let in at a time.
    pub wip: RangeInclusive<usize>,
    /// That nothing is reserved.
    pub unreserved: u32,
    /// That there are two of everything, with nothing in common.
    pub apart: u32,
    /// That a plan has what not every plan has: parts that stay for the next step, ways that end early.
    pub plans: u32,
    /// That what could be otherwise is: other prototypes than the usual ones, more ways than are needed.
    pub odd: u32,
}

impl Default for CellShape {
    /// Two to six machines with something of everything.
    fn default() -> Self {
        CellShape {
            machines: 2..=6,
            carriers: 1..=2,
            stores: 1..=3,
            room: 1..=3,
            types: 1..=4,
            steps: 1..=4,
            wip: 1..=5,
            unreserved: 25,
            apart: 0,
            plans: 0,
            odd: 25,
        }
    }
}

impl CellShape {
    /// Few enough states to look at each one by one, in a slow and obvious way.
    pub fn small() -> Self {
        CellShape { machines: 2..=4, types: 1..=3, steps: 1..=3, wip: 1..=4, plans: 30, ..CellShape::default() }
    }

    /// So many machines around large stores, and plans as long as that.
    pub fn large(machines: usize) -> Self {
        CellShape {
            machines: machines..=machines,
            carriers: machines.div_ceil(8)..=machines.div_ceil(8),
            stores: machines.div_ceil(10)..=machines.div_ceil(10),
            room: 10..=20,
            types: machines..=machines,
            steps: 3..=6,
            wip: machines..=machines,
            unreserved: 0,
            apart: 0,
            plans: 0,
            odd: 0,
        }
    }
}

/// A kind of resource that is left to chance.
struct RandomResource {
    name: String,
    prototype: &'static str,
    capacity: Option<usize>,
}

/// The description of a cell of this shape; the same for the same seed.
///
/// # Panics
/// When the shape has no machine or no store.
pub fn cell(shape: &CellShape, seed: u64) -> String {
    let mut random = Random::new(seed ^ 0x6365_6C6C);
    let mut text = String::new();
    // Writing to a string cannot fail.
    write_cell(shape, seed, &mut random, &mut text).expect("a string accepts every write");
    text
}

fn write_cell(shape: &CellShape, seed: u64, random: &mut Random, out: &mut String) -> std::fmt::Result {
    let reserve = !random.chance(shape.unreserved);
    let wip = random.within(&shape.wip).max(1);
    writeln!(out, "name = \"generated\"\ntitle = \"Generated cell {seed}\"\n")?;
    writeln!(out, "[cell]\nwip_max = {wip}\nreserve = {reserve}\n")?;
    let (mut resources, mut types) = (0, 0);
    for _ in 0..=usize::from(random.chance(shape.apart)) {
        half(shape, random, (&mut resources, &mut types), out)?;
    }
    Ok(())
}

/// Resources with what they do together, and the parts that they work on; counted through.
fn half(
    shape: &CellShape,
    random: &mut Random,
    (resources, types): (&mut usize, &mut usize),
    out: &mut String,
) -> std::fmt::Result {
    let mut some = |count: usize, one: fn(usize, &CellShape, &mut Random) -> RandomResource, random: &mut Random| {
        let first = *resources + 1;
        *resources += count;
        (first..=*resources).map(|number| one(number, shape, random)).collect::<Vec<RandomResource>>()
    };
    let machines = some(random.within(&shape.machines).max(1), machine, random);
    let stores = some(random.within(&shape.stores).max(1), store, random);
    let carriers = some(random.within(&shape.carriers), carrier, random);
    for RandomResource { name, prototype, capacity } in machines.iter().chain(&stores).chain(&carriers) {
        writeln!(out, "[[resource]]\nname = \"{name}\"\nprototype = \"{prototype}\"")?;
        if let Some(capacity) = capacity {
            writeln!(out, "capacity = {capacity}")?;
        }
        writeln!(out, "station = \"{}\"\n", name.to_lowercase())?;
    }
    let mut syncs = Syncs { machines: &machines, carriers: &carriers, out };
    syncs.all(&stores, shape, random)?;
    for _ in 0..random.within(&shape.types).max(1) {
        part(*types, &machines, shape, random, out)?;
        *types += 1;
    }
    Ok(())
}

fn machine(number: usize, shape: &CellShape, random: &mut Random) -> RandomResource {
    let is_human = random.chance(shape.odd / 2);
    let capacity = random.chance(shape.odd / 2).then_some(2);
    let (letter, prototype) = if is_human { ("H", "human") } else { ("M", "machine") };
    RandomResource { name: format!("{letter}{number}"), prototype, capacity }
}

fn store(number: usize, shape: &CellShape, random: &mut Random) -> RandomResource {
    let prototype =
        if random.chance(shape.odd) { *random.pick(&["fifo-buffer", "lifo-buffer"]) } else { "random-access-store" };
    RandomResource { name: format!("S{number}"), prototype, capacity: Some(random.within(&shape.room).max(1)) }
}

fn carrier(number: usize, shape: &CellShape, random: &mut Random) -> RandomResource {
    if random.chance(shape.odd / 2) {
        RandomResource { name: format!("R{number}"), prototype: "conveyor", capacity: Some(2) }
    } else {
        RandomResource { name: format!("R{number}"), prototype: "robot", capacity: None }
    }
}

/// Writes what resources do together.
struct Syncs<'a> {
    machines: &'a [RandomResource],
    carriers: &'a [RandomResource],
    out: &'a mut String,
}

impl Syncs<'_> {
    fn all(&mut self, stores: &[RandomResource], shape: &CellShape, random: &mut Random) -> std::fmt::Result {
        for RandomResource { name, .. } in self.machines {
            let from = random.pick(stores);
            self.one(&format!("load {name}"), &format!("{}.retrieve", from.name), &format!("{name}.load"), random)?;
            let to = random.pick(stores);
            self.one(&format!("unload {name}"), &format!("{name}.unload"), &format!("{}.store", to.name), random)?;
            if random.chance(shape.odd) {
                let from = random.pick(stores);
                let also = format!("load {name} from {}", from.name);
                self.one(&also, &format!("{}.retrieve", from.name), &format!("{name}.load"), random)?;
            }
            let other = random.pick(self.machines);
            if other.name != *name && random.chance(shape.odd) {
                let direct = format!("{name} to {}", other.name);
                self.one(&direct, &format!("{name}.unload"), &format!("{}.load", other.name), random)?;
            }
        }
        for (at, from) in stores.iter().enumerate().filter(|_| stores.len() > 1) {
            let to = &stores[(at + 1) % stores.len()];
            let name = format!("{} to {}", from.name, to.name);
            self.one(&name, &format!("{}.retrieve", from.name), &format!("{}.store", to.name), random)?;
        }
        let (first, last) = (random.pick(stores), random.pick(stores));
        self.one(&format!("enter {}", first.name), "outside.in", &format!("{}.store", first.name), random)?;
        self.one(&format!("leave {}", last.name), &format!("{}.retrieve", last.name), "outside.out", random)?;
        let odd = random.pick(self.machines);
        if random.chance(shape.odd) {
            self.one(&format!("enter {}", odd.name), "outside.in", &format!("{}.load", odd.name), random)?;
        }
        if random.chance(shape.odd) {
            self.one(&format!("leave {}", odd.name), &format!("{}.unload", odd.name), "outside.out", random)?;
        }
        Ok(())
    }

    fn one(&mut self, name: &str, source: &str, target: &str, random: &mut Random) -> std::fmt::Result {
        let holder = |action: &str| action.split('.').next().unwrap_or_default().to_owned();
        let ends = [holder(source), holder(target)];
        let humans =
            self.machines.iter().filter(|machine| machine.prototype == "human" && !ends.contains(&machine.name));
        let mut can_carry: Vec<&RandomResource> = self.carriers.iter().collect();
        // A worker may help out; a robot is there for it.
        can_carry.extend(humans.filter(|_| random.chance(30)));
        write!(self.out, "[[sync]]\nname = \"{name}\"\nactions = [\"{source}\"")?;
        if !can_carry.is_empty() && random.chance(80) {
            write!(self.out, ", \"{}.pick-and-place\"", random.pick(&can_carry).name)?;
        }
        writeln!(self.out, ", \"{target}\"]")?;
        if random.chance(70) {
            writeln!(self.out, "time_s = {}", 1 + random.below(20))?;
            let stations = ends.iter().filter(|name| *name != "outside" && random.chance(50));
            let orders: Vec<String> = stations
                .map(|name| format!("{{ station = \"{}\", task = \"{}\" }}", name.to_lowercase(), "take part"))
                .collect();
            if !orders.is_empty() {
                writeln!(self.out, "orders = [{}]", orders.join(", "))?;
            }
        }
        writeln!(self.out)
    }
}

/// A type of parts and its plan: steps one after the other, some with an alternative on other machines, some of which are
/// the last. A part stays for a step beside others on which it can be done, or where nothing but that machine led to it.
fn part(
    number: usize,
    machines: &[RandomResource],
    shape: &CellShape,
    random: &mut Random,
    out: &mut String,
) -> std::fmt::Result {
    writeln!(out, "[[part]]\nname = \"P{number}\"")?;
    // Shapes without such plans are drawn as if there were none.
    let special = |random: &mut Random| shape.plans > 0 && random.chance(shape.plans);
    let mut before: Vec<&RandomResource> = Vec::new();
    for step in 1..=random.within(&shape.steps).max(1) {
        let mut left: Vec<&RandomResource> = machines.iter().collect();
        let mut on = Vec::new();
        if !before.is_empty() && special(random) {
            let stays = *random.pick(&before);
            left.retain(|machine| machine.name != stays.name);
            let word = *random.pick(&["may", "must"]);
            let time = 1 + random.below(60);
            on.push(format!("{{ resource = \"{}\", time_s = {time}, stays = \"{word}\" }}", stays.name));
        }
        if on.is_empty() || before.len() > 1 || random.chance(50) {
            on.extend(some_of(&mut left, random));
        }
        writeln!(out, "[[part.step]]\nname = \"s{step}\"\non = [{}]", on.join(", "))?;
        if !left.is_empty() && random.chance(shape.odd / 2) {
            let on = some_of(&mut left, random).join(", ");
            writeln!(out, "[[part.step]]\nname = \"s{step} else\"\nor = \"s{step}\"\non = [{on}]")?;
        }
        before = machines.iter().filter(|machine| left.iter().all(|other| other.name != machine.name)).collect();
        if !left.is_empty() && special(random) {
            let on = some_of(&mut left, random).join(", ");
            writeln!(out, "[[part.step]]\nname = \"s{step} last\"\nor = \"s{step}\"\nthen = \"done\"\non = [{on}]")?;
        }
    }
    writeln!(out)
}

/// One or two machines, which are left no more.
fn some_of(left: &mut Vec<&RandomResource>, random: &mut Random) -> Vec<String> {
    let count = (1 + random.below(2)).min(left.len());
    (0..count)
        .map(|_| {
            let machine = left.swap_remove(random.below(left.len()));
            format!("{{ resource = \"{}\", time_s = {} }}", machine.name, 1 + random.below(60))
        })
        .collect()
}
