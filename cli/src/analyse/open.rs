//! A net from a file, and what is wrong with the file as JSON.

use std::path::Path;

use linewright_nets::Net;
use linewright_pnml::{Problems, limits};
use miette::{IntoDiagnostic, WrapErr, miette};
use serde_json::{Value, json};

/// Reads the net of a file, or the one with the id `wanted`.
pub fn net(file: &Path, wanted: Option<&str>) -> miette::Result<Net> {
    let name = file.display().to_string();
    let size = std::fs::metadata(file).into_diagnostic().wrap_err_with(|| format!("cannot read {name}"))?.len();
    if size > limits::FILE_BYTES_MAX as u64 {
        let most = limits::FILE_BYTES_MAX;
        return Err(miette!("{name} has {size} bytes; at most {most} are read. Is this the right file?"));
    }
    let bytes = std::fs::read(file).into_diagnostic().wrap_err_with(|| format!("cannot read {name}"))?;
    linewright_pnml::read(&name, &bytes, wanted).map_err(miette::Report::new)
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
