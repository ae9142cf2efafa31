//! Text → [`RawCell`]: TOML, keys and types, and nothing about meaning.
//!
//! Every list is bounded here, so that whatever a file contains, the later passes work on something of known size.

use linewright_text::{Fields, Report};

use super::raw::{
    RawAnswer, RawCell, RawCellAction, RawDispatch, RawException, RawOn, RawOrder, RawPart, RawResource, RawStep,
    RawSync,
};
use crate::{Strategy, Whereabouts};

/// At most this many resources.
pub(super) const RESOURCES_MAX: usize = 1000;
/// At most this many synchronisations.
const SYNCS_MAX: usize = 5000;
/// At most this many part types.
const PARTS_MAX: usize = 2000;
/// At most this many steps of one plan.
const STEPS_MAX: usize = 500;
/// At most this many resources for one step.
const ALTERNATIVES_MAX: usize = 100;
/// At most this many orders of one activity.
const ORDERS_MAX: usize = 16;
/// At most this many parameters of one order.
const PARAMETERS_MAX: usize = 16;
/// At most this many actions that are one.
const ACTIONS_MAX: usize = 8;
/// At most this many rules for exceptions, and answers to one.
const EXCEPTIONS_MAX: usize = 1000;
const ANSWERS_MAX: usize = 16;
/// At most this many resources that are left out after one answer.
const DOWN_MAX: usize = 16;
/// At most this many parts in the cell at once.
const WIP_MAX: i64 = 10_000;
/// What a limit is of the nominal time, where nothing is said.
const SAFETY: f64 = 2.0;

/// Reads `text`; `None` when it is not TOML at all.
pub(super) fn read(text: &str, report: &mut Report) -> Option<RawCell> {
    let document = linewright_text::document(text, report)?;
    let mut top = Fields::new(document.as_table(), 0..0, "the description");
    let mut raw = RawCell {
        name: top.required_text(report, "name"),
        title: top.text(report, "title"),
        at: 0..0,
        wip_max: None,
        reserve: true,
        safety: SAFETY,
        dispatch: top.table(report, "dispatch", "`[dispatch]`").map(|f| dispatch(f, report)).unwrap_or_default(),
        resources: each(top.tables(report, "resource", "a resource", RESOURCES_MAX), report, resource),
        syncs: each(top.tables(report, "sync", "a synchronisation", SYNCS_MAX), report, sync),
        actions: each(top.tables(report, "action", "an action", SYNCS_MAX), report, action),
        parts: each(top.tables(report, "part", "a part", PARTS_MAX), report, part),
        exceptions: each(top.tables(report, "exception", "an exception", EXCEPTIONS_MAX), report, exception),
    };
    if let Some(mut f) = top.required_table(report, "cell", "`[cell]`") {
        raw.at = f.at.clone();
        let wip_max = f.required_integer(report, "wip_max");
        raw.wip_max = wip_max.filter(|_| f.whole(report, "wip_max", 1, WIP_MAX).is_some());
        raw.reserve = f.flag(report, "reserve").is_none_or(|flag| flag.value);
        raw.safety = f.within(report, "safety", 1.0, 100.0).map_or(SAFETY, |safety| safety.value);
        f.finish(report);
    }
    top.finish(report);
    Some(raw)
}

fn each<T>(tables: Vec<Fields<'_>>, report: &mut Report, read: impl Fn(Fields<'_>, &mut Report) -> T) -> Vec<T> {
    tables.into_iter().map(|fields| read(fields, report)).collect()
}

fn dispatch(mut f: Fields<'_>, report: &mut Report) -> RawDispatch {
    let raw = RawDispatch {
        rules: f.texts(report, "rules", crate::DispatchRule::ALL.len()),
        look_ahead: f.within(report, "look_ahead_s", 0.0, 86_400.0),
        patience: f.seconds(report, "patience_s"),
        window: f.within(report, "window_s", 0.0, 86_400.0),
    };
    f.finish(report);
    raw
}

fn resource(mut f: Fields<'_>, report: &mut Report) -> RawResource {
    let raw = RawResource {
        at: f.at.clone(),
        name: f.required_text(report, "name"),
        prototype: f.required_text(report, "prototype"),
        capacity: f.integer(report, "capacity"),
        station: f.text(report, "station"),
        presence: f.text(report, "presence"),
    };
    f.finish(report);
    raw
}

fn sync(mut f: Fields<'_>, report: &mut Report) -> RawSync {
    let raw = RawSync {
        at: f.at.clone(),
        name: f.required_text(report, "name"),
        actions: f.required_texts(report, "actions", ACTIONS_MAX),
        time: f.seconds(report, "time_s"),
        orders: each(f.tables(report, "orders", "an order", ORDERS_MAX), report, order),
    };
    f.finish(report);
    raw
}

fn action(mut f: Fields<'_>, report: &mut Report) -> RawCellAction {
    let raw = RawCellAction {
        of: f.required_text(report, "of"),
        orders: each(f.tables(report, "orders", "an order", ORDERS_MAX), report, order),
    };
    f.finish(report);
    raw
}

fn order(mut f: Fields<'_>, report: &mut Report) -> RawOrder {
    let parameters = f.table(report, "parameters", "`parameters`");
    let raw = RawOrder {
        at: f.at.clone(),
        station: f.required_text(report, "station"),
        task: f.required_text(report, "task"),
        parameters: parameters.map(|f| f.scalars(report, PARAMETERS_MAX)).unwrap_or_default(),
        limit: f.seconds(report, "max_s"),
    };
    f.finish(report);
    raw
}

fn part(mut f: Fields<'_>, report: &mut Report) -> RawPart {
    let raw = RawPart {
        at: f.at.clone(),
        name: f.required_text(report, "name"),
        steps: each(f.tables(report, "step", "a step", STEPS_MAX), report, step),
    };
    f.finish(report);
    raw
}

fn step(mut f: Fields<'_>, report: &mut Report) -> RawStep {
    let raw = RawStep {
        at: f.at.clone(),
        name: f.required_text(report, "name"),
        or: f.text(report, "or"),
        then: f.text(report, "then"),
        on: each(f.tables(report, "on", "a resource of a step", ALTERNATIVES_MAX), report, on),
    };
    f.finish(report);
    raw
}

fn on(mut f: Fields<'_>, report: &mut Report) -> RawOn {
    let raw = RawOn {
        has_program: f.has("program"),
        at: f.at.clone(),
        resource: f.required_text(report, "resource"),
        time: f.required_seconds(report, "time_s"),
        program: f.whole(report, "program", i32::MIN.into(), i32::MAX.into()),
    };
    f.finish(report);
    raw
}

fn exception(mut f: Fields<'_>, report: &mut Report) -> RawException {
    let raw = RawException {
        at: f.at.clone(),
        within: f.required_text(report, "in"),
        code: f.required_text(report, "code"),
        tell: f.required_text(report, "tell"),
        retries: f.whole(report, "retries", 0, 100).map_or(0, |retries| retries.value),
        down: f.texts(report, "down", DOWN_MAX),
        automatic: f.flag(report, "automatic").is_some_and(|flag| flag.value),
        emergency_stop: f.texts(report, "emergency_stop", DOWN_MAX),
        answers: each(f.tables(report, "answers", "an answer", ANSWERS_MAX), report, answer),
    };
    f.finish(report);
    raw
}

fn answer(mut f: Fields<'_>, report: &mut Report) -> RawAnswer {
    let whereabouts = [
        ("from", Whereabouts::From),
        ("to", Whereabouts::To),
        ("carrier", Whereabouts::Carrier),
        ("gone", Whereabouts::Gone),
    ];
    let strategies = [("redo", Strategy::Redo), ("backward", Strategy::Backward), ("forward", Strategy::Forward)];
    let raw = RawAnswer {
        word: f.required_text(report, "word"),
        part: f.required_word(report, "part", &whereabouts),
        then: f.required_word(report, "then", &strategies),
        down: f.texts(report, "down", DOWN_MAX),
    };
    f.finish(report);
    raw
}
