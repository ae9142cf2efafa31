//! The operator of a cell with its real stations: follows the recovery plan, and answers alarms by where the part is.

use std::time::Duration;

use linewright_coordinator_cell::exception::{
    AlarmSubject, LeadDirection, RecoveryDecision, StationsToLead, Whereabouts,
};
use linewright_coordinator_cell::texts::ListedAnswer;
use linewright_coordinator_cell::{ActivityPhase, AlarmId, FiringId, OngoingActivity, PlayerInput};
use linewright_coordinator_shell::CoordinatorArrival;
use linewright_line::StationId;
use linewright_plant::{NestPosition, PartNo};
use linewright_recovery::{
    ActivityEnd, DecidedEnd, LineSituation, Need, PanelButton, RecoveryAction, RecoveryEnd, RecoveryStep,
    StandingAlarm, as_received, plan,
};
use linewright_station_logic::{PanelCommand, RejoinAt};

use super::{FloorWorld, LONG};

/// Longer than any mode, report or order takes.
const MOMENT: Duration = Duration::from_millis(800);
/// Steps of one way back. The longest plan has fewer.
const STEPS_MAX: usize = 200;
/// Waits for one need, once all faults are over.
const WAITS_MAX: usize = 150;

impl FloorWorld {
    /// What a console receives.
    fn situation(&self) -> LineSituation {
        let report = |id: StationId| {
            let is_heard = self.is_received(id) && self.shell.coordinator().hears(id);
            is_heard.then(|| as_received(self.floor().controller(id).report()))
        };
        let coordinator = self.shell.coordinator();
        let stations = self.line.station_ids().map(report).collect();
        let (mode, enabled) = (coordinator.mode(), coordinator.order().enabled);
        let mut seen = LineSituation::read(&self.line, mode, enabled, coordinator.standing(), stations);
        seen.alarms = self.sim.state().exceptions().alarms().map(|alarm| self.standing(alarm.id)).collect();
        let about = |firing: FiringId| {
            self.sim.state().exceptions().alarms().any(|alarm| alarm.about == AlarmSubject::Firing(firing))
        };
        let failed = |of: &&OngoingActivity| of.phase != ActivityPhase::Running && !about(of.id);
        let name = |of: &OngoingActivity| self.sim.table.mode_name(of.mode).to_owned();
        seen.unsettled = self.sim.state().firings().filter(failed).map(name).collect();
        seen
    }

    fn standing(&self, id: AlarmId) -> StandingAlarm {
        let alarm = self.sim.state().exceptions().alarm(id).unwrap_or_else(|| unreachable!("it has just been listed"));
        let (coordination, now) = (&self.sim.coordination, self.sim.now);
        let StationsToLead { lead, reset, at_order, reason } = coordination.alarm_leads(now, alarm);
        let end = reason.map(|reason| DecidedEnd {
            end: match reason.direction() {
                LeadDirection::On => ActivityEnd::Done,
                LeadDirection::Back => ActivityEnd::TakenBack,
            },
            because: String::new(),
        });
        StandingAlarm {
            id: id.0,
            text: coordination.alarm_text(now, alarm),
            answers: alarm.words.iter().map(|word| ListedAnswer::from(word.as_str())).collect(),
            lead,
            reset,
            at_order,
            end,
            bring: coordination.alarm_brings(now, alarm),
        }
    }

    /// Brings the cell back to auto where it is not, answers what is asked, and takes into service what is left out.
    ///
    /// # Errors
    /// What the plan does not lead out of, once no fault lasts.
    pub fn look_after(&mut self) -> Result<(), String> {
        let mut waits = 0;
        for _ in 0..STEPS_MAX {
            let seen = self.situation();
            let plan = plan(&self.line, &seen);
            let Some(step) = plan.steps.first().cloned() else {
                let is_stuck = matches!(plan.end, RecoveryEnd::NoWay { .. } | RecoveryEnd::Misfit(_));
                if is_stuck && self.is_calm() {
                    waits += 1;
                    if waits > WAITS_MAX {
                        return Err(format!("no way back: {:?}; {}", plan.end, self.described()));
                    }
                    self.run(MOMENT);
                    continue;
                }
                self.take_into_service();
                return Ok(());
            };
            let is_wait = self.do_step(&step);
            waits = if is_wait && self.is_calm() { waits + 1 } else { 0 };
            let is_to_bring =
                plan.steps.iter().any(|step| matches!(step.action, RecoveryAction::First(Need::Bring(..))));
            if waits > WAITS_MAX && is_to_bring {
                self.is_left_standing = true;
                return Ok(());
            }
            if waits > WAITS_MAX {
                return Err(format!("the plan waits without an end: {}; {}", step.text(&self.line), self.described()));
            }
            if self.finding.is_some() || self.now > LONG {
                return Ok(());
            }
        }
        match self.is_calm() {
            true => Err(format!("the plan does not end: {}", self.described())),
            false => Ok(()),
        }
    }

    fn take_into_service(&mut self) {
        let down: Vec<_> = self.sim.state().exceptions().down().map(|(resource, _)| resource).collect();
        for resource in down {
            self.say(PlayerInput::Resource { resource, up: true });
        }
    }

    fn say(&mut self, what: PlayerInput<'_>) {
        let mut by = self.dispatcher();
        self.sim.say(&mut by, &[what]);
    }

    /// Whether it was only waited.
    fn do_step(&mut self, step: &RecoveryStep) -> bool {
        let text = step.text(&self.line);
        self.note(format!("the operator: {}", text.chars().take(200).collect::<String>()));
        match &step.action {
            RecoveryAction::First(need) => return self.see_to(need),
            RecoveryAction::Command(command) => {
                self.shell.handle(self.now, CoordinatorArrival::Command(*command));
            }
            RecoveryAction::ManualAlone(station) => {
                self.shell.handle(self.now, CoordinatorArrival::Single(*station, true));
            }
            RecoveryAction::AutoAgain(station) => {
                self.shell.handle(self.now, CoordinatorArrival::Single(*station, false));
            }
            RecoveryAction::Press(station, button) => {
                let press = |held| match button {
                    PanelButton::Advance => PanelCommand::Advance(held),
                    PanelButton::Return => PanelCommand::Retract(held),
                };
                self.held = Some((*station, press(false)));
                self.run(Duration::from_millis(100));
                self.held = Some((*station, press(true)));
                self.run(step.hold(&self.line));
                self.held = Some((*station, press(false)));
                self.run(Duration::from_millis(100));
                self.held = None;
            }
            RecoveryAction::Resume => {
                self.resumes = true;
                self.run(step.hold(&self.line));
                self.resumes = false;
            }
            RecoveryAction::Hold { button, .. } => {
                self.buttons = 1 << button.0;
                self.run(step.hold(&self.line));
                self.buttons = 0;
            }
            RecoveryAction::Selector(station, manual) => {
                let (station, turned) = (*station, PanelCommand::Selector(*manual));
                self.floor_mut().press(station, turned);
            }
            RecoveryAction::Rejoin { station, at, or } => {
                let seen = self.stood_in.get(station).map(|op| RejoinAt::Within(*op));
                let at = seen.filter(|seen| or.iter().any(|of| of.at == *seen)).unwrap_or(at.at);
                self.floor_mut().rejoin(*station, at);
            }
        }
        self.run(MOMENT);
        false
    }

    /// What the machine or a person beside it has to do; whether that was only waited for.
    fn see_to(&mut self, need: &Need) -> bool {
        match need {
            Need::Answer(alarm) => {
                let id = AlarmId(alarm.id);
                let word = self.answer(id);
                if let Some(word) = word {
                    self.note(format!("the operator answers {word}"));
                    self.say(PlayerInput::Answer { alarm: id, word: &word });
                }
            }
            Need::Reset(station) => self.say(PlayerInput::Reset(*station)),
            _ => {}
        }
        self.run(Duration::from_secs(2));
        true
    }

    /// The answer that fits where the part is; one that has fallen is put back before.
    fn answer(&mut self, id: AlarmId) -> Option<String> {
        let alarm = self.sim.state().exceptions().alarm(id)?.clone();
        let AlarmSubject::Firing(firing) = alarm.about else { return alarm.words.first().cloned() };
        let rulings = self.sim.coordination.rulings(id);
        let mut found = self.found(firing)?;
        self.note(format!("the part is {found:?}"));
        if found == Whereabouts::Gone && self.put_back(firing) {
            found = Whereabouts::From;
            self.note("it has fallen, and is put back");
        }
        let means = |part: Whereabouts| rulings.iter().find(|ruling: &&RecoveryDecision| ruling.part == part);
        means(found).map(|ruling| ruling.word.clone())
    }

    /// Puts a part that has fallen where it came from, or takes it away; whether it is back.
    fn put_back(&mut self, firing: FiringId) -> bool {
        let Some((mode, part)) = self.sim.state().firing(firing).and_then(|of| Some((of.mode, of.part?))) else {
            return false;
        };
        let from = self.sim.table.handling().mode(mode).from;
        let name = from.map(|id| self.sim.table.handling().resource_name(id).to_owned());
        let nest = self.resource_at.iter().find(|(_, of)| Some(*of) == name.as_ref()).map(|(nest, _)| *nest);
        let known = self.sim.state().part(part).and_then(|part| u16::try_from(part.position?).ok());
        let (now, no) = (self.now, PartNo(part.0));
        let plant = self.floor_mut().plant_mut();
        let is_away = plant.take(now, no).is_ok();
        let position = known.unwrap_or(1);
        is_away && nest.is_some_and(|nest| plant.put(now, no, NestPosition { nest, position }).is_ok())
    }

    /// Where the part of an activity is.
    fn found(&self, firing: FiringId) -> Option<Whereabouts> {
        let of = self.sim.state().firing(firing)?;
        let handled = self.sim.table.handling().mode(of.mode);
        let part = of.part?;
        let before = self.works_before.get(&firing).copied().unwrap_or(0);
        if handled.from == handled.to {
            let is_done = self.works_on(Some(part)) > before;
            return Some(if is_done { Whereabouts::To } else { Whereabouts::From });
        }
        let plant = self.floor().plant();
        let Some((_, at)) = plant.parts().find(|(no, _)| *no == PartNo(part.0)) else { return Some(Whereabouts::Gone) };
        let Some(NestPosition { nest, .. }) = at.spot else {
            return Some(if at.hand.is_some() { Whereabouts::Carrier } else { Whereabouts::Gone });
        };
        let resource = self.resource_at.get(&nest).and_then(|name| self.sim.table.handling().resource_named(name));
        match resource {
            resource if resource.is_some() && resource == handled.to => Some(Whereabouts::To),
            resource if resource.is_some() && resource == handled.from => Some(Whereabouts::From),
            _ => None,
        }
    }
}
