//! What a page sends: the number of a frame that it has drawn, or what its operator does.
//!
//! Strict: a message that no page sends is an error, and ends its connection.

use linewright_coordinator_logic::ModeCommand;
use serde::{Deserialize, Serialize};

use crate::request::ResourceCommand;

/// Most bytes of a message of a page.
pub const PAGE_MESSAGE_MAX: usize = 512;

/// A message of a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PageMessage {
    /// A frame is acknowledged, by its number.
    Acknowledged(u64),
    Operated(PageOperation),
}

/// What an operator does, with the time of the frame that the page showed meanwhile.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PageOperation {
    /// `now_ms` of the newest frame that was drawn.
    pub seen_ms: u64,
    pub act: PageAct,
    /// Of the button of the step that comes next: the number of that step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<u64>,
}

/// What an operator does at a page.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PageAct {
    /// Takes control, from whatever connection has it.
    Take {
        /// Name of the operator, for all to see. May be empty.
        name: String,
    },
    /// Gives control up.
    GiveUp {},
    /// A mode command, of a cell also for one station.
    Command {
        word: String,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        station: Option<String>,
    },
    /// Turns a station's selector.
    Select { station: String, manual: bool },
    /// Begins to hold a button: of a station's panel, or of the console.
    Press {
        /// Higher than that of every press before on this connection.
        number: u64,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        station: Option<String>,
        button: String,
    },
    /// The button is still held.
    Beat { number: u64 },
    /// It is held no more.
    Release { number: u64 },
    /// Acknowledges an alarm: the operator has seen it. Its cause, and so the alarm, may still stand.
    Acknowledge {
        /// Number of the alarm on the page.
        shown: u64,
        /// Note, shown with the alarm and logged. May be empty.
        note: String,
    },
    /// Answers an alarm of a cell, by its number there.
    Answer { alarm: u64, word: String },
    /// Submits a production order.
    Submit {
        product: String,
        quantity: u32,
        /// Empty: one is made of product and time.
        #[serde(default)]
        name: String,
        /// Time from now to the due date, in s.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        due_s: Option<u32>,
    },
    /// Nothing more of an order enters.
    Cancel { order: String },
    /// An order of which nothing has entered is as if it had never been.
    Withdraw { order: String },
    /// Asks why an order, a part or a resource does not go on.
    Why { about: String },
    /// Takes a resource out of service, or back.
    Resource { resource: String, to: ResourceCommand },
}

/// A message that no page sends.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a message of a page: {0}")]
pub struct PageMessageError(String);

impl PageMessage {
    /// Reads a message.
    ///
    /// # Errors
    /// When it is longer than [`PAGE_MESSAGE_MAX`], no JSON of a message, or has more in it than a message has.
    pub fn parse(text: &str) -> Result<Self, PageMessageError> {
        if text.len() > PAGE_MESSAGE_MAX {
            return Err(PageMessageError(format!("{} bytes", text.len())));
        }
        if text.bytes().all(|byte| byte.is_ascii_digit()) {
            return text.parse().map(PageMessage::Acknowledged).map_err(|error| PageMessageError(error.to_string()));
        }
        serde_json::from_str(text).map(PageMessage::Operated).map_err(|error| PageMessageError(error.to_string()))
    }
}

impl PageAct {
    /// Whether it is *estop* of the line, which is given from every page, whatever that shows: a stop too many costs a reset.
    pub fn is_stop(&self) -> bool {
        matches!(self, PageAct::Command { word, station: None } if ModeCommand::parse(word) == Some(ModeCommand::EStop))
    }

    /// What tells the button of an act from every other one of a page; none of an act that has no button of its own.
    pub fn key(&self) -> Option<String> {
        let of = |station: &Option<String>| station.as_ref().map_or_else(String::new, |name| format!(" {name}"));
        match self {
            PageAct::Take { .. } | PageAct::GiveUp {} => Some("control".to_owned()),
            PageAct::Command { word, station } => Some(format!("command {word}{}", of(station))),
            PageAct::Select { station, manual } => {
                Some(format!("select {} {station}", if *manual { "manual" } else { "auto" }))
            }
            PageAct::Press { station, button, .. } => Some(format!("hold {button}{}", of(station))),
            // Each has one place on its page, whatever it is about.
            PageAct::Acknowledge { .. } => Some("acknowledge".to_owned()),
            PageAct::Answer { .. } => Some("answer".to_owned()),
            PageAct::Submit { .. } => Some("submit".to_owned()),
            PageAct::Cancel { .. } => Some("cancel".to_owned()),
            PageAct::Withdraw { .. } => Some("withdraw".to_owned()),
            PageAct::Why { .. } => Some("why".to_owned()),
            PageAct::Resource { to, .. } => Some(format!("resource {}", to.word())),
            PageAct::Beat { .. } | PageAct::Release { .. } => None,
        }
    }
}
