//! Reasons why nothing happens: for every state in which the station waits, the conditions it waits for.
//!
//! Called when a state is published, never in the step; it reads the same tables the step reads, so it cannot give a
//! reason the controller does not have. The texts are in `texts`.

use linewright_line::net::{Block, ControlMode, MotionStage, StationPlace, TransitionKind};
use linewright_line::{InputId, Line, OpId, OperationModule, Owner, Tick};

use crate::controller::Controller;
use crate::event::{StationHappening, StopCause};
use crate::parts::{AgreementRefusal, PendingAgreement};
use crate::program::{CompiledTransition, IncomingArrow as Arrow};
use crate::texts::place::{op_names, place_text, rest_text};
use crate::texts::{
    NoReturn, PanelChoice, PositionDoubt, REJOIN_WAY, RejoinAdvice, StationWait, SwitchTense, signal_now_text,
    stuck_text,
};
use crate::views::Comparability;

impl Controller {
    /// Operation of each branch of the station, e.g. `advance clamp` or `undoing 1st lift (stopped)`; of a task-driven station between
    /// its tasks the rest, since the place there stands for the end of whichever task has led to it.
    pub fn operation_text(&self, line: &Line) -> String {
        if let Some(rest) = self.rest().filter(|_| !self.homing.is_driven) {
            return rest_text(line, self.program.station, rest);
        }
        let mut parts: Vec<String> =
            self.marking().map(|place| place_text(line, self.program.station, place)).collect();
        parts.extend(self.homing.is_driven.then(|| "homing".to_owned()));
        parts.join(" + ")
    }

    /// The fault to announce, e.g. `undoing advance clamp: fault signal`; empty when there is none.
    pub fn fault_text(&self, line: &Line) -> String {
        let mut parts = Vec::new();
        for place in self.marking().filter(|place| place.is_incomplete()) {
            let cause = match self.cause_shown(place.op) {
                // Where it is measured changes while it is in doubt.
                cause @ StopCause::IndexDoubtful { .. } => {
                    self.loss().filter(|_| self.doubtful_index().is_some()).unwrap_or(cause)
                }
                cause => cause,
            };
            if cause.is_fault() {
                let of = (self.program.station, place.op);
                let mut text = cause.text_at(line, of, place.block, self.tense_of(cause));
                if let Some(fault) =
                    self.fault_signal(line, place).filter(|_| cause == StopCause::Signal && self.image.valid)
                {
                    text.push_str(signal_now_text(self.image.bits & fault.bit() != 0));
                }
                let undoing = if place.block == Block::Recovery { "undoing " } else { "" };
                parts.push(format!("{undoing}{}: {text}", self.op_name(line, place.op)));
            }
        }
        if let Some(lost) = self.loss() {
            let detail = lost.detail(line, self.program.station);
            if !parts.iter().any(|stopped| stopped.ends_with(&detail)) {
                parts.push(detail);
            }
            // The text of a doubt names the way itself.
            if let Some(way) = self.homing_way(line) {
                parts.push(way);
            } else if self.doubtful_index().is_none() && self.is_read_off() {
                parts.push(REJOIN_WAY.to_owned());
            }
        }
        let is_stopped = |op: OpId| self.marking().any(|place| place.op == op && place.stage != MotionStage::Completed);
        if let Some(stuck) = self.marking.stuck.filter(|stuck| !is_stopped(stuck.op)) {
            let text = |input| line.input_text(Owner::Station(self.program.station), input);
            let behind = stuck.behind.map(text);
            parts.push(stuck_text(self.op_name(line, stuck.op), &text(stuck.input), behind.as_deref()));
        }
        parts.join("; ")
    }

    /// The cause of a stop. One that was reported by switches of both ends is shown until they are seen off, though a button
    /// has been let go since.
    fn cause_shown(&self, op: OpId) -> StopCause {
        let cause = self.marking.causes_of_stop[op.index()];
        let behind = self.marking.stuck.filter(|stuck| stuck.op == op).and_then(|stuck| stuck.behind);
        match (cause, behind) {
            (StopCause::Released, Some(behind)) if self.image.valid && self.image.bits & behind.bit() != 0 => {
                StopCause::BothSwitchesOn { behind }
            }
            _ => cause,
        }
    }

    /// Whether the switch that has stopped a motion is as it was then.
    fn tense_of(&self, cause: StopCause) -> SwitchTense {
        let is_over = match cause {
            StopCause::PositionLost { input, .. } => self.image.valid && self.image.bits & input.bit() != 0,
            StopCause::Interlock { station, input: Some(input), is_on } => self
                .views
                .peers
                .iter()
                .find(|view| view.station == station && self.now < view.measured_until)
                .is_some_and(|view| (view.measured & input.bit() != 0) != is_on),
            _ => false,
        };
        if is_over { SwitchTense::Then } else { SwitchTense::Now }
    }

    /// Loss of its position.
    fn loss(&self) -> Option<StopCause> {
        let (op, input) = self.position_lost()?;
        Some(match self.doubtful_index() {
            Some(_) => StopCause::IndexDoubtful { op, input, places: self.places_apart() },
            None => StopCause::PositionLost { op, input },
        })
    }

    /// Conditions the station waits for. Empty while something moves.
    pub fn blocked_by(&self, line: &Line, now: Tick) -> Vec<String> {
        let mut reasons = Vec::new();
        if let Some((followed, other)) = self.commands.contested(now) {
            reasons.push(StationWait::RivalCoordinators { followed, other }.text());
        }
        if self.panel_is_live() && self.commands.has_two_consoles(now) {
            reasons.push(StationWait::OneConsole.text());
        }
        if !self.image.valid {
            reasons.push(StationWait::Devices.text());
        }
        if let Some(lost) = self.loss() {
            let detail = lost.detail(line, self.program.station);
            reasons.push(StationWait::PositionLost(&detail).text());
        }
        self.explain_generation(line, &mut reasons);
        for place in self.marking() {
            self.explain_place(line, place, now, &mut reasons);
        }
        if let Some(pending) = &self.agreement.pending {
            self.explain_request(line, pending, now, &mut reasons);
        }
        if let Some(AgreementRefusal { by, in_the_way, ops }) = self.agreement.refusal {
            let station = &line.station(by).name;
            let op = in_the_way.map(|op| line.operation((by, op)).name.as_str());
            let ops = self.op_names(line, ops);
            reasons.push(match op {
                Some(op) if !ops.is_empty() => StationWait::Disagreement { station, op, ops: &ops }.text(),
                op => StationWait::EntryRejected { station, op }.text(),
            });
        }
        let mut said = Vec::with_capacity(reasons.len());
        reasons.into_iter().for_each(|reason| {
            if !said.contains(&reason) {
                said.push(reason);
            }
        });
        said
    }

    /// Where advance and return lead an operation that was stopped.
    fn panel_choices(&self, place: StationPlace) -> (Option<PanelChoice>, Option<PanelChoice>) {
        let table = usize::from(self.program.index_of(place));
        let leaves = |action: &&CompiledTransition| action.from.iter().any(|&from| usize::from(from) == table);
        let (mut advance, mut back) = (None, None);
        for action in self.program.actions.iter().filter(leaves) {
            match action.kind {
                TransitionKind::Resume(_, Block::Normal) if self.marking.path.is_some() => {
                    back = Some(PanelChoice::WayHome);
                }
                TransitionKind::Resume(_, Block::Normal) => advance = Some(PanelChoice::GoOn),
                TransitionKind::Again(_) if self.marking.path.is_none() => advance = Some(PanelChoice::DoAgain),
                TransitionKind::Retract(_) if self.marking.path.is_none() => back = Some(PanelChoice::TakeBack),
                TransitionKind::Resume(_, Block::Recovery) => back = Some(PanelChoice::TakeBack),
                TransitionKind::EnterPath(_) if self.marking.path.is_none() => back = Some(PanelChoice::WayHome),
                _ => {}
            }
        }
        (advance, back.filter(|_| !self.is_not_taken_back(place)))
    }

    /// The way back of a station that has lost its memory, or an axis of which is not where its chart has it.
    fn explain_generation(&self, line: &Line, reasons: &mut Vec<String>) {
        let is_doubtful = self.position_lost().is_some() && self.doubtful_index().is_some();
        let is_lost = self.position_lost().is_some();
        if self.program.tasks.is_some() {
            return self.explain_lost_rest(line, reasons);
        }
        if let Some(way) = self.homing_way(line) {
            reasons.push(way);
            return;
        }
        let compares = self.rules.generations && (is_lost || !self.program.peers.is_empty());
        let forgot = self.views.generation == 0;
        if !compares || !(is_lost || (forgot && !self.is_at_home())) {
            return;
        }
        let not_home = |place: StationPlace| self.marking.causes_of_stop[place.op.index()] == StopCause::NotAtHome;
        let doubt = match (is_doubtful, forgot) {
            (true, _) if self.places_apart().is_some() => PositionDoubt::AnotherPlace,
            (true, _) => PositionDoubt::Index,
            (false, true) => PositionDoubt::NoJournal,
            (false, false) => PositionDoubt::AxisOff,
        };
        let ends: Vec<&str> =
            self.steps_read_off().flat_map(|step| self.ops_of_step(step)).map(|op| self.op_name(line, op)).collect();
        reasons.push(match self.read_off() {
            Some(step) if is_lost || self.marking().any(not_home) => {
                let ops = self.op_names(line, self.ops_of_step(step).fold(0, |bits, op| bits | 1 << op.0));
                let index = self.doubtful_index().map(|(op, _)| self.op_name(line, op)).filter(|_| is_doubtful);
                let advice = match index {
                    None => RejoinAdvice::Confirm { ops: &ops },
                    Some(_) if self.places_apart().is_some() => RejoinAdvice::ConfirmPlace,
                    Some(op) => RejoinAdvice::ConfirmIndex { op },
                };
                StationWait::Rejoin(doubt, advice).text()
            }
            None if ends.len() > 1 && (is_lost || self.marking().any(not_home)) => {
                StationWait::Rejoin(doubt, RejoinAdvice::Several { ops: &ends }).text()
            }
            None if is_doubtful || (forgot && self.marking().any(not_home)) => {
                let may_be = self
                    .counts
                    .done
                    .iter()
                    .enumerate()
                    .map(|(op, _)| OpId::at(op))
                    .filter(|&op| self.stands_within(op));
                let may_be: Vec<&str> = may_be.map(|op| self.op_name(line, op)).collect();
                let advice = match may_be.as_slice() {
                    [] => RejoinAdvice::NoOperation,
                    ops => RejoinAdvice::Between { ops },
                };
                StationWait::Rejoin(doubt, advice).text()
            }
            None if is_lost => StationWait::Rejoin(doubt, RejoinAdvice::NoPlace).text(),
            _ => StationWait::NewGeneration.text(),
        });
    }

    fn explain_place(&self, line: &Line, place: StationPlace, now: Tick, reasons: &mut Vec<String>) {
        let name = self.op_name(line, place.op);
        match place.stage {
            MotionStage::Operating => self.explain_motion(line, place, reasons),
            MotionStage::Incomplete => {
                // What it stands in is not known before rejoin.
                let unknown = self.rules.generations && self.views.generation == 0 && self.program.tasks.is_none();
                reasons.extend(match self.cause_shown(place.op) {
                    StopCause::NotAtHome if unknown && !self.program.peers.is_empty() => None,
                    // What ends a doubt is said before; nothing at the panel does.
                    _ if self.doubtful_index().is_some_and(|(op, _)| op == place.op) => None,
                    cause if self.program.index_switch(place.op) != 0 => {
                        Some(StationWait::IndexStopped { op: name, cause }.text())
                    }
                    cause => {
                        let (advance, back) = self.panel_choices(place);
                        Some(StationWait::Stopped { op: name, advance, back, cause }.text())
                    }
                });
                self.explain_fault_signal(line, place, reasons);
                if self.mode() == ControlMode::Manual {
                    self.explain_guard(line, StationPlace { stage: MotionStage::Operating, ..place }, reasons);
                }
                self.explain_way_home(line, place, now, reasons);
            }
            MotionStage::Completed if self.rests_to_be_homed().is_some() => self.explain_homing(line, now, reasons),
            MotionStage::Completed => self.explain_next(line, place, now, reasons),
        }
    }

    /// The fault signal of the motion of a place.
    fn fault_signal(&self, line: &Line, place: StationPlace) -> Option<InputId> {
        let operation = line.operation((self.program.station, place.op));
        match (place.block, &operation.module) {
            (Block::Recovery, OperationModule::Reversible { recovery, .. }) => recovery.fault,
            _ => operation.normal.fault,
        }
    }

    /// A fault signal that is on stops the motion again as soon as it begins.
    fn explain_fault_signal(&self, line: &Line, place: StationPlace, reasons: &mut Vec<String>) {
        let is_on = |input: &InputId| self.image.valid && self.image.bits & input.bit() != 0;
        reasons.extend(self.fault_signal(line, place).filter(is_on).map(|input| {
            let input = line.input_text(Owner::Station(self.program.station), input);
            StationWait::FaultSignal { input: &input, op: self.op_name(line, place.op) }.text()
        }));
    }

    fn explain_motion(&self, line: &Line, place: StationPlace, reasons: &mut Vec<String>) {
        let held_by_hand = self.tokens().iter().any(|t| self.place(t) == place && !t.driven);
        if held_by_hand && self.image.valid && self.mode() != ControlMode::EStop {
            let hand = line.operation((self.program.station, place.op)).hand;
            let button = match place.block {
                Block::Normal => Some(hand.forward()),
                Block::Recovery => hand.back(),
            };
            if let Some(button) = button {
                reasons.push(StationWait::Held { button: &line.buttons[usize::from(button.0)] }.text());
            }
            self.explain_guard(line, place, reasons);
        }
    }

    fn explain_next(&self, line: &Line, place: StationPlace, now: Tick, reasons: &mut Vec<String>) {
        let steps = self.program.causes.len();
        let step = usize::from(self.program.step_of[place.op.index()]);
        let next = if place.block == Block::Normal { (step + 1) % steps } else { step };
        if self.marking().any(|other| !other.is_operating() && other.is_incomplete()) {
            return;
        }
        if let Some(other) = self.marking().find(|other| other.is_operating()) {
            reasons.push(StationWait::Concurrent { op: self.op_name(line, other.op) }.text());
            return;
        }
        if self.marking.path.is_some() && place.block == Block::Recovery {
            reasons.push(StationWait::RecoveryPath.text());
            return;
        }
        for op in self.ops_of_step(next) {
            self.explain_fault_signal(line, StationPlace::operating(op), reasons);
        }
        if self.explain_order(line, place, reasons) {
            return;
        }
        match self.mode() {
            ControlMode::Auto => {
                if self.is_at_home() && self.master_stop() {
                    reasons.push(StationWait::MasterStop.text());
                }
                self.explain_causes(line, next, now, reasons);
            }
            ControlMode::Hand => {
                self.explain_return(line, place, step, reasons);
                self.explain_causes(line, next, now, reasons);
                reasons.push(self.hand_choices(line, place));
            }
            ControlMode::Manual => {
                if self.panel_is_live() {
                    self.explain_missing(line, next as u8, reasons);
                    self.explain_return(line, place, step, reasons);
                    self.explain_causes(line, next, now, reasons);
                    reasons.push(match place.block {
                        _ if self.leads_back(place, step) => StationWait::Panel.text(),
                        block => StationWait::PanelAdvance {
                            op: self.op_name(line, place.op),
                            no_return: match block {
                                Block::Recovery if self.is_at_home() => NoReturn::AtHome,
                                Block::Recovery => NoReturn::Undone,
                                Block::Normal => NoReturn::Irreversible,
                            },
                        }
                        .text(),
                    });
                } else {
                    reasons.push(StationWait::Selector.text());
                }
            }
            ControlMode::Home | ControlMode::StandBy => reasons.push(StationWait::Mode(self.mode()).text()),
            ControlMode::EStop => reasons.push(StationWait::EStop.text()),
        }
    }

    /// Whether the panel's return leads on from this place, at rest at the end of a motion.
    fn leads_back(&self, place: StationPlace, step: usize) -> bool {
        self.ways_back(place, step).next().is_some()
    }

    /// What return does from this place.
    fn ways_back(&self, place: StationPlace, step: usize) -> impl Iterator<Item = &CompiledTransition> {
        self.program.actions.iter().filter(move |action| match (place.block, action.kind) {
            (Block::Normal, TransitionKind::Undo(op)) => op == place.op,
            (Block::Recovery, TransitionKind::Back { from, .. }) => from == step,
            (Block::Recovery, TransitionKind::GiveUp(task)) => {
                self.program.tasks.as_ref().is_some_and(|tasks| tasks.task(task).first == place.op)
            }
            _ => false,
        })
    }

    /// What keeps return from starting its motion.
    fn explain_return(&self, line: &Line, place: StationPlace, step: usize, reasons: &mut Vec<String>) {
        let started = self.ways_back(place, step).flat_map(|action| &action.to);
        let started = started.map(|&to| self.program.places[usize::from(to)].place);
        started.filter(|to| to.is_operating()).for_each(|to| self.explain_guard(line, to, reasons));
    }

    fn hand_choices(&self, line: &Line, place: StationPlace) -> String {
        let hand = line.operation((self.program.station, place.op)).hand;
        let name = |button: linewright_line::ButtonId| line.buttons[usize::from(button.0)].as_str();
        let onward = match place.block {
            Block::Normal => Some(hand.next().unwrap_or(hand.forward())),
            Block::Recovery => hand.restarts_by(),
        };
        let back = match place.block {
            Block::Normal => hand.reverses_from_its_end(),
            Block::Recovery => hand.reverse_on(),
        };
        let leads_back = self.leads_back(place, usize::from(self.program.step_of[place.op.index()]));
        match (place.block, onward, back, hand.back()) {
            (Block::Normal, Some(onward), None, Some(back)) if leads_back => {
                StationWait::ButtonMidway { onward: name(onward), back: name(back) }.text()
            }
            (Block::Recovery, Some(again), None, _) if leads_back && self.rest().is_some() => {
                StationWait::ButtonUndone { again: name(again) }.text()
            }
            _ => StationWait::Button { onward: onward.map(name), back: back.map(name) }.text(),
        }
    }

    fn explain_way_home(&self, line: &Line, place: StationPlace, now: Tick, reasons: &mut Vec<String>) {
        let Some(path) = self.program.paths.iter().position(|&op| op == place.op) else { return };
        if self.marking.path.is_some() || self.mode() != ControlMode::Manual {
            return;
        }
        for &(step, ahead) in &self.program.ways_home[path] {
            let cycle = self.counts.cycle + ahead;
            let causes =
                self.program.causes[usize::from(step)].iter().filter(|c| c.modes[ControlMode::Manual as usize]);
            for cause in causes.filter(|cause| !self.views.holds(cause, ControlMode::Manual, cycle, now)) {
                reasons.push(StationWait::WayHome { cause: &self.cause_text(line, cause, cycle, now) }.text());
            }
        }
    }

    fn explain_causes(&self, line: &Line, step: usize, now: Tick, reasons: &mut Vec<String>) {
        let cycle = self.cycle_of_start(step as u8);
        let mode = self.mode();
        for cause in self.program.causes[step].iter().filter(|c| c.modes[mode as usize]) {
            if !self.views.holds(cause, mode, cycle, now) {
                reasons.push(self.cause_text(line, cause, cycle, now));
            }
        }
        // Motions that the second barrier blocks.
        for op in self.ops_of_step(step) {
            self.explain_guard(line, StationPlace::operating(op), reasons);
        }
    }

    fn explain_guard(&self, line: &Line, place: StationPlace, reasons: &mut Vec<String>) {
        if let Some(guard) = self.violated(place, self.marking.path) {
            let detail = self.interlock(&guard).detail(line, self.program.station);
            let own = place_text(line, self.program.station, place);
            reasons.push(StationWait::Position { detail: &detail, own: &own }.text());
        }
    }

    pub(crate) fn cause_text(&self, line: &Line, cause: &Arrow, cycle: i32, now: Tick) -> String {
        let peer = self.program.peers[cause.peer as usize];
        let (station, op) = (&line.station(peer).name, &line.operation((peer, cause.from)).name);
        let own = self.op_name(line, cause.to);
        let view = &self.views.peers[cause.peer as usize];
        let is_withdrawn = view.request.is_some_and(|request| request.ops & (1 << cause.from.0) != 0);
        let wait = match self.views.standing(cause.peer as usize, cycle, now) {
            Comparability::NotHeard => StationWait::NoState { station, own },
            Comparability::OtherGeneration if self.views.generation == 0 => StationWait::OwnGeneration { own },
            Comparability::OtherGeneration => StationWait::OtherGeneration { station, own },
            Comparability::PositionLost => StationWait::PositionOf { station, own },
            Comparability::TooFarAhead => StationWait::Implausible { station, cycle: view.cycle, own },
            Comparability::Comparable if is_withdrawn => StationWait::BeingWithdrawn { station, op, own },
            Comparability::Comparable => {
                StationWait::Arrow { station, op, cycle: cycle.saturating_sub(cause.lag), own }
            }
        };
        wait.text()
    }

    fn explain_request(&self, line: &Line, pending: &PendingAgreement, now: Tick, reasons: &mut Vec<String>) {
        let ops = self.op_names(line, pending.request.ops);
        for peer in (pending.needs | pending.entered).iter() {
            let view = &self.views.peers[peer];
            let is_heard = now < view.known_until;
            let is_by_counts = self.views.shares_generation(peer);
            let mine = (self.boot_id, pending.request.number);
            let agreed = is_by_counts != pending.entered.contains(peer)
                && matches!(view.verdict, Some((boot, number, None)) if (boot, number) == mine);
            if !agreed {
                let station = &line.station(view.station).name;
                reasons.push(match pending.entered.contains(peer) {
                    true => StationWait::EntryAgreement { station, is_heard }.text(),
                    false => StationWait::Agreement { station, is_heard, ops: &ops }.text(),
                });
            }
        }
    }

    pub(crate) fn op_name<'a>(&self, line: &'a Line, op: OpId) -> &'a str {
        &line.operation((self.program.station, op)).name
    }

    fn op_names(&self, line: &Line, ops: u64) -> String {
        op_names(line, self.program.station, ops)
    }

    /// The text of an event of this station.
    pub fn event_text(&self, line: &Line, event: &StationHappening) -> String {
        event.text(line, self.program.station)
    }
}
