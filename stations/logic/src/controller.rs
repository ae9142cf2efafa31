//! The controller of one station: what it remembers, what it is told, and the step.
//!
//! Invariants, checked by the tests over all reachable states:
//! * one token per concurrent branch, all in one step of the cycle;
//! * an output is on only in an operating place, with valid devices, outside the emergency stop, and — where a person
//!   holds the motion — while the button is held;
//! * done(o) ≤ started(o) ≤ cycle for every operation, and a count goes back only as [`crate::withdraw`] allows.

use linewright_line::net::{Block, ControlMode, Kind, Place, Stage};
use linewright_line::{BRANCHES_MAX, InputId, Line, OpId, Panel, StationId, Tick};
use std::time::Duration;

use crate::event::{Cause, Event, Happening};
use crate::panel::{Commands, ModeOrder, PanelCommand};
use crate::program::{Causal, CompileError, Program, Row, bit};
use crate::report::{Report, Restore, Snapshot};
use crate::views::Views;
use crate::withdraw::{Pending, Standing};

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
    },
    /// The coordinator's order.
    Order(ModeOrder),
    /// A newer report of another station.
    View(StationId, &'a Report),
    /// The station's panel, by message.
    Panel(PanelCommand),
}

/// What a step gives.
#[derive(Clone, Debug, Default)]
pub struct Outbox {
    /// The output image: bit `i` is output `i` of the description.
    pub outputs: u128,
    /// The report differs from that of the step before: send it.
    pub changed: bool,
    /// What happened, in order. The caller drains it.
    pub events: Vec<Event>,
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
    pub driven: bool,
    /// While driven: when the watchdog runs out.
    pub deadline: Tick,
    /// While not driven: what is left of the watchdog.
    pub remaining: Duration,
}

/// Transitions looked at in one step before the next image is asked for. An operation that completes leads on to the
/// next at once; a longer chain means a description with operations that take no time.
const PASSES_MAX: usize = 4;

/// The controller of one station.
#[derive(Clone, Debug)]
pub struct Controller {
    pub(crate) program: Program,
    pub(crate) boot_id: u64,
    pub(crate) now: Tick,
    pub(crate) tokens: [Token; BRANCHES_MAX],
    pub(crate) token_count: usize,
    pub(crate) cycle: i32,
    pub(crate) done: Vec<i32>,
    pub(crate) started: Vec<i32>,
    pub(crate) home_counts: Vec<i32>,
    initial_round: i32,
    pub(crate) path: Option<OpId>,
    pub(crate) causes_of_stop: Vec<Cause>,
    pub(crate) views: Views,
    pub(crate) commands: Commands,
    panel: Panel,
    stale: Duration,
    pub(crate) inputs: u128,
    inputs_until: Tick,
    pub(crate) devices_valid: bool,
    /// Command levels of this image and of the one before.
    levels: u128,
    levels_before: u128,
    mode_before: ControlMode,
    pub(crate) pending: Option<Pending>,
    pub(crate) next_request: u64,
    /// The last refusal, for the operator: who, its operation in the way, our operations that stay.
    pub(crate) refusal: Option<(StationId, OpId, u64)>,
    /// Fresh from the start: the home position is still to be confirmed by the devices.
    unconfirmed: bool,
    outputs: u128,
    dirty: bool,
    deadline: Tick,
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
    /// When the station does not compile.
    pub fn new(line: &Line, station: StationId, boot_id: u64, restore: Restore) -> Result<Self, CompileError> {
        let program = Program::compile(line, station)?;
        let described = line.station(station);
        let operations_of: Vec<usize> = program.peers.iter().map(|&peer| line.station(peer).operations.len()).collect();
        let views = Views::new(&program, &operations_of, line.timing.stale);
        let round = described.initial_round();
        let counts: Vec<i32> = described.op_ids().map(|op| described.home_count(op, round)).collect();
        let idle = Token {
            place: program.home_place,
            run: Run::Auto,
            left_start: true,
            driven: false,
            deadline: Tick::NEVER,
            remaining: Duration::ZERO,
        };
        let mut controller = Controller {
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
            panel: described.panel.clone(),
            stale: line.timing.stale,
            inputs: 0,
            inputs_until: Tick::ZERO,
            devices_valid: false,
            levels: 0,
            levels_before: 0,
            mode_before: ControlMode::StandBy,
            pending: None,
            next_request: 1,
            refusal: None,
            unconfirmed: restore == Restore::Fresh,
            outputs: 0,
            dirty: true,
            deadline: Tick::ZERO,
            changed: true,
            events: Vec::with_capacity(64),
            program,
        };
        if let Restore::From(snapshot) = restore {
            controller.restore(snapshot);
        }
        Ok(controller)
    }

    fn restore(&mut self, snapshot: Snapshot) {
        self.token_count = snapshot.marking.len().clamp(1, BRANCHES_MAX);
        for (token, place) in self.tokens.iter_mut().zip(&snapshot.marking) {
            let place = if place.is_operating() {
                self.causes_of_stop[place.op.index()] = Cause::Restart;
                place.stopped()
            } else {
                if place.is_incomplete() {
                    self.causes_of_stop[place.op.index()] = Cause::Restart;
                }
                *place
            };
            token.place = self.program.index_of(place);
        }
        self.cycle = snapshot.cycle;
        self.done = snapshot.done;
        self.started = snapshot.started;
        self.path = snapshot.path;
        self.next_request = snapshot.next_request;
    }

    /// What to keep so that [`Restore::From`] brings the station up where it is now. Keep it before the outputs and
    /// the report of the same step leave, so that nobody knows more of this station than it will remember.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            marking: self.tokens().iter().map(|t| self.place(t)).collect(),
            cycle: self.cycle,
            done: self.done.clone(),
            started: self.started.clone(),
            path: self.path,
            next_request: self.next_request,
        }
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

    /// The cycle it is in.
    pub fn cycle(&self) -> i32 {
        self.cycle
    }

    /// Takes what has arrived. Follow with [`Controller::step`]. Gives false if the input was ignored: an order of an
    /// older epoch, a report of no peer or of the wrong shape.
    pub fn handle(&mut self, now: Tick, input: Input<'_>) -> bool {
        // Levels and deadlines are worked out again in the next step, unless the image says nothing new.
        let before = (self.inputs, self.devices_valid);
        // An image that only renews its term needs no new deadline: the old one comes too early, and is put right.
        let taken = self.take(now, input);
        if !matches!(input, Input::Inputs { .. }) || before != (self.inputs, self.devices_valid) {
            self.deadline = Tick::ZERO;
        }
        taken
    }

    fn take(&mut self, now: Tick, input: Input<'_>) -> bool {
        self.now = self.now.max(now);
        let now = self.now;
        match input {
            Input::Inputs { bits, valid, until } => {
                self.inputs_until = until;
                self.take_image(if valid { bits } else { 0 }, valid);
                true
            }
            Input::Order(order) => {
                let epoch = self.commands.epoch();
                let taken = self.commands.order(now, order);
                self.changed |= self.commands.epoch() != epoch;
                taken
            }
            Input::View(station, report) => {
                let me = (self.program.station, self.boot_id);
                let answer = |views: &Views| views.peers.iter().find(|v| v.station == station).map(|v| v.answer);
                let before = answer(&self.views);
                let taken = self.views.hear(now, me, &self.program, &self.started, station, report);
                self.changed |= before != answer(&self.views);
                taken
            }
            Input::Panel(command) => {
                let before = self.commands.selector_manual();
                self.commands.panel(now, command, self.stale);
                self.changed |= before != self.commands.selector_manual();
                true
            }
        }
    }

    fn take_image(&mut self, bits: u128, valid: bool) {
        if (bits, valid) == (self.inputs, self.devices_valid) {
            return;
        }
        self.inputs = bits;
        if valid != self.devices_valid {
            self.devices_valid = valid;
            self.changed = true;
            self.note(Happening::Devices(valid));
            // A button that is down when the devices come back was not pressed now.
            self.commands.disarm();
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
        let operating = self.program.index_of(Place::operating(home));
        if self.inputs & self.program.places[operating as usize].complete == 0 {
            self.tokens[0].place = self.program.index_of(Place::incomplete(home));
            self.done[home.index()] -= 1;
            self.causes_of_stop[home.index()] = Cause::NotAtHome;
            self.note(Happening::Stopped(home, Block::Normal, Cause::NotAtHome));
            self.dirty = true;
            self.changed = true;
        }
    }

    pub(crate) fn note(&mut self, what: Happening) {
        self.events.push(Event { cycle: self.cycle, what });
    }

    /// Plays the net one image further. Call it after every [`Controller::handle`] and at every deadline.
    ///
    /// Each rising edge since the last step fires at most one transition of a token; what follows without a command
    /// (a completed operation leading on in auto) follows in the same step. Allocates nothing.
    pub fn step(&mut self, now: Tick, out: &mut Outbox) {
        self.now = self.now.max(now);
        if self.now >= self.deadline {
            self.refresh();
        }
        let edges = bit::edges(self.levels & !self.levels_before);
        self.levels_before = self.levels;
        let mut fired = self.pending.is_some() && self.settle();
        fired |= self.pass(self.levels | edges);
        if edges != 0 && !fired && self.pending.is_none() {
            self.refuse(edges);
        }
        if fired {
            for _ in 1..PASSES_MAX {
                if !self.pass(self.levels) {
                    break;
                }
            }
            self.changed = true;
            self.refusal = None;
        }
        if fired || self.dirty {
            self.drive();
        }
        out.outputs = self.outputs;
        out.changed = std::mem::take(&mut self.changed);
        if !self.events.is_empty() {
            out.events.append(&mut self.events);
        }
    }

    /// When to step again if nothing arrives before.
    pub fn next_deadline(&self) -> Option<Tick> {
        (self.deadline != Tick::NEVER).then_some(self.deadline)
    }

    /// Works out what depends on time or on what was handled: mode, levels, the outputs' holders, deadlines.
    fn refresh(&mut self) {
        if self.devices_valid && self.now >= self.inputs_until {
            self.take_image(0, false);
        }
        let levels = self.commands.refresh(self.now);
        let path = self.path.map_or(0, |op| bit::ANY_PATH | crate::program::path_bit(&self.program.paths, op));
        let levels = levels | path | self.stop_bit();
        self.dirty |= levels != self.levels;
        self.levels = levels;
        let mode = self.commands.mode();
        if mode != self.mode_before {
            self.mode_before = mode;
            // No edge reaches over a change of mode.
            self.levels_before = levels;
            self.enter_mode(mode);
        }
        self.dirty = true;
    }

    fn enter_mode(&mut self, mode: ControlMode) {
        self.note(Happening::Mode(mode));
        self.changed = true;
        for token in &mut self.tokens[..self.token_count] {
            // Auto takes over what a hand-mode button has started, for the operator has asked for it; hand mode takes
            // over what auto has left running, and drives it when its button is held.
            match (mode, token.run) {
                (ControlMode::Auto, Run::Hand) => token.run = Run::Auto,
                (ControlMode::Hand, Run::Auto) => token.run = Run::Hand,
                _ => {}
            }
        }
    }

    /// Follows up an open request.
    fn settle(&mut self) -> bool {
        let Some(pending) = self.pending.take() else { return false };
        match self.standing(&pending, self.levels, self.commands.mode()) {
            Standing::Waiting => {
                self.pending = Some(pending);
                false
            }
            // The token may have moved on a command given meanwhile; the request then has no meaning any more.
            Standing::Agreed if !self.are_enabled(&pending.transitions[..pending.count]) => {
                self.changed = true;
                false
            }
            Standing::Agreed => {
                for &transition in &pending.transitions[..pending.count] {
                    self.fire(transition);
                }
                true
            }
            Standing::GivenUp => {
                self.changed = true;
                false
            }
        }
    }

    fn are_enabled(&self, transitions: &[u16]) -> bool {
        let marked = |place: &u16| self.tokens().iter().any(|t| t.place == *place);
        transitions.iter().all(|&t| self.program.actions[t as usize].from.iter().all(marked))
    }

    /// Looks at every token once, on the state before the pass, then fires what may fire.
    fn pass(&mut self, word: u128) -> bool {
        let mode = self.commands.mode();
        if self.token_count == 1 {
            let fired = match self.choose(0, word, mode) {
                Some(row) => self.act(row, mode),
                None => false,
            };
            return fired;
        }
        let mut chosen = [None; BRANCHES_MAX];
        for (index, choice) in chosen.iter_mut().enumerate().take(self.token_count) {
            *choice = self.choose(index, word, mode);
        }
        let mut fired = false;
        for row in chosen.into_iter().flatten() {
            fired |= self.act(row, mode);
        }
        fired
    }

    /// The row that lets a token move, if there is one.
    #[inline]
    fn choose(&mut self, index: usize, word: u128, mode: ControlMode) -> Option<u16> {
        let token = self.tokens[index];
        let table = &self.program.places[token.place as usize];
        let mut word = word;
        if table.complete != 0 {
            word |= self.motion_bits(index);
        }
        let table = &self.program.places[token.place as usize];
        let (start, end) = table.rows[mode as usize];
        let rows = &self.program.rows[start as usize..end as usize];
        let mut found: Option<u16> = None;
        for (offset, row) in rows.iter().enumerate() {
            if word & row.need == row.need && word & row.forbid == 0 && self.allows(row, mode) {
                match found {
                    None => found = Some(start + offset as u16),
                    Some(first) if self.program.rows[first as usize].transition != row.transition => {
                        return self.ambiguous(index);
                    }
                    Some(_) => {}
                }
            }
        }
        found
    }

    /// Fault, arrival and loss of hold of an operating token.
    #[inline]
    fn motion_bits(&mut self, index: usize) -> u128 {
        let token = &mut self.tokens[index];
        let table = &self.program.places[token.place as usize];
        let on = self.inputs & table.complete != 0;
        token.left_start |= !on;
        let mut bits = if on && token.left_start { bit::ARRIVED } else { 0 };
        let late = token.driven && self.now >= token.deadline;
        if !self.devices_valid || late || self.inputs & table.fault != 0 {
            bits |= bit::FAULT;
        }
        if token.run == Run::Manual && self.commands.mode() != ControlMode::Manual {
            bits |= bit::HOLD_LOST;
        }
        bits
    }

    #[inline]
    fn allows(&self, row: &Row, mode: ControlMode) -> bool {
        if row.causal == Causal::Free && row.settled == 0 && !row.join {
            return true;
        }
        let causal = match row.causal {
            Causal::Free => true,
            Causal::Holds(step) => self.devices_valid && self.causes_hold(step, mode),
            Causal::Fails(step) => !self.causes_hold(step, mode),
        };
        causal && self.neighbours_settled(row.settled) && (!row.join || self.joined())
    }

    fn causes_hold(&self, step: u8, mode: ControlMode) -> bool {
        let causes = &self.program.causes[step as usize];
        self.views.all_hold(causes, mode, self.cycle_of_start(step), self.now)
    }

    /// The cycle in which a step would start: the first one listed starts a new one.
    pub(crate) fn cycle_of_start(&self, step: u8) -> i32 {
        self.cycle + i32::from(step == 0)
    }

    fn neighbours_settled(&self, mask: u64) -> bool {
        mask == 0
            || self
                .tokens()
                .iter()
                .map(|t| self.place(t))
                .all(|place| mask & (1 << place.op.0) == 0 || place.stage == Stage::Completed)
    }

    fn joined(&self) -> bool {
        let first = self.place(&self.tokens[0]);
        self.tokens().iter().all(|t| {
            let place = self.place(t);
            (place.block, place.stage) == (first.block, first.stage)
        })
    }

    /// Two exclusive transitions are both allowed. The checker proves this cannot happen; if it does, the controller
    /// does not guess: an operating token is stopped, any other stays where it is.
    #[cold]
    fn ambiguous(&mut self, index: usize) -> Option<u16> {
        let place = self.place(&self.tokens[index]);
        if place.is_operating() {
            self.stop(index, Cause::Ambiguous);
            self.dirty = true;
            self.changed = true;
        }
        None
    }

    /// Fires the transition of a row, or asks for the agreement it needs.
    fn act(&mut self, row: u16, mode: ControlMode) -> bool {
        let row = self.program.rows[row as usize];
        if row.withdraws {
            let ops = self.taken_back(self.program.actions[row.transition as usize].kind);
            if self.dependents(ops) != 0 {
                let opened = self.pending.is_none_or(|p| !p.transitions[..p.count].contains(&row.transition));
                if opened {
                    self.ask(&row, ops, mode);
                    let number = self.next_request - 1;
                    self.note(Happening::Asked(number));
                }
                return false;
            }
        }
        self.fire(row.transition);
        true
    }

    /// The operations whose counts a transition takes back.
    pub(crate) fn taken_back(&self, kind: Kind) -> u64 {
        match kind {
            Kind::Undo(op) => 1 << op.0,
            Kind::Back { to, .. } => {
                let ops = self.program.step_of.iter().enumerate().filter(|&(_, &step)| usize::from(step) == to);
                ops.fold(0, |bits, (op, _)| bits | 1 << op)
            }
            Kind::EnterPath(_) => {
                let round = self.done[self.program.home.index()];
                let counted = |&(op, &done): &(usize, &i32)| done > self.home_counts[op] + round;
                self.done.iter().enumerate().filter(counted).fold(0, |bits, (op, _)| bits | 1 << op)
            }
            Kind::Stop(..)
            | Kind::Resume(..)
            | Kind::Complete(..)
            | Kind::Retract(_)
            | Kind::Restart(_)
            | Kind::Again(_)
            | Kind::Next { .. }
            | Kind::FollowPath { .. } => 0,
        }
    }

    /// A press moved nothing. Say so if it was meant for this station.
    #[cold]
    fn refuse(&mut self, edges: u128) {
        let pressed = bit::levels(edges);
        let mine = pressed & (bit::PANEL | self.program.buttons) != 0;
        if mine && self.commands.mode().enables_motion() {
            self.note(Happening::Refused);
            self.changed = true;
        }
    }

    /// Works out the outputs and the deadline.
    ///
    /// Why an actuator may be energised: its place is operating, which is left on any fault; the devices vouch for
    /// the image that place was judged by; the mode is not the emergency stop, in which no place is operating; and a
    /// motion that a person holds is driven only while the button is down. Everything else is off, so a controller
    /// that has nothing to say says "off".
    fn drive(&mut self) {
        let mut outputs = 0;
        let mut deadline = self.commands.deadline(self.now).min(self.views.deadline(self.now));
        if self.devices_valid {
            deadline = deadline.min(self.inputs_until);
        }
        let mode = self.commands.mode();
        for index in 0..self.token_count {
            let token = &mut self.tokens[index];
            let table = &self.program.places[token.place as usize];
            let held = token.run != Run::Hand || (table.hold != 0 && self.levels & table.hold == table.hold);
            let driven = table.actuator != 0 && self.devices_valid && held && mode != ControlMode::EStop;
            match (token.driven, driven) {
                (false, true) => token.deadline = self.now + token.remaining,
                (true, false) => token.remaining = token.deadline.since(self.now),
                (true, true) | (false, false) => {}
            }
            token.driven = driven;
            if driven {
                outputs |= table.actuator;
                deadline = deadline.min(token.deadline);
            }
            outputs |= table.lamp;
        }
        self.outputs = outputs;
        self.deadline = deadline;
        self.dirty = false;
    }

    /// The report of the present state.
    pub fn report(&self) -> Report {
        let mut report = Report::default();
        self.report_into(&mut report);
        report
    }

    /// Writes the report of the present state, reusing what `report` has allocated.
    pub fn report_into(&self, report: &mut Report) {
        report.boot_id = self.boot_id;
        report.mode_epoch = self.commands.epoch();
        report.mode = Some(self.commands.mode());
        report.cycle = self.cycle;
        report.done.clone_from(&self.done);
        report.started.clone_from(&self.started);
        report.places.clear();
        report.places.resize(self.done.len(), 0);
        report.incomplete.clear();
        for place in self.marking() {
            report.places[place.op.index()] = place.number();
            if place.is_incomplete() {
                report.incomplete.push((place.op, self.causes_of_stop[place.op.index()]));
            }
        }
        report.recovering_home = self.path.is_some();
        report.at_home = self.is_at_home();
        report.round = self.home_round() + i32::from(!report.at_home);
        report.stopped = !self.tokens().iter().any(|t| t.driven);
        report.selector_manual = self.commands.selector_manual();
        report.devices_valid = self.devices_valid;
        report.request = self.pending.map(|p| p.request);
        report.answers.clear();
        report.answers.extend(self.views.peers.iter().filter_map(|v| v.answer));
    }

    pub(crate) fn refresh_path(&mut self) {
        let bits = self.path.map_or(0, |op| bit::ANY_PATH | crate::program::path_bit(&self.program.paths, op));
        self.levels = self.levels & !(bit::ANY_PATH | bit::PATHS) | bits;
        self.levels_before = self.levels;
    }

    /// How often the station has come home since the line first stood at home together.
    pub(crate) fn home_round(&self) -> i32 {
        self.done[self.program.home.index()] - self.initial_round
    }

    fn stop_bit(&self) -> u128 {
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

    pub(crate) fn panel_is_live(&self) -> bool {
        self.commands.panel_is_live()
    }

    /// At home: the home operation is complete, or everything after it has been undone — the same position.
    pub fn is_at_home(&self) -> bool {
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
