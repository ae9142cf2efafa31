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
    publisher: Publisher<Text>,
    text: String,
    valid: Option<bool>,
    news: Budget,
    due: Tick,
}

impl DeviceDiagnosticsTopic {
    /// Opens the topic.
    pub fn open(node: &mut RosNode, topic: &str, owner: Owner) -> Result<Self, TopicError> {
        let publisher = node.publisher(topic, qos::latched_state())?;
        let news = Budget::new(STATES_MAX, NEWS_EVERY);
        Ok(DeviceDiagnosticsTopic { owner, publisher, text: String::new(), valid: None, news, due: Tick::ZERO })
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
        let text = in_words(buses, self.owner);
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

/// Most bytes of a description of device faults, whatever its source.
pub const TROUBLE_BYTES_MAX: usize = 1024;

/// Approximate length of the text on one owner's devices, in bytes: messages of bounded length contain it several
/// times.
const ENOUGH: usize = 800;

/// A sentence for each device of `owner` that is in the way, or for the first ones; empty if none is.
pub fn in_words(buses: &Joined, owner: Owner) -> String {
    joined(buses.trouble(owner).into_iter())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_devices_the_first_are_named_and_the_rest_counted() {
        let of = |number: usize| joined((0..number).map(|at| format!("device {at:03} is not heard")));
        assert_eq!(of(0), "");
        assert_eq!(of(2), "device 000 is not heard; device 001 is not heard");
        let many = of(200);
        assert!(many.len() <= TROUBLE_BYTES_MAX && many.ends_with(" more"), "{many}");
        let named = many.matches("device ").count();
        assert!(many.ends_with(&format!("; and {} more", 200 - named)), "{many}");
        let long = joined(["x".repeat(9000), "y".to_owned()].into_iter());
        assert!(long.len() <= TROUBLE_BYTES_MAX && long.ends_with('…'), "{long}");
    }
}
