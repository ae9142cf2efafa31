//! The thin shell around a [`Manager`]: its bus, and the clock its node shares.
//!
//! Nothing is decided here. A frame that comes in goes to the manager, a deadline that comes up polls it, frames it
//! hands out are sent at once.

use std::sync::{Arc, Mutex};

use linewright_canopen::Frame;
use linewright_canopen::codec::NodeId;
use linewright_canopen::manager::{BusEvent, BusOutbox, DeviceRequest, Manager, RequestResult};
use linewright_fieldbus_seam::InputImage;
use linewright_line::{Owner, Tick};

use crate::bus::{Bus, BusError, LastWire};
use crate::clock::Clock;
use crate::texts::BusWarning;

pub struct Driver {
    bus: Bus,
    manager: Manager,
    clock: Clock,
    outbox: BusOutbox,
    /// Frames that let go of outputs now, where a device needs them.
    last: Arc<Mutex<Vec<Frame>>>,
}

/// Lets go of outputs from another thread, when the one that drives them is stuck.
pub struct LastFrames {
    frames: Arc<Mutex<Vec<Frame>>>,
    wire: Option<LastWire>,
}

impl LastFrames {
    /// Sends, without waiting, the frames that let go of every output of devices that would keep it; gives the number
    /// taken. The process has to end after this: its driver is unaware of it.
    pub fn send(&self) -> usize {
        match (&self.wire, self.frames.try_lock()) {
            (Some(wire), Ok(frames)) => wire.send(&frames),
            _ => 0,
        }
    }
}

/// Why a manager cannot go on. Its node lets go of its outputs and ends.
#[derive(Debug)]
pub enum DriverError {
    /// The interface is gone.
    Bus(BusError),
    /// Another manager drives this bus.
    AnotherManager {
        bus: String,
        /// Whether this one had already sent frames.
        has_sent: bool,
    },
}

impl From<BusError> for DriverError {
    fn from(error: BusError) -> Self {
        DriverError::Bus(error)
    }
}

/// Number and distance of the attempts to send the last orders: a tenth of a second in all.
const RELEASE_TRIES: usize = 100;
const RELEASE_PAUSE: std::time::Duration = std::time::Duration::from_millis(1);

impl Driver {
    /// Joins a manager and its bus. Nothing is sent before [`Driver::next`] or [`Driver::set_outputs`] is called.
    pub fn new(bus: Bus, manager: Manager, clock: Clock) -> Self {
        Driver { bus, manager, clock, outbox: BusOutbox::default(), last: Arc::default() }
    }

    /// Frames that let go of outputs when this driver gets no turn any more, for a watchdog.
    pub fn last_frames(&self) -> LastFrames {
        LastFrames { frames: self.last.clone(), wire: self.bus.last_wire() }
    }

    /// Runs the bus until there is something to report; never returns an empty list.
    ///
    /// It returns after the first frame or deadline that reports anything, so that a loss is seen before the recovery
    /// that may follow in the very next frame. Must be called again without much delay: between two calls no
    /// heartbeat is sent, and after [`heartbeat_timeout`](linewright_line::Timing::heartbeat_timeout) the devices let
    /// go of their outputs. Cancel safe.
    ///
    /// # Errors
    /// When the interface is gone, or another manager was on the bus first. The node then has to end.
    pub async fn next(&mut self) -> Result<Vec<BusEvent>, DriverError> {
        loop {
            // The clock first: under a flood of frames, and after this process was held up, silence still counts.
            let now = self.clock.now();
            if self.manager.next_deadline().is_none_or(|due| due <= now) {
                self.manager.poll(now, &mut self.outbox);
                self.flush();
            }
            if let Some(has_sent) = self.manager.yields() {
                return Err(DriverError::AnotherManager { bus: self.bus.describe(), has_sent });
            }
            if !self.outbox.events.is_empty() {
                return Ok(std::mem::take(&mut self.outbox.events));
            }
            tokio::select! {
                biased;
                frame = self.bus.recv() => {
                    self.manager.handle(self.clock.now(), &frame?, &mut self.outbox);
                    self.flush();
                }
                () = self.clock.sleep_until(self.manager.next_deadline()) => {}
            }
        }
    }

    /// Sets the output image of `owner`; see [`Manager::set_outputs`]. Sent before this returns.
    ///
    /// After a loss ([`InputImage::losses`] has grown) an image must be set again: the one from before is forgotten.
    pub fn set_outputs(&mut self, owner: Owner, image: u128) {
        self.manager.set_outputs(self.clock.now(), owner, image, &mut self.outbox);
        self.flush();
    }

    /// Lets go of every output, for an orderly end. The bus gets no turn after that, so frames that the interface has
    /// no room for are offered again for a while, and the program waits. One that came second on its bus sends nothing.
    pub fn release_outputs(&mut self) {
        self.manager.release_outputs(self.clock.now(), &mut self.outbox);
        for _ in 0..RELEASE_TRIES {
            let sent = self.outbox.frames.iter().take_while(|frame| self.bus.send(frame)).count();
            self.outbox.frames.drain(..sent);
            if self.outbox.frames.is_empty() {
                return;
            }
            std::thread::sleep(RELEASE_PAUSE);
        }
        tracing::warn!(left = self.outbox.frames.len(), "{}", BusWarning::NotReleased);
    }

    /// Sends a request to a device; see [`Manager::ask`]. [`Driver::next`] reports when it is answered.
    pub fn ask(&mut self, node: u8, ask: DeviceRequest) -> u64 {
        let number = self.manager.ask(self.clock.now(), node, ask, &mut self.outbox);
        self.flush();
        number
    }

    /// Results of requests since the last call.
    pub fn take_answers(&mut self) -> Vec<(u64, RequestResult)> {
        std::mem::take(&mut self.outbox.answers)
    }

    /// Resets a device; see [`Manager::reset_node`].
    pub fn reset_node(&mut self, node: NodeId) {
        self.manager.reset_node(self.clock.now(), node, &mut self.outbox);
        self.flush();
    }

    /// Starts a device; see [`Manager::start_node`].
    ///
    /// # Errors
    /// In words, why it is not started now.
    pub fn start_node(&mut self, node: NodeId) -> Result<String, String> {
        let result = self.manager.start_node(self.clock.now(), node, &mut self.outbox);
        self.flush();
        result
    }

    pub fn inputs(&self, owner: Owner) -> InputImage {
        self.manager.inputs(self.clock.now(), owner)
    }

    pub fn manager(&self) -> &Manager {
        &self.manager
    }

    pub fn bus(&self) -> &Bus {
        &self.bus
    }

    /// The present moment of the clock it was given.
    pub fn now(&self) -> Tick {
        self.clock.now()
    }

    fn flush(&mut self) {
        if !self.outbox.frames.is_empty()
            && let Ok(mut frames) = self.last.lock()
        {
            frames.clear();
            self.manager.release_frames(&mut frames);
        }
        let sent = self.outbox.frames.iter().take_while(|frame| self.bus.send(frame)).count();
        let refused = self.outbox.frames.split_off(sent);
        self.outbox.frames.clear();
        if !refused.is_empty() {
            self.manager.return_unsent(self.clock.now(), refused);
        }
    }
}
