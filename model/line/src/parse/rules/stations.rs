//! A station as a whole.

use linewright_text::{Problem, Report};

use crate::DeviceBus;
use crate::parse::draft::{DraftLine, DraftStation};

/// Longest name of a Linux network interface (`IFNAMSIZ` less the closing zero).
const INTERFACE_MAX: usize = 15;

pub(super) fn line_has_stations(draft: &DraftLine<'_>, report: &mut Report) {
    if draft.stations.is_empty() {
        report.add(Problem::error(0..0, "a line needs at least one station").hint("begin one with `[[station]]`"));
    }
}

pub(super) fn station_has_operations(station: &DraftStation<'_>, report: &mut Report) {
    if station.operations.is_empty() {
        report.add(
            Problem::error(station.place(), format!("station `{}` has no operation", station.name))
                .hint("begin one with `[[station.operation]]` below the station's keys"),
        );
    }
}

pub(super) fn panel_is_complete(station: &DraftStation<'_>, report: &mut Report) {
    let Some(panel) = &station.raw.panel else {
        report.add(
            Problem::warning(station.place(), format!("station `{}` has no panel", station.name))
                .hint("in manual mode it can be operated over ROS topics only"),
        );
        return;
    };
    let keys = [("manual", &panel.manual), ("advance", &panel.advance), ("return", &panel.retract)];
    let missing: Vec<String> =
        keys.iter().filter(|(_, name)| name.is_none()).map(|(key, _)| format!("`{key}`")).collect();
    if !missing.is_empty() {
        report.add(
            Problem::warning(
                station.place(),
                format!("the panel of station `{}` has no {}", station.name, missing.join(", ")),
            )
            .hint("what is missing can be operated over ROS topics only"),
        );
    }
}

pub(super) fn bus_is_an_interface(station: &DraftStation<'_>, report: &mut Report) {
    let (Some(bus), DeviceBus::Own(name)) = (&station.raw.bus, &station.bus) else { return };
    let fits =
        !name.is_empty() && name.len() <= INTERFACE_MAX && name.chars().all(|c| c.is_ascii_graphic() && c != '/');
    if !fits {
        report.add(
            Problem::error(bus.at.clone(), format!("`{}` is not the name of a CAN interface", name.escape_debug()))
                .hint(format!("as `ip link` lists it, e.g. \"can1\"; at most {INTERFACE_MAX} characters")),
        );
    }
}
