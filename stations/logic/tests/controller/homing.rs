//! A table whose drive has lost its reference, and a press over it that is half-way through its cycle.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{Line, StationId, Tick, parse};
use linewright_station_logic::{
    Controller, Handled, Ignored, ModeOrder, NO_DELAY, PanelCommand, Restore, StationInput, StationOutbox,
    StationReport, StationSnapshot,
};

const TABLE: usize = 0;
const PRESS: usize = 1;
const STATIONS: [usize; 2] = [TABLE, PRESS];
const GENERATION: u64 = 5;
const REFRESH: Duration = Duration::from_millis(20);

/// Something that happens to the bench, with its name.
type Change = (&'static str, fn(&mut HomingBench));

/// Two real controllers that receive each other's reports; a test is their mechanisms.
struct HomingBench {
    line: Line,
    controllers: Vec<Controller>,
    images: [u128; 2],
    outputs: [u128; 2],
    held: [Option<PanelCommand>; 2],
    order: ModeOrder,
    now: Tick,
    /// Reports of the press do not arrive.
    is_cut: bool,
    /// What the table receives of the press instead of its report.
    forged: Option<fn(&mut StationReport)>,
}

fn description() -> Line {
    parse("homed_table.toml", include_str!("homed_table.toml")).unwrap_or_else(|problems| panic!("{problems:#}")).line
}

fn bits(names: &[String], on: &[&str]) -> u128 {
    let bit = |name: &&str| 1u128 << names.iter().position(|known| known == name).expect("it has this signal");
    on.iter().map(bit).fold(0, |bits, bit| bits | bit)
}

impl HomingBench {
    /// Both at home with a generation in common, the table at place 1.
    fn at_home() -> Self {
        let line = description();
        let up = |at: usize| Controller::new(&line, StationId::at(at), 1, Restore::Fresh).expect("it compiles");
        let mut bench = HomingBench {
            controllers: STATIONS.map(up).into(),
            images: [0; 2],
            outputs: [0; 2],
            held: [None; 2],
            order: ModeOrder {
                manual_all: true,
                found: Some(GENERATION),
                ..ModeOrder::of(9, 1, ControlMode::StandBy, Duration::from_secs(1))
            },
            now: Tick::from_millis(1000),
            is_cut: false,
            forged: None,
            line,
        };
        bench.images[PRESS] = bits(&bench.line.stations[PRESS].inputs, &["LS_up"]);
        bench.see(TABLE, &["in_place", "place_1"]);
        bench.order.found = None;
        bench
    }

    /// The table has turned to place 2, the press is on its way down, and the drive has lost its reference: its process
    /// image says nothing.
    fn lost() -> Self {
        let mut bench = HomingBench::at_home();
        bench.mode(ControlMode::Auto);
        bench.see(TABLE, &["place_1"]);
        bench.see(TABLE, &["in_place", "place_2"]);
        assert_eq!(bench.outputs(PRESS), ["down"], "{}", bench.waits(PRESS));
        bench.see(PRESS, &[]);
        bench.see(TABLE, &[]);
        assert!(bench.controllers[TABLE].position_lost().is_some());
        bench.mode(ControlMode::Manual);
        assert_eq!(bench.outputs, [0, 0]);
        bench
    }

    /// The same, the press having been led back.
    fn clear() -> Self {
        let mut bench = HomingBench::lost();
        bench.press(PRESS, PanelCommand::Advance);
        assert_eq!(bench.outputs(PRESS), Vec::<&str>::new(), "nothing goes down on a table at an unknown place");
        bench.press(PRESS, PanelCommand::Retract);
        assert_eq!(bench.outputs(PRESS), ["up"], "{}", bench.waits(PRESS));
        bench.see(PRESS, &["LS_up"]);
        bench.release();
        bench.wait_ms(1000);
        bench
    }

    fn play(&mut self) {
        self.now = self.now + REFRESH;
        for at in STATIONS {
            let image =
                StationInput::Inputs { bits: self.images[at], valid: true, until: Tick::NEVER, under: NO_DELAY };
            self.controllers[at].handle(self.now, image);
            self.controllers[at].handle(self.now, StationInput::Order(self.order));
            if let Some(command) = self.held[at] {
                self.controllers[at].handle(self.now, StationInput::Panel(command));
            }
            let other = 1 - at;
            if !(self.is_cut && other == PRESS) {
                let mut report = self.controllers[other].report();
                self.forged.filter(|_| other == PRESS).into_iter().for_each(|forge| forge(&mut report));
                self.controllers[at].handle(self.now, StationInput::View(StationId::at(other), &report));
            }
            let mut out = StationOutbox::default();
            self.controllers[at].step(self.now, &mut out);
            self.outputs[at] = out.outputs;
        }
    }

    fn wait_ms(&mut self, ms: u64) {
        let end = self.now + Duration::from_millis(ms);
        while self.now < end {
            self.play();
        }
    }

    fn mode(&mut self, mode: ControlMode) {
        (self.order.mode, self.order.epoch) = (mode, self.order.epoch + 1);
        self.wait_ms(60);
    }

    fn see(&mut self, at: usize, on: &[&str]) {
        self.images[at] = bits(&self.line.stations[at].inputs, on);
        self.wait_ms(60);
    }

    fn press(&mut self, at: usize, command: fn(bool) -> PanelCommand) {
        self.release();
        self.held[at] = Some(command(true));
        self.wait_ms(60);
    }

    fn release(&mut self) {
        self.held = [None; 2];
        for at in STATIONS {
            for command in [PanelCommand::Advance(false), PanelCommand::Retract(false)] {
                self.controllers[at].handle(self.now, StationInput::Panel(command));
            }
        }
        self.wait_ms(60);
    }

    fn outputs(&self, at: usize) -> Vec<&str> {
        let names = self.line.stations[at].outputs.iter().enumerate();
        names.filter(|(bit, _)| self.outputs[at] & (1 << bit) != 0).map(|(_, name)| name.as_str()).collect()
    }

    fn waits(&self, at: usize) -> String {
        self.controllers[at].blocked_by(&self.line, self.now).join("\n")
    }

    /// Counts of the table, its generation, and its place.
    fn counts(&self) -> (i32, Vec<i32>, u64, u16) {
        let kept = self.controllers[TABLE].snapshot();
        (kept.cycle, kept.done, kept.generation, kept.place)
    }
}

#[test]
fn a_table_that_stands_is_homed_without_waiting_for_the_arrows_of_its_next_index() {
    let mut bench = HomingBench::clear();
    let before = bench.counts();
    let waits = bench.waits(TABLE);
    assert!(waits.contains("the homing of its drive: hold advance at its panel in manual"), "{waits}");
    assert!(!waits.contains("press: raise"), "{waits}");
    bench.press(TABLE, PanelCommand::Advance);
    assert_eq!(bench.outputs(TABLE), ["turn"], "to no place: {}", bench.waits(TABLE));
    assert!(!bench.controllers[TABLE].report().stopped);
    assert!(bench.controllers[TABLE].report().position_lost.is_some(), "nothing builds on it meanwhile");
    // No index's watchdog ends it.
    bench.wait_ms(20_000);
    assert_eq!(bench.outputs(TABLE), ["turn"]);
    bench.release();
    assert_eq!(bench.outputs(TABLE), Vec::<&str>::new(), "while it is held, and no longer");
    bench.press(TABLE, PanelCommand::Advance);
    // Homed where it stood: nothing has become of it, and the button held on begins no index.
    bench.see(TABLE, &["in_place", "place_2"]);
    assert_eq!((bench.outputs(TABLE), bench.counts()), (vec![], before), "{}", bench.waits(TABLE));
    assert_eq!(bench.controllers[TABLE].position_lost(), None);
    bench.release();
    bench.mode(ControlMode::Auto);
    assert_eq!(bench.outputs(PRESS), ["down"], "the cycle goes on: {}", bench.waits(PRESS));
}

#[test]
fn homed_at_another_place_than_it_stood_at_it_is_in_doubt_and_a_person_confirms() {
    let mut bench = HomingBench::clear();
    bench.press(TABLE, PanelCommand::Advance);
    bench.see(TABLE, &["in_place", "place_1"]);
    assert_eq!(bench.outputs(TABLE), Vec::<&str>::new());
    let fault = bench.controllers[TABLE].fault_text(&bench.line);
    assert!(fault.contains("measured at or after place 1, last known at place 2"), "{fault}");
    bench.release();
    bench.press(TABLE, PanelCommand::Advance);
    assert_eq!(bench.outputs(TABLE), Vec::<&str>::new());
    bench.release();
    assert!(bench.controllers[TABLE].handle(bench.now, StationInput::Rejoin(None.into(), &[])).is_taken());
    bench.wait_ms(60);
    assert_eq!((bench.controllers[TABLE].position_lost(), bench.counts().2), (None, 0));
}

#[test]
fn a_homing_does_not_begin_while_the_press_is_in_its_way_or_not_known() {
    let hindrances: [Change; 6] = [
        ("not measured up", |bench| bench.see(PRESS, &[])),
        ("not received", |bench| bench.is_cut = true),
        ("without its devices", |bench| bench.forged = Some(|report| report.devices_valid = false)),
        ("moving", |bench| bench.forged = Some(|report| report.stopped = false)),
        ("its position lost", |bench| {
            bench.forged = Some(|report| {
                report.position_lost = Some((linewright_line::OpId(0), linewright_line::InputId(0)));
            });
        }),
        ("in its state by its marking, though its switch is on", |bench| {
            bench.forged = Some(|report| report.places = vec![2, 0]);
        }),
    ];
    for (name, hinder) in hindrances {
        let mut bench = HomingBench::clear();
        hinder(&mut bench);
        bench.wait_ms(1000);
        bench.press(TABLE, PanelCommand::Advance);
        assert_eq!(bench.outputs(TABLE), Vec::<&str>::new(), "{name}");
        let waits = bench.waits(TABLE);
        assert!(waits.contains("for the homing of its drive"), "{name}: {waits}");
        // One that comes up under way ends it, and its end begins nothing: the button has to be pressed again.
        let mut bench = HomingBench::clear();
        bench.press(TABLE, PanelCommand::Advance);
        assert_eq!(bench.outputs(TABLE), ["turn"], "{name}");
        hinder(&mut bench);
        bench.wait_ms(1000);
        assert_eq!(bench.outputs(TABLE), Vec::<&str>::new(), "{name}");
        (bench.is_cut, bench.forged) = (false, None);
        bench.see(PRESS, &["LS_up"]);
        bench.wait_ms(1000);
        assert_eq!(bench.outputs(TABLE), Vec::<&str>::new(), "{name}");
    }
}

#[test]
fn a_homing_does_not_begin_before_every_older_view_of_the_table_has_run_out() {
    let mut bench = HomingBench::clear();
    bench.see(TABLE, &["in_place", "place_2"]);
    bench.see(TABLE, &[]);
    bench.press(TABLE, PanelCommand::Advance);
    assert_eq!(bench.outputs(TABLE), Vec::<&str>::new(), "a press might have started by its last report");
    bench.wait_ms(1000);
    bench.press(TABLE, PanelCommand::Advance);
    assert_eq!(bench.outputs(TABLE), ["turn"]);
}

#[test]
fn a_homing_is_ended_by_its_drives_fault_by_another_mode_and_by_return() {
    let ends: [Change; 4] = [
        ("fault", |bench| bench.see(TABLE, &["drive_fault"])),
        ("emergency stop", |bench| bench.mode(ControlMode::EStop)),
        ("stand-by", |bench| bench.mode(ControlMode::StandBy)),
        ("return", |bench| {
            bench.controllers[TABLE].handle(bench.now, StationInput::Panel(PanelCommand::Retract(true)));
            bench.play();
        }),
    ];
    for (name, end) in ends {
        let mut bench = HomingBench::clear();
        bench.press(TABLE, PanelCommand::Advance);
        assert_eq!(bench.outputs(TABLE), ["turn"], "{name}");
        end(&mut bench);
        assert_eq!(bench.outputs(TABLE), Vec::<&str>::new(), "{name}");
    }
    for mode in [ControlMode::Auto, ControlMode::Hand] {
        let mut bench = HomingBench::clear();
        bench.mode(mode);
        bench.press(TABLE, PanelCommand::Advance);
        assert_eq!(bench.outputs(TABLE), Vec::<&str>::new(), "in manual alone");
    }
}

/// The press starts nothing, in or out, while the table turns to its reference.
#[test]
fn nothing_else_moves_while_the_table_is_homed() {
    let mut bench = HomingBench::clear();
    bench.press(TABLE, PanelCommand::Advance);
    for command in [PanelCommand::Advance, PanelCommand::Retract] {
        bench.held[PRESS] = Some(command(true));
        bench.wait_ms(200);
        assert_eq!((bench.outputs(TABLE), bench.outputs(PRESS)), (vec!["turn"], vec![]));
        bench.controllers[PRESS].handle(bench.now, StationInput::Panel(command(false)));
        bench.held[PRESS] = None;
        bench.wait_ms(60);
    }
}

/// A person has looked before the table turned. The place where the homing ends is compared all the same.
#[test]
fn a_position_that_was_confirmed_before_the_homing_is_compared_with_where_it_ends() {
    let mut bench = HomingBench::clear();
    let index = bench.line.stations[TABLE].operation_named("index").expect("it turns");
    assert!(bench.controllers[TABLE].handle(bench.now, StationInput::Rejoin(Some(index).into(), &[])).is_taken());
    bench.wait_ms(60);
    bench.press(TABLE, PanelCommand::Advance);
    assert_eq!(bench.outputs(TABLE), ["turn"]);
    bench.see(TABLE, &["in_place", "place_4"]);
    assert_eq!(bench.outputs(TABLE), Vec::<&str>::new());
    let fault = bench.controllers[TABLE].fault_text(&bench.line);
    assert!(fault.contains("last known at place 2"), "{fault}");
}

#[test]
fn nothing_is_confirmed_while_the_table_is_homed() {
    let mut bench = HomingBench::clear();
    bench.press(TABLE, PanelCommand::Advance);
    assert_eq!(bench.outputs(TABLE), ["turn"]);
    let handled = bench.controllers[TABLE].handle(bench.now, StationInput::Rejoin(None.into(), &[]));
    assert_eq!(handled, Handled::Ignored(Ignored::Moving));
    bench.wait_ms(60);
    assert_eq!(bench.outputs(TABLE), ["turn"]);
}

#[test]
fn a_record_without_a_place_is_of_no_generation() {
    let bench = HomingBench::clear();
    let snapshot = bench.controllers[TABLE].snapshot();
    assert_eq!(snapshot.generation, GENERATION);
    let generation = |kept| {
        let restored = Controller::new(&bench.line, StationId::at(TABLE), 2, Restore::From(kept)).expect("it fits");
        restored.snapshot().generation
    };
    assert_eq!(generation(snapshot.clone()), GENERATION);
    assert_eq!(generation(StationSnapshot { place: 0, ..snapshot }), 0);
}
