//! The numbers of an explorer written in Python before any of this, which shares nothing with it; the same table as in
//! `model/cell/tests/net/counts.rs`, here for the numbers of `check`.

use linewright_cell::net::Detail;
use linewright_proof::cell::{CellExploration, Checked, Verdict, check};

use super::{ASSEMBLY, C1, cell, edited, verdicts};

fn expanded(text: &str, parts: &[u32]) -> Checked {
    let cell = cell(text);
    let setting =
        CellExploration { detail: Detail::Expanded, parts: Some(parts.to_vec()), ..CellExploration::new(&cell) };
    check(&setting).expect("it is small")
}

#[track_caller]
fn is_sound(text: &str, parts: &[u32], states: u64, arcs: u64) {
    let checked = expanded(text, parts);
    assert_eq!(verdicts(&checked)[..2], [Verdict::Holds; 2], "{checked:#?}");
    let [group] = checked.groups.as_slice() else { panic!("{checked:#?}") };
    assert_eq!((group.states, group.arcs), (states, arcs));
}

#[track_caller]
fn gets_stuck(text: &str, parts: &[u32], sound: u32) {
    let checked = expanded(text, parts);
    assert_eq!((verdicts(&checked)[0], checked.sound), (Verdict::Fails, sound), "{checked:#?}");
}

fn c1(slots: u32, reserve: bool) -> String {
    let (capacity, reserve) = (format!("capacity = {slots}"), format!("reserve = {reserve}"));
    edited(C1, &[("capacity = 6", &capacity), ("reserve = true", &reserve), ("wip_max = 6", "wip_max = 10")])
}

#[test]
fn c1_is_as_computed() {
    is_sound(&c1(4, true), &[2, 2], 4_256, 12_546);
    is_sound(&c1(6, true), &[3, 3], 31_860, 118_016);
    // Those with deadlocks: as many parts as slots are sound, one more is not.
    for parts in [[3, 2], [1, 4], [3, 3], [4, 4]] {
        gets_stuck(&c1(4, true), &parts, 4);
    }
    gets_stuck(&c1(4, false), &[2, 2], 1);
}

#[test]
fn the_assembly_cell_is_as_computed() {
    is_sound(ASSEMBLY, &[1, 1, 1], 288, 744);
    is_sound(ASSEMBLY, &[2, 2, 1], 1_773, 6_516);
    let six = ASSEMBLY.replace("capacity = 5", "capacity = 6").replace("wip_max = 5", "wip_max = 6");
    is_sound(&six, &[2, 2, 2], 4_104, 16_956);
    let unreserved = six.replace("reserve = true", "reserve = false");
    gets_stuck(&unreserved, &[1, 1, 1], 1);
    gets_stuck(&unreserved, &[2, 2, 2], 1);
}
