//! A station that stands at a rest where its next task cannot begin is brought to another one in hand mode: which button does it.
//!
//! The real controllers are played with each button of the console held: what the button begins ends at some rest, or begins nothing, as
//! where a task waits for an input that is off. A button that moves another station is none: how far that one goes depends on how long a
//! person holds it.

use linewright_coordinator_cell::compile::rests;
use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{ButtonId, RestId, StationId};
use linewright_station_logic::{ModeOrder, StationInput};

use crate::desk::Desk;
use crate::image;
use crate::situation::LineSituation;
use crate::units::{PlayedLine, PlayedStations, whole_image};

/// Motions of a held button: no task has more.
const MOTIONS_MAX: usize = 100;

/// A hand-mode button that brings a station to a rest.
pub(crate) struct HeldButton {
    pub station: StationId,
    pub rest: RestId,
    pub button: ButtonId,
    /// What it moves, one after the other.
    pub motions: Vec<(StationId, StationPlace)>,
    pub after: PlayedStations,
}

/// The way to hand mode, the buttons there, and the way from there to auto.
pub(crate) struct WayInHand {
    pub to_hand: Vec<(ModeCommand, Desk)>,
    pub held: Vec<HeldButton>,
    pub to_auto: Vec<(ModeCommand, Desk)>,
}

/// Every station that an alarm asks for is brought to its rest; none where that does not go by buttons, or nothing is asked for.
pub(crate) fn in_hand(floor: &PlayedLine<'_>, situation: &LineSituation, desk: Desk) -> Option<WayInHand> {
    let asked: Vec<(StationId, RestId)> = situation.alarms.iter().filter_map(|alarm| alarm.bring).collect();
    let to_hand = desk.way_to(floor, ControlMode::Hand).filter(|_| !asked.is_empty())?;
    let mut desk = to_hand.last().map_or(desk, |(_, desk)| desk.clone());
    let mut held: Vec<HeldButton> = Vec::new();
    for (station, rest) in asked {
        let brought = best_button(floor, &desk.units, station, rest)?;
        desk.units.clone_from(&brought.after);
        held.push(brought);
    }
    desk.settle(floor);
    let to_auto = desk.way_to(floor, ControlMode::Auto)?;
    Some(WayInHand { to_hand, held, to_auto })
}

fn best_button(
    floor: &PlayedLine<'_>,
    before: &PlayedStations,
    station: StationId,
    rest: RestId,
) -> Option<HeldButton> {
    let buttons = (0..floor.line.buttons.len()).map(ButtonId::at);
    let all = buttons.filter_map(|button| {
        let (motions, after) = hold(floor, before, button)?;
        let at = after[station.index()].report.order.as_ref()?.rest;
        let moves_others = motions.iter().any(|(id, _)| *id != station);
        (at == Some(rest) && !moves_others).then_some(HeldButton { station, rest, button, motions, after })
    });
    let all: Vec<HeldButton> = all.collect();
    let stands = before[station.index()].report.order.as_ref().and_then(|order| order.rest);
    // The one that the alarm names goes before others, also shorter ones.
    let ways = Some(&all).filter(|all| all.len() > 1).map(|_| rests(floor.line, station));
    let named = ways.as_ref().zip(stands).and_then(|(ways, stands)| ways.button(stands, rest));
    let is_named = |button: ButtonId| named == Some(floor.line.buttons[button.index()].as_str());
    all.into_iter().min_by_key(|held| (!is_named(held.button), held.motions.len()))
}

/// Holds a button until nothing moves by it any more. None where that does not end.
fn hold(
    floor: &PlayedLine<'_>,
    before: &PlayedStations,
    button: ButtonId,
) -> Option<(Vec<(StationId, StationPlace)>, PlayedStations)> {
    let mut units = before.clone();
    press(floor, &mut units, 1 << button.0);
    let mut all = Vec::new();
    while let Some(at) = (0..units.len()).find(|&at| !units[at].motions().is_empty()) {
        if all.len() > MOTIONS_MAX {
            return None;
        }
        let (id, bits, motions) = (StationId::at(at), units[at].report.measured, units[at].motions());
        let moved = image::under_way(floor.line.station(id), bits, &motions);
        floor.give(&mut units, at, whole_image(moved));
        floor.give(&mut units, at, whole_image(image::arrived(floor.line, id, bits, &motions)));
        all.extend(motions.iter().map(|&place| (id, place)));
        if units[at].motions() == motions {
            return None;
        }
    }
    press(floor, &mut units, 0);
    Some((all, units))
}

fn press(floor: &PlayedLine<'_>, units: &mut PlayedStations, buttons: u32) {
    for at in 0..units.len() {
        let epoch = units[at].report.mode_epoch;
        let order = ModeOrder { buttons, ..ModeOrder::of(1, epoch, ControlMode::Hand, ModeOrder::FOR_GOOD) };
        floor.give(units, at, StationInput::Order(order));
    }
}
