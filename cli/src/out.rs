//! Writing to standard output and standard error, which may be a pipe that somebody has closed, or a full disk.

use std::io::Write;

use miette::IntoDiagnostic;

/// Writes a line; false when nobody reads any more (`linewright candump | head`), which is no error.
pub fn line(text: std::fmt::Arguments<'_>) -> bool {
    writeln!(std::io::stdout().lock(), "{text}").is_ok()
}

/// Prints what `--json` asks for: one object over several lines.
pub fn json(object: &impl serde::Serialize) -> miette::Result<()> {
    line(format_args!("{}", serde_json::to_string_pretty(object).into_diagnostic()?));
    Ok(())
}

/// `println!` for this program: a closed pipe does not end it in a panic.
macro_rules! say {
    ($($text:tt)*) => {{
        let _ = $crate::out::line(format_args!($($text)*));
    }};
}
pub(crate) use say;

/// `eprintln!` for this program: an output that is closed, full or not read neither ends it nor holds it up.
macro_rules! complain {
    ($($text:tt)*) => { linewright_node_shell::stderr_line(format_args!($($text)*)) };
}
pub(crate) use complain;
