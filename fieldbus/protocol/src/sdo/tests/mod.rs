//! A client and a server face to face, over a channel that a test may disturb.

mod client;
mod lossy;
mod pairs;
mod server;
mod wire;

use std::borrow::Cow;
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use linewright_line::Tick;

use super::wire::SdoBytes;
use super::*;

const NAME: ObjectId = ObjectId::new(0x1008, 0);
const OTHER: ObjectId = ObjectId::new(0x2000, 1);

/// A frame from its first bytes in hexadecimal; the rest is 0.
fn raw(text: &str) -> SdoBytes {
    let mut raw = [0; 8];
    for (at, byte) in raw.iter_mut().enumerate().take(text.len() / 2) {
        *byte = u8::from_str_radix(&text[2 * at..2 * at + 2], 16).unwrap();
    }
    raw
}

/// A frame as its bytes in hexadecimal, zeros at the end left away.
fn text(raw: &SdoBytes) -> String {
    let len = raw.iter().rposition(|byte| *byte != 0).map_or(1, |at| at + 1);
    raw[..len].iter().map(|byte| format!("{byte:02X}")).collect()
}

/// A dictionary of strings of bytes.
#[derive(Default)]
struct ByteDictionary {
    objects: BTreeMap<ObjectId, Vec<u8>>,
    writes: usize,
}

impl ByteDictionary {
    fn with(object: ObjectId, data: &[u8]) -> Self {
        ByteDictionary { objects: BTreeMap::from([(object, data.to_vec())]), writes: 0 }
    }
}

impl Dictionary for ByteDictionary {
    fn read(&mut self, object: ObjectId) -> Result<Cow<'_, [u8]>, Abort> {
        self.objects.get(&object).map(|data| Cow::Borrowed(&**data)).ok_or(Abort::NO_OBJECT)
    }

    fn write(&mut self, object: ObjectId, data: &[u8]) -> Result<(), Abort> {
        self.may_write(object, Some(data.len()))?;
        self.objects.insert(object, data.to_vec());
        self.writes += 1;
        Ok(())
    }

    fn may_write(&mut self, object: ObjectId, _len: Option<usize>) -> Result<(), Abort> {
        match object.index {
            0x1008 => Err(Abort::READ_ONLY),
            0x2000..=0x2FFF => Ok(()),
            _ => Err(Abort::NO_OBJECT),
        }
    }
}

/// Fate of a frame in the channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    Arrives,
    Lost,
    Twice,
    /// After the next one in the same direction.
    Late,
}

/// One direction of the channel.
#[derive(Default)]
struct ChannelDirection {
    queue: VecDeque<SdoBytes>,
    held: Option<SdoBytes>,
}

impl ChannelDirection {
    fn push(&mut self, raw: SdoBytes, fate: Fate) {
        let held = self.held.take();
        match fate {
            Fate::Arrives => self.queue.push_back(raw),
            Fate::Lost => {}
            Fate::Twice => self.queue.extend([raw, raw]),
            Fate::Late => self.held = Some(raw),
        }
        self.queue.extend(held);
    }

    /// A frame that nothing follows arrives when nothing else happens.
    fn release(&mut self) {
        self.queue.extend(self.held.take());
    }
}

struct ClientServerPair {
    client: SdoClient,
    server: SdoServer,
    store: ByteDictionary,
    now: Tick,
    /// Requests and answers in order, as text; answers are indented.
    log: Vec<String>,
}

impl ClientServerPair {
    fn new(client: SdoClient, store: ByteDictionary) -> Self {
        ClientServerPair { client, server: SdoServer::new(4096), store, now: Tick::from_millis(5), log: Vec::new() }
    }

    /// Runs the transfer to its end on an undisturbed channel.
    fn run(&mut self) -> Result<Vec<u8>, TransferError> {
        self.run_with(|_| Fate::Arrives)
    }

    /// Runs the transfer to its end; `fate` is called for every frame sent. Panics if there is no end.
    fn run_with(&mut self, mut fate: impl FnMut(&SdoBytes) -> Fate) -> Result<Vec<u8>, TransferError> {
        let (mut up, mut down) = (ChannelDirection::default(), ChannelDirection::default());
        let mut out = Vec::new();
        let mut result = None;
        self.client.start(self.now, &mut out);
        for _ in 0..100_000 {
            for raw in out.drain(..) {
                self.log.push(text(&raw));
                up.push(raw, fate(&raw));
            }
            let mut answers = Vec::new();
            let mut progress = TransferProgress::Busy;
            if let Some(raw) = up.queue.pop_front() {
                self.server.handle(self.now, &raw, &mut self.store, &mut answers);
            } else if let Some(raw) = down.queue.pop_front() {
                progress = self.client.handle(self.now, &raw, &mut out);
            } else if up.held.is_some() || down.held.is_some() {
                up.release();
                down.release();
            } else {
                let Some(due) = self.client.next_deadline().into_iter().chain(self.server.next_deadline()).min() else {
                    return result.expect("the client has ended");
                };
                assert!(due >= self.now, "nothing is overdue");
                self.now = due;
                progress = self.client.poll(self.now, &mut out);
                self.server.poll(self.now, &mut answers);
            }
            for raw in answers {
                self.log.push(format!("  {}", text(&raw)));
                down.push(raw, fate(&raw));
            }
            if let TransferProgress::Done(ended) = progress {
                assert_eq!(result.replace(ended), None, "it ends once");
            }
        }
        panic!("no end: {:?}", &self.log[self.log.len() - 20..]);
    }
}

fn options(mode: TransferMode) -> TransferOptions {
    TransferOptions { mode, ..TransferOptions::default() }
}

/// Bytes that depend on their position.
fn pattern(len: usize) -> Vec<u8> {
    (0..len).map(|at| (at * 7 + at / 251) as u8).collect()
}

fn after(now: Tick, millis: u64) -> Tick {
    now + Duration::from_millis(millis)
}
