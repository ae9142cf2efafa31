//! Orders that are not done: the activity fails, and keeps its tokens.

use linewright_coordinator_cell::{
    ActivityFailure, ActivityPhase, CellEvent, CellMessage, Coordination, Fifo, OrderFailure, OrderKey, OrderMessage,
    OrderProgress, PartPlace, PlayerInput, PlayerOutbox, PlayerState, RecordKind, Sending, TaskOutcome, TaskRefusal,
    TaskReply, TaskReport,
};
use linewright_line::{StationId, Tick};
use linewright_orders::TaskFailure;

use super::crash::merged;
use super::plans::Compiled;

const ROBOT: StationId = StationId(0);
const MACHINE: StationId = StationId(1);

/// A cell whose robot and machine have just been ordered to load a part 1, by hand from here on.
struct PlayerBench {
    it: Compiled,
    player: Coordination,
    out: PlayerOutbox,
    log: Vec<linewright_coordinator_cell::Record>,
    now: u64,
}

fn key(id: u64) -> OrderKey {
    OrderKey { epoch: 1, id }
}

impl PlayerBench {
    fn new() -> Self {
        let (it, mut out) = (merged([1, 0, 0]), PlayerOutbox::default());
        let player = Coordination::begin(PlayerState::new(it.table.clone()), Tick::ZERO, 1, &mut out).unwrap();
        let mut bench = PlayerBench { it, player, log: std::mem::take(&mut out.records), out, now: 0 };
        let fresh = TaskReport { memory: 1, ..TaskReport::default() };
        let stations = [ROBOT, MACHINE].map(|station| PlayerInput::Station(station, &fresh));
        bench.at(0, &stations);
        bench.at(0, &[PlayerInput::Starts(true)]);
        assert_eq!(bench.keys_sent(), [key(1), key(2)]);
        bench
    }

    /// One step at a time in milliseconds.
    fn at(&mut self, millis: u64, inputs: &[PlayerInput<'_>]) {
        self.now = millis;
        self.out = PlayerOutbox::default();
        self.player.step(Tick::from_millis(millis), inputs, &mut Fifo, &mut self.out);
        self.log.extend(self.out.records.iter().cloned());
        assert_eq!(&PlayerState::replay(self.it.table.clone(), &self.log).unwrap(), self.player.state());
    }

    fn sent(&self) -> Vec<OrderMessage> {
        let orders = self.out.sends.iter().filter_map(|send| match send {
            CellMessage::Order(order) => Some(order.clone()),
            CellMessage::Secure { .. } => None,
        });
        orders.collect()
    }

    fn keys_sent(&self) -> Vec<OrderKey> {
        self.sent().iter().map(|message| message.order.key).collect()
    }

    fn restart(&mut self) {
        let state = PlayerState::replay(self.it.table.clone(), &self.log).unwrap();
        let epoch = state.epoch() + 1;
        let mut out = PlayerOutbox::default();
        self.player = Coordination::begin(state, Tick::from_millis(self.now), epoch, &mut out).unwrap();
        self.log.extend(out.records);
    }

    /// The only activity, which has failed: it holds the part and what it took, and goes on holding them.
    fn assert_failed(&mut self, cause: ActivityFailure) {
        let held = |bench: &PlayerBench| {
            let state = bench.player.state();
            let firing = state.firings().next().unwrap();
            assert_eq!((firing.phase, state.firings().len()), (ActivityPhase::Failed(cause), 1));
            assert_eq!(state.parts().map(|part| part.place).collect::<Vec<_>>(), [PartPlace::In(firing.id)]);
            let gone = ["free<m1>", "robot<r1>", "input<p1>", "loaded<m1,p1>"];
            gone.iter().for_each(|name| assert_eq!(state.marking().count(bench.it.cell(name)), 0, "{name}"));
            assert_eq!(state.enabled(), []);
        };
        held(self);
        let later = self.now + 1_000_000;
        self.at(later, &[]);
        held(self);
        assert_eq!(self.sent(), [], "nothing of it is sent any more");
        self.restart();
        held(self);
        assert_eq!(self.player.next_deadline(), None);
    }
}

fn running(station: StationId, id: u64) -> PlayerInput<'static> {
    PlayerInput::Reply(station, key(id), TaskReply::Running)
}

fn done(station: StationId, id: u64) -> PlayerInput<'static> {
    PlayerInput::Reply(station, key(id), TaskReply::Ended(TaskOutcome::Done))
}

#[test]
fn it_ends_when_all_of_its_stations_have_done_their_orders() {
    let mut bench = PlayerBench::new();
    assert!(bench.player.next_deadline() <= Some(Tick::from_millis(200)));
    bench.at(10, &[running(ROBOT, 1), running(MACHINE, 2)]);
    bench.at(500, &[done(MACHINE, 2)]);
    assert_eq!(bench.player.state().firings().len(), 1);
    bench.at(900, &[done(ROBOT, 1)]);
    // The part is loaded; the work on it begins, with the next key.
    assert_eq!(bench.it.names(bench.player.state().firings().map(|firing| firing.mode)), ["work<m1,p1>"]);
    assert_eq!(bench.player.state().marking().count(bench.it.cell("robot<r1>")), 1);
    assert_eq!(bench.keys_sent(), [key(3)]);
    assert_eq!(bench.sent()[0].part, bench.player.state().parts().next().map(|part| part.id));
}

#[test]
fn an_unanswered_order_is_repeated_with_its_key_and_what_is_left_of_its_time() {
    let mut bench = PlayerBench::new();
    assert_eq!(bench.player.sending(key(1)), Some(Sending::Sent { tries: 1, at: Tick::ZERO }));
    bench.at(100, &[]);
    assert_eq!(bench.sent(), []);
    assert_eq!(bench.player.next_deadline(), Some(Tick::from_millis(200)));
    bench.at(200, &[running(ROBOT, 1)]);
    assert_eq!(bench.keys_sent(), [key(2)]);
    assert_eq!(bench.sent()[0].order.limit.as_millis(), 59_800);
    assert_eq!(bench.player.sending(key(1)), None);
    // A busy station gets the order again; a second refusal counts like the first.
    for at in [250, 300] {
        bench.at(at, &[PlayerInput::Reply(MACHINE, key(2), TaskReply::Refused(TaskRefusal::Busy))]);
        assert_eq!(bench.sent(), []);
    }
    bench.at(400, &[]);
    assert_eq!(bench.keys_sent(), [key(2)]);
    assert_eq!(bench.player.sending(key(2)), Some(Sending::Sent { tries: 3, at: Tick::from_millis(400) }));
}

#[test]
fn a_code_fails_it_and_what_other_stations_do_meanwhile_is_kept() {
    let mut bench = PlayerBench::new();
    bench.at(10, &[running(ROBOT, 1), running(MACHINE, 2)]);
    bench.at(
        20,
        &[PlayerInput::Reply(MACHINE, key(2), TaskReply::Ended(TaskOutcome::Failed(TaskFailure::Waiting(12))))],
    );
    bench.at(30, &[done(ROBOT, 1)]);
    let states: Vec<_> =
        bench.player.state().firings().next().unwrap().orders.iter().map(|order| order.state).collect();
    assert_eq!(states, [OrderProgress::Ended, OrderProgress::Failed(OrderFailure::Code(12))]);
    bench.assert_failed(ActivityFailure::Order { key: key(2), failure: OrderFailure::Code(12) });
}

#[test]
fn a_refusal_that_does_not_pass_fails_it() {
    let mut bench = PlayerBench::new();
    bench.at(10, &[PlayerInput::Reply(ROBOT, key(1), TaskReply::Refused(TaskRefusal::NotThere))]);
    let failure = OrderFailure::Refused(TaskRefusal::NotThere);
    bench.assert_failed(ActivityFailure::Order { key: key(1), failure });
}

/// Seed 001, Fig. 6: all limits count from the start of the activity; each station has its own.
#[test]
fn an_end_that_does_not_come_in_time_fails_it_and_one_that_comes_later_is_kept() {
    let mut bench = PlayerBench::new();
    bench.at(10, &[running(ROBOT, 1), running(MACHINE, 2)]);
    bench.at(50_000, &[done(MACHINE, 2)]);
    assert_eq!(bench.player.next_deadline(), Some(Tick::from_millis(60_000)));
    bench.at(59_999, &[]);
    assert_eq!(bench.player.state().firings().next().unwrap().phase, ActivityPhase::Running);
    bench.at(60_000, &[]);
    bench.at(61_000, &[done(ROBOT, 1)]);
    let orders = &bench.player.state().firings().next().unwrap().orders;
    assert!(orders.iter().all(|order| order.state == OrderProgress::Ended), "known to whoever finds out what is true");
    bench.assert_failed(ActivityFailure::Order { key: key(1), failure: OrderFailure::TimedOut });
}

#[test]
fn an_end_that_comes_at_the_last_moment_is_in_time() {
    let mut bench = PlayerBench::new();
    bench.at(60_000, &[done(ROBOT, 1), done(MACHINE, 2)]);
    assert!(bench.log.iter().any(|record| matches!(record.fact, RecordKind::Ended { .. })));
}

/// After a restart, first the ends of orders in the meantime are received.
#[test]
fn no_limit_runs_out_in_the_first_second_after_a_restart() {
    let mut bench = PlayerBench::new();
    bench.at(10, &[running(ROBOT, 1), running(MACHINE, 2)]);
    bench.now = 100_000;
    bench.restart();
    bench.at(100_500, &[]);
    assert_eq!(bench.player.state().firings().next().unwrap().phase, ActivityPhase::Running);
    assert_eq!(bench.player.next_deadline(), Some(Tick::from_millis(101_000)));
    bench.at(101_000, &[]);
    bench.assert_failed(ActivityFailure::Order { key: key(1), failure: OrderFailure::TimedOut });
}

/// A station with a new memory may have done its order or not: it is not sent again.
#[test]
fn an_order_to_a_station_that_has_lost_its_memory_fails_and_is_never_sent_again() {
    for acknowledged in [false, true] {
        for restarted in [false, true] {
            let mut bench = PlayerBench::new();
            if acknowledged {
                bench.at(10, &[running(ROBOT, 1)]);
            }
            if restarted {
                bench.restart();
            }
            let fresh = TaskReport { memory: 2, ..TaskReport::default() };
            bench.at(20, &[PlayerInput::Station(ROBOT, &fresh)]);
            let machine: Vec<_> = bench.sent().iter().map(|order| order.station).collect();
            assert_eq!(machine, [], "{acknowledged} {restarted}");
            bench.assert_failed(ActivityFailure::Order { key: key(1), failure: OrderFailure::Forgotten });
        }
    }
}

/// Killed between the records of such a step, the next life finds the same.
#[test]
fn a_lost_memory_is_noticed_whichever_of_its_records_were_written() {
    let fresh = TaskReport { memory: 2, ..TaskReport::default() };
    let mut whole = PlayerBench::new();
    let before = whole.log.len();
    whole.at(20, &[PlayerInput::Station(ROBOT, &fresh)]);
    assert!(whole.log.len() >= before + 3, "the order fails, the memory is new, the activity fails");
    for written in before..=whole.log.len() {
        let mut bench = PlayerBench::new();
        bench.at(20, &[PlayerInput::Station(ROBOT, &fresh)]);
        bench.log.truncate(written);
        bench.restart();
        bench.at(30, &[PlayerInput::Station(ROBOT, &fresh)]);
        assert_eq!(bench.sent(), [], "{written}");
        bench.assert_failed(ActivityFailure::Order { key: key(1), failure: OrderFailure::Forgotten });
    }
}

/// Until this life has received a station, it sends it nothing: its memory has to be in a record first.
#[test]
fn a_restarted_coordinator_sends_what_nobody_has_answered_once_it_hears_the_station() {
    let mut bench = PlayerBench::new();
    bench.at(10, &[running(ROBOT, 1)]);
    bench.restart();
    bench.at(20, &[PlayerInput::Starts(true)]);
    assert_eq!(bench.sent(), []);
    let same = TaskReport { memory: 1, epoch: 1, ..TaskReport::default() };
    bench.at(30, &[PlayerInput::Station(MACHINE, &same), PlayerInput::Station(ROBOT, &same)]);
    assert_eq!(bench.keys_sent(), [key(2)], "the same key, and only what nobody has taken on");
    // What has ended is in the station's whole state.
    let ended = |id| TaskReport { results: vec![(key(id), TaskOutcome::Done)], ..same.clone() };
    bench.at(40, &[PlayerInput::Station(MACHINE, &ended(2)), PlayerInput::Station(ROBOT, &ended(1))]);
    let work = &bench.sent()[0];
    assert_eq!((work.order.key, &*work.order.task), (OrderKey { epoch: 2, id: 3 }, "work"));
}

/// There is another coordinator already.
#[test]
fn a_coordinator_that_hears_of_a_later_life_starts_and_sends_nothing_more() {
    let mut bench = PlayerBench::new();
    let later = TaskReport { memory: 1, epoch: 2, ..TaskReport::default() };
    bench.at(200, &[PlayerInput::Station(MACHINE, &later)]);
    assert_eq!(bench.out.events, [CellEvent::Superseded { by: MACHINE, epoch: 2 }]);
    bench.at(1000, &[PlayerInput::Station(MACHINE, &later)]);
    assert_eq!((bench.out.events.len(), bench.sent().len()), (0, 0));
    bench.at(2000, &[done(ROBOT, 1), done(MACHINE, 2)]);
    assert_eq!(bench.player.state().firings().len(), 0, "what ends, ends, and nothing follows");
}

#[test]
fn what_another_station_says_of_an_order_is_not_believed() {
    let mut bench = PlayerBench::new();
    bench.at(10, &[done(MACHINE, 1), done(ROBOT, 2), done(StationId(9), 1), done(ROBOT, 77)]);
    assert_eq!(bench.out.records, []);
}
