//! The last order to a device: outputs off, written to the socket without waiting for anything.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use linewright_modbus::ModbusRequest;

/// The transaction of a last order: one that the connection itself reaches after an hour at the earliest, and by which the
/// answer is known.
const TRANSACTION: u16 = 0xFFFF;
/// How often, and how far apart, it is looked whether last orders are answered: a tenth of a second in all.
const TRIES: u32 = 100;
const PAUSE: Duration = Duration::from_millis(1);

/// What is left to do for a device when nothing else can be done.
#[derive(Clone)]
pub struct LastOrder {
    order: Arc<Vec<u8>>,
    socket: Arc<Mutex<Option<TcpStream>>>,
}

impl LastOrder {
    /// For a device with this unit, whose outputs this request turns off.
    pub fn new(unit: u8, request: Option<ModbusRequest>) -> Self {
        let order = request.map(|request| request.adu(TRANSACTION, unit)).unwrap_or_default();
        LastOrder { order: Arc::new(order), socket: Arc::default() }
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

    /// Reads what has come; true when the order is answered, or nothing will come any more.
    fn is_answered(&self, heard: &mut Vec<u8>) -> bool {
        let Ok(own) = self.socket.try_lock() else { return true };
        let Some(mut socket) = own.as_ref() else { return true };
        let mut bytes = [0; 64];
        loop {
            match socket.read(&mut bytes) {
                Ok(0) => return true,
                Ok(read) => heard.extend(&bytes[..read]),
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(_) => return true,
            }
        }
        // Transaction and protocol of the answer; an answer to what was asked before may come first.
        let [high, low] = TRANSACTION.to_be_bytes();
        heard.windows(4).any(|part| part == [high, low, 0, 0])
    }
}

/// Sends all last orders, and waits until they are answered, for a tenth of a second at most. A socket that is closed with an
/// unread answer resets the connection, and the device may never read the order.
pub fn send_all(lasts: &[LastOrder]) {
    let sent: Vec<&LastOrder> = lasts.iter().filter(|last| last.send()).collect();
    wait_for(&sent);
}

fn wait_for(lasts: &[&LastOrder]) {
    let mut heard = vec![Vec::new(); lasts.len()];
    for _ in 0..TRIES {
        let answered = lasts.iter().zip(&mut heard).map(|(last, heard)| last.is_answered(heard));
        // Each is looked at, whatever the others say.
        let answered = answered.filter(|is_answered| *is_answered).count();
        if answered == lasts.len() {
            return;
        }
        std::thread::sleep(PAUSE);
    }
    tracing::warn!("a Modbus device has not answered the order to let go");
}
