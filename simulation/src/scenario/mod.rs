//! A scenario as text: actions of people and faults on a line, and the expected results.
//!
//! TOML, read like a line description: all problems at once, each with its place and advice, and the names of the line
//! checked while reading. What comes out is a [`Script`], which has no text.

pub(crate) mod faults;
mod read;
mod vocabulary;

use linewright_line::{Line, Problem, Problems};
use linewright_text::Report;

use crate::options::Network;
use crate::script::Script;

#[derive(Clone, Debug)]
pub struct Scenario {
    pub title: Option<String>,
    /// Number of cycles to run, where given.
    pub cycles: Option<usize>,
    /// Start and auto are given first.
    pub starts: bool,
    /// Largest deviation of a motion's duration, as a fraction.
    pub variation: f64,
    pub network: Network,
    /// The steps.
    pub script: Script,
    file_name: String,
    text: String,
}

impl Scenario {
    /// Reads the scenario `text` for `line`; `file_name` is for messages.
    ///
    /// # Errors
    /// All problems of the text at once, each with its place.
    pub fn parse(line: &Line, file_name: &str, text: &str) -> Result<Self, Problems> {
        let mut report = Report::default();
        let is_bounded = linewright_text::is_bounded(text, "the scenario", &mut report);
        let scenario = if is_bounded { read::scenario(line, text, &mut report) } else { None };
        let (scenario, _) = report.close(scenario, file_name, text)?;
        Ok(Scenario { file_name: file_name.to_owned(), text: text.to_owned(), ..scenario })
    }

    /// The place of a step that failed, from 0, with the reason.
    pub fn failed_at(&self, step: usize, why: &str) -> Option<Problems> {
        let span = self.script.steps.get(step)?.span.clone();
        let problem = Problem::error(span, format!("this step failed: {why}")).label("here");
        Some(Problems::new(&self.file_name, &self.text, vec![problem]))
    }
}
