//! Rules of a description beyond being readable: one named function per rule, one file per subject.
//!
//! Every rule reads the whole draft and reports on its own; where a part is missing because it could not be read or
//! resolved, a rule passes over it in silence, since the reason has been reported already.

mod analogue;
mod arrows;
mod causality;
mod conflicts;
mod console;
mod devices;
mod drives;
mod endless;
mod frames;
mod hand;
mod handling;
mod modbus;
mod motion;
mod operations;
mod recovery;
mod setups;
mod signals;
mod stations;
pub(super) mod steps;
mod sync;
mod tasks;
mod timing;

pub(super) use devices::node_id;
pub(super) use motion::wrong_homes;
pub(super) use operations::{same_motion, same_place};

use linewright_text::Report;

use super::draft::DraftLine;
use crate::StationId;

/// Applies every rule.
pub(super) fn check(draft: &DraftLine<'_>, report: &mut Report) {
    timing::limits_exceed_their_periods(draft, report);
    stations::line_has_stations(draft, report);
    devices::node_ids_are_usable(draft, report);
    devices::node_ids_are_unique_on_a_bus(draft, report);
    devices::devices_carry_something(draft, report);
    devices::comments_are_of_signals(draft, report);
    devices::own_buses_are_not_shared(draft, report);
    drives::check(draft, report);
    endless::drives_go_to_places(draft, report);
    setups::check(draft, report);
    sync::check(draft, report);
    frames::check(draft, report);
    modbus::check(draft, report);
    analogue::check(draft, report);
    let stale = draft.raw.timing.stale.as_ref().map_or(crate::Timing::default().stale, |stale| stale.value);
    for (nth, station) in draft.stations.iter().enumerate() {
        let id = StationId::at(nth);
        stations::station_has_operations(station, report);
        stations::panel_is_complete(station, report);
        stations::bus_is_an_interface(station, report);
        for operation in &station.operations {
            operations::motion_goes_somewhere(operation, report);
            operations::watchdog_outlasts_duration(station, operation, report);
            operations::watchdog_is_in_seconds(station, operation, report);
            operations::module_has_its_recovery(station, operation, report);
            operations::duration_is_in_seconds(operation, report);
        }
        if station.is_task_driven() {
            tasks::check(station, report);
            hand::tasks_are_sequences(station, report);
            hand::buttons_tell_tasks_apart(station, report);
        } else {
            tasks::nothing_of_tasks(station, report);
            steps::groups_are_allowed(station, report);
            steps::groups_move_different_axes(station, report);
            motion::motions_chain(station, report);
            hand::sequences_end(station, report);
        }
        endless::check(draft, id, stale, report);
        motion::axes_are_moved(station, report);
        recovery::paths_are_reversible_and_earlier(station, report);
        recovery::paths_lead_home(station, report);
        hand::modules_suit_their_types(station, report);
        hand::groups_share_one_entry(station, report);
        hand::sequences_continue(station, report);
        hand::sequences_begin(station, report);
        hand::next_is_the_following_forward(station, report);
        operations::one_motion_takes_one_time(station, report);
        signals::inputs_mean_one_thing(station, draft.indexes_of(id), report);
        signals::outputs_mean_one_thing(station, draft.indexes_of(id), report);
    }
    handling::check(draft, report);
    console::console_exists(draft, report);
    console::buttons_are_used(draft, report);
    console::signals_mean_one_thing(draft, report);
    tasks::task_driven_stations_are_not_joined(draft, report);
    arrows::arrows_join_stations(draft, report);
    arrows::arrows_are_unique(draft, report);
    arrows::arrows_hold_at_home(draft, report);
    causality::no_operation_waits_for_itself(draft, report);
    conflicts::conflicts_join_stations(draft, report);
    tasks::tasks_are_in_conflict_with_tasks(draft, report);
    conflicts::conflict_spans_have_an_order(draft, report);
    conflicts::conflicts_do_not_hold_at_home(draft, report);
    conflicts::conflicts_have_buttons_of_their_own(draft, report);
}
