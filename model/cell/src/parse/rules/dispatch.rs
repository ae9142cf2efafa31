//! Configuration of the dispatcher.

use linewright_text::{Problem, Report, suggestion};

use super::durations::time_left_out;
use crate::DispatchRule;
use crate::parse::draft::DraftCell;

pub(super) fn rules_exist_once(draft: &DraftCell<'_>, report: &mut Report) {
    let Some(rules) = &draft.raw.dispatch.rules else { return };
    if rules.value.is_empty() {
        report.add(Problem::error(rules.at.clone(), "no rule decides").hint("leave `rules` out for `fifo`"));
    }
    for (at, rule) in rules.value.iter().enumerate() {
        if !DispatchRule::ALL.iter().any(|(known, _)| *known == rule.value) {
            report.add(
                Problem::error(rule.at.clone(), format!("unknown rule `{}`", rule.value))
                    .maybe_hint(suggestion(&rule.value, DispatchRule::ALL.map(|(name, _)| name))),
            );
        } else if let Some(earlier) = rules.value[..at].iter().find(|earlier| earlier.value == rule.value) {
            report.add(
                Problem::error(rule.at.clone(), format!("rule `{}` twice", rule.value))
                    .label("again")
                    .also(&earlier.at, "first here"),
            );
        }
    }
}

pub(super) fn schedule_is_not_alone(draft: &DraftCell<'_>, report: &mut Report) {
    if let Some(last) = draft.raw.dispatch.known_rules().last().filter(|last| last.value == DispatchRule::Schedule) {
        report.add(
            Problem::error(last.at, "`schedule` is the last rule")
                .label("no rule after `schedule` for activities that are not planned")
                .hint("name another one after it, such as \"fifo\""),
        );
    }
}

pub(super) fn patience_outlasts_activities(draft: &DraftCell<'_>, report: &mut Report) {
    let Some(patience) = &draft.raw.dispatch.patience else { return };
    let moves = draft.activities.iter().filter_map(|activity| Some(activity.time.as_ref()?.value));
    let on = draft.parts.iter().flat_map(|part| &part.raw.steps).flat_map(|step| &step.on);
    let works = on.filter_map(|on| Some(on.time.as_ref()?.value));
    let charted = draft.activities.iter().filter_map(|activity| Some(time_left_out(draft, activity)?.longest));
    if let Some(longest) = moves.chain(works).chain(charted).max().filter(|longest| *longest > patience.value) {
        report.add(
            Problem::warning(patience.at.clone(), format!("`patience_s` is {}", patience.value.as_secs_f64()))
                .label("short")
                .hint(format!(
                    "a single activity takes {} s: parts become urgent while they wait for one",
                    longest.as_secs_f64()
                )),
        );
    }
}
