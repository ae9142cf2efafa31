//! Writing to standard output and standard error, which may be a closed pipe or a full disk.

use std::io::{self, ErrorKind, Write};
use std::sync::OnceLock;

use miette::IntoDiagnostic;

/// The first error of standard output, other than a closed pipe.
static FAILED: OnceLock<String> = OnceLock::new();

fn written(result: io::Result<()>) -> bool {
    if let Err(error) = &result
        && error.kind() != ErrorKind::BrokenPipe
    {
        FAILED.get_or_init(|| error.to_string());
    }
    result.is_ok()
}

/// Writes a line; false when it could not be written. A reader that has gone (`linewright candump | head`) is no error; any
/// other cause is an error of the command, see [`finish`].
pub fn line(text: std::fmt::Arguments<'_>) -> bool {
    written(writeln!(io::stdout().lock(), "{text}"))
}

/// Writes bytes; errors as with [`line()`].
pub fn bytes(bytes: &[u8]) {
    written(io::stdout().lock().write_all(bytes));
}

/// Writes the rest, at the end of the command.
///
/// # Errors
/// Why not everything could be written.
pub fn finish() -> Result<(), String> {
    written(io::stdout().lock().flush());
    FAILED.get().map_or(Ok(()), |why| Err(why.clone()))
}

/// Prints the output of `--json`: one object over several lines.
pub fn json(object: &impl serde::Serialize) -> miette::Result<()> {
    line(format_args!("{}", serde_json::to_string_pretty(object).into_diagnostic()?));
    Ok(())
}

/// A word as a shell reads it: quoted where it has blanks or what a shell acts on.
pub fn shell_word(word: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "_-./:=@%+,".contains(letter);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    let escaped = |letter: char| match letter {
        '"' | '$' | '`' | '\\' => format!("\\{letter}"),
        letter => letter.to_string(),
    };
    format!("\"{}\"", word.chars().map(escaped).collect::<String>())
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
