//! `linewright run --cycles N`: the automatic cycle, on one bus and on two, in many processes and in few.
//!
//! ```text
//!   transfer  lift lift lift lift advance lower lower lower lower ············ return ·········· lift …
//!   clamp_1   ······································· close ·························· open
//!   mill_1    ··············································· rapid decel feed rapid reset
//! ```

use serde_json::Value;

use crate::support::chart::{RETURN, starts_follow_the_chart};
use crate::support::eye::{Seen, Start};
use crate::support::rig::{OWN_BUS, Rig, line};

/// In every cycle the bar runs back while the mill works.
fn bar_and_mill_overlap(starts: &[Start], cycles: usize) {
    let together = |start: &&Start| {
        let mill_beside = start.beside.iter().any(|what| what.starts_with("mill_1"));
        let bar_beside = start.beside.iter().any(|what| what == RETURN);
        (start.what == RETURN && mill_beside) || (start.what == "mill_1: rapid_advance" && bar_beside)
    };
    assert_eq!(starts.iter().filter(together).count(), cycles, "{starts:?}");
}

fn stands_at_home(seen: &Seen) {
    assert_eq!(seen.energised(), [""; 0]);
    for (station, switch) in [
        ("transfer", "LS_vertical_0"),
        ("transfer", "LS_horizontal_0"),
        ("clamp_1", "LS_open"),
        ("mill_1", "LS_main_0"),
    ] {
        assert!(seen.input(station, switch), "{station} {switch}");
    }
}

fn report_is_of(report: &Value, cycles: usize) {
    assert_eq!(report["line"], "transfer_line");
    assert_eq!(report["cycles"], cycles);
    assert_eq!(report["mode"], "home");
    assert_eq!(report["conflicts_seen"], Value::Array(Vec::new()));
    assert_eq!(report["restarts"], 0);
    assert!(report.get("error").is_none(), "{report}");
    let times = report["cycle_time_s"].as_array().expect("a list");
    assert!(times.len() == cycles && times.iter().all(|time| time.as_f64().is_some_and(|t| t > 0.0)), "{times:?}");
    for (station, operations) in [("transfer", 10), ("clamp_1", 2), ("mill_1", 5)] {
        let station = &report["stations"][station];
        assert_eq!((&station["cycles"], &station["faults"]), (&cycles.into(), &0.into()), "{report}");
        let listed = station["operations"].as_object().expect("an object");
        assert_eq!(listed.len(), operations);
        for (name, operation) in listed {
            assert_eq!(operation["count"], cycles, "{name}");
            assert!(operation["duration_s"].as_f64().is_some_and(|duration| duration > 0.0), "{name}: {operation}");
        }
    }
}

fn run_cycles(text: &str, cycles: usize, options: &[&str]) -> Rig {
    let mut rig = Rig::new(text);
    let number = cycles.to_string();
    let mut all = vec!["--cycles", &number];
    all.extend(options);
    rig.start(&all);
    let (code, report) = rig.ended();
    assert_eq!(code, 0, "{report}");
    report_is_of(&report, cycles);
    {
        let seen = rig.eye.seen();
        assert_eq!(seen.conflicts(), [""; 0]);
        starts_follow_the_chart(seen.starts(), cycles);
        bar_and_mill_overlap(seen.starts(), cycles);
        stands_at_home(&seen);
        for operation in &rig.plan.operations {
            let times = i32::try_from(cycles).expect("few");
            assert_eq!(seen.arrivals(&operation.station, &operation.name), times, "{operation:?}");
        }
        assert!(seen.frames() > 100);
    }
    assert!(rig.processes().is_empty(), "nothing is left: {:?}", rig.processes());
    rig
}

#[test]
fn cycles_follow_the_chart_without_a_conflict() {
    let rig = run_cycles(&line(0.3), 3, &[]);
    reports_what_was_done(&rig, 3);
}

/// The coordinator's database has every motion, the cycle times and what stations waited for.
fn reports_what_was_done(rig: &Rig, cycles: usize) {
    let dir = rig.state().join("tables");
    let recording = rig.state().join("line.mcap");
    let picture = rig.state().join("line.svg");
    let [dir, recording, picture] = [&dir, &recording, &picture].map(|path| path.to_str().expect("a name"));
    let reported = rig.reported(&["--json", "--csv", dir, "--mcap", recording, "--gantt", picture]);
    let reported: Value = serde_json::from_str(&reported).expect("JSON");
    let number = |of: &Value, name: &str| of[name].as_f64().unwrap_or_else(|| panic!("{name}: {of}"));
    assert_eq!(reported["cycles"]["time_s"]["count"], cycles, "{reported}");
    let produced = number(&reported, "produced_s");
    let stations = reported["stations"].as_array().expect("a list");
    for (station, operations) in stations.iter().zip([10, 2, 5]) {
        let seen = number(station, "motions") + number(station, "unseen");
        assert_eq!(seen, (operations * cycles) as f64, "{station}");
        let waits = station["waits"].as_array().expect("a list");
        let waited: f64 = waits.iter().map(|wait| number(wait, "total_s")).sum();
        let all = number(station, "busy_s") + waited + number(station, "other_s");
        assert!((all - produced).abs() < 1e-3, "{station} of {produced} s");
        assert_eq!((&station["stopped"], &station["faults"]), (&0.into(), &0.into()), "{station}");
    }
    let waits = stations[1]["waits"].as_array().expect("a list");
    assert!(waits.iter().any(|wait| wait["why"].as_str().is_some_and(|why| why.contains("transfer"))), "{reported}");
    let stops = reported["stops"].as_array().expect("a list");
    assert!(
        stops.iter().all(|stop| !["alarm", "emergency stop"].contains(&stop["kind"].as_str().unwrap())),
        "{reported}"
    );
    let rows = reported["chart"]["rows"].as_array().expect("a chart");
    assert_eq!(rows.len(), 17);
    assert!(rows.iter().all(|row| row["planned_s"].is_array() && row["measured_s"][0].is_array()), "{reported}");
    for figure in reported["figures"]["list"].as_array().expect("a list") {
        let (name, value) = (figure["name"].as_str().unwrap(), &figure["value"]);
        match name {
            "effectiveness" | "utilization efficiency" => {
                assert!(value.as_f64().is_some_and(|share| share > 0.3 && share <= 1.0), "{figure}");
            }
            _ => assert!(value.is_null() && figure["left_out"].is_string(), "{figure}"),
        }
    }
    let motions = std::fs::read_to_string(rig.state().join("tables/motion.csv")).expect("a table");
    assert_eq!(motions.lines().count(), 1 + 17 * cycles, "{motions}");
    assert!(std::fs::read_to_string(picture).expect("a picture").matches("planned ").count() >= 17);
    let text = rig.reported(&["--chart", "--planned-busy", "1", "--rejected", "1"]);
    for part in ["cycles have ended", "OEE index", "while producing", "▀ planned", "waited"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(text.lines().any(|line| line.starts_with("quality ratio") && line.ends_with("66.7 %")), "{text}");
}

#[test]
fn all_stations_in_one_process_and_one_with_a_bus_of_its_own_run_the_same() {
    let bus = format!("name = \"mill_1\"\nbus = \"{OWN_BUS}\"\n");
    let text = line(0.3).replacen("name = \"mill_1\"\n", &bus, 1);
    assert!(text.contains(OWN_BUS));
    let rig = run_cycles(&text, 1, &["--stations-per-process", "3"]);
    let log = rig.log("transfer+clamp_1+mill_1");
    assert!(["transfer", "clamp_1", "mill_1"].iter().all(|name| log.contains(name)), "one log, of one process");
    assert!(log.contains(OWN_BUS), "it drives its devices itself");
}

/// An observer that never complains proves nothing: without the arrow that keeps the clamp open, it does.
#[test]
fn a_line_with_an_arrow_missing_is_seen_to_reach_its_conflict() {
    let arrow = "[[arrow]]\nfrom = \"transfer: 4th lower\"\nto = \"clamp_1: advance clamp\"\nlag = 0\n";
    let text = line(0.3);
    let (before, after) = text.split_once(arrow).expect("the arrow");
    let after = after.split_once('\n').expect("its modes").1;
    let mut rig = Rig::new(&format!("{before}{after}"));
    rig.start(&["--cycles", "1", "--patience", "5", "--unchecked"]);
    let (code, report) = rig.ended();
    assert_eq!(code, 1, "{report}");
    let by_run = report["conflicts_seen"].as_array().expect("a list");
    assert!(by_run.iter().any(|text| text.as_str().is_some_and(|t| t.contains("off its rest"))), "{report}");
    let seen = rig.eye.seen();
    assert!(seen.conflicts().iter().any(|text| text.contains("off its rest")), "{:?}", seen.conflicts());
}
