//! Every rule, broken once: an edit of a shipped cell, and all that is said about it.
//!
//! The snapshot has place, message and hint of each problem. A case whose edit were without effect would fail: it must
//! raise a problem, of the stated kind, and the problem must lie within the text.

use std::fmt::Write;

use linewright_cell::parse;

use crate::common::{ASSEMBLY, ASSEMBLY_LINE, C1, C1_LINE, edited};

/// The rule, and what to replace by what, first occurrence each.
type Case<'a> = (&'a str, &'a [(&'a str, &'a str)]);

/// All problems of a text, one a line.
fn said(text: &str) -> (String, usize, usize) {
    let problems = match parse("cell.toml", text, None) {
        Ok(parsed) => parsed.warnings,
        Err(problems) => problems.into_vec(),
    };
    let mut list = String::new();
    for p in &problems {
        assert!(text.get(p.span.clone()).is_some(), "{p} points out of the text");
        let kind = if p.is_warning { "warning: " } else { "" };
        let marked = text.get(p.span.clone()).unwrap_or_default().lines().next().unwrap_or_default();
        let label = p.label.as_deref().map_or(String::new(), |label| format!(" [{label}]"));
        let hint = p.hint.as_deref().map_or(String::new(), |hint| format!(" ({hint})"));
        writeln!(list, "  {}:{} `{marked}`: {kind}{}{label}{hint}", p.line, p.column, p.message)
            .expect("writing to a string");
    }
    let errors = problems.iter().filter(|p| !p.is_warning).count();
    (list, errors, problems.len() - errors)
}

fn check(base: &str, cases: &[Case<'_>], is_warning: bool) -> String {
    let mut all = String::new();
    for (rule, edits) in cases {
        let (list, errors, warnings) = said(&edited(base, edits));
        assert!(if is_warning { warnings > 0 && errors == 0 } else { errors > 0 }, "{rule}: {list}");
        write!(all, "{rule}\n{list}").expect("writing to a string");
    }
    all
}

#[test]
fn the_shipped_cells_are_sound() {
    assert_eq!(said(C1), (String::new(), 0, 0));
    assert_eq!(said(ASSEMBLY), (String::new(), 0, 0));
}

#[test]
fn keys_and_types() {
    let cases: &[Case<'_>] = &[
        ("name is needed", &[("name = \"workcell_c1\"\n", "")]),
        ("[cell] is needed", &[("[cell]", "[sell]")]),
        ("wip_max is needed", &[("wip_max = 6", "")]),
        ("wip_max is a number", &[("wip_max = 6", "wip_max = \"six\"")]),
        ("wip_max is bounded", &[("wip_max = 6", "wip_max = 0")]),
        ("safety is at least 1", &[("safety = 2", "safety = 0.5")]),
        ("reserve is true or false", &[("reserve = true", "reserve = 1")]),
        ("actions are needed", &[("actions = [\"ST.retrieve\", \"R.pick-and-place\", \"M1.load\"]\n", "")]),
        ("unknown key", &[("prototype = \"machine\"", "protoype = \"machine\"")]),
        ("a time is above zero", &[("time_s = 40", "time_s = 0")]),
        ("a step needs its time", &[("time_s = 40, ", "")]),
        ("a program is a number", &[("program = 1", "program = \"one\"")]),
        ("a program has 32 bits", &[("program = 1", "program = 4294967296")]),
        ("a parameter is a text or a number", &[("slot = \"ST.position\"", "slot = 1.5")]),
        (
            "unknown whereabouts and strategy",
            &[("part = \"from\"", "part = \"form\""), ("then = \"redo\"", "then = \"again\"")],
        ),
        ("an answer needs its word", &[("word = \"scrap\", ", "")]),
    ];
    insta::assert_snapshot!(check(C1, cases, false));
}

#[test]
fn names() {
    let cases: &[Case<'_>] = &[
        ("the cell has a ROS name", &[("\"workcell_c1\"", "\"Workcell C1\"")]),
        ("a resource twice", &[("name = \"M2\"", "name = \"M1\"")]),
        ("a resource with a sign", &[("name = \"R\"", "name = \"R.1\"")]),
        ("a resource called outside", &[("name = \"R\"", "name = \"outside\"")]),
        ("a resource called running", &[("name = \"R\"", "name = \"running\"")]),
        ("an empty name", &[("name = \"R\"", "name = \"\"")]),
        ("a synchronisation twice", &[("name = \"unload M1\"", "name = \"load M1\"")]),
        ("a synchronisation with a sign", &[("name = \"leave\"", "name = \"leave<now>\"")]),
        ("a part twice", &[("name = \"B\"", "name = \"A\"")]),
        ("a step twice", &[("name = \"drill\"", "name = \"grind\"")]),
        ("a step called done", &[("name = \"drill\"", "name = \"done\"")]),
        ("an action described twice", &[("of = \"M2.process\"", "of = \"M1.process\"")]),
        ("an answer is one word", &[("word = \"scrap\"", "word = \"throw it away\"")]),
    ];
    insta::assert_snapshot!(check(C1, cases, false));
}

#[test]
fn resources() {
    let cases: &[Case<'_>] = &[
        ("unknown prototype", &[("\"machine\"", "\"machin\"")]),
        ("capacity zero", &[("capacity = 1", "capacity = 0")]),
        ("capacity too large", &[("capacity = 6", "capacity = 10001")]),
        ("a store needs a capacity", &[("capacity = 6\n", "")]),
        ("a robot has none", &[("prototype = \"robot\"", "prototype = \"robot\"\ncapacity = 2")]),
        ("a station of two", &[("station = \"m2\"", "station = \"m1\"")]),
        ("presence without a station", &[("station = \"m1\"\n", "")]),
        ("no resource", &[("[[resource]]", "[[resorce]]")]),
    ];
    insta::assert_snapshot!(check(C1, cases, false));
}

#[test]
fn synchronisations() {
    let cases: &[Case<'_>] = &[
        ("unknown resource", &[("\"M1.load\"", "\"M11.load\"")]),
        ("no action of its prototype", &[("\"M1.load\"", "\"M1.store\"")]),
        ("no action at all", &[("\"M1.load\"", "\"M1\"")]),
        ("of the outside only in and out", &[("\"outside.in\"", "\"outside.inn\"")]),
        (
            "two sources",
            &[("\"ST.retrieve\", \"R.pick-and-place\"", "\"ST.retrieve\", \"M2.unload\", \"R.pick-and-place\"")],
        ),
        ("no source", &[("\"ST.retrieve\", \"R.pick-and-place\", \"M1.load\"", "\"R.pick-and-place\", \"M1.load\"")]),
        ("two targets", &[("\"M1.load\"", "\"M1.load\", \"M2.load\"")]),
        ("no target", &[("\"R.pick-and-place\", \"M1.load\"", "\"R.pick-and-place\"")]),
        ("from itself to itself", &[("\"M1.load\"", "\"ST.store\"")]),
        ("a machine works in it", &[("\"M1.load\"", "\"M1.load\", \"M1.process\"")]),
        ("an action twice", &[("\"M1.load\"", "\"M1.load\", \"M1.load\"")]),
        (
            "two carriers",
            &[
                (
                    "name = \"R\"\nprototype = \"robot\"",
                    "name = \"Q\"\nprototype = \"robot\"\n[[resource]]\nname = \"R\"\nprototype = \"robot\"",
                ),
                ("\"M1.load\"", "\"M1.load\", \"Q.pick-and-place\""),
            ],
        ),
        ("no part comes", &[("\"outside.in\", ", "")]),
        ("no part leaves", &[(", \"outside.out\"", "")]),
        ("an action that is no work", &[("of = \"M1.process\"", "of = \"M1.load\"")]),
    ];
    insta::assert_snapshot!(check(C1, cases, false));
}

#[test]
fn a_human_cannot_carry_to_himself() {
    let cases: &[Case<'_>] = &[(
        "the carrier is the target",
        &[("\"robot_1.pick-and-place\", \"human.load\"", "\"human.pick-and-place\", \"human.load\"")],
    )];
    insta::assert_snapshot!(check(ASSEMBLY, cases, false));
}

#[test]
fn orders() {
    let cases: &[Case<'_>] = &[
        (
            "two orders to one station",
            &[("{ station = \"m1\", task = \"clamp\"", "{ station = \"robot\", task = \"clamp\"")],
        ),
        ("a limit below the time", &[("max_s = 24", "max_s = 12")]),
        ("no limit and no time", &[("time_s = 12\n", ""), ("max_s = 24 },", "},")]),
        ("a parameter from nowhere", &[("\"ST.position\"", "\"ST.place\"")]),
        ("a parameter from an unknown store", &[("\"ST.position\"", "\"SP.position\"")]),
        ("a position in a machine", &[("\"ST.position\"", "\"M1.position\"")]),
        ("a program where nothing is worked on", &[("\"ST.position\"", "\"step.program\"")]),
        ("a parameter too large", &[("\"ST.position\"", "2147483648")]),
        ("no program given", &[("time_s = 30, program = 2", "time_s = 30")]),
    ];
    insta::assert_snapshot!(check(C1, cases, false));
}

#[test]
fn plans() {
    let turn = "[[part.step]]\nname = \"turn\"\n";
    let cases: &[Case<'_>] = &[
        (
            "no part",
            &[
                ("[[part]]\nname = \"A\"\n[[part.step]]", "[[art]]\n[[art.step]]"),
                ("[[part.step]]", "[[art.step]]"),
                ("[[part]]\nname = \"B\"\n[[part.step]]", "[[art]]\n[[art.step]]"),
                ("[[part.step]]", "[[art.step]]"),
            ],
        ),
        ("no steps", &[("[[part]]\nname = \"B\"", "[[part]]\nname = \"C\"\n[[part]]\nname = \"B\"")]),
        ("a step nowhere", &[("on = [{ resource = \"M3\", time_s = 30, program = 2 }]", "on = []")]),
        ("on an unknown resource", &[("resource = \"M1\"", "resource = \"M9\"")]),
        ("on one that cannot work", &[("resource = \"M1\"", "resource = \"R\"")]),
        ("a resource twice", &[("resource = \"M1\"", "resource = \"M2\"")]),
        ("or what does not exist", &[(turn, "[[part.step]]\nname = \"turn\"\nor = \"trun\"\n")]),
        ("or what comes later", &[(turn, "[[part.step]]\nname = \"turn\"\nor = \"grind\"\n")]),
        ("then what comes earlier", &[("name = \"grind\"", "name = \"grind\"\nthen = \"turn\"")]),
        (
            "never reached",
            &[
                (turn, "[[part.step]]\nname = \"turn\"\nthen = \"polish\"\n"),
                (
                    "[[part]]\nname = \"B\"",
                    "[[part.step]]\nname = \"polish\"\non = [{ resource = \"M2\", time_s = 1, program = 9 }]\n\n[[part]]\nname = \"B\"",
                ),
            ],
        ),
        (
            "not said what follows",
            &[(
                "[[part]]\nname = \"B\"",
                "[[part.step]]\nname = \"mill\"\nor = \"turn\"\non = [{ resource = \"M2\", time_s = 1, program = 9 }]\n[[part.step]]\nname = \"end\"\non = [{ resource = \"M3\", time_s = 1, program = 9 }]\n\n[[part]]\nname = \"B\"",
            )],
        ),
    ];
    insta::assert_snapshot!(check(C1, cases, false));
}

#[test]
fn plans_that_cannot_be_done() {
    let cases: &[Case<'_>] = &[
        ("nothing loads M3", &[("\"R.pick-and-place\", \"M3.load\"", "\"R.pick-and-place\", \"M1.load\"")]),
        ("nothing unloads M3", &[("\"M3.unload\", \"R.pick-and-place\"", "\"M1.unload\", \"R.pick-and-place\"")]),
        (
            "an alternative that is never used",
            &[("\"R.pick-and-place\", \"M1.load\"", "\"R.pick-and-place\", \"M2.load\"")],
        ),
        (
            "an alternative that is a dead end",
            &[("\"M1.unload\", \"R.pick-and-place\"", "\"M2.unload\", \"R.pick-and-place\"")],
        ),
        (
            "what is finished cannot leave",
            &[
                ("\"ST.retrieve\", \"outside.out\"", "\"OUT.retrieve\", \"outside.out\""),
                (
                    "[[resource]]\nname = \"R\"",
                    "[[resource]]\nname = \"OUT\"\nprototype = \"random-access-store\"\ncapacity = 1\n[[resource]]\nname = \"R\"",
                ),
            ],
        ),
    ];
    insta::assert_snapshot!(check(C1, cases, false));
}

#[test]
fn dispatch() {
    let cases: &[Case<'_>] = &[
        ("unknown rule", &[("\"earliest-due-date\"", "\"earliest-due\"")]),
        ("a rule twice", &[("\"earliest-due-date\"", "\"fifo\"")]),
        ("the schedule alone", &[("[\"schedule\", \"earliest-due-date\", \"fifo\"]", "[\"schedule\"]")]),
        ("no rule", &[("[\"schedule\", \"earliest-due-date\", \"fifo\"]", "[]")]),
        ("look-ahead is bounded", &[("look_ahead_s = 120", "look_ahead_s = -1")]),
    ];
    insta::assert_snapshot!(check(C1, cases, false));
}

#[test]
fn exceptions() {
    let cases: &[Case<'_>] = &[
        ("a pattern that fits nothing", &[("in = \"load M*\"", "in = \"laod M1\"")]),
        ("an answer twice", &[("word = \"in-machine\"", "word = \"in-store\"")]),
        ("a strategy that does not fit", &[("part = \"to\", then = \"forward\"", "part = \"to\", then = \"redo\"")]),
        (
            "forward with a part that has not moved",
            &[("part = \"from\", then = \"redo\"", "part = \"from\", then = \"forward\"")],
        ),
        ("forward without a part", &[("part = \"gone\", then = \"backward\"", "part = \"gone\", then = \"forward\"")]),
        ("redo without a retry", &[("retries = 2", "retries = 0")]),
        ("telling what nobody knows", &[("{slot}", "{slto}")]),
        ("a brace that stays open", &[("{from}", "{from")]),
        ("no answer", &[("answers = [", "answers = []\nold = [")]),
        ("stopping what there is not", &[("retries = 2", "retries = 2\nemergency_stop = [\"robto\", \"*\"]")]),
        ("stopping a resource", &[("retries = 2", "retries = 2\nemergency_stop = [\"M1\", \"ST\"]")]),
        ("stopping without anybody", &[("retries = 2", "retries = 2\nautomatic = true\nemergency_stop = [\"robot\"]")]),
        (
            "leaving out what there is not",
            &[
                ("retries = 2", "retries = 2\ndown = [\"M9\"]"),
                ("then = \"forward\"", "then = \"forward\", down = [\"gone\"]"),
            ],
        ),
    ];
    insta::assert_snapshot!(check(C1, cases, false));
}

#[test]
fn warnings() {
    let cases: &[Case<'_>] = &[
        ("more parts than stores hold", &[("wip_max = 6", "wip_max = 7")]),
        ("a patience below an activity", &[("patience_s = 600", "patience_s = 50")]),
        (
            "a resource without work",
            &[(
                "[[resource]]\nname = \"R\"",
                "[[resource]]\nname = \"M4\"\nprototype = \"machine\"\n[[resource]]\nname = \"R\"",
            )],
        ),
        (
            "a station of nobody",
            &[("station = \"robot\", task = \"load m1\"", "station = \"robto\", task = \"load m1\"")],
        ),
    ];
    insta::assert_snapshot!(check(C1, cases, true));
}

#[test]
fn all_at_once() {
    let text = edited(
        C1,
        &[
            ("\"machine\"", "\"machin\""),
            ("capacity = 6", "capacity = 0"),
            ("\"M2.load\"", "\"M2.store\""),
            ("resource = \"M1\"", "resource = \"R\""),
            ("\"fifo\"", "\"fiffo\""),
            ("then = \"redo\"", "then = \"forward\""),
            ("name = \"B\"", "nme = \"B\""),
        ],
    );
    let (list, errors, _) = said(&text);
    assert!(errors >= 7, "{list}");
    insta::assert_snapshot!(list);
}

/// A line with stations of other names.
#[test]
fn stations_are_looked_up_in_the_line() {
    let line = linewright_line::TransferLine::default().text();
    let line = linewright_line::parse("line.toml", &line).expect("the shipped line is sound").line;
    let text = edited(C1, &[("station = \"m1\"", "station = \"clamp_1\"")]);
    let problems = parse("cell.toml", &text, Some(&line)).expect_err("it is another line");
    let has = |message: &str| problems.iter().any(|p| p.message.starts_with(message));
    assert!(has("the cell is called `workcell_c1`, its line `transfer_line`"), "{problems:#}");
    assert!(
        has("station `clamp_1` has no input `part_in_clamp`") && has("the line has no station `m2`"),
        "{problems:#}"
    );
    assert!(has("the line has no station `robot`") && !has("the line has no station `clamp_1`"), "{problems:#}");
}

fn line_of(text: &str) -> linewright_line::Line {
    linewright_line::parse("line.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

#[test]
fn the_shipped_cells_are_sound_beside_their_lines() {
    for (cell, line) in [(C1, C1_LINE), (ASSEMBLY, ASSEMBLY_LINE)] {
        let line = linewright_line::parse("line.toml", line).unwrap_or_else(|problems| panic!("{problems:#}"));
        assert_eq!(line.warnings, []);
        let parsed = parse("cell.toml", cell, Some(&line.line)).unwrap_or_else(|problems| panic!("{problems:#}"));
        assert_eq!(parsed.warnings, []);
    }
}

/// What the orders name is looked up in the line.
#[test]
fn orders_fit_the_tasks_of_the_line() {
    let line = line_of(C1_LINE);
    let said = |edits: &[(&str, &str)]| -> Vec<String> {
        let problems = match parse("cell.toml", &edited(C1, edits), Some(&line)) {
            Ok(parsed) => parsed.warnings,
            Err(problems) => problems.into_vec(),
        };
        let hint = |problem: &linewright_text::Problem| problem.hint.clone().unwrap_or_default();
        problems.iter().map(|p| format!("{}:{} {} ({})", p.line, p.column, p.message, hint(p))).collect()
    };
    insta::assert_snapshot!(
        [
            said(&[("task = \"load m1\"", "task = \"lod m1\"")]),
            said(&[("task = \"load m1\", parameters = { slot", "task = \"load m1\", parameters = { slt")]),
            said(&[("task = \"load m1\", parameters = { slot = \"ST.position\" }", "task = \"load m1\"")]),
            said(&[("slot = \"ST.position\"", "slot = 8")]),
            said(&[("program = 4", "program = 9")]),
            said(&[("capacity = 6", "capacity = 8")]),
            said(&[("station = \"m1\", task = \"clamp\"", "station = \"m1\", task = \"clmp\"")]),
            // All at once.
            said(&[("task = \"load m1\"", "task = \"lod m1\""), ("task = \"release\"", "task = \"relase\"")]),
        ]
        .iter()
        .map(|problems| problems.join("\n"))
        .collect::<Vec<_>>()
        .join("\n\n")
    );
}

#[test]
fn a_station_that_does_not_work_on_order_gets_none_and_one_that_does_should() {
    let line = include_str!("../../../launch-config/lines/transfer-line/line.toml").replacen(
        "transfer_line",
        "workcell_c1",
        1,
    );
    let text = edited(C1, &[("station = \"robot\", task = \"load m1\"", "station = \"clamp_1\", task = \"load m1\"")]);
    let problems = parse("cell.toml", &text, Some(&line_of(&line))).expect_err("it is another line");
    let has = |words: &str| problems.iter().any(|problem| problem.message.contains(words));
    assert!(has("station `clamp_1` does not work on order"), "{problems:#}");

    let line = C1_LINE
        .replacen("name = \"robot\"", "name = \"other\"", 1)
        .replace("station = \"robot\"", "station = \"other\"");
    let line = line_of(&line.replace("\"robot.", "\"other."));
    let problems = parse("cell.toml", C1, Some(&line)).expect_err("there is no robot");
    let has = |words: &str| problems.iter().any(|problem| problem.message.contains(words));
    assert!(has("nothing is ordered of station `other`") && has("the line has no station `robot`"), "{problems:#}");
}
