//! Many devices at once, over a bus that has to be waited for: 500 kbit/s, and an interface that queues ten frames and
//! refuses what comes beyond.

use std::borrow::Cow;
use std::collections::VecDeque;

use linewright_line::ObjectWrite;

use super::*;
use crate::codec::NmtCommand;
use crate::sdo::{Abort, Dictionary, ObjectId, SdoServer};

/// Bus time of a frame of eight bytes at 500 kbit/s, with a few stuff bits.
const FRAME_TIME: Duration = Duration::from_micros(240);
const QUEUE: usize = 10;
/// Setting of each device before it is started: a domain of 1 kB.
const DOMAIN: usize = 1024;

/// The objects of a device: a profile of 401, and whatever is written.
#[derive(Default)]
struct CrowdObjects {
    domain: Vec<u8>,
    bytes: std::collections::BTreeMap<ObjectId, Vec<u8>>,
}

impl Dictionary for CrowdObjects {
    fn read(&mut self, object: ObjectId) -> Result<Cow<'_, [u8]>, Abort> {
        match object.index {
            0x1000 => Ok(vec![0x91, 1, 3, 0].into()),
            0x2000 => Ok(self.domain.clone().into()),
            _ => self.bytes.get(&object).map(|bytes| bytes.clone().into()).ok_or(Abort::NO_OBJECT),
        }
    }

    fn write(&mut self, object: ObjectId, data: &[u8]) -> Result<(), Abort> {
        if object.index == 0x2000 {
            self.domain = data.to_vec();
        }
        self.bytes.insert(object, data.to_vec());
        Ok(())
    }

    fn may_write(&mut self, _: ObjectId, _: Option<usize>) -> Result<(), Abort> {
        Ok(())
    }
}

struct CrowdStation {
    node: NodeId,
    server: SdoServer,
    objects: CrowdObjects,
    queue: VecDeque<Frame>,
    state: NmtState,
    next_heartbeat: Tick,
}

impl CrowdStation {
    /// Sends the next segments of a block, when the last ones are through.
    fn go_on(&mut self, now: Tick) {
        if self.queue.is_empty() {
            let (node, mut segments) = (self.node, Vec::new());
            self.server.poll(now, &mut segments);
            self.queue.extend(segments.into_iter().map(|raw| CanopenMessage::SdoResponse { node, raw }.encode()));
        }
    }

    fn hear(&mut self, now: Tick, frame: &Frame) {
        match CanopenMessage::decode(frame) {
            Ok(CanopenMessage::SdoRequest { node, raw }) if node == self.node => {
                let mut answers = Vec::new();
                self.server.handle(now, &raw, &mut self.objects, &mut answers);
                let node = self.node;
                self.queue.extend(answers.into_iter().map(|raw| CanopenMessage::SdoResponse { node, raw }.encode()));
            }
            Ok(CanopenMessage::Nmt { command: NmtCommand::Start, node }) if node == Some(self.node) => {
                self.state = NmtState::Operational;
                self.queue.push_back(format!("{:03X}#00", 0x180 + u16::from(self.node.get())).parse().unwrap());
            }
            _ => {}
        }
    }
}

struct Crowd {
    manager: Manager,
    now: Tick,
    queue: VecDeque<Frame>,
    refused: usize,
    stations: Vec<CrowdStation>,
    up: Vec<Tick>,
    answers: Vec<(u64, RequestResult)>,
}

impl Crowd {
    fn new(count: u8) -> Self {
        let mut devices: Vec<Device> = Vec::new();
        for id in 1..=count {
            let mut device = super::devices().remove(0);
            device.name = format!("io {id}");
            device.canopen_mut().expect("CANopen").node_id = id;
            device.owner = Owner::Station(StationId(id.into()));
            device.canopen_mut().expect("CANopen").setup.settings =
                vec![ObjectWrite { index: 0x2000, sub: 0, data: domain(id) }];
            devices.push(device);
        }
        let station = |id| CrowdStation {
            node: node(id),
            server: SdoServer::new(4096),
            objects: CrowdObjects::default(),
            // They are switched on with the manager: all send at once.
            queue: [format!("7{id:02X}#00").parse().unwrap()].into(),
            state: NmtState::PreOperational,
            next_heartbeat: Tick::from_millis(1050),
        };
        Crowd {
            manager: Manager::new(&devices, Timing::default()).unwrap(),
            now: Tick::from_millis(800),
            queue: VecDeque::new(),
            refused: 0,
            stations: (1..=count).map(station).collect(),
            up: Vec::new(),
            answers: Vec::new(),
        }
    }

    fn send(&mut self, mut out: BusOutbox) {
        self.answers.append(&mut out.answers);
        self.up.extend(out.events.iter().filter(|e| matches!(e, BusEvent::DeviceUp { .. })).map(|_| self.now));
        let failed = out.events.iter().find(|e| matches!(e, BusEvent::BootFailed { .. } | BusEvent::DeviceLost { .. }));
        assert_eq!(failed, None, "at {:?}", self.now);
        let room = QUEUE - self.queue.len();
        let mut frames = out.frames;
        let refused = frames.split_off(room.min(frames.len()));
        self.queue.extend(frames);
        if !refused.is_empty() {
            self.refused += refused.len();
            self.manager.return_unsent(self.now, refused);
        }
    }

    /// One frame, the one that wins among those that are first in their queues. The manager is called as a program
    /// with timers of a millisecond calls it.
    fn step(&mut self) {
        let mut out = BusOutbox::default();
        let grain = self.now.since(Tick::ZERO).as_micros() % 1000 < FRAME_TIME.as_micros();
        if grain && self.manager.next_deadline().is_none_or(|due| due <= self.now) {
            self.manager.poll(self.now, &mut out);
        }
        self.send(out);
        for station in self.stations.iter_mut().filter(|station| station.next_heartbeat <= self.now) {
            let state = station.state;
            station.queue.push_back(CanopenMessage::Heartbeat { node: station.node, state }.encode());
            station.next_heartbeat = station.next_heartbeat + Duration::from_millis(50);
        }
        for station in &mut self.stations {
            station.go_on(self.now);
        }
        let of_stations = (0..self.stations.len()).filter_map(|at| Some((self.stations[at].queue.front()?, Some(at))));
        let heads = self.queue.front().map(|frame| (frame, None)).into_iter().chain(of_stations);
        let wins = heads.min_by_key(|(frame, _)| frame.id_word()).map(|(_, sender)| sender);
        self.now = self.now + FRAME_TIME;
        match wins {
            Some(None) => {
                let frame = self.queue.pop_front().unwrap();
                for station in &mut self.stations {
                    station.hear(self.now, &frame);
                }
            }
            Some(Some(at)) => {
                let frame = self.stations[at].queue.pop_front().unwrap();
                let mut out = BusOutbox::default();
                self.manager.handle(self.now, &frame, &mut out);
                self.send(out);
            }
            None => {}
        }
    }

    /// Time until all of them are up.
    fn boot(&mut self) -> Duration {
        // It has listened for another manager first.
        let began = Tick::from_millis(1000);
        while self.up.len() < self.stations.len() {
            assert!(self.now.since(began) < Duration::from_secs(10), "{} are up", self.up.len());
            self.step();
        }
        for station in &self.stations {
            assert_eq!(station.objects.domain, domain(station.node.get()));
        }
        self.now.since(began)
    }
}

/// Bytes that are another device's nowhere.
fn domain(id: u8) -> Vec<u8> {
    (0..DOMAIN).map(|at| (at as u8).wrapping_mul(31).wrapping_add(id)).collect()
}

#[test]
fn many_devices_boot_at_once_and_no_queue_overflows() {
    let mut alone = Crowd::new(1);
    let one = alone.boot();
    assert_eq!(alone.refused, 0);
    // 147 segments, four in a millisecond, and some twenty other frames.
    assert!(one < Duration::from_millis(60), "{one:?}");

    let mut crowd = Crowd::new(32);
    let all = crowd.boot();
    println!("one device is up after {one:?}, 32 after {all:?}; {} frames refused", crowd.refused);
    // While all of them send boot-up, the heartbeat, last in rank, holds up what is queued behind it.
    assert!(crowd.refused < 50, "{}", crowd.refused);
    // 32 times 160 frames and their answers take 1.3 s on the wire; heartbeats and idle moments come to it.
    assert!(all < Duration::from_millis(2600), "{all:?}");
    // No device is served last: the first is up when the last is nearly.
    let first = crowd.up[0].since(Tick::from_millis(1000));
    assert!(first * 2 > all, "the first after {first:?}, the last after {all:?}");
}

#[test]
fn outputs_of_many_devices_go_off_at_once_and_no_queue_overflows() {
    let mut crowd = Crowd::new(32);
    crowd.boot();
    crowd.refused = 0;
    for on in [1, 0] {
        for station in 1..=32 {
            let mut out = BusOutbox::default();
            crowd.manager.set_outputs(crowd.now, Owner::Station(StationId(station)), on, &mut out);
            crowd.send(out);
        }
    }
    let began = crowd.now;
    while !crowd.manager.pace.is_empty() || !crowd.queue.is_empty() {
        crowd.step();
    }
    assert_eq!(crowd.refused, 0);
    let took = crowd.now.since(began);
    assert!(took < Duration::from_millis(20), "{took:?}");
}

#[test]
fn a_long_object_is_read_on_request_in_blocks_while_others_are_told_theirs() {
    let mut crowd = Crowd::new(8);
    crowd.boot();
    // Two devices boot again, and get a kilobyte each, in blocks; of a third and a fourth a kilobyte is read.
    for at in [5, 6] {
        let station = &mut crowd.stations[at];
        (station.objects.domain, station.state) = (Vec::new(), NmtState::PreOperational);
        station.queue.push_back(format!("7{:02X}#00", station.node.get()).parse().unwrap());
    }
    let began = crowd.now;
    let mut out = BusOutbox::default();
    let asked = [3, 4].map(|node| {
        (crowd.manager.ask(crowd.now, node, DeviceRequest::Read(ObjectId::new(0x2000, 0)), &mut out), Ok(domain(node)))
    });
    crowd.send(out);
    let told = |crowd: &Crowd| crowd.stations.iter().all(|station| station.objects.domain.len() == DOMAIN);
    while crowd.answers.len() < asked.len() || !told(&crowd) || crowd.up.len() < 10 {
        assert!(
            crowd.now.since(began) < Duration::from_secs(2),
            "{} answers, {} up",
            crowd.answers.len(),
            crowd.up.len()
        );
        crowd.step();
    }
    crowd.answers.sort_by_key(|(number, _)| *number);
    assert_eq!(crowd.answers, asked);
    assert!(crowd.stations.iter().all(|station| station.objects.domain == domain(station.node.get())));
    println!("two kilobytes each way after {:?}", crowd.now.since(began));
}
