//! Any dialogue on an SDO channel: frames are passed on, lost, doubled, changed and made up, at any moment and on both
//! sides. No panic, bounded answers, an end; what a client reads through losses alone is what the server has; and an
//! object is written only with bytes that a whole and proper transfer carried.

#![cfg_attr(feature = "engine", no_main)]

use std::borrow::Cow;
use std::collections::VecDeque;
use std::time::Duration;

use libfuzzer_sys::fuzz_target;
use linewright_canopen::sdo::wire::{ClientFrame, InitiateContent, SdoBytes};
use linewright_canopen::sdo::{
    Abort, Dictionary, ObjectId, SdoClient, SdoServer, TransferMode, TransferOptions, TransferProgress,
};
use linewright_line::Tick;

const LEN_MAX: usize = 1024;
/// Longer than any answer to one frame: a burst of segments, an abort and a new question.
const ANSWERS_MAX: usize = 8;

/// One object, and the frames that the server has received since its last write.
struct Store {
    object: ObjectId,
    data: Vec<u8>,
    heard: Vec<SdoBytes>,
}

impl Dictionary for Store {
    fn read(&mut self, object: ObjectId) -> Result<Cow<'_, [u8]>, Abort> {
        if object == self.object { Ok(Cow::Borrowed(&self.data)) } else { Err(Abort::NO_OBJECT) }
    }

    fn write(&mut self, object: ObjectId, data: &[u8]) -> Result<(), Abort> {
        assert!(data.len() <= LEN_MAX);
        assert!(justified(&self.heard, object, data, &self.data), "{object} = {data:02X?} after {:02X?}", self.heard);
        if object != self.object {
            return Err(Abort::NO_OBJECT);
        }
        self.data = data.to_vec();
        Ok(())
    }
}

/// Whether the frames end in a transfer of these bytes to this object. Judged by the frames alone and backwards, unlike
/// in the server.
fn justified(heard: &[SdoBytes], object: ObjectId, data: &[u8], before: &[u8]) -> bool {
    let Some((last, earlier)) = heard.split_last() else { return false };
    match ClientFrame::decode(last) {
        Some(ClientFrame::Download { object: asked, content: InitiateContent::Expedited { bytes, len, sized } }) => {
            asked == object && (bytes[..usize::from(len)] == *data || (!sized && bytes[..before.len().min(4)] == *data))
        }
        Some(ClientFrame::DownloadSegment(_)) => segments(heard, object, data),
        Some(ClientFrame::BlockDownloadEnd { unused, crc }) => blocks(earlier, object, data, unused, crc),
        _ => false,
    }
}

/// The last frames are an announcement and nothing but its segments.
fn segments(heard: &[SdoBytes], object: ObjectId, data: &[u8]) -> bool {
    let mut chunks: VecDeque<(bool, Vec<u8>)> = VecDeque::new();
    for raw in heard.iter().rev() {
        match ClientFrame::decode(raw) {
            Some(ClientFrame::DownloadSegment(segment)) => {
                chunks.push_front((segment.toggle, segment.bytes().to_vec()));
            }
            Some(ClientFrame::Download { object: asked, content: InitiateContent::Segmented { size } }) => {
                let alternate = chunks.iter().enumerate().all(|(at, (toggle, _))| *toggle == (at % 2 == 1));
                let all: Vec<u8> = chunks.into_iter().flat_map(|(_, bytes)| bytes).collect();
                return asked == object
                    && alternate
                    && all == data
                    && size.is_none_or(|size| size as usize == all.len());
            }
            _ => return false,
        }
    }
    false
}

/// Some block transfer of the object has begun, and its frames carry the bytes in this order.
fn blocks(earlier: &[SdoBytes], object: ObjectId, data: &[u8], unused: u8, crc: u16) -> bool {
    (0..earlier.len()).any(|at| {
        let Some(ClientFrame::BlockDownload { object: asked, crc: with_crc, size }) = ClientFrame::decode(&earlier[at])
        else {
            return false;
        };
        let mut frames = earlier[at + 1..].iter();
        let mut chunks = data.chunks(7).peekable();
        let mut carried = true;
        while let Some(chunk) = chunks.next() {
            let last = chunks.peek().is_none() && usize::from(unused) < 7;
            carried &= frames.any(|raw| raw[1..=chunk.len()] == *chunk && (!last || raw[0] & 0x80 != 0));
        }
        asked == object
            && carried
            && size.is_none_or(|size| size as usize == data.len())
            && (!with_crc || checksum(data) == crc)
    })
}

/// CRC-16/XMODEM by long division of the bits, unlike the product's.
fn checksum(data: &[u8]) -> u16 {
    let bits = data.iter().flat_map(|byte| (0..8).rev().map(move |bit| u32::from(byte >> bit & 1)));
    let rest = bits.chain(std::iter::repeat_n(0, 16)).fold(0u32, |rest, bit| {
        let rest = rest << 1 | bit;
        if rest & 0x1_0000 != 0 { rest ^ 0x1_1021 } else { rest }
    });
    rest as u16
}

struct SdoBench {
    client: SdoClient,
    server: SdoServer,
    store: Store,
    now: Tick,
    up: VecDeque<SdoBytes>,
    down: VecDeque<SdoBytes>,
    written: Option<Vec<u8>>,
    was: Vec<u8>,
    /// A frame is on the channel that neither side sent, or sent only once.
    tampered: bool,
    done: bool,
}

impl SdoBench {
    fn send_to_server(&mut self, raw: &SdoBytes) {
        let mut out = Vec::new();
        self.store.heard.push(*raw);
        self.server.handle(self.now, raw, &mut self.store, &mut out);
        assert!(out.len() <= ANSWERS_MAX);
        self.down.extend(out);
    }

    fn send_to_client(&mut self, raw: &SdoBytes) {
        let mut out = Vec::new();
        let progress = self.client.handle(self.now, raw, &mut out);
        self.said(progress, out);
    }

    fn poll(&mut self) {
        let mut out = Vec::new();
        self.server.poll(self.now, &mut out);
        assert!(out.len() <= ANSWERS_MAX);
        self.down.extend(out.drain(..));
        let progress = self.client.poll(self.now, &mut out);
        self.said(progress, out);
    }

    fn said(&mut self, progress: TransferProgress, out: Vec<SdoBytes>) {
        assert!(out.len() <= ANSWERS_MAX);
        self.up.extend(out);
        let TransferProgress::Done(result) = progress else { return };
        assert!(!std::mem::replace(&mut self.done, true), "it ends once");
        match (result, &self.written) {
            (Ok(read), None) => {
                assert!(read.len() <= LEN_MAX);
                assert!(self.tampered || read == self.was, "read {read:02X?} instead of {:02X?}", self.was);
            }
            (Ok(_), Some(written)) => assert!(self.tampered || self.store.data == *written),
            (Err(error), _) => assert!(!error.to_string().is_empty()),
        }
    }

    /// Nothing arrives any more: both sides end.
    fn finish(&mut self) {
        for _ in 0..2000 {
            let Some(due) = self.client.next_deadline().into_iter().chain(self.server.next_deadline()).min() else {
                assert!(self.done, "the client has neither an end nor a deadline");
                return;
            };
            self.now = self.now.max(due);
            self.poll();
        }
        panic!("no end");
    }
}

fuzz_target!(|input: &[u8]| {
    let mut input = input.iter().copied();
    let mut next = || input.next();
    let (Some(kind), Some(len), Some(more)) = (next(), next(), next()) else { return };
    let len = (usize::from(len) | usize::from(more) << 8) % LEN_MAX;
    let mode = [TransferMode::Auto, TransferMode::Segmented, TransferMode::Block][usize::from(kind >> 1) % 3];
    let options = TransferOptions { mode, len_max: LEN_MAX, ..TransferOptions::default() };
    let object = ObjectId::new(0x2000, 1);
    let pattern: Vec<u8> = (0..len).map(|at| (at * 7 + at / 251) as u8).collect();
    let writes = kind & 1 == 1;
    let was = if writes { vec![1, 2, 3] } else { pattern.clone() };
    let mut bench = SdoBench {
        client: if writes {
            SdoClient::download(object, &*pattern, options)
        } else {
            SdoClient::upload(object, options)
        },
        server: SdoServer::new(LEN_MAX),
        store: Store { object, data: was.clone(), heard: Vec::new() },
        now: Tick::from_millis(1),
        up: VecDeque::new(),
        down: VecDeque::new(),
        written: writes.then_some(pattern),
        was,
        tampered: false,
        done: false,
    };
    let mut out = Vec::new();
    bench.client.start(bench.now, &mut out);
    bench.up.extend(out);
    while let Some(op) = next() {
        // The upper bits are a number of repetitions or a duration.
        let many = usize::from(op >> 4) + 1;
        match op & 0x0F {
            // Frames arrive as they were sent.
            0..=4 => (0..many * many).for_each(|_| {
                if let Some(raw) = bench.up.pop_front() {
                    bench.send_to_server(&raw);
                } else if let Some(raw) = bench.down.pop_front() {
                    bench.send_to_client(&raw);
                } else if let Some(due) =
                    bench.client.next_deadline().into_iter().chain(bench.server.next_deadline()).min()
                    && due <= bench.now + Duration::from_millis(1)
                {
                    bench.now = bench.now.max(due);
                    bench.poll();
                }
            }),
            5 => drop(bench.up.pop_front()),
            6 => drop(bench.down.pop_front()),
            7 => {
                bench.now = bench.now + Duration::from_millis(100 * many as u64);
                bench.poll();
            }
            // One arrives twice.
            8 => {
                bench.tampered = true;
                if let Some(raw) = bench.up.front().copied() {
                    bench.send_to_server(&raw);
                }
            }
            9 => {
                bench.tampered = true;
                if let Some(raw) = bench.down.front().copied() {
                    bench.send_to_client(&raw);
                }
            }
            // One byte of one is another.
            10 | 11 => {
                bench.tampered = true;
                let queue = if op & 1 == 0 { &mut bench.up } else { &mut bench.down };
                if let (Some(raw), Some(byte)) = (queue.front_mut(), next()) {
                    raw[many % 8] = byte;
                }
            }
            // A frame of neither side.
            kind => {
                bench.tampered = true;
                let raw: SdoBytes = std::array::from_fn(|_| next().unwrap_or(0));
                if kind & 1 == 0 { bench.send_to_server(&raw) } else { bench.send_to_client(&raw) }
            }
        }
    }
    bench.finish();
});

/// Without the engine a target only links.
#[cfg(not(feature = "engine"))]
fn main() {}
