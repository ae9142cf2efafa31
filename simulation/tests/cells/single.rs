//! One station in manual by itself while the others go on making parts: the real coordinator of the mode beside the token player,
//! the real controllers, and the plant. Each observes the others' messages only.

use std::time::Duration;

use linewright_coordinator_cell::{ActivityPhase, CellEvent, FiringId, PlayerInput};
use linewright_coordinator_logic::ModeCommand;
use linewright_coordinator_shell::orders::manual_permit;
use linewright_coordinator_shell::{CoordinatorArrival, CoordinatorEffect, CoordinatorRecord, CoordinatorShell, heard};
use linewright_line::net::ControlMode;
use linewright_line::{StationId, Tick};
use linewright_simulation::cell::CellSim;
use linewright_station_logic::{PanelCommand, RejoinAt};

use super::{LONG, Shipped, dispatcher, options, shipped};

const MILLIS: fn(u64) -> Duration = Duration::from_millis;
/// Between two looks of the coordinator.
const PERIOD: Duration = Duration::from_millis(10);

/// A cell with the coordinator of its mode.
struct Cell<'c> {
    of: &'c Shipped,
    sim: CellSim,
    dispatcher: Box<dyn linewright_coordinator_cell::Dispatcher>,
    shell: CoordinatorShell,
    sequence: u64,
    now: Tick,
    refusal: Option<String>,
    /// Held at a panel.
    held: Option<(StationId, PanelCommand)>,
}

impl<'c> Cell<'c> {
    /// In auto.
    fn new(of: &'c Shipped) -> Self {
        let mut cell = Cell {
            of,
            sim: of.sim(options(1, 0, Vec::new()), 0.0),
            dispatcher: Box::new(dispatcher(&of.cell, &of.table)),
            shell: CoordinatorShell::new(&of.line, 5, CoordinatorRecord { epoch: 10, estop: false }),
            sequence: 0,
            now: Tick::from_millis(10),
            refusal: None,
            held: None,
        };
        cell.run(MILLIS(200));
        for command in [ModeCommand::Start, ModeCommand::Auto] {
            cell.command(CoordinatorArrival::Command(command)).expect("it is obeyed");
        }
        cell
    }

    fn command(&mut self, command: CoordinatorArrival) -> Result<(), String> {
        self.refusal = None;
        self.shell.handle(self.now, command);
        self.run(MILLIS(100));
        self.refusal.take().map_or(Ok(()), Err)
    }

    fn single(&mut self, station: StationId, is_manual: bool) -> Result<(), String> {
        self.command(CoordinatorArrival::Single(station, is_manual))
    }

    fn run(&mut self, time: Duration) {
        let end = self.now + time;
        while self.now < end {
            self.look();
            self.sim.run_on(&mut *self.dispatcher, self.now);
            self.now = self.now + PERIOD;
        }
    }

    fn run_until(&mut self, what: &str, is_there: impl Fn(&Cell<'_>) -> bool) {
        let end = self.now + Duration::from_secs(600);
        while !is_there(self) {
            assert!(self.now < end, "{what}: {}", self.shell.coordinator().text());
            self.run(PERIOD);
        }
    }

    /// One period of the coordinator: reports in, orders out.
    fn look(&mut self) {
        let (now, line) = (self.now, &self.of.line);
        let untouched = line.console.estop.filter(|contact| !contact.pressed);
        let bits = untouched.map_or(0, |contact| 1 << contact.input.0);
        self.shell.handle(now, CoordinatorArrival::Console { bits, valid: true });
        self.sequence += 1;
        for id in line.station_ids() {
            let controller = self.sim.floor.as_ref().expect("real stations").controller(id);
            let mut heard = heard(&controller.report());
            heard.follows = controller.followed();
            self.shell.handle(now, CoordinatorArrival::State { station: id, sequence: self.sequence, heard });
        }
        let coordination = &self.sim.coordination;
        let isolated = linewright_coordinator_cell::exception::isolated(coordination.state());
        self.shell.plays_cell(isolated.into_iter(), coordination.state().exceptions().stopped());
        let held: Vec<StationId> = coordination.held_stations().collect();
        self.shell.hold(|id| held.contains(&id));
        self.shell.permit_manual(|id| Some(manual_permit(coordination, line, now, id)));
        let mut effects = Vec::new();
        self.shell.act(now, &mut effects);
        for effect in effects {
            match effect {
                CoordinatorEffect::Remember(record) => _ = self.shell.remembered(now, record, true),
                CoordinatorEffect::Refused(refusal) => self.refusal = Some(refusal.text(line)),
                _ => {}
            }
        }
        let order = self.shell.order();
        self.sim.starts = order.mode == ControlMode::Auto && order.enabled && order.master_stop.is_none();
        let coordinator = self.shell.coordinator();
        let by_hand = line.station_ids().filter(|&id| coordinator.is_by_hand(id));
        self.sim.in_manual = by_hand.map(|id| (id, coordinator.single_epoch(id))).collect();
        let floor = self.sim.floor.as_mut().expect("real stations");
        for id in line.station_ids() {
            floor.order(id, self.shell.order_for(id));
        }
        if let Some((station, button)) = self.held {
            floor.press(station, button);
        }
    }

    fn mode(&self, station: StationId) -> ControlMode {
        self.sim.floor.as_ref().expect("real stations").controller(station).mode()
    }

    fn moves(&self, station: StationId) -> bool {
        self.sim.floor.as_ref().expect("real").controller(station).marking().any(|place| place.is_operating())
    }

    fn station(&self, name: &str) -> StationId {
        self.of.line.station_named(name).expect("there")
    }

    fn say(&mut self, input: PlayerInput<'_>) -> Option<String> {
        let before = self.sim.events.len();
        self.sim.say(&mut *self.dispatcher, &[input]);
        let refused = self.sim.events.drain(before..).find_map(|(_, event)| match event {
            CellEvent::Objected { why, .. } => Some(format!("{why:?}")),
            _ => None,
        });
        self.run(MILLIS(100));
        refused
    }

    /// Holds a button of a panel, with a release before it.
    fn hold(&mut self, station: StationId, button: PanelCommand, time: Duration) {
        self.held = Some((station, PanelCommand::Advance(false)));
        self.run(MILLIS(100));
        self.held = Some((station, button));
        self.run(time);
        self.held = None;
        self.run(MILLIS(300));
    }
}

/// Machine 1 is stopped in the middle of its cut, by an alarm given for it; with what has failed, and its resource.
fn stopped<'c>(of: &'c Shipped) -> (Cell<'c>, FiringId, StationId) {
    let mut cell = Cell::new(of);
    let m1 = cell.station("m1");
    let cut = of.line.station(m1).operation_named("cut").expect("it does that");
    let cuts = move |cell: &Cell<'_>| {
        let controller = cell.sim.floor.as_ref().expect("real").controller(m1);
        controller.marking().any(|place| place.is_operating() && place.op == cut)
    };
    cell.run_until("m1 cuts", cuts);
    cell.run(MILLIS(500));
    let resource = cell.sim.table.handling().resource_named("M1").expect("there");
    let refusal = cell.single(m1, true).expect_err("it takes part in auto");
    assert!(refusal.contains("m1: takes part in auto"), "{refusal}");
    assert_eq!(cell.mode(m1), ControlMode::Auto);
    assert_eq!(cell.say(PlayerInput::Alarm { resource, text: "smoke" }), None);
    cell.run_until("somebody is asked", |cell| cell.sim.state().exceptions().alarms().next().is_some());
    let failed = cell.sim.state().firings().find(|of| of.phase != ActivityPhase::Running).expect("it has failed").id;
    (cell, failed, m1)
}

#[test]
fn a_person_leads_one_station_on_while_the_others_make_parts() {
    let of = shipped("workcell-c1", &[3, 4]);
    let (mut cell, failed, m1) = stopped(&of);
    let resource = cell.sim.table.handling().resource_named("M1").expect("there");
    let others: Vec<StationId> = of.line.station_ids().filter(|&id| id != m1).collect();
    cell.single(m1, true).expect("it is left out");
    assert_eq!(cell.mode(m1), ControlMode::Manual);
    assert!(others.iter().all(|&id| cell.mode(id) == ControlMode::Auto));
    let text = cell.shell.coordinator().text();
    assert_eq!(text, "auto, m1 in manual. Left out: m1");

    // The cell goes on.
    let left = cell.sim.state().left();
    cell.run_until("parts are made", |cell| cell.sim.state().left() >= left + 2);
    assert_eq!(cell.mode(m1), ControlMode::Manual);
    assert!(!cell.moves(m1), "nothing moves that nobody holds");

    // Held a while, let go, and held to the end.
    cell.hold(m1, PanelCommand::Advance(true), MILLIS(300));
    assert!(!cell.moves(m1));
    let alarm = cell.sim.state().exceptions().alarms().next().expect("it stands").id;
    for _ in 0..20 {
        cell.hold(m1, PanelCommand::Advance(true), Duration::from_secs(3));
    }
    let at_rest = |cell: &Cell<'_>| {
        let report = cell.sim.floor.as_ref().expect("real").controller(m1).report();
        report.order.and_then(|order| order.rest).is_some()
    };
    assert!(at_rest(&cell));
    // While it is in manual the activity keeps all it has, and nothing of it comes into service.
    let refusal = cell.say(PlayerInput::Answer { alarm, word: "as-done" }).expect("refused");
    assert!(refusal.contains("InManual"), "{refusal}");
    assert!(cell.sim.state().firing(failed).is_some());
    assert!(cell.say(PlayerInput::Resource { resource, up: true }).is_some());

    cell.single(m1, false).expect("at a rest");
    assert_eq!((cell.mode(m1), cell.shell.coordinator().mode()), (ControlMode::Auto, ControlMode::Auto));
    assert_eq!(cell.say(PlayerInput::Answer { alarm, word: "as-done" }), None);
    cell.run_until("it is closed", |cell| cell.sim.state().firing(failed).is_none());
    assert_eq!(cell.say(PlayerInput::Resource { resource, up: true }), None);
    cell.run_until("all are made", |cell| cell.sim.state().left() == 7);
    assert!(cell.now < LONG);
    of.is_done(&cell.sim);
}

/// Whatever ends auto ends it: what is held stops, and nothing goes on by itself.
#[test]
fn it_ends_with_auto_and_what_is_held_stops() {
    let of = shipped("workcell-c1", &[2, 2]);
    for command in [ModeCommand::EStop, ModeCommand::Stop] {
        let (mut cell, failed, m1) = stopped(&of);
        cell.single(m1, true).expect("it is left out");
        cell.held = Some((m1, PanelCommand::Advance(false)));
        cell.run(MILLIS(100));
        cell.held = Some((m1, PanelCommand::Advance(true)));
        cell.run(MILLIS(100));
        assert!(cell.moves(m1));
        cell.shell.handle(cell.now, CoordinatorArrival::Command(command));
        cell.run_until("auto has ended", |cell| cell.shell.coordinator().mode() != ControlMode::Auto);
        cell.run(MILLIS(50));
        assert!(!cell.moves(m1), "{command:?}");
        cell.run(Duration::from_secs(5));
        assert!(!cell.moves(m1) && !cell.shell.coordinator().is_single(m1));
        assert!(cell.sim.state().firing(failed).is_some());
    }
}

/// An answer is compared with sensors at a rest. A station that goes into manual before that may be moved from it: the alarm is
/// raised anew, and its activity keeps all it has.
#[test]
fn an_answer_is_taken_back_where_its_station_goes_into_manual() {
    let of = shipped("workcell-c1", &[1, 1]);
    let (mut cell, failed, m1) = stopped(&of);
    cell.single(m1, true).expect("it is left out");
    for _ in 0..20 {
        cell.hold(m1, PanelCommand::Advance(true), Duration::from_secs(3));
    }
    cell.single(m1, false).expect("at a rest");
    let alarm = cell.sim.state().exceptions().alarms().next().expect("it stands").id;
    cell.sim.say(&mut *cell.dispatcher, &[PlayerInput::Answer { alarm, word: "as-done" }]);
    assert!(cell.sim.state().exceptions().alarms().next().is_none(), "it is taken");
    cell.single(m1, true).expect("it is left out still");
    let alarm = cell.sim.state().exceptions().alarms().next().expect("it is raised anew");
    assert!(alarm.text.contains("m1 went into manual after the answer \"as-done\""), "{}", alarm.text);
    assert!(cell.sim.state().firing(failed).is_some());
    assert_eq!(cell.mode(m1), ControlMode::Manual);
}

/// Its place is not confirmed meanwhile: the others rely on the task it stands in.
#[test]
fn a_place_is_not_confirmed_in_manual_by_itself() {
    use linewright_station_logic::{Handled, Ignored, StationInput};
    let of = shipped("workcell-c1", &[1, 1]);
    let (mut cell, _, m1) = stopped(&of);
    cell.single(m1, true).expect("it is left out");
    let mut controller = cell.sim.floor.as_ref().expect("real").controller(m1).clone();
    let handled = controller.handle(cell.now, StationInput::Rejoin(RejoinAt::Measured, &[]));
    assert_eq!(handled, Handled::Ignored(Ignored::InSingleManual));
    cell.single(m1, false).expect("left out it goes back");
    let mut controller = cell.sim.floor.as_ref().expect("real").controller(m1).clone();
    let handled = controller.handle(cell.now, StationInput::Rejoin(RejoinAt::Measured, &[]));
    assert_eq!(handled, Handled::Ignored(Ignored::NotLost));
}
