//! Whether received messages of a node are present ones.
//!
//! The middleware keeps the messages of a node for a reader that was killed, for as long as that reader's lease: up to 50 s of
//! states. A new reader receives all of them, oldest first; boot id and sequence do not distinguish them from present ones, their
//! pace does: the node's stamps then go on faster than the time here. Only differences of stamps count, so that the clocks need
//! not agree.
//!
//! Best effort readers receive none of that, but are no way out: this library's reliable writers wait for their
//! acknowledgement too, which never comes, and then keep 8192 messages for every new reader.

use std::time::Duration;

use linewright_msgs::RosMessage;
use rustix::time::{ClockId, clock_gettime};
use tokio::sync::mpsc;

use crate::subscription::{Forward, MessageSource, Subscription, forward};

/// The pace of one node's messages. Times of arrival are counted from any moment, the same for all.
#[derive(Clone, Debug)]
pub struct MessagePace {
    /// The interval at which the node repeats its state.
    refresh: Duration,
    /// Unheard for so long it has to be seen anew.
    unheard_after: Duration,
    /// How much later than its stamp a message came, in seconds, and when messages began to come that late.
    lag: Option<(f64, Duration)>,
    heard: Duration,
    is_live: bool,
}

impl MessagePace {
    /// Nothing heard yet.
    pub fn new(refresh: Duration, unheard_after: Duration) -> Self {
        MessagePace { refresh, unheard_after, lag: None, heard: Duration::ZERO, is_live: false }
    }

    /// Takes the stamp of a message, in seconds of the node's own clock; gives whether the message is of now.
    pub fn offer(&mut self, now: Duration, stamp: f64) -> bool {
        self.is_live &= now.saturating_sub(self.heard) < self.unheard_after;
        self.heard = now;
        let lag = now.as_secs_f64() - stamp;
        let near = (self.refresh * 3 / 2).as_secs_f64();
        let (before, since) = self.lag.filter(|(before, _)| (before - lag).abs() <= near).unwrap_or((lag, now));
        self.lag = Some((before, since));
        self.is_live |= now.saturating_sub(since) >= self.refresh * 3;
        self.is_live
    }
}

/// Publishers of one topic whose pace is watched. There is one as a rule, and its predecessors.
const PUBLISHERS_MAX: usize = 8;

/// The paces of all publishers of a topic: what one sends says nothing of another.
struct PublisherPaces {
    fresh: MessagePace,
    known: Vec<([u8; 16], MessagePace)>,
}

impl PublisherPaces {
    fn offer(&mut self, now: Duration, source: &MessageSource) -> bool {
        let Some(sent) = source.sent_ns else { return false };
        let known = self.known.iter().position(|(publisher, _)| *publisher == source.publisher);
        let at = known.unwrap_or_else(|| {
            if self.known.len() == PUBLISHERS_MAX {
                let longest = (0..self.known.len()).min_by_key(|&at| self.known[at].1.heard);
                self.known.remove(longest.unwrap_or(0));
            }
            self.known.push((source.publisher, self.fresh.clone()));
            self.known.len() - 1
        });
        self.known[at].1.offer(now, sent as f64 / 1e9)
    }
}

/// As [`forward`], of whole states that are repeated, and of these only what is of now: nothing that the middleware has kept
/// for another reader, or sends once more after a silence.
pub fn forward_present<T, U>(
    from: Subscription<T>,
    to: mpsc::Sender<U>,
    pace: MessagePace,
    mut map: impl FnMut(T, MessageSource) -> Option<U> + Send + 'static,
) -> Forward
where
    T: RosMessage,
    U: Send + 'static,
{
    // The time that the machine sleeps counts: what was sent meanwhile is not of now when it wakes.
    let now = || {
        let time = clock_gettime(ClockId::Boottime);
        Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec as u32)
    };
    let mut paces = PublisherPaces { fresh: pace, known: Vec::new() };
    forward(from, to, move |message, source| if paces.offer(now(), &source) { map(message, source) } else { None })
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFRESH: Duration = Duration::from_millis(50);
    const SILENCE: Duration = Duration::from_millis(500);
    /// The node's clock when that here is at zero.
    const OFFSET: f64 = 1.7e9;

    /// Messages by arrival and stamp, in ms here; gives what is taken for live.
    fn judged(messages: impl Iterator<Item = (u64, u64)>) -> Vec<bool> {
        let mut pace = MessagePace::new(REFRESH, SILENCE);
        messages
            .map(|(arrival, stamp)| pace.offer(Duration::from_millis(arrival), OFFSET + stamp as f64 / 1e3))
            .collect()
    }

    #[test]
    fn a_state_that_is_repeated_in_time_is_live_from_the_fourth_message() {
        let judged = judged((0..6).map(|nth| (50_000 + nth * 50, 50_000 + nth * 50)));
        assert_eq!(judged, [false, false, false, true, true, true]);
    }

    #[test]
    fn what_was_kept_for_another_reader_is_not_live_and_what_follows_is() {
        // 40 s of states within 2 s, with a pause in the middle; then those of now.
        let pause = |nth: u64| if nth < 400 { 0 } else { 180 };
        let kept = (0..800).map(|nth| (50_000 + nth * 5 / 2 + pause(nth), 10_000 + nth * 50));
        let now = (0..10).map(|nth| (52_200 + nth * 50, 52_200 + nth * 50));
        let judged = judged(kept.chain(now));
        assert!(!judged[..800].contains(&true), "{:?}", judged.iter().position(|live| *live));
        assert!(judged[803..].iter().all(|live| *live), "{:?}", &judged[800..]);
    }

    #[test]
    fn a_late_message_of_a_live_node_is_live_and_one_after_a_silence_is_looked_at_anew() {
        let steady = (0..6).map(|nth| (nth * 50, nth * 50));
        let late = [(450, 300), (451, 350)];
        let back = [(1500, 1500), (1550, 1550), (1600, 1600), (1650, 1650)];
        let judged = judged(steady.chain(late).chain(back));
        assert_eq!(judged[3..8], [true; 5]);
        assert_eq!(judged[8..], [false, false, false, true]);
    }

    /// 30 s of states within 1 s from one publisher do not count, whatever another one of the topic sends meanwhile.
    #[test]
    fn each_publisher_of_a_topic_has_its_own_pace() {
        let mut paces = PublisherPaces { fresh: MessagePace::new(REFRESH, SILENCE), known: Vec::new() };
        let mut offer = |at: u64, publisher: u8, sent: u64| {
            let source = MessageSource {
                publisher: [publisher; 16],
                sequence: 1,
                sent_ns: Some(sent as i64 * 1_000_000),
                received_ns: None,
            };
            paces.offer(Duration::from_millis(at), &source)
        };
        for nth in 0..20 {
            assert!((0..30).all(|kept| !offer(nth * 50, 1, (nth * 30 + kept) * 50)));
            // By a clock of its own.
            assert_eq!(offer(nth * 50, 2, 7_000_000 + nth * 50), nth >= 3);
        }
        assert!(!offer(1000, 3, 1000));
    }

    #[test]
    fn only_the_publishers_heard_last_are_remembered() {
        let mut paces = PublisherPaces { fresh: MessagePace::new(REFRESH, SILENCE), known: Vec::new() };
        for at in 0..100 {
            let source = MessageSource { publisher: [at; 16], sequence: 1, sent_ns: Some(0), received_ns: None };
            assert!(!paces.offer(Duration::from_millis(at.into()), &source));
        }
        assert_eq!(paces.known.iter().map(|(publisher, _)| publisher[0]).collect::<Vec<_>>(), Vec::from_iter(92..100));
    }
}
