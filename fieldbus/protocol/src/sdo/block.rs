//! Block transfer, the same in both directions: one side sends up to 127 segments and waits, the other acknowledges how
//! far they came in order (CiA 301 §7.2.4.3.9 to §7.2.4.3.17).
//!
//! The sender repeats what was lost; the checksum at the end catches what sequence numbers cannot, such as an
//! acknowledgement that came twice. A receiver that gets nothing within a block acknowledges how far it got, because
//! the frame lost may have been the one that ends the block.

use std::time::Duration;

use super::cause::TransferFailure;
use super::wire::{BlockAck, BlockSegment, SdoBytes};

/// Segments in a block at most (CiA 301 §7.2.4.3.9).
pub(super) const BLOCK_MAX: u8 = 127;
/// Most acknowledgements in a row without progress before the transfer is given up.
const STALLS_MAX: u8 = 3;
/// Wait of a receiver within a block before it acknowledges how far it got. Longer than any sender pauses within one,
/// shorter than senders wait for an acknowledgement.
pub(super) const STALL: Duration = Duration::from_millis(250);
/// The pause between two bursts of segments.
pub(super) const PACE: Duration = Duration::from_millis(1);
/// Segments in a burst: what 500 kbit/s carry in [`PACE`], so that a short transmit queue of an interface suffices.
pub(super) const BURST: u8 = 4;

/// The checksum of a block transfer (CiA 301 §7.2.4.3.16): polynomial 1021h, initial value 0.
pub(super) fn crc(data: &[u8]) -> u16 {
    data.iter().fold(0, |crc: u16, byte| {
        (0..8).fold(crc ^ u16::from(*byte) << 8, |crc, _| crc << 1 ^ if crc & 0x8000 != 0 { 0x1021 } else { 0 })
    })
}

/// Unused bytes of the last segment, for that many bytes in all.
pub(super) fn unused(len: usize) -> u8 {
    if len == 0 { 7 } else { ((7 - len % 7) % 7) as u8 }
}

/// Progress of the sending side of a block transfer. The bytes themselves are their owner's.
#[derive(Debug)]
pub(super) struct BlockSender {
    /// Bytes the receiver has in order.
    acked: usize,
    /// Segments sent of the present block.
    sent: u8,
    /// Segments in the present block.
    size: u8,
    stalls: u8,
}

impl BlockSender {
    pub(super) fn new(size: u8) -> Result<Self, TransferFailure> {
        if !(1..=BLOCK_MAX).contains(&size) {
            return Err(TransferFailure::BlockSize { size });
        }
        Ok(BlockSender { acked: 0, sent: 0, size, stalls: 0 })
    }

    /// Bytes the receiver has.
    pub(super) fn acked(&self) -> usize {
        self.acked
    }

    /// Whether it waits for the receiver: the present block is sent, as far as there is data for it.
    pub(super) fn waits(&self, data: &[u8]) -> bool {
        self.sent == self.size || (self.sent > 0 && self.next() >= data.len())
    }

    /// Offset of the next segment.
    fn next(&self) -> usize {
        self.acked + usize::from(self.sent) * 7
    }

    /// Sends up to `burst` segments of the present block.
    pub(super) fn send(&mut self, data: &[u8], burst: u8, out: &mut Vec<SdoBytes>) {
        for _ in 0..burst {
            if self.waits(data) {
                return;
            }
            let rest = data.get(self.next()..).unwrap_or(&[]);
            let len = rest.len().min(7);
            let mut bytes = [0; 7];
            bytes[..len].copy_from_slice(&rest[..len]);
            self.sent += 1;
            out.push(BlockSegment { number: self.sent, last: rest.len() <= 7, bytes }.encode());
        }
    }

    /// Takes the receiver's acknowledgement; whether all of `data` has arrived.
    pub(super) fn acknowledged(&mut self, ack: BlockAck, data: &[u8]) -> Result<bool, TransferFailure> {
        if ack.good > self.sent {
            return Err(TransferFailure::Sequence { number: ack.good });
        }
        let all = ack.good > 0 && self.acked + usize::from(ack.good) * 7 >= data.len();
        if all {
            self.acked = data.len();
            return Ok(true);
        }
        if !(1..=BLOCK_MAX).contains(&ack.next) {
            return Err(TransferFailure::BlockSize { size: ack.next });
        }
        self.stalls = if ack.good == 0 { self.stalls + 1 } else { 0 };
        if self.stalls > STALLS_MAX {
            return Err(TransferFailure::Sequence { number: ack.good });
        }
        self.acked += usize::from(ack.good) * 7;
        self.sent = 0;
        self.size = ack.next;
        Ok(false)
    }
}

/// The receiving side of a block transfer.
#[derive(Debug)]
pub(super) struct BlockReceiver {
    data: Vec<u8>,
    size: Option<u32>,
    len_max: usize,
    /// The last segment of the present block that came in order.
    good: u8,
    /// Whether the last segment of the transfer has come in order.
    complete: bool,
    stalls: u8,
}

impl BlockReceiver {
    pub(super) fn new(size: Option<u32>, len_max: usize) -> Self {
        BlockReceiver { data: reserve(size, len_max), size, len_max, good: 0, complete: false, stalls: 0 }
    }

    /// Bytes received in order, those of the last segment that do not count included.
    pub(super) fn len(&self) -> usize {
        self.data.len()
    }

    /// Whether every segment has come; the end frame is next.
    pub(super) fn complete(&self) -> bool {
        self.complete
    }

    /// Takes a segment; whether the sender waits for an acknowledgement after it.
    pub(super) fn take(&mut self, segment: &BlockSegment) -> Result<bool, TransferFailure> {
        // Anything else is of a block whose beginning was lost, or came twice: the acknowledgement sorts it out.
        if segment.number == self.good + 1 {
            let most = self.size.map_or(self.len_max, |size| self.len_max.min(size as usize));
            // Up to seven bytes of the last segment may not count.
            if self.data.len() >= most.max(1) {
                return Err(too_long(self.size, self.len_max));
            }
            self.data.extend_from_slice(&segment.bytes);
            self.good = segment.number;
            self.complete = segment.last;
        }
        Ok(segment.last || segment.number == BLOCK_MAX)
    }

    /// Ends the present block; `None` if there was no progress for too long.
    pub(super) fn acknowledge(&mut self) -> Option<BlockAck> {
        let good = std::mem::take(&mut self.good);
        self.stalls = if good == 0 { self.stalls + 1 } else { 0 };
        (self.stalls <= STALLS_MAX).then_some(BlockAck { good, next: BLOCK_MAX })
    }

    /// The bytes, if they are what the sender meant. `crc` is `None` where the sender computes none.
    pub(super) fn finish(&mut self, unused: u8, crc: Option<u16>) -> Result<Vec<u8>, TransferFailure> {
        let mut data = std::mem::take(&mut self.data);
        data.truncate(data.len().saturating_sub(unused.into()));
        check_size(self.size, data.len())?;
        if data.len() > self.len_max {
            return Err(too_long(self.size, self.len_max));
        }
        match crc {
            Some(sent) if sent != self::crc(&data) => Err(TransferFailure::Crc { sent, computed: self::crc(&data) }),
            _ => Ok(data),
        }
    }
}

/// Room for what was announced, but no more than a page before anything has come: the announcement may be false.
pub(super) fn reserve(size: Option<u32>, len_max: usize) -> Vec<u8> {
    Vec::with_capacity(size.map_or(0, |size| size as usize + 7).min(len_max).min(4096))
}

/// Checks that the length that came is the announced one.
pub(super) fn check_size(size: Option<u32>, came: usize) -> Result<(), TransferFailure> {
    match size {
        Some(announced) if announced as usize != came => Err(TransferFailure::Length { announced, came }),
        _ => Ok(()),
    }
}

/// More came than was announced, or than there is room for.
pub(super) fn too_long(size: Option<u32>, len_max: usize) -> TransferFailure {
    match size {
        Some(announced) if announced as usize <= len_max => {
            TransferFailure::Length { announced, came: announced as usize + 1 }
        }
        _ => TransferFailure::TooLong { len_max },
    }
}
