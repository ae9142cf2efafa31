//! A net from a file, and what is wrong with the file as JSON.

use std::path::Path;

use linewright_nets::Net;
use linewright_pnml::{Problems, limits};
use miette::miette;
use serde_json::{Value, json};

use crate::files;

/// Reads the net of a file, or the one with the id `wanted`.
pub fn net(file: &Path, wanted: Option<&str>) -> miette::Result<Net> {
    if file.is_dir() {
        let dir = crate::out::shell_word(&file.display().to_string());
        return Err(miette!(
            help = format!(
                "the nets of a line or cell: `linewright nets {dir} --out NETS` writes them, `linewright analyse NETS/FILE.pnml` analyses one"
            ),
            "{dir} is a directory, and a net in PNML is a file"
        ));
    }
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
