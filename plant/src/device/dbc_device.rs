//! A simulated device without CANopen: the frames of a DBC file, from the far end.
//!
//! It sends each message four times within the time in which it is missed, and at once when something changes; of a
//! multiplexed one all pages in turn. Signals have a value that makes the inputs what the plant has them: nothing else
//! of them is simulated. It does what a device of this kind has to do by itself: when a message it is sent has not come
//! for the time in its description, or three of its periods, or comes with the counter standing still, **its outputs go
//! off**.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_canopen::Frame;
use linewright_line::{FrameBinding, FrameField, FrameId, Page, ReceivedFrameBinding, SentFrameBinding, Tick, When};

use super::{CanDevice, DeviceOutbox};
use crate::fault::DeviceFault;

/// So many of its own messages within the time in which they are missed.
const PER_TIMEOUT: u32 = 4;
/// So many periods without a message it is sent, and its outputs go off, where the description gives no time.
const PERIODS: u32 = 3;

#[derive(Debug)]
struct SentFrame {
    frame: ReceivedFrameBinding,
    count: u64,
    page: usize,
    due: Tick,
}

#[derive(Debug)]
struct ReceivedFrame {
    frame: SentFrameBinding,
    /// When it is missed; `None` before it has come, and after that.
    missed: Option<Tick>,
    /// The outputs it switched on.
    outputs: u128,
}

/// A simulated device without CANopen.
#[derive(Debug)]
pub struct DbcDeviceNode {
    sent: Vec<SentFrame>,
    taken: Vec<ReceivedFrame>,
    /// The counter each message came with last, whatever it showed.
    counters: BTreeMap<FrameId, u64>,
    inputs: u128,
    silent: bool,
}

impl DbcDeviceNode {
    /// One that is switched on at `now`.
    pub fn new(now: Tick, binding: &FrameBinding) -> Self {
        let sent = |frame: &ReceivedFrameBinding| SentFrame { frame: frame.clone(), count: 0, page: 0, due: now };
        let taken = |frame: &SentFrameBinding| ReceivedFrame { frame: frame.clone(), missed: None, outputs: 0 };
        DbcDeviceNode {
            sent: binding.heard.iter().map(sent).collect(),
            taken: binding.told.iter().map(taken).collect(),
            counters: BTreeMap::new(),
            inputs: 0,
            silent: false,
        }
    }

    /// Bit `i` is output `i` of its owner; others than its own are 0.
    pub fn outputs(&self) -> u128 {
        self.taken.iter().fold(0, |all, taken| all | taken.outputs)
    }

    /// Sets its owner's inputs as the switches have them at `now`.
    pub fn set_inputs(&mut self, now: Tick, inputs: u128, out: &mut DeviceOutbox) {
        let changed = self.inputs ^ inputs;
        self.inputs = inputs;
        for sent in &mut self.sent {
            let mut own = sent.frame.pages.iter().flat_map(|page| &page.inputs);
            if own.any(|(input, _, _)| changed & input.bit() != 0) {
                for _ in 0..sent.frame.pages.len() {
                    send(sent, now, inputs, self.silent, out);
                }
            }
        }
    }
}

impl CanDevice for DbcDeviceNode {
    fn handle(&mut self, now: Tick, frame: &Frame, _: &mut DeviceOutbox) {
        let Some(id) = frame.frame_id().filter(|_| !self.silent) else { return };
        let mut data = [0; 8];
        data[..frame.data().len()].copy_from_slice(frame.data());
        let mut meant = self.taken.iter_mut().filter(|taken| taken.frame.id == id);
        let Some(taken) = meant.find(|taken| taken.is(frame.data().len(), &data)) else { return };
        if let Some(counter) = &taken.frame.counter {
            let count = counter.get(&data);
            if self.counters.insert(id, count) == Some(count) {
                return;
            }
        }
        taken.obey(now, &data);
    }

    fn poll(&mut self, now: Tick, out: &mut DeviceOutbox) {
        for taken in self.taken.iter_mut().filter(|taken| taken.missed.is_some_and(|at| at <= now)) {
            (taken.missed, taken.outputs) = (None, 0);
        }
        for sent in self.sent.iter_mut().filter(|sent| sent.due <= now) {
            send(sent, now, self.inputs, self.silent, out);
        }
    }

    fn next_deadline(&self) -> Option<Tick> {
        let missed = self.taken.iter().filter_map(|taken| taken.missed);
        self.sent.iter().map(|sent| sent.due).chain(missed).min()
    }

    /// Unplugs it, makes it boot, or lets it work again (`None`).
    fn inject(&mut self, now: Tick, fault: Option<DeviceFault>) {
        self.silent = fault == Some(DeviceFault::Silent);
        if fault == Some(DeviceFault::Reboot) {
            self.counters.clear();
            for taken in &mut self.taken {
                (taken.missed, taken.outputs) = (None, 0);
            }
        }
        for sent in &mut self.sent {
            sent.due = now;
        }
    }
}

fn send(sent: &mut SentFrame, now: Tick, inputs: u128, silent: bool, out: &mut DeviceOutbox) {
    let SentFrame { frame, count, page, due } = sent;
    let data = bytes(frame, *page, *count, inputs);
    let pages = frame.pages.len().max(1);
    *page = (*page + 1) % pages;
    *count = count.wrapping_add(1);
    let every = frame.timeout / PER_TIMEOUT / u32::try_from(pages).unwrap_or(1);
    *due = now + every.max(Duration::from_millis(1));
    if !silent {
        out.frames.extend(Frame::of_id(frame.id, &data[..usize::from(frame.len.min(8))]));
    }
}

fn bytes(frame: &ReceivedFrameBinding, page: usize, count: u64, inputs: u128) -> [u8; 8] {
    let mut data = [0; 8];
    if let Some(page) = frame.pages.get(page) {
        if let Some((selector, values)) = &page.selected {
            selector.put(&mut data, values.first().map_or(0, |(first, _)| *first));
        }
        show(page, inputs, &mut data);
    }
    // Fields of every page are on this one too.
    for page in frame.pages.iter().filter(|page| page.selected.is_none()) {
        show(page, inputs, &mut data);
    }
    if let Some(counter) = &frame.counter {
        counter.put(&mut data, count);
    }
    if let Some((at, checksum)) = frame.checksum {
        data[usize::from(at.min(7))] = checksum.of(&data, frame.len, at);
    }
    data
}

/// Gives each signal of a page a value with which the inputs that follow it are what they are to be; where there is none,
/// at least one within its limits, so that the message is not taken for a broken one.
fn show(page: &Page, inputs: u128, data: &mut [u8; 8]) {
    for (_, field, _) in &page.inputs {
        let of_field = || page.inputs.iter().filter(|(_, other, _)| other == field);
        let suits = |bits: &u64| {
            of_field().all(|(input, field, when)| {
                let on = inputs & input.bit() != 0;
                when.holds(field, *bits, true) == on && when.holds(field, *bits, false) == on
            })
        };
        // Bits first, as they are to be; then every value at which something changes, and its neighbours.
        let wired = of_field().fold(0, |bits, (input, _, when)| match when {
            When::Bit(at) if inputs & input.bit() != 0 => bits | 1u64.checked_shl((*at).into()).unwrap_or(0),
            _ => bits,
        });
        let edges = of_field().flat_map(|(_, field, when)| edges(field, *when));
        let limits = || page.limits.iter().filter(|(other, ..)| other == field);
        let ends = limits().flat_map(|(_, least, most)| [*least, *most]).filter_map(|end| field.bits(end));
        let is_value = |bits: &u64| limits().all(|(_, least, most)| (*least..=*most).contains(&field.value(*bits)));
        let candidates: Vec<u64> = [wired, 0, 1].into_iter().chain(edges).chain(ends).filter(is_value).collect();
        if let Some(bits) = candidates.iter().find(|bits| suits(bits)).or(candidates.first()) {
            field.put(data, *bits);
        }
    }
}

fn edges(field: &FrameField, when: When) -> Vec<u64> {
    let values = match when {
        When::NotZero => vec![0.0],
        When::Equals(value) => vec![value],
        When::Bit(_) => Vec::new(),
        When::Above { at, hysteresis } => vec![at, at - hysteresis],
        When::Below { at, hysteresis } => vec![at, at + hysteresis],
    };
    let step = field.factor.abs();
    let around = values.into_iter().flat_map(|value| [value, value + step, value - step]);
    around.filter_map(|value| field.bits(value)).collect()
}

impl ReceivedFrame {
    /// Whether a frame is this message, in this form.
    fn is(&self, len: usize, data: &[u8; 8]) -> bool {
        let frame = &self.frame;
        // Another page of the same message has other bits where this one's never change.
        let mut fixed = *data;
        for (_, field, _) in &frame.outputs {
            field.put(&mut fixed, field.get(&frame.rest));
        }
        if let Some(counter) = &frame.counter {
            counter.put(&mut fixed, counter.get(&frame.rest));
        }
        if let Some((at, checksum)) = frame.checksum {
            let at = usize::from(at.min(7));
            if data[at] != checksum.of(data, frame.len, at as u8) {
                return false;
            }
            fixed[at] = frame.rest[at];
        }
        len >= usize::from(frame.len) && fixed == frame.rest
    }

    fn obey(&mut self, now: Tick, data: &[u8; 8]) {
        self.missed = Some(now + self.frame.lets_go_after.unwrap_or(self.frame.every * PERIODS));
        let on = self.frame.outputs.iter().filter(|(_, field, on)| field.get(data) == *on);
        self.outputs = on.fold(0, |outputs, (output, _, _)| outputs | output.bit());
    }
}
