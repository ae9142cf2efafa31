//! `/rosout`: the log of this process as messages, so that the tools of ROS 2 show it beside that of other nodes.
//!
//! A line goes to stderr and here, by the same level. Nothing here waits: lines go through a bounded queue to a task that publishes them,
//! so many a second; what finds no room, or comes faster, is left out, counted, and reported with the next line. What the middleware logs about
//! itself is left out, since a line about the publication of lines would cause another one.

use std::fmt::{self, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, Instant};

use linewright_msgs::{Log, Time, fitting};
use tokio::sync::mpsc::{self, Receiver, Sender};
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::layer::Context;

use crate::subscription::Forward;
use crate::{Publisher, RosNode, TopicError, names, qos, stamp};

/// Lines that wait to be published.
const QUEUE: usize = 256;
/// Lines published at once after a silence, of warnings and errors and of the others each.
const BURST: u32 = 100;
/// Time in which one more line may be published. A reader that is killed is waited for up to 50 s, and up to 8192 lines of both kinds
/// together ([`qos`]).
const LINE_EVERY: Duration = Duration::from_millis(50);

/// Beginning of the names of this project's crates, as the filter of the log has it.
const OURS: &str = "linewright";

/// A line on its way.
#[derive(Debug)]
struct LoggedLine {
    stamp: Time,
    level: Level,
    text: String,
    file: &'static str,
    line: u32,
}

/// Where the lines of a node go.
#[derive(Clone, Debug)]
struct LineQueue {
    /// Base name of the node.
    node: String,
    to: Sender<LoggedLine>,
    left_out: Arc<AtomicU64>,
}

/// The nodes of this process whose lines are published.
static QUEUES: RwLock<Vec<LineQueue>> = RwLock::new(Vec::new());

/// The log of a node as messages. Dropping this ends it.
pub struct Rosout {
    left_out: Arc<AtomicU64>,
    task: Forward,
}

impl Rosout {
    /// Opens the topic. From now on lines of the process that name this node, and where it is the first node of the process all that name none,
    /// are published. Must be called inside a tokio runtime.
    ///
    /// # Errors
    /// When the middleware refuses the topic.
    pub fn open(node: &mut RosNode) -> Result<Self, TopicError> {
        let publisher = node.publisher::<Log>("/rosout", qos::log())?;
        let name = names::expand(node.name(), node.namespace(), node.name())?;
        let logger = name.trim_start_matches('/').replace('/', ".");
        let (to, from) = mpsc::channel(QUEUE);
        let left_out = Arc::new(AtomicU64::new(0));
        let queue = LineQueue { node: node.name().to_owned(), to, left_out: Arc::clone(&left_out) };
        QUEUES.write().unwrap_or_else(PoisonError::into_inner).push(queue);
        let count = Arc::clone(&left_out);
        Ok(Rosout { left_out, task: Forward::spawn(publish_all(publisher, logger, from, count)) })
    }

    /// Its task has ended; the middleware has failed.
    pub fn is_failed(&self) -> bool {
        self.task.is_finished()
    }
}

impl Drop for Rosout {
    fn drop(&mut self) {
        let mut queues = QUEUES.write().unwrap_or_else(PoisonError::into_inner);
        queues.retain(|queue| !Arc::ptr_eq(&queue.left_out, &self.left_out));
    }
}

/// A budget of lines that fills up with time.
#[derive(Clone, Copy, Debug)]
struct LineBudget {
    lines: u32,
    filled: Instant,
}

impl LineBudget {
    fn new(now: Instant) -> Self {
        LineBudget { lines: BURST, filled: now }
    }

    /// Whether one more line may be published.
    fn take(&mut self, now: Instant) -> bool {
        let periods = now.saturating_duration_since(self.filled).as_millis() / LINE_EVERY.as_millis();
        let periods = u32::try_from(periods).unwrap_or(u32::MAX);
        if periods >= BURST {
            *self = LineBudget::new(now);
        } else {
            self.lines = (self.lines + periods).min(BURST);
            self.filled += LINE_EVERY * periods;
        }
        let has_room = self.lines > 0;
        self.lines = self.lines.saturating_sub(1);
        has_room
    }
}

async fn publish_all(
    publisher: Publisher<Log>,
    logger: String,
    mut from: Receiver<LoggedLine>,
    left_out: Arc<AtomicU64>,
) {
    let now = Instant::now();
    // A flood of news leaves room for what is wrong.
    let (mut news, mut warnings) = (LineBudget::new(now), LineBudget::new(now));
    while let Some(line) = from.recv().await {
        let budget = if line.level <= Level::WARN { &mut warnings } else { &mut news };
        if !budget.take(Instant::now()) {
            left_out.fetch_add(1, Ordering::Relaxed);
            continue;
        }
        let missing = left_out.swap(0, Ordering::Relaxed);
        // Not by `send`: what fails here is not logged, as that would be a line as well.
        if publisher.try_send(message(line, logger.clone(), missing)).is_err() {
            left_out.fetch_add(missing + 1, Ordering::Relaxed);
        }
        tokio::task::yield_now().await;
    }
}

fn message(line: LoggedLine, name: String, missing: u64) -> Log {
    let LoggedLine { stamp, level, mut text, file, line } = line;
    if missing > 0 {
        let _ = write!(text, " ({missing} lines before this one left out)");
    }
    let level = match level {
        Level::ERROR => Log::ERROR,
        Level::WARN => Log::WARN,
        Level::INFO => Log::INFO,
        Level::DEBUG | Level::TRACE => Log::DEBUG,
    };
    Log { stamp, level: level.0, name, msg: fitting(text), file: file.to_owned(), function: String::new(), line }
}

/// Takes the lines of the process.
pub(crate) struct RosoutLayer;

impl<S: Subscriber> Layer<S> for RosoutLayer {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let of = event.metadata();
        if !of.target().starts_with(OURS) {
            return;
        }
        let queues = QUEUES.read().unwrap_or_else(PoisonError::into_inner);
        if queues.is_empty() {
            return;
        }
        let mut words = LineWords::default();
        event.record(&mut words);
        let named = queues.iter().find(|queue| words.node.as_deref() == Some(&*queue.node));
        let Some(queue) = named.or_else(|| queues.first()) else { return };
        let line = LoggedLine {
            stamp: stamp().stamp,
            level: *of.level(),
            text: words.text,
            file: of.file().unwrap_or_default(),
            line: of.line().unwrap_or(0),
        };
        if queue.to.try_send(line).is_err() {
            queue.left_out.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// The fields of a line: its message, then the others as `name=value`.
#[derive(Default)]
struct LineWords {
    text: String,
    /// The node that the line is about: a station's name, or an absolute name.
    node: Option<String>,
}

impl Visit for LineWords {
    fn record_str(&mut self, field: &Field, value: &str) {
        if ["station", "node"].contains(&field.name()) {
            self.node = Some(value.rsplit('/').next().unwrap_or(value).to_owned());
        }
        self.record_debug(field, &format_args!("{value}"));
    }

    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        if field.name() == "message" {
            let rest = std::mem::take(&mut self.text);
            let _ = write!(self.text, "{value:?}{rest}");
        } else {
            let _ = write!(self.text, " {}={value:?}", field.name());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_is_cut_to_a_rate_and_a_silence_makes_room_again() {
        let begun = Instant::now();
        let mut budget = LineBudget::new(begun);
        let taken = |budget: &mut LineBudget, at: Duration, lines: usize| {
            (0..lines).filter(|_| budget.take(begun + at)).count()
        };
        assert_eq!(taken(&mut budget, Duration::ZERO, 1000), 100);
        assert_eq!(taken(&mut budget, Duration::from_millis(49), 1000), 0);
        assert_eq!(taken(&mut budget, Duration::from_secs(1), 1000), 20);
        assert_eq!(taken(&mut budget, Duration::from_secs(3600), 1000), 100);
    }

    #[test]
    fn a_line_has_its_fields_and_what_is_missing_before_it() {
        let line = LoggedLine {
            stamp: Time { sec: 1, nanosec: 2 },
            level: Level::WARN,
            text: "not sent failed=3".to_owned(),
            file: "a.rs",
            line: 7,
        };
        let sent = message(line, "transfer_line.mill_1".to_owned(), 2);
        assert_eq!((sent.level, sent.name.as_str(), sent.line), (Log::WARN.0, "transfer_line.mill_1", 7));
        assert_eq!(sent.msg, "not sent failed=3 (2 lines before this one left out)");
    }
}
