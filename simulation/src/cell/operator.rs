//! A simulated operator: inspects what has failed, puts it right, and answers the alarm.
//!
//! The operator sees the parts as they are ([`super::PartTruth`]), never the coordinator's state. It brings stations to a rest,
//! mends them, and answers with the places found; where no answer fits it changes the places first. On request some answers are
//! wrong.

use linewright_coordinator_cell::exception::{AlarmSubject, RecoveryDecision, Whereabouts};
use linewright_coordinator_cell::{AlarmId, Dispatcher, FiringId, PlayerInput, ResourceId};

use super::sim::CellSim;

#[derive(Clone, Debug, Default)]
pub struct SimulatedOperator {
    /// Number of alarms to be answered wrongly, as soon as a sensor can contradict the answer.
    pub lies: usize,
    /// Number of answers given.
    pub answers: usize,
}

impl SimulatedOperator {
    /// He looks at everything once.
    pub fn look(&mut self, sim: &mut CellSim, dispatcher: &mut dyn Dispatcher) {
        let alarms: Vec<(AlarmId, AlarmSubject)> =
            sim.state().exceptions().alarms().map(|alarm| (alarm.id, alarm.about)).collect();
        for (alarm, about) in alarms {
            let word = match about {
                AlarmSubject::Firing(firing) => {
                    leave_out(sim, dispatcher, firing);
                    self.put_right(sim, dispatcher, alarm, firing)
                }
                AlarmSubject::Resource(resource) => {
                    mend(sim, resource);
                    sim.state().exceptions().alarm(alarm).and_then(|alarm| alarm.words.first().cloned())
                }
            };
            if let Some(word) = word {
                self.answers += 1;
                sim.say(dispatcher, &[PlayerInput::Answer { alarm, word: &word }]);
            }
        }
        let down: Vec<ResourceId> = sim.state().exceptions().down().map(|(resource, _)| resource).collect();
        for resource in down {
            mend(sim, resource);
            sim.say(dispatcher, &[PlayerInput::Resource { resource, up: true }]);
        }
    }

    /// Brings its stations to a rest, and returns the answer for the places found, or changes them so that one fits.
    fn put_right(
        &mut self,
        sim: &mut CellSim,
        dispatcher: &mut dyn Dispatcher,
        alarm: AlarmId,
        firing: FiringId,
    ) -> Option<String> {
        let orders = sim.state().firing(firing)?.orders.clone();
        let mut is_led = false;
        for order in &orders {
            let now = sim.now;
            let station = sim.stations.get_mut(order.station.index())?;
            (station.is_stuck, station.waits_to_begin) = (false, false);
            if station.doing() == Some(order.key) || station.is_held {
                station.bring_to_rest(now);
                is_led = true;
            }
        }
        if is_led {
            // Messages may be lost.
            let heard = sim.now + sim.options.period * 10;
            sim.run_on(dispatcher, heard);
        }
        // No answer is taken before the coordinator has heard it as well.
        if sim.coordination.unheard(sim.now, firing).is_some() {
            return None;
        }
        if sim.coordination.held_stations().any(|id| orders.iter().any(|order| order.station == id)) {
            return None;
        }
        let found = sim.truth.found(&sim.table, firing)?.part;
        let can_say = sim.coordination.rulings(alarm);
        let said = |part: Whereabouts| can_say.iter().find(|ruling: &&RecoveryDecision| ruling.part == part);
        if self.lies > 0
            && let Some(lie) = opposite(found).filter(|_| is_seen(sim, firing)).and_then(said)
        {
            self.lies -= 1;
            return Some(lie.word.clone());
        }
        if let Some(ruling) = said(found) {
            return Some(ruling.word.clone());
        }
        let table = sim.table.clone();
        let is_made = found == Whereabouts::To;
        match (said(Whereabouts::From), said(Whereabouts::To), said(Whereabouts::Gone)) {
            (Some(back), _, _) if !is_made => {
                sim.truth.bring_back(&table, firing);
                Some(back.word.clone())
            }
            (_, Some(on), _) => {
                sim.truth.finish(&table, firing);
                Some(on.word.clone())
            }
            (_, None, Some(gone)) => {
                sim.truth.take_away(firing);
                Some(gone.word.clone())
            }
            (_, None, None) => None,
        }
    }
}

/// Takes the first station of an activity that is dead out of service.
fn leave_out(sim: &mut CellSim, dispatcher: &mut dyn Dispatcher, firing: FiringId) {
    let Some((station, resource)) = sim.coordination.unheard(sim.now, firing) else { return };
    if sim.stations.get(station.index()).is_some_and(|station| station.is_away) {
        sim.say(dispatcher, &[PlayerInput::Resource { resource, up: false }]);
    }
}

/// Wrong answer to a place found.
fn opposite(found: Whereabouts) -> Option<Whereabouts> {
    match found {
        Whereabouts::From => Some(Whereabouts::To),
        Whereabouts::To => Some(Whereabouts::From),
        Whereabouts::Carrier | Whereabouts::Gone => None,
    }
}

/// Whether a sensor sees if an activity's part is where it was or where it was to go: nothing else is there, or comes there.
fn is_seen(sim: &CellSim, firing: FiringId) -> bool {
    let Some(of) = sim.state().firing(firing) else { return false };
    let (handling, part) = (sim.table.handling(), of.part);
    let handled = handling.mode(of.mode);
    let others = || sim.state().firings().filter(|other| other.id != firing);
    let alone = |id: ResourceId| {
        let is_used = others().any(|other| handling.mode(other.mode).resources().any(|of| of == id));
        let has_other = sim.truth.parts().any(|other| Some(other) != part && sim.truth.at(other) == Some(id));
        let station = handling.resource(id).filter(|of| of.is_sensed).and_then(|of| of.station);
        let is_heard = station.and_then(|id| sim.stations.get(id.index())).is_some_and(|station| !station.is_away);
        is_heard && !is_used && !has_other
    };
    handled.from != handled.to && [handled.from, handled.to].into_iter().flatten().any(alone)
}

/// Clears every fault of its station.
fn mend(sim: &mut CellSim, resource: ResourceId) {
    let station = sim.table.handling().resource(resource).and_then(|of| of.station);
    if let Some(station) = station.and_then(|station| sim.stations.get_mut(station.index())) {
        (station.unable, station.is_held) = (None, false);
    }
}
