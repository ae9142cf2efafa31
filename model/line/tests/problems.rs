//! Every rule, broken once: edits of the descriptions here, and the problems they raise, in `problems/*.cases`.

use linewright_line::{Problem, Timing, TransferLine, parse, schema};
use linewright_text::{Shape, Usual};

use crate::{analogue, modbus, types};

const CELL: &str = include_str!("descriptions/cell.toml");

/// The text of a base that the cases name.
fn base(name: &str) -> String {
    match name {
        "cell" => CELL.to_owned(),
        "task_driven" => include_str!("descriptions/task_driven.toml").to_owned(),
        "endless" => include_str!("../../../examples/rotary-table.toml").to_owned(),
        "driven" => include_str!("../../../examples/driven-table.toml").to_owned(),
        "drives" => include_str!("descriptions/drives.toml").to_owned(),
        "analogue" => analogue::with("", ""),
        "modbus" => modbus::line(modbus::DEVICE),
        "types" => types::TYPES.to_owned(),
        "shipped" => TransferLine::default().text(),
        other => panic!("no base is called `{other}`"),
    }
}

/// All problems, errors and warnings alike.
fn problems(text: &str) -> Vec<Problem> {
    match parse("line.toml", text) {
        Ok(parsed) => parsed.warnings,
        Err(problems) => problems.into_vec(),
    }
}

#[track_caller]
fn check(file: &str) {
    linewright_cases::check(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/problems"), file, base, problems);
}

#[test]
fn rules_of_a_line() {
    check("cell.cases");
}

#[test]
fn rules_of_tasks_and_material_flow() {
    check("task_driven.cases");
}

#[test]
fn rules_of_endless_axes() {
    check("endless.cases");
}

#[test]
fn rules_of_drives_and_settings() {
    check("drives.cases");
}

#[test]
fn rules_of_analogue_channels() {
    check("analogue.cases");
}

#[test]
fn rules_of_devices_in_modbus() {
    check("modbus.cases");
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
fn a_line_needs_a_station() {
    let found = problems("[[arrow]]\nfrom = \"a: b\"\nto = \"c: d\"\n");
    assert!(found.iter().any(|p| p.message == "a line needs at least one station"), "{found:?}");
}

/// The base with the name of each station in its header, as written by `name`.
fn with_names_in_headers(name: impl Fn(&str) -> String) -> String {
    let mut blocks = CELL.split("[[station]]\n");
    let mut text = blocks.next().expect("a split has a first part").to_owned();
    for block in blocks {
        let (first, rest) = block.split_once('\n').expect("a station has keys");
        let at = name(first.trim_start_matches("name = ").trim_matches('"'));
        text += &format!(
            "[station.{at}]\n{}",
            rest.replace("[[station.operation]]", &format!("[[station.{at}.operation]]"))
        );
    }
    text
}

#[test]
fn stations_with_their_names_in_headers_are_read_and_are_one_error() {
    let errors = |text: &str| -> Vec<(String, Option<String>)> {
        let all = problems(text).into_iter().filter(|problem| !problem.is_warning);
        all.map(|problem| (problem.message, problem.hint)).collect()
    };
    let found = errors(&with_names_in_headers(str::to_owned));
    let [(message, hint)] = &found[..] else { panic!("{found:#?}") };
    assert_eq!(message, "`station` must be a list of tables");
    let advice = "write each one under a header `[[station]]`, with two brackets, and below it `name = \"…\"`";
    assert_eq!(hint.as_deref(), Some(advice));
    // The same with a blank in one name, which is a mistake of its own; the uses of it are none.
    let blank = with_names_in_headers(|name| name.replace("feeder", "\"my feeder\""));
    let found: Vec<String> = errors(&blank).into_iter().map(|(message, _)| message).collect();
    assert_eq!(found, ["`station` must be a list of tables", "`my feeder` cannot be the name of a station"]);
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
fn a_console_is_not_needed_and_a_contact_opens_or_closes() {
    let without_console = CELL.split("[console]").next().expect("a split has a first part");
    let parsed = parse("cell.toml", without_console).expect("a console is not needed");
    assert!(parsed.warnings.iter().any(|w| w.message == "the line has no `[console]`" && (w.line, w.column) == (1, 1)));
    for (estop, pressed) in [
        ("\"ES\"", true),
        ("{ input = \"ES\", pressed = \"on\" }", true),
        ("{ input = \"ES\", pressed = \"off\" }", false),
    ] {
        let text = CELL.replacen("estop = \"ES\"", &format!("estop = {estop}"), 1);
        let line = parse("cell.toml", &text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
        assert_eq!(line.console.estop.expect("it has one").pressed, pressed, "{estop}");
    }
}

#[test]
fn rules_of_types() {
    check("types.cases");
}

/// The default times of the documented keys.
#[test]
fn the_usual_times_are_those_of_a_timing() {
    let table = |shape: Shape| if let Shape::Table(_, keys) = shape { keys } else { panic!("{shape:?}") };
    let timing = table(schema()).into_iter().find(|property| property.key == "timing").expect("it has times");
    let described: Vec<_> = table(timing.shape).into_iter().map(|property| property.usual).collect();
    let usual = Timing::default();
    let times = [usual.refresh, usual.stale, usual.lease, usual.heartbeat, usual.heartbeat_timeout];
    let times = times.map(|time| Some(Usual::Whole(time.as_millis() as i64)));
    assert_eq!(described, [&times[..], &[None]].concat());
}
