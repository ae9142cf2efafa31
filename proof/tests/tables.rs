//! The tables of stations that go round a cycle are, to the byte, what they were before there were task-driven ones.
//!
//! `tables.txt` was written by the compiler of that time, of the shipped line and of fifty random ones. A change of it
//! is a change of every controller there is: it needs a reason that has nothing to do with orders.

use linewright_line::{Line, TransferLine, parse};
use linewright_proof::generate::{self, LineShape};
use linewright_station_logic::Program;

const BEFORE: &str = include_str!("tables.txt");

/// FNV-1a, 64 bits.
fn hash(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

/// The text without what stands from `from` up to the next `until`, each time.
fn without(text: String, from: &str, until: &str) -> String {
    let mut parts = text.split(from);
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |kept, part| kept + part.find(until).map_or(part, |end| &part[end..]))
}

/// A line of text for each station: of which line, its name, how many bytes its tables take in words, and their hash.
fn tables(of: &str, line: &Line, out: &mut Vec<String>) {
    for id in line.station_ids() {
        let program = Program::compile(line, id).expect("a sound station compiles");
        // Parts that only task-driven stations have are at the end, and absent here; the second barrier stands beside
        // these tables.
        let words = without(format!("{program:?}"), ", interlocks: ", ", tasks").replace(", tasks: None", "");
        // These types had other names.
        let renamed = [
            ("IncomingArrow {", "Cause {"),
            ("ConditionRow {", "Row {"),
            ("CompiledTransition {", "Action {"),
            ("StationPlace {", "Place {"),
            // Sets of peers were a number.
            ("PeerSet([", ""),
            (", 0, 0, 0])", ""),
        ];
        let words = renamed.iter().fold(words, |words, (now, then)| words.replace(now, then));
        let words = without(without(words, ", starts: ", ", withdraws"), ", rest: ", ", hold");
        // The switch of the end that a motion leaves, compared since a stuck switch is.
        let words = without(words, ", behind: ", ", fault");
        // Fields that only an index has.
        let words = without(words, ", turns: 0, least: ", ", hold");
        out.push(format!("{of} {} {} {:016x}", line.station(id).name, words.len(), hash(&words)));
    }
}

#[test]
fn they_are_what_they_were() {
    let shipped = TransferLine::default().text();
    let mut now = Vec::new();
    tables("shipped", &parse("line.toml", &shipped).expect("the shipped line is sound").line, &mut now);
    for seed in 0..50 {
        let shape = if seed < 40 { LineShape::default() } else { LineShape::row(8) };
        tables(&format!("generated-{seed}"), &generate::line(&shape, seed), &mut now);
    }
    let first = now.iter().zip(BEFORE.lines()).find(|(now, before)| now != before);
    let same = now.iter().map(String::as_str).eq(BEFORE.lines());
    assert!(same, "the first that differs: {first:?}; the whole of it now:\n{}\n", now.join("\n"));
}
