//! The interface between a node and a field bus, whatever its kind.
//!
//! - [`InputImage`]: the inputs of an owner, with validity and losses;
//! - [`Fieldbus`]: a bus at work: images in and out, faults, diagnoses, requests, outputs off;
//! - [`News`]: what a bus reports;
//! - [`Joined`]: the buses of one node as one;
//! - [`Budget`]: limit on reports of repeated events.
//!
//! A kind of bus is a pure manager that decides, and a shell that implements [`Fieldbus`]. The nodes use nothing else of it:
//! another kind is another crate, and a `kind` in the description.
//!
//! One rule holds for every kind: **an output is energised only by an image that its owner set after the last time one of
//! the owner's devices was lost.** Each manager keeps it for its own devices, [`Joined`] across buses.

mod budget;
mod diagnosis;
mod image;
mod joined;
mod request;

use std::error::Error;
use std::future::Future;
use std::pin::Pin;

use linewright_line::Owner;

pub use budget::Budget;
pub use diagnosis::{Diagnosis, Level, NOT_HEARD};
pub use image::{InputImage, gather, scatter};
pub use joined::Joined;
pub use request::{Answer, BusRefusal, BusReply, BusRequest, BusTarget, ObjectAddress, abort};

/// Report of a bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum News {
    /// An owner's input image has changed, or whether it can be trusted has.
    InputsChanged { owner: Owner },
    /// A request to a device is answered; see [`Fieldbus::take_answers`].
    Answered,
    /// A message without meaning arrived; its description.
    Ignored(String),
    /// Anything else of interest to an operator, in words.
    Noted(String),
}

/// The bus is gone, or another manager's: its node lets go of its outputs and ends.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct BusLost(Box<dyn Error + Send + Sync>);

impl BusLost {
    pub fn new(why: impl Error + Send + Sync + 'static) -> Self {
        BusLost(Box::new(why))
    }
}

/// Future of [`Fieldbus::next`].
pub type NextNews<'a> = Pin<Box<dyn Future<Output = Result<Vec<News>, BusLost>> + Send + 'a>>;

/// Lets go of outputs from another thread, when the one that drives them is stuck.
pub type LastOrders = Box<dyn Fn() + Send>;

/// A field bus at work, as its node sees it.
pub trait Fieldbus: Send {
    fn describe(&self) -> String;

    /// Runs the bus until there is something to report; never returns an empty list.
    ///
    /// A loss is reported before the recovery that may follow it. Must be called again without much delay: between two
    /// calls the devices receive nothing, and let go of their outputs by themselves after a while. Cancel safe.
    ///
    /// # Errors
    /// When the bus is gone or another manager's. The node then has to end.
    fn next(&mut self) -> NextNews<'_>;

    /// The inputs of `owner` now; `None` if none of its devices is on this bus.
    fn inputs(&self, owner: Owner) -> Option<InputImage>;

    /// Sets the output image of `owner`. What changes is sent at once; on a loss the image is forgotten, and must be set
    /// again.
    fn set_outputs(&mut self, owner: Owner, image: u128);

    /// Lets go of every output, for an orderly end. It may wait for up to a tenth of a second.
    fn release_outputs(&mut self);

    /// Orders that let go of outputs when this bus gets no turn any more, for a watchdog. The process has to end after
    /// it.
    fn last_orders(&self) -> LastOrders;

    /// Why the inputs of `owner` are invalid: a sentence for each of its devices that is in the way.
    fn trouble(&self, owner: Owner) -> Vec<String>;

    fn diagnoses(&self) -> Vec<Diagnosis>;

    /// The name of each device that has a state in the words of `ros2_canopen`, and that state.
    fn states(&self, take: &mut dyn FnMut(&str, &'static str));

    /// Sends a request to a device; the answer comes with [`News::Answered`], under the number given here. `None` if it
    /// is not on this bus.
    fn ask(&mut self, target: &BusTarget, request: BusRequest) -> Option<u64>;

    /// Results of requests since the last call.
    fn take_answers(&mut self) -> Vec<(u64, Answer)>;
}
