//! Lines for an output that may be slow, full or gone.
//!
//! A controller must not wait for the reader of its log, and must not end because a disk is full. Lines go through a
//! bounded queue to a thread that writes them. A line that finds the queue full, or that the output refuses, is dropped and
//! counted; the next line that can be written is preceded by that count. (`tracing-appender` has such a thread, but prints
//! at its end when the queue is full, which waits for the same reader, and its log does not show that lines are missing.)

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use tracing_subscriber::fmt::MakeWriter;

/// Lines the queue holds: a burst of a few seconds of a node that logs every event.
const QUEUE: usize = 1024;
/// Period of retries to put the last request into a full queue.
const RETRY: Duration = Duration::from_millis(5);

enum QueuedLine {
    Line(Vec<u8>),
    /// Everything before it is written.
    Flush(SyncSender<()>),
}

/// Writes without waiting. Clones share the queue.
#[derive(Clone, Debug)]
pub struct LossyWriter {
    queue: SyncSender<QueuedLine>,
    dropped: Arc<AtomicU64>,
}

impl LossyWriter {
    /// Starts the thread that writes to `output`.
    ///
    /// # Errors
    /// When the operating system gives no thread.
    pub fn start(output: impl Write + Send + 'static) -> io::Result<Self> {
        let (queue, items) = sync_channel(QUEUE);
        let dropped = Arc::new(AtomicU64::new(0));
        let count = Arc::clone(&dropped);
        thread::Builder::new().name("log".to_owned()).spawn(move || write_all(output, &items, &count))?;
        Ok(LossyWriter { queue, dropped })
    }

    /// Hands over one line, which ends with its line feed, or drops it.
    pub fn line(&self, line: Vec<u8>) {
        if self.queue.try_send(QueuedLine::Line(line)).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Lines dropped and not yet reported in the output.
    #[cfg(test)]
    fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Waits until all lines so far are written, at most this long: for the end of a process.
    pub fn flush(&self, at_most: Duration) {
        let until = Instant::now() + at_most;
        let (done, is_done) = sync_channel(1);
        while self.queue.try_send(QueuedLine::Flush(done.clone())).is_err() {
            if Instant::now() >= until {
                return;
            }
            thread::sleep(RETRY);
        }
        let _ = is_done.recv_timeout(until.saturating_duration_since(Instant::now()));
    }
}

fn write_all(mut output: impl Write, items: &Receiver<QueuedLine>, dropped: &AtomicU64) {
    while let Ok(item) = items.recv() {
        match item {
            QueuedLine::Line(line) => {
                if !report(&mut output, dropped) || output.write_all(&line).is_err() {
                    dropped.fetch_add(1, Ordering::Relaxed);
                }
            }
            QueuedLine::Flush(done) => {
                report(&mut output, dropped);
                let _ = output.flush();
                let _ = done.try_send(());
            }
        }
    }
}

/// Writes how many lines are missing here, if some are; false when the output refuses that too.
fn report(output: &mut impl Write, dropped: &AtomicU64) -> bool {
    let missing = dropped.load(Ordering::Relaxed);
    if missing == 0 {
        return true;
    }
    if writeln!(output, "({missing} log lines dropped: output too slow or not writable)").is_err() {
        return false;
    }
    dropped.fetch_sub(missing, Ordering::Relaxed);
    true
}

/// One event of the log: gathered, and handed over as one line when it is complete.
#[derive(Debug)]
pub struct LossyLine {
    to: LossyWriter,
    bytes: Vec<u8>,
}

impl Write for LossyLine {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for LossyLine {
    fn drop(&mut self) {
        if !self.bytes.is_empty() {
            self.to.line(std::mem::take(&mut self.bytes));
        }
    }
}

impl<'a> MakeWriter<'a> for LossyWriter {
    type Writer = LossyLine;

    fn make_writer(&'a self) -> Self::Writer {
        LossyLine { to: self.clone(), bytes: Vec::new() }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead, BufReader, pipe};

    use super::*;

    const LONG: Duration = Duration::from_secs(10);

    #[test]
    fn lines_of_an_output_that_is_not_read_are_dropped_and_counted_and_the_writer_never_waits() {
        let (reader, output) = pipe().expect("a pipe");
        let log = LossyWriter::start(output).expect("a thread");
        // A pipe holds 64 KiB, the queue its lines; the rest is more than both.
        let line = [b"x".repeat(1023), b"\n".to_vec()].concat();
        let sent = 4 * QUEUE;
        (0..sent).for_each(|_| log.line(line.clone()));
        assert!(log.dropped() > 0);
        log.flush(Duration::from_millis(20));
        let mut lines = BufReader::new(reader).lines().map(|line| line.expect("text"));
        let (mut read, mut missing) = (0, 0);
        while read + missing < sent {
            let line = lines.next().expect("a line");
            match line.strip_prefix('(') {
                Some(report) => {
                    missing += report.split(' ').next().and_then(|n| n.parse::<usize>().ok()).expect("a count")
                }
                None => read += 1,
            }
            // The report comes with the next line.
            if read + missing + usize::try_from(log.dropped()).expect("few") == sent && log.dropped() > 0 {
                log.flush(LONG);
            }
        }
        assert_eq!((read + missing, log.dropped()), (sent, 0));
    }

    #[test]
    fn an_output_that_refuses_everything_costs_lines_only() {
        let full = std::fs::File::options().write(true).open("/dev/full").expect("Linux has it");
        let log = LossyWriter::start(full).expect("a thread");
        (0..3).for_each(|_| log.line(b"a line\n".to_vec()));
        log.flush(LONG);
        assert_eq!(log.dropped(), 3);
    }

    #[test]
    fn an_event_that_is_written_in_pieces_is_one_line() {
        let (reader, output) = pipe().expect("a pipe");
        let log = LossyWriter::start(output).expect("a thread");
        let mut event = log.make_writer();
        write!(event, "one ").expect("it takes all");
        log.line(b"first\n".to_vec());
        writeln!(event, "line").expect("it takes all");
        drop(event);
        log.flush(LONG);
        drop(log);
        let lines: Vec<String> = BufReader::new(reader).lines().map(|line| line.expect("text")).collect();
        assert_eq!(lines, ["first", "one line"]);
    }
}
