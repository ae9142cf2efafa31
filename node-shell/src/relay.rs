//! More than twelve participants on one host without multicast.
//!
//! Linux gives the loopback interface no multicast. The DDS library then announces itself to the well-known ports of
//! the first twelve participants of its own host only: participants 12 and 13 both discover the first twelve, but never
//! each other.
//!
//! An announcement is one datagram, complete in itself: it carries its sender's identity and addresses, and its
//! deliverer does not matter. So one process sits on the port of the twelfth participant — that number is then simply
//! taken — receives all announcements, and passes them on, unread, to the ports of the participants beyond. Every
//! process tries to be that one, and tries again when it has gone; the kernel lets exactly one succeed.
//!
//! Nothing but announcements comes here: all other traffic goes to addresses found inside them.

use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// Participants the library announces itself to on the loopback address.
pub(crate) const PROBED: u16 = 12;

/// Participants whose ports exist in every domain: those of domain 232 end here.
const PORTS: u16 = 63;

/// Most time until a relay whose process has gone is replaced, and until this one stops.
const RETRY: Duration = Duration::from_millis(500);

/// Largest datagram UDP can carry.
const DATAGRAM_MAX: usize = 65_535;

/// Every RTPS message starts with this.
const MAGIC: &[u8] = b"RTPS";

/// Well-known discovery port of a participant (RTPS 2.5, 9.6.2.3).
const fn port(domain_id: u16, participant: u16) -> u16 {
    7400 + 250 * domain_id + 10 + 2 * participant
}

/// A share in the relay of this host and domain. Dropping it ends this process's share.
pub(crate) struct Relay {
    stop: Arc<AtomicBool>,
}

impl Relay {
    /// Starts. Call before the participant is opened, so that the first of many processes takes the
    /// twelfth port before a participant does.
    pub(crate) fn start(domain_id: u16) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let socket = bind(domain_id);
        let stopped = Arc::clone(&stop);
        thread::Builder::new().name("discovery relay".to_owned()).spawn(move || run(domain_id, socket, &stopped))?;
        Ok(Self { stop })
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// Bound to the loopback address: nothing from outside is ever relayed.
fn bind(domain_id: u16) -> io::Result<UdpSocket> {
    let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, port(domain_id, PROBED - 1)))?;
    socket.set_read_timeout(Some(RETRY))?;
    Ok(socket)
}

fn run(domain_id: u16, mut socket: io::Result<UdpSocket>, stop: &AtomicBool) {
    let mut buffer = vec![0; DATAGRAM_MAX];
    while !stop.load(Ordering::Relaxed) {
        match &socket {
            Ok(open) => relay_one(open, &mut buffer, domain_id, PROBED..PORTS),
            Err(_) => {
                thread::sleep(RETRY);
                socket = bind(domain_id);
            }
        }
    }
}

fn relay_one(socket: &UdpSocket, buffer: &mut [u8], domain_id: u16, to: Range<u16>) {
    let (length, from) = match socket.recv_from(buffer) {
        Ok(received) => received,
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => return,
        Err(error) => {
            tracing::debug!("discovery relay: {error}");
            // Whatever it is, it must not turn into a busy loop.
            thread::sleep(RETRY);
            return;
        }
    };
    let message = &buffer[..length];
    if !message.starts_with(MAGIC) || !from.ip().is_loopback() {
        return;
    }
    for participant in to {
        let there = SocketAddr::V4(SocketAddrV4::new(Ipv4Addr::LOCALHOST, port(domain_id, participant)));
        // Most of these ports have no reader; announcements are repeated anyway.
        let _ = socket.send_to(message, there);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A domain the other tests leave alone.
    const DOMAIN: u16 = 99;

    #[test]
    fn ports_are_those_of_the_standard() {
        assert_eq!(port(0, 0), 7410);
        assert_eq!(port(1, 3), 7666);
        assert_eq!(u32::from(port(232, PORTS - 1)) + 1, 65_535, "the last user port still exists");
    }

    #[test]
    fn announcements_are_passed_on_and_nothing_else_is() {
        let relay = Relay::start(DOMAIN).expect("thread");
        let far = UdpSocket::bind((Ipv4Addr::LOCALHOST, port(DOMAIN, 20))).expect("port free");
        far.set_read_timeout(Some(Duration::from_secs(5))).expect("timeout");
        let sender = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("any port");
        for message in [&b"rubbish"[..], b"RTPS announcement"] {
            sender.send_to(message, (Ipv4Addr::LOCALHOST, port(DOMAIN, PROBED - 1))).expect("sent");
        }
        let mut buffer = [0; 64];
        let (length, _) = far.recv_from(&mut buffer).expect("relayed");
        assert_eq!(&buffer[..length], b"RTPS announcement");
        drop(relay);
    }

    #[test]
    fn a_second_relay_takes_over_from_a_dead_one() {
        let domain = DOMAIN + 1;
        let first = Relay::start(domain).expect("thread");
        let second = Relay::start(domain).expect("thread");
        drop(first);
        let far = UdpSocket::bind((Ipv4Addr::LOCALHOST, port(domain, PROBED))).expect("port free");
        far.set_read_timeout(Some(Duration::from_millis(100))).expect("timeout");
        thread::sleep(RETRY * 3);
        let sender = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).expect("any port");
        let mut buffer = [0; 64];
        let relayed = (0..50).any(|_| {
            sender.send_to(b"RTPS", (Ipv4Addr::LOCALHOST, port(domain, PROBED - 1))).expect("sent");
            far.recv_from(&mut buffer).is_ok()
        });
        assert!(relayed);
        drop(second);
    }
}
