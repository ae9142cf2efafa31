//! What is wrong with a file that other programs wrote: where, and what to do about it.
//!
//! A reader finds places as byte ranges ([`Finding`] at [`At`]), collects them in a [`Report`], and turns that into
//! [`Problems`] with lines and columns at the end. `miette` draws them.
//!
//! It knows text and no format. The drawings look like those of a line description's problems, which are of another
//! crate because descriptions are written by people: there the whole text is kept, here the few lines around each
//! problem, since a program may write many megabytes as one line.

mod excerpt;
mod problem;

pub use problem::{At, Finding, PROBLEMS_MAX, Problem, Problems, Report, shown};
