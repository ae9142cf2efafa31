//! The controller of one station: what it remembers, and what it is told. The step is in `step.rs`.
//!
//! Invariants, checked by the tests over all reachable states:
//! * one token per concurrent branch, all in one step of the cycle;
//! * an output is on only in an operating place, with valid devices, outside the emergency stop, and — where a person
//!   holds the motion — while the button is held;
//! * done(o) ≤ started(o) ≤ cycle for every operation, and a count goes back only as [`crate::withdraw`] allows.

use linewright_line::net::{Block, ControlMode, Place, Stage};
use linewright_line::{BRANCHES_MAX, InputId, Line, OpId, Panel, StationId, Tick};
use std::sync::Arc;
use std::time::Duration;

use crate::event::{Cause, Event, Happening};
use crate::order::{OrderKey, Reply, TaskCommand};
use crate::panel::{Commands, Contest, ModeOrder, PanelCommand};
use crate::program::{CompileError, Program, bit};
use crate::report::{Report, Restore};
use crate::rules::Rules;
use crate::slot::Orders;
use crate::step::PASSES_MAX;
use crate::views::Views;
use crate::withdraw::Pending;

/// What a controller is told.
#[derive(Clone, Copy, Debug)]
pub enum Input<'a> {
    /// The station's input image, and whether its devices vouch for it.
    Inputs {
        /// Bit `i` is input `i` of the description.
        bits: u128,
        /// False when a device is lost or has not yet spoken.
        valid: bool,
        /// The image is unknown from then on, unless a newer one arrives; [`Tick::NEVER`] where the source itself
        /// tells when it is lost.
        until: Tick,
        /// [`Outbox::number`] of the newest output image that was in force when it was taken; [`NO_DELAY`] where the
        /// image follows the outputs at once.
        under: u64,
    },
    /// The coordinator's order.
    Order(ModeOrder),
    /// An emergency stop that is no newer order, given by this life of a coordinator: by another one than is followed, or
    /// in a message that came late or twice. In force while it is heard, and until the coordinator that is followed has
    /// ordered the emergency stop too and ended it.
    EmergencyStop(u64),
    /// Another coordinator gives orders beside the one that is followed, or no longer does.
    Contest(Option<Contest>),
    /// The caller stood still for longer than a message lasts: the order's lease has ended.
    Gap,
    /// A newer report of another station.
    View(StationId, &'a Report),
    /// The station's panel, by message.
    Panel(PanelCommand),
    /// An operator's confirmation that the station stands where its switches say (see [`Controller::read_off`]), or was
    /// stopped in this operation.
    Rejoin(Option<OpId>),
    /// An order for a task, or about one; for a station that works on order.
    Task(TaskCommand<'a>),
}

/// An image that is never older than the outputs: from a bus of the station's own, or from a test.
pub const NO_DELAY: u64 = u64::MAX;

/// What a step gives.
#[derive(Clone, Debug, Default)]
pub struct Outbox {
    /// The output image: bit `i` is output `i` of the description.
    pub outputs: u128,
    /// Grows with every change of the output image, and with every motion that begins.
    pub number: u64,
    /// The report differs from that of the step before: send it.
    pub changed: bool,
    /// What happened, in order. The caller drains it.
    pub events: Vec<Event>,
    /// What is answered to orders, in order. The caller drains it; whatever of it gets lost, the report says as well.
    pub replies: Vec<(OrderKey, Reply)>,
}

/// Who keeps a motion going.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Run {
    /// The controller.
    Auto,
    /// A held hand-mode button: the actuator is driven while it is down.
    Hand,
    /// A held panel button: the motion is stopped when it is released.
    Manual,
}

/// One token: where a branch of the station stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Token {
    pub place: u16,
    pub run: Run,
    /// The completion signal counts: it has been seen off since the motion left its other end.
    pub left_start: bool,
    /// It will count as it stands, in the first image taken while this motion is driven: the motion was stopped
    /// between its ends, and an image from before it may still show the switch that the mechanism has left since.
    pub awaits_image: bool,
    /// The output image that began to drive it.
    pub driven_since: u64,
    pub driven: bool,
    /// While driven: when the watchdog runs out.
    pub deadline: Tick,
    /// While not driven: what is left of the watchdog.
    pub remaining: Duration,
}

/// As many transitions as one step can fire: every branch once in each pass.
const FIRED_MAX: usize = PASSES_MAX * BRANCHES_MAX;

/// The controller of one station.
#[derive(Clone, Debug)]
pub struct Controller {
    /// Shared by all copies of a controller: a checker makes many.
    pub(crate) program: Arc<Program>,
    pub(crate) rules: Rules,
    pub(crate) boot_id: u64,
    pub(crate) now: Tick,
    pub(crate) tokens: [Token; BRANCHES_MAX],
    pub(crate) token_count: usize,
    pub(crate) cycle: i32,
    pub(crate) done: Vec<i32>,
    pub(crate) started: Vec<i32>,
    pub(crate) home_counts: Vec<i32>,
    pub(crate) initial_round: i32,
    pub(crate) path: Option<OpId>,
    pub(crate) causes_of_stop: Vec<Cause>,
    pub(crate) views: Views,
    pub(crate) commands: Commands,
    panel: Panel,
    /// The inputs the panel is wired to.
    pub(crate) panel_inputs: u128,
    /// Those, and the ones that the marked places look at: a change of any other means nothing now.
    pub(crate) watched: u128,
    stale: Duration,
    pub(crate) inputs: u128,
    pub(crate) inputs_until: Tick,
    pub(crate) inputs_under: u64,
    pub(crate) devices_valid: bool,
    /// Command levels of this image and of the one before.
    pub(crate) levels: u128,
    pub(crate) levels_before: u128,
    pub(crate) mode_before: ControlMode,
    pub(crate) pending: Option<Pending>,
    /// Of a station that works on order.
    pub(crate) orders: Option<Box<Orders>>,
    pub(crate) next_request: u64,
    /// The last refusal, for the operator: who, its operation in the way, our operations that stay.
    pub(crate) refusal: Option<(StationId, OpId, u64)>,
    /// As it was noted last (see `interlock`).
    pub(crate) lost_before: Option<(OpId, InputId)>,
    /// Fresh from the start: the home position is still to be confirmed by the devices.
    pub(crate) unconfirmed: bool,
    /// The marking was read off the switches, or follows from a marking that was. False after a start away from home, and with
    /// a record that may be older than the mechanism's place.
    pub(crate) placed: bool,
    pub(crate) outputs: u128,
    pub(crate) output_number: u64,
    pub(crate) dirty: bool,
    /// The last step changed nothing, and nothing was heard since: until the deadline a step has nothing to do.
    pub(crate) settled: bool,
    /// The transitions the last look fired, the first `fired_count` of them.
    fired: [u16; FIRED_MAX],
    fired_count: usize,
    pub(crate) deadline: Tick,
    pub(crate) changed: bool,
    pub(crate) events: Vec<Event>,
}

impl Controller {
    /// A controller for `station`, living its life number `boot_id` (unique per start).
    ///
    /// Restored from a snapshot, whatever was moving counts as stopped: its outputs went off when the controller
    /// ended, and a person should look before it moves again.
    ///
    /// # Errors
    /// When the station does not compile, or the snapshot is not one of this station's.
    pub fn new(line: &Line, station: StationId, boot_id: u64, restore: Restore) -> Result<Self, CompileError> {
        let program = Program::compile(line, station)?;
        let described = line.station(station);
        let operations_of: Vec<usize> = program.peers.iter().map(|&peer| line.station(peer).operations.len()).collect();
        let views = Views::new(&program, &operations_of, line.timing.stale);
        let round = described.initial_round();
        let counts: Vec<i32> = described.op_ids().map(|op| described.home_count(op, round)).collect();
        let idle = Token::at(program.home_place);
        let mut controller = Controller {
            rules: Rules::default(),
            boot_id,
            now: Tick::ZERO,
            tokens: [idle; BRANCHES_MAX],
            token_count: 1,
            cycle: round,
            done: counts.clone(),
            started: counts,
            home_counts: described.op_ids().map(|op| described.home_count(op, 0)).collect(),
            initial_round: round,
            path: None,
            causes_of_stop: vec![Cause::Released; described.operations.len()],
            views,
            commands: Commands::new(),
            watched: u128::MAX,
            panel_inputs: inputs_of(&described.panel),
            panel: described.panel.clone(),
            stale: line.timing.stale,
            inputs: 0,
            inputs_until: Tick::ZERO,
            inputs_under: 0,
            devices_valid: false,
            levels: 0,
            levels_before: 0,
            mode_before: ControlMode::StandBy,
            pending: None,
            orders: program.on_order.as_ref().map(|_| Box::new(Orders::new(boot_id))),
            next_request: 1,
            refusal: None,
            lost_before: None,
            unconfirmed: restore == Restore::Fresh,
            placed: restore == Restore::Fresh,
            outputs: 0,
            output_number: 0,
            dirty: true,
            settled: false,
            fired: [0; FIRED_MAX],
            fired_count: 0,
            deadline: Tick::ZERO,
            changed: true,
            events: Vec::with_capacity(64),
            program: Arc::new(program),
        };
        controller.come_up(restore)?;
        Ok(controller)
    }

    /// The same controller with some rules switched off, for a checker that must be seen to miss them.
    #[must_use]
    pub fn with_rules(mut self, rules: Rules) -> Self {
        self.rules = rules;
        self.views.rules = rules;
        self
    }

    pub(crate) fn tokens(&self) -> &[Token] {
        &self.tokens[..self.token_count]
    }

    pub(crate) fn place(&self, token: &Token) -> Place {
        self.program.places[token.place as usize].place
    }

    /// The places that hold a token.
    pub fn marking(&self) -> impl Iterator<Item = Place> + '_ {
        self.tokens().iter().map(|t| self.place(t))
    }

    /// The station it controls.
    pub fn station(&self) -> StationId {
        self.program.station
    }

    /// The stations whose state it needs to hear.
    pub fn peers(&self) -> &[StationId] {
        &self.program.peers
    }

    /// The mode it acts on.
    pub fn mode(&self) -> ControlMode {
        self.commands.mode()
    }

    /// The newest mode epoch it has heard.
    pub fn mode_epoch(&self) -> u64 {
        self.commands.epoch()
    }

    /// The cycle it is in.
    pub fn cycle(&self) -> i32 {
        self.cycle
    }

    /// The transitions that the last step that did anything has fired, in order, as indices into the station's net.
    pub fn fired(&self) -> &[u16] {
        &self.fired[..self.fired_count]
    }

    pub(crate) fn note_fired(&mut self, transition: u16) {
        if let Some(slot) = self.fired.get_mut(self.fired_count) {
            *slot = transition;
            self.fired_count += 1;
        }
    }

    pub(crate) fn forget_fired(&mut self) {
        self.fired_count = 0;
    }

    /// Takes what has arrived. Follow with [`Controller::step`]. Gives false if the input was ignored: an order of an
    /// older epoch, a report of no peer or of the wrong shape.
    #[inline]
    pub fn handle(&mut self, now: Tick, input: Input<'_>) -> bool {
        self.now = self.now.max(now);
        if let Input::Inputs { bits, valid, until, under } = input {
            self.inputs_until = until;
            self.settled &= under == self.inputs_under;
            self.inputs_under = under;
            self.take_image(if valid { bits } else { 0 }, valid);
            // A longer term needs no new deadline: the old one comes too early, and is put right.
            self.deadline = self.deadline.min(until);
            return true;
        }
        // Commands and views: levels and deadlines are worked out again in the next step.
        self.deadline = Tick::ZERO;
        self.take(input)
    }

    fn take(&mut self, input: Input<'_>) -> bool {
        let now = self.now;
        match input {
            Input::Inputs { .. } => true,
            Input::Order(order) => {
                let epoch = self.commands.epoch();
                let taken = self.commands.order(now, order, self.stale);
                if taken && let Some(founding) = order.found {
                    self.found(founding);
                }
                self.changed |= self.commands.epoch() != epoch;
                taken
            }
            Input::EmergencyStop(life) => {
                self.commands.stop(now, life, self.stale);
                true
            }
            Input::Contest(contest) => {
                self.commands.contest(contest);
                self.changed = true;
                true
            }
            Input::Gap => {
                self.commands.end_lease(now);
                true
            }
            Input::View(station, report) => {
                let me = (self.program.station, self.boot_id);
                let answer = |views: &Views| views.peers.iter().find(|v| v.station == station).map(|v| v.answer);
                let before = answer(&self.views);
                let taken = self.views.hear(now, me, &self.program, &self.started, station, report);
                self.changed |= before != answer(&self.views);
                taken
            }
            Input::Task(command) => self.command(command),
            Input::Rejoin(within) => self.rejoin(within),
            Input::Panel(command) => {
                let before = self.commands.selector_manual();
                self.commands.panel(now, command, self.stale);
                self.changed |= before != self.commands.selector_manual();
                true
            }
        }
    }

    #[inline]
    pub(crate) fn take_image(&mut self, bits: u128, valid: bool) {
        let differing = bits ^ self.inputs;
        self.inputs = bits;
        if differing & self.watched != 0 || valid != self.devices_valid {
            self.take_watched(differing, valid);
        }
    }

    /// Something changed that matters where the tokens stand, or at the panel.
    fn take_watched(&mut self, differing: u128, valid: bool) {
        let bits = self.inputs;
        self.settled = false;
        // Others hold their motions by these.
        self.changed |= differing & self.program.interlocks.read_by_others != 0;
        if differing & self.panel_inputs == 0 && valid == self.devices_valid {
            return;
        }
        self.deadline = Tick::ZERO;
        if valid != self.devices_valid {
            self.devices_valid = valid;
            self.changed = true;
            self.note(Happening::Devices(valid));
            // A button that is down when the devices come back was not pressed now.
            self.commands.disarm(u128::MAX);
        }
        let wired = |input: Option<InputId>| input.is_some_and(|input| bits & (1 << input.0) != 0);
        let (manual, advance, retract) =
            (wired(self.panel.manual), wired(self.panel.advance), wired(self.panel.retract));
        let before = self.commands.selector_manual();
        self.commands.wired(manual, advance, retract);
        self.changed |= before != self.commands.selector_manual();
        if valid && self.unconfirmed {
            self.confirm_home();
        }
    }

    /// Switched on for the first time, the station claims to be at home. If the switch of the home operation does not
    /// say so, the home operation is incomplete instead, and counts one less: a person brings it home.
    fn confirm_home(&mut self) {
        self.unconfirmed = false;
        let home = self.program.home;
        let at_rest =
            if self.rules.positions { self.program.places[usize::from(self.program.home_place)].rest } else { 0 };
        let needed = self.home_switch() | at_rest;
        if self.inputs & needed != needed {
            self.tokens[0].place = self.program.index_of(Place::incomplete(home));
            self.placed = false;
            self.done[home.index()] -= 1;
            self.causes_of_stop[home.index()] = Cause::NotAtHome;
            self.note(Happening::Stopped(home, Block::Normal, Cause::NotAtHome));
            self.dirty = true;
            self.changed = true;
        }
    }

    /// How long ago the input image was taken, as far as this station can tell.
    pub(crate) fn image_age(&self) -> Duration {
        if self.inputs_until == Tick::NEVER {
            return Duration::ZERO;
        }
        self.stale.saturating_sub(self.inputs_until.since(self.now))
    }

    pub(crate) fn note(&mut self, what: Happening) {
        self.events.push(Event { cycle: self.cycle, what });
    }

    /// When to step again if nothing arrives before.
    pub fn next_deadline(&self) -> Option<Tick> {
        (self.deadline != Tick::NEVER).then_some(self.deadline)
    }

    pub(crate) fn refresh_path(&mut self) {
        let bits = self.path.map_or(0, |op| bit::ANY_PATH | crate::program::path_bit(&self.program.paths, op));
        self.levels = self.levels & !(bit::ANY_PATH | bit::PATHS) | bits;
        self.levels_before = self.levels;
    }

    /// How often the station has come home since the line first stood at home together; on order nobody counts that.
    pub(crate) fn home_round(&self) -> i32 {
        if self.program.on_order.is_some() { 0 } else { self.done[self.program.home.index()] - self.initial_round }
    }

    pub(crate) fn stop_bit(&self) -> u128 {
        if self.commands.stops_at(self.home_round()) { bit::MASTER_STOP } else { 0 }
    }

    /// Coming home or being taken back from there decides anew whether master stop holds the station.
    pub(crate) fn refresh_stop(&mut self) {
        self.levels = self.levels & !bit::MASTER_STOP | self.stop_bit();
        self.levels_before = self.levels_before & !bit::MASTER_STOP | self.stop_bit();
    }

    pub(crate) fn master_stop(&self) -> bool {
        self.levels & bit::MASTER_STOP != 0
    }

    pub(crate) fn master_stop_is_given(&self) -> bool {
        self.commands.is_stopping()
    }

    pub(crate) fn panel_is_live(&self) -> bool {
        self.commands.panel_is_live()
    }

    /// At home: the home operation is complete, or everything after it has been undone — the same position. On order: at
    /// any rest.
    pub fn is_at_home(&self) -> bool {
        if self.program.on_order.is_some() {
            return self.rest().is_some();
        }
        let after = (usize::from(self.program.step_of[self.program.home.index()]) + 1) % self.program.causes.len();
        self.path.is_none()
            && self.marking().all(|place| {
                place == Place::completed(self.program.home)
                    || (place.block == Block::Recovery
                        && place.stage == Stage::Completed
                        && usize::from(self.program.step_of[place.op.index()]) == after)
            })
    }
}

fn inputs_of(panel: &Panel) -> u128 {
    [panel.manual, panel.advance, panel.retract].into_iter().flatten().fold(0, |bits, input| bits | 1 << input.0)
}
