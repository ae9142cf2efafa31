//! Problems in a file: place, and advice.
//!
//! A reader finds places as byte ranges. It reports each [`Problem`] to a [`Report`], which becomes [`Problems`] with lines
//! and columns at the end; `miette` draws them. It handles text of any format.
//!
//! Files come in two sizes. A description that people wrote is kept whole, so that a drawing can show several places of it
//! ([`Report::default`]). What a program wrote may be many megabytes in one line: of that only the few lines around each
//! problem are kept ([`Report::of_excerpts`]).

mod excerpt;
mod place;
mod problem;
mod problems;
mod report;

pub use place::At;
pub use problem::Problem;
pub use problems::Problems;
pub use report::{EXCERPTS_MAX, Report};

/// Foreign text in a message: short, and in one line.
pub fn shown(text: &str) -> String {
    const CHARS_MAX: usize = 60;
    let mut short: String = text.chars().take(CHARS_MAX).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(CHARS_MAX).is_some() {
        short.push('…');
    }
    short
}
