//! The steps of a counterexample, as text.

use linewright_coordinator_cell::OrderMessage;
use linewright_line::{Line, StationId};
use linewright_orders::OrderKey;

use super::players::{Event, Message, Player};
use super::station::{Act, Machine, StationAnswer};

pub(super) fn message(line: &Line, message: &Message) -> String {
    let name = |station: StationId| &line.station(station).name;
    match message {
        Message::Order(OrderMessage { station, order, .. }) => {
            format!("{} hears order {}: {}", name(*station), number(order.key), order.task)
        }
        Message::Secure { station, key, stop, alarmed: _ } => {
            let what = if *stop { "stop" } else { "leave" };
            format!("{} hears that it is to {what} order {}", name(*station), number(*key))
        }
    }
}

pub(super) fn number(key: OrderKey) -> String {
    if key.epoch == 1 { key.id.to_string() } else { format!("{} (life {})", key.id, key.epoch) }
}

pub(super) fn act(line: &Line, machine: &Machine, act: Act) -> String {
    let name = &line.station(machine.controller.station()).name;
    let doing = machine.controller.operation_text(line);
    match act {
        Act::Arrive => format!("{name}: \"{doing}\" arrives"),
        Act::Fail => format!("{name}: \"{doing}\" fails"),
        Act::Sensors(true) => format!("what {name} waits for comes"),
        Act::Sensors(false) => format!("what {name} waits for goes"),
        Act::Expire => format!("{name}: the time of its order is over, by its own clock"),
        Act::Restart => format!("the node of {name} is started again, with what it kept"),
        Act::Led { on } => {
            format!("a person leads {name} {} by one motion, in manual mode", if on { "on" } else { "back" })
        }
        Act::Forget => format!("the node of {name} is started again, without its memory"),
    }
}

pub(super) fn says(line: &Line, station: StationId, said: &StationAnswer) -> String {
    let name = &line.station(station).name;
    let slot = said.heard.slot.map_or_else(|| "has no order".to_owned(), |key| format!("is at order {}", number(key)));
    let held = if said.heard.is_held { ", stands between rests" } else { "" };
    let ended: Vec<String> =
        said.heard.results.iter().rev().take(2).map(|(key, end)| format!("{} ended {end:?}", number(*key))).collect();
    let ended = if ended.is_empty() { String::new() } else { format!("; order {}", ended.join(", ")) };
    format!("{name} says: {slot}{held}{ended}")
}

pub(super) fn event(player: &Player, event: Event) -> String {
    match event {
        Event::Heard(..) => "the coordinator hears a station".to_owned(),
        Event::Time => "at the coordinator time goes on to its next limit".to_owned(),
        Event::Answer => {
            let mut alarms = player.coordination.state().exceptions().alarms();
            let word = alarms.find_map(|alarm| alarm.words.first());
            format!("the operator answers \"{}\"", word.map_or("?", |word| word))
        }
        Event::Alarm => "a person gives alarm of a resource of the activity".to_owned(),
        Event::Restart => "the coordinator is started again".to_owned(),
        Event::Start(mode) => {
            let table = player.coordination.state().table();
            format!("the coordinator starts {}", table.called(mode))
        }
    }
}
