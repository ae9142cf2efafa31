//! The station's shell: arrivals in, effects out.
//!
//! Order of effects: record, outputs, state, answers, events. So no state is sent that the station would have lost after
//! being killed. What switches outputs off goes first, because a slow disk must not delay it. That is safe: a record that
//! still shows an operation as running restores it as stopped. After a record that took longer than a period nothing is
//! switched on by what was decided before it: the station decides again.

mod health;
mod lifecycle;

use std::fmt::Display;
use std::time::Duration;

use linewright_lifecycle::LifecycleState;
use linewright_line::net::ControlMode;
use linewright_line::{Line, NumberedOrder, StationId, TaskOrderSource, Tick};
use linewright_station_logic::{
    CompileError, Controller, Handled, Ignored, ModeOrder, NO_DELAY, PanelCommand, Restore, RivalCoordinators, Rules,
    StationInput, StationOutbox, StationSnapshot,
};

use crate::effect::{Driven, InputsMessage, ParticipantId, StationArrival, StationEffect};
use crate::held::{HeldByOne, HeldPass};
use crate::newest::NewestBySequence;
use crate::rivals::Rivals;
use crate::rules::ShellRules;

pub use health::StationFacts;

/// No line changes its mode so often while one reader does not receive it: an order whose epoch is further ahead of those
/// that were followed is no coordinator's.
pub const EPOCH_JUMP_MAX: u64 = 1 << 20;

/// A station between its messages.
#[derive(Debug)]
pub struct StationShell {
    rules: ShellRules,
    controller: Controller,
    boot_id: u64,
    /// State of the node; see `lifecycle`.
    lifecycle: LifecycleState,
    outbox: StationOutbox,
    /// A step that was not the last one before [`StationShell::act`] has changed the state.
    is_changed: bool,
    orders: NewestBySequence,
    /// Sender of the order that was followed last.
    coordinator: Option<ParticipantId>,
    order_source: TaskOrderSource,
    /// Coordinators that give orders beside the one that is followed.
    rivals: Rivals,
    contest: Option<RivalCoordinators>,
    /// The panel's buttons.
    advance: HeldByOne,
    retract: HeldByOne,
    images: NewestBySequence,
    states: Vec<NewestBySequence>,
    /// [`InputsMessage::lives`] of the image the controller saw last.
    lives: u64,
    /// The input image the controller saw last.
    inputs: u128,
    /// Outputs of which several are one order.
    orders_by_number: Vec<NumberedOrder>,
    /// Number and lives of the output image that was given last.
    driven: Option<(u64, u64)>,
    /// Bits and number of the output image that was given last.
    image: (u128, u64),
    /// The same of the one before, if a record comes first that may be late.
    before: Option<(u128, u64)>,
    /// Everything was turned off while a record was being written.
    is_interrupted: bool,
    /// Time of the last decision.
    acted: Tick,
    state_sequence: u64,
    image_sequence: u64,
    refresh: Duration,
    refresh_due: Tick,
    stale: Duration,
    /// The longest lease of the description.
    lease: Duration,
    /// Time of the next call that it has requested.
    expected: Tick,
    /// Arrivals before this may have waited while the process stood still: their age is unknown.
    doubts_until: Tick,
    /// Since when orders do not name this start of the station.
    unnamed_since: Tick,
    ignored: u64,
}

impl StationShell {
    /// The shell of `station` in its life `boot_id` (unique per start).
    ///
    /// # Errors
    /// When the station does not compile, or the snapshot is not one of this station's.
    pub fn new(line: &Line, station: StationId, boot_id: u64, restore: Restore) -> Result<Self, CompileError> {
        let stale = line.timing.stale;
        Ok(StationShell {
            rules: ShellRules::ALL,
            controller: Controller::new(line, station, boot_id, restore)?,
            boot_id,
            lifecycle: LifecycleState::Active,
            outbox: StationOutbox::default(),
            is_changed: false,
            orders: NewestBySequence::new(stale),
            coordinator: None,
            order_source: line.station(station).order_source,
            rivals: Rivals::new(line.timing.refresh, stale),
            contest: None,
            advance: HeldByOne::default(),
            retract: HeldByOne::default(),
            images: NewestBySequence::new(stale),
            states: vec![NewestBySequence::new(stale); line.stations.len()],
            lives: 0,
            inputs: 0,
            orders_by_number: line.numbered_orders(station),
            driven: None,
            image: (0, 0),
            before: None,
            is_interrupted: false,
            acted: Tick::ZERO,
            state_sequence: 0,
            image_sequence: 0,
            refresh: line.timing.refresh,
            refresh_due: Tick::ZERO,
            stale,
            lease: line.timing.lease,
            expected: Tick::NEVER,
            doubts_until: Tick::ZERO,
            unnamed_since: Tick::NEVER,
            ignored: 0,
        })
    }

    /// The same without repetitions, for a simulation whose links repeat the last message by themselves.
    #[must_use]
    pub fn without_refresh(mut self) -> Self {
        self.refresh_due = Tick::NEVER;
        self
    }

    /// The same with some rules of the controller switched off.
    #[must_use]
    pub fn with_rules(mut self, rules: Rules) -> Self {
        self.controller = self.controller.with_rules(rules);
        self
    }

    /// The same with some of its own rules switched off.
    #[must_use]
    pub fn with_shell_rules(mut self, rules: ShellRules) -> Self {
        self.rules = rules;
        self
    }

    /// The controller, to look at.
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// Boot id of the station.
    pub fn boot_id(&self) -> u64 {
        self.boot_id
    }

    /// Record for [`StationEffect::Remember`].
    pub fn snapshot(&self) -> StationSnapshot {
        self.controller.snapshot()
    }

    /// The input image the controller saw last.
    pub fn inputs(&self) -> u128 {
        self.inputs
    }

    /// Whether task orders, and orders to leave one, are taken from this participant. True for the one whose order of the mode is followed; for
    /// any where the description has `orders = "any"`. DDS does not authenticate participants: this keeps out what is sent by mistake, not
    /// what is forged.
    pub fn takes_tasks_of(&self, from: ParticipantId) -> bool {
        self.order_source == TaskOrderSource::Any || self.coordinator == Some(from)
    }

    /// Takes an arrival. Follow with [`StationShell::act`], once everything that waits has been taken.
    pub fn handle(&mut self, now: Tick, arrival: StationArrival<'_>, effects: &mut Vec<StationEffect>) {
        self.notice_gap(now);
        let is_doubtful = now < self.doubts_until;
        let handled = match arrival {
            StationArrival::Order { .. } if !self.is_active() => Handled::Taken,
            StationArrival::Order { sequence, from, order } => self.order(now, (sequence, from), order, is_doubtful),
            StationArrival::State { station, sequence, report } => {
                let Some(states) = self.states.get_mut(station.index()) else {
                    self.ignore("a report of a station that is not described", effects);
                    return;
                };
                let is_newest = states.offer(now, report.boot_id, sequence) || !self.rules.numbers;
                if is_newest && !is_doubtful {
                    self.controller.handle(now, StationInput::View(station, report))
                } else {
                    Handled::Taken
                }
            }
            StationArrival::Inputs(message) => {
                let is_newest = self.images.offer(now, message.boot_id, message.sequence) || !self.rules.numbers;
                if is_newest && !is_doubtful {
                    self.inputs_by_message(now, message);
                }
                Handled::Taken
            }
            StationArrival::Devices { bits, valid, losses } => {
                self.image(now, (bits, valid), losses, Tick::NEVER, NO_DELAY);
                Handled::Taken
            }
            StationArrival::Panel { console, command } => self.panel(now, console, command, is_doubtful),
            StationArrival::Rejoin(..) if is_doubtful => {
                self.ignore("rejoin: the node stood still just before it; confirm again", effects);
                return;
            }
            StationArrival::Rejoin(at, numbers) => self.controller.handle(now, StationInput::Rejoin(at, numbers)),
            StationArrival::Task(command) => self.controller.handle(now, StationInput::Task(command)),
        };
        if let Handled::Ignored(why) = handled {
            self.ignore(why.text(), effects);
        }
    }

    /// Counts something that is ignored: a sender of rubbish must not fill a disk.
    pub fn ignore(&mut self, why: impl Display, effects: &mut Vec<StationEffect>) {
        self.ignored += 1;
        if self.ignored.is_power_of_two() {
            effects.push(StationEffect::Ignored { count: self.ignored, why: why.to_string() });
        }
    }

    /// Takes a command of the panel. A button is held by one console at a time.
    fn panel(&mut self, now: Tick, console: u64, command: PanelCommand, is_doubtful: bool) -> Handled {
        let (button, held, released) = match command {
            PanelCommand::Advance(held) => (&mut self.advance, held, PanelCommand::Advance(false)),
            PanelCommand::Retract(held) => (&mut self.retract, held, PanelCommand::Retract(false)),
            PanelCommand::Selector(_) => return self.controller.handle(now, StationInput::Panel(command)),
        };
        // One that was held before the gap may have been released in it.
        if held && is_doubtful {
            button.offer_late(now, console, held, self.stale);
            return Handled::Taken;
        }
        if button.offer(now, console, held, self.stale) == HeldPass::Taken {
            return self.controller.handle(now, StationInput::Panel(command));
        }
        self.controller.handle(now, StationInput::TwoConsoles(now + self.stale));
        self.controller.handle(now, StationInput::Panel(released))
    }

    /// Takes an order. The emergency stop is obeyed whichever coordinator gives it, in whichever of its lives, sequences
    /// and epochs: a stop too many costs a reset.
    fn order(
        &mut self,
        now: Tick,
        (sequence, from): (u64, ParticipantId),
        order: ModeOrder,
        is_doubtful: bool,
    ) -> Handled {
        let handled = self.take_order(now, (sequence, from), order, is_doubtful);
        self.look_for_rivals(now, sequence, &order, is_doubtful);
        handled
    }

    /// Orders of two coordinators in turn are no order: nothing starts while both are received. An emergency stop counts
    /// as none here; it is obeyed from either.
    fn look_for_rivals(&mut self, now: Tick, sequence: u64, order: &ModeOrder, is_doubtful: bool) {
        let Some((followed, _)) = self.orders.current().filter(|_| self.rules.rivals) else { return };
        if order.boot_id == followed {
            self.rivals.forget(followed);
        } else if order.mode != ControlMode::EStop && !is_doubtful {
            self.rivals.hear(now, (order.boot_id, sequence), self.orders.heard());
        }
        let rival = self.rivals.there(now);
        let contest = rival.map(|rival| RivalCoordinators { lives: (followed, rival.life), until: rival.until });
        if contest != self.contest {
            self.contest = contest;
            self.controller.handle(now, StationInput::Contest(contest));
        }
    }

    fn take_order(
        &mut self,
        now: Tick,
        (sequence, from): (u64, ParticipantId),
        order: ModeOrder,
        is_doubtful: bool,
    ) -> Handled {
        // A station that has followed no coordinator yet has nothing to compare with. It follows whatever epoch the line has
        // come to, so that a line comes back from an epoch that was forged when its stations are restarted.
        let followed = self.controller.mode_epoch();
        // What was decided without this start of the station was decided for another one: an order of before an emergency stop
        // that arrives once more would start a motion within it, and a second process would obey beside the first.
        let is_for_other_life = self.rules.lives && order.station_life != self.boot_id;
        self.unnamed_since = if is_for_other_life { self.unnamed_since.min(now) } else { Tick::NEVER };
        let jumps = self.rules.epochs && followed != 0 && order.epoch > followed.saturating_add(EPOCH_JUMP_MAX);
        // Followed, the others would shut out every coordinator that counts as it should, or outlive their sender.
        let why = match () {
            () if is_for_other_life => Some(Ignored::OtherLife),
            () if jumps => Some(Ignored::EpochTooHigh),
            () if self.rules.leases && order.lease > self.lease => Some(Ignored::LeaseTooLong),
            () => None,
        };
        if let Some(why) = why {
            if order.mode == ControlMode::EStop {
                // Of a coordinator that has only to receive this start, a later epoch is decided after the stop.
                let epoch = is_for_other_life.then_some(order.epoch);
                self.controller.handle(now, StationInput::EmergencyStop(order.boot_id, epoch));
            }
            // Until the coordinator has received a station that was started, its orders name none or the start before.
            let is_usual = is_for_other_life && now < self.unnamed_since + 2 * self.stale;
            return if is_usual { Handled::Taken } else { Handled::Ignored(why) };
        }
        let is_newest = self.orders.offer(now, order.boot_id, sequence) || !self.rules.numbers;
        let is_stop = order.mode == ControlMode::EStop;
        match (is_newest && !is_doubtful, is_stop) {
            (true, _) => {
                let handled = self.controller.handle(now, StationInput::Order(order));
                // An emergency stop of an older epoch is obeyed, and not followed.
                if matches!(handled, Handled::Taken) && self.controller.followed() == order.boot_id {
                    self.coordinator = Some(from);
                }
                handled
            }
            (false, true) => self.controller.handle(now, StationInput::EmergencyStop(order.boot_id, None)),
            (false, false) => Handled::Taken,
        }
    }

    fn inputs_by_message(&mut self, now: Tick, message: InputsMessage) {
        // The number of an output image of an earlier life means nothing to this one.
        let (life, number) = message.under;
        let under = if life == self.boot_id { number } else { 0 };
        self.image(now, (message.bits, message.valid), message.lives, now + self.stale, under);
    }

    fn image(&mut self, now: Tick, (bits, valid): (u128, bool), lives: u64, until: Tick, under: u64) {
        if self.lives != lives {
            // A loss shorter than the scan: the devices have started over, so the controller must see it.
            self.lives = lives;
            self.controller.handle(now, StationInput::Inputs { bits: 0, valid: false, until: Tick::NEVER, under });
            self.step_between(now);
        }
        self.inputs = bits;
        self.controller.handle(now, StationInput::Inputs { bits, valid, until, under });
    }

    /// A step whose results are given with those of the next [`StationShell::act`].
    fn step_between(&mut self, now: Tick) {
        self.controller.step(now, &mut self.outbox);
        self.is_changed |= std::mem::take(&mut self.outbox.changed);
    }

    /// The process was stopped, or the machine stood still: what was received before is too old. Views and images are so
    /// by their age; the controller has to see that before anything newer hides it. The lease is longer than that, and
    /// ends.
    fn notice_gap(&mut self, now: Tick) {
        if self.expected == Tick::NEVER || now <= self.expected + self.stale || !self.rules.gaps {
            return;
        }
        self.expected = Tick::NEVER;
        self.doubts_until = now + self.refresh;
        self.controller.handle(now, StationInput::Gap);
        self.step_between(now);
    }

    /// Plays the controller one step further and returns the effects.
    pub fn act(&mut self, now: Tick, effects: &mut Vec<StationEffect>) {
        self.notice_gap(now);
        self.controller.step(now, &mut self.outbox);
        if !self.is_active() {
            self.outbox.outputs = 0;
        }
        let changed = std::mem::take(&mut self.outbox.changed) | std::mem::take(&mut self.is_changed);
        let due = now >= self.refresh_due;
        if due {
            self.refresh_due = now + self.refresh;
        }
        let news = (self.outbox.number, self.lives);
        let drives = due || self.driven != Some(news);
        // No motion is driven in the emergency stop; what may be on is a lamp.
        let switches_on = self.outbox.outputs & !self.staying() != 0 && self.controller.mode() != ControlMode::EStop;
        if drives && !(changed && (switches_on || !self.rules.off_first)) {
            self.drive(news, effects);
        }
        if changed {
            if switches_on && self.rules.off_first {
                self.switch_off(effects);
            }
            effects.push(StationEffect::Remember);
        }
        self.before = (drives && changed && (switches_on || !self.rules.off_first)).then_some(self.image);
        if self.before.is_some() {
            self.drive(news, effects);
        }
        self.acted = now;
        if changed || due {
            self.state_sequence += 1;
            effects.push(StationEffect::Tell { sequence: self.state_sequence });
        }
        effects.extend(self.outbox.replies.drain(..).map(|(key, reply)| StationEffect::Reply(key, reply)));
        effects.extend(self.outbox.events.drain(..).map(StationEffect::Happened));
        self.expected = self.next_deadline().max(now);
    }

    fn drive(&mut self, (number, lives): (u64, u64), effects: &mut Vec<StationEffect>) {
        self.driven = Some((number, lives));
        self.put((self.outbox.outputs, number), effects);
    }

    fn put(&mut self, image: (u128, u64), effects: &mut Vec<StationEffect>) {
        self.image = image;
        self.image_sequence += 1;
        let ((bits, number), sequence, lives) = (image, self.image_sequence, self.lives);
        let mode_epoch = self.controller.mode_epoch();
        effects.push(StationEffect::Drive(Driven { sequence, bits, number, lives, mode_epoch }));
    }

    /// Leaves on only those outputs of before that stay on, under their number: the motion that begins is not driven
    /// yet.
    fn switch_off(&mut self, effects: &mut Vec<StationEffect>) {
        let ((bits, number), staying) = (self.image, self.staying());
        if staying != bits {
            self.put((staying, number), effects);
        }
    }

    /// The outputs of before that stay on.
    fn staying(&self) -> u128 {
        NumberedOrder::staying(&self.orders_by_number, self.image.0, self.outbox.outputs)
    }

    /// The record of [`StationEffect::Remember`] is written. False if that took longer than a period: outputs that follow
    /// in the same effects are not put out, as they were decided on what is old now. All else that follows is performed,
    /// and [`StationShell::act`] is due at once.
    pub fn remembered(&mut self, now: Tick) -> bool {
        let is_late = std::mem::take(&mut self.is_interrupted) || now > self.acted + self.refresh;
        let is_late = is_late && self.rules.late;
        if is_late {
            // What it would switch on is not: the image before is the last one that was given.
            if let Some(before) = self.before.take() {
                (self.image, self.driven) = (before, None);
            }
            self.refresh_due = self.refresh_due.min(now);
        }
        !is_late
    }

    /// The image for when an emergency stop arrives while a record is being written, or the record takes longer than received
    /// state is valid: everything off. The order itself is handled after the record, and nothing that was decided before it
    /// is put out ([`StationShell::remembered`]).
    pub fn interrupt(&mut self) -> Driven {
        self.is_interrupted = true;
        self.before = None;
        self.driven = None;
        self.image.0 = 0;
        self.image_sequence += 1;
        let ((bits, number), sequence, lives) = (self.image, self.image_sequence, self.lives);
        Driven { sequence, bits, number, lives, mode_epoch: self.controller.mode_epoch() }
    }

    /// The image to end with, whatever the reason: everything off.
    pub fn off(&mut self) -> Driven {
        self.image_sequence += 1;
        // A number that no image of this life had: inputs taken under it are taken under none of them.
        let number = self.outbox.number.saturating_add(1);
        let mode_epoch = self.controller.mode_epoch();
        Driven { sequence: self.image_sequence, bits: 0, number, lives: self.lives, mode_epoch }
    }

    /// Time of the next call if nothing arrives before.
    pub fn next_deadline(&self) -> Tick {
        self.controller.next_deadline().unwrap_or(Tick::NEVER).min(self.refresh_due)
    }
}
