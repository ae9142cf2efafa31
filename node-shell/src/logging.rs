//! Logging to stderr, and to [`/rosout`](crate::Rosout).
//!
//! Nothing here waits for the reader of the log, nor ends when it cannot be written (see [`LossyWriter`]); a panic's
//! message goes the same way.
//!
//! `--log-level` wins over `RUST_LOG`; without either, this project logs normal events and the DDS library only its
//! errors (it warns about kernel buffer sizes at every start).

use crate::LogLevel;
use crate::lossy::LossyWriter;
use crate::rosout::RosoutLayer;
use std::backtrace::{Backtrace, BacktraceStatus};
use std::fmt::Arguments;
use std::io::{self, IsTerminal, Write};
use std::sync::{LazyLock, OnceLock};
use std::time::Duration;
use thiserror::Error;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, reload};

/// Why logging was not set up.
#[derive(Debug, Error)]
pub enum LoggingError {
    /// `RUST_LOG` cannot be read.
    #[error("RUST_LOG: {0}")]
    Filter(#[from] tracing_subscriber::filter::ParseError),
    /// The operating system gives no thread for it.
    #[error("no thread for the log: {0}")]
    Thread(String),
    /// Logging has been set up already.
    #[error("logging is set up already: {0}")]
    Twice(Box<dyn std::error::Error + Send + Sync>),
}

/// Standard error of this process.
static STDERR: LazyLock<io::Result<LossyWriter>> = LazyLock::new(|| LossyWriter::start(io::stderr()));

/// Most time that the end of a process may wait for its log.
const FLUSH_WITHIN: Duration = Duration::from_millis(500);

/// Puts another filter into force.
type Reload = Box<dyn Fn(EnvFilter) + Send + Sync>;

/// Replaces the filter in force; set when logging is started.
static RELOAD: OnceLock<Reload> = OnceLock::new();

/// The text of `RUST_LOG`, if it decides: it is not empty, and no level is given.
fn filter_of_environment(level: Option<LogLevel>) -> Option<String> {
    std::env::var("RUST_LOG").ok().filter(|text| level.is_none() && !text.is_empty())
}

/// Name of the log level that this process starts with; `RUST_LOG` where the filter of that variable decides.
pub fn level_at_start(level: Option<LogLevel>) -> &'static str {
    match filter_of_environment(level) {
        Some(_) => "RUST_LOG",
        None => level.unwrap_or(LogLevel::Info).name(),
    }
}

/// Logs with another level from now on, in the whole process. Without effect before logging is started.
pub fn set_log_level(level: LogLevel) {
    if let (Some(reload), Ok(filter)) = (RELOAD.get(), EnvFilter::try_new(directives(level))) {
        reload(filter);
    }
}

/// Starts logging for this process. Call [`flush_stderr`] before it ends.
pub fn init(level: Option<LogLevel>) -> Result<(), LoggingError> {
    let filter = match filter_of_environment(level) {
        Some(text) => EnvFilter::try_new(text)?,
        None => EnvFilter::try_new(directives(level.unwrap_or(LogLevel::Info)))?,
    };
    let log = STDERR.as_ref().map_err(|error| LoggingError::Thread(error.to_string()))?;
    let (filter, handle) = reload::Layer::new(filter);
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(log.clone())
        // A log file has no colours.
        .with_ansi(io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()))
        // Errors of its own it prints to stderr, and panics where that cannot be written.
        .log_internal_errors(false)
        .with_target(false);
    let subscriber = tracing_subscriber::registry().with(filter).with(lines).with(RosoutLayer);
    subscriber.try_init().map_err(|error| LoggingError::Twice(error.into()))?;
    let reload = move |filter| {
        if let Err(error) = handle.reload(filter) {
            tracing::warn!("the log level stays: {error}");
        }
    };
    // The first one: logging is not set up twice.
    let _ = RELOAD.set(Box::new(reload));
    std::panic::set_hook(Box::new(|panic| {
        let trace = Backtrace::capture();
        if trace.status() == BacktraceStatus::Captured {
            tracing::error!("{panic}\n{trace}");
        } else {
            tracing::error!("{panic}");
        }
    }));
    Ok(())
}

/// Writes a line to standard error, in order with the log, without waiting for its reader; one that cannot be written is
/// dropped. Instead of `eprintln!`, which panics then.
pub fn stderr_line(text: Arguments<'_>) {
    match &*STDERR {
        Ok(log) => log.line(format!("{text}\n").into_bytes()),
        Err(_) => drop(writeln!(io::stderr(), "{text}")),
    }
}

/// Waits a moment for what goes to standard error to be written: before the process ends.
pub fn flush_stderr() {
    if let Ok(log) = &*STDERR {
        log.flush(FLUSH_WITHIN);
    }
}

fn directives(level: LogLevel) -> String {
    let (ours, theirs) = match level {
        LogLevel::Debug => ("debug", "warn"),
        LogLevel::Info => ("info", "error"),
        LogLevel::Warn => ("warn", "error"),
        LogLevel::Error | LogLevel::Fatal => ("error", "error"),
    };
    // At an orderly end the DDS library reports its own threads gone before its readers, some twenty errors a node.
    let orderly_end = match level {
        LogLevel::Debug => "",
        LogLevel::Info | LogLevel::Warn | LogLevel::Error | LogLevel::Fatal => {
            ",rustdds::network::udp_listener=off,rustdds::dds::pubsub=off"
        }
    };
    // Ours are the crates whose names begin with `linewright`.
    format!("{theirs},linewright={ours}{orderly_end}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_is_a_filter() {
        for level in [LogLevel::Debug, LogLevel::Info, LogLevel::Warn, LogLevel::Error, LogLevel::Fatal] {
            assert!(EnvFilter::try_new(directives(level)).is_ok(), "{level:?}");
        }
    }
}
