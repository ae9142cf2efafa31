//! What a page about a running line shows: states in, the page's model and its changes out.
//!
//! [`ConsoleView`] is called with the newest state of each node and its age, and gives a [`ConsolePage`]: mode, stations, lanes of
//! operations, alarms, and of a flexible cell its parts and orders. What was never received, or is too old, is unknown in it: the
//! last value is never shown as if it were of now. [`PageFeed`] makes frames of the pages: the whole page, or what has changed since
//! the frame before. [`PageReader`] is the other side.
//!
//! Texts that the terminal view shows as well are here, once: [`refusal`], [`station_not_received`], [`left_out`], [`NextStep`] and others.
//!
//! What operators do comes the other way: [`PageMessage`] reads it, [`ControlDesk`] gives it to one page at a time, [`HoldMachine`] decides
//! for how long a button is held, and [`why_not`] why one would do nothing now.
//!
//! Pure: there is no clock. Times in a page count from the begin of the console, and each frame has the time at which it was made, so
//! that a reader computes ages and never compares clocks. It knows no sockets, no HTTP, no ROS and not how a page is drawn.
//!
//! ```
//! use std::time::Duration;
//! use linewright_console_view::{ConsoleInputs, ConsoleView, PageFeed, PageReader};
//!
//! let text = linewright_line::TransferLine::default().text();
//! let line = linewright_line::parse("line.toml", &text).unwrap().line;
//! let mut view = ConsoleView::new(&line, None, |_| "auto");
//! let page = view.page(&ConsoleInputs::nothing(Duration::from_millis(100), &line));
//! assert!(!page.mode.is_known);
//! let frame = PageFeed::default().frame(Duration::from_millis(100), &page);
//! let mut reader = PageReader::default();
//! reader.take(frame.text_after(None)).unwrap();
//! assert_eq!(reader.page()["mode"]["is_known"], false);
//! ```

mod aged;
mod alarms;
mod answers;
mod bounds;
mod cell;
mod desk;
mod frame;
mod hold;
mod lanes;
mod message;
mod next;
mod operate;
mod page;
mod plan;
mod request;
mod texts;
mod view;

pub use aged::{Aged, CELL_FRESH, state_fresh};
pub use alarms::{AcknowledgePart, AlarmPart, AlarmPriority};
pub use answers::{AnswerJson, answers, permitted, verdict};
pub use bounds::{LIST_MAX, TEXT_MAX};
pub use cell::{CellChoices, CellPart, ShownActivity, ShownOrder, ShownOutage, ShownPart};
pub use desk::{ConnectionNumber, ControlDesk, ControlPart, DeskEffect, DeskNote, HolderPart, PressPart};
pub use frame::{PageChange, PageFeed, PageFrame, PageFrameError, PageReader};
pub use hold::{
    BEAT_WITHIN, HELD_AT_MOST, HoldButton, HoldEnd, HoldMachine, HoldMessage, PUBLISH_EVERY, RESUME, SEEN_WITHIN,
};
pub use lanes::{LANE_WINDOW, LaneRow, LaneStretch, STRETCHES_MAX, StationLanes, StretchKind};
pub use message::{PAGE_MESSAGE_MAX, PageAct, PageMessage, PageMessageError, PageOperation};
pub use next::{NextStep, asks_to_confirm};
pub use operate::{
    HAND_ONLY, NOTHING_INCOMPLETE, OperateButton, OperatePart, OperateStates, PANEL_ONLY, PanelPart, RESUME_ONLY,
    stations_of, why_not,
};
pub use page::{ConsolePage, CyclePart, ModePart, StationHealth, StationPart};
pub use plan::{INERT_FOR, PlanPart, PlanStepPart};
pub use request::{CellRequest, ResourceCommand};
pub use texts::{
    OWN_EMERGENCY_STOP, ReasonsByResource, SELECTOR_AT_MANUAL, coordinator_not_received, due, is_over, left_out,
    of_order, of_part, refusal, seconds, span, station_not_received, waits,
};
pub use view::{ConsoleInputs, ConsoleView};
