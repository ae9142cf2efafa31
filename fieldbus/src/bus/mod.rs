//! The wire: SocketCAN where the kernel has an interface of that name, else a virtual bus between processes.
//!
//! Both carry the same sixteen bytes per frame and behave alike: everyone else hears a frame, its sender does not,
//! frames of one sender arrive in order, and nobody waits for anybody. Which of the two it is, [`Bus::describe`] says
//! in words, because a line that moves nothing is a nuisance to debug when the frames are somewhere else.
//!
//! This module knows sockets and directories; it does not look into frames.

mod kernel;
mod members;
mod virtual_bus;

use std::io;
use std::path::PathBuf;
use std::time::SystemTime;

use thiserror::Error;

use crate::candump::Recorder;
use crate::frame::Frame;
use kernel::KernelBus;
use virtual_bus::VirtualBus;

/// Where to look for the bus.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Which kind of wire.
    pub transport: Transport,
    /// Where virtual buses live, one directory each. By default `$LINEWRIGHT_BUS_DIR`, else
    /// `$XDG_RUNTIME_DIR/linewright-bus`, else `linewright-bus-<uid>` in the directory for temporary files.
    pub dir: Option<PathBuf>,
}

/// Which kind of wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transport {
    /// SocketCAN if the kernel has a CAN interface of that name, else the virtual bus.
    #[default]
    Auto,
    /// SocketCAN or an error.
    SocketCan,
    /// The virtual bus, whatever the kernel has.
    Virtual,
}

/// Why a bus cannot be opened.
#[derive(Debug, Error)]
pub enum BusError {
    /// The name cannot be that of an interface.
    #[error("`{name}` is not a bus name: 1 to 15 letters, digits, `.`, `_` or `-`, not starting with a dot")]
    Name {
        /// The name.
        name: String,
    },
    /// The kernel refuses the interface.
    #[error("cannot open CAN interface {name}: {error}")]
    Kernel {
        /// The interface.
        name: String,
        /// The kernel's reason.
        error: io::Error,
    },
    /// The virtual bus's directory cannot be used.
    #[error("cannot use {path} for virtual bus '{name}': {error}")]
    Virtual {
        /// The bus.
        name: String,
        /// Its directory, or this member's place in it.
        path: String,
        /// The system's reason.
        error: io::Error,
    },
}

/// What went wrong on a bus without stopping it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusStats {
    /// Frames sent.
    pub sent: u64,
    /// Frames received.
    pub received: u64,
    /// Frames some or all others did not get because a queue was full.
    pub overruns: u64,
    /// Frames the system refused to send.
    pub send_errors: u64,
    /// Failures to receive.
    pub receive_errors: u64,
    /// Datagrams that were no frames.
    pub malformed: u64,
}

enum Wire {
    Kernel(KernelBus),
    Virtual(VirtualBus),
}

/// One participant's connection to a bus.
pub struct Bus {
    name: String,
    wire: Wire,
    stats: BusStats,
    recorder: Option<Recorder>,
}

impl Bus {
    /// Connects to the bus `name`. Must be called within a tokio runtime.
    pub fn open(name: &str, options: &Options) -> Result<Bus, BusError> {
        if !is_bus_name(name) {
            return Err(BusError::Name { name: name.to_owned() });
        }
        let wire = match options.transport {
            Transport::Virtual => Wire::Virtual(VirtualBus::open(name, options.dir.as_deref())?),
            Transport::SocketCan => match KernelBus::open(name) {
                Ok(bus) => Wire::Kernel(bus),
                Err(error) => return Err(BusError::Kernel { name: name.to_owned(), error }),
            },
            Transport::Auto => match KernelBus::open(name) {
                Ok(bus) => Wire::Kernel(bus),
                Err(error) if kernel::means_no_interface(&error) => {
                    Wire::Virtual(VirtualBus::open(name, options.dir.as_deref())?)
                }
                // The interface is there and does not work: falling back would hide it.
                Err(error) => return Err(BusError::Kernel { name: name.to_owned(), error }),
            },
        };
        Ok(Bus { name: name.to_owned(), wire, stats: BusStats::default(), recorder: None })
    }

    /// The bus's name, as given.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Which wire this is, for a person.
    pub fn describe(&self) -> String {
        match &self.wire {
            Wire::Kernel(_) => format!("SocketCAN {}", self.name),
            Wire::Virtual(bus) if kernel::has_can() => {
                format!("virtual bus '{}' in {} (no CAN interface of that name)", self.name, bus.dir().display())
            }
            Wire::Virtual(bus) => {
                format!("virtual bus '{}' in {} (this kernel has no CAN)", self.name, bus.dir().display())
            }
        }
    }

    /// Whether it is the virtual bus.
    pub fn is_virtual(&self) -> bool {
        matches!(self.wire, Wire::Virtual(_))
    }

    /// Records every frame sent and received from here on.
    pub fn record(&mut self, recorder: Recorder) {
        self.recorder = Some(recorder);
    }

    /// Sends a frame to everyone else on the bus. Never waits: what cannot be sent now is counted, and lost as on a
    /// wire unless the caller tries again. (The virtual bus holds a short backlog for members that are slow.)
    ///
    /// False if the interface's queue is full, and the frame was not sent.
    pub fn send(&mut self, frame: &Frame) -> bool {
        let taken = match &mut self.wire {
            Wire::Kernel(bus) => bus.send(frame, &mut self.stats),
            Wire::Virtual(bus) => {
                bus.send(frame, &mut self.stats);
                true
            }
        };
        if taken {
            self.note(frame);
        }
        taken
    }

    /// The next frame somebody else has sent. Cancel safe: a frame is either returned or still to come. Failures of
    /// the system are counted and waited out; a bus that has come down never answers.
    pub async fn recv(&mut self) -> Frame {
        let frame = match &mut self.wire {
            Wire::Kernel(bus) => bus.recv(&mut self.stats).await,
            Wire::Virtual(bus) => bus.recv(&mut self.stats).await,
        };
        self.stats.received += 1;
        self.note(&frame);
        frame
    }

    /// What went wrong so far, and what did not.
    pub fn stats(&self) -> BusStats {
        self.stats
    }

    fn note(&mut self, frame: &Frame) {
        if let Some(recorder) = &mut self.recorder {
            let since_epoch = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
            recorder.record(since_epoch, frame);
        }
    }
}

/// What Linux takes as an interface name, narrowed to what is harmless as a directory name.
fn is_bus_name(name: &str) -> bool {
    let plain = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'_' | b'-');
    (1..=15).contains(&name.len()) && !name.starts_with('.') && name.bytes().all(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_leave_the_directory_are_refused() {
        for name in ["", ".", "..", "../x", "a/b", "sixteen-letters-", "né"] {
            assert!(matches!(Bus::open(name, &Options::default()), Err(BusError::Name { .. })), "{name}");
        }
        assert!(is_bus_name("vcan0") && is_bus_name("can-drill.1"));
    }
}
