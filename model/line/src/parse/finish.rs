//! Draft → [`Line`]: the last step, taken only when no rule has found an error.
//!
//! Every `?` here is a part that some earlier pass must have reported missing. Should that ever not be so, the caller
//! reports that instead of panicking: a description is a user's input, whatever the mistake is.

use linewright_text::{Located, or};

use super::draft::{DraftConsole, DraftDevice, DraftLine, DraftOperation, DraftSignals, DraftStation};
use super::raw::{ModuleKind, RawConsole, RawDevice, RawTiming};
use super::rules::{node_id, same_motion};
use super::setup;
use super::{analogue, drive, frames, handling, modbus, task};
use crate::{
    Arrow, Canopen, Conflict, Console, Device, DeviceKind, InputId, Io, Line, MotionResult, MotionSignals, Operation,
    OperationModule, Owner, Panel, Station, StopContact, TaskOrderSource, Timing,
};

/// The line a draft describes; `None` if a part is missing.
pub(super) fn finish(draft: &DraftLine<'_>) -> Option<Line> {
    let raw = draft.raw;
    let name = raw.name.as_ref()?.value.clone();
    Some(Line {
        title: raw.title.as_ref().map_or_else(|| name.clone(), |title| title.value.clone()),
        name,
        stations: draft.stations.iter().map(station).collect::<Option<_>>()?,
        arrows: draft
            .arrows
            .iter()
            .map(|arrow| {
                let (from, to) = (arrow.from.as_ref()?.value, arrow.to.as_ref()?.value);
                Some(Arrow { from, to, lag: arrow.lag, auto: arrow.auto, manual: arrow.manual })
            })
            .collect::<Option<_>>()?,
        conflicts: draft
            .conflicts
            .iter()
            .zip(&raw.conflicts)
            .map(|(conflict, raw)| {
                let why = raw.why.as_ref()?.value.clone();
                Some(Conflict { why, a: conflict.a.as_ref()?.value, b: conflict.b.as_ref()?.value })
            })
            .collect::<Option<_>>()?,
        devices: devices(draft)?,
        buttons: raw.buttons.iter().map(|button| button.value.clone()).collect(),
        console: console(&draft.console, draft.raw.console.as_ref()),
        timing: timing(&raw.timing),
        handling: handling::finish(&draft.handling)?,
    })
}

fn texts(names: &[Located<String>]) -> Vec<String> {
    names.iter().map(|name| name.value.clone()).collect()
}

fn station(draft: &DraftStation<'_>) -> Option<Station> {
    let name = draft.raw.name.as_ref()?.value.clone();
    let [manual, advance, retract] = draft.panel.each_ref().map(|input| input.as_ref().map(|i| i.value));
    Some(Station {
        title: draft.raw.title.as_ref().map_or_else(|| name.clone(), |title| title.value.clone()),
        name,
        operations: draft.operations.iter().map(|op| operation(draft, op)).collect::<Option<_>>()?,
        home: draft.home.as_ref()?.value,
        steps: draft.steps.clone(),
        axes: draft.axes.clone(),
        rests: task::finish_rests(draft)?,
        tasks: draft.tasks.iter().map(task::finish).collect::<Option<_>>()?,
        order_source: draft.raw.order_source.as_ref().map_or(TaskOrderSource::Coordinator, |source| source.value),
        inputs: texts(&draft.wiring.inputs),
        outputs: texts(&draft.wiring.outputs),
        panel: Panel { manual, advance, retract },
        bus: draft.bus.clone(),
    })
}

fn operation(station: &DraftStation<'_>, draft: &DraftOperation<'_>) -> Option<Operation> {
    let raw = draft.raw;
    let (duration, watchdog) = (raw.duration.as_ref()?.value, raw.watchdog.as_ref()?.value);
    let module = match draft.kind()? {
        ModuleKind::Reversible => {
            let recovery = raw.recovery.as_ref()?;
            let same = same_motion(station, draft).map_or(raw, |other| other.raw);
            OperationModule::Reversible {
                recovery: signals(draft.recovery.as_ref()?)?,
                recovery_duration: or(&recovery.duration, same.duration.as_ref()?.value),
                recovery_watchdog: or(&recovery.watchdog, same.watchdog.as_ref()?.value),
            }
        }
        ModuleKind::Irreversible => {
            OperationModule::Irreversible { recovery_path: draft.path.iter().map(|step| step.value).collect() }
        }
    };
    Some(Operation {
        name: raw.name.as_ref()?.value.clone(),
        module,
        duration,
        watchdog,
        motion: draft.motion.as_ref()?.value,
        normal: signals(&draft.normal)?,
        waits: draft.waits.iter().map(|input| input.value).collect(),
        waits_code: raw.waits_code.as_ref().map_or(Some(0), |code| u16::try_from(code.value).ok())?,
        result: match &raw.result {
            Some(result) => Some(MotionResult {
                input: draft.result.as_ref()?.value,
                within: result.within.as_ref()?.value,
                code: u16::try_from(result.code.as_ref()?.value).ok()?,
            }),
            None => None,
        },
        hand: draft.hand.as_ref()?.value,
    })
}

fn signals(draft: &DraftSignals) -> Option<MotionSignals> {
    Some(MotionSignals {
        actuator: draft.actuator.as_ref()?.value,
        complete: draft.complete.as_ref()?.value,
        fault: draft.fault.as_ref().map(|fault| fault.value),
        lamp: draft.lamp.as_ref().map(|lamp| lamp.value),
    })
}

fn devices(draft: &DraftLine<'_>) -> Option<Vec<Device>> {
    let devices = draft.devices.iter().zip(&draft.raw.devices).map(|(device, raw)| {
        Some(Device {
            name: raw.name.as_ref()?.value.clone(),
            owner: device.owner?,
            bus: device.bus.clone(),
            kind: kind(draft, device, raw)?,
        })
    });
    devices.collect()
}

fn kind(draft: &DraftLine<'_>, device: &DraftDevice, raw: &RawDevice) -> Option<DeviceKind> {
    if let (Some(draft), Some(raw)) = (&device.frames, &raw.frames) {
        return Some(DeviceKind::Frames(frames::finish(draft, raw)?));
    }
    if let Some(raw) = &raw.modbus {
        return Some(DeviceKind::Modbus(modbus::finish(device, raw)?));
    }
    let canopen = Canopen { node_id: node_id(raw.node.as_ref()?.value)?, setup: setup::finish(raw)? };
    if let (Some(drive), Some(raw)) = (&device.drive, &raw.drive) {
        let Owner::Station(station) = device.owner? else { return None };
        return Some(DeviceKind::Drive(canopen, drive::finish(drive, raw, &draft.stations[station.index()].axes)?));
    }
    let analogue = analogue::finish(&device.analogue, &raw.analogue, draft.image(device.owner?))?;
    Some(DeviceKind::Io(canopen, Io { inputs: device.inputs.clone(), outputs: device.outputs.clone(), analogue }))
}

fn console(draft: &DraftConsole, raw: Option<&RawConsole>) -> Console {
    let [start, stop, auto, hand, estop, reset]: [Option<InputId>; 6] =
        draft.inputs.each_ref().map(|input| input.as_ref().map(|i| i.value));
    Console {
        inputs: texts(&draft.wiring.inputs),
        outputs: texts(&draft.wiring.outputs),
        start,
        stop,
        auto,
        hand,
        estop: estop.map(|input| StopContact { input, pressed: raw.is_none_or(|raw| raw.estop.pressed) }),
        reset,
        buttons: draft.buttons.clone(),
        lamps: draft.lamps.each_ref().map(|lamp| lamp.as_ref().map(|l| l.value)),
    }
}

fn timing(raw: &RawTiming) -> Timing {
    let default = Timing::default();
    Timing {
        refresh: or(&raw.refresh, default.refresh),
        stale: or(&raw.stale, default.stale),
        lease: or(&raw.lease, default.lease),
        heartbeat: or(&raw.heartbeat, default.heartbeat),
        heartbeat_timeout: or(&raw.heartbeat_timeout, default.heartbeat_timeout),
        sync: raw.sync.as_ref().map(|sync| sync.value),
    }
}
