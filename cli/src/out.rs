//! Writing to standard output and standard error, which may be a pipe that somebody has closed, or a full disk.

use std::io::Write;

/// Writes a line; false when nobody reads any more (`linewright candump | head`), which is no error.
pub fn line(text: std::fmt::Arguments<'_>) -> bool {
    writeln!(std::io::stdout().lock(), "{text}").is_ok()
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
