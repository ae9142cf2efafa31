//! The ROS 2 parameters of the coordinator's node. What may be changed while it runs, and why no more, is in
//! [`linewright_station_shell::parameters`].

use std::time::Duration;

use linewright_cell::Cell;
use linewright_line::Line;
use linewright_parameters::{Declaration, ParameterChange, ParameterDomain, ParameterSet, ParameterValue};
use linewright_station_shell::parameters::{OF_EVERY_NODE, OF_STATIONS, common};

/// A day, in s.
const DAY_S: f64 = 86_400.0;

const fn of_cell(
    name: &'static str,
    place: &'static str,
    domain: ParameterDomain,
    description: &'static str,
) -> Declaration {
    Declaration { name, domain, change: ParameterChange::Elsewhere(place), description }
}

/// Bus of the line.
pub const CAN_INTERFACE: Declaration = Declaration {
    name: "can_interface_name",
    domain: ParameterDomain::Text,
    change: ParameterChange::AtStart("by --bus, or as this parameter"),
    description: "CAN interface of the line's bus.",
};
/// Period of the mode as text, in s.
pub const MODE_TEXT_PERIOD: Declaration = Declaration {
    name: "mode_text_period_s",
    domain: ParameterDomain::Double { from: 0.2, to: 60.0 },
    change: ParameterChange::Live,
    description: "Period of mode_text when nothing changes, in s.",
};
/// Days that the database keeps.
pub const RETENTION: Declaration = Declaration {
    name: "retention_days",
    domain: ParameterDomain::Integer { from: 0, to: 36_500 },
    change: ParameterChange::Elsewhere("--retention"),
    description: "Days for which the database keeps what happens; 0 for everything.",
};
/// [`linewright_cell::CellTimeouts::wip_max`].
pub const WIP_MAX: Declaration = of_cell(
    "cell.wip_max",
    "wip_max in [cell] of the cell's description",
    ParameterDomain::Integer { from: 1, to: 10_000 },
    "Most parts in the cell at once.",
);
/// [`linewright_cell::Dispatch::look_ahead`].
pub const LOOK_AHEAD: Declaration = of_cell(
    "dispatch.look_ahead_s",
    "look_ahead_s in [dispatch] of the cell's description",
    ParameterDomain::Double { from: 0.0, to: DAY_S },
    "Time of the simulation before decisions, in s; 0 for none.",
);
/// [`linewright_cell::Dispatch::patience`].
pub const PATIENCE: Declaration = of_cell(
    "dispatch.patience_s",
    "patience_s in [dispatch] of the cell's description",
    ParameterDomain::Double { from: 0.0, to: DAY_S },
    "Time of waiting after which a part that could move goes first, in s.",
);
/// [`linewright_cell::Dispatch::window`].
pub const WINDOW: Declaration = of_cell(
    "dispatch.window_s",
    "window_s in [dispatch] of the cell's description",
    ParameterDomain::Double { from: 0.0, to: DAY_S },
    "Permitted difference from the planned start, in s.",
);

/// Further parameters of the coordinator, in the order of the documentation; the last four where there is a cell.
pub const OF_THE_COORDINATOR: [&Declaration; 7] =
    [&CAN_INTERFACE, &MODE_TEXT_PERIOD, &RETENTION, &WIP_MAX, &LOOK_AHEAD, &PATIENCE, &WINDOW];

/// First value of [`MODE_TEXT_PERIOD`].
pub const MODE_TEXT_EVERY_S: f64 = 1.0;

/// Names of the parameters of any node of a line: what a file sets for several nodes may be a parameter of some of them.
pub fn names() -> Vec<&'static str> {
    let all = OF_EVERY_NODE.iter().chain(&OF_STATIONS).chain(&OF_THE_COORDINATOR);
    all.map(|declared| declared.name).collect()
}

/// The parameters of the coordinator's node, with their first values. `log_level`: that of the process; `retention`: days that the database keeps.
pub fn coordinator_parameters(
    line: &Line,
    cell: Option<&Cell>,
    log_level: &str,
    interface: &str,
    retention: Option<u32>,
) -> ParameterSet {
    let seconds = |time: Duration| ParameterValue::Double(time.as_secs_f64());
    let mut all = common(line, log_level);
    all.push((&CAN_INTERFACE, ParameterValue::Text(interface.to_owned())));
    all.push((&MODE_TEXT_PERIOD, ParameterValue::Double(MODE_TEXT_EVERY_S)));
    all.push((&RETENTION, ParameterValue::Integer(retention.map_or(0, i64::from))));
    if let Some(cell) = cell {
        all.push((&WIP_MAX, ParameterValue::Integer(i64::from(cell.limits.wip_max))));
        all.push((&LOOK_AHEAD, seconds(cell.dispatch.look_ahead)));
        all.push((&PATIENCE, seconds(cell.dispatch.patience)));
        all.push((&WINDOW, seconds(cell.dispatch.window)));
    }
    ParameterSet::new(all)
}
