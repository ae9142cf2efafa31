//! The second barrier at one clamp of the shipped line, between a bar and a mill that report what they are made to report.

use std::time::Duration;

use linewright_line::net::{ControlMode, StationPlace};
use linewright_line::{Arrow, Line, OpId, OutputId, StationId, Tick};
use linewright_station_logic::{
    AgreementAnswer, CompileError, Controller, Handled, Ignored, ModeOrder, NO_DELAY, PanelCommand, Program, RejoinAt,
    Restore, StationInput, StationOutbox, StationReport,
};

use linewright_testkit::built::transfer_line;

pub const BAR: StationId = StationId(0);
pub const CLAMP: StationId = StationId(1);
pub const MILL: StationId = StationId(2);
pub const GENERATION: u64 = 5;

pub struct InterlockBench {
    pub line: Line,
    pub clamp: Controller,
    now: Tick,
    pub order: ModeOrder,
    outputs: u128,
    /// The output image in force when the input image was taken.
    pub under: u64,
    /// The others agree to each request.
    pub agree: bool,
    pub bar: StationReport,
    pub mill: StationReport,
    image: u128,
}

impl InterlockBench {
    /// The clamp at home and open, with `generation` in common with the others, which stand clear of it.
    pub fn new(line: Line, generation: u64) -> Self {
        InterlockBench::standing(line, generation, &["LS_open"])
    }

    pub fn standing(line: Line, generation: u64, on: &[&str]) -> Self {
        let mut bench = InterlockBench {
            clamp: Controller::new(&line, CLAMP, 1, Restore::Fresh).expect("it compiles"),
            now: Tick::from_millis(1000),
            order: ModeOrder {
                manual_all: true,
                found: (generation != 0).then_some(generation),
                ..ModeOrder::of(9, 1, ControlMode::StandBy, Duration::from_secs(1))
            },
            outputs: 0,
            under: NO_DELAY,
            agree: true,
            bar: report(&line, BAR, &["LS_vertical_0", "LS_horizontal_0"], GENERATION),
            mill: report(&line, MILL, &["LS_positioning_0", "LS_main_0"], GENERATION),
            image: inputs(&line, CLAMP, on),
            line,
        };
        bench.wait();
        bench
    }

    /// Everything is sent again and again, for longer than an image is valid.
    pub fn wait(&mut self) {
        (0..15).for_each(|_| self.play());
    }

    /// Everything is sent once more.
    pub fn play(&mut self) {
        self.now = self.now + Duration::from_millis(20);
        if let Some(request) = self.clamp.request().filter(|_| self.agree) {
            self.answer(self.clamp.report().boot_id, request.number, None);
        }
        let mut out = StationOutbox::default();
        let image = StationInput::Inputs { bits: self.image, valid: true, until: Tick::NEVER, under: self.under };
        self.clamp.handle(self.now, image);
        self.clamp.handle(self.now, StationInput::Order(self.order));
        self.clamp.handle(self.now, StationInput::View(BAR, &self.bar));
        self.clamp.handle(self.now, StationInput::View(MILL, &self.mill));
        self.clamp.step(self.now, &mut out);
        self.outputs = out.outputs;
    }

    /// Both others answer a request of this life of the clamp.
    pub fn answer(&mut self, boot_id: u64, number: u64, in_the_way: Option<OpId>) {
        let answer = AgreementAnswer { to: CLAMP, boot_id, number, in_the_way };
        (self.bar.answers, self.mill.answers) = (vec![answer], vec![answer]);
    }

    pub fn mode(&mut self, mode: ControlMode) {
        (self.order.mode, self.order.epoch) = (mode, self.order.epoch + 1);
        self.play();
    }

    pub fn press(&mut self, command: fn(bool) -> PanelCommand) {
        self.clamp.handle(self.now, StationInput::Panel(command(false)));
        self.play();
        self.clamp.handle(self.now, StationInput::Panel(command(true)));
        self.play();
        self.play();
    }

    pub fn release(&mut self) {
        for command in [PanelCommand::Advance(false), PanelCommand::Retract(false)] {
            self.clamp.handle(self.now, StationInput::Panel(command));
        }
        self.play();
    }

    pub fn drives(&self, output: OutputId) -> bool {
        self.outputs & (1 << output.0) != 0
    }

    pub fn closing(&self) -> OutputId {
        let op = self.op("advance clamp");
        self.line.operation((CLAMP, op)).normal.actuator
    }

    pub fn opening(&self) -> OutputId {
        let op = self.op("return clamp");
        self.line.operation((CLAMP, op)).normal.actuator
    }

    pub fn op(&self, name: &str) -> OpId {
        self.line.station(CLAMP).operation_named(name).expect("the clamp has it")
    }

    pub fn blocked(&self) -> String {
        self.clamp.blocked_by(&self.line, self.now).join("; ")
    }

    pub fn set(&mut self, on: &[&str]) {
        self.image = inputs(&self.line, CLAMP, on);
        self.play();
    }

    pub fn bar_has(&mut self, on: &[&str], stopped: bool) {
        self.bar.measured = inputs(&self.line, BAR, on);
        self.bar.stopped = stopped;
        self.play();
    }
}

fn inputs(line: &Line, station: StationId, on: &[&str]) -> u128 {
    let names = &line.station(station).inputs;
    let bit = |name: &&str| 1u128 << names.iter().position(|known| known == name).expect("it has this input");
    on.iter().map(bit).fold(0, |bits, bit| bits | bit)
}

/// A station that stands, its devices in order, having done everything in its second cycle.
fn report(line: &Line, station: StationId, on: &[&str], generation: u64) -> StationReport {
    let done = vec![2; line.station(station).operations.len()];
    StationReport {
        boot_id: 1,
        generation,
        cycle: 2,
        started: done.clone(),
        done,
        stopped: true,
        devices_valid: true,
        measured: inputs(line, station, on),
        ..StationReport::default()
    }
}

/// Half-way to closed, and the bar has come off its switch: neither is clear of the other.
fn both_inside() -> InterlockBench {
    let mut bench = InterlockBench::new(transfer_line(), GENERATION);
    bench.mode(ControlMode::Manual);
    bench.press(PanelCommand::Advance);
    assert!(bench.drives(bench.closing()), "{}", bench.blocked());
    bench.set(&[]);
    bench.bar_has(&["LS_horizontal_0"], false);
    assert_eq!(bench.outputs & !lamp(&bench), 0, "it stops for what is measured in its way");
    bench.release();
    bench
}

fn lamp(bench: &InterlockBench) -> u128 {
    let operation = bench.line.operation((CLAMP, bench.op("advance clamp")));
    operation.normal.lamp.map_or(0, |lamp| 1 << lamp.0)
}

#[test]
fn of_two_inside_the_one_that_leaves_moves_while_the_other_stands() {
    let mut bench = both_inside();
    let back = bench.opening();
    bench.press(PanelCommand::Retract);
    assert!(!bench.drives(back), "the bar moves");
    bench.release();
    bench.bar_has(&["LS_horizontal_0"], true);
    // On towards closed is no way out.
    bench.press(PanelCommand::Advance);
    assert!(!bench.drives(bench.closing()), "further in");
    assert!(bench.blocked().contains("transfer"), "{}", bench.blocked());
    bench.release();
    bench.press(PanelCommand::Retract);
    assert!(bench.drives(back), "{}", bench.blocked());
    bench.bar_has(&["LS_horizontal_0"], false);
    assert!(!bench.drives(back), "the bar moves again");
}

/// The bar's lower switch sticks: the bar is up, at the next one, which contradicts it.
#[test]
fn a_switch_that_sticks_does_not_measure_the_other_station_clear() {
    let mut bench = InterlockBench::new(transfer_line(), GENERATION);
    bench.mode(ControlMode::Manual);
    // The clamp closes on its way: from there it relies on the bar.
    bench.press(PanelCommand::Advance);
    bench.set(&[]);
    assert!(bench.drives(bench.closing()), "{}", bench.blocked());
    bench.bar_has(&["LS_vertical_0", "LS_vertical_50", "LS_horizontal_0"], false);
    assert_eq!(bench.outputs & !lamp(&bench), 0, "{}", bench.blocked());
    let blocked = bench.blocked();
    assert!(blocked.contains("LS_vertical_50") && blocked.contains("is on, and off while it is clear"), "{blocked}");
}

/// At the end of an operation what is in the way of *return* is no reason why the operation itself waits.
#[test]
fn what_is_in_the_way_of_return_is_named_as_undoing() {
    let mut bench = InterlockBench::new(transfer_line(), GENERATION);
    bench.mode(ControlMode::Manual);
    bench.press(PanelCommand::Advance);
    bench.set(&["LS_closed"]);
    bench.release();
    // The mill is not measured back: the closed clamp must not open.
    bench.mill.measured = 0;
    bench.play();
    let (waits, op) = (bench.blocked(), "advance clamp");
    assert!(waits.contains("interlock: mill_1") && waits.contains(&format!("for undoing {op}")), "{waits}");
    assert!(!waits.contains(&format!(", for {op}")), "it is done: {waits}");
    bench.mill.measured = inputs(&bench.line, MILL, &["LS_positioning_0", "LS_main_0"]);
    bench.play();
    assert!(!bench.blocked().contains("interlock"), "{}", bench.blocked());
}

#[test]
fn a_conflict_that_no_switch_measures_blocks_what_a_lost_memory_may_run_into() {
    let mut line = transfer_line();
    let op = |name| line.station(BAR).operation_named(name).expect("the bar has it");
    // Outside this stretch the bar lifts and lowers too: no switch distinguishes it from the inside.
    let (from, until) = (op("2nd lift"), op("3rd lower"));
    (line.conflicts[0].a.from, line.conflicts[0].a.until) = (from, until);
    assert!(line.clearance(&line.conflicts[0].a).is_err() && line.conflicts[0].a.station == BAR);
    // Away from home and without a memory; its home motion is the one that opens it.
    let mut bench = InterlockBench::standing(line.clone(), 0, &["LS_closed"]);
    bench.mode(ControlMode::Manual);
    bench.bar_has(&[], false);
    bench.press(PanelCommand::Advance);
    assert!(!bench.drives(bench.opening()), "the bar moves, and where is not known");
    bench.release();
    bench.bar_has(&[], true);
    bench.press(PanelCommand::Advance);
    assert!(bench.drives(bench.opening()), "out of it, while the bar stands: {}", bench.blocked());
    bench.bar_has(&[], false);
    assert!(!bench.drives(bench.opening()), "the bar moves, and no switch says where");
    assert!(bench.blocked().contains("interlock: transfer not clear: no switches measure that"), "{}", bench.blocked());
    // At home without a memory: nothing stands in for the counts, not even of the mill, whose conflict is measured.
    let mut bench = InterlockBench::new(line, 0);
    bench.mode(ControlMode::Manual);
    bench.press(PanelCommand::Advance);
    assert!(!bench.drives(bench.closing()), "into it");
    assert!(bench.blocked().contains("it has no memory of the cycle"), "{}", bench.blocked());
}

#[test]
fn a_hand_mode_motion_that_was_let_go_is_not_taken_up_while_the_other_is_unknown() {
    let mut bench = InterlockBench::new(transfer_line(), GENERATION);
    // The bar has lowered the part of the first cycle.
    (bench.bar.cycle, bench.bar.done) = (1, vec![1; 10]);
    bench.mode(ControlMode::Hand);
    let button = bench.line.operation((CLAMP, bench.op("advance clamp"))).hand.forward();
    let hold = |bench: &mut InterlockBench, held: bool| {
        bench.order.buttons = if held { 1 << button.0 } else { 0 };
        bench.play();
    };
    hold(&mut bench, true);
    assert!(bench.drives(bench.closing()), "{}", bench.blocked());
    hold(&mut bench, false);
    assert!(!bench.drives(bench.closing()));
    bench.bar.devices_valid = false;
    bench.play();
    hold(&mut bench, true);
    assert!(!bench.drives(bench.closing()), "the bar is measured nowhere");
    assert!(bench.blocked().contains("position of transfer unknown"), "{}", bench.blocked());
    bench.bar.devices_valid = true;
    bench.play();
    assert!(bench.drives(bench.closing()), "{}", bench.blocked());
}

#[test]
fn a_station_whose_axis_has_left_its_switch_is_rejoined_where_it_is() {
    let mut bench = InterlockBench::new(transfer_line(), GENERATION);
    let home = bench.op("return clamp");
    assert_eq!(
        bench.clamp.handle(bench.now, StationInput::Rejoin(RejoinAt::Within(home), &[])),
        Handled::Ignored(Ignored::NotLost)
    );
    bench.set(&[]);
    assert!(bench.clamp.position_lost().is_some());
    assert!(bench.blocked().contains("rejoin"), "{}", bench.blocked());
    assert!(bench.clamp.handle(bench.now, StationInput::Rejoin(RejoinAt::Within(home), &[])).is_taken());
    bench.play();
    assert_eq!(bench.clamp.marking().collect::<Vec<_>>(), [StationPlace::incomplete(home)]);
    assert_eq!((bench.clamp.generation(), bench.clamp.position_lost()), (0, None));
    bench.mode(ControlMode::Manual);
    bench.press(PanelCommand::Advance);
    assert!(bench.drives(bench.opening()), "{}", bench.blocked());
    bench.set(&["LS_open"]);
    assert!(bench.clamp.is_at_home());
}

#[test]
fn more_peers_than_a_set_has_room_for_do_not_compile() {
    let mut line = transfer_line();
    let other = line.stations[1].clone();
    for nth in 0..256 {
        let mut station = other.clone();
        station.name = format!("clamp_{}", 10 + nth);
        let from = (StationId::at(line.stations.len()), OpId(0));
        line.stations.push(station);
        line.arrows.push(Arrow { from, to: (BAR, OpId(0)), lag: 0, auto: true, manual: true });
    }
    let refused = Program::compile(&line, BAR).expect_err("too many");
    assert!(matches!(refused, CompileError::TooManyPeers { has: 257, .. }), "{refused}");
}

#[test]
fn a_restart_does_not_make_known_where_a_station_stands() {
    let mut line = transfer_line();
    let advance = line.station(CLAMP).operation_named("advance clamp").expect("the clamp has it");
    // Outside this state the clamp moves, so none of its switches measures it; the bar's do.
    (line.conflicts[0].b.from, line.conflicts[0].b.until) = (advance, advance);
    assert!(line.clearance(&line.conflicts[0].b).is_err() && line.clearance(&line.conflicts[0].a).is_ok());
    let mut bench = InterlockBench::standing(line, 0, &[]);
    let opens = |bench: &mut InterlockBench| {
        bench.mode(ControlMode::Manual);
        bench.bar_has(&[], true);
        bench.press(PanelCommand::Advance);
        let opens = bench.drives(bench.opening());
        bench.release();
        opens
    };
    assert!(!opens(&mut bench), "it may stand anywhere, and the bar is in the way");
    let snapshot = bench.clamp.snapshot();
    bench.clamp = Controller::new(&bench.line, CLAMP, 2, Restore::From(snapshot)).expect("its own");
    bench.order.boot_id = 10;
    assert!(!opens(&mut bench), "no more is known than before");
    bench.bar_has(&["LS_vertical_0"], true);
    bench.press(PanelCommand::Advance);
    assert!(bench.drives(bench.opening()), "{}", bench.blocked());
}
