//! Report to a user when several things are wrong at once.

use linewright_line::{Problem, Problems, parse};
use miette::{GraphicalReportHandler, GraphicalTheme};

const SHIPPED: &str = include_str!("../../../launch-config/lines/transfer-line/line.toml");

/// The shipped line after an evening of careless editing.
fn careless() -> String {
    let mut text = SHIPPED.to_owned();
    for (old, new) in [
        ("buttons = ", "botons = [\"PB_9\"]\nbuttons = "),
        ("from = 50, to = 100", "from = 60, to = 100"),
        ("watchdog_s = 1.5", "watchdog_s = 0.4"),
        ("complete = \"LS_closed\"", "complete = \"LS_close\""),
        ("[\"rapid advance positioning slide\"]", "[\"rapid advance positioning slide\", \"reset main slide\"]"),
        ("to = \"transfer: 1st lift\"", "to = \"transfer: first lift\""),
        ("lag = 1", "lag = 0"),
        ("node = 0x22", "node = 0x21"),
    ] {
        assert!(text.contains(old), "the shipped line has no {old:?}");
        text = text.replacen(old, new, 1);
    }
    text
}

fn drawn(problems: &Problems) -> String {
    let mut drawn = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .with_width(120)
        .render_report(&mut drawn, problems)
        .expect("a report can be drawn");
    drawn
}

#[test]
fn all_problems_are_drawn_at_their_places() {
    let problems = parse("line.toml", &careless()).expect_err("this is wrong in many ways");
    insta::assert_snapshot!("drawn", drawn(&problems));
}

#[test]
fn all_problems_are_listed_one_a_line() {
    let problems = parse("line.toml", &careless()).expect_err("this is wrong in many ways");
    insta::assert_snapshot!("listed", format!("{problems:#}"));
}

#[test]
fn far_too_many_problems_are_cut_and_said_to_be() {
    let problems = parse("line.toml", &"[[arrow]]\n".repeat(1000)).expect_err("arrows need ends");
    assert_eq!(problems.errors(), 500);
    assert_eq!(problems.to_string(), "line.toml: the first 500 errors of more");
}

#[test]
fn of_a_very_long_line_a_part_is_drawn() {
    let long = "x".repeat(500_000);
    for (text, what) in [
        (format!("name = \"{long}\"\n"), "a value"),
        (format!("{long} = 1\n"), "a key"),
        (format!("name = \"{long}\n"), "no TOML"),
        ("#".repeat(2 << 20), "more than a description"),
    ] {
        let problems = parse("line.toml", &text).expect_err(what);
        let drawn = drawn(&problems);
        assert!(drawn.len() < 20_000, "{what}: {} bytes\n{}", drawn.len(), &drawn[..2000]);
        assert!(format!("{problems:#}").len() < 20_000, "{what}");
    }
}

#[test]
fn of_two_places_far_apart_the_lines_between_are_not_drawn() {
    let text: String = (1..=100).map(|line| format!("row {line:03}\n")).collect();
    let place = |line: usize| 8 * (line - 1)..8 * line - 1;
    let drawn_with = |first: usize| {
        let problem = Problem::error(place(90), "twice").label("the second").earlier(place(first));
        drawn(&Problems::new("list", &text, vec![problem]))
    };
    let apart = drawn_with(60);
    assert!(
        ["row 060", "row 089", "row 090", "the first", "the second"].iter().all(|part| apart.contains(part)),
        "{apart}"
    );
    assert!(!apart.contains("row 075"), "{apart}");
    assert!(apart.contains("list:90:1"), "{apart}");
    let near = drawn_with(87);
    assert!(near.contains("row 088") && near.matches("[list:").count() == 1, "{near}");
}

#[test]
fn text_that_is_not_toml_is_one_problem() {
    let problems = parse("line.toml", "name = \"a\"\ntitle \"b\"\n").expect_err("there is a sign missing");
    insta::assert_snapshot!("not_toml", drawn(&problems));
}
