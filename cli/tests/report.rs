//! `linewright simulate --record` and `linewright report`, as a user meets them: what was written is what is reported.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;

use serde_json::Value;

use crate::support::command::{Scratch, json, linewright, shipped, text};

fn file(scratch: &Scratch, name: &str) -> PathBuf {
    scratch.path(name).into()
}

/// A simulation of workcell C1 that is written into a database; with its own output.
fn recorded(scratch: &Scratch, args: &[&str]) -> (PathBuf, Value) {
    let (cell, db) = (shipped().with_file_name("workcell-c1"), file(scratch, "cell.db"));
    let fixed = ["simulate", cell.to_str().unwrap(), "--json", "--record", db.to_str().unwrap()];
    let output = linewright(&[&fixed[..], args].concat());
    assert!(output.status.success(), "{output:?}");
    (db, json(&output))
}

fn report(db: &Path, args: &[&str]) -> Output {
    linewright(&[&["report", db.to_str().unwrap()], args].concat())
}

/// The error text: lines may be broken anywhere.
fn unbroken(output: &Output) -> String {
    text(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ").replace("│ ", "")
}

const PARTS: [&str; 6] = ["--parts", "A=4,B=3", "--variation", "20", "--seed", "5"];

fn list<'v>(of: &'v Value, name: &str) -> &'v Vec<Value> {
    of[name].as_array().unwrap_or_else(|| panic!("no {name}: {of}"))
}

fn number(of: &Value, name: &str) -> f64 {
    of[name].as_f64().unwrap_or_else(|| panic!("no {name}: {of}"))
}

#[test]
fn what_is_reported_of_a_database_is_what_the_simulation_said() {
    let scratch = Scratch::new();
    let (db, simulated) = recorded(&scratch, &PARTS);
    let reported = json(&report(&db, &["--json"]));
    let makespan = number(&simulated, "makespan_s");
    assert_eq!((&reported["cell"], number(&reported, "observed_s")), (&"workcell_c1".into(), makespan));
    assert_eq!(reported["missing"], Value::Array(Vec::new()));
    // Lead times by nearest rank, from the list of parts.
    let parts = list(&simulated, "parts");
    let mut leads: Vec<f64> = parts.iter().map(|part| number(part, "done_s") - number(part, "entered_s")).collect();
    leads.sort_by(f64::total_cmp);
    let lead = &reported["parts"]["lead_s"];
    assert_eq!((number(lead, "count"), leads.len()), (7.0, 7));
    for (name, expected) in
        [("least", leads[0]), ("median", leads[3]), ("p90", leads[6]), ("p99", leads[6]), ("most", leads[6])]
    {
        assert!((number(lead, name) - expected).abs() < 1e-6, "{name}: {lead}, not {expected}");
    }
    // Utilisation of each resource, from the list of activities.
    for (said, other) in list(&reported, "resources").iter().zip(list(&simulated, "resources")) {
        assert_eq!((&said["name"], &said["taken_most"]), (&other["name"], &other["taken_most"]));
        let machine = format!("{}.process", said["name"].as_str().unwrap());
        let works =
            list(&simulated, "activities").iter().filter(|of| of["activity"].as_str().unwrap().starts_with(&machine));
        let worked: f64 = works.clone().map(|of| number(of, "end_s") - number(of, "start_s")).sum();
        assert!((number(said, "actual_s") - worked).abs() < 1e-6, "{said}");
        assert_eq!(number(said, "parts"), works.count() as f64);
    }
    let of = &reported["effectiveness"];
    assert_eq!((number(of, "availability"), number(of, "quality")), (1.0, 1.0));
    let performance = number(of, "performance");
    assert!((0.8..1.25).contains(&performance) && performance != 1.0, "{of}");
    let shown = report(&db, &[]);
    let shown = text(&shown.stdout);
    assert!(shown.starts_with(&format!("Workcell C1, 0.000 s to {makespan:.3} s\n")), "{shown}");
    assert!(shown.contains("7 parts have left, 0 are inside, 0 were lost; 0 activities have failed"), "{shown}");
}

/// Cut into two spans, what is reported of them adds up.
#[test]
fn a_span_is_reported_by_itself() {
    let scratch = Scratch::new();
    let (db, _) = recorded(&scratch, &PARTS);
    let [whole, early, late] =
        [&[][..], &["--to", "150"], &["--from", "150"]].map(|args| json(&report(&db, &[&["--json"], args].concat())));
    let sum = |name: &str| number(&early, name) + number(&late, name);
    assert!((sum("observed_s") - number(&whole, "observed_s")).abs() < 1e-6);
    for (index, of) in list(&whole, "resources").iter().enumerate() {
        for name in ["busy_s", "work_s", "nominal_s", "parts"] {
            let sum: f64 = [&early, &late].map(|span| number(&list(span, "resources")[index], name)).iter().sum();
            assert!((sum - number(of, name)).abs() < 1e-6, "{name} of {of}");
        }
    }
    assert!(number(&early["parts"], "inside") > 0.0);
    let refused = |args: &[&str]| {
        let output = report(&db, args);
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        unbroken(&output)
    };
    assert!(refused(&["--from", "100000"]).contains("nothing lies from 100000.000 s to"));
    assert!(refused(&["--from", "2026-11-22"]).contains("is not a number of seconds"));
}

type Row = BTreeMap<String, String>;

fn rows(file: &Path) -> Vec<Row> {
    csv::Reader::from_path(file).unwrap().deserialize().collect::<Result<_, _>>().unwrap()
}

/// The tables, read back, agree with the simulation; and a recount over the events agrees with the report.
#[test]
fn tables_are_read_back() {
    let scratch = Scratch::new();
    let (db, simulated) = recorded(&scratch, &PARTS);
    let dir = file(&scratch, "tables");
    let reported = json(&report(&db, &["--json", "--csv", dir.to_str().unwrap()]));
    let activities = rows(&dir.join("activity.csv"));
    let timed: Vec<&Row> = activities.iter().filter(|row| row["duration_s"] != "0.0").collect();
    let expected = list(&simulated, "activities");
    assert_eq!(timed.len(), expected.len());
    for (row, of) in timed.iter().zip(expected) {
        assert_eq!((row["mode"].as_str(), &row["part"]), (of["activity"].as_str().unwrap(), &of["part"].to_string()));
        assert_eq!(row["start_us"].parse::<u64>().unwrap(), (number(of, "start_s") * 1e6).round() as u64);
        assert_eq!(row["end_us"].parse::<u64>().unwrap(), (number(of, "end_s") * 1e6).round() as u64);
    }
    let parts = rows(&dir.join("part.csv"));
    for (row, part) in
        parts.iter().map(|row| (&row["part"], row)).collect::<BTreeMap<_, _>>().values().zip(list(&simulated, "parts"))
    {
        assert_eq!(
            (&row["part"], row["product"].as_str()),
            (&part["part"].to_string(), part["type"].as_str().unwrap())
        );
    }
    let orders = std::fs::read_to_string(dir.join("order.csv")).unwrap();
    assert!(orders.starts_with("id,name,product,quantity,state,") && orders.lines().count() == 1, "{orders}");
    // Events: numbered as in the log, and each start has its end.
    let events = rows(&dir.join("event.csv"));
    let numbers = events.iter().map(|row| row["log"].parse::<usize>().unwrap());
    assert!(numbers.eq(1..=events.len()));
    let mut open: BTreeMap<&str, (&str, u64)> = BTreeMap::new();
    let mut busy: BTreeMap<String, u64> = BTreeMap::new();
    for row in &events {
        let at = row["at_us"].parse::<u64>().unwrap();
        match row["kind"].as_str() {
            "started" => _ = open.insert(&row["firing"], (&row["activity"], at)),
            "ended" => {
                let (activity, began) = open.remove(row["firing"].as_str()).expect("it has started");
                let machine = activity.split(".process").next().filter(|_| activity.contains(".process"));
                // A machine works, or is loaded, or unloaded: `load M1<A.new>`, `M1.process<A.new>`.
                let of = machine.or_else(|| activity.split(['<', ' ']).nth(1)).filter(|name| name.starts_with('M'));
                of.into_iter().for_each(|of| *busy.entry(of.to_owned()).or_default() += at - began);
            }
            _ => (),
        }
    }
    assert!(open.is_empty());
    for of in list(&reported, "resources").iter().filter(|of| of["prototype"] == "machine") {
        let said = (number(of, "busy_s") * 1e6).round() as u64;
        assert_eq!(said, busy[of["name"].as_str().unwrap()], "{of}");
    }
}

#[test]
fn what_cannot_be_reported_is_said_clearly() {
    let scratch = Scratch::new();
    let (db, _) = recorded(&scratch, &[]);
    let cell = shipped().with_file_name("workcell-c1");
    let again = linewright(&["simulate", cell.to_str().unwrap(), "--record", db.to_str().unwrap()]);
    assert!(text(&again.stderr).contains("exists already; choose another name"), "{again:?}");
    let refused = |path: &Path| {
        let output = report(path, &[]);
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        unbroken(&output)
    };
    assert!(refused(&file(&scratch, "none.db")).contains("give the state directory of a run"));
    assert!(refused(&cell.join("cell.toml")).contains("is no database of a cell"));
    let given = "has neither cell.db nor line.db; give the state directory of a run (`run --state-dir DIR`)";
    assert!(refused(&cell).contains(given));
    let for_lines = report(&db, &["--cycle", "3"]);
    assert!(unbroken(&for_lines).contains("are for lines; this database is about a cell"), "{for_lines:?}");
    let whole = std::fs::read(&db).unwrap();
    std::fs::write(&db, &whole[..whole.len() / 2]).unwrap();
    assert!(refused(&db).contains("is damaged"));
}

/// Content of a recording: of each topic the times, in nanoseconds, and messages.
fn messages(file: &Path) -> BTreeMap<String, Vec<(u64, Value)>> {
    let bytes = std::fs::read(file).unwrap();
    let mut all: BTreeMap<String, Vec<(u64, Value)>> = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().expect("each has one");
        assert_eq!((schema.encoding.as_str(), message.channel.message_encoding.as_str()), ("jsonschema", "json"));
        let schema: Value = serde_json::from_slice(&schema.data).unwrap();
        let data: Value = serde_json::from_slice(&message.data).unwrap();
        let known = schema["properties"].as_object().unwrap();
        assert!(data.as_object().unwrap().keys().eq(known.keys()), "{data} has what its schema has");
        all.entry(message.channel.topic.clone()).or_default().push((message.log_time, data));
    }
    all
}

/// A recording, read back: how long each resource is busy follows from its messages, as the report has it.
#[test]
fn a_recording_is_read_back() {
    let scratch = Scratch::new();
    let (db, _) = recorded(&scratch, &PARTS);
    for span in [&[][..], &["--from", "100", "--to", "200"]] {
        let recording = file(&scratch, "cell.mcap");
        let args = [&["--json", "--mcap", recording.to_str().unwrap()], span].concat();
        let reported = json(&report(&db, &args));
        let all = messages(&recording);
        let end = ((number(&reported, "observed_s") + span.get(1).map_or(0.0, |_| 100.0)) * 1e9).round() as u64;
        for of in list(&reported, "resources") {
            let said = &all[&format!("/resources/{}", of["name"].as_str().unwrap())];
            assert!(said.is_sorted_by_key(|(at, _)| *at));
            let ends = said.iter().skip(1).map(|(at, _)| *at).chain([end]);
            let busy = said.iter().zip(ends).filter(|((_, of), _)| of["state"] == "busy");
            let busy: u64 = busy.map(|((at, _), to)| to - at).sum();
            assert_eq!(busy, (number(of, "busy_s") * 1e9).round() as u64, "{of}");
        }
        let last = &all["/cell"].last().unwrap().1;
        assert_eq!((&last["inside"], &last["left"]), (&reported["parts"]["inside"], &reported["parts"]["left"]));
        assert_eq!(all["/log"].len(), all["/events"].len());
        if span.is_empty() {
            let numbers = all["/events"].iter().map(|(_, event)| event["log"].as_u64().unwrap());
            assert!(numbers.eq(1..=all["/events"].len() as u64));
        }
        read_by_others(&recording, &all);
    }
}

const READER: &str = "import sys, json
from mcap.reader import make_reader
count = {}
with open(sys.argv[1], 'rb') as file:
    last = 0
    for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
        json.loads(schema.data), json.loads(message.data)
        assert message.log_time >= last
        last = message.log_time
        count[channel.topic] = count.get(channel.topic, 0) + 1
print(json.dumps(count))
";

/// The Python package `mcap` finds the same by the index, with all checksums right.
fn read_by_others(recording: &Path, expected: &BTreeMap<String, Vec<(u64, Value)>>) {
    let python = std::env::var("LINEWRIGHT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let has =
        std::process::Command::new(&python).args(["-c", "import mcap"]).stderr(std::process::Stdio::null()).status();
    if !has.is_ok_and(|status| status.success()) {
        println!("SKIPPED: no Python with mcap here (pip install mcap; LINEWRIGHT_PYTHON)");
        return;
    }
    let read = std::process::Command::new(&python).args(["-c", READER]).arg(recording).output().unwrap();
    assert!(read.status.success(), "{read:?}");
    let count: BTreeMap<String, usize> = serde_json::from_slice(&read.stdout).unwrap();
    assert!(
        count.iter().map(|(topic, count)| (topic, *count)).eq(expected.iter().map(|(topic, of)| (topic, of.len())))
    );
}

/// Whether every tag that is opened is closed.
fn is_well_formed(svg: &str) -> bool {
    let mut open = Vec::new();
    for tag in svg.split('<').skip(1).map(|rest| rest.split('>').next().unwrap_or_default()) {
        match tag.strip_prefix('/') {
            Some(name) if open.pop() != Some(name) => return false,
            Some(_) => (),
            None if tag.ends_with('/') => (),
            None => open.extend(tag.split(' ').next()),
        }
    }
    open.is_empty()
}

/// Bars as long as the activities, in the picture and in text.
#[test]
fn a_gantt_chart_has_a_bar_for_each_activity() {
    let scratch = Scratch::new();
    let (db, simulated) = recorded(&scratch, &PARTS);
    let picture = file(&scratch, "cell.svg");
    let output = report(&db, &["--chart", "--gantt", picture.to_str().unwrap()]);
    let svg = std::fs::read_to_string(&picture).unwrap();
    for of in list(&simulated, "activities") {
        let name = of["activity"].as_str().unwrap().replace('<', "&lt;").replace('>', "&gt;");
        let (from, to) = (number(of, "start_s"), number(of, "end_s"));
        let title = format!("<title>{name}, part {}: {from:.3} – {to:.3} s</title>", of["part"]);
        assert_eq!(svg.matches(&title).count(), 1, "{title}");
    }
    assert!(is_well_formed(&svg), "{svg}");
    let shown = text(&output.stdout);
    for name in ["M1", "M2", "M3", "R "] {
        let row = shown.lines().find(|line| line.starts_with(&format!("{name} │"))).expect("its row");
        assert_eq!(row.chars().filter(|glyph| *glyph == '│').count(), 2, "{row}");
        assert!(row.contains('█'), "{row}");
    }
    assert!(!shown.contains("ST │"), "a store does nothing");
}

/// Nothing is later than planned where everything takes its time: 17.5 s is the best there is (seed 000, L2029-2035, by an
/// exhaustive search).
#[test]
fn the_plan_stands_above_what_was_done() {
    let scratch = Scratch::new();
    let (cell, db) = (shipped().with_file_name("assembly-cell"), file(&scratch, "cell.db"));
    let args = ["simulate", cell.to_str().unwrap(), "--planned", "--json", "--record", db.to_str().unwrap()];
    let simulated = json(&linewright(&args));
    assert_eq!(number(&simulated, "makespan_s"), 17.5);
    let (dir, picture) = (file(&scratch, "tables"), file(&scratch, "cell.svg"));
    let output = report(&db, &["--chart", "--csv", dir.to_str().unwrap(), "--gantt", picture.to_str().unwrap()]);
    let activities = rows(&dir.join("activity.csv"));
    let timed: Vec<&Row> = activities.iter().filter(|row| row["duration_s"] != "0.0").collect();
    assert_eq!(timed.len(), 3 * 3);
    for row in &timed {
        assert_eq!((&row["planned_start"], &row["planned_end"]), (&row["start"], &row["end"]), "{row:?}");
    }
    let svg = std::fs::read_to_string(&picture).unwrap();
    assert_eq!(svg.matches(": planned ").count(), 3 + 3 * 2, "work of three, and loading and unloading each");
    let shown = text(&output.stdout);
    let of = shown.lines().position(|line| line.starts_with("robot_1 │")).expect("its rows");
    let [plan, done] = [of, of + 1].map(|row| shown.lines().nth(row).expect("a row").split_once('│').unwrap().1);
    assert!(plan.contains('▒') && plan.replace('▒', "█") == done, "{shown}");
}
