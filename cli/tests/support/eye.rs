//! The observer: the machine's behaviour, read from the frames on its bus.
//!
//! It has the wiring (names to bits, from the description's text) and the states that must never occur on this machine,
//! written down here by hand:
//!
//! * the bar is off its rest (`LS_vertical_0` is off) while the clamp is not open (`LS_open` is off);
//! * the tool is forward (`LS_positioning_0` is off) while the clamp is not closed (`LS_closed` is off).
//!
//! It also keeps the order in which outputs came on, and the number of arrivals of each operation at its switch.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use super::bus::{EYE, Member};
use super::plan::{Drive, Plan};
use super::{PATIENCE, wait_for};

/// An output that moves something came on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Start {
    /// `station: output`.
    pub what: String,
    /// Outputs that were on already, in the same form.
    pub beside: Vec<String>,
}

/// State of the observation.
pub struct Seen {
    plan: Plan,
    /// By node id. An input is unknown until its device has sent.
    inputs: HashMap<u8, u64>,
    outputs: HashMap<u8, u64>,
    /// By node id: outputs that were on at any time since the station's last input frame. The frame that switches a motion off
    /// may be received before the input frame that it follows from.
    recent: HashMap<u8, u64>,
    holding: [bool; 2],
    conflicts: Vec<String>,
    starts: Vec<Start>,
    arrivals: HashMap<(String, String), i32>,
    frames: u64,
}

/// The observer's thread and its notes.
pub struct Eye {
    seen: Arc<Mutex<Seen>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Eye {
    /// Begins to look at the buses in these directories.
    pub fn open(plan: Plan, buses: Vec<PathBuf>) -> Self {
        let member = Member::join(buses, EYE).expect("a place on the bus");
        let seen = Arc::new(Mutex::new(Seen::new(plan)));
        let stop = Arc::new(AtomicBool::new(false));
        let (notes, ended) = (seen.clone(), stop.clone());
        let thread = std::thread::spawn(move || {
            let mut bytes = [0; 64];
            while !ended.load(Ordering::Relaxed) {
                if let Some(datagram) = member.receive(&mut bytes) {
                    lock(&notes).datagram(datagram);
                }
            }
        });
        Eye { seen, stop, thread: Some(thread) }
    }

    /// State of the observation so far.
    pub fn seen(&self) -> MutexGuard<'_, Seen> {
        lock(&self.seen)
    }

    /// Waits until something is seen.
    pub fn wait(&self, what: &str, holds: impl Fn(&Seen) -> bool) {
        self.within(PATIENCE, what, holds);
    }

    /// Waits until something is seen, no longer than this.
    pub fn within(&self, long: Duration, what: &str, holds: impl Fn(&Seen) -> bool) {
        if !wait_for(long, || holds(&self.seen())) {
            panic!("not seen within {long:?}: {what}; on are {:?}", self.seen().energised());
        }
    }
}

impl Drop for Eye {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn lock(seen: &Mutex<Seen>) -> MutexGuard<'_, Seen> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Seen {
    /// Observation of a recording, in the form of `candump -L`.
    pub fn of_log(plan: Plan, log: &str) -> Self {
        let mut seen = Seen::new(plan);
        for line in log.lines() {
            let frame = line.split_whitespace().nth(2).and_then(|frame| frame.split_once('#'));
            let (id, data) = frame.unwrap_or_else(|| panic!("no frame: {line}"));
            let byte = |at: usize| u8::from_str_radix(&data[at..at + 2], 16).expect("hexadecimal");
            let data: Vec<u8> = (0..data.len()).step_by(2).map(byte).collect();
            seen.frame(u32::from_str_radix(id, 16).expect("hexadecimal"), &data);
        }
        seen
    }

    fn new(plan: Plan) -> Self {
        Seen {
            plan,
            inputs: HashMap::new(),
            outputs: HashMap::new(),
            recent: HashMap::new(),
            holding: [false; 2],
            conflicts: Vec::new(),
            starts: Vec::new(),
            arrivals: HashMap::new(),
            frames: 0,
        }
    }

    /// Conflicts, each time one began.
    pub fn conflicts(&self) -> &[String] {
        &self.conflicts
    }

    /// Outputs that came on, in order.
    pub fn starts(&self) -> &[Start] {
        &self.starts
    }

    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Number of arrivals of an operation at its switch while it was driven there.
    pub fn arrivals(&self, station: &str, operation: &str) -> i32 {
        let is_known = self.plan.operations.iter().any(|o| o.station == station && o.name == operation);
        assert!(is_known, "{station} has {operation}");
        self.arrivals.get(&(station.to_owned(), operation.to_owned())).copied().unwrap_or(0)
    }

    /// An input of a station; off until its device has sent.
    pub fn input(&self, station: &str, name: &str) -> bool {
        self.known(station, name) == Some(true)
    }

    /// Whether this output of a station is on, by its last output frame.
    pub fn output(&self, station: &str, name: &str) -> bool {
        let (device, bit) = self.plan.with_output(station, name);
        self.outputs.get(&device.node).is_some_and(|bits| bits >> bit & 1 == 1)
    }

    /// Whether it was on at any time since the station's last input frame.
    fn was_output(&self, station: &str, name: &str) -> bool {
        let (device, bit) = self.plan.with_output(station, name);
        self.recent.get(&device.node).is_some_and(|bits| bits >> bit & 1 == 1)
    }

    /// Every output that moves something and is on.
    pub fn energised(&self) -> Vec<String> {
        let mut on = Vec::new();
        for device in &self.plan.devices {
            let Some(station) = &device.station else { continue };
            let moving = device.outputs.iter().filter(|o| self.plan.moves(station, o) && self.output(station, o));
            on.extend(moving.map(|output| format!("{station}: {output}")));
        }
        on
    }

    fn known(&self, station: &str, name: &str) -> Option<bool> {
        let (device, bit) = self.plan.with_input(station, name);
        self.inputs.get(&device.node).map(|bits| bits >> bit & 1 == 1)
    }

    fn datagram(&mut self, datagram: &[u8]) {
        let Ok(bytes) = <[u8; 16]>::try_from(datagram) else { return };
        let word = u32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        let length = usize::from(bytes[4]);
        // The top three bits mark extended, remote and error frames; a line uses none of them.
        if word > 0x7FF || length > 8 {
            return;
        }
        self.frame(word, &bytes[8..8 + length]);
    }

    fn frame(&mut self, word: u32, data: &[u8]) {
        self.frames += 1;
        let node = (word & 0x7F) as u8;
        match word & 0x780 {
            0x180 => {
                let bits = self.drive(node).map_or(number(data), |drive| places_reached(drive, data));
                self.heard_inputs(node, bits);
            }
            0x200 => {
                let bits = self.drive(node).map_or(number(data), |drive| place_ordered(drive, data));
                self.heard_outputs(node, bits);
            }
            // Emergency 8130h: the device has lost its manager and has switched its outputs off.
            0x080 if node != 0 && data.starts_with(&[0x30, 0x81]) => self.heard_outputs(node, 0),
            // Boot-up, or anything but operational: no outputs.
            0x700 if data != [5] => self.heard_outputs(node, 0),
            _ => {}
        }
    }

    fn drive(&self, node: u8) -> Option<&Drive> {
        self.plan.devices.iter().find(|device| device.node == node)?.drive.as_ref()
    }

    fn heard_inputs(&mut self, node: u8, bits: u64) {
        let Some(before) = self.inputs.insert(node, bits) else { return };
        let Some(device) = self.plan.devices.iter().find(|device| device.node == node).cloned() else { return };
        let Some(station) = device.station else { return };
        let came_on = bits & !before;
        for (_, input) in device.inputs.iter().enumerate().filter(|(bit, _)| came_on >> bit & 1 == 1) {
            let arrived: Vec<String> = self
                .plan
                .operations
                .iter()
                .filter(|o| o.station == station && o.complete == *input && self.was_output(&station, &o.actuator))
                .map(|o| o.name.clone())
                .collect();
            for operation in arrived {
                *self.arrivals.entry((station.clone(), operation)).or_default() += 1;
            }
        }
        for device in self.plan.devices.iter().filter(|device| device.station.as_ref() == Some(&station)) {
            self.recent.insert(device.node, self.outputs.get(&device.node).copied().unwrap_or(0));
        }
        self.judge();
    }

    fn heard_outputs(&mut self, node: u8, bits: u64) {
        let before = self.outputs.insert(node, 0).unwrap_or(0);
        *self.recent.entry(node).or_default() |= bits;
        let Some(device) = self.plan.devices.iter().find(|device| device.node == node).cloned() else { return };
        let Some(station) = device.station else { return };
        let mut beside = self.energised();
        self.outputs.insert(node, bits);
        for (bit, output) in device.outputs.iter().enumerate() {
            let what = format!("{station}: {output}");
            if (bits & !before) >> bit & 1 == 1 && self.plan.moves(&station, output) {
                self.starts.push(Start { what: what.clone(), beside: beside.clone() });
                beside.push(what);
            }
        }
    }

    fn judge(&mut self) {
        // The forbidden states are those of the shipped line alone.
        if self.plan.operations.iter().all(|operation| operation.station != "transfer") {
            return;
        }
        let off = |station: &str, input: &str| self.known(station, input) == Some(false);
        let now = [
            off("transfer", "LS_vertical_0") && off("clamp_1", "LS_open"),
            off("mill_1", "LS_positioning_0") && off("clamp_1", "LS_closed"),
        ];
        let why = ["the bar is off its rest while the clamp is not open", "the tool is forward on a clamp not closed"];
        for (index, why) in why.into_iter().enumerate() {
            if now[index] && !self.holding[index] {
                self.conflicts.push(format!("{why}, after {} starts", self.starts.len()));
            }
        }
        self.holding = now;
    }
}

/// Targets that a drive stands at, a bit for each. Its frame is statusword, mode and position.
fn places_reached(drive: &Drive, data: &[u8]) -> u64 {
    let Some(position) = number_at_3(data) else { return 0 };
    let near = |place: &i32| place.abs_diff(position) <= drive.window.unsigned_abs();
    // Of several targets at one place the first stands for all: they share their input.
    let first = |at: usize| !drive.places[..at].contains(&drive.places[at]);
    let reached = drive.places.iter().enumerate().filter(|(at, place)| first(*at) && near(place));
    reached.fold(0, |bits, (at, _)| bits | 1 << at)
}

/// Target that a drive is ordered to; of several at one place the first. Its frame is controlword, mode and target.
fn place_ordered(drive: &Drive, data: &[u8]) -> u64 {
    let Some(target) = number_at_3(data) else { return 0 };
    let word = u16::from_le_bytes([data[0], data[1]]);
    // Operation enabled, change set immediately, no halt.
    let goes = word & 0x012F == 0x002F;
    drive.places.iter().position(|place| goes && *place == target).map_or(0, |at| 1 << at)
}

fn number_at_3(data: &[u8]) -> Option<i32> {
    Some(i32::from_le_bytes(data.get(3..7)?.try_into().ok()?))
}

/// The bytes as one number, the first byte lowest: bit 0 is bit 0 of the first byte.
fn number(data: &[u8]) -> u64 {
    data.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}
