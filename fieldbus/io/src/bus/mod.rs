//! The wire: SocketCAN where the kernel has an interface of that name, else a virtual bus between processes.
//!
//! Both carry the same sixteen bytes per frame and behave alike: all other members receive a frame, its sender does
//! not, frames of one sender arrive in order, and no member waits for another. [`Bus::describe`] names the one in use,
//! because a line without motion is hard to debug when the frames are on the other.
//!
//! This module handles sockets and directories; it does not look into frames.

mod kernel;
mod last;
mod members;
mod own;
mod virtual_bus;

use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use kernel::KernelBus;
pub use kernel::means_gone;
pub use last::LastWire;
use linewright_canopen::Frame;
use linewright_canopen::candump::CandumpWriter;
pub use own::{BusDirectory, OwnBuses, find as find_bus, find_in as find_bus_in};
use virtual_bus::VirtualBus;

use crate::texts::{BusDescription, BusWarning};

/// Transport and place of the bus.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BusOptions {
    pub transport: Transport,
    /// Directory of the virtual buses, one directory each. By default `$LINEWRIGHT_BUS_DIR`, else
    /// `$XDG_RUNTIME_DIR/linewright-bus`, else `linewright-bus-<uid>` in the directory for temporary files.
    pub dir: Option<PathBuf>,
}

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
#[derive(Debug)]
pub enum BusError {
    /// The name cannot be that of an interface.
    Name { name: String },
    /// The interface cannot be opened.
    Kernel { name: String, error: io::Error },
    /// There is no such interface, and the virtual bus was not requested.
    Missing { name: String, error: io::Error },
    /// The interface was there, and is down or gone.
    Gone { name: String, error: io::Error },
    /// The virtual bus's directory cannot be used.
    Virtual {
        name: String,
        /// Its directory, or this member's place in it.
        path: String,
        error: io::Error,
    },
}

/// Counters of a bus, with the errors that did not stop it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusStats {
    pub sent: u64,
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

enum BusWire {
    Kernel(KernelBus),
    Virtual(VirtualBus),
}

/// One participant's connection to a bus.
pub struct Bus {
    name: String,
    wire: BusWire,
    stats: BusStats,
    recorder: Option<CandumpWriter>,
}

impl Bus {
    /// Connects to the bus `name`. Must be called within a tokio runtime.
    pub fn open(name: &str, options: &BusOptions) -> Result<Bus, BusError> {
        if !is_bus_name(name) {
            return Err(BusError::Name { name: name.to_owned() });
        }
        let wire = match options.transport {
            Transport::Virtual => BusWire::Virtual(VirtualBus::open(name, options.dir.as_deref())?),
            Transport::SocketCan => match KernelBus::open(name) {
                Ok(bus) => BusWire::Kernel(bus),
                Err(error) if kernel::means_no_interface(&error) => {
                    return Err(BusError::Missing { name: name.to_owned(), error });
                }
                Err(error) => return Err(BusError::Kernel { name: name.to_owned(), error }),
            },
            Transport::Auto => match KernelBus::open(name) {
                Ok(bus) => BusWire::Kernel(bus),
                Err(error) if kernel::means_no_interface(&error) => {
                    BusWire::Virtual(VirtualBus::open(name, options.dir.as_deref())?)
                }
                // The interface is there and does not work: falling back would hide it.
                Err(error) => return Err(BusError::Kernel { name: name.to_owned(), error }),
            },
        };
        Ok(Bus { name: name.to_owned(), wire, stats: BusStats::default(), recorder: None })
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn describe(&self) -> String {
        let name = self.name.as_str();
        match &self.wire {
            BusWire::Kernel(_) => BusDescription::SocketCan { name },
            BusWire::Virtual(bus) => BusDescription::Virtual { name, dir: bus.dir(), has_can: kernel::has_can() },
        }
        .to_string()
    }

    /// Whether it is the virtual bus.
    pub fn is_virtual(&self) -> bool {
        matches!(self.wire, BusWire::Virtual(_))
    }

    /// A second way onto this bus, for another thread. None where the system gives no more sockets.
    pub fn last_wire(&self) -> Option<LastWire> {
        let opened = match &self.wire {
            BusWire::Kernel(_) => LastWire::kernel(&self.name),
            BusWire::Virtual(bus) => LastWire::of_directory(bus.dir().to_owned()),
        };
        opened.map_err(|error| tracing::warn!("{}: {}: {error}", self.name, BusWarning::NoLastWire)).ok()
    }

    /// Records every frame sent and received from here on.
    pub fn record(&mut self, recorder: CandumpWriter) {
        self.recorder = Some(recorder);
    }

    /// Sends a frame to all other members of the bus. Never waits: what cannot be sent now is counted, and lost as on a
    /// wire unless the caller tries again. (The virtual bus holds a short backlog for members that are slow.)
    ///
    /// False if the interface's queue is full, and the frame was not sent.
    pub fn send(&mut self, frame: &Frame) -> bool {
        let taken = match &mut self.wire {
            BusWire::Kernel(bus) => bus.send(frame, &mut self.stats),
            BusWire::Virtual(bus) => {
                bus.send(frame, &mut self.stats);
                true
            }
        };
        if taken {
            self.note(frame);
        }
        taken
    }

    /// The next frame from another member. Cancel safe: a frame is either returned or still to come. Other failures of
    /// the system are counted and waited out.
    ///
    /// # Errors
    /// The CAN interface is down or gone. The last frames may not have left, and no more are received: a node ends.
    pub async fn recv(&mut self) -> Result<Frame, BusError> {
        let frame = match &mut self.wire {
            BusWire::Kernel(bus) => {
                bus.recv(&mut self.stats).await.map_err(|error| BusError::Gone { name: self.name.clone(), error })?
            }
            BusWire::Virtual(bus) => bus.recv(&mut self.stats).await,
        };
        self.stats.received += 1;
        self.note(&frame);
        Ok(frame)
    }

    /// Counters so far, those of errors among them.
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

/// Place of a bus, without opening it: its interface's name, or the directory of a virtual one. Two programs that open
/// buses of one place are on one bus.
pub fn place(name: &str, options: &BusOptions) -> String {
    let is_interface = is_bus_name(name) && Path::new("/sys/class/net").join(name).exists();
    if options.transport == Transport::SocketCan || (options.transport == Transport::Auto && is_interface) {
        return name.to_owned();
    }
    let Ok(directory) = members::base(options.dir.as_deref()) else { return name.to_owned() };
    let directory = std::fs::canonicalize(&directory).or_else(|_| std::path::absolute(&directory)).unwrap_or(directory);
    directory.join(name).display().to_string()
}

/// Whether it is an interface name for Linux, and harmless as a directory name.
fn is_bus_name(name: &str) -> bool {
    let plain = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'_' | b'-');
    (1..=15).contains(&name.len()) && !name.starts_with('.') && name.bytes().all(plain)
}
