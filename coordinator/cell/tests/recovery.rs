//! The net with what fails, held against the player: every answer that it offers is a way out in the net and the other way
//! round, and closing an activity by it does to the marking what the way out does.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{OrderTiming, Recovery, RecoveryNet, compile_cell, recovery_net};
use linewright_coordinator_cell::exception::{ExceptionStep, Strategy, Whereabouts};
use linewright_coordinator_cell::{
    ActivityPhase, AlarmId, Coordination, DispatchDecision, Dispatcher, ModeId, OngoingActivity, PlayerInput,
    PlayerOutbox, PlayerState, Question, Record, RecordKind, Start, TaskOutcome, TaskReply, TaskReport,
};
use linewright_line::{StationId, Tick};
use linewright_nets::TransitionId;
use linewright_orders::TaskFailure;

const C1: &str = include_str!("../../../launch-config/lines/workcell-c1/cell.toml");
const ASSEMBLY: &str = include_str!("../../../launch-config/lines/assembly-cell/cell.toml");
const PACE: OrderTiming = OrderTiming { repeat_interval: Duration::from_millis(200), grace: Duration::from_secs(1) };
/// No rule of a shipped cell is about this code, which is no wait that was too long.
const ANY_CODE: u16 = 1997;

/// Lets one mode start if it is to, and keeps what could.
#[derive(Default)]
struct Wanted {
    mode: Option<ModeId>,
    asked: Vec<ModeId>,
}

impl Dispatcher for Wanted {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        self.asked = question.candidates.iter().map(|of| of.mode).collect();
        let found = question.candidates.iter().position(|of| Some(of.mode) == self.mode);
        let start =
            found.map(|candidate| Start { candidate, part: question.parts(&question.candidates[candidate]).next() });
        self.mode = self.mode.filter(|_| start.is_none());
        DispatchDecision { start: start.into_iter().collect(), held: Vec::new() }
    }
}

/// A life of the player, at a moment.
#[derive(Clone)]
struct Life {
    player: Coordination,
    now: Tick,
    stations: usize,
}

/// Recovery that was taken: its mode, whether the carrier was answered to have the part before, and where it led.
type Taken = (ModeId, bool, Whereabouts, Strategy);

impl Life {
    fn step(&mut self, inputs: &[PlayerInput<'_>], wanted: &mut Wanted) -> Vec<Record> {
        let mut out = PlayerOutbox::default();
        self.player.reconsider();
        self.player.step(self.now, inputs, wanted, &mut out);
        out.records
    }

    /// All stations stand at a rest, without orders.
    fn hear(&mut self) {
        let heard = TaskReport { memory: 1, ..TaskReport::default() };
        for station in 0..self.stations {
            self.step(
                &[PlayerInput::Starts(true), PlayerInput::Station(StationId::at(station), &heard)],
                &mut Wanted::default(),
            );
        }
    }

    fn asked(&self) -> Vec<ModeId> {
        let mut wanted = Wanted::default();
        self.clone().step(&[], &mut wanted);
        wanted.asked.sort_unstable();
        wanted.asked.dedup();
        wanted.asked
    }

    /// The activity of a mode that is in progress or open.
    fn firing(&self, mode: ModeId) -> Option<OngoingActivity> {
        self.player.state().firings().find(|firing| firing.mode == mode).cloned()
    }

    fn alarm(&self) -> Option<AlarmId> {
        self.player.state().exceptions().alarms().next().map(|alarm| alarm.id)
    }

    fn on(&mut self) -> Vec<Record> {
        self.now = self.player.next_deadline().unwrap_or(self.now).max(self.now + Duration::from_secs(1));
        self.step(&[], &mut Wanted::default())
    }

    /// It is done by all its stations.
    fn done(&mut self, mode: ModeId) {
        let orders = self.firing(mode).map(|firing| firing.orders).unwrap_or_default();
        for order in &orders {
            let reply = PlayerInput::Reply(order.station, order.key, TaskReply::Ended(TaskOutcome::Done));
            self.step(&[reply], &mut Wanted::default());
        }
        while self.firing(mode).is_some() {
            self.on();
        }
    }
}

struct Check<'c> {
    net: &'c RecoveryNet,
    cells: usize,
    taken: BTreeSet<Taken>,
}

impl Check<'_> {
    /// Effect of a transition on the cells of the table.
    fn effect(&self, t: TransitionId) -> BTreeMap<usize, i64> {
        let net = &self.net.net;
        let mut effect: BTreeMap<usize, i64> = BTreeMap::new();
        let all = net.postset(t).iter().map(|&(place, n)| (place, i64::from(n)));
        for (place, n) in all.chain(net.preset(t).iter().map(|&(place, n)| (place, -i64::from(n)))) {
            *effect.entry(place.index()).or_default() += n;
        }
        effect.retain(|&place, n| place < self.cells && *n != 0);
        effect
    }

    /// Fails what is in progress in every way, and answers whatever can be answered.
    fn fail(&mut self, life: &Life, mode: ModeId, causes: &[Option<u16>], depth: u8) {
        for &cause in causes {
            let mut life = life.clone();
            let firing = life.firing(mode).expect("it is in progress");
            if let (Some(code), Some(order)) = (cause, firing.orders.first()) {
                let reply = PlayerInput::Reply(
                    order.station,
                    order.key,
                    TaskReply::Ended(TaskOutcome::Failed(TaskFailure::from_code(code))),
                );
                life.step(&[reply], &mut Wanted::default());
            } else if firing.orders.is_empty() {
                let handling = life.player.state().table().handling().clone();
                let Some(resource) = handling.mode(mode).resources().next() else { continue };
                life.step(&[PlayerInput::Alarm { resource, text: "by hand" }], &mut Wanted::default());
            }
            // Otherwise its time runs out. No station comes to rest by itself: the alarm is raised in any case.
            for _ in 0..1000 {
                if life.alarm().is_some() {
                    break;
                }
                life.on();
            }
            assert!(matches!(life.firing(mode).map(|firing| firing.phase), Some(ActivityPhase::Failed(_))));
            self.answer(&life, mode, false, depth);
        }
    }

    fn answer(&mut self, life: &Life, mode: ModeId, is_carried: bool, depth: u8) {
        let part = self.net.errors.iter().find(|part| part.mode == mode).expect("it can fail");
        let ways: Vec<Recovery> = if is_carried { part.brought.clone() } else { part.recoveries.clone() };
        let alarm = life.alarm().expect("somebody is asked");
        let rulings = life.player.rulings(alarm);
        assert!(!rulings.is_empty());
        for ruling in rulings {
            let name = life.player.state().table().mode_name(mode);
            let way = ways.iter().find(|way| (way.part, way.then) == (ruling.part, ruling.then));
            let way = way.unwrap_or_else(|| panic!("{name}: the net has no {ruling:?}"));
            self.taken.insert((mode, is_carried, ruling.part, ruling.then));
            let mut life = life.clone();
            let mut state = life.player.state().clone();
            let mut records = life.step(&[PlayerInput::Answer { alarm, word: &ruling.word }], &mut Wanted::default());
            for _ in 0..1000 {
                if life.firing(mode).is_none() || life.alarm().is_some() {
                    break;
                }
                records.extend(life.on());
            }
            let done = records.iter().find_map(|record| self.closed(&mut state, record));
            if ruling.part == Whereabouts::Carrier {
                assert_eq!(done, None);
                self.answer(&life, mode, true, depth);
                continue;
            }
            assert_eq!(done.as_ref(), Some(&self.effect(way.transition)), "{name}: {ruling:?}");
            if ruling.then == Strategy::Redo && depth > 0 {
                let resources: Vec<_> = life.player.state().table().handling().resource_ids().collect();
                life.hear();
                for resource in resources {
                    life.step(&[PlayerInput::Resource { resource, up: true }], &mut Wanted::default());
                }
                assert!(life.firing(mode).is_some(), "{name} is done again");
                self.fail(&life, mode, &[Some(ANY_CODE)], depth - 1);
            }
        }
    }

    /// Effect of the record that closes an activity on the marking.
    fn closed(&self, state: &mut PlayerState, record: &Record) -> Option<BTreeMap<usize, i64>> {
        let before: Vec<i64> = state.marking().counts().iter().map(|&n| n as i64).collect();
        state.apply(record).expect("the player wrote it");
        let is_closed = matches!(record.fact, RecordKind::Exception(ExceptionStep::Closed { .. }));
        is_closed.then(|| {
            let after = state.marking().counts().iter().map(|&n| n as i64);
            after
                .zip(before)
                .enumerate()
                .map(|(cell, (after, before))| (cell, after - before))
                .filter(|(_, n)| *n != 0)
                .collect()
        })
    }
}

/// Everything that can fail fails in every way, as soon as it can start.
fn held_against(text: &str) -> (RecoveryNet, usize) {
    let cell = linewright_cell::parse("cell.toml", text, None).unwrap_or_else(|problems| panic!("{problems:#}")).cell;
    let made = compile_cell(&cell, None, Supply::Open, PACE).unwrap_or_else(|why| panic!("{why}"));
    // No sensor contradicts an answer here.
    let mut handling = made.table.handling().clone();
    handling.resources.iter_mut().for_each(|resource| resource.is_sensed = false);
    let table = Arc::new(made.table.with_handling(handling));
    let net = recovery_net("recovery", &table).expect("it has one");
    let mut codes: Vec<Option<u16>> =
        cell.exceptions.iter().filter_map(|rule| rule.code.parse().ok()).map(Some).collect();
    codes.extend([None, Some(ANY_CODE)]);
    let mut out = PlayerOutbox::default();
    let player = Coordination::begin(PlayerState::new(table.clone()), Tick::ZERO, 1, &mut out).expect("the first life");
    let mut life = Life { player, now: Tick::ZERO, stations: cell.controllers.len() };
    life.hear();
    let mut check = Check { net: &net, cells: table.cell_count(), taken: BTreeSet::new() };
    let mut open: BTreeSet<ModeId> = net.errors.iter().map(|part| part.mode).collect();
    for turn in 0..5000 {
        let asked = life.asked();
        for &mode in asked.iter().filter(|mode| open.contains(mode)) {
            let mut begun = life.clone();
            begun.step(&[], &mut Wanted { mode: Some(mode), asked: Vec::new() });
            check.fail(&begun, mode, &codes, 2);
        }
        // New modes first, so that parts come further; else by the turn.
        let next = asked.iter().find(|mode| open.contains(mode)).or(asked.get(turn * 7919 % asked.len().max(1)));
        let Some(&mode) = next else { break };
        asked.iter().for_each(|mode| _ = open.remove(mode));
        life.step(&[], &mut Wanted { mode: Some(mode), asked: Vec::new() });
        life.done(mode);
        if open.is_empty() {
            break;
        }
    }
    assert!(open.is_empty(), "never started: {:?}", open.iter().map(|&mode| table.mode_name(mode)).collect::<Vec<_>>());
    let all = net.errors.iter().flat_map(|part| {
        let ways = part.recoveries.iter().map(|way| (false, way)).chain(part.brought.iter().map(|way| (true, way)));
        ways.map(|(carried, way)| (part.mode, carried, way.part, way.then))
    });
    let all: BTreeSet<Taken> = all.collect();
    assert_eq!(check.taken, all, "what the player offers, and the ways out of the net");
    let count = all.len();
    (net, count)
}

#[test]
fn every_answer_of_the_shipped_cells_is_a_way_out_and_does_the_same() {
    let (net, ways) = held_against(C1);
    println!(
        "C1: {} that can fail, {ways} ways out, {} places, {} transitions",
        net.errors.len(),
        net.net.place_count(),
        net.net.transition_count()
    );
    assert!(ways > net.errors.len());
    let (net, ways) = held_against(ASSEMBLY);
    println!("assembly: {} that can fail, {ways} ways out", net.errors.len());
    assert!(ways > net.errors.len());
}

#[test]
fn with_the_carrier_and_with_nothing_but_trying_again_too() {
    let (head, _) = C1.split_once("[[exception]]").expect("it has one");
    let with = |rule: &str| format!("{head}[[exception]]\nin = \"*\"\n{rule}\n");
    let carried = "code = \"*\"\ntell = \"x\"\nanswers = [{ word = \"held\", part = \"carrier\", then = \"forward\" }, \
                   { word = \"back\", part = \"from\", then = \"backward\" }]";
    let (net, _) = held_against(&with(carried));
    assert!(net.errors.iter().any(|part| part.carried.is_some() && part.brought.len() == 3));
    let again =
        "code = \"*\"\nretries = 1\ntell = \"x\"\nanswers = [{ word = \"again\", part = \"from\", then = \"redo\" }]";
    let (net, _) = held_against(&with(again));
    assert!(net.errors.iter().all(|part| part.recoveries.len() == 4), "and the usual three when it was tried again");
}
