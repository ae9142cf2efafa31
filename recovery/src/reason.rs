//! Why a plan has its presses: found by playing it with the real controllers, and once more without the station that is asked about.
//!
//! A station is moved because something of it is incomplete, or because another one is refused as long as it stands where it does. Of the
//! second the description alone does not say it: agreements, conflicts and interlocks do, in the controllers.

use std::rc::Rc;

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{Line, StationId};

use crate::image;
use crate::plan::RecoveryPlan;
use crate::restore::unit;
use crate::situation::LineSituation;
use crate::step::{Need, PanelButton, RecoveryAction, RecoveryStep};
use crate::units::{PlayedLine, PlayedStations, in_manual};

/// Plans of more steps are left without reasons: each step is played once for each step before it.
const STEPS_MAX: usize = 40;

/// Why a step moves a station, or several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StepReason {
    /// What is wrong with each station that it moves.
    pub(crate) own: Vec<(StationId, OwnReason)>,
    /// A later step that is refused without it.
    pub(crate) otherwise: Option<(StationId, StationPlace)>,
    /// Why *return* takes an operation back, where no other station's step decides it.
    pub(crate) back: Option<BackReason>,
}

/// What is wrong with a station by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OwnReason {
    /// It stands within this operation.
    Incomplete(StationPlace),
    PositionLost,
    /// It is on its recovery path.
    OnTheWayHome,
    /// It is on its recovery path, and its mechanism stands at the end of it: what is pressed moves nothing.
    AtTheEndOfTheWayHome,
    /// Task-driven, it stands between two rests.
    BetweenRests,
    /// Every station is led home, where counts begin anew.
    Away,
}

/// Why an operation is taken back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BackReason {
    /// *Advance* moves nothing there.
    NoWayOn,
    /// The mechanism stands at the end of what *advance* would do: nothing would be seen to arrive.
    EndNotSeen,
    Shorter,
}

impl RecoveryPlan {
    /// By step, why it is there: of the presses of a plan with several of them, and of a press that moves nothing.
    pub fn reasons(&self, line: &Line, situation: &LineSituation) -> Vec<Option<StepReason>> {
        let mut found = vec![None; self.steps.len()];
        let is_press = |step: &RecoveryStep| matches!(step.action, RecoveryAction::Press(..) | RecoveryAction::Resume);
        // One press alone that leads something on explains itself.
        let is_back = |step: &RecoveryStep| matches!(step.action, RecoveryAction::Press(_, PanelButton::Return));
        let is_unclear =
            |step: &RecoveryStep| is_press(step) && (self.presses() > 1 || step.moves.is_empty() || is_back(step));
        let none_is_unclear = !self.steps.iter().any(is_unclear);
        if none_is_unclear || self.steps.len() > STEPS_MAX || situation.mode == ControlMode::Auto {
            return found;
        }
        let Some((floor, mut units)) = self.begin_in_manual(line, situation) else { return found };
        for (at, step) in self.steps.iter().enumerate() {
            let Some(after) = played(&floor, &units, step) else { return found };
            if is_unclear(step) {
                found[at] = self.reason(&floor, &units, at);
            }
            units = after;
        }
        found
    }

    /// Whether presses of *return* alone lead a station home in manual, as along its recovery path.
    pub fn returns_home(&self, line: &Line, situation: &LineSituation, station: StationId) -> bool {
        let begun = self.begin_in_manual(line, situation);
        begun.is_some_and(|(floor, units)| presses_home(&floor, units, station, PanelButton::Return).is_some())
    }

    /// The stations in manual, when what a person has to see to is done.
    pub(crate) fn begin_in_manual<'l>(
        &self,
        line: &'l Line,
        situation: &LineSituation,
    ) -> Option<(PlayedLine<'l>, PlayedStations)> {
        let mut units = self.begin(line, situation)?;
        let floor = PlayedLine::new(line, &units);
        floor.meet(&mut units);
        for at in 0..units.len() {
            let epoch = units[at].report.mode_epoch;
            floor.order(&mut units, at, in_manual(epoch));
        }
        Some((floor, units))
    }

    /// The stations, when what a person has to see to is done.
    fn begin(&self, line: &Line, situation: &LineSituation) -> Option<PlayedStations> {
        let mut reports: Vec<_> = situation.stations.iter().cloned().collect::<Option<_>>()?;
        for step in &self.steps {
            match step.action {
                RecoveryAction::First(Need::FaultSignal(id, input)) => {
                    reports[id.index()].measured &= !input.bit();
                }
                RecoveryAction::First(Need::Axis { station, input, .. }) => {
                    let report = &mut reports[station.index()];
                    report.measured = image::put_onto(line.station(station), report.measured, input.bit());
                    report.position_lost = None;
                }
                _ => {}
            }
        }
        line.station_ids().zip(&reports).map(|(id, report)| unit(line, id, report).ok().map(Rc::new)).collect()
    }

    fn reason(&self, floor: &PlayedLine<'_>, units: &PlayedStations, at: usize) -> Option<StepReason> {
        let step = &self.steps[at];
        let is_still = step.moves.is_empty();
        let ends_at_home = step.after.as_ref().is_some_and(|after| after.at_home);
        let own = |station: StationId| {
            let own = match self.own_reason(floor.line, units, station)? {
                OwnReason::OnTheWayHome if is_still && ends_at_home => OwnReason::AtTheEndOfTheWayHome,
                own => own,
            };
            Some((station, own))
        };
        let mut moved: Vec<StationId> = step.moves.iter().map(|motion| motion.station).collect();
        moved.extend(step.action.station().filter(|_| step.moves.is_empty()));
        moved.dedup();
        let own: Vec<_> = moved.into_iter().filter_map(own).collect();
        let RecoveryAction::Press(station, button) = step.action else {
            return Some(StepReason { own, otherwise: None, back: None });
        };
        let otherwise = self.refused_without(floor, units, at, station);
        let is_stopped = own.iter().any(|(_, own)| matches!(own, OwnReason::Incomplete(_)));
        let is_on_the_way = units[station.index()].report.recovering_home;
        let is_back = button == PanelButton::Return && is_stopped && otherwise.is_none() && !is_on_the_way;
        let back = is_back.then(|| match floor.press(units, station.index(), PanelButton::Advance) {
            Some(on) if on.motions.is_empty() || on.is_doubtful => BackReason::EndNotSeen,
            Some(_) => BackReason::Shorter,
            None => BackReason::NoWayOn,
        });
        (!own.is_empty() || otherwise.is_some()).then_some(StepReason { own, otherwise, back })
    }

    fn own_reason(&self, line: &Line, units: &PlayedStations, id: StationId) -> Option<OwnReason> {
        let (unit, is_task_driven) = (&units[id.index()], line.station(id).is_task_driven());
        if let Some(place) = unit.controller.marking().find(|place| place.is_incomplete()) {
            return Some(OwnReason::Incomplete(place));
        }
        let report = &unit.report;
        match () {
            () if report.position_lost.is_some() => Some(OwnReason::PositionLost),
            () if report.recovering_home => Some(OwnReason::OnTheWayHome),
            () if is_task_driven && !report.at_home => Some(OwnReason::BetweenRests),
            () if self.begins_anew && !report.at_home => Some(OwnReason::Away),
            () => None,
        }
    }

    /// The first later step of another station that is refused if this station stays where it is.
    fn refused_without(
        &self,
        floor: &PlayedLine<'_>,
        units: &PlayedStations,
        at: usize,
        station: StationId,
    ) -> Option<(StationId, StationPlace)> {
        let mut units = units.clone();
        for step in &self.steps[at + 1..] {
            if step.action.station() == Some(station) {
                continue;
            }
            match played(floor, &units, step) {
                Some(after) => units = after,
                None => return step.moves.iter().find(|of| of.station != station).map(|of| (of.station, of.place)),
            }
        }
        None
    }
}

/// How many presses of one button lead a station home, the others standing where they are; none where they do not.
pub(crate) fn presses_home(
    floor: &PlayedLine<'_>,
    mut units: PlayedStations,
    station: StationId,
    button: PanelButton,
) -> Option<usize> {
    // Each operation is done, or taken back, at most once.
    for presses in 1..=floor.line.station(station).operations.len() + 1 {
        units = floor.press(&units, station.index(), button)?.units;
        let report = &units[station.index()].report;
        if report.at_home && report.incomplete.is_empty() {
            return Some(presses);
        }
    }
    None
}

/// The stations after a step; as before where it moves none. None where it has no effect.
fn played(floor: &PlayedLine<'_>, units: &PlayedStations, step: &RecoveryStep) -> Option<PlayedStations> {
    match &step.action {
        RecoveryAction::Press(station, button) => Some(floor.press(units, station.index(), *button)?.units),
        RecoveryAction::Resume => Some(floor.resume(units)?.units),
        RecoveryAction::Rejoin { station, at, .. } => floor.rejoin(units, station.index(), at.at),
        _ => Some(units.clone()),
    }
}
