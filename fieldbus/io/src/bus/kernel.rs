//! SocketCAN: the kernel's CAN interfaces.

use std::io;
use std::path::Path;
use std::time::Duration;

use embedded_can::Frame as _;
use socketcan::frame::Frame as _;
use socketcan::tokio::CanSocket;
use socketcan::{CanDataFrame, CanFrame, CanRemoteFrame, SocketOptions};

use linewright_canopen::{Frame, FrameKind};

use super::BusStats;
use crate::texts::BusWarning;

/// After a failed read, so that one that fails again and again does not take the whole processor.
const READ_PAUSE: Duration = Duration::from_millis(50);

/// In bytes, of which the kernel takes some 800 for a frame: more than a thousand frames, a quarter of a second of a full
/// bus of 500 kbit/s.
const RECEIVE_BUFFER: libc::c_int = 1 << 20;

pub(super) struct KernelBus {
    name: String,
    socket: CanSocket,
    /// The last read failed: reported once, not at every retry.
    failing: bool,
    /// The `errno` of the lost interface. The kernel reports it once, to the next call.
    gone: Option<i32>,
}

impl KernelBus {
    pub(super) fn open(name: &str) -> io::Result<Self> {
        let socket = CanSocket::open(name)?;
        // The kernel's reports about the bus come as frames; without them a bus that is off looks like a quiet one.
        socket.set_error_filter_accept_all()?;
        // A program that is held up finds what came meanwhile here, and what did not fit is lost. Not every system gives
        // more than its default, and none has to.
        let _ = socket.set_socket_option_int(libc::SOL_SOCKET, libc::SO_RCVBUF, RECEIVE_BUFFER);
        Ok(KernelBus { name: name.to_owned(), socket, failing: false, gone: None })
    }

    /// False if the interface takes nothing more at present.
    pub(super) fn send(&mut self, frame: &Frame, stats: &mut BusStats) -> bool {
        let Some(frame) = to_kernel(frame) else {
            stats.send_errors += 1;
            return true;
        };
        match self.socket.try_write_frame(frame) {
            Ok(()) => stats.sent += 1,
            // ENOBUFS: the interface's transmit queue is full.
            Err(e) if e.kind() == io::ErrorKind::WouldBlock || e.raw_os_error() == Some(libc::ENOBUFS) => {
                stats.overruns += 1;
                return false;
            }
            Err(error) => {
                tracing::debug!(%error, "CAN frame not sent");
                stats.send_errors += 1;
                self.gone = self.gone.or(means_gone(&error));
            }
        }
        true
    }

    /// The next frame; an error if the interface is down or gone.
    pub(super) async fn recv(&mut self, stats: &mut BusStats) -> io::Result<Frame> {
        loop {
            if let Some(code) = self.gone {
                return Err(io::Error::from_raw_os_error(code));
            }
            match self.socket.read_frame().await {
                Ok(frame) => {
                    self.failing = false;
                    match from_kernel(&frame) {
                        Some(frame) => return Ok(frame),
                        None => stats.malformed += 1,
                    }
                }
                Err(error) if means_gone(&error).is_some() => {
                    stats.receive_errors += 1;
                    self.gone = means_gone(&error);
                }
                Err(error) => {
                    if !std::mem::replace(&mut self.failing, true) {
                        tracing::warn!(interface = self.name, %error, "{}", BusWarning::NothingReceived);
                    }
                    stats.receive_errors += 1;
                    tokio::time::sleep(READ_PAUSE).await;
                }
            }
        }
    }
}

/// The kernel's number for an interface that is down (`ip link set … down`), or no more (unplugged, its driver unloaded);
/// `None` for anything else.
pub fn means_gone(error: &io::Error) -> Option<i32> {
    error.raw_os_error().filter(|code| [libc::ENETDOWN, libc::ENODEV, libc::ENXIO].contains(code))
}

/// Whether opening failed because there is no CAN interface of that name, or no CAN in the kernel at all.
pub(super) fn means_no_interface(error: &io::Error) -> bool {
    let absent = [libc::ENODEV, libc::ENXIO, libc::EAFNOSUPPORT, libc::EPROTONOSUPPORT, libc::ESOCKTNOSUPPORT];
    error.raw_os_error().is_some_and(|code| absent.contains(&code))
}

/// Whether the kernel has CAN, without opening a socket: the protocol registers itself here.
pub(super) fn has_can() -> bool {
    Path::new("/proc/net/can").exists()
}

pub(super) fn to_kernel(frame: &Frame) -> Option<CanFrame> {
    let id = embedded_can::Frame::id(frame);
    match frame.kind() {
        FrameKind::Data => CanDataFrame::new(id, frame.data()).map(CanFrame::Data),
        FrameKind::Remote => CanRemoteFrame::new_remote(id, frame.len()).map(CanFrame::Remote),
        // Error frames come from the kernel alone; they cannot be sent.
        FrameKind::Error(_) => None,
    }
}

fn from_kernel(frame: &CanFrame) -> Option<Frame> {
    match frame {
        CanFrame::Data(f) => Frame::from_word(f.id_word(), f.data()).ok(),
        CanFrame::Remote(f) => Frame::remote_from_word(f.id_word(), u8::try_from(f.dlc()).ok()?).ok(),
        CanFrame::Error(f) => Frame::from_word(f.id_word(), f.data()).ok(),
    }
}
