//! The last order to a device: outputs off, written to the socket without waiting for anything.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use linewright_modbus::ModbusRequest;

/// The transaction of a last order: one that the connection itself reaches after an hour at the earliest, and which
/// identifies the answer.
const TRANSACTION: u16 = 0xFFFF;
/// Number and distance of the checks for answers to last orders: a tenth of a second in all.
const TRIES: u32 = 100;
const PAUSE: Duration = Duration::from_millis(1);
/// So many pieces of what has come are read at a time: a device that never stops sending holds up no other.
const PIECES: usize = 16;
/// After so many of these pauses an order that was refused is sent again.
const AGAIN: u32 = 10;

/// Last order to a device, for when nothing else can be done.
#[derive(Clone)]
pub struct LastOrder {
    /// The device, in words.
    device: Arc<str>,
    order: Arc<Vec<u8>>,
    socket: Arc<Mutex<Option<TcpStream>>>,
}

impl LastOrder {
    /// For the device at this address and unit, whose outputs this request turns off.
    pub fn new((address, unit): (&str, u8), request: Option<ModbusRequest>) -> Self {
        let order = request.map(|request| request.adu(TRANSACTION, unit)).unwrap_or_default();
        let device = format!("{address} unit {unit}").into();
        LastOrder { device, order: Arc::new(order), socket: Arc::default() }
    }

    /// Its connection is this one, which does not block.
    pub fn set(&self, socket: TcpStream) {
        if let Ok(mut own) = self.socket.lock() {
            *own = Some(socket);
        }
    }

    pub fn forget(&self) {
        if let Ok(mut own) = self.socket.lock() {
            *own = None;
        }
    }

    /// Sends the order; true if the connection has taken it whole.
    pub fn send(&self) -> bool {
        let Ok(own) = self.socket.try_lock() else { return false };
        let Some(mut socket) = own.as_ref().filter(|_| !self.order.is_empty()) else { return false };
        matches!(socket.write(&self.order), Ok(written) if written == self.order.len())
    }

    /// Reads from the socket: the fate of the order, if that is decided.
    fn look(&self, received: &mut Vec<u8>) -> Option<LastOutcome> {
        let Ok(own) = self.socket.try_lock() else { return Some(LastOutcome::Gone) };
        let Some(mut socket) = own.as_ref() else { return Some(LastOutcome::Gone) };
        let mut bytes = [0; 64];
        for _ in 0..PIECES {
            match socket.read(&mut bytes) {
                Ok(0) => return Some(answer(&self.order, received).unwrap_or(LastOutcome::Gone)),
                Ok(read) => received.extend(&bytes[..read]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(_) => return Some(LastOutcome::Gone),
            }
        }
        answer(&self.order, received)
    }

    /// Logs an outcome after which outputs may be on.
    fn log(&self, outcome: LastOutcome) {
        if let Some(text) = outcome.text(&self.device) {
            tracing::error!("{text}");
        }
    }

    /// Whether it has a connection, and an order for it.
    fn is_connected(&self) -> bool {
        !self.order.is_empty() && self.socket.lock().is_ok_and(|own| own.is_some())
    }
}

/// Outcome of a last order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LastOutcome {
    Taken,
    /// The connection has not taken the order.
    Unsent,
    /// Refused with this exception code.
    Refused(u8),
    /// The connection has ended.
    Gone,
    /// Not answered in time.
    Unanswered,
}

/// The answer to an order among the bytes that have come; an answer to an earlier request may come first.
fn answer(order: &[u8], received: &[u8]) -> Option<LastOutcome> {
    let [high, low] = TRANSACTION.to_be_bytes();
    let function = *order.get(7)?;
    // MBAP header (transaction, protocol, length, unit), function, and of an exception its code (§7).
    received.windows(9).find_map(|part| match *part {
        [a, b, 0, 0, 0, 6, _, of, _] if (a, b, of) == (high, low, function) => Some(LastOutcome::Taken),
        [a, b, 0, 0, 0, 3, _, of, code] if (a, b, of) == (high, low, function | 0x80) => {
            Some(LastOutcome::Refused(code))
        }
        _ => None,
    })
}

/// Sends all last orders, and waits until they are taken, for a tenth of a second at most; what is refused is sent again
/// meanwhile. A socket that is closed with an unread answer resets the connection, and the device may never read the order.
pub fn send_all(lasts: &[LastOrder]) -> Vec<LastOutcome> {
    // A device without a connection was reported when it was lost; its own watchdog turns its outputs off.
    let (sent, unsent): (Vec<_>, Vec<_>) =
        lasts.iter().filter(|last| last.is_connected()).partition(|last| last.send());
    for last in unsent {
        last.log(LastOutcome::Unsent);
    }
    let outcomes = wait_for(&sent);
    for (last, outcome) in sent.iter().zip(&outcomes) {
        last.log(*outcome);
    }
    outcomes
}

fn wait_for(lasts: &[&LastOrder]) -> Vec<LastOutcome> {
    let mut received = vec![Vec::new(); lasts.len()];
    let mut outcomes = vec![LastOutcome::Unanswered; lasts.len()];
    for nth in 1..=TRIES {
        for ((last, received), outcome) in lasts.iter().zip(&mut received).zip(&mut outcomes) {
            if matches!(outcome, LastOutcome::Taken | LastOutcome::Gone) {
                continue;
            }
            if let Some(come) = last.look(received) {
                *outcome = come;
                received.clear();
            }
            if matches!(outcome, LastOutcome::Refused(_)) && nth % AGAIN == 0 {
                last.send();
            }
        }
        if outcomes.iter().all(|outcome| matches!(outcome, LastOutcome::Taken | LastOutcome::Gone)) {
            break;
        }
        std::thread::sleep(PAUSE);
    }
    outcomes
}
