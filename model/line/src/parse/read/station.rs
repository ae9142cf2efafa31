//! A station's table and its operations.

use linewright_text::{At, Fields, Problem, Report};

use super::line::each;
use super::{AXES_MAX, HOLDERS_MAX, REACHES_MAX, handling, task};
use crate::parse::raw::{Kind, RawHand, RawMoves, RawOperation, RawPanel, RawRecovery, RawSignals, RawStation};
use crate::{CODE_MAX, OPERATIONS_MAX, RESTS_MAX, TASKS_MAX};

/// At most this many inputs that one operation waits for.
const WAITS_MAX: usize = 16;

pub(super) fn station(mut f: Fields<'_>, report: &mut Report) -> RawStation {
    let on_order = f.has("task");
    let raw = RawStation {
        at: f.at.clone(),
        name: f.required_text(report, "name"),
        title: f.text(report, "title"),
        home: if on_order { f.text(report, "home") } else { f.required_text(report, "home") },
        bus: f.text(report, "bus"),
        axes: f
            .required_table(report, "axes", "`axes`")
            .map(|axes| axes.coordinates(report, AXES_MAX))
            .unwrap_or_default(),
        rests: each(f.tables(report, "rest", "a rest", RESTS_MAX), report, task::rest),
        tasks: each(f.tables(report, "task", "a task", TASKS_MAX), report, task::task),
        holders: each(f.tables(report, "holder", "a holder", HOLDERS_MAX), report, handling::holder),
        reaches: each(f.tables(report, "reach", "a reach", REACHES_MAX), report, handling::reach),
        panel: f.table(report, "panel", "`panel`").map(|f| panel(f, report)),
        operations: each(f.tables(report, "operation", "an operation", OPERATIONS_MAX), report, operation),
    };
    f.finish(report);
    raw
}

fn panel(mut f: Fields<'_>, report: &mut Report) -> RawPanel {
    let raw = RawPanel {
        manual: f.text(report, "manual"),
        advance: f.text(report, "advance"),
        retract: f.text(report, "return"),
    };
    f.finish(report);
    raw
}

fn operation(mut f: Fields<'_>, report: &mut Report) -> RawOperation {
    let raw = RawOperation {
        at: f.at.clone(),
        name: f.required_text(report, "name"),
        kind: kind(&mut f, report),
        moves: f.required_table(report, "moves", "`moves`").map(|f| moves(f, report)),
        duration: f.required_seconds(report, "duration_s"),
        watchdog: f.required_seconds(report, "watchdog_s"),
        normal: f.required_table(report, "normal", "`normal`").map(|mut f| {
            let signals = signals(&mut f, report);
            f.finish(report);
            signals
        }),
        recovery: f.table(report, "recovery", "`recovery`").map(|f| recovery(f, report)),
        hand: f.required_table(report, "hand", "`hand`").map(|f| hand(f, report)),
        recovery_path: f.texts(report, "recovery_path", OPERATIONS_MAX),
        with: f.text(report, "with"),
        task: f.text(report, "task"),
        waits: f.texts(report, "waits", WAITS_MAX),
        waits_code: f.whole(report, "waits_code", 1, i64::from(CODE_MAX)),
    };
    f.finish(report);
    raw
}

fn kind(f: &mut Fields<'_>, report: &mut Report) -> Option<At<Kind>> {
    let module = f.required_text(report, "module")?;
    let kind = match module.value.as_str() {
        "R" => Kind::Reversible,
        "I" => Kind::Irreversible,
        other => {
            report.add(
                Problem::error(module.at, format!("unknown module `{other}`"))
                    .hint("`R` for a reversible operation, `I` for an irreversible one"),
            );
            return None;
        }
    };
    Some(At::new(kind, module.at))
}

fn moves(mut f: Fields<'_>, report: &mut Report) -> RawMoves {
    let raw = RawMoves {
        at: f.at.clone(),
        axis: f.required_text(report, "axis"),
        from: f.coordinate(report, "from"),
        to: f.coordinate(report, "to"),
    };
    f.finish(report);
    raw
}

fn signals(f: &mut Fields<'_>, report: &mut Report) -> RawSignals {
    RawSignals {
        actuator: f.required_text(report, "actuator"),
        complete: f.required_text(report, "complete"),
        fault: f.text(report, "fault"),
        lamp: f.text(report, "lamp"),
    }
}

fn recovery(mut f: Fields<'_>, report: &mut Report) -> RawRecovery {
    let raw = RawRecovery {
        at: f.at.clone(),
        signals: signals(&mut f, report),
        duration: f.seconds(report, "duration_s"),
        watchdog: f.seconds(report, "watchdog_s"),
    };
    f.finish(report);
    raw
}

fn hand(mut f: Fields<'_>, report: &mut Report) -> RawHand {
    let raw = RawHand {
        at: f.at.clone(),
        number: f.required_integer(report, "type"),
        forward: f.required_text(report, "forward"),
        back: f.text(report, "back"),
        next: f.text(report, "next"),
    };
    f.finish(report);
    raw
}
