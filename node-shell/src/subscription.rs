//! Receiving, whatever is sent.
//!
//! A message that does not decode, or is [invalid](linewright_msgs::Invalid), is counted, reported and otherwise
//! dropped: any host on the network can send it, so it must not end anything. Only a middleware that has itself failed
//! ends a subscription.

use linewright_msgs::RosMessage;
use ros2_client::{MessageInfo, ReadError};
use thiserror::Error;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;

/// Source of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MessageSource {
    /// Global identity of the publisher: one per publisher and start of its process.
    pub publisher: [u8; 16],
    /// The middleware's number of the message within that publisher.
    pub sequence: i64,
    /// Time of sending by the publisher's clock, in nanoseconds since the Unix epoch.
    pub sent_ns: Option<i64>,
    /// Time of arrival here, in nanoseconds since the Unix epoch.
    pub received_ns: Option<i64>,
}

impl MessageSource {
    /// The participant (the process, in the rule) that the publisher belongs to: the prefix of its identity.
    pub fn participant(&self) -> [u8; 12] {
        participant_of(&self.publisher)
    }

    /// The publisher's identity as a number. Two publishers have the same one as seldom as two random numbers are equal.
    pub fn publisher_id(&self) -> u64 {
        // FNV-1a: every byte of the identity decides, whichever of them differ.
        let mix = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        self.publisher.iter().fold(0xcbf2_9ce4_8422_2325, mix)
    }
}

/// The participant of a publisher or client, by the first twelve of its sixteen bytes (DDSI-RTPS 2.5, 8.2.4.1, GUID prefix).
pub(crate) fn participant_of(identity: &[u8; 16]) -> [u8; 12] {
    let mut prefix = [0; 12];
    prefix.copy_from_slice(&identity[..12]);
    prefix
}

/// The subscription is over.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{topic}: the middleware failed: {reason}")]
pub struct RecvError {
    pub topic: String,
    /// The middleware's words.
    pub reason: String,
}

/// Receives messages of one type from one topic.
pub struct Subscription<T: RosMessage> {
    inner: ros2_client::Subscription<T>,
    topic: String,
    received: u64,
    rejected: u64,
}

impl<T: RosMessage> Subscription<T> {
    pub(crate) fn new(inner: ros2_client::Subscription<T>, topic: String) -> Self {
        Self { inner, topic, received: 0, rejected: 0 }
    }

    /// The next valid message. Cancel safe: nothing is lost when the future is dropped, so it may
    /// stand in a `select!`.
    pub async fn recv(&mut self) -> Result<(T, MessageSource), RecvError> {
        loop {
            match self.inner.async_take().await {
                Ok((message, info)) => match message.validate() {
                    Ok(()) => {
                        self.received += 1;
                        return Ok((message, source(&info)));
                    }
                    Err(invalid) => self.reject(&invalid),
                },
                Err(error @ (ReadError::Deserialization { .. } | ReadError::Malformed)) => self.reject(&error),
                Err(error) => return Err(RecvError { topic: self.topic.clone(), reason: error.to_string() }),
            }
            // A flood of rubbish must not keep the other tasks of this thread waiting. Nothing is held
            // here, so being cancelled at this point loses nothing.
            tokio::task::yield_now().await;
        }
    }

    /// The topic's absolute name.
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// Valid messages so far.
    pub fn received(&self) -> u64 {
        self.received
    }

    /// Messages that did not decode or were invalid.
    pub fn rejected(&self) -> u64 {
        self.rejected
    }

    fn reject(&mut self, why: &dyn std::fmt::Display) {
        self.rejected += 1;
        if self.rejected.is_power_of_two() {
            tracing::warn!(topic = self.topic, rejected = self.rejected, "ignored a message: {why}");
        }
    }
}

fn source(info: &MessageInfo) -> MessageSource {
    MessageSource {
        publisher: info.publisher_gid().to_bytes16(),
        sequence: info.sequence_number(),
        sent_ns: info.source_timestamp().map(|t| t.to_nanos()),
        received_ns: info.received_timestamp().map(|t| t.to_nanos()),
    }
}

/// A task that moves messages from a subscription into a channel. Dropping this ends it.
pub struct Forward {
    task: JoinHandle<()>,
}

impl Forward {
    pub(crate) fn spawn(work: impl Future<Output = ()> + Send + 'static) -> Self {
        Forward { task: tokio::spawn(work) }
    }

    /// Whether the task has ended: the channel's reader is gone, or the middleware failed.
    pub fn is_finished(&self) -> bool {
        self.task.is_finished()
    }

    /// Waits until the task has ended. Cancel safe.
    pub async fn finished(&mut self) {
        // A task's end is given once only.
        if !self.task.is_finished() {
            let _ = (&mut self.task).await;
        }
    }
}

impl Drop for Forward {
    fn drop(&mut self) {
        self.task.abort();
    }
}

/// Merges a subscription into `to`: each message is passed through `map`, and what comes out is sent.
/// Must be called inside a tokio runtime. When the channel is full this waits, and the middleware keeps
/// as much as the topic's history allows.
pub fn forward<T, U>(
    mut from: Subscription<T>,
    to: mpsc::Sender<U>,
    mut map: impl FnMut(T, MessageSource) -> Option<U> + Send + 'static,
) -> Forward
where
    T: RosMessage,
    U: Send + 'static,
{
    Forward::spawn(async move {
        loop {
            let received = tokio::select! {
                received = from.recv() => received,
                () = to.closed() => return,
            };
            match received {
                Ok((message, source)) => {
                    if let Some(item) = map(message, source)
                        && to.send(item).await.is_err()
                    {
                        return;
                    }
                }
                Err(error) => {
                    tracing::error!("{error}");
                    return;
                }
            }
        }
    })
}
