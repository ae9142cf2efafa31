//! Keeps a participant's sockets to the loopback device.
//!
//! The DDS library binds its sockets to all addresses of the machine, also where it announces itself and sends on the loopback address only.
//! So anything that reaches one of these ports from outside would be read. A socket that is bound to a device receives what comes by that
//! device alone: the kernel drops the rest before it is read.
//!
//! The library gives no access to its sockets. A process may duplicate descriptors of its own by their number (`pidfd_getfd` on itself, Linux
//! 5.6); an option that is set on the duplicate is one of the socket. Binding to a device without privileges takes Linux 5.7. What arrives in the
//! milliseconds between the opening of a socket and that is still read.

use std::collections::HashSet;
use std::ffi::OsString;
use std::io;
use std::os::fd::OwnedFd;

use rustix::process::{PidfdFlags, PidfdGetfdFlags, getpid, pidfd_getfd, pidfd_open};
use socket2::{Domain, SockRef, Type};

const LOOPBACK: &[u8] = b"lo";

/// The descriptors of this process at one moment, by what they stand for.
pub(crate) struct OpenFiles(HashSet<OsString>);

impl OpenFiles {
    pub fn now() -> io::Result<Self> {
        Ok(OpenFiles(own_descriptors()?.into_iter().map(|(_, stands_for)| stands_for).collect()))
    }

    /// Binds the UDP sockets that have been opened since then to the loopback device; their number.
    ///
    /// A socket that another thread opens meanwhile is among them: nodes open theirs one after the other.
    pub fn confine_newer(&self) -> io::Result<usize> {
        let process = pidfd_open(getpid(), PidfdFlags::empty())?;
        let mut confined = 0;
        for (number, stands_for) in own_descriptors()? {
            if self.0.contains(&stands_for) || !stands_for.as_encoded_bytes().starts_with(b"socket:") {
                continue;
            }
            let socket: OwnedFd = match pidfd_getfd(&process, number, PidfdGetfdFlags::empty()) {
                Ok(socket) => socket,
                // Closed since it was listed.
                Err(rustix::io::Errno::BADF) => continue,
                Err(error) => return Err(error.into()),
            };
            let socket = SockRef::from(&socket);
            if is_udp(&socket)? {
                socket.bind_device(Some(LOOPBACK))?;
                confined += 1;
            }
        }
        Ok(confined)
    }
}

fn is_udp(socket: &SockRef<'_>) -> io::Result<bool> {
    Ok(matches!(socket.domain()?, Domain::IPV4 | Domain::IPV6) && socket.r#type()? == Type::DGRAM)
}

/// Numbers of the descriptors of this process, and what they stand for, as `socket:[4711]`.
fn own_descriptors() -> io::Result<Vec<(i32, OsString)>> {
    let mut descriptors = Vec::new();
    for entry in std::fs::read_dir("/proc/self/fd")? {
        let entry = entry?;
        let Some(number) = entry.file_name().to_str().and_then(|name| name.parse().ok()) else { continue };
        // One that is closed meanwhile, as that of this directory, has no target.
        if let Ok(target) = std::fs::read_link(entry.path()) {
            descriptors.push((number, target.into_os_string()));
        }
    }
    Ok(descriptors)
}

#[cfg(test)]
mod tests {
    use std::net::UdpSocket;

    use super::*;

    #[test]
    fn only_newer_udp_sockets_are_confined() {
        let older = UdpSocket::bind("0.0.0.0:0").expect("a port");
        let before = OpenFiles::now().expect("proc");
        let newer = UdpSocket::bind("0.0.0.0:0").expect("a port");
        let other = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
        // Tests beside this one may open sockets meanwhile.
        assert!(before.confine_newer().expect("Linux 5.7 and newer allow it") >= 1);
        assert_eq!(SockRef::from(&newer).device().expect("a socket").as_deref(), Some(LOOPBACK));
        assert_eq!(SockRef::from(&older).device().expect("a socket"), None);
        assert_eq!(SockRef::from(&other).device().expect("a socket"), None);
        // It still receives what is sent on this machine.
        let to = ("127.0.0.1", newer.local_addr().expect("bound").port());
        older.send_to(b"here", to).expect("sent");
        newer.set_read_timeout(Some(std::time::Duration::from_secs(5))).expect("a timeout");
        let mut buffer = [0; 8];
        assert_eq!(newer.recv(&mut buffer).expect("received"), 4);
    }
}
