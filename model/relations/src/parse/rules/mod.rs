//! Whether the tables hold together: one function per rule.
//!
//! The numbers are those of the applicability rules of Richardsson, Andersson and Fabian, "Automated Verification and Generation of
//! Control Programs for Flexible Manufacturing Cells", §III.A. Rules 9 and 10 name what the method does not handle.

mod conditions;
mod executions;
mod interlocks;
mod order;
mod ways;
mod zones;

use super::findings::TableFindings;
use crate::Relations;

/// Asks every rule. What is wrong with the sequences themselves would be reported by the later ones many times over.
pub(super) fn check(relations: &Relations, findings: &mut TableFindings<'_>) {
    conditions::operations_are_related(relations, findings);
    conditions::every_machine_has_a_sequence(relations, findings);
    conditions::start_conditions_differ(relations, findings);
    conditions::rows_are_of_their_machine(relations, findings);
    order::each_operation_stands_once(relations, findings);
    order::groups_are_whole(relations, findings);
    if findings.has_errors() {
        return;
    }
    order::predecessors_can_be_finished(relations, findings);
    executions::sequences_begin_at_home(relations, findings);
    executions::rows_name_the_same_components(relations, findings);
    executions::actions_change_what_they_may(relations, findings);
    executions::states_follow_each_other(relations, findings);
    ways::ways_differ(relations, findings);
    ways::ends_are_detected_alike(relations, findings);
    ways::passive_components_are_affected_one_by_one(relations, findings);
    zones::zones_are_kept_until_they_are_freed(relations, findings);
    zones::executions_book_what_relations_say(relations, findings);
    zones::declared_zones_are_those_of_relations(relations, findings);
    zones::interlocks_book_what_executions_do(relations, findings);
    interlocks::external_states_are_declared(relations, findings);
    interlocks::executions_fulfil_an_automatic_term(relations, findings);
}

/// Names joined for a message.
fn listed(names: impl IntoIterator<Item = impl AsRef<str>>) -> String {
    let names: Vec<String> = names.into_iter().map(|name| name.as_ref().to_owned()).collect();
    match &names[..] {
        [] => "none".to_owned(),
        [one] => one.clone(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
    }
}
