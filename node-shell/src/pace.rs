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

use linewright_msgs::{RosMessage, Time};
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

/// How much later than the fastest message of its publisher a command comes. Only differences of stamps count, so that the clocks need not
/// agree.
///
/// A reliable writer keeps what a reader behind a cut link has not acknowledged, and sends all of it when the link is there again: a
/// button that was held then, or a command that was given up long ago.
#[derive(Clone, Debug)]
struct CommandDelay {
    /// Difference of arrival and stamp of the fastest, in seconds, and when the last message came.
    least: Option<(f64, Duration)>,
    /// The difference of the first of those that are late by as much, and when it came.
    late: Option<(f64, Duration)>,
}

/// A command is late by more than this.
const LATE_AFTER: Duration = Duration::from_secs(2);
/// What is late by the same for so long is not kept by the middleware: the publisher's clock was set.
const SET_AFTER: Duration = Duration::from_secs(5);
/// By which part of a time two clocks may differ at its end.
const DRIFT: f64 = 1e-4;

impl CommandDelay {
    const fn new() -> Self {
        CommandDelay { least: None, late: None }
    }

    /// Takes the stamp of a message, in seconds of the publisher's own clock; gives whether it has come in time.
    fn offer(&mut self, now: Duration, stamp: f64) -> bool {
        let lag = now.as_secs_f64() - stamp;
        let least = self.least.map_or(lag, |(least, at)| lag.min(least + now.saturating_sub(at).as_secs_f64() * DRIFT));
        if lag - least <= LATE_AFTER.as_secs_f64() {
            (self.least, self.late) = (Some((least, now)), None);
            return true;
        }
        let is_same = |(first, _): &(f64, Duration)| (first - lag).abs() <= LATE_AFTER.as_secs_f64() / 4.0;
        let (first, since) = self.late.filter(is_same).unwrap_or((lag, now));
        let is_set = now.saturating_sub(since) >= SET_AFTER;
        (self.least, self.late) =
            if is_set { (Some((lag, now)), None) } else { (Some((least, now)), Some((first, since))) };
        is_set
    }
}

/// Publishers of one topic that are told apart. There is one as a rule, and its predecessors.
const PUBLISHERS_MAX: usize = 8;
/// Clients of one service that are told apart: each call of the ROS 2 command line is one.
const CLIENTS_MAX: usize = 64;

/// A value for each publisher of a topic: what one sends says nothing of another.
struct PerPublisher<T> {
    /// Most that are known; the one that was asked for longest ago is forgotten for another one.
    most: usize,
    fresh: T,
    /// With the time at which it was asked for last.
    known: Vec<([u8; 16], Duration, T)>,
}

impl<T: Clone> PerPublisher<T> {
    const fn new(fresh: T) -> Self {
        PerPublisher { most: PUBLISHERS_MAX, fresh, known: Vec::new() }
    }

    fn of(&mut self, now: Duration, publisher: [u8; 16]) -> &mut T {
        let known = self.known.iter().position(|(known, ..)| *known == publisher);
        let at = known.unwrap_or_else(|| {
            if self.known.len() >= self.most {
                let longest = (0..self.known.len()).min_by_key(|&at| self.known[at].1);
                self.known.remove(longest.unwrap_or(0));
            }
            self.known.push((publisher, now, self.fresh.clone()));
            self.known.len() - 1
        });
        self.known[at].1 = now;
        &mut self.known[at].2
    }
}

impl PerPublisher<MessagePace> {
    fn offer(&mut self, now: Duration, source: &MessageSource) -> bool {
        source.sent_ns.is_some_and(|sent| self.of(now, source.publisher).offer(now, sent as f64 / 1e9))
    }
}

impl PerPublisher<CommandDelay> {
    /// Of a message without a stamp, as no ROS 2 middleware sends, no delay is known.
    fn offer(&mut self, now: Duration, source: &MessageSource) -> bool {
        source.sent_ns.is_none_or(|sent| self.of(now, source.publisher).offer(now, sent as f64 / 1e9))
    }
}

/// Which commands of clients come in time, by stamps of their own: a service's requests have none of the middleware's.
pub struct ClientDelays(PerPublisher<CommandDelay>);

impl Default for ClientDelays {
    fn default() -> Self {
        ClientDelays(PerPublisher { most: CLIENTS_MAX, ..PerPublisher::new(CommandDelay::new()) })
    }
}

impl ClientDelays {
    /// Takes the stamp of a request, by the clock of the client with this identity; gives whether it has come at most two seconds later
    /// than the fastest of that client.
    pub fn offer(&mut self, client: [u8; 16], stamp: &Time) -> bool {
        let at = f64::from(stamp.sec) + f64::from(stamp.nanosec) / 1e9;
        let now = boottime();
        self.0.of(now, client).offer(now, at)
    }
}

/// The time that the machine sleeps counts: what was sent meanwhile is not of now when it wakes.
fn boottime() -> Duration {
    let time = clock_gettime(ClockId::Boottime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec as u32)
}

/// As [`forward`], of commands and held buttons, and of these only what comes at most two seconds later than the fastest message of its
/// publisher. `may_be_late`: what is obeyed however late it comes, since it only stops or releases.
pub fn forward_timely<T, U>(
    from: Subscription<T>,
    to: mpsc::Sender<U>,
    may_be_late: impl Fn(&T) -> bool + Send + 'static,
    mut map: impl FnMut(T, MessageSource) -> Option<U> + Send + 'static,
) -> Forward
where
    T: RosMessage,
    U: Send + 'static,
{
    let topic = from.topic().to_owned();
    let mut delays = PerPublisher::new(CommandDelay::new());
    forward(from, to, move |message, source| {
        let is_timely = delays.offer(boottime(), &source);
        if is_timely || may_be_late(&message) {
            return map(message, source);
        }
        tracing::warn!("{topic}: not obeyed, since it came more than {} s late: give it again", LATE_AFTER.as_secs());
        None
    })
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
    let mut paces = PerPublisher::new(pace);
    forward(from, to, move |message, source| if paces.offer(boottime(), &source) { map(message, source) } else { None })
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
        let mut paces = PerPublisher::new(MessagePace::new(REFRESH, SILENCE));
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
        let mut paces = PerPublisher::new(MessagePace::new(REFRESH, SILENCE));
        for at in 0..100 {
            let source = MessageSource { publisher: [at; 16], sequence: 1, sent_ns: Some(0), received_ns: None };
            assert!(!paces.offer(Duration::from_millis(at.into()), &source));
        }
        assert_eq!(paces.known.iter().map(|(publisher, ..)| publisher[0]).collect::<Vec<_>>(), Vec::from_iter(92..100));
    }

    /// Commands by arrival and stamp, in ms here; gives which are obeyed.
    fn obeyed(messages: impl Iterator<Item = (u64, u64)>) -> Vec<bool> {
        let mut delay = CommandDelay::new();
        messages
            .map(|(arrival, stamp)| delay.offer(Duration::from_millis(arrival), OFFSET + stamp as f64 / 1e3))
            .collect()
    }

    #[test]
    fn commands_that_were_kept_while_a_link_was_cut_are_not_obeyed() {
        let before = (0..10).map(|nth| (1_000 + nth * 50, 1_000 + nth * 50));
        // 18 s of a held button within one second, then what is sent now.
        let kept = (0..360).map(|nth| (20_000 + nth * 1000 / 360, 2_000 + nth * 50));
        let now = (0..10).map(|nth| (21_100 + nth * 50, 21_100 + nth * 50));
        let obeyed = obeyed(before.chain(kept).chain(now));
        assert!(obeyed[..10].iter().all(|obeyed| *obeyed));
        // Those of the last two seconds may be of now.
        assert!(!obeyed[10..325].contains(&true), "{:?}", obeyed[10..].iter().position(|obeyed| *obeyed));
        assert!(obeyed[370..].iter().all(|obeyed| *obeyed));
    }

    #[test]
    fn a_first_command_is_obeyed_and_so_are_those_of_a_clock_that_was_set_after_a_while() {
        assert_eq!(obeyed([(9_000, 1_000)].into_iter()), [true]);
        // The clock goes back by an hour; a button is held by it for 6 s.
        let set = (0..121).map(|nth| (4_010_000 + nth * 50, 410_000 + nth * 50));
        let obeyed = obeyed([(4_000_000, 4_000_000)].into_iter().chain(set));
        assert!(obeyed[0] && !obeyed[1..101].contains(&true) && obeyed[102..].iter().all(|obeyed| *obeyed));
    }

    #[test]
    fn a_request_that_comes_late_is_seen_by_its_own_stamp() {
        let mut delays = ClientDelays::default();
        let now = boottime().as_secs();
        let stamp = |late: u64| Time { sec: i32::try_from(now + 1_000_000 - late).expect("in time"), nanosec: 0 };
        assert!(delays.offer([1; 16], &stamp(0)));
        assert!(!delays.offer([1; 16], &stamp(10)));
        assert!(delays.offer([2; 16], &stamp(10)), "another client, with a clock of its own");
        assert!(delays.offer([1; 16], &stamp(1)));
    }

    /// A clock that is slow by 50 millionths, and a command a day.
    #[test]
    fn a_slow_clock_makes_no_command_late() {
        let day = 86_400_000;
        assert!(obeyed((1..30).map(|nth| (nth * day, nth * (day - 4_320)))).iter().all(|obeyed| *obeyed));
    }
}
