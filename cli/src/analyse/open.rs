//! A net from a file, and what is wrong with the file as JSON.

use std::path::Path;

use linewright_nets::Net;
use linewright_pnml::{Problems, limits};
use serde_json::{Value, json};

use crate::files;

/// Reads the net of a file, or the one with the id `wanted`.
pub fn net(file: &Path, wanted: Option<&str>) -> miette::Result<Net> {
    let bytes = files::bytes(file, limits::FILE_BYTES_MAX, "a net in PNML")?;
    linewright_pnml::read(&file.display().to_string(), &bytes, wanted).map_err(miette::Report::new)
}

/// The problems of a file that holds no net that could be read.
pub fn problems(error: &miette::Report) -> Value {
    let list = match error.downcast_ref::<Problems>() {
        Some(problems) => problems
            .iter()
            .map(|p| json!({ "line": p.line, "column": p.column, "message": p.message, "help": p.hint }))
            .collect(),
        None => vec![json!({ "line": null, "column": null, "message": format!("{error:#}"), "help": null })],
    };
    json!({ "problems": list })
}
