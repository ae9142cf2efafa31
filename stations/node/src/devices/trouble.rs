//! What keeps an owner's devices from being valid, told in words on a topic of its own (`<station>/trouble`).
//!
//! The sentences come from the manager. They count milliseconds, so they differ each time; what is told is when they
//! begin and end to apply, and once a second meanwhile.

use linewright_fieldbus::Driver;
use linewright_line::{Owner, Tick};
use linewright_msgs::Text;
use linewright_node_shell::{Node, Publisher, TopicError, qos};

use super::EVERY;

/// The topic of one owner.
pub struct Trouble {
    owner: Owner,
    publisher: Publisher<Text>,
    text: String,
    valid: Option<bool>,
    due: Tick,
}

impl Trouble {
    /// Opens the topic.
    pub fn open(node: &mut Node, topic: &str, owner: Owner) -> Result<Self, TopicError> {
        let publisher = node.publisher(topic, qos::latched_state())?;
        Ok(Trouble { owner, publisher, text: String::new(), valid: None, due: Tick::ZERO })
    }

    /// Tells what there is to tell now.
    pub fn act(&mut self, now: Tick, driver: &Driver) {
        let valid = driver.inputs(self.owner).valid;
        if self.valid == Some(valid) && (valid || now < self.due) {
            return;
        }
        self.valid = Some(valid);
        self.due = now + EVERY;
        let text = in_words(driver, self.owner);
        if text != self.text || text.is_empty() {
            self.text.clone_from(&text);
            self.publisher.send(Text { data: text });
        }
    }

    /// What was told last; empty if the devices are valid.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// A sentence for each device of `owner` that is in the way; empty if none is.
pub fn in_words(driver: &Driver, owner: Owner) -> String {
    let sentences: Vec<String> = driver.manager().trouble(driver.now(), owner).collect();
    sentences.join("; ")
}
