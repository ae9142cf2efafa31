//! The two cells as ordinary nets written down by hand, place by place: the form in which they were first explored.
//!
//! It has nothing in common with the description, its parser or the fusion of instances; it confirms the numbers of the
//! reserved cells, and has those of the unreserved ones, where a part is put in one step.

use linewright_nets::{NetBuilder, PlaceId, explore};

/// A cell with one store, or several that are never full.
struct Twin<'a> {
    /// Capacity of the store; none for no limit.
    slots: Option<u32>,
    reserve: bool,
    /// For each type of parts, the machines that can do each step.
    plans: &'a [&'a [&'a [usize]]],
    waiting: &'a [u32],
}

const C1: [&[&[usize]]; 2] = [&[&[0, 1], &[2]], &[&[2], &[1]]];
const ASSEMBLY: [&[&[usize]]; 3] = [&[&[0]], &[&[1]], &[&[1]]];

type Arcs<'a> = &'a [PlaceId];

fn transition(b: &mut NetBuilder, name: String, takes: Arcs<'_>, gives: Arcs<'_>) {
    let t = b.transition(name);
    takes.iter().for_each(|&place| _ = b.input(t, place, 1));
    gives.iter().for_each(|&place| _ = b.output(t, place, 1));
}

impl Twin<'_> {
    /// Places, transitions, states, steps, deadlocks.
    fn counts(&self) -> [usize; 5] {
        let mut b = NetBuilder::new("twin");
        let robot = b.place("robot", 1);
        let slot: Vec<PlaceId> = self.slots.map(|slots| b.place("slots", slots)).into_iter().collect();
        let with = |places: &[PlaceId]| [places, &slot].concat();
        let mut free: Vec<Option<PlaceId>> = vec![None; 3];
        for (part, (plan, &waiting)) in self.plans.iter().zip(self.waiting).enumerate() {
            let outside = b.place(format!("outside {part}"), waiting);
            let stored: Vec<_> = (0..=plan.len()).map(|stage| b.place(format!("stored {part} {stage}"), 0)).collect();
            transition(&mut b, format!("enter {part}"), &with(&[outside]), &[stored[0]]);
            transition(&mut b, format!("leave {part}"), &[stored[plan.len()]], &with(&[outside]));
            for (step, machines) in plan.iter().enumerate() {
                for &machine in *machines {
                    let id = format!("{part} {step} {machine}");
                    let free = *free[machine].get_or_insert_with(|| b.place(format!("free {machine}"), 1));
                    let mut place = |name: &str| b.place(format!("{name} {id}"), 0);
                    let (loaded, working, ready) = (place("loaded"), place("working"), place("ready"));
                    let (loading, unloading) = (place("loading"), place("unloading"));
                    let (before, after) = (stored[step], stored[step + 1]);
                    let mut t = |name: &str, takes: Arcs<'_>, gives: Arcs<'_>| {
                        transition(&mut b, format!("{name} {id}"), takes, gives);
                    };
                    t("start work", &[loaded], &[working]);
                    t("end work", &[working], &[ready]);
                    if self.reserve {
                        t("start load", &[before, robot, free], &[loading]);
                        t("end load", &[loading], &with(&[loaded, robot]));
                        t("start unload", &with(&[ready, robot]), &[unloading]);
                        t("end unload", &[unloading], &[after, robot, free]);
                    } else {
                        t("start load", &[before, robot], &[loading]);
                        t("start unload", &[ready, robot], &[unloading]);
                        let mut place = |name: &str| b.place(format!("{name} {id}"), 0);
                        let (brought, fetched) = (place("brought"), place("fetched"));
                        let mut t = |name: &str, takes: Arcs<'_>, gives: Arcs<'_>| {
                            transition(&mut b, format!("{name} {id}"), takes, gives);
                        };
                        t("grasped in the store", &[loading], &with(&[brought]));
                        t("put into the machine", &[brought, free], &[loaded, robot]);
                        t("grasped in the machine", &[unloading], &[fetched, free]);
                        t("put into the store", &with(&[fetched]), &[after, robot]);
                    }
                }
            }
        }
        let net = b.build().expect("it is written down correctly");
        let graph = explore(&net, 1_000_000).expect("it is small");
        let played = [graph.states().len(), graph.steps().len(), graph.deadlocks().count()];
        [net.place_count(), net.transition_count(), played[0], played[1], played[2]]
    }
}

fn c1(slots: u32, reserve: bool, waiting: &[u32]) -> [usize; 5] {
    Twin { slots: Some(slots), reserve, plans: &C1, waiting }.counts()
}

fn assembly(reserve: bool, waiting: &[u32]) -> [usize; 5] {
    Twin { slots: None, reserve, plans: &ASSEMBLY, waiting }.counts()
}

#[test]
fn c1_by_hand_has_the_computed_numbers() {
    assert_eq!(c1(4, true, &[2, 2]), [38, 34, 4_256, 12_546, 0]);
    assert_eq!(c1(4, false, &[2, 2]), [48, 44, 9_054, 25_512, 78]);
    assert_eq!(c1(4, true, &[3, 2]), [38, 34, 12_604, 42_548, 2]);
    assert_eq!(c1(4, true, &[1, 4]), [38, 34, 4_525, 13_775, 3]);
    assert_eq!(c1(4, true, &[3, 3]), [38, 34, 26_108, 94_592, 20]);
    assert_eq!(c1(6, true, &[3, 3]), [38, 34, 31_860, 118_016, 0]);
}

#[test]
fn the_assembly_cell_by_hand_has_the_computed_numbers() {
    assert_eq!(assembly(true, &[1, 1, 1]), [27, 24, 288, 744, 0]);
    assert_eq!(assembly(true, &[2, 2, 1]), [27, 24, 1_773, 6_516, 0]);
    assert_eq!(assembly(true, &[2, 2, 2]), [27, 24, 4_104, 16_956, 0]);
    assert_eq!(assembly(false, &[1, 1, 1]), [33, 30, 486, 1_206, 4]);
    assert_eq!(assembly(false, &[2, 2, 1]), [33, 30, 3_789, 13_536, 9]);
    assert_eq!(assembly(false, &[2, 2, 2]), [33, 30, 9_612, 38_880, 11]);
}
