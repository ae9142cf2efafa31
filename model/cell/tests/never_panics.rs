//! Whatever a file contains, reading it ends with a cell, whose nets can be made, or with problems that can be drawn.

use linewright_cases::slips::{draw, moved, near, slipped, slips};
use linewright_cell::net::{Detail, Supply, net};
use linewright_cell::parse;
use linewright_text::Problems;
use proptest::prelude::*;

use linewright_testkit::cells::{ASSEMBLY, C1};

/// Parses, and checks what must hold of any outcome.
fn survives(text: &str) {
    let problems = match parse("any.toml", text, None) {
        Ok(parsed) => {
            for detail in [Detail::Coordination, Detail::Expanded] {
                let made = net(&parsed.cell, detail, &[1, 1]).and(net(&parsed.cell, detail, Supply::Open));
                if let Err(why) = made {
                    panic!("a sound cell has no net: {why:?}");
                }
            }
            Problems::new("any.toml", text, parsed.warnings)
        }
        Err(problems) => {
            assert!(problems.errors() > 0, "no cell and no error");
            assert!(!problems.iter().any(|p| p.message.contains("no rule explains")), "unexplained\n{text}");
            problems
        }
    };
    draw(text, &problems);
}

const WORDS: &[&str] = &[
    "[[part]]\n",
    "[[sync]]\n",
    "or = \"turn\"\n",
    "then = \"grind\"\n",
    "\"M1.load\", ",
    "capacity = 3\n",
    "reserve = false\n",
];

fn base() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec![C1, ASSEMBLY])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_text(text in any::<String>()) {
        survives(&text);
    }

    #[test]
    fn a_truncated_file(base in base(), end in 0.0..1.0) {
        survives(&base[..near(base, end)]);
    }

    #[test]
    fn a_file_with_slips(base in base(), slips in slips(WORDS)) {
        survives(&slipped(base, slips));
    }

    #[test]
    fn a_file_with_a_line_moved_or_lost(base in base(), from in 0.0..1.0, to in prop::option::of(0.0..1.0)) {
        survives(&moved(base, from, to));
    }

    #[test]
    fn a_file_with_words_exchanged(base in base(), from in 0usize..400, to in 0usize..400) {
        // Every second piece between quotation marks is a word.
        let mut pieces: Vec<&str> = base.split('"').collect();
        let words = pieces.len() / 2;
        pieces.swap(2 * (from % words) + 1, 2 * (to % words) + 1);
        survives(&pieces.join("\""));
    }

    #[test]
    fn a_file_with_another_prototype(at in 0usize..8, name in prop::sample::select(vec!["fifo-buffer", "lifo-buffer", "conveyor", "human", "random-access-store"]), reserve in any::<bool>()) {
        let mut lines: Vec<String> = C1.lines().map(str::to_owned).collect();
        let places: Vec<usize> = (0..lines.len()).filter(|&line| lines[line].starts_with("prototype")).collect();
        let line = places[at % places.len()];
        lines[line] = format!("prototype = \"{name}\"");
        if name == "conveyor" {
            lines[line].push_str("\ncapacity = 2");
        }
        survives(&lines.join("\n").replace("reserve = true", &format!("reserve = {reserve}")));
    }
}

#[test]
fn the_bounds_hold() {
    survives(&"#".repeat((1 << 20) + 1));
    survives(&"[".repeat(10_000));
    survives(&"[[resource]]\n".repeat(70_000));
    survives(&"[[sync]]\nactions = [\"a.b\"]\n".repeat(30_000));
    let steps = |n: usize| {
        (0..n).map(|at| {
            format!("[[part.step]]\nname = \"s{at}\"\non = [{{ resource = \"M1\", time_s = 1, program = 1 }}]\n")
        })
    };
    let parts: String =
        (0..30).flat_map(|part| std::iter::once(format!("[[part]]\nname = \"p{part}\"\n")).chain(steps(300))).collect();
    survives(&format!("{C1}{parts}"));
}
