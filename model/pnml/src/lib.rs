//! Petri nets as PNML, the exchange format of ISO/IEC 15909-2: read, with errors that have a position, and written.
//!
//! [`read`] takes the files that tools write, which is more than the standard allows, and refuses what would make the
//! net it returns another one than the file means: an arc of an unknown kind, a capacity, a coloured label. [`write()`]
//! writes by the standard. The crate handles nets and text, no files, stations or lines.
//!
//! ```
//! use linewright_pnml::{read, write};
//!
//! let text = r#"<pnml><net id="clamp">
//!   <place id="open"><initialMarking><text>1</text></initialMarking></place>
//!   <place id="closed"/>
//!   <transition id="close"/>
//!   <arc id="a1" source="open" target="close"/>
//!   <arc id="a2" source="close" target="closed"/>
//! </net></pnml>"#;
//! let net = read("clamp.pnml", text.as_bytes(), None)?;
//! assert_eq!(net.describe(&net.initial_marking()), "open");
//! assert_eq!(read("again.pnml", write(&net).as_bytes(), None)?.to_string(), net.to_string());
//!
//! let wrong = text.replace("target=\"closed\"", "target=\"open \"");
//! let problems = read("clamp.pnml", wrong.as_bytes(), None).unwrap_err();
//! assert_eq!(
//!     format!("{problems:#}"),
//!     "clamp.pnml: 1 error\nclamp.pnml:6:39: the arc `a2` leads to `open `, which is no node of the net"
//! );
//! # Ok::<(), linewright_pnml::Problems>(())
//! ```
//!
//! # How a file is read
//! 1. `decode`: bytes → text
//! 2. `survey`: is it XML, and which nets are there?
//! 3. `draft`: one net's elements, with their places in the text, as they stand
//! 4. `resolve`: what refers to what? → [`linewright_nets::Net`]
//!
//! The first two stop at the first mistake, because nothing after it can be trusted; the others go on and report all.

mod decode;
mod draft;
mod kinds;
mod label;
pub mod limits;
mod resolve;
mod survey;
mod write;
mod xml;

pub use linewright_diagnostics::{Problem, Problems};
pub use write::write;

use linewright_diagnostics::Report;
use linewright_nets::Net;

/// Reads a place/transition net. `file_name` is for messages; `net` is the id of the net to take, and may be absent if
/// there is only one.
///
/// Nodes are called by their names where those are unique, and by their ids where they are not.
///
/// # Errors
/// All problems of the file, up to [`limits::PROBLEMS_MAX`], each with its place.
pub fn read(file_name: &str, bytes: &[u8], net: Option<&str>) -> Result<Net, Problems> {
    let mut report = Report::of_excerpts();
    let text = match decode::decode(bytes, &mut report) {
        Ok(text) => text,
        Err(readable) => return Err(report.into_problems(file_name, readable)),
    };
    match understand(&text, net, &mut report) {
        Some(net) if !report.has_errors() => Ok(net),
        _ => Err(report.into_problems(file_name, &text)),
    }
}

fn understand(text: &str, wanted: Option<&str>, report: &mut Report) -> Option<Net> {
    let chosen = survey::choose(text, wanted, report)?;
    let draft = draft::read(text, chosen, report)?;
    resolve::resolve(draft, report)
}
