//! The controller of one station: its state and its input. The step is in `step.rs`.
//!
//! Invariants, checked by the tests over all reachable states:
//! * one token per concurrent branch, all in one step of the cycle;
//! * an output is on only in an operating place, with valid devices, outside the emergency stop, and — where a person
//!   holds the motion — while the button is held;
//! * done(o) ≤ started(o) ≤ cycle for every operation, and a count goes back only as [`crate::withdraw`] allows.

use linewright_line::net::{Block, ControlMode, MotionStage, StationPlace};
use linewright_line::{BRANCHES_MAX, InputId, Line, Panel, StationId, Tick};
use std::sync::Arc;
use std::time::Duration;

use crate::event::{HappeningKind, StationHappening, StopCause};
use crate::homing::Homing;
use crate::ignored::{Handled, Ignored};
use crate::order::{OrderKey, TaskCommand, TaskReply};
use crate::panel::{Commands, ModeOrder, PanelCommand, RivalCoordinators};
use crate::parts::{Agreement, Counts, Due, Fired, Levels, StationImage, StationMarking, StationOutput, Token};
use crate::program::{CompileError, Program, bit};
use crate::rejoin::RejoinAt;
use crate::report::{Restore, StationReport};
use crate::rules::{OrderRules, Rules};
use crate::slot::OrderSlot;
use crate::views::PeerViews;

/// Input of a controller.
#[derive(Clone, Copy, Debug)]
pub enum StationInput<'a> {
    /// The station's input image, and whether its devices vouch for it.
    Inputs {
        /// Bit `i` is input `i` of the description.
        bits: u128,
        /// False when a device is lost or has not yet sent.
        valid: bool,
        /// The image is unknown from then on, unless a newer one arrives; [`Tick::NEVER`] where the source itself
        /// reports its loss.
        until: Tick,
        /// [`StationOutbox::number`] of the newest output image that was in force when it was taken; [`NO_DELAY`] where the
        /// image follows the outputs at once.
        under: u64,
    },
    Order(ModeOrder),
    /// An emergency stop that is no newer order, given by this life of a coordinator: by another one than is followed, or
    /// in a message that came late or twice. In force while it is received, and until the coordinator that is followed
    /// has ordered the emergency stop too and ended it. With its epoch where it is of the coordinator that has still to be followed: a
    /// later epoch of that ends it.
    EmergencyStop(u64, Option<u64>),
    /// Another coordinator gives orders beside the one that is followed, or no longer does.
    Contest(Option<RivalCoordinators>),
    /// The caller stood still for longer than a message lasts: the order's lease has ended.
    Gap,
    /// A newer report of another station.
    View(StationId, &'a StationReport),
    /// The station's panel, by message.
    Panel(PanelCommand),
    /// Two consoles send a button of the panel, which counts for neither; named in `blocked_by` until this time.
    TwoConsoles(Tick),
    /// An operator's confirmation of where the station stands, with the parameters of the task that it stands in.
    Rejoin(RejoinAt, &'a [(Arc<str>, i32)]),
    /// An order for a task, or about one; for a task-driven station.
    Task(TaskCommand<'a>),
}

/// An image that is never older than the outputs: from a bus of the station's own, or from a test.
pub const NO_DELAY: u64 = u64::MAX;

/// Output of a step.
#[derive(Clone, Debug, Default)]
pub struct StationOutbox {
    /// The output image: bit `i` is output `i` of the description.
    pub outputs: u128,
    /// Grows with every change of the output image, and with every motion that begins.
    pub number: u64,
    /// The report differs from that of the step before: send it.
    pub changed: bool,
    /// Events, in order. The caller drains them.
    pub events: Vec<StationHappening>,
    /// Replies to orders, in order. The caller drains them; a reply that gets lost is in the report as well.
    pub replies: Vec<(OrderKey, TaskReply)>,
}

/// The controller of one station.
#[derive(Clone, Debug)]
pub struct Controller {
    /// Shared by all copies of a controller: a checker makes many.
    pub(crate) program: Arc<Program>,
    pub(crate) rules: Rules,
    pub(crate) boot_id: u64,
    /// Age at which a message or an image is stale.
    pub(crate) stale: Duration,
    panel: Panel,
    pub(crate) now: Tick,
    pub(crate) marking: StationMarking,
    pub(crate) counts: Counts,
    pub(crate) image: StationImage,
    pub(crate) views: PeerViews,
    pub(crate) commands: Commands,
    pub(crate) levels: Levels,
    pub(crate) agreement: Agreement,
    pub(crate) homing: Homing,
    /// Operations that have gone on since *resume* is held, a bit each; see `resume`.
    pub(crate) resumed: u64,
    /// Of a task-driven station.
    pub(crate) orders: Option<Box<OrderSlot>>,
    pub(crate) output: StationOutput,
    pub(crate) due: Due,
    pub(crate) fired: Fired,
    pub(crate) events: Vec<StationHappening>,
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
        let views = PeerViews::new(&program, &operations_of, line.timing.stale);
        let round = described.initial_round();
        let counts: Vec<i32> = described.op_ids().map(|op| described.home_count(op, round)).collect();
        let mut controller = Controller {
            rules: Rules::default(),
            boot_id,
            stale: line.timing.stale,
            now: Tick::ZERO,
            marking: StationMarking {
                tokens: [Token::at(program.home_place); BRANCHES_MAX],
                count: 1,
                path: None,
                causes_of_stop: vec![StopCause::Released; described.operations.len()],
                unconfirmed: restore == Restore::Fresh,
                placed: restore == Restore::Fresh,
                axis_place: 0,
                doubtful: None,
                stuck: None,
                lost_position: None,
            },
            counts: Counts {
                cycle: round,
                done: counts.clone(),
                started: counts,
                at_home: described.op_ids().map(|op| described.home_count(op, 0)).collect(),
                initial_round: round,
            },
            image: StationImage::new(&described.panel),
            panel: described.panel.clone(),
            views,
            commands: Commands::new(),
            levels: Levels { now: 0, before: 0, mode: ControlMode::StandBy },
            agreement: Agreement { pending: None, next_request: 1, refusal: None },
            homing: Homing::default(),
            resumed: 0,
            orders: program.tasks.as_ref().map(|_| Box::new(OrderSlot::new(boot_id))),
            output: StationOutput::NONE,
            due: Due { outputs: true, report: true, settled: false, deadline: Tick::ZERO },
            fired: Fired::NONE,
            events: Vec::with_capacity(64),
            program: Arc::new(program),
        };
        controller.come_up(restore)?;
        Ok(controller)
    }

    /// The same controller with some rules switched off, to show that a checker finds the effect.
    #[must_use]
    pub fn with_rules(mut self, rules: Rules) -> Self {
        self.rules = rules;
        self.views.rules = rules;
        self
    }

    /// The same controller with some rules of orders switched off.
    #[must_use]
    pub fn with_order_rules(mut self, rules: OrderRules) -> Self {
        self.orders.iter_mut().for_each(|orders| orders.rules = rules);
        self
    }

    pub(crate) fn tokens(&self) -> &[Token] {
        &self.marking.tokens[..self.marking.count]
    }

    pub(crate) fn place(&self, token: &Token) -> StationPlace {
        self.program.places[token.place as usize].place
    }

    /// The places that hold a token.
    pub fn marking(&self) -> impl Iterator<Item = StationPlace> + '_ {
        self.tokens().iter().map(|t| self.place(t))
    }

    pub fn station(&self) -> StationId {
        self.program.station
    }

    /// The stations whose state it needs.
    pub fn peers(&self) -> &[StationId] {
        &self.program.peers
    }

    /// The mode it acts on.
    pub fn mode(&self) -> ControlMode {
        self.commands.mode()
    }

    /// The newest mode epoch it has received.
    pub fn mode_epoch(&self) -> u64 {
        self.commands.epoch()
    }

    pub fn cycle(&self) -> i32 {
        self.counts.cycle
    }

    /// The transitions that the last step that did anything has fired, in order, as indices into the station's net.
    pub fn fired(&self) -> &[u16] {
        self.fired.as_slice()
    }

    /// Takes an arrival. Follow with [`Controller::step`].
    #[inline]
    pub fn handle(&mut self, now: Tick, input: StationInput<'_>) -> Handled {
        self.now = self.now.max(now);
        if let StationInput::Inputs { bits, valid, until, under } = input {
            self.image.until = until;
            self.due.settled &= under == self.image.under;
            self.image.under = under;
            self.take_image(if valid { bits } else { 0 }, valid);
            // A longer term needs no new deadline: the old one comes too early, and is put right.
            self.due.deadline = self.due.deadline.min(until);
            return Handled::Taken;
        }
        // Commands and views: levels and deadlines are worked out again in the next step.
        self.due.deadline = Tick::ZERO;
        self.take(input).into()
    }

    fn take(&mut self, input: StationInput<'_>) -> Result<(), Ignored> {
        let now = self.now;
        match input {
            StationInput::Inputs { .. } => {}
            StationInput::Order(order) => {
                let epoch = self.commands.epoch();
                let taken = self.commands.order(now, order, self.stale);
                if taken.is_ok()
                    && let Some(generation) = order.found
                {
                    self.found(generation);
                }
                self.due.report |= self.commands.epoch() != epoch;
                return taken;
            }
            StationInput::EmergencyStop(life, epoch) => self.commands.stop(now, (life, epoch), self.stale),
            StationInput::Contest(contest) => {
                self.commands.contest(contest);
                self.due.report = true;
            }
            StationInput::Gap => {
                self.commands.end_lease(now);
                self.result_after_gap(now);
            }
            StationInput::View(station, report) => {
                let me = (self.program.station, self.boot_id);
                let answer = |views: &PeerViews| views.peers.iter().find(|v| v.station == station).map(|v| v.answer);
                let before = answer(&self.views);
                self.views.hear(now, me, &self.program, &self.counts.started, station, report)?;
                self.answer_entries();
                self.due.report |= before != answer(&self.views);
            }
            StationInput::Task(command) => return self.command(command),
            StationInput::Rejoin(at, numbers) => return self.rejoin(at, numbers),
            StationInput::Panel(command) => {
                let before = self.commands.selector_manual();
                self.commands.panel(now, command, self.stale);
                self.due.report |= before != self.commands.selector_manual();
            }
            StationInput::TwoConsoles(until) => self.commands.hear_two_consoles(until),
        }
        Ok(())
    }

    #[inline]
    pub(crate) fn take_image(&mut self, bits: u128, valid: bool) {
        let differing = bits ^ self.image.bits;
        self.image.bits = bits;
        if differing & self.image.watched != 0 || valid != self.image.valid {
            self.take_watched(differing, valid);
        }
    }

    /// Something changed that matters where the tokens stand, or at the panel.
    fn take_watched(&mut self, differing: u128, valid: bool) {
        let bits = self.image.bits;
        self.due.settled = false;
        // Others hold their motions by these.
        self.due.report |= differing & self.program.interlocks.read_by_others != 0;
        if differing & self.image.panel == 0 && valid == self.image.valid {
            return;
        }
        self.due.deadline = Tick::ZERO;
        if valid != self.image.valid {
            self.image.valid = valid;
            self.due.report = true;
            self.note(HappeningKind::Devices(valid));
            // A button that is down when the devices come back was not pressed now.
            self.commands.disarm(u128::MAX);
        }
        let wired = |input: Option<InputId>| input.is_some_and(|input| bits & (1 << input.0) != 0);
        let (manual, advance, retract) =
            (wired(self.panel.manual), wired(self.panel.advance), wired(self.panel.retract));
        let before = self.commands.selector_manual();
        self.commands.wired(manual, advance, retract);
        self.due.report |= before != self.commands.selector_manual();
        if valid && self.marking.unconfirmed {
            self.confirm_home();
        }
    }

    /// Switched on for the first time, or from a record that is not certain, the station claims to be at home. If the switch of
    /// the home operation does not measure so, the home operation is incomplete instead, and counts one less: a person brings it
    /// home.
    fn confirm_home(&mut self) {
        self.marking.unconfirmed = false;
        let home = self.program.home;
        let home_place = &self.program.places[usize::from(self.program.home_place)];
        let off_at_rest = if self.judges_rests() { home_place.off_at_rest(self.image.bits) } else { 0 };
        if (self.home_switch() & !self.image.bits) | (off_at_rest & !self.unreferenced()) != 0 {
            self.stand_at(&[StationPlace::incomplete(home)]);
            self.marking.placed = false;
            self.counts.done[home.index()] -= 1;
            self.marking.causes_of_stop[home.index()] = StopCause::NotAtHome;
            self.note(HappeningKind::Stopped(home, Block::Normal, StopCause::NotAtHome));
            self.due.outputs = true;
            self.due.report = true;
        }
    }

    /// Age of the input image, as far as this station can measure it.
    pub(crate) fn image_age(&self) -> Duration {
        if self.image.until == Tick::NEVER {
            return Duration::ZERO;
        }
        self.stale.saturating_sub(self.image.until.since(self.now))
    }

    pub(crate) fn note(&mut self, what: HappeningKind) {
        self.events.push(StationHappening { cycle: self.counts.cycle, what });
    }

    /// Time of the next step if nothing arrives before.
    pub fn next_deadline(&self) -> Option<Tick> {
        (self.due.deadline != Tick::NEVER).then_some(self.due.deadline)
    }

    pub(crate) fn refresh_path(&mut self) {
        let bits = self.marking.path.map_or(0, |op| bit::ANY_PATH | crate::program::path_bit(&self.program.paths, op));
        self.levels.now = self.levels.now & !(bit::ANY_PATH | bit::PATHS) | bits;
        self.levels.before = self.levels.now;
    }

    /// Number of times that the station has come home since the line first stood at home together; not counted on
    /// order.
    pub(crate) fn home_round(&self) -> i32 {
        if self.program.tasks.is_some() {
            0
        } else {
            self.counts.done[self.program.home.index()] - self.counts.initial_round
        }
    }

    pub(crate) fn stop_bit(&self) -> u128 {
        if self.commands.stops_at(self.home_round()) { bit::MASTER_STOP } else { 0 }
    }

    /// Coming home or being taken back from there decides anew whether master stop holds the station.
    pub(crate) fn refresh_stop(&mut self) {
        self.levels.now = self.levels.now & !bit::MASTER_STOP | self.stop_bit();
        self.levels.before = self.levels.before & !bit::MASTER_STOP | self.stop_bit();
    }

    pub(crate) fn master_stop(&self) -> bool {
        self.levels.now & bit::MASTER_STOP != 0
    }

    pub(crate) fn master_stop_is_given(&self) -> bool {
        self.commands.is_stopping()
    }

    pub(crate) fn panel_is_live(&self) -> bool {
        self.commands.panel_is_live()
    }

    /// At home: the home operation is complete, or everything after it has been undone — the same position. Task-driven:
    /// at any rest.
    pub fn is_at_home(&self) -> bool {
        if self.program.tasks.is_some() {
            return self.rest().is_some();
        }
        let after = (usize::from(self.program.step_of[self.program.home.index()]) + 1) % self.program.causes.len();
        self.marking.path.is_none()
            && self.marking().all(|place| {
                place == StationPlace::completed(self.program.home)
                    || (place.block == Block::Recovery
                        && place.stage == MotionStage::Completed
                        && usize::from(self.program.step_of[place.op.index()]) == after)
            })
    }
}
