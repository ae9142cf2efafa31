//! The steps of a counterexample, as text.

use linewright_coordinator_cell::OrderMessage;
use linewright_line::{Line, StationId};
use linewright_orders::TaskOutcome;
use linewright_orders::{LeaveWay, OrderKey};

use super::players::{PlayerMove, ProtocolPlayer, StationMessage};
use super::station::{StationAnswer, TaskStationAct, TaskStationModel};

pub(super) fn message(line: &Line, message: &StationMessage) -> String {
    let name = |station: StationId| &line.station(station).name;
    match message {
        StationMessage::Order(OrderMessage { station, order, .. }) => {
            format!("{} receives order {}: {}", name(*station), number(order.key), order.task)
        }
        StationMessage::Secure { station, key, way, alarmed: _ } => {
            let what = match way {
                LeaveWay::Back => "go back from",
                LeaveWay::Hold => "hold",
                LeaveWay::Stop => "stop",
            };
            format!("{} receives: {what} order {}", name(*station), number(*key))
        }
    }
}

pub(super) fn number(key: OrderKey) -> String {
    if key.epoch == 1 { key.id.to_string() } else { format!("{} (epoch {})", key.id, key.epoch) }
}

pub(super) fn act(line: &Line, machine: &TaskStationModel, act: TaskStationAct) -> String {
    let name = &line.station(machine.controller.station()).name;
    let doing = machine.controller.operation_text(line);
    match act {
        TaskStationAct::Arrive => format!("{name}: \"{doing}\" arrives"),
        TaskStationAct::Fail => format!("{name}: \"{doing}\" fails"),
        TaskStationAct::Sensors(true) => format!("input of {name} comes on"),
        TaskStationAct::Sensors(false) => format!("input of {name} goes off"),
        TaskStationAct::Expire => format!("{name}: time limit of its order exceeded, by its own clock"),
        TaskStationAct::Restart => format!("the node of {name} is restarted with its journal"),
        TaskStationAct::Led { on } => {
            format!("a person leads {name} {} by one motion, in manual mode", if on { "on" } else { "back" })
        }
        TaskStationAct::Forget => format!("the node of {name} is restarted without its journal"),
    }
}

pub(super) fn says(line: &Line, station: StationId, said: &StationAnswer) -> String {
    let name = &line.station(station).name;
    let slot =
        said.heard.slot.map_or_else(|| "no order".to_owned(), |key| format!("order {} in progress", number(key)));
    let held = if said.heard.is_held { ", stopped between two rests" } else { "" };
    let ended: Vec<String> = said
        .heard
        .results
        .iter()
        .rev()
        .take(2)
        .map(|(key, end)| format!("{} {}", number(*key), ended_as(*end)))
        .collect();
    let ended = if ended.is_empty() { String::new() } else { format!("; order {}", ended.join(", ")) };
    format!("{name} reports: {slot}{held}{ended}")
}

fn ended_as(end: TaskOutcome) -> String {
    match end {
        TaskOutcome::Done => "done".to_owned(),
        TaskOutcome::Failed(failure) => format!("failed with code {}", failure.code()),
    }
}

pub(super) fn event(player: &ProtocolPlayer, event: PlayerMove) -> String {
    match event {
        PlayerMove::Heard(..) => "the coordinator receives a station state".to_owned(),
        PlayerMove::Time => "time at the coordinator advances to the next limit".to_owned(),
        PlayerMove::Answer => {
            let mut alarms = player.coordination.state().exceptions().alarms();
            let word = alarms.find_map(|alarm| alarm.words.first());
            format!("the operator answers \"{}\"", word.map_or("?", |word| word))
        }
        PlayerMove::Alarm => "alarm raised by hand for a resource of the activity".to_owned(),
        PlayerMove::Restart => "the coordinator is restarted".to_owned(),
        PlayerMove::Start(mode) => {
            let table = player.coordination.state().table();
            format!("the coordinator starts {}", table.called(mode))
        }
    }
}
