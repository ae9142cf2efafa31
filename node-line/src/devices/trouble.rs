//! Faults of an owner's devices that invalidate its image, in words on a topic of its own (`<station>/trouble`).
//!
//! The sentences come from the bus. They count milliseconds, so they differ each time; they are published when they
//! begin and end to apply, and once a second meanwhile.

use linewright_fieldbus_seam::{Budget, Joined};
use linewright_line::{Owner, Tick};
use linewright_msgs::{Text, cut};
use linewright_node_shell::{Publisher, RosNode, TopicError, qos};

use super::{EVERY, NEWS_EVERY, STATES_MAX};

/// The topic of one owner.
pub struct DeviceDiagnosticsTopic {
    owner: Owner,
    /// The node that manages them.
    manager: &'static str,
    /// They have been operational in this life.
    was_valid: bool,
    publisher: Publisher<Text>,
    text: String,
    valid: Option<bool>,
    news: Budget,
    due: Tick,
}

impl DeviceDiagnosticsTopic {
    /// Opens the topic. `manager` is the node that manages the devices, in an operator's words.
    pub fn open(node: &mut RosNode, topic: &str, owner: Owner, manager: &'static str) -> Result<Self, TopicError> {
        let publisher = node.publisher(topic, qos::latched_state())?;
        let news = Budget::new(STATES_MAX, NEWS_EVERY);
        let (text, due) = (String::new(), Tick::ZERO);
        Ok(DeviceDiagnosticsTopic { owner, manager, was_valid: false, publisher, text, valid: None, news, due })
    }

    /// Publishes what is due now.
    pub fn act(&mut self, now: Tick, buses: &Joined) {
        let valid = buses.inputs(self.owner).valid;
        if self.valid == Some(valid) && (valid || now < self.due) {
            return;
        }
        // A device that comes and goes must not flood a reliable topic. What is not published now is published at the
        // next call, which is never far: the manager's heartbeat alone causes one.
        if !self.news.take(now) {
            return;
        }
        self.valid = Some(valid);
        self.due = now + EVERY;
        self.was_valid |= valid;
        let text = since_start(self.manager, self.was_valid, in_words(buses, self.owner));
        if text != self.text || text.is_empty() {
            self.text.clone_from(&text);
            self.publisher.send(Text { data: text });
        }
    }

    /// Text last published; empty if the devices are valid.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// Devices that have not been operational in this life of their manager: what it has not received yet is the consequence of
/// its start, not the cause of what has stopped.
pub fn since_start(manager: &str, was_valid: bool, text: String) -> String {
    if was_valid || text.is_empty() {
        return text;
    }
    cut(format!("{manager}{STARTED}{text}"), TROUBLE_BYTES_MAX)
}

/// Between a manager and what is amiss with its devices since it was started.
const STARTED: &str = " was started, since then ";

/// The cause in a text of devices: of those that have not been operational since their manager was started, that start alone.
pub fn cause(text: &str) -> String {
    text.split_once(STARTED).map_or_else(|| text.to_owned(), |(manager, _)| format!("{manager} was started"))
}

/// Most bytes of a description of device faults, whatever its source.
pub const TROUBLE_BYTES_MAX: usize = 1024;

/// Approximate length of the text on one owner's devices, in bytes: messages of bounded length contain it several
/// times.
const ENOUGH: usize = 800;

/// A sentence for each device of `owner` that is in the way, or for the first ones, and one for all that were never heard; empty if none is.
pub fn in_words(buses: &Joined, owner: Owner) -> String {
    joined(unheard_together(buses.trouble(owner)).into_iter())
}

/// Text about a device that has not sent anything, between its name and the details.
const NEVER_HEARD: &str = ": never heard: ";

/// Sentences with those of devices that were never heard as one, in place of the first: they have one cause.
fn unheard_together(sentences: Vec<String>) -> Vec<String> {
    let name = |sentence: &String| Some(sentence.split_once(NEVER_HEARD)?.0.to_owned());
    let names: Vec<String> = sentences.iter().filter_map(name).collect();
    if names.len() < 2 {
        return sentences;
    }
    let mut all = Some(format!("never heard: {}", names.join(", ")));
    sentences.into_iter().filter_map(|of| if of.contains(NEVER_HEARD) { all.take() } else { Some(of) }).collect()
}

fn joined(sentences: impl Iterator<Item = String>) -> String {
    let mut text = String::new();
    let mut more = 0;
    for sentence in sentences {
        if text.is_empty() {
            text = sentence;
        } else if text.len() + sentence.len() <= ENOUGH {
            text.push_str("; ");
            text.push_str(&sentence);
        } else {
            more += 1;
        }
    }
    cut(if more == 0 { text } else { format!("{text}; and {more} more") }, TROUBLE_BYTES_MAX)
}
