//! The ROS 2 parameters of a station's node, and those that every node of a line has.
//!
//! A parameter may be changed while the node runs only if no check rests on it: a request may come from any node, arrives in any mode,
//! and is not agreed with the other nodes. Ages, leases and heartbeats follow from the description, which all nodes compare by its
//! fingerprint, so they are read-only.

use std::time::Duration;

use linewright_line::{DeviceBus, Line, StationId, TaskOrderSource};
use linewright_parameters::{Declaration, ParameterChange, ParameterDomain, ParameterSet, ParameterValue};

const fn integer_ms(name: &'static str, place: &'static str, from: i64, description: &'static str) -> Declaration {
    Declaration {
        name,
        domain: ParameterDomain::Integer { from, to: 60_000 },
        change: ParameterChange::Elsewhere(place),
        description,
    }
}

/// Log level of the process. The first value is `RUST_LOG` where that variable decides.
pub const LOG_LEVEL: Declaration = Declaration {
    name: "log_level",
    domain: ParameterDomain::OneOf(&["debug", "info", "warn", "error", "fatal"]),
    change: ParameterChange::Live,
    description: "Log level of the process: of several nodes in one, the level that was set last is in force.",
};
/// As every node of ROS 2 has it.
pub const USE_SIM_TIME: Declaration = Declaration {
    name: "use_sim_time",
    domain: ParameterDomain::Bool,
    change: ParameterChange::Elsewhere("the program: a line runs by the clocks of its machines"),
    description: "Whether time comes from the topic /clock.",
};
/// [`linewright_line::Timing::refresh`].
pub const REFRESH: Declaration = integer_ms(
    "timing.refresh_ms",
    "refresh_ms in [timing] of the line's description",
    1,
    "Period of the whole state when nothing changes, in ms.",
);
/// [`linewright_line::Timing::stale`].
pub const STALE: Declaration = integer_ms(
    "timing.stale_ms",
    "stale_ms in [timing] of the line's description",
    1,
    "Age from which a state, an image or a held button is unknown, in ms.",
);
/// [`linewright_line::Timing::lease`].
pub const LEASE: Declaration = integer_ms(
    "timing.lease_ms",
    "lease_ms in [timing] of the line's description",
    1,
    "Time after which a mode that is not repeated has run out, in ms.",
);
/// [`linewright_line::Timing::heartbeat`].
pub const HEARTBEAT: Declaration = integer_ms(
    "timing.heartbeat_ms",
    "heartbeat_ms in [timing] of the line's description",
    1,
    "Period of the heartbeat of CAN devices and managers, in ms.",
);
/// [`linewright_line::Timing::heartbeat_timeout`].
pub const HEARTBEAT_TIMEOUT: Declaration = integer_ms(
    "timing.heartbeat_timeout_ms",
    "heartbeat_timeout_ms in [timing] of the line's description",
    1,
    "Time without a heartbeat after which a CAN device is lost, in ms.",
);
/// [`linewright_line::Timing::sync`].
pub const SYNC: Declaration = integer_ms(
    "timing.sync_ms",
    "sync_ms in [timing] of the line's description",
    0,
    "Period of SYNC, in ms; 0 if none is sent.",
);
/// Period of the diagnostics, in s.
pub const DIAGNOSTICS_PERIOD: Declaration = Declaration {
    name: "diagnostics_period_s",
    domain: ParameterDomain::Double { from: 0.5, to: 10.0 },
    change: ParameterChange::Live,
    description: "Period of the messages on /diagnostics when nothing changes, in s.",
};
/// Bus of a station's own.
pub const OWN_CAN_INTERFACE: Declaration = Declaration {
    name: "can_interface_name",
    domain: ParameterDomain::Text,
    change: ParameterChange::Elsewhere("bus of the station in the line's description"),
    description: "CAN interface of the station's own bus.",
};
/// [`linewright_line::Station::order_source`].
pub const ORDERS: Declaration = Declaration {
    name: "orders",
    domain: ParameterDomain::OneOf(&["coordinator", "any"]),
    change: ParameterChange::Elsewhere("orders of the station in the line's description"),
    description: "Senders that task orders are taken from.",
};

/// The declared parameters of every node, in the order of the documentation.
pub const OF_EVERY_NODE: [&Declaration; 9] =
    [&LOG_LEVEL, &USE_SIM_TIME, &DIAGNOSTICS_PERIOD, &REFRESH, &STALE, &LEASE, &HEARTBEAT, &HEARTBEAT_TIMEOUT, &SYNC];

/// Further parameters of a station: of one with a bus of its own the first, of a task-driven one the second.
pub const OF_STATIONS: [&Declaration; 2] = [&OWN_CAN_INTERFACE, &ORDERS];

/// First value of [`DIAGNOSTICS_PERIOD`].
pub const DIAGNOSTICS_EVERY_S: f64 = 1.0;

/// The parameters that every node has, with their first values.
pub fn common(line: &Line, log_level: &str) -> Vec<(&'static Declaration, ParameterValue)> {
    let ms = |time: Duration| ParameterValue::Integer(i64::try_from(time.as_millis()).unwrap_or(i64::MAX));
    let timing = line.timing;
    vec![
        (&LOG_LEVEL, ParameterValue::Text(log_level.to_owned())),
        (&USE_SIM_TIME, ParameterValue::Bool(false)),
        (&DIAGNOSTICS_PERIOD, ParameterValue::Double(DIAGNOSTICS_EVERY_S)),
        (&REFRESH, ms(timing.refresh)),
        (&STALE, ms(timing.stale)),
        (&LEASE, ms(timing.lease)),
        (&HEARTBEAT, ms(timing.heartbeat)),
        (&HEARTBEAT_TIMEOUT, ms(timing.heartbeat_timeout)),
        (&SYNC, ms(timing.sync.unwrap_or_default())),
    ]
}

/// The parameters of a station's node, with their first values. `log_level`: that of the process.
pub fn station_parameters(line: &Line, station: StationId, log_level: &str) -> ParameterSet {
    let mut all = common(line, log_level);
    let station = line.station(station);
    if let DeviceBus::Own(interface) = &station.bus {
        all.push((&OWN_CAN_INTERFACE, ParameterValue::Text(interface.clone())));
    }
    if station.is_task_driven() {
        let word = match station.order_source {
            TaskOrderSource::Coordinator => "coordinator",
            TaskOrderSource::Any => "any",
        };
        all.push((&ORDERS, ParameterValue::Text(word.to_owned())));
    }
    ParameterSet::new(all)
}
