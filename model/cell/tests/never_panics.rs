//! Whatever a file contains, reading it ends with a cell, whose nets can be made, or with problems that can be drawn.

use linewright_cell::net::{Detail, Supply, net};
use linewright_cell::parse;
use linewright_text::Problems;
use miette::{GraphicalReportHandler, GraphicalTheme};
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
    for problem in problems.iter() {
        assert!(text.get(problem.span.clone()).is_some(), "{problem} points out of the text");
    }
    let mut drawn = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .render_report(&mut drawn, &problems)
        .expect("every report can be drawn");
}

/// Effect of a slip of the hand, or of a merge tool, on a file.
fn slip() -> impl Strategy<Value = String> {
    let signs = vec![
        "\"",
        "[",
        "]",
        "[[",
        "{",
        "}",
        "=",
        "\n",
        ",",
        ".",
        "-1",
        "0",
        "1e400",
        "nan",
        "\"\"",
        "true",
        "[]",
        "{}",
        "é",
        "\u{0}",
        "[[part]]\n",
        "[[sync]]\n",
        "or = \"turn\"\n",
        "then = \"grind\"\n",
        "\"M1.load\", ",
        "capacity = 3\n",
        "reserve = false\n",
    ];
    prop_oneof![any::<char>().prop_map(String::from), "[a-z_]{1,6}", prop::sample::select(signs).prop_map(String::from)]
}

/// Cuts `text` at a whole character near `at` (a fraction).
fn cut(text: &str, at: f64) -> usize {
    (0..=(text.len() as f64 * at) as usize).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0)
}

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
        survives(&base[..cut(base, end)]);
    }

    #[test]
    fn a_file_with_slips(base in base(), slips in prop::collection::vec((0.0..1.0, 0usize..12, slip()), 1..4)) {
        let mut text = base.to_owned();
        for (at, removed, inserted) in slips {
            let start = cut(&text, at);
            let end = ((start + removed).min(text.len())..=text.len()).find(|&at| text.is_char_boundary(at));
            text.replace_range(start..end.unwrap_or(text.len()), &inserted);
        }
        survives(&text);
    }

    #[test]
    fn a_file_with_a_line_moved_or_lost(base in base(), from in 0.0..1.0, to in 0.0..1.0, lost in any::<bool>()) {
        let mut lines: Vec<&str> = base.lines().collect();
        let line = lines.remove((lines.len() as f64 * from) as usize);
        if !lost {
            lines.insert((lines.len() as f64 * to) as usize, line);
        }
        survives(&lines.join("\n"));
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
