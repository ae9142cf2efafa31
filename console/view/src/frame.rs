//! Frames of a page: the whole of it, or what has changed since the frame before.
//!
//! A change is a path into the page as JSON and the value that is there now. An object keeps its keys and is compared by them; of a list
//! the entries are compared as long as it keeps its length, otherwise it is given anew. Frames are numbered without gaps. A reader that
//! has not read the frame before is given the whole page.

use std::sync::OnceLock;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::lanes::ms;
use crate::page::ConsolePage;

/// One step into a page: a key of an object or an index of a list.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
enum PathStep {
    Index(usize),
    Key(String),
}

/// A value that has changed, with its place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PageChange(Vec<PathStep>, Value);

/// Why a reader cannot use a frame.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum PageFrameError {
    #[error("a frame that is no JSON of a frame: {0}")]
    NotAFrame(String),
    #[error(
        "changes since frame {expected} were received, and the page is that of frame {is}; connect again for the whole page"
    )]
    Missed { expected: u64, is: u64 },
    #[error("a change at a place that the page does not have")]
    NoSuchPlace,
}

impl PageChange {
    /// What has to be changed for `old` to be `new`.
    pub fn between(old: &Value, new: &Value) -> Vec<PageChange> {
        let mut changes = Vec::new();
        compare(old, new, &mut Vec::new(), &mut changes);
        changes
    }

    /// Makes the change in a page.
    ///
    /// # Errors
    /// When the page has no such place.
    pub fn apply(self, page: &mut Value) -> Result<(), PageFrameError> {
        let PageChange(path, value) = self;
        let mut place = page;
        for step in &path {
            place = match step {
                PathStep::Index(index) => place.get_mut(index),
                PathStep::Key(key) => place.get_mut(key),
            }
            .ok_or(PageFrameError::NoSuchPlace)?;
        }
        *place = value;
        Ok(())
    }
}

fn compare(old: &Value, new: &Value, path: &mut Vec<PathStep>, changes: &mut Vec<PageChange>) {
    match (old, new) {
        (Value::Object(was), Value::Object(is)) if was.len() == is.len() && was.keys().eq(is.keys()) => {
            for ((key, was), is) in was.iter().zip(is.values()) {
                path.push(PathStep::Key(key.clone()));
                compare(was, is, path, changes);
                path.pop();
            }
        }
        (Value::Array(was), Value::Array(is)) if was.len() == is.len() => {
            for (index, (was, is)) in was.iter().zip(is).enumerate() {
                path.push(PathStep::Index(index));
                compare(was, is, path, changes);
                path.pop();
            }
        }
        _ if old == new => {}
        _ => changes.push(PageChange(path.clone(), new.clone())),
    }
}

/// A frame, as text for every reader.
#[derive(Debug)]
pub struct PageFrame {
    sequence: u64,
    now_ms: u64,
    page: Value,
    changes: String,
    whole: OnceLock<String>,
}

impl PageFrame {
    /// Its number, from 1.
    pub fn sequence(&self) -> u64 {
        self.sequence
    }

    /// JSON for a reader whose last frame had this number; none for a reader that has had none.
    pub fn text_after(&self, last: Option<u64>) -> &str {
        if last.is_some_and(|last| last + 1 == self.sequence) {
            return &self.changes;
        }
        let whole = || json!({ "sequence": self.sequence, "now_ms": self.now_ms, "page": self.page }).to_string();
        self.whole.get_or_init(whole)
    }
}

/// Makes the frames of one console.
#[derive(Debug, Default)]
pub struct PageFeed {
    sequence: u64,
    last: Value,
}

impl PageFeed {
    /// The next frame, made at this time since the begin of the console.
    pub fn frame(&mut self, now: Duration, page: &ConsolePage) -> PageFrame {
        // A page has no map with keys that are no texts, and no writer that fails.
        self.frame_of(now, serde_json::to_value(page).unwrap_or_default())
    }

    /// The same of a page that is JSON already.
    pub fn frame_of(&mut self, now: Duration, page: Value) -> PageFrame {
        self.sequence += 1;
        let (sequence, now_ms) = (self.sequence, ms(now));
        let changes =
            json!({ "sequence": sequence, "now_ms": now_ms, "changes": PageChange::between(&self.last, &page) });
        self.last = page.clone();
        PageFrame { sequence, now_ms, page, changes: changes.to_string(), whole: OnceLock::new() }
    }
}

#[derive(Deserialize)]
struct FrameJson {
    sequence: u64,
    now_ms: u64,
    #[serde(default)]
    page: Option<Value>,
    #[serde(default)]
    changes: Vec<PageChange>,
}

/// A reader's page, put together from frames.
#[derive(Debug, Default)]
pub struct PageReader {
    sequence: u64,
    now_ms: u64,
    page: Value,
}

impl PageReader {
    /// Takes a frame; gives its number.
    ///
    /// # Errors
    /// When it is no frame, or its changes are those of another page. The page is then the one before.
    pub fn take(&mut self, text: &str) -> Result<u64, PageFrameError> {
        let frame: FrameJson =
            serde_json::from_str(text).map_err(|error| PageFrameError::NotAFrame(error.to_string()))?;
        let page = match frame.page {
            Some(page) => page,
            None if self.sequence + 1 == frame.sequence => {
                let mut page = self.page.clone();
                frame.changes.into_iter().try_for_each(|change| change.apply(&mut page))?;
                page
            }
            None => {
                return Err(PageFrameError::Missed { expected: frame.sequence.saturating_sub(1), is: self.sequence });
            }
        };
        *self = PageReader { sequence: frame.sequence, now_ms: frame.now_ms, page };
        Ok(self.sequence)
    }

    /// The page as JSON; null before the first frame.
    pub fn page(&self) -> &Value {
        &self.page
    }

    /// When its frame was made, in ms since the begin of the console.
    pub fn now_ms(&self) -> u64 {
        self.now_ms
    }
}
