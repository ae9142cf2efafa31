//! Requests of a page to the coordinator of a flexible cell: what each needs, and how it is logged.

use linewright_coordinator_cell::texts::AnswerFit;
use linewright_msgs::{AlarmState, CellState};
use serde::{Deserialize, Serialize};

use crate::answers::{permitted, verdict};
use crate::message::PageAct;
use crate::texts::is_over;

/// Most characters of an operator's note.
pub(crate) const NOTE_MAX: usize = 100;

/// Longest time from a submission to its due date, in s.
const DUE_MAX: u32 = 1_000_000_000;

/// Most parts of an order that is submitted at a page.
const QUANTITY_MAX: u32 = 1_000_000;

/// A state of a resource that is commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ResourceCommand {
    /// It is counted on again.
    Up,
    /// It is left out when it has finished what it does.
    Down,
    /// Its station, which is in an emergency stop of its own, follows the mode of the line again.
    Reset,
}

/// A request to the coordinator of a cell. Its reply belongs to the page that has asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CellRequest {
    Answer {
        alarm: u64,
        word: String,
        /// The operator, for the log of the coordinator.
        by: String,
    },
    Submit {
        product: String,
        quantity: u32,
        /// Empty: one is made of product and time.
        name: String,
        /// Time from now to the due date, in s; none: it does not matter.
        due_s: Option<u32>,
    },
    Cancel {
        order: String,
    },
    Withdraw {
        order: String,
    },
    Why {
        about: String,
    },
    Resource {
        resource: String,
        to: ResourceCommand,
        by: String,
    },
}

impl ResourceCommand {
    /// The word an operator types.
    pub const fn word(self) -> &'static str {
        match self {
            ResourceCommand::Up => "up",
            ResourceCommand::Down => "down",
            ResourceCommand::Reset => "reset",
        }
    }
}

impl CellRequest {
    /// The request of an act of this operator; none of other acts.
    pub fn of(act: &PageAct, by: &str) -> Option<Self> {
        let by = by.to_owned();
        Some(match act.clone() {
            PageAct::Answer { alarm, word } => CellRequest::Answer { alarm, word, by },
            PageAct::Submit { product, quantity, name, due_s } => {
                CellRequest::Submit { product, quantity, name: name.trim().to_owned(), due_s }
            }
            PageAct::Cancel { order } => CellRequest::Cancel { order },
            PageAct::Withdraw { order } => CellRequest::Withdraw { order },
            PageAct::Why { about } => CellRequest::Why { about },
            PageAct::Resource { resource, to } => CellRequest::Resource { resource, to, by },
            PageAct::Take { .. }
            | PageAct::GiveUp {}
            | PageAct::Command { .. }
            | PageAct::Select { .. }
            | PageAct::Press { .. }
            | PageAct::Beat { .. }
            | PageAct::Release { .. }
            | PageAct::Acknowledge { .. } => return None,
        })
    }

    /// What is asked, for the log.
    pub fn text(&self) -> String {
        match self {
            CellRequest::Answer { alarm, word, .. } => format!("answer \"{word}\" to alarm {alarm}"),
            CellRequest::Submit { product, quantity, name, due_s } => {
                let name = if name.is_empty() { String::new() } else { format!(" `{name}`") };
                let due = due_s.map_or_else(String::new, |due| format!(", due in {due} s"));
                format!("order{name} of {quantity} {product}{due}")
            }
            CellRequest::Cancel { order } => format!("order `{order}` cancelled"),
            CellRequest::Withdraw { order } => format!("order `{order}` withdrawn"),
            CellRequest::Why { about } => format!("why {about}"),
            CellRequest::Resource { resource, to, .. } => format!("resource {resource} {}", to.word()),
        }
    }

    /// Whether it changes nothing.
    pub fn only_reads(&self) -> bool {
        matches!(self, CellRequest::Why { .. })
    }
}

/// Why a request is not possible by the state of the cell; none where its coordinator is to decide. `cell`: none where it is not received.
pub(crate) fn why_not(cell: Option<&CellState>, act: &PageAct) -> Option<String> {
    let Some(cell) = cell else { return Some("the state of the cell is not received".to_owned()) };
    match act {
        PageAct::Answer { alarm, word } => {
            let Some(alarm) = cell.alarms.as_slice().iter().find(|of| of.id == *alarm) else {
                return Some(format!("alarm {alarm} is over; another one may ask for something else"));
            };
            answer_why_not(alarm, word)
        }
        PageAct::Submit { quantity, due_s, .. } => match () {
            () if !(1..=QUANTITY_MAX).contains(quantity) => Some(format!("a number of parts from 1 to {QUANTITY_MAX}")),
            () if due_s.is_some_and(|due| due > DUE_MAX) => Some(format!("due in at most {DUE_MAX} s")),
            () => None,
        },
        PageAct::Cancel { order } | PageAct::Withdraw { order } => {
            let open: Vec<&str> =
                cell.orders.as_slice().iter().filter(|of| !is_over(of)).map(|of| of.name.as_str()).collect();
            // The list of a large cell is cut.
            let is_whole = open.len() >= cell.orders_open as usize;
            (is_whole && !open.contains(&order.as_str())).then(|| format!("no order `{order}` that is not over"))
        }
        _ => None,
    }
}

/// Why an answer would not be taken now; none where it may be.
pub(crate) fn answer_why_not(alarm: &AlarmState, word: &str) -> Option<String> {
    let answers = permitted(alarm);
    let Some(answer) = answers.iter().find(|of| of.word == word) else {
        let words: Vec<&str> = answers.iter().map(|of| of.word.as_str()).collect();
        return Some(format!("\"{word}\" is no answer to alarm {}; its answers: {}", alarm.id, words.join(", ")));
    };
    let refused = answer.remark.as_ref().filter(|remark| remark.fit == AnswerFit::Refused);
    refused.map(|remark| format!("{} now: {}", verdict(remark.fit), remark.why))
}
