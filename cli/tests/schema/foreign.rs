//! The schemas in `docs/schema`, evaluated by the Python package `jsonschema`, against the project's own readers.
//!
//! Descriptions that the reader accepts must be valid; descriptions with a misspelt key, a value of another type, a missing
//! required key or a number out of range ([`mutants`]) must be invalid. Without the package the tests print SKIPPED.

use std::collections::BTreeSet;
use std::io::Write;
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use super::mutants::{self, Change, DescriptionMutant};
use super::{schema, shipped};

/// Standard input: schemas by name, and a list of [name, description]. Standard output: for each description null, or the
/// first validation error.
const SCRIPT: &str = r#"
import json, sys
from jsonschema import Draft7Validator
asked = json.load(sys.stdin)
for schema in asked["schemas"].values():
    Draft7Validator.check_schema(schema)
known = {name: Draft7Validator(schema) for name, schema in asked["schemas"].items()}
errors = (next(known[name].iter_errors(description), None) for name, description in asked["descriptions"])
json.dump([error and error.message[:200] for error in errors], sys.stdout)
"#;

/// For each (schema, description) the first validation error; `None` without the package.
fn judged(descriptions: &[(&str, &Value)]) -> Option<Vec<Option<String>>> {
    let python = std::env::var("LINEWRIGHT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let has = Command::new(&python).args(["-c", "import jsonschema"]).stderr(Stdio::null()).status();
    if !has.is_ok_and(|status| status.success()) {
        println!("SKIPPED: no Python with jsonschema here (pip install jsonschema; LINEWRIGHT_PYTHON)");
        return None;
    }
    let parsed = |of| serde_json::from_str::<Value>(&schema(of)).expect("it is JSON");
    let asked = json!({
        "schemas": { "line": parsed("line"), "cell": parsed("cell"), "scenario": parsed("scenario") }, "descriptions": descriptions,
    });
    let mut child = Command::new(&python)
        .args(["-c", SCRIPT])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("there is a Python");
    child.stdin.take().expect("a pipe").write_all(asked.to_string().as_bytes()).expect("it reads");
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success(), "{output:?}");
    Some(serde_json::from_slice(&output.stdout).expect("a list"))
}

/// The reader's errors: message, and label of the marked text.
fn read(of: &str, text: &str) -> Vec<(String, String)> {
    let problems = match of {
        "line" => linewright_line::parse("line.toml", text).err(),
        "scenario" => {
            let cell = linewright_cell::parse("cell.toml", C1, None).expect("the shipped cell is sound").cell;
            linewright_simulation::cell::CellScenario::parse(&cell, "scenario.toml", text).err()
        }
        _ => linewright_cell::parse("cell.toml", text, None).err(),
    };
    let problems = problems.iter().flat_map(|problems| problems.iter());
    problems
        .filter(|problem| !problem.is_warning)
        .map(|p| (p.message.clone(), p.label.clone().unwrap_or_default()))
        .collect()
}

const CELL: &str = include_str!("../../../model/line/tests/descriptions/cell.toml");
const TASK_DRIVEN: &str = include_str!("../../../model/line/tests/descriptions/task_driven.toml");
const DRIVES: &str = include_str!("../../../model/line/tests/descriptions/drives.toml");
const C1: &str = include_str!("../../../launch-config/lines/workcell-c1/cell.toml");
const PRODUCTION: &str = include_str!("../../../launch-config/lines/workcell-c1/scenarios/production.toml");
const ASSEMBLY: &str = include_str!("../../../launch-config/lines/assembly-cell/cell.toml");

/// Every key that none of the descriptions above has.
const REST: &str = r#"
[timing]
refresh_ms = 20
stale_ms = 100
lease_ms = 200
heartbeat_ms = 20
heartbeat_timeout_ms = 100
sync_ms = 10

[console]
estop = { input = "estop", pressed = "off" }
lamps = { auto = "A", hand = "H", manual = "M", fault = "F" }
reset = "reset"

[[device]]
name = "gauge"
station = "feeder"
[device.dbc]
file = "gauge.dbc"
[[device.dbc.receive]]
message = "GaugeState"
timeout_ms = 100
counter = "Alive"
checksum = { signal = "Check", kind = "crc8" }
inputs = [
    { input = "high", signal = "Pressure", above = 5.0, hysteresis = 0.2 },
    { input = "low", signal = "Pressure", below = 1 },
    { input = "fault", signal = "Mode", equals = 3 },
    { input = "bit", signal = "Mode", bit = 2 },
]
[[device.dbc.send]]
message = "GaugeCommand"
every_ms = 20
lets_go_after_ms = 60
counter = "Count"
checksum = { signal = "Check" }
outputs = [{ output = "pump", signal = "Setpoint", on = 6.5, off = 0.0 }]
set = [{ signal = "Valve", value = 2 }]

[[device]]
name = "analogue"
station = "feeder"
node = 9
file = "analogue.eds"
identity = { type = 0x30191, vendor = 0x123, product = 1, revision = 0x10000, serial = 7 }
settings = [{ object = "6206:01", type = "u8", value = 255 }]
without_error_values = "a relay"
transmission = { inputs = 2, outputs = 255 }
on_emergency = "fault"
when_lost = "report"
analogue_inputs = [{ channel = 1, unit = "bar", factor = 0.01, offset = 1, least = 0, most = 10, broken = "wire", inputs = [
    { input = "above", above = 5.0, hysteresis = 0.2 },
    { input = "below", below = 1.0 },
], simulated = { output = "pump", on = 2, off = 1, lag_ms = 20 } }]
analogue_outputs = [{ channel = 2, rest = 0.5, outputs = [{ output = "soft", value = 3.5 }] }]
"#;

/// Descriptions as JSON values. The last one has every remaining key; its names refer to nothing, so no reader accepts it.
fn samples() -> Vec<(&'static str, Value)> {
    let head = "name = \"rest\"\nbuttons = []\n";
    let texts = [
        ("line", CELL),
        ("line", TASK_DRIVEN),
        ("line", DRIVES),
        ("cell", C1),
        ("cell", ASSEMBLY),
        ("scenario", PRODUCTION),
    ];
    let sound = texts.map(|(of, text)| {
        assert!(read(of, text).is_empty());
        (of, mutants::value(text))
    });
    sound.into_iter().chain([("line", mutants::value(&format!("{head}{REST}")))]).collect()
}

#[test]
fn what_the_readers_take_the_schemas_take() {
    let shipped: Vec<(&str, Value)> = shipped()
        .into_iter()
        .map(|(of, file)| (of, mutants::value(&std::fs::read_to_string(file).expect("a description"))))
        .chain(samples())
        .collect();
    let descriptions: Vec<(&str, &Value)> = shipped.iter().map(|(of, value)| (*of, value)).collect();
    let Some(found) = judged(&descriptions) else { return };
    assert!(found.iter().all(Option::is_none), "{found:?}");
}

/// Whether an error reports a missing required key. The buttons of a hand type are required by a rule, not by the schema.
fn is_missed_by_the_reader(message: &str, label: &str) -> bool {
    label.starts_with("no `") && label.ends_with("` here") && !message.starts_with("hand type")
}

#[test]
fn what_is_misspelt_of_the_wrong_type_or_missing_the_schemas_refuse() {
    let samples = samples();
    let mut mutants: Vec<(&str, DescriptionMutant)> = Vec::new();
    for of in ["line", "cell", "scenario"] {
        let mut seen = BTreeSet::new();
        for (_, sample) in samples.iter().filter(|(it, _)| *it == of) {
            mutants.extend(mutants::of(sample, &mut seen).into_iter().map(|mutant| (of, mutant)));
        }
    }
    println!("{} descriptions", mutants.len());
    assert!(mutants.len() > 1500, "{}", mutants.len());
    let descriptions: Vec<(&str, &Value)> = mutants.iter().map(|(of, mutant)| (*of, &mutant.description)).collect();
    let Some(found) = judged(&descriptions) else { return };
    let mut wrong = Vec::new();
    for ((of, mutant), refused) in mutants.iter().zip(&found) {
        let errors = read(of, &mutants::text(&mutant.description));
        let must = match mutant.change {
            Change::Misspelt | Change::WrongType => true,
            Change::LeftOut => errors.iter().any(|(message, label)| is_missed_by_the_reader(message, label)),
            Change::Number => false,
        };
        if errors.is_empty() && refused.is_some() || must && refused.is_none() {
            wrong.push(format!("{}: the reader says {errors:?}, the schema {refused:?}", mutant.what));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), mutants.len(), wrong.join("\n"));
}

#[test]
fn what_is_out_of_range_the_schemas_refuse() {
    let cases = [
        ("line", CELL, "duration_s = 0.5", "duration_s = 0"),
        ("line", CELL, "duration_s = 0.5", "duration_s = 86401"),
        ("line", CELL, "from = 0, to = 100", "from = 0, to = 2e6"),
        ("line", CELL, "type = 6", "type = 7"),
        ("line", CELL, "node = 1", "node = 0"),
        ("line", CELL, "node = 1", "node = 127"),
        ("line", CELL, ", until = \"retract\"", ""),
        ("line", CELL, "module = \"R\"", "module = \"r\""),
        ("line", CELL, "from = \"feeder: push\"", "from = \"push\""),
        ("line", DRIVES, "units_per_mm = 1000", "units_per_mm = 0"),
        ("line", TASK_DRIVEN, "waits_code = ", "waits_code = 1000#"),
        ("cell", C1, "wip_max = ", "wip_max = 0#"),
        ("cell", C1, "prototype = \"machine\"", "prototype = \"machin\""),
        ("cell", C1, "retries = ", "retries = 101#"),
        ("cell", C1, "then = \"redo\"", "then = \"again\""),
        ("scenario", PRODUCTION, "replications = 10", "replications = 0"),
        ("scenario", PRODUCTION, "every_s = 240", "every_s = 0"),
        ("scenario", PRODUCTION, "distribution = \"weibull\"", "distribution = \"weibul\""),
        ("scenario", PRODUCTION, "clock = \"operating\"", "clock = \"clock\""),
    ];
    let changed = cases.map(|(of, text, from, to)| {
        assert!(text.contains(from), "nothing to replace: {from}");
        (of, mutants::value(&text.replacen(from, to, 1)))
    });
    let descriptions: Vec<(&str, &Value)> = changed.iter().map(|(of, value)| (*of, value)).collect();
    let Some(found) = judged(&descriptions) else { return };
    let taken: Vec<_> = cases.iter().zip(&found).filter(|(_, refused)| refused.is_none()).collect();
    assert!(taken.is_empty(), "{taken:?}");
}
