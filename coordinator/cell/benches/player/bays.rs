//! A cell of any size, as text: bays of machines around a store, each with a robot, and parts that go on to the next bay.
//!
//! The first machine of a bay is its way out: it is loaded from the store of its bay and unloaded into that of the next one.
//! So a part has one way, nothing goes round for ever, and all bays are one cell. Stores have room for all parts, so it
//! never gets stuck. The same size gives the same text.

use std::fmt::Write as _;

use crate::dice::Dice;

/// Ten resources a bay: a store, a robot and eight machines, one more or less where it does not come out even.
const BAY: usize = 10;
/// Of every type of parts so many are there.
const OF_EACH: usize = 20;
/// Types of parts that begin in a bay.
const TYPES: usize = 5;

/// Some seconds that are not whole ones, so that few activities of a large cell end at one moment.
fn seconds(dice: &mut Dice, from: usize, bound: usize) -> f64 {
    (from * 1000 + dice.below(bound * 1000)) as f64 / 1000.0
}

/// A description, and of each type of parts how many there are: ten for each resource.
pub struct Bays {
    pub text: String,
    pub parts: Vec<u32>,
}

/// The cell with so many resources, at least ten.
pub fn bays(resources: usize) -> Bays {
    let count = (resources + BAY / 2) / BAY;
    let machines = |bay: usize| (resources - 2 * count) / count + usize::from(bay < (resources - 2 * count) % count);
    let mut dice = Dice(resources as u64);
    let parts = vec![OF_EACH as u32; TYPES * count];
    let all = OF_EACH * parts.len();
    let mut text = format!("name = \"bays\"\ntitle = \"{count} bays\"\n[cell]\nwip_max = {all}\n");
    (0..count).for_each(|bay| resources_of(bay, machines(bay), all, &mut text));
    (0..count).for_each(|bay| moves_of(bay, (bay + 1) % count, machines(bay), &mut dice, &mut text));
    for bay in 0..count {
        let next = (bay + 1) % count;
        (0..TYPES).for_each(|kind| part(kind, [(bay, machines(bay)), (next, machines(next))], &mut dice, &mut text));
    }
    Bays { text, parts }
}

fn add(out: &mut String, line: std::fmt::Arguments<'_>) {
    writeln!(out, "{line}").expect("a string accepts every write");
}

fn resources_of(bay: usize, machines: usize, room: usize, out: &mut String) {
    add(out, format_args!("[[resource]]\nname = \"S{bay}\"\nprototype = \"random-access-store\"\ncapacity = {room}"));
    add(out, format_args!("[[resource]]\nname = \"R{bay}\"\nprototype = \"robot\"\nstation = \"r{bay}\""));
    for m in 0..machines {
        let station = format_args!("station = \"m{bay}_{m}\"");
        add(out, format_args!("[[resource]]\nname = \"M{bay}_{m}\"\nprototype = \"machine\"\ncapacity = 1\n{station}"));
    }
}

fn moves_of(bay: usize, next: usize, machines: usize, dice: &mut Dice, out: &mut String) {
    for m in 0..machines {
        let (name, time) = (format!("M{bay}_{m}"), seconds(dice, 2, 3));
        let to = if m == 0 { next } else { bay };
        let both = |task: &str| {
            format!(
                "time_s = {time}\norders = [{{ station = \"r{bay}\", task = \"{task} {m}\" }}, {{ station = \"m{bay}_{m}\", \
                 task = \"{task}\" }}]"
            )
        };
        let load = format!("\"S{bay}.retrieve\", \"R{bay}.pick-and-place\", \"{name}.load\"");
        let unload = format!("\"{name}.unload\", \"R{bay}.pick-and-place\", \"S{to}.store\"");
        add(out, format_args!("[[sync]]\nname = \"load {name}\"\nactions = [{load}]\n{}", both("load")));
        add(out, format_args!("[[sync]]\nname = \"unload {name}\"\nactions = [{unload}]\n{}", both("unload")));
        let work = format_args!("orders = [{{ station = \"m{bay}_{m}\", task = \"work\" }}]");
        add(out, format_args!("[[action]]\nof = \"{name}.process\"\n{work}"));
    }
    add(out, format_args!("[[sync]]\nname = \"enter {bay}\"\nactions = [\"outside.in\", \"S{bay}.store\"]"));
    add(out, format_args!("[[sync]]\nname = \"leave {bay}\"\nactions = [\"S{bay}.retrieve\", \"outside.out\"]"));
}

/// Two steps in a bay, the way out, two steps in the next; of every step but that, one in three has another machine.
fn part(kind: usize, [here, there]: [(usize, usize); 2], dice: &mut Dice, out: &mut String) {
    add(out, format_args!("[[part]]\nname = \"P{}_{kind}\"", here.0));
    let way_out = (here.0, 1);
    for (step, (bay, machines)) in [here, here, way_out, there, there].into_iter().enumerate() {
        let choices = if step == 2 { 1 } else { machines - 1 };
        let first = dice.below(choices);
        let other = (first + 1) % choices;
        let offset = usize::from(step != 2);
        let mut on = format!("{{ resource = \"M{bay}_{}\", time_s = {} }}", first + offset, seconds(dice, 20, 60));
        if other != first && dice.below(3) == 0 {
            let time = seconds(dice, 20, 60);
            write!(on, ", {{ resource = \"M{bay}_{}\", time_s = {time} }}", other + offset)
                .expect("a string accepts it");
        }
        add(out, format_args!("[[part.step]]\nname = \"s{step}\"\non = [{on}]"));
    }
}
