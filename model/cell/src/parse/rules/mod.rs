//! Rules of a description beyond being readable: one named function per rule, one file per subject.
//!
//! Every rule reads the whole draft and reports on its own; where a part is missing because it could not be read or
//! resolved, a rule passes over it in silence, since the reason has been reported already.

mod apart;
mod dispatch;
mod durations;
mod exceptions;
mod handshakes;
mod orders;
mod plans;
mod resources;
mod rests;
mod syncs;
mod tasks;
mod ways;
mod whole;

pub(super) use durations::charted_time;
pub(super) use ways::{Offsets, offsets, transport};

use linewright_text::Report;

use super::draft::DraftCell;
use crate::routes::Routes;

/// Applies every rule; returns the spots that can be reached, if they could be computed.
pub(super) fn check(draft: &DraftCell<'_>, report: &mut Report) -> Option<Routes> {
    whole::the_line_is_the_same(draft, report);
    whole::cell_has_resources(draft, report);
    whole::cell_has_parts(draft, report);
    whole::parts_come_and_go(draft, report);
    whole::stores_hold_what_is_let_in(draft, report);
    for resource in &draft.resources {
        resources::capacity_is_possible(resource, report);
        resources::presence_has_a_station(resource, report);
        resources::presence_is_an_input(draft, resource, report);
        resources::part_sensors_are_looked_at(draft, resource, report);
    }
    resources::stations_belong_to_one(draft, report);
    resources::stations_exist(draft, report);
    for activity in &draft.activities {
        syncs::one_part_is_moved(draft, activity, report);
        syncs::source_and_target_differ(draft, activity, report);
        syncs::one_carries(draft, activity, report);
        orders::each_station_gets_one(activity, report);
        orders::orders_are_for_stations_of_the_activity(draft, activity, report);
        orders::limits_are_known_and_exceed_times(draft, activity, report);
        orders::parameters_are_there(draft, activity, report);
    }
    orders::stations_exist(draft, report);
    tasks::orders_fit_their_tasks(draft, report);
    apart::tasks_that_reach_alike_are_kept_apart(draft, report);
    draft.activities.iter().for_each(|activity| durations::times_are_those_of_the_charts(draft, activity, report));
    draft.activities.iter().for_each(|activity| durations::charted_limits_leave_room(draft, activity, report));
    durations::works_have_times(draft, report);
    rests::machines_come_from_rest_to_rest(draft, report);
    for part in draft.parts.iter().filter(|part| part.variant.is_none()) {
        plans::part_has_steps(part, report);
        plans::steps_have_resources_that_work(draft, part, report);
        plans::nothing_is_listed_twice(draft, part, report);
        plans::steps_are_led_to(part, report);
        plans::parts_stay_after_work(draft, part, report);
    }
    plans::stages_can_be_numbered(draft, report);
    dispatch::rules_exist_once(draft, report);
    dispatch::schedule_is_not_alone(draft, report);
    dispatch::patience_outlasts_activities(draft, report);
    for exception in &draft.exceptions {
        exceptions::answers_differ(exception, report);
        exceptions::strategies_fit(exception, report);
        exceptions::retries_are_allowed(exception, report);
        exceptions::tells_what_is_known(exception, report);
        exceptions::somebody_answers(exception, report);
        exceptions::code_can_occur(exception, report);
        exceptions::whoever_resets_answers(exception, report);
    }
    let routes = ways::routes(draft)?;
    let (variants, described): (Vec<_>, Vec<_>) =
        draft.parts.iter().enumerate().partition(|(_, part)| part.variant.is_some());
    described.into_iter().for_each(|part| ways::plans_can_be_done(draft, part, &routes, report));
    // Errors of a plan are errors of its variants.
    for (at, part) in variants.into_iter().filter(|_| !report.has_errors()).collect::<Vec<_>>() {
        plans::nothing_is_listed_twice(draft, part, report);
        plans::parts_stay_after_work(draft, part, report);
        ways::plans_can_be_done(draft, (at, part), &routes, report);
    }
    if !report.has_errors() {
        ways::resources_are_used(draft, &routes, report);
        handshakes::activities_can_complete(draft, report);
    }
    Some(routes)
}
