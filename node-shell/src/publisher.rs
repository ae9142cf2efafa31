//! Sending without waiting.
//!
//! A controller's step must take the same time whatever its readers do. The library hands the sample to its own thread;
//! failures are counted, and logged at 1, 2, 4, 8 … of them so that a broken reader fills no disk.

use linewright_msgs::RosMessage;
use ros2_client::WriteError;
use std::sync::atomic::{AtomicU64, Ordering};
use thiserror::Error;

/// Why a message was not sent.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SendError {
    /// Some reliable reader has not acknowledged thousands of messages; it is most likely dead.
    #[error("{topic}: the send window is full, a reader has stopped acknowledging")]
    WindowFull { topic: String },
    /// Any other error of the middleware.
    #[error("{topic}: {reason}")]
    Middleware {
        topic: String,
        /// The middleware's text.
        reason: String,
    },
}

/// Messages that no publisher of this process could send.
static UNSENT: AtomicU64 = AtomicU64::new(0);

/// Messages that the publishers of this process could not send, of all its nodes.
pub fn unsent_messages() -> u64 {
    UNSENT.load(Ordering::Relaxed)
}

/// Sends messages of one type to one topic.
pub struct Publisher<T: RosMessage> {
    inner: ros2_client::Publisher<T>,
    topic: String,
    sent: AtomicU64,
    failed: AtomicU64,
}

impl<T: RosMessage> Publisher<T> {
    pub(crate) fn new(inner: ros2_client::Publisher<T>, topic: String) -> Self {
        Self { inner, topic, sent: AtomicU64::new(0), failed: AtomicU64::new(0) }
    }

    /// Sends, or counts and logs why not. Never waits.
    pub fn send(&self, message: T) {
        if let Err(error) = self.try_send(message) {
            let failed = self.failed();
            if failed.is_power_of_two() {
                tracing::warn!(failed, "not sent: {error}");
            }
        }
    }

    /// Sends, or gives the error. Never waits; failures are counted here as well.
    pub fn try_send(&self, message: T) -> Result<(), SendError> {
        match self.inner.publish(message) {
            Ok(()) => {
                self.sent.fetch_add(1, Ordering::Relaxed);
                Ok(())
            }
            Err(error) => {
                self.failed.fetch_add(1, Ordering::Relaxed);
                UNSENT.fetch_add(1, Ordering::Relaxed);
                Err(match error {
                    WriteError::WouldBlock { .. } => SendError::WindowFull { topic: self.topic.clone() },
                    other => SendError::Middleware { topic: self.topic.clone(), reason: other.to_string() },
                })
            }
        }
    }

    /// The topic's absolute name.
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// Messages handed to the middleware.
    pub fn sent(&self) -> u64 {
        self.sent.load(Ordering::Relaxed)
    }

    /// Messages that were not.
    pub fn failed(&self) -> u64 {
        self.failed.load(Ordering::Relaxed)
    }
}
