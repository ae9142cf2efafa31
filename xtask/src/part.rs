//! One program started, its lines passed on as they come.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::{Sender, channel};
use std::thread;

/// Output stream of a program that a line came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// Standard output.
    Out,
    /// Standard error.
    Err,
}

/// `cargo` with these arguments, the same cargo that started us.
pub fn cargo(root: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root).args(args);
    command
}

/// Runs a program, hands every line of it to `each`, and gives its exit code; `None` if it did not start or was killed.
///
/// # Errors
/// When it cannot be started.
pub fn lines(mut command: Command, mut each: impl FnMut(Stream, &str)) -> std::io::Result<Option<i32>> {
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let (sender, receiver) = channel();
    let out = child.stdout.take().map(|pipe| pass_on(Stream::Out, pipe, sender.clone()));
    let err = child.stderr.take().map(|pipe| pass_on(Stream::Err, pipe, sender));
    for (stream, line) in receiver {
        each(stream, &line);
    }
    for reader in [out, err].into_iter().flatten() {
        // A reader that panicked has lost lines of output, nothing else.
        let _ = reader.join();
    }
    Ok(child.wait()?.code())
}

fn pass_on(stream: Stream, pipe: impl Read + Send + 'static, to: Sender<(Stream, String)>) -> thread::JoinHandle<()> {
    thread::spawn(move || {
        let mut pipe = BufReader::new(pipe);
        let mut line = Vec::new();
        // Not `lines()`: a program may print what is not UTF-8.
        while pipe.read_until(b'\n', &mut line).is_ok_and(|read| read > 0) {
            let text = String::from_utf8_lossy(&line).trim_end().to_owned();
            if to.send((stream, text)).is_err() {
                return;
            }
            line.clear();
        }
    })
}
