//! Logging to stderr.
//!
//! `--log-level` wins over `RUST_LOG`; without either, this project logs what happens and the DDS
//! library only its errors (it warns about kernel buffer sizes at every start).

use crate::LogLevel;
use thiserror::Error;
use tracing_subscriber::EnvFilter;

/// Why logging was not set up.
#[derive(Debug, Error)]
pub enum LoggingError {
    /// `RUST_LOG` cannot be read.
    #[error("RUST_LOG: {0}")]
    Filter(#[from] tracing_subscriber::filter::ParseError),
    /// Somebody else has set up logging already.
    #[error("logging is set up already: {0}")]
    Twice(Box<dyn std::error::Error + Send + Sync>),
}

/// Starts logging for this process.
pub fn init(level: Option<LogLevel>) -> Result<(), LoggingError> {
    let filter = match (level, std::env::var("RUST_LOG")) {
        (None, Ok(text)) if !text.is_empty() => EnvFilter::try_new(text)?,
        (level, _) => EnvFilter::try_new(directives(level.unwrap_or(LogLevel::Info)))?,
    };
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_target(false)
        .try_init()
        .map_err(LoggingError::Twice)
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
    format!("{ours},rustdds={theirs},ros2_client={theirs}{orderly_end}")
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
