//! Random well-formed stations: sequences of every hand type, irreversible operations with their paths home, groups
//! side by side, and the home operation anywhere.
//!
//! A path home avoids groups here: the bare net of a station whose path runs through one operation of a group has a
//! token alone in that group, which only the conditions (no turning forward on a path) keep from getting stuck.

use linewright_line::Line;
use proptest::prelude::*;

use linewright_testkit::built::{Op, alone, line, r, station};

/// One hand-mode sequence: its hand types, and for each operation whether it may be irreversible and grouped.
fn sequence() -> impl Strategy<Value = Vec<Op>> {
    let plain = (0usize..3).prop_map(|before| {
        let mut ops = vec![r(1); before];
        ops.push(r(2));
        ops
    });
    let reversed = (0usize..2).prop_map(|middle| {
        let mut ops = vec![r(3)];
        ops.extend(vec![r(4); middle]);
        ops.push(r(5));
        ops
    });
    prop_oneof![2 => plain, 1 => reversed, 2 => Just(vec![r(6)])]
}

/// A station by itself.
pub fn station_alone() -> impl Strategy<Value = Line> {
    parts().prop_map(|(home, ops, share)| {
        if share { line(vec![station("alone", home, &ops, 0, true)], Vec::new()) } else { alone(home, &ops) }
    })
}

fn parts() -> impl Strategy<Value = (usize, Vec<Op>, bool)> {
    let dice = prop::collection::vec(any::<u8>(), 24);
    (prop::collection::vec(sequence(), 1..5), dice, any::<u8>(), any::<bool>()).prop_filter_map(
        "two steps at least",
        |(sequences, dice, home, share)| {
            let ops: Vec<Op> = sequences.concat();
            if ops.len() < 2 {
                return None;
            }
            let home = usize::from(home) % ops.len();
            let (home, mut ops) = with_groups(ops, home, &dice);
            add_paths(&mut ops, home, &dice);
            Some((home, ops, share))
        },
    )
}

/// Gives some operations, neither the first nor the home one, one or two neighbours.
fn with_groups(ops: Vec<Op>, home: usize, dice: &[u8]) -> (usize, Vec<Op>) {
    let mut grown = Vec::new();
    let mut new_home = home;
    for (n, op) in ops.into_iter().enumerate() {
        let neighbours = if n == 0 || n == home { 0 } else { usize::from(dice[n % dice.len()] % 8).saturating_sub(5) };
        let hand = op.hand;
        if n == home {
            new_home = grown.len();
        }
        grown.push(op);
        grown.extend(vec![Op { beside: true, ..r(hand) }; neighbours]);
    }
    (new_home, grown)
}

/// Makes some operations irreversible, of hand types that allow it, where an operation before them leads home.
fn add_paths(ops: &mut [Op], home: usize, dice: &[u8]) {
    let grouped = |ops: &[Op], n: usize| ops[n].beside || ops.get(n + 1).is_some_and(|next| next.beside);
    let mut way_back: Vec<usize> = Vec::new();
    for distance in 1..ops.len() {
        let n = (home + distance) % ops.len();
        if grouped(ops, n) {
            continue;
        }
        if ops[n].hand <= 2 && !way_back.is_empty() && dice[n % dice.len()].is_multiple_of(3) {
            let taken = 1 + usize::from(dice[(n + 1) % dice.len()]) % way_back.len();
            ops[n].path = Some(way_back.iter().rev().take(taken).copied().collect());
        } else {
            way_back.push(n);
        }
    }
}
