//! Whatever a file contains, parsing it ends with a line or with problems that can be drawn.

use linewright_cases::slips::{draw, moved, near, slipped, slips};
use linewright_line::{Problems, TransferLine, parse};
use proptest::prelude::*;

const SHIPPED: &str = include_str!("../../../launch-config/lines/transfer-line/line.toml");
const CELL: &str = include_str!("descriptions/cell.toml");
const TASK_DRIVEN: &str = include_str!("descriptions/task_driven.toml");

/// Parses, and checks what must hold of any outcome.
fn survives(text: &str) {
    let problems = match parse("any.toml", text) {
        Ok(parsed) => {
            assert!(!parsed.line.stations.is_empty());
            Problems::new("any.toml", text, parsed.warnings)
        }
        Err(problems) => {
            assert!(problems.errors() > 0, "no line and no error");
            problems
        }
    };
    draw(text, &problems);
}

const WORDS: &[&str] =
    &["[[station]]\n", "[[station.operation]]\n", "with = \"decel\"\n", "[[station.task]]\n", "task = \"clamp\"\n"];

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_text(text in any::<String>()) {
        survives(&text);
    }

    #[test]
    fn random_toml(text in "([a-z]{1,8}(\\.[a-z]{1,8})? = (\"[ -~]{0,8}\"|[0-9.e-]{1,6}|\\{ [a-z]{1,4} = 1 \\}|\\[[0-9, ]{0,6}\\])\n|\\[\\[?(station|arrow|device|timing|console)\\]?\\]\n){0,20}") {
        survives(&text);
    }

    #[test]
    fn a_truncated_file(end in 0.0..1.0) {
        survives(&SHIPPED[..near(SHIPPED, end)]);
    }

    #[test]
    fn a_file_with_slips(slips in slips(WORDS), of in 0usize..3) {
        survives(&slipped([CELL, TASK_DRIVEN, SHIPPED][of], slips));
    }

    #[test]
    fn a_file_with_a_line_moved(from in 0.0..1.0, to in 0.0..1.0) {
        survives(&moved(SHIPPED, from, Some(to)));
    }

    #[test]
    fn a_file_with_a_value_swapped(key in 0usize..400, value in 0usize..400, of in 0usize..2) {
        let mut lines: Vec<String> = [CELL, TASK_DRIVEN][of].lines().map(str::to_owned).collect();
        let (key, value) = (key % lines.len(), value % lines.len());
        let taken = lines[value].split_once(" = ").map(|(_, v)| v.to_owned());
        if let (Some((name, _)), Some(taken)) = (lines[key].clone().split_once(" = "), taken) {
            lines[key] = format!("{name} = {taken}");
        }
        survives(&lines.join("\n"));
    }
}

#[test]
fn the_bounds_hold() {
    survives(&"#".repeat((1 << 20) + 1));
    survives(&"[".repeat(10_000));
    survives(&format!("a = {}", "[".repeat(10_000)));
    survives(&format!("a = {}", "{a=".repeat(10_000)));
    survives(&format!("{}b = 1", "a.".repeat(10_000)));
    survives(&"[[station]]\n".repeat(80_000));
    survives(&"[[arrow]]\nfrom = \"a: b\"\nto = \"c: d\"\n".repeat(25_000));
    survives(&format!("buttons = [{}]", "\"a\",".repeat(200_000)));
    let long = "x".repeat(60);
    let stations: String = (0..1000).map(|n| format!("[[station]]\nname = \"{long}{n}\"\n")).collect();
    let arrows = format!("[[arrow]]\nfrom = \"{long}y: a\"\nto = \"b: c\"\n").repeat(8000);
    survives(&format!("{stations}{arrows}"));
    let operation = "[[station.operation]]\nname = \"a\"\nnormal = { actuator = \"Y\", complete = \"X\" }\n";
    survives(&format!("[[station]]\nname = \"s\"\n{}", operation.repeat(64)).repeat(150));
    survives(
        &TransferLine { machines: TransferLine::MACHINES_MAX, time_scale: 1.0 }.text().replace("lag = 0", "lag = 1"),
    );
}
