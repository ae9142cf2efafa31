//! Parameters of the shipped line and cell, and their tables in the documentation.

use linewright_coordinator_shell::parameters::{OF_THE_COORDINATOR, coordinator_parameters, names};
use linewright_line::{Line, StationId};
use linewright_parameters::{Declaration, ParameterChange, ParameterSet, ParameterType, ParameterValue};
use linewright_station_shell::parameters::{OF_EVERY_NODE, OF_STATIONS, station_parameters};

fn line(text: &str) -> Line {
    linewright_line::parse("line.toml", text).expect("a sound description").line
}

fn transfer_line() -> Line {
    line(include_str!("../../../launch-config/lines/transfer-line/line.toml"))
}

fn kind(declared: &Declaration) -> &'static str {
    match declared.domain.kind() {
        ParameterType::Bool => "bool",
        ParameterType::Integer => "integer",
        ParameterType::Double => "double",
        _ => "string",
    }
}

fn row(declared: &Declaration) -> String {
    let Declaration { name, domain, change, description } = declared;
    let place = match change {
        ParameterChange::Live => "**while the node runs**".to_owned(),
        ParameterChange::AtStart(place) => format!("at the start, {place}"),
        ParameterChange::Elsewhere(place) => (*place).to_owned(),
    };
    let values = match domain.to_string() {
        values if values.is_empty() => "any".to_owned(),
        values => values,
    };
    format!("| `{name}` | {} | {values} | {place} | {description} |\n", kind(declared))
}

#[test]
fn the_documentation_has_each_parameter_as_it_is_declared() {
    let documents = include_str!("../../../docs/ros.md");
    let head = "| parameter | type | values | set | |\n|---|---|---|---|---|\n";
    for (about, table) in
        [("every node", &OF_EVERY_NODE[..]), ("stations", &OF_STATIONS[..]), ("coordinator", &OF_THE_COORDINATOR[..])]
    {
        let rows: String = table.iter().map(|declared| row(declared)).collect();
        assert!(documents.contains(&format!("{head}{rows}\n")), "docs/ros.md, {about}:\n{head}{rows}");
    }
}

/// What a check rests on: how old a thing may be, how long a mode is in force, which bus and which orders.
#[test]
fn nothing_that_a_check_rests_on_is_set_while_a_node_runs() {
    let line = transfer_line();
    let live = |set: &ParameterSet| {
        set.iter()
            .filter(|(declared, _)| !declared.is_read_only())
            .map(|(declared, _)| declared.name)
            .collect::<Vec<_>>()
    };
    let coordinator = coordinator_parameters(&line, None, "info", "vcan0", None);
    assert_eq!(live(&coordinator), ["diagnostics_period_s", "log_level", "mode_text_period_s"]);
    for station in line.station_ids() {
        let station = station_parameters(&line, station, "info");
        assert!(live(&station).iter().all(|name| ["diagnostics_period_s", "log_level"].contains(name)));
    }
    let mut set = coordinator;
    for name in ["timing.refresh_ms", "timing.stale_ms", "timing.lease_ms", "timing.heartbeat_timeout_ms"] {
        let refused = set.set(name, &ParameterValue::Integer(60_000)).expect_err("it is refused").to_string();
        let key = name.trim_start_matches("timing.");
        assert!(refused.ends_with(&format!("it is set by {key} in [timing] of the line's description")), "{refused}");
    }
}

#[test]
fn a_node_shows_what_it_was_started_with() {
    let line = transfer_line();
    let set = station_parameters(&line, StationId::at(0), "warn");
    assert_eq!(
        (set.text("log_level"), set.get("timing.stale_ms")),
        (Some("warn"), Some(&ParameterValue::Integer(250)))
    );
    let cell_line = line_of_cell();
    let cell = linewright_cell::parse(
        "cell.toml",
        include_str!("../../../launch-config/lines/workcell-c1/cell.toml"),
        Some(&cell_line),
    );
    let cell = cell.expect("a sound description").cell;
    let set = coordinator_parameters(&cell_line, Some(&cell), "info", "can3", Some(30));
    assert_eq!(
        (set.text("can_interface_name"), set.get("retention_days")),
        (Some("can3"), Some(&ParameterValue::Integer(30)))
    );
    assert_eq!(set.double("dispatch.look_ahead_s"), Some(cell.dispatch.look_ahead.as_secs_f64()));
    let known = names();
    assert!(
        set.iter().all(|(declared, value)| known.contains(&declared.name) && value.kind() == declared.domain.kind())
    );
    // A first value that is refused when it is set again could not be loaded from a dump.
    let same = |(declared, value): (&Declaration, &ParameterValue)| set.clone().set(declared.name, value) == Ok(false);
    assert!(set.iter().all(same));
}

fn line_of_cell() -> Line {
    line(include_str!("../../../launch-config/lines/workcell-c1/line.toml"))
}
