//! A lower bound: how many presses a station needs by itself, whatever the others do.
//!
//! Its own controller is played, without arrows and without measured positions, and with all inputs on that see stations or
//! hands, so that none of these blocks. So no way in the line is shorter, and where nothing blocks it is as short.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::time::Duration;

use linewright_line::net::StationPlace;
use linewright_line::{Line, StationId};
use linewright_station_logic::{Controller, PanelCommand, Restore, Rules, StationInput};
use rustc_hash::FxHashMap;

use crate::image::{self, SeenAxes};
use crate::units::{PlayedStation, in_manual, whole_image};

const ALONE: Rules = Rules { arrows: false, positions: false, timely: false, generations: false, ..Rules::ALL };

/// Presses, and the time of their motions. The smaller number of presses comes first.
pub(crate) type Cost = (u32, Duration);

/// What a station is to be led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Aim {
    /// Nothing of it incomplete.
    InOrder,
    Home,
}

/// Marked places and whether it is on a recovery path.
type StandsAt = (Vec<u8>, bool);

#[derive(Default)]
struct KnownDistances {
    numbers: FxHashMap<StandsAt, usize>,
    in_order: Vec<Cost>,
    home: Vec<Cost>,
}

/// The distances of the stations that were asked for.
pub(crate) struct Distances<'l> {
    line: &'l Line,
    /// By station: inputs that see axes.
    seen: Vec<u128>,
    known: RefCell<BTreeMap<usize, KnownDistances>>,
}

/// More situations of one station than any has.
const PLACES_MAX: usize = 4096;

impl<'l> Distances<'l> {
    pub fn new(line: &'l Line) -> Self {
        let mut seen = vec![0; line.stations.len()];
        SeenAxes::of_line(line).into_iter().for_each(|of| seen[of.reader.index()] |= of.input);
        Distances { line, seen, known: RefCell::default() }
    }

    /// The least cost; nothing where the station can get where it is in a way that is not looked at here.
    pub fn least(&self, station: usize, unit: &PlayedStation, aim: Aim) -> Cost {
        let mut known = self.known.borrow_mut();
        let place = (unit.report.places.clone(), unit.report.recovering_home);
        let of = known.entry(station).or_default();
        if !of.numbers.contains_key(&place) {
            self.look(of, station, unit);
        }
        let list = if aim == Aim::Home { &of.home } else { &of.in_order };
        of.numbers.get(&place).map_or((0, Duration::ZERO), |&at| list[at])
    }

    /// Plays the station from where it stands, and from home.
    fn look(&self, known: &mut KnownDistances, station: usize, unit: &PlayedStation) {
        let id = StationId::at(station);
        let fresh = Controller::new(self.line, id, 1, Restore::Fresh).ok();
        let from_home = fresh.map(|controller| self.alone(controller, None));
        let here = self.alone(unit.controller.clone(), Some(unit.report.measured));
        let mut units: Vec<PlayedStation> = Vec::new();
        let mut arcs: Vec<(usize, usize, Duration)> = Vec::new();
        *known = KnownDistances::default();
        let mut enter = |unit: PlayedStation, units: &mut Vec<PlayedStation>| {
            let place = (unit.report.places.clone(), unit.report.recovering_home);
            *known.numbers.entry(place).or_insert_with(|| {
                units.push(unit);
                units.len() - 1
            })
        };
        for unit in from_home.into_iter().chain([here]) {
            enter(unit, &mut units);
        }
        let mut at = 0;
        while at < units.len() && units.len() < PLACES_MAX {
            for advance in [true, false] {
                if let Some((next, time)) = self.pressed(&units[at], advance) {
                    let to = enter(next, &mut units);
                    arcs.push((at, to, time));
                }
            }
            at += 1;
        }
        let is_driven = self.line.station(id).is_task_driven();
        let whole = |unit: &PlayedStation| unit.report.incomplete.is_empty() && !unit.report.recovering_home;
        let in_order = |unit: &PlayedStation| whole(unit) && (!is_driven || unit.report.at_home);
        known.in_order = least_costs(&units, &arcs, in_order);
        known.home = least_costs(&units, &arcs, |unit| whole(unit) && unit.report.at_home);
    }

    /// In manual, without the others. Where no image is given, that of home.
    fn alone(&self, controller: Controller, bits: Option<u128>) -> PlayedStation {
        let id = controller.station();
        let described = self.line.station(id);
        let home = || image::at_rest(described, StationPlace::completed(described.home));
        let mut unit = PlayedStation::new(controller.with_rules(ALONE));
        let switch = described.operations[described.home.index()].normal.complete.bit();
        unit.take(whole_image(bits.unwrap_or_else(|| home() | switch) | self.seen[id.index()]));
        let epoch = unit.report.mode_epoch + 1;
        unit.take(StationInput::Order(in_manual(epoch)));
        unit
    }

    fn pressed(&self, before: &PlayedStation, advance: bool) -> Option<(PlayedStation, Duration)> {
        let mut unit = before.clone();
        let command = |held| if advance { PanelCommand::Advance(held) } else { PanelCommand::Retract(held) };
        unit.take(StationInput::Panel(command(true)));
        let motions = unit.motions();
        if motions.is_empty() {
            unit.take(StationInput::Panel(command(false)));
            return (unit.report.places != before.report.places).then_some((unit, Duration::ZERO));
        }
        let id = unit.controller.station();
        let (station, bits) = (self.line.station(id), unit.report.measured);
        unit.take(whole_image(image::under_way(station, bits, &motions)));
        unit.take(whole_image(image::arrived(self.line, id, bits, &motions)));
        unit.take(StationInput::Panel(command(false)));
        let time = motions.iter().map(|&place| image::motion(station, place).1).max()?;
        unit.motions().is_empty().then_some((unit, time))
    }
}

/// Of each unit, the least cost of a way to one that is where it is to be; nothing where none leads there.
fn least_costs(
    units: &[PlayedStation],
    arcs: &[(usize, usize, Duration)],
    is_there: impl Fn(&PlayedStation) -> bool,
) -> Vec<Cost> {
    let mut costs: Vec<Option<Cost>> = units.iter().map(|unit| is_there(unit).then_some((0, Duration::ZERO))).collect();
    loop {
        let mut changed = false;
        for &(from, to, time) in arcs {
            let Some((presses, rest)) = costs[to] else { continue };
            let cost = (presses + 1, rest + time);
            if costs[from].is_none_or(|known| cost < known) {
                costs[from] = Some(cost);
                changed = true;
            }
        }
        if !changed {
            return costs.into_iter().map(Option::unwrap_or_default).collect();
        }
    }
}
