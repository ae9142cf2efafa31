//! The parameters of a device's PDOs: when they are sent or taken, and what they carry (CiA 301 §7.5.2.35 ff.).
//!
//! The mapping is fixed: the first PDO of the inputs carries all of 6000h, that of the outputs all of 6200h, byte by
//! byte; the others four channels of 6401h and 6411h each, which go by event alone. A
//! manager may still go through the motions of configuring it (disable, clear, write, count, enable): values that are
//! those anyway are taken, others refused.

use std::time::Duration;

use linewright_canopen::codec::{Abort, NodeId};
use linewright_canopen::sdo::ObjectId;

use super::bytes::exactly;

/// In a COB-ID entry: the PDO does not exist.
const INVALID: u32 = 1 << 31;
/// In a COB-ID entry of a TPDO: it may not be requested by a remote frame. Nothing here answers one anyway.
const NO_RTR: u32 = 1 << 30;
/// Sent or taken by event, as the device profile has it; the default (CiA 401).
const BY_EVENT: u8 = 255;

/// Event timer of the inputs (1800h sub 5): they are sent this often when nothing changes, so that a frame lost on the
/// way is made good.
const EVENT_TIMER: Duration = Duration::from_millis(100);

#[derive(Debug)]
pub(super) struct Pdo {
    /// Index of its communication parameters: 1400h or 1800h. Its mapping is 200h above.
    index: u16,
    /// Index of the objects mapped.
    mapped_index: u16,
    cob_id: u32,
    transmission: u8,
    event_timer: Duration,
    /// The subindex before the first one mapped.
    before: u8,
    /// Bits of each.
    width: u8,
    /// Number of subindices there are to map.
    entries: u8,
    /// Number of those mapped: all or none.
    mapped: u8,
    /// SYNCs since it was last sent.
    syncs: u8,
}

impl Pdo {
    /// The process data object of the inputs (TPDO1).
    pub(super) fn of_inputs(node: NodeId, inputs: usize) -> Self {
        Pdo::new(0x1800, 0x6000, 0x180 + u32::from(node.get()), inputs.div_ceil(8) as u8)
    }

    /// The process data object of the outputs (RPDO1).
    pub(super) fn of_outputs(node: NodeId, outputs: usize) -> Self {
        Pdo::new(0x1400, 0x6200, 0x200 + u32::from(node.get()), outputs.div_ceil(8) as u8)
    }

    /// The `nth` of those that carry four of `channels` channels each: TPDO2 and on, or RPDO2 and on.
    pub(super) fn of_channels(node: NodeId, sends: bool, nth: u8, channels: u8) -> Self {
        let entries = channels.saturating_sub(4 * nth).min(4);
        let (index, mapped, cob_id) = if sends { (0x1801, 0x6401, 0x280) } else { (0x1401, 0x6411, 0x300) };
        let cob_id = cob_id + 0x100 * u32::from(nth) + u32::from(node.get());
        Pdo { before: 4 * nth, width: 16, ..Pdo::new(index + u16::from(nth), mapped, cob_id, entries) }
    }

    fn new(index: u16, mapped_index: u16, cob_id: u32, entries: u8) -> Self {
        let (transmission, event_timer) = (BY_EVENT, EVENT_TIMER);
        let (before, width, mapped, syncs) = (0, 8, entries, 0);
        Pdo { index, mapped_index, cob_id, transmission, event_timer, before, width, entries, mapped, syncs }
    }

    /// Its bytes.
    pub(super) fn len(&self) -> usize {
        usize::from(self.entries) * usize::from(self.width) / 8
    }

    /// Whether it exists and carries anything.
    pub(super) fn is_active(&self) -> bool {
        self.cob_id & INVALID == 0 && self.mapped > 0
    }

    /// Whether it is sent on a change, or taken at once.
    pub(super) fn by_event(&self) -> bool {
        self.transmission >= 254
    }

    /// Period at which it is sent when nothing changes.
    pub(super) fn event_timer(&self) -> Option<Duration> {
        (self.by_event() && !self.event_timer.is_zero()).then_some(self.event_timer)
    }

    /// Takes a SYNC; whether it is to be sent. `changed`: whether there is anything new.
    pub(super) fn sync(&mut self, changed: bool) -> bool {
        self.syncs = self.syncs.saturating_add(1);
        let due = match self.transmission {
            0 => changed,
            every @ 1..=240 => self.syncs >= every,
            _ => false,
        };
        if due {
            self.syncs = 0;
        }
        due
    }

    /// The bytes of an object; `None` for any other.
    pub(super) fn read(&self, object: ObjectId) -> Option<Result<Vec<u8>, Abort>> {
        let sends = self.index >= 0x1800;
        let (communication, mapping) = (object.index == self.index, object.index == self.index + 0x200);
        if !communication && !mapping {
            return None;
        }
        Some(match object.sub {
            _ if self.entries == 0 => Err(Abort::NO_OBJECT),
            0 if communication => Ok(vec![if sends { 5 } else { 2 }]),
            1 if communication => Ok(self.cob_id.to_le_bytes().into()),
            2 if communication => Ok(vec![self.transmission]),
            5 if communication && sends => Ok((self.event_timer.as_millis() as u16).to_le_bytes().into()),
            0 if mapping => Ok(vec![self.mapped]),
            sub if mapping && sub <= self.entries => Ok(self.mapping(sub).to_le_bytes().into()),
            _ => Err(Abort::NO_SUBINDEX),
        })
    }

    /// Gives an object these bytes; `None` for what cannot be written here.
    pub(super) fn write(&mut self, object: ObjectId, data: &[u8]) -> Option<Result<(), Abort>> {
        if !matches!(self.read(object), Some(Ok(_))) {
            return None;
        }
        match (object.index == self.index, object.sub) {
            (true, 1) => Some(exactly(data).and_then(|bytes| self.write_cob_id(u32::from_le_bytes(bytes)))),
            (true, 2) => Some(exactly(data).and_then(|[code]| self.write_transmission(code))),
            (true, 5) => Some(exactly(data).map(|bytes| {
                self.event_timer = Duration::from_millis(u16::from_le_bytes(bytes).into());
            })),
            (true, _) => None,
            (false, sub) => Some(self.write_mapping(sub, data)),
        }
    }

    fn write_cob_id(&mut self, cob_id: u32) -> Result<(), Abort> {
        if (cob_id ^ self.cob_id) & !(INVALID | NO_RTR) != 0 {
            return Err(Abort::VALUE);
        }
        self.cob_id = cob_id;
        Ok(())
    }

    fn write_transmission(&mut self, code: u8) -> Result<(), Abort> {
        // 241 to 251 are reserved, 252 and 253 are answers to remote requests.
        let channels = self.width == 16;
        if (241..=253).contains(&code) || channels && code <= 240 {
            return Err(Abort::VALUE);
        }
        self.transmission = code;
        self.syncs = 0;
        Ok(())
    }

    fn write_mapping(&mut self, sub: u8, data: &[u8]) -> Result<(), Abort> {
        // A PDO that exists is not changed under way (CiA 301 §7.5.2.36).
        if self.cob_id & INVALID == 0 {
            return Err(Abort::ACCESS);
        }
        if sub == 0 {
            let [count] = exactly(data)?;
            match count {
                0 => self.mapped = 0,
                count if count == self.entries => self.mapped = count,
                count if count > 8 => return Err(Abort::PDO_LENGTH),
                _ => return Err(Abort::VALUE),
            }
            return Ok(());
        }
        let asked = u32::from_le_bytes(exactly(data)?);
        match self.mapped {
            0 if asked == self.mapping(sub) => Ok(()),
            0 => Err(Abort::NOT_MAPPABLE),
            _ => Err(Abort::ACCESS),
        }
    }

    /// The entry a mapping has at a subindex: index, subindex, and a length in bits.
    fn mapping(&self, sub: u8) -> u32 {
        u32::from(self.mapped_index) << 16 | u32::from(self.before + sub) << 8 | u32::from(self.width)
    }
}
