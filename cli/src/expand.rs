//! `linewright expand`: the description of a line with every station of a type written out, to be read or kept.

use std::path::PathBuf;
use std::process::ExitCode;

use crate::files::description;
use crate::load;

/// Print the description of a line with every station of a type written out.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The directory of a line, or its description file.
    line: PathBuf,
}

/// `linewright expand`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let file = load::file_of(&args.line);
    let text = description(&file)?;
    let out = linewright_line::expand(&file.display().to_string(), &text).map_err(miette::Report::new)?;
    crate::out::bytes(out.as_bytes());
    Ok(ExitCode::SUCCESS)
}
