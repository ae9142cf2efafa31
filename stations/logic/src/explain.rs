//! Why nothing happens: for every state in which the station waits, the conditions it waits for, in words.
//!
//! Called when a state is published, never in the step; it reads the same tables the step reads, so it cannot give a
//! reason the controller does not have.

use linewright_line::net::{Block, ControlMode, MotionStage, StationPlace};
use linewright_line::{Line, OpId, StationId, Tick};

use crate::controller::Controller;
use crate::event::{HappeningKind, StationHappening, StopCause};
use crate::order_words::task_name;
use crate::program::IncomingArrow as Arrow;
use crate::views::Comparability;

/// What a station waits for whose devices cannot be trusted. Which device and why, their manager knows.
pub const DEVICES_INVALID: &str = "its devices: not heard, or not operational";

impl Controller {
    /// What each branch of the station is doing, e.g. `advance clamp` or `undoing 1st lift (stopped)`.
    pub fn operation_text(&self, line: &Line) -> String {
        let parts: Vec<String> = self.marking().map(|place| self.place_text(line, place)).collect();
        parts.join(" + ")
    }

    fn place_text(&self, line: &Line, place: StationPlace) -> String {
        let name = self.op_name(line, place.op);
        match (place.block, place.stage) {
            (Block::Normal, MotionStage::Operating) => name.to_owned(),
            (Block::Normal, MotionStage::Incomplete) => format!("{name} (stopped)"),
            (Block::Normal, MotionStage::Completed) => format!("{name} (done)"),
            (Block::Recovery, MotionStage::Operating) => format!("undoing {name}"),
            (Block::Recovery, MotionStage::Incomplete) => format!("undoing {name} (stopped)"),
            (Block::Recovery, MotionStage::Completed) => format!("{name} (undone)"),
        }
    }

    /// The fault to announce, e.g. `advance clamp: took too long`; empty when there is none.
    pub fn fault_text(&self, line: &Line) -> String {
        let mut parts = Vec::new();
        for place in self.marking().filter(|place| place.is_incomplete()) {
            let cause = self.marking.causes_of_stop[place.op.index()];
            if cause.is_fault() {
                let text = cause.text_of(line, self.program.station, place.op, place.block);
                parts.push(format!("{}: {text}", self.op_name(line, place.op)));
            }
        }
        if let Some((op, input)) = self.position_lost() {
            parts.push(StopCause::PositionLost { op, input }.detail(line, self.program.station));
        }
        parts.join("; ")
    }

    /// What the station waits for. Empty while something moves.
    pub fn blocked_by(&self, line: &Line, now: Tick) -> Vec<String> {
        let mut reasons = Vec::new();
        if let Some((followed, other)) = self.commands.contested(now) {
            reasons.push(format!("two coordinators give orders (boot ids {followed} and {other}): end one of them"));
        }
        if !self.image.valid {
            reasons.push(DEVICES_INVALID.to_owned());
        }
        if let Some((op, input)) = self.position_lost() {
            reasons.push(StopCause::PositionLost { op, input }.detail(line, self.program.station));
        }
        self.explain_generation(line, &mut reasons);
        for place in self.marking() {
            self.explain_place(line, place, now, &mut reasons);
        }
        if let Some(pending) = &self.agreement.pending {
            self.explain_request(line, pending.request.ops, pending.needs, now, &mut reasons);
        }
        if let Some((by, in_the_way, ops)) = self.agreement.refusal {
            reasons.push(format!(
                "{} cannot be taken back: {}: {} has started on it",
                self.op_names(line, ops),
                line.station(by).name,
                line.operation((by, in_the_way)).name
            ));
        }
        reasons.dedup();
        reasons
    }

    /// The way back of a station that has lost its memory, or an axis of which is not where its chart has it.
    fn explain_generation(&self, line: &Line, reasons: &mut Vec<String>) {
        let compares = self.rules.generations && self.program.on_order.is_none() && !self.program.peers.is_empty();
        let is_lost = self.position_lost().is_some();
        let forgot = self.views.generation == 0;
        if !compares || !(is_lost || (forgot && !self.is_at_home())) {
            return;
        }
        let not_home = |place: StationPlace| self.marking.causes_of_stop[place.op.index()] == StopCause::NotAtHome;
        let why =
            if forgot { "it has no memory of where it stands" } else { "its axes are not where its chart has them" };
        reasons.push(match self.read_off() {
            Some(step) if is_lost || self.marking().any(not_home) => format!(
                "rejoin: {why}; by its switches `{}` is complete: confirm that with rejoin",
                self.op_names(line, self.ops_of_step(step).fold(0, |bits, op| bits | 1 << op.0))
            ),
            None if forgot && self.marking().any(not_home) => {
                let may_be = self.counts.done.iter().enumerate().map(|(op, _)| OpId::at(op)).filter(|&op| self.stands_within(op));
                let may_be: Vec<&str> = may_be.map(|op| self.op_name(line, op)).collect();
                let advice = match may_be.as_slice() {
                    [] => "its switches fit no operation of the chart: bring its axes to a switch by hand".to_owned(),
                    ops => format!(
                        "it stands between two switches: look, and name with rejoin the operation that it stands within; by its \
                         switches that may be `{}`",
                        ops.join("`, `")
                    ),
                };
                format!("rejoin: {why}; {advice}")
            }
            None if is_lost => format!(
                "rejoin: {why}, and its switches fit no place of the chart: bring the axis back to its switch by hand, \
                 or name with rejoin the operation that it stands within"
            ),
            _ => "a common start: it has no memory of the others' counts; lead all stations home in manual, then give auto"
                .to_owned(),
        });
    }

    fn explain_place(&self, line: &Line, place: StationPlace, now: Tick, reasons: &mut Vec<String>) {
        let name = self.op_name(line, place.op);
        match place.stage {
            MotionStage::Operating => self.explain_motion(line, place, reasons),
            MotionStage::Incomplete => {
                // What it stands in is not known before rejoin.
                let unknown = self.rules.generations && self.views.generation == 0 && self.program.on_order.is_none();
                reasons.extend(match self.marking.causes_of_stop[place.op.index()] {
                    StopCause::NotAtHome if unknown && !self.program.peers.is_empty() => None,
                    StopCause::Released => Some(format!("{name} to be finished or taken back in manual")),
                    cause => Some(format!("recovery of {name} in manual ({})", cause.text())),
                });
                if self.mode() == ControlMode::Manual {
                    self.explain_guard(line, StationPlace { stage: MotionStage::Operating, ..place }, reasons);
                }
                self.explain_way_home(line, place, now, reasons);
            }
            MotionStage::Completed => self.explain_next(line, place, now, reasons),
        }
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
                reasons.push(format!("{} to be held", line.buttons[usize::from(button.0)]));
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
            reasons.push(format!("{} beside it", self.op_name(line, other.op)));
            return;
        }
        if self.explain_order(line, place, reasons) {
            return;
        }
        match self.mode() {
            ControlMode::Auto => {
                if self.is_at_home() && self.master_stop() {
                    reasons.push("master stop: halted at home".to_owned());
                }
                self.explain_causes(line, next, now, reasons);
            }
            ControlMode::Hand => {
                reasons.push(format!("a button: {}", self.hand_choices(line, place)));
                self.explain_positions(line, step, StationPlace::undoing, reasons);
                self.explain_causes(line, next, now, reasons);
            }
            ControlMode::Manual => {
                if self.panel_is_live() {
                    reasons.push("advance or return at its panel".to_owned());
                    self.explain_positions(line, step, StationPlace::undoing, reasons);
                    self.explain_causes(line, next, now, reasons);
                } else {
                    reasons.push("its selector to be switched to manual".to_owned());
                }
            }
            ControlMode::Home | ControlMode::StandBy => reasons.push(format!("a mode (now {})", self.mode())),
            ControlMode::EStop => reasons.push("the emergency stop to be reset".to_owned()),
        }
    }

    fn hand_choices(&self, line: &Line, place: StationPlace) -> String {
        let hand = line.operation((self.program.station, place.op)).hand;
        let name = |button: linewright_line::ButtonId| line.buttons[usize::from(button.0)].clone();
        let onward = match place.block {
            Block::Normal => Some(hand.next().unwrap_or(hand.forward())),
            Block::Recovery if matches!(hand.number(), 3 | 6) => Some(hand.forward()),
            Block::Recovery => None,
        };
        let back = match place.block {
            Block::Normal if hand.number() >= 5 => hand.back(),
            Block::Recovery if matches!(hand.number(), 4 | 5) => hand.back(),
            Block::Normal | Block::Recovery => None,
        };
        match (onward, back) {
            (Some(on), Some(back)) if on == back => name(on),
            (Some(on), Some(back)) => format!("{} to go on, {} to go back", name(on), name(back)),
            (Some(on), None) => format!("{} to go on", name(on)),
            (None, Some(back)) => format!("{} to go back", name(back)),
            (None, None) => "none leads on from here; use manual or auto".to_owned(),
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
                reasons.push(format!("{}, which going home includes", self.cause_text(line, cause, cycle, now)));
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
        self.explain_positions(line, step, StationPlace::operating, reasons);
    }

    /// What the second barrier keeps from starting.
    fn explain_positions(&self, line: &Line, step: usize, moves: fn(OpId) -> StationPlace, reasons: &mut Vec<String>) {
        let ops = self.program.step_of.iter().enumerate().filter(|&(_, &at)| usize::from(at) == step);
        for op in ops.map(|(op, _)| OpId::at(op)) {
            self.explain_guard(line, moves(op), reasons);
        }
    }

    fn explain_guard(&self, line: &Line, place: StationPlace, reasons: &mut Vec<String>) {
        if let Some(guard) = self.violated(place, self.marking.path) {
            let text = self.interlock(&guard).detail(line, self.program.station);
            reasons.push(format!("{text}, for {}", self.op_name(line, place.op)));
        }
    }

    fn cause_text(&self, line: &Line, cause: &Arrow, cycle: i32, now: Tick) -> String {
        let peer = self.program.peers[cause.peer as usize];
        let (station, op) = (&line.station(peer).name, &line.operation((peer, cause.from)).name);
        let own = self.op_name(line, cause.to);
        let view = &self.views.peers[cause.peer as usize];
        match self.views.standing(cause.peer as usize, cycle, now) {
            Comparability::Comparable => {}
            Comparability::NotHeard => return format!("{station} to be heard, for {own}"),
            Comparability::OtherGeneration if self.views.generation == 0 => {
                return format!("a common start, for {own}: this station has no memory of the others' counts");
            }
            Comparability::OtherGeneration => {
                return format!("a common start with {station}, for {own}: it has no memory of these counts");
            }
            Comparability::PositionLost => {
                return format!("{station} to be where its chart has it (position lost), for {own}");
            }
            Comparability::TooFarAhead => {
                return format!("{station} to report a cycle that can be (it reports {}), for {own}", view.cycle);
            }
        }
        if view.request.is_some_and(|request| request.ops & (1 << cause.from.0) != 0) {
            return format!("{station}: {op}, which is being taken back, for {own}");
        }
        format!("{station}: {op} (cycle {}), for {own}", cycle.saturating_sub(cause.lag))
    }

    fn explain_request(&self, line: &Line, ops: u64, needs: u64, now: Tick, reasons: &mut Vec<String>) {
        for (index, view) in self.views.peers.iter().enumerate().filter(|&(i, _)| needs & (1 << i) != 0) {
            let heard = if now < view.known_until { "" } else { " (not heard)" };
            let agreed = matches!(view.verdict, Some((_, number, None)) if Some(number) == self.agreement.pending.map(|p| p.request.number));
            if !agreed {
                let station = &line.station(self.program.peers[index]).name;
                reasons.push(format!("{station}{heard} to agree that {} is taken back", self.op_names(line, ops)));
            }
        }
    }

    fn op_name<'a>(&self, line: &'a Line, op: OpId) -> &'a str {
        &line.operation((self.program.station, op)).name
    }

    fn op_names(&self, line: &Line, ops: u64) -> String {
        op_names(line, self.program.station, ops)
    }

    /// An event of this station in words, as the operator would say it.
    pub fn event_text(&self, line: &Line, event: &StationHappening) -> String {
        event.text(line, self.program.station)
    }
}

fn op_names(line: &Line, station: StationId, ops: u64) -> String {
    let described = line.station(station);
    let named = described.op_ids().filter(|op| ops & (1 << op.0) != 0);
    let names: Vec<&str> = named.map(|op| described.operations[op.index()].name.as_str()).collect();
    names.join(", ")
}

impl StationHappening {
    /// The event in words, for the station it belongs to.
    pub fn text(&self, line: &Line, station: StationId) -> String {
        let name = |op: OpId| line.operation((station, op)).name.as_str();
        let undoing = |block: Block| match block {
            Block::Normal => "",
            Block::Recovery => "undoing ",
        };
        match self.what {
            HappeningKind::Started(op, block) => format!("starts {}{}", undoing(block), name(op)),
            HappeningKind::Completed(op, Block::Normal) => format!("has done {}", name(op)),
            HappeningKind::Completed(op, Block::Recovery) => format!("has undone {}", name(op)),
            HappeningKind::Stopped(op, block, cause) => {
                format!("stops {}{}: {}", undoing(block), name(op), cause.text_of(line, station, op, block))
            }
            HappeningKind::Withdrawn(0) => "takes nothing back".to_owned(),
            HappeningKind::Withdrawn(ops) => format!("takes back {}", op_names(line, station, ops)),
            HappeningKind::HomeAgain if line.station(station).works_on_order() => {
                "is back where the task began".to_owned()
            }
            HappeningKind::HomeAgain => "is home; the cycle will be done again".to_owned(),
            HappeningKind::Founded => "is at home with the others: counts begin anew".to_owned(),
            HappeningKind::Rejoined => "stands where its switches say, by an operator's confirmation".to_owned(),
            HappeningKind::PositionLost(op, input) => StopCause::PositionLost { op, input }.detail(line, station),
            HappeningKind::PositionFound => "is measured where its chart has it again".to_owned(),
            HappeningKind::Asked(number) => format!("asks to go back (request {number})"),
            HappeningKind::NotAgreed { by, in_the_way } => {
                format!(
                    "may not go back: {}: {} has started",
                    line.station(by).name,
                    line.operation((by, in_the_way)).name
                )
            }
            HappeningKind::Refused => "refuses the command".to_owned(),
            HappeningKind::Mode(mode) => format!("obeys {mode}"),
            HappeningKind::Devices(true) => "has its devices".to_owned(),
            HappeningKind::Devices(false) => "has lost its devices".to_owned(),
            HappeningKind::Ordered(task) => format!("is to do {}", task_name(line, station, task)),
            HappeningKind::OrderRefused(refusal) => format!("refuses an order: {}", refusal.text()),
            HappeningKind::OrderDone(task) => format!("has done the task {}", task_name(line, station, task)),
            HappeningKind::OrderFailed(task, failure) => {
                format!("has not done the task {}: {}", task_name(line, station, task), failure.text())
            }
            HappeningKind::Securing(task) => format!("goes back from the task {}", task_name(line, station, task)),
        }
    }
}
