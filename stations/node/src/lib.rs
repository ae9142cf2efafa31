//! One station's ROS 2 node: a thin shell around [`linewright_station_logic::Controller`].
//!
//! It turns messages, images and timers into the controller's inputs, and the controller's outbox into a journal
//! record, an output image, a report and events — in that order, so that no state is sent that the station would have
//! lost after being killed. It decides nothing.

mod device_texts;
mod devices;
mod journal;
mod lifecycle;
mod node;
mod orders;
mod tell;
mod topics;
mod waiting;

pub use device_texts::DeviceTexts;
pub use journal::{RecordError, from_record, to_record};
pub use node::{StationNodeError, StationOptions, run};
pub use topics::inputs_from_message;
