//! Every rule, broken once: an edit of `descriptions/cell.toml` and the problem it must raise.
//!
//! `«` in a replacement marks where the problem must point; the mark is taken out before parsing. So a case states
//! message and place together, and stays right when lines move.

use linewright_line::{Problem, parse};

const CELL: &str = include_str!("descriptions/cell.toml");

/// What to replace by what, first occurrence each; the beginning of the message; some words of the hint, or nothing to
/// leave it open.
type Case<'a> = (&'a [(&'a str, &'a str)], &'a str, &'a str);

/// The problems, errors and warnings alike, of the base description after some edits, and where the mark was.
fn edited(edits: &[(&str, &str)]) -> (Vec<Problem>, (usize, usize)) {
    let mut text = CELL.to_owned();
    for (old, new) in edits {
        assert!(text.contains(old), "the base has no {old:?}");
        text = text.replacen(old, new, 1);
    }
    let mark = text.find('«').expect("a case marks a place");
    let before = &text[..mark];
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    let text = text.replace('«', "");
    let problems = match parse("cell.toml", &text) {
        Ok(parsed) => parsed.warnings,
        Err(problems) => problems.into_vec(),
    };
    (problems, (line, column))
}

fn check(cases: &[Case<'_>], is_warning: bool) {
    let mut failures = Vec::new();
    for (edits, message, hint) in cases {
        let (problems, mark) = edited(edits);
        let found = problems.iter().any(|p| {
            p.message.starts_with(message)
                && (p.line, p.column) == mark
                && p.is_warning == is_warning
                && p.hint.as_deref().unwrap_or_default().contains(hint)
        });
        if !found {
            let list: Vec<String> = problems
                .iter()
                .map(|p| format!("  {}:{}: {} ({})", p.line, p.column, p.message, p.hint.as_deref().unwrap_or("-")))
                .collect();
            failures.push(format!("{edits:?}\n wanted {mark:?} {message} ({hint})\n{}", list.join("\n")));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[track_caller]
fn errors(cases: &[Case<'_>]) {
    check(cases, false);
}

#[track_caller]
fn warnings(cases: &[Case<'_>]) {
    check(cases, true);
}

#[test]
fn the_base_is_sound() {
    let parsed = parse("cell.toml", CELL).unwrap_or_else(|problems| panic!("{problems:#}"));
    assert_eq!(parsed.warnings, []);
    let lifter = &parsed.line.stations[2];
    assert_eq!(lifter.steps.iter().map(Vec::len).collect::<Vec<_>>(), [1, 1, 1, 1, 2, 2]);
    assert_eq!(parsed.line.title, "cell", "the name by default");
    assert_eq!(parsed.line.timing.stale.as_millis(), 200);
}

#[test]
fn lines_and_columns_are_counted_in_characters_from_one() {
    let text = "name = \"ok\"\n# größer\n  title = 'é' # ü\nstation = [ { name = \"ä\", nme = 1 } ]\n";
    let problems = parse("f.toml", text).expect_err("much is wrong").into_vec();
    let place = |start: &str| problems.iter().find(|p| p.message.starts_with(start)).map(|p| (p.line, p.column));
    assert_eq!(place("`ä` cannot be"), Some((4, 22)));
    assert_eq!(place("unknown key `nme`"), Some((4, 27)));
}

#[test]
fn keys_and_types() {
    errors(&[
        (&[("name = \"cell\"", "name = «cell")], "this is not TOML", ""),
        (
            &[("buttons", "name = \"x\"\nbuttons"), ("name = \"x\"", "«name = \"x\"")],
            "this is not TOML: duplicate key",
            "",
        ),
        (&[("name = \"cell\"\n", ""), ("# A", "«# A")], "the description needs `name`", ""),
        (&[("stale_ms", "«stale")], "unknown key `stale` in `[timing]`", "did you mean `stale_ms`?"),
        (&[("buttons", "«botons")], "unknown key `botons` in the description", "did you mean `buttons`?"),
        (&[("home = \"pull back\"", "«hme = \"pull back\"")], "unknown key `hme` in a station", "`home`"),
        (&[("[[station]]\n", "«[[station]]\n"), ("home = \"pull back\"", "")], "a station needs `home`", ""),
        (&[("module = \"R\"", "«modul = \"R\"")], "unknown key `modul` in an operation", "`module`"),
        (&[("module = \"R\"", "module = «\"r\"")], "unknown module `r`", "`R` for a reversible"),
        (&[("duration_s = 0.5", "duration_s = «\"0.5\"")], "`duration_s` must be a number of seconds", ""),
        (&[("axis = \"x\", from = 0", "«ax = \"x\", from = 0")], "unknown key `ax` in `moves`", "`axis`"),
        (&[("{ axis = \"x\", from = 0", "«{ from = 0")], "`moves` needs `axis`", ""),
        (&[("actuator = \"Y_push\"", "actuator = «3")], "`actuator` must be text", ""),
        (&[("from = 0, to = 100", "from = 0, to = «2e6")], "`to` is 2000000", "mm"),
        (&[("from = 0, to = 100", "from = 0, to = «nan")], "`to` is NaN", ""),
        (&[("axes = { x = 0.0 }", "axes = { x = «\"\" }")], "`x` must be a number", ""),
        (&[("[timing]", "«[[timing]]")], "`timing` must be a table", ""),
        (&[("[[conflict]]", "«[conflict]")], "`conflict` must be a list of tables", "two brackets"),
        (&[("[\"X_0\", \"X_100\", \"\"", "[\"X_0\", \"X_100\", «7")], "an entry of `inputs` must be text", ""),
        (&[("console = true", "console = «1")], "`console` must be true or false", ""),
        (&[("start = \"P_start\"", "«strat = \"P_start\"")], "unknown key `strat` in `[console]`", "`start`"),
        (&[("{ auto = \"H_auto\"", "{ «atuo = \"H_auto\"")], "unknown key `atuo` in `lamps`", "`auto`"),
    ]);
}

#[test]
fn bounds() {
    let long_list = format!("buttons = «[{}]#", "\"B\",".repeat(33));
    let long_title = format!("name = \"cell\"\ntitle = «\"{}\"", "x".repeat(501));
    let wide = format!("«[{}", "\"\", ".repeat(65));
    let bits: Vec<String> = (0..60).map(|bit| format!("\"I{bit}\"")).collect();
    let more = |n: usize, bits: &str| {
        format!(
            "[[device]]\nname = \"more {n}\"\nstation = \"feeder\"\nnode = {}\ninputs = [{bits}]\n\n[console]",
            20 + n
        )
    };
    let a_lot = [0, 100, 200].map(|from| {
        let bits: Vec<String> = bits.iter().map(|b| b.replace('I', &format!("I{from}_"))).collect();
        more(from / 100, &bits.join(", ").replace("\"I200_3\"", "«\"I200_3\""))
    });
    errors(&[
        (&[("buttons = ", &long_list)], "`buttons` has 33 entries", "at most 32"),
        (&[("name = \"cell\"", &long_title)], "`title` has 501 bytes", "at most 500"),
        (&[("[\"X_0\"", &format!("{wide}\"X_0\""))], "`inputs` has", "at most 64"),
        (
            &[("[console]", &a_lot[0]), ("[console]", &a_lot[1]), ("[console]", &a_lot[2])],
            "more than 128 inputs in one process image",
            "",
        ),
    ]);
}

#[test]
fn names() {
    errors(&[
        (&[("\"cell\"", "«\"Cell\"")], "`Cell` cannot be the name of a line", "lower-case"),
        (&[("name = \"feeder\"", "name = «\"feeder 1\"")], "`feeder 1` cannot be the name of a station", "`title`"),
        (&[("name = \"feeder\"", "name = «\"coordinator\"")], "a station cannot be called `coordinator`", ""),
        (&[("name = \"press\"", "name = «\"feeder\"")], "a second station named `feeder`", ""),
        (&[("name = \"stroke\"", "name = «\"approach\"")], "a second operation of this station named `approach`", ""),
        (&[("name = \"stroke\"", "name = «\"stroke: in\"")], "`stroke: in` cannot name this operation", "without `:`"),
        (&[("{ x = 0.0 }", "{ «\"x y\" = 0.0 }")], "`x y` cannot name this axis", ""),
        (&[("\"B1\", \"B2\"", "\"B1\", «\"B1\"")], "a second button named `B1`", ""),
        (&[("\"B1\", \"B2\"", "\"B1\", «\"B 2\"")], "`B 2` cannot name this button", "without blanks"),
        (&[("name = \"press io\"", "name = «\"feeder io\"")], "a second device named `feeder io`", ""),
        (
            &[("home = \"pull back\"", "home = «\"pul back\"")],
            "unknown operation `pul back`",
            "did you mean `pull back`?",
        ),
        (&[("axis = \"x\"", "axis = «\"zed\"")], "unknown axis `zed`", "known here: `x`"),
        (&[("forward = \"B1\"", "forward = «\"PB\"")], "unknown button `PB`", ""),
        (&[("[\"approach\"]", "[«\"aproach\"]")], "unknown operation `aproach`", "`approach`"),
        (&[("from = \"feeder: push\"", "from = \"«feder: push\"")], "unknown station `feder`", "`feeder`"),
        (&[("from = \"feeder: push\"", "from = \"feeder: «psuh\"")], "unknown operation `psuh`", "`push`"),
        (
            &[("from = \"feeder: push\"", "from = \"feeder: «stroke\"")],
            "unknown operation `stroke`",
            "of station `press`",
        ),
        (&[("from = \"feeder: push\"", "from = «\"push\"")], "`push` names no operation", "station: operation"),
        (&[("station = \"press\", from", "station = «\"pres\", from")], "unknown station `pres`", "`press`"),
        (&[("until = \"retract\"", "until = «\"retrakt\"")], "unknown operation `retrakt`", "`retract`"),
        (&[("station = \"press\"\n", "station = «\"presse\"\n")], "unknown station `presse`", "`press`"),
        (&[("bus = \"can1\"", "bus = «\"can/1\"")], "`can/1` is not the name of a CAN interface", "ip link"),
    ]);
}

#[test]
fn stations() {
    let nothing = "[[arrow]]\nfrom = \"a: b\"\nto = «\"c: d\"\n";
    let problems = parse("f.toml", &nothing.replace('«', "")).expect_err("no station").into_vec();
    assert!(problems.iter().any(|p| p.message == "a line needs at least one station"));
    errors(&[(
        &[("[[arrow]]", "[[station]]\nname = «\"idle\"\nhome = \"x\"\naxes = {}\npanel = {}\n\n[[arrow]]")],
        "station `idle` has no operation",
        "[[station.operation]]",
    )]);
    warnings(&[
        (
            &[
                ("panel = { manual = \"S0\", advance = \"S1\", return = \"S2\" }", ""),
                ("name = \"feeder\"", "name = «\"feeder\""),
            ],
            "station `feeder` has no panel",
            "ROS topics only",
        ),
        (
            &[("advance = \"S1\", return = \"S2\"", ""), ("name = \"feeder\"", "name = «\"feeder\"")],
            "the panel of station `feeder` has no `advance`, `return`",
            "",
        ),
    ]);
}

#[test]
fn operations() {
    errors(&[
        (&[("from = 0, to = 100", "from = 0, to = «0")], "`push` moves from 0 to 0", ""),
        (&[("duration_s = 0.5", "duration_s = «0")], "`duration_s` is 0 seconds", "positive"),
        (&[("duration_s = 0.5", "duration_s = «-1")], "`duration_s` is -1 seconds", ""),
        (&[("duration_s = 0.5", "duration_s = «inf")], "`duration_s` is inf seconds", ""),
        (&[("duration_s = 0.5", "duration_s = «90000")], "`duration_s` is 90000 seconds", "a day"),
        (&[("watchdog_s = 1.0", "watchdog_s = «0.5")], "the watchdog of `push` is 0.5 s", "longer"),
        (&[("watchdog_s = 2.0", "watchdog_s = «0.7")], "the watchdog of the recovery of `pull back`", ""),
        (
            &[
                ("recovery = { actuator = \"Y_pull\", complete = \"X_0\" }\n", ""),
                ("name = \"push\"", "name = «\"push\""),
            ],
            "reversible operation `push` has no `recovery`",
            "which actuator",
        ),
        (
            &[("recovery_path =", "recovery = «{ actuator = \"Y_up\", complete = \"RAM_0\" }\nrecovery_path =")],
            "irreversible operation `stroke` has a `recovery`",
            "`recovery_path",
        ),
        (&[("[\"approach\"]", "«[]")], "irreversible operation `stroke` has no recovery path", ""),
        (
            &[("recovery_path = [\"approach\"]", ""), ("name = \"stroke\"", "name = «\"stroke\"")],
            "irreversible operation `stroke` has no recovery path",
            "before the home operation",
        ),
        (
            &[("hand = { type = 6", "recovery_path = «[\"pull back\"]\nhand = { type = 6")],
            "reversible operation `push` has a `recovery_path`",
            "",
        ),
    ]);
}

#[test]
fn motions() {
    errors(&[
        (&[("from = 0, to = 100", "from = «1, to = 100")], "`push` starts at 1, but at home `x` stands at 0", ""),
        (&[("from = 10, to = 20", "from = «11, to = 20")], "`lift 2` starts at 11, but `lift 1` leaves `y` at 10", ""),
        (
            &[("{ axis = \"x\", from = 100, to = 0 }", "«{ axis = \"x\", from = 100, to = 1 }")],
            "`pull back` leaves `x` at 1, but at home it stands at 0",
            "ends where it began",
        ),
    ]);
    warnings(&[(&[("{ x = 0.0 }", "{ x = 0.0, «z = 0.0 }")], "no operation moves axis `z`", "")]);
}

#[test]
fn side_by_side() {
    errors(&[
        (&[("with = \"grip\"", "with = «\"gripe\"")], "unknown operation `gripe`", "`grip`"),
        (&[("with = \"grip\"", "with = «\"lift 1\"")], "`lift 1` is not listed directly before", "follow each other"),
        (&[("with = \"grip\"", "with = «\"turn\"")], "`turn` is not listed directly before", ""),
        (
            &[("name = \"pull back\"", "name = \"pull back\"\nwith = «\"push\"")],
            "the first operation listed runs by itself",
            "new cycle",
        ),
        (
            &[("name = \"pull back\"", "name = \"pull back\"\nwith = «\"push\"")],
            "the home operation `pull back` runs by itself",
            "",
        ),
        (
            &[
                ("name = \"raise\"", "name = \"raise\"\nwith = \"retract\""),
                ("name = \"retract\"\nmodule = \"R\"", "name = «\"retract\"\nmodule = \"I\""),
            ],
            "irreversible operation `retract` runs side by side",
            "independently",
        ),
        (
            &[("{ axis = \"turn\", from = 0", "«{ axis = \"grip\", from = 0")],
            "`grip` and `turn` run side by side, and both move `grip`",
            "an axis each",
        ),
        (
            &[
                ("complete = \"T_0\" }\nhand = { type", "complete = \"T_0\" }\nhand = «{ type"),
                (
                    "hand = «{ type = 6, forward = \"B6\", back = \"B7\"",
                    "hand = «{ type = 6, forward = \"B6\", back = \"B1\"",
                ),
            ],
            "`turn` runs beside `grip`, but has another hand entry",
            "equal entries",
        ),
    ]);
    let many: String = (1..=9)
        .map(|n| {
            let with =
                if n == 1 { String::new() } else { format!("with = {}\"m1\"\n", if n == 9 { "«" } else { "" }) };
            format!("[[station.operation]]\nname = \"m{n}\"\n{with}\n")
        })
        .collect();
    errors(&[(&[("[[arrow]]", &format!("{many}[[arrow]]"))], "more than 8 operations side by side", "")]);
}

#[test]
fn hand_types() {
    errors(&[
        (&[("type = 6", "type = «7")], "unknown hand type 7", "1 to 6"),
        (
            &[("{ type = 6, forward = \"B1\", back = \"B2\", ", "«{ type = 6, forward = \"B1\", ")],
            "hand type 6 needs `back`",
            "on its own",
        ),
        (
            &[(
                "hand = { type = 6, forward = \"B1\", back = \"B2\", next = \"B2\" }",
                "hand = «{ type = 6, forward = \"B1\", back = \"B2\" }",
            )],
            "hand type 6 needs `next`",
            "",
        ),
        (
            &[("{ type = 1, forward = \"B3\" }", "{ type = 1, forward = \"B3\", back = «\"B1\" }")],
            "hand type 1 has no `back`",
            "never reversed",
        ),
        (
            &[(
                "type = 3, forward = \"B5\", back = \"B4\"",
                "type = 3, forward = \"B5\", back = \"B4\", next = «\"B5\"",
            )],
            "hand type 3 has no `next`",
            "",
        ),
        (
            &[("forward = \"B1\", back = \"B2\"", "forward = \"B1\", back = «\"B1\"")],
            "`B1` runs the operation forward and back",
            "",
        ),
        (
            &[(
                "hand = { type = 1, forward = \"B3\" }\nrecovery_path",
                "hand = «{ type = 3, forward = \"B3\", back = \"B1\" }\nrecovery_path",
            )],
            "irreversible operation `stroke` has hand type 3",
            "1 or 2",
        ),
        (
            &[
                ("hand = { type = 3", "hand = «{ type = 3"),
                (
                    "type = 4, forward = \"B5\", back = \"B4\"",
                    "type = 6, forward = \"B5\", back = \"B4\", next = \"B5\"",
                ),
            ],
            "`lift 1` has hand type 3, but `lift 2` after it has type 6",
            "followed by 4 or 5",
        ),
        (
            &[
                ("hand = { type = 5", "hand = «{ type = 5"),
                (
                    "type = 4, forward = \"B5\", back = \"B4\"",
                    "type = 6, forward = \"B5\", back = \"B4\", next = \"B5\"",
                ),
            ],
            "`lift 3` has hand type 5, but `lift 2` before it has type 6",
            "preceded by 3 or 4",
        ),
        (
            &[(
                "hand = { type = 4, forward = \"B5\", back = \"B4\"",
                "hand = «{ type = 4, forward = \"B5\", back = \"B1\"",
            )],
            "`lift 1` and `lift 2` are one sequence, but have different buttons",
            "",
        ),
        (
            &[(
                "hand = { type = 2, forward = \"B3\", next = \"B3\" }",
                "hand = «{ type = 2, forward = \"B1\", next = \"B3\" }",
            )],
            "`retract` and `raise` are one sequence, but have different buttons",
            "",
        ),
        (
            &[
                ("type = 2, forward = \"B3\", next = \"B3\"", "type = 1, forward = \"B3\""),
                ("name = \"press\"", "name = «\"press\""),
            ],
            "in hand mode the cycle of station `press` never ends",
            "hand type 2",
        ),
        (
            &[("back = \"B4\", next = \"B6\"", "back = \"B4\", next = «\"B7\"")],
            "`next` of `lift 3` does not start `grip`",
            "next = \"B6\"",
        ),
        (
            &[("type = 2, forward = \"B3\", next = \"B3\"", "type = 2, forward = \"B3\", next = «\"B1\"")],
            "`next` of `raise` does not start `approach`",
            "",
        ),
    ]);
}

#[test]
fn recovery_paths() {
    errors(&[
        (&[("[\"approach\"]", "[«\"stroke\"]")], "the recovery path of `stroke` names the operation itself", ""),
        (
            &[("[\"approach\"]", "[\"approach\", «\"raise\"]")],
            "the recovery path of `stroke` names the home operation",
            "always follows",
        ),
        (&[("[\"approach\"]", "[\"approach\", «\"approach\"]")], "`approach` is twice on one recovery path", ""),
        (
            &[("[\"approach\"]", "[\"approach\", «\"retract\"]")],
            "`retract` does not come before `stroke`",
            "since the station left home",
        ),
        (
            &[
                ("[\"approach\"]", "[«\"approach\"]"),
                ("name = \"approach\"\nmodule = \"R\"", "name = \"approach\"\nmodule = \"I\""),
            ],
            "`approach` is irreversible and cannot be taken back",
            "reversible operations",
        ),
        (
            &[(
                "name = \"turn back\"\nwith = \"open\"\nmodule = \"R\"",
                "name = \"turn back\"\nrecovery_path = [«\"grip\"]\nmodule = \"I\"",
            )],
            "`grip` runs side by side with others",
            "one operation at a time",
        ),
        (
            &[("[\"approach\"]", "«[\"retract\"]")],
            "the recovery path of `stroke` leaves `slide` at 80",
            "at home `slide` stands at 0",
        ),
        (
            &[("[\"approach\"]", "«[\"stroke\"]")],
            "the recovery path of `stroke` leaves `slide` where the fault found it",
            "",
        ),
    ]);
}

#[test]
fn signals() {
    errors(&[
        (
            &[("complete = \"X_100\"", "complete = «\"X_10\"")],
            "no device of station `feeder` has an input `X_10`",
            "did you mean",
        ),
        (
            &[("complete = \"X_100\"", "complete = «\"RAM_20\"")],
            "no device of station `feeder` has an input `RAM_20`",
            "station `press` has a signal",
        ),
        (
            &[("actuator = \"Y_push\"", "actuator = «\"valve\"")],
            "no device of station `feeder` has an output `valve`",
            "[[device]]",
        ),
        (&[("actuator = \"Y_push\"", "actuator = «\"X_0\"")], "`X_0` is an input, not an output", ""),
        (&[("complete = \"X_100\"", "complete = «\"Y_push\"")], "`Y_push` is an output, not an input", ""),
        (&[("manual = \"S0\"", "manual = «\"SX\"")], "no device of station `feeder` has an input `SX`", ""),
        (&[("[\"X_0\", \"X_100\", \"\"", "[\"X_0\", \"X_100\", «\"X_0\"")], "`X_0` is bound to two bits", ""),
        (
            &[("[\"Y_push\", \"Y_pull\"]", "[\"Y_push\", \"Y_pull\", «\"X_0\"]")],
            "`X_0` names an input and an output",
            "",
        ),
        (&[("[\"X_0\", \"X_100\", \"\"", "[\"X_0\", \"X_100\", «\"a b\"")], "`a b` cannot name this input", ""),
        (&[("actuator = \"Y_20\"", "actuator = «\"Y_10\"")], "`Y_10` means two things", ""),
        (&[("actuator = \"Y_up\"", "actuator = «\"Y_in\"")], "`Y_in` means two things", ""),
        (&[("complete = \"L_20\"", "complete = «\"L_10\"")], "`L_10` means two things", ""),
        (&[("return = \"S2\"", "return = «\"S1\"")], "`S1` means two things", ""),
        (
            &[("fault = \"F_slide\"", "fault = \"SL_80\""), ("complete = \"SL_80\"", "complete = «\"SL_80\"")],
            "`SL_80` means two things",
            "",
        ),
        (&[("lamp = \"H_slide\"", "lamp = «\"Y_out\"")], "`Y_out` means two things", ""),
        (&[("stop = \"P_stop\"", "stop = «\"P_start\"")], "`P_start` means two things", ""),
        (
            &[("stop = \"P_stop\"", "stop = «\"P_stopp\"")],
            "unknown input of the console's devices: `P_stopp`",
            "`P_stop`",
        ),
        (&[("hand = \"H_hand\"", "hand = «\"H_auto\"")], "`H_auto` means two things", ""),
    ]);
    warnings(&[
        (&[("[\"X_0\", \"X_100\", \"\"", "[\"X_0\", \"X_100\", «\"X_50\"")], "nothing uses `X_50`", "not connected"),
        (&[("[\"Y_push\", \"Y_pull\"]", "[\"Y_push\", \"Y_pull\", «\"Y_more\"]")], "nothing uses `Y_more`", ""),
        (&[("reset = \"P_reset\"", ""), ("\"P_reset\"", "«\"P_reset\"")], "nothing uses `P_reset`", ""),
    ]);
}

#[test]
fn devices() {
    errors(&[
        (&[("node = 1", "node = «0")], "0 is not a node id", "1 to 126"),
        (&[("node = 1", "node = «128")], "128 is not a node id", ""),
        (&[("node = 1", "node = «127")], "node id 127 is the bus manager's own", "1 to 126"),
        (
            &[
                ("node = 1", "node = «2"),
                ("node = «2", "node = 2"),
                ("node = 2\ninputs = [\"X_0\"", "node = «2\ninputs = [\"X_0\""),
            ],
            "two devices with node id 0x02 (2) on the coordinator's bus",
            "",
        ),
        (
            &[(
                "name = \"lifter head\"\nstation = \"lifter\"\nnode = 3",
                "name = \"lifter head\"\nstation = \"lifter\"\nnode = «2",
            )],
            "two devices with node id 0x02 (2) on can1",
            "",
        ),
        (
            &[("console = true", "console = «true\nstation = \"press\"")],
            "a device is a station's or the console's, not both",
            "",
        ),
        (&[("[[device]]", "«[[device]]"), ("console = true\n", "")], "this device belongs to nobody", "console = true"),
    ]);
    warnings(&[
        (
            &[("[console]", "[[device]]\nname = «\"spare\"\nconsole = true\nnode = 9\n\n[console]")],
            "this device has no connected input or output",
            "",
        ),
        (
            &[
                ("home = \"pull back\"", "home = \"pull back\"\nbus = \"can1\""),
                ("home = \"lower\"\nbus = ", "home = \"lower\"\nbus = «"),
            ],
            "stations `feeder` and `lifter` both have bus `can1`",
            "two computers",
        ),
    ]);
}

#[test]
fn console() {
    let without_console = CELL.split("[console]").next().expect("a split has a first part");
    let parsed = parse("cell.toml", without_console).expect("a console is not needed");
    assert!(parsed.warnings.iter().any(|w| w.message == "the line has no `[console]`" && (w.line, w.column) == (1, 1)));
    let contact = |text: &str| {
        let line =
            parse("cell.toml", &CELL.replacen("estop = \"ES\"", text, 1)).unwrap_or_else(|e| panic!("{e:?}")).line;
        line.console.estop.expect("it has one").pressed
    };
    assert!(contact("estop = \"ES\""));
    assert!(contact("estop = { input = \"ES\", pressed = \"on\" }"));
    assert!(!contact("estop = { input = \"ES\", pressed = \"off\" }"));
    errors(&[
        (&[("estop = \"ES\"", "estop = «{ input = \"ES\" }")], "`estop` needs `pressed`", ""),
        (&[("estop = \"ES\"", "estop = «{ pressed = \"off\" }")], "`estop` needs `input`", ""),
        (&[("estop = \"ES\"", "estop = { input = \"ES\", pressed = «\"offf\" }")], "unknown pressed `offf`", "off"),
    ]);
    warnings(&[
        (&[("estop = \"ES\"\n", ""), ("[console]", "«[console]")], "the console has no `estop`", ""),
        (&[("\"B7\"]", "\"B7\", «\"B8\"]")], "no operation uses button `B8`", ""),
        (
            &[("\"B7\"]", "«\"B7\"]"), ("\"B7\", \"P_start\"", "\"P_start\"")],
            "no console device has an input `B7`",
            "ROS topics only",
        ),
    ]);
}

#[test]
fn timing() {
    errors(&[
        (&[("stale_ms = 200", "stale_ms = «79")], "`stale_ms` is 79 ms, but `refresh_ms` is 40 ms", "twice"),
        (
            &[("refresh_ms = 40", "refresh_ms = «300"), ("stale_ms = 200", "stale_ms = 600")],
            "`lease_ms` is 500 ms, but `refresh_ms` is 300 ms",
            "",
        ),
        (
            &[("stale_ms = 200", "heartbeat_ms = «101")],
            "`heartbeat_timeout_ms` is 200 ms, but `heartbeat_ms` is 101 ms",
            "",
        ),
        (&[("refresh_ms = 40", "refresh_ms = «0")], "`refresh_ms` is 0 ms", "between"),
        (&[("refresh_ms = 40", "refresh_ms = «4.5")], "`refresh_ms` must be a whole number of milliseconds", ""),
    ]);
}

#[test]
fn arrows() {
    errors(&[
        (&[("to = \"press: approach\"", "to = \"«feeder: push\"")], "`feeder: push` waits for itself", ""),
        (
            &[("to = \"press: approach\"", "to = \"«feeder: pull back\"")],
            "an arrow within one station",
            "order in which they are listed",
        ),
        (&[("lag = 1", "lag = «-1")], "a lag of -1 cycles", ""),
        (&[("lag = 1", "lag = «9")], "a lag of 9 cycles", "up to 8"),
        (&[("modes = [\"auto\"]", "modes = «[]")], "an arrow that holds in no mode", "for both"),
        (&[("modes = [\"auto\"]", "modes = [«\"hand\"]")], "unknown mode `hand`", "auto and manual alike"),
        (&[("modes = [\"auto\"]", "modes = [\"auto\", «\"auto\"]")], "mode `auto` twice", ""),
        (
            &[(
                "[[conflict]]",
                "[[arrow]]\nfrom = \"«feeder: push\"\nto = \"press: approach\"\nmodes = [\"manual\"]\n\n[[conflict]]",
            )],
            "this arrow has been drawn before",
            "lag",
        ),
        (
            &[("from = \"press: raise\"\nto = \"lifter: lift 1\"", "from = \"«press: raise\"\nto = \"lifter: lower\"")],
            "at home `lifter: lower` is done, but `press: raise` is not",
            "lag = 1",
        ),
        (
            &[("[[arrow]]", "«[[arrow]]"), ("lag = 1", "lag = 0")],
            "a deadlock: each of these waits for the one before it: feeder: push → press: approach → press: raise → feeder: push",
            "lag = 1",
        ),
    ]);
    warnings(&[(&[("lag = 1", "lag = «2")], "a lag of 2 cycles", "ahead")]);
}

#[test]
fn conflicts() {
    errors(&[
        (
            &[(
                "b = { station = \"press\", from = \"approach\", until = \"retract\" }",
                "b = «{ station = \"feeder\", from = \"push\", until = \"push\" }",
            )],
            "a conflict of a station with itself",
            "two stations",
        ),
        (
            &[
                ("[[conflict]]", "«[[conflict]]"),
                ("from = \"push\", until = \"pull back\"", "from = \"pull back\", until = \"push\""),
                ("from = \"approach\", until = \"retract\"", "from = \"raise\", until = \"approach\""),
            ],
            "this conflict holds while the whole line stands at home",
            "completion of `until`",
        ),
    ]);
}
