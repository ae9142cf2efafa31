//! Scenarios, named by what happens to the device.

use std::time::Duration;

use linewright_fieldbus_seam::{BusRefusal, BusRequest as Asked, BusTarget, InputImage, Level, News, abort};
use linewright_line::{
    Device, DeviceBus, DeviceKind, InputId, Modbus, OutputId, Owner, RegisterValue, StationId, Table, Tick,
    WatchdogRegister,
};
use linewright_modbus::{LinkAct, LinkOutcome, LinkTask, ModbusFailure, ModbusManager, ModbusOutbox, ModbusRequest};

const OWNER: Owner = Owner::Station(StationId(0));
const OTHER: Owner = Owner::Station(StationId(1));

fn modbus() -> Modbus {
    Modbus {
        address: "127.0.0.1:1502".to_owned(),
        unit: 1,
        cycle: Duration::from_millis(20),
        timeout: Duration::from_millis(100),
        inputs: vec![Some(InputId(0)), None, Some(InputId(1))],
        inputs_at: (Table::DiscreteInputs, 10),
        outputs: vec![Some(OutputId(0)), Some(OutputId(1))],
        outputs_at: (Table::Coils, 0),
        reads_back: false,
        watchdog: Some(WatchdogRegister { register: 16, timeout: Duration::from_millis(300) }),
        without_watchdog: None,
        expect: vec![RegisterValue { register: 0, value: 0x401 }],
        settings: vec![RegisterValue { register: 17, value: 300 }],
    }
}

fn device(name: &str, owner: Owner, modbus: Modbus) -> Device {
    Device { name: name.to_owned(), owner, bus: DeviceBus::Line, kind: DeviceKind::Modbus(modbus) }
}

/// A device as the tests have it, behind a line that takes a while.
#[derive(Clone, Default)]
struct Station {
    inputs: u64,
    coils: u64,
    fed: Vec<u64>,
    set: Vec<(u16, u64)>,
    code: u64,
    /// Time for an answer.
    takes: Duration,
    /// It takes no connections, and none that it had is left.
    gone: bool,
    /// It refuses everything but connections with this code.
    refuses: Option<u8>,
    connected: Option<u32>,
    connections: u32,
}

impl Station {
    fn answer(&mut self, request: ModbusRequest) -> LinkOutcome {
        if let Some(code) = self.refuses {
            return LinkOutcome::Failed(ModbusFailure::Exception(code));
        }
        match request {
            ModbusRequest::Read { table: Table::DiscreteInputs, first: 10, count: 3 } => LinkOutcome::Read(self.inputs),
            ModbusRequest::Read { table: Table::Coils, first: 0, count: 2 } => LinkOutcome::Read(self.coils),
            ModbusRequest::Read { table: Table::HoldingRegisters, first: 0, count: 1 } => LinkOutcome::Read(self.code),
            ModbusRequest::WriteCoils { first: 0, count: 2, bits } => {
                self.coils = bits;
                LinkOutcome::Written
            }
            ModbusRequest::WriteRegisters { first: 16, count: 1, words } => {
                self.fed.push(words);
                LinkOutcome::Written
            }
            ModbusRequest::WriteRegisters { first, count: 1, words } => {
                self.set.push((first, words));
                LinkOutcome::Written
            }
            other => panic!("{other}"),
        }
    }
}

struct ModbusBench {
    manager: ModbusManager,
    now: Tick,
    out: ModbusOutbox,
    stations: Vec<Station>,
    /// Outcomes under way: time of arrival, device, connection.
    coming: Vec<(Tick, usize, u32, LinkOutcome)>,
    news: Vec<News>,
}

impl ModbusBench {
    fn new(devices: &[Device]) -> Self {
        let station = Station { code: 0x401, takes: Duration::from_millis(2), ..Station::default() };
        ModbusBench {
            manager: ModbusManager::new(devices),
            now: Tick::from_millis(1000),
            out: ModbusOutbox::default(),
            stations: vec![station; devices.len()],
            coming: Vec::new(),
            news: Vec::new(),
        }
    }

    fn up() -> Self {
        let mut bench = ModbusBench::new(&[device("io", OWNER, modbus())]);
        bench.run(50);
        assert!(bench.inputs().valid, "{:?}", bench.manager.trouble(bench.now, OWNER));
        bench
    }

    fn inputs(&self) -> InputImage {
        self.manager.inputs(self.now, OWNER).expect("its devices are here")
    }

    fn trouble(&self) -> String {
        self.manager.trouble(self.now, OWNER).join("; ")
    }

    fn set(&mut self, image: u128) {
        self.manager.set_outputs(self.now, OWNER, image, &mut self.out);
        self.act();
    }

    fn act(&mut self) {
        for LinkAct { device, link, what } in std::mem::take(&mut self.out.acts) {
            let station = &mut self.stations[device];
            let arrives = self.now + station.takes;
            match what {
                LinkTask::Connect if station.gone => {
                    let refused = LinkOutcome::Failed(ModbusFailure::Gone("connection refused".to_owned()));
                    self.coming.push((arrives, device, link, refused));
                }
                LinkTask::Connect => {
                    station.connected = Some(link);
                    station.connections += 1;
                    self.coming.push((arrives, device, link, LinkOutcome::Connected));
                }
                LinkTask::Ask(_) if station.gone => {
                    let closed = LinkOutcome::Failed(ModbusFailure::Gone("connection closed".to_owned()));
                    self.coming.push((arrives, device, link, closed));
                }
                LinkTask::Ask(request) => {
                    assert_eq!(station.connected, Some(link));
                    let outcome = station.answer(request);
                    self.coming.push((arrives, device, link, outcome));
                }
                LinkTask::Close { last } => {
                    if let Some(last) = last.filter(|_| station.refuses.is_none()) {
                        station.answer(last);
                    }
                    station.connected = None;
                    self.coming.retain(|(_, of, ..)| *of != device);
                }
            }
        }
        self.news.append(&mut self.out.news);
    }

    /// Lets so many milliseconds go by, one by one.
    fn run(&mut self, millis: u64) {
        for _ in 0..millis {
            self.now = self.now + Duration::from_millis(1);
            let (arrived, coming) = std::mem::take(&mut self.coming).into_iter().partition(|(at, ..)| *at <= self.now);
            self.coming = coming;
            let arrived: Vec<(Tick, usize, u32, LinkOutcome)> = arrived;
            for (_, device, link, outcome) in arrived {
                self.manager.handle(self.now, device, link, outcome, &mut self.out);
                self.act();
            }
            if self.manager.next_deadline() <= self.now {
                self.manager.poll(self.now, &mut self.out);
                self.act();
            }
        }
    }

    fn noted(&self, what: &str) -> usize {
        self.news.iter().filter(|news| matches!(news, News::Noted(text) if text.contains(what))).count()
    }
}

#[test]
fn a_device_is_compared_turned_off_and_set_up_before_it_is_used() {
    let mut bench = ModbusBench::up();
    assert_eq!((bench.stations[0].coils, bench.stations[0].set.as_slice()), (0, &[(17, 300)][..]));
    bench.stations[0].inputs = 0b111;
    bench.set(0b10);
    bench.run(25);
    assert_eq!(bench.stations[0].coils, 0b10);
    // The bit in the middle has no wire.
    assert_eq!((bench.inputs().bits, bench.inputs().losses), (0b11, 0));
}

#[test]
fn the_watchdog_gets_another_number_in_each_cycle() {
    let mut bench = ModbusBench::up();
    bench.stations[0].fed.clear();
    bench.run(200);
    let fed = &bench.stations[0].fed;
    assert!((9..=11).contains(&fed.len()), "{fed:?}");
    assert!(fed.windows(2).all(|pair| pair[0] != pair[1]), "{fed:?}");
}

#[test]
fn outputs_go_off_with_the_next_request_and_not_with_the_next_cycle() {
    let mut bench = ModbusBench::up();
    bench.set(0b11);
    bench.run(30);
    assert_eq!(bench.stations[0].coils, 0b11);
    // At every moment of a cycle: at most one answer of 2 ms is waited for.
    for moment in 0..25 {
        bench.set(0b11);
        bench.run(40 + moment);
        assert_eq!(bench.stations[0].coils, 0b11);
        bench.set(0);
        bench.run(2);
        assert_eq!(bench.stations[0].coils, 0, "at {moment}");
    }
}

#[test]
fn a_server_that_is_gone_is_lost_and_tried_again_later_and_later() {
    let mut bench = ModbusBench::up();
    bench.set(0b01);
    bench.run(1500);
    bench.stations[0].gone = true;
    bench.run(30);
    assert!(!bench.inputs().valid);
    assert_eq!(bench.inputs().losses, 1);
    let trouble = bench.trouble();
    assert!(trouble.starts_with("io (127.0.0.1:1502 unit 1): no connection: connection closed; tried"), "{trouble}");
    bench.run(5000);
    assert_eq!(bench.noted("io is lost"), 1);
    assert_eq!(bench.noted("io is not started: no connection: connection refused"), 1, "said once");
    bench.stations[0].gone = false;
    bench.stations[0].connections = 0;
    bench.run(2010);
    assert!(bench.inputs().valid, "{}", bench.trouble());
    assert_eq!(bench.stations[0].connections, 1);
    assert_eq!(bench.stations[0].coils, 0, "what was set before the loss is forgotten");
    bench.set(0b01);
    bench.run(5);
    assert_eq!(bench.stations[0].coils, 0b01);
}

#[test]
fn a_server_that_does_not_answer_in_time_is_lost_and_told_to_let_go() {
    let mut bench = ModbusBench::up();
    bench.set(0b11);
    bench.run(50);
    bench.stations[0].takes = Duration::from_secs(10);
    let mut millis = 0;
    while bench.inputs().valid {
        bench.run(1);
        millis += 1;
    }
    // The answer under way, a cycle, and the time it has.
    assert!(millis <= 125, "{millis}");
    bench.run(1);
    assert!(bench.trouble().contains("no answer within 100 ms ("), "{}", bench.trouble());
    assert_eq!(bench.stations[0].coils, 0, "the last order of the connection");
    assert_eq!(bench.manager.diagnoses(bench.now)[0].level, Level::Stale);
}

#[test]
fn a_slow_server_is_reported_and_used() {
    let mut bench = ModbusBench::up();
    bench.stations[0].takes = Duration::from_millis(60);
    bench.run(1000);
    assert!(bench.inputs().valid);
    assert_eq!(bench.noted("io is slow: an answer took 60 ms, in a cycle of 20 ms"), 1);
    assert_eq!(bench.manager.diagnoses(bench.now)[0].level, Level::Warn);
    bench.stations[0].takes = Duration::from_millis(2);
    bench.run(11_000);
    assert_eq!(bench.noted("io is slow no longer"), 1);
}

#[test]
fn a_wrong_register_map_is_named_and_nothing_is_started() {
    let mut bench = ModbusBench::new(&[device("io", OWNER, modbus())]);
    bench.stations[0].refuses = Some(2);
    bench.set(0b11);
    bench.run(4000);
    assert!(!bench.inputs().valid);
    let trouble = bench.trouble();
    let expected =
        "wrong register map: reading 1 holding registers from 0 is refused: illegal data address (exception 2)";
    assert!(trouble.contains(expected), "{trouble}");
    assert_eq!(bench.noted("io is not started"), 1);
    assert_eq!(bench.manager.diagnoses(bench.now)[0].level, Level::Error);
    bench.stations[0].refuses = None;
    bench.run(2100);
    assert!(bench.inputs().valid, "{}", bench.trouble());
    assert_eq!(bench.stations[0].coils, 0b11, "set since it was last lost, which it never was");
}

#[test]
fn another_device_is_not_started_and_told_nothing() {
    let mut bench = ModbusBench::new(&[device("io", OWNER, modbus())]);
    bench.stations[0].code = 5;
    bench.stations[0].coils = 0b01;
    bench.run(3000);
    assert!(bench.trouble().contains("another device: holding register 0 is 5, expected 1025"), "{}", bench.trouble());
    assert_eq!(bench.stations[0].coils, 0b01);
}

#[test]
fn an_exception_under_way_loses_the_device() {
    let mut bench = ModbusBench::up();
    bench.stations[0].refuses = Some(4);
    bench.run(30);
    assert_eq!((bench.inputs().valid, bench.inputs().losses), (false, 1));
    assert!(bench.trouble().contains("device failure (exception 4)"), "{}", bench.trouble());
}

#[test]
fn one_device_lost_lets_go_of_its_owners_others_and_of_nobody_elses() {
    let devices = [device("a", OWNER, modbus()), device("b", OWNER, modbus()), device("c", OTHER, modbus())];
    let mut bench = ModbusBench::new(&devices);
    bench.run(50);
    bench.set(0b11);
    bench.manager.set_outputs(bench.now, OTHER, 0b11, &mut bench.out);
    bench.run(50);
    assert_eq!(bench.stations.iter().map(|station| station.coils).collect::<Vec<_>>(), [0b11; 3]);
    bench.stations[0].gone = true;
    bench.run(60);
    assert_eq!([bench.stations[1].coils, bench.stations[2].coils], [0, 0b11]);
    assert!(bench.manager.inputs(bench.now, OTHER).is_some_and(|image| image.valid));
}

#[test]
fn an_orderly_end_lets_go_and_closes() {
    let mut bench = ModbusBench::up();
    bench.set(0b11);
    bench.run(50);
    bench.manager.release_outputs(&mut bench.out);
    bench.act();
    assert_eq!((bench.stations[0].coils, bench.stations[0].connected), (0, None));
    bench.set(0b11);
    bench.run(5000);
    assert_eq!((bench.stations[0].coils, bench.stations[0].connected), (0, None));
}

#[test]
fn requests_are_answered_and_objects_refused_in_words() {
    let mut bench = ModbusBench::up();
    bench.set(0b11);
    bench.run(50);
    let io = BusTarget::Device("io".to_owned());
    let object = linewright_fieldbus_seam::ObjectAddress { index: 0x1018, sub: 1 };
    assert_eq!(bench.manager.ask(bench.now, &BusTarget::Node(4), Asked::Reset, &mut bench.out), None);
    let number = bench.manager.ask(bench.now, &io, Asked::Read(object), &mut bench.out);
    let refusal = BusRefusal {
        text: "io, read object 1018h:01: it speaks Modbus, and has no objects".to_owned(),
        code: abort::UNSUPPORTED,
    };
    assert_eq!(bench.out.answers.pop(), Some((number.expect("it is here"), Err(refusal))));
    bench.manager.ask(bench.now, &io, Asked::Reset, &mut bench.out);
    bench.act();
    assert_eq!((bench.stations[0].coils, bench.inputs().losses), (0, 1));
    bench.run(50);
    assert!(bench.inputs().valid, "{}", bench.trouble());
}

#[test]
fn after_a_standstill_nothing_that_was_decided_before_is_written() {
    let mut bench = ModbusBench::up();
    bench.set(0b11);
    // A device that answers within 2 ms is idle for most of a cycle of 20 ms.
    while bench.stations[0].coils == 0 || !bench.coming.is_empty() {
        bench.run(1);
    }
    bench.now = bench.now + Duration::from_secs(60);
    // Its watchdog has run out meanwhile.
    bench.stations[0].coils = 0;
    for _ in 0..500 {
        bench.run(1);
        assert_eq!(bench.stations[0].coils, 0, "{}", bench.trouble());
    }
    assert_eq!(bench.noted("io is lost: not asked for"), 1);
    assert_eq!((bench.inputs().valid, bench.inputs().losses), (true, 1), "it has come up again, with all outputs off");
}

#[test]
fn a_device_whose_watchdog_may_have_run_out_is_lost_before_it_is_written_again() {
    let described = Modbus {
        timeout: Duration::from_millis(50),
        watchdog: Some(WatchdogRegister { register: 16, timeout: Duration::from_millis(130) }),
        ..modbus()
    };
    let mut bench = ModbusBench::new(&[device("io", OWNER, described)]);
    bench.run(50);
    assert!(bench.inputs().valid, "{}", bench.trouble());
    // Three answers of a cycle take longer than the watchdog.
    bench.stations[0].takes = Duration::from_millis(45);
    bench.run(500);
    assert!(bench.noted("its watchdog was not written for") >= 1);
}

/// Another master on the same server, or a device that has turned its outputs off by itself.
#[test]
fn outputs_that_are_not_as_written_lose_a_device_that_is_read_back() {
    for reads_back in [false, true] {
        let mut bench = ModbusBench::new(&[device("io", OWNER, Modbus { reads_back, ..modbus() })]);
        bench.run(50);
        for image in [0b01, 0b11, 0b10] {
            bench.set(image);
            bench.run(60);
            assert_eq!((bench.inputs().valid, u128::from(bench.stations[0].coils)), (true, image));
        }
        bench.stations[0].coils = 0b11;
        bench.run(30);
        assert_eq!(bench.inputs().losses, u32::from(reads_back), "{}", bench.trouble());
        if reads_back {
            let said = "its outputs are 3h, where 2h was written";
            assert_eq!(bench.noted(said), 1, "{:?}", bench.news);
            assert_eq!(bench.stations[0].coils, 0, "let go");
        }
    }
}
