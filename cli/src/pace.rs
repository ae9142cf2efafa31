//! Whether what is heard of a node is of now.
//!
//! The middleware keeps what a node has sent for a reader that was killed, for as long as that reader's lease: up to 50 s of
//! states. A new reader receives all of them, oldest first; boot id and sequence do not distinguish them from present ones, their
//! pace does: the node's stamps then go on faster than the time here. Only differences of stamps count, so that the clocks need not
//! agree.

use std::time::Duration;

use linewright_line::Tick;

/// The pace of one node's messages.
#[derive(Clone, Debug)]
pub struct MessagePace {
    /// The interval at which the node repeats its state.
    refresh: Duration,
    /// Unheard for so long it has to be seen anew.
    unheard_after: Duration,
    /// How much later than its stamp a message came, in seconds, and when messages began to come that late.
    lag: Option<(f64, Tick)>,
    heard: Tick,
    is_live: bool,
}

impl MessagePace {
    /// Nothing heard yet.
    pub fn new(refresh: Duration, unheard_after: Duration) -> Self {
        MessagePace { refresh, unheard_after, lag: None, heard: Tick::ZERO, is_live: false }
    }

    /// Takes the stamp of a message, in seconds of the node's own clock; gives whether the message is of now.
    pub fn offer(&mut self, now: Tick, stamp: f64) -> bool {
        self.is_live &= now.since(self.heard) < self.unheard_after;
        self.heard = now;
        let lag = now.since(Tick::ZERO).as_secs_f64() - stamp;
        let near = (self.refresh * 3 / 2).as_secs_f64();
        let (before, since) = self.lag.filter(|(before, _)| (before - lag).abs() <= near).unwrap_or((lag, now));
        self.lag = Some((before, since));
        self.is_live |= now.since(since) >= self.refresh * 3;
        self.is_live
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFRESH: Duration = Duration::from_millis(50);
    const UNHEARD_AFTER: Duration = Duration::from_millis(500);
    /// The node's clock when that here is at zero.
    const OFFSET: f64 = 1.7e9;

    /// Messages by arrival and stamp, in ms here; gives what is taken for live.
    fn judged(messages: impl Iterator<Item = (u64, u64)>) -> Vec<bool> {
        let mut pace = MessagePace::new(REFRESH, UNHEARD_AFTER);
        let at = |ms| Tick::ZERO + Duration::from_millis(ms);
        messages.map(|(arrival, stamp)| pace.offer(at(arrival), OFFSET + stamp as f64 / 1e3)).collect()
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
}
