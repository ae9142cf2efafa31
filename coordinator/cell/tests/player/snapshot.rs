//! A snapshot stands for all records before it; written and read again it is the same; a forged one does no harm.

use std::sync::Arc;
use std::time::Duration;

use linewright_coordinator_cell::dispatch::{DispatchRule, PartPriority, RuleDispatcher};
use linewright_coordinator_cell::texts;
use linewright_coordinator_cell::{
    ActivityFailure, ActivityTiming, CellSnapshot, CellTable, Coordination, DecidingRule, Fifo, FiringId, Gain,
    HoldReason, LostDecision, ModeId, OrderFailure, OrderKey, PartId, PlayerInput, PlayerOutbox, PlayerState,
    ProgressComparison, Record, RecordKind, TaskRefusal,
};
use linewright_line::{StationId, Tick};
use linewright_nets::NetBuilder;
use linewright_nets::coloured::ColouredBuilder;

use super::crash::merged;
use super::plans::{Compiled, PARTS, TOKENS, ordered};
use super::printed::{Variant, compiled};
use super::workcell::{self, Workcell};
use super::world::{World, options};
use linewright_random::Random as Dice;

const LONG: Tick = Tick::from_millis(3_600_000);

/// Cells in which much happens: stations fail, messages are lost, the coordinator is killed.
fn worlds() -> Vec<World> {
    let printed = || compiled(&Variant { waiting: [2, 2, 2], ..Variant::default() });
    let mut worlds = vec![World::with(printed(), 3, options(1, 8, vec![50]))];
    for seed in 2..5 {
        let cell = Workcell::random(&mut Dice::new(seed));
        let mut world = World::with(workcell::compiled(&cell), cell.stations(), options(seed, 8, vec![70]));
        world.stations.iter_mut().for_each(|station| station.failing = 6);
        worlds.push(world);
    }
    worlds.iter_mut().for_each(|world| world.run(&mut Fifo, LONG));
    worlds
}

/// Written and read by another program.
fn again(snapshot: &CellSnapshot) -> CellSnapshot {
    let text = serde_json::to_string(snapshot).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// All that can be read of a state. What lists of watchers look like inside is no part of it.
fn assert_same(a: &PlayerState, b: &PlayerState) {
    assert_eq!(a.snapshot(), b.snapshot());
    assert_eq!((a.enabled(), a.marking().counts()), (b.enabled(), b.marking().counts()));
    for mode in a.table().modes() {
        assert_eq!((a.in_progress(mode), a.room(mode)), (b.in_progress(mode), b.room(mode)));
        assert!(a.takeable(mode).eq(b.takeable(mode)));
    }
}

/// Whichever record a snapshot is taken after, the records behind it lead on from there as they did.
#[test]
fn what_is_restored_goes_on_as_the_state_would_have() {
    let mut records = 0;
    for world in worlds() {
        let mut state = PlayerState::new(world.table.clone());
        for (count, record) in world.log.iter().enumerate() {
            let mut restored = PlayerState::restore(world.table.clone(), again(&state.snapshot())).unwrap();
            assert_same(&restored, &state);
            if count % 7 == 0 {
                world.log[count..].iter().for_each(|record| restored.apply(record).unwrap());
                assert_same(&restored, world.state());
            }
            state.apply(record).unwrap();
        }
        records += world.log.len();
    }
    assert!(records > 200, "{records}");
}

/// A life that begins from a snapshot decides and sends what one would that begins from the records.
#[test]
fn a_life_from_a_snapshot_does_what_a_life_from_the_records_does() {
    for world in worlds() {
        for count in (0..world.log.len()).step_by(5) {
            let state = PlayerState::replay(world.table.clone(), &world.log[..count]).unwrap();
            let restored = PlayerState::restore(world.table.clone(), state.snapshot()).unwrap();
            let lives = [state, restored].map(|state| {
                let (now, epoch, mut out) = (world.now, state.epoch() + 1, PlayerOutbox::default());
                let mut player = Coordination::begin(state, now, epoch, &mut out).unwrap();
                let heard: Vec<_> = world.stations.iter().map(|station| station.heard().clone()).collect();
                let mut inputs = vec![PlayerInput::Starts(true)];
                inputs
                    .extend(heard.iter().enumerate().map(|(at, heard)| PlayerInput::Station(StationId::at(at), heard)));
                player.step(now, &inputs, &mut Fifo, &mut out);
                let limit = player.next_deadline();
                player.step(now + Duration::from_secs(120), &[], &mut Fifo, &mut out);
                (out, limit)
            });
            assert_eq!(lives[0], lives[1]);
        }
    }
}

/// Every number in it by chance another: it is refused, or it is a state with which one can go on.
#[test]
fn a_snapshot_or_a_record_that_somebody_has_made_up_is_refused_or_fits() {
    let mut dice = Dice::new(17);
    let (mut fitted, mut refused) = (0, 0);
    for world in worlds() {
        let table = &world.table;
        for round in 0..600 {
            let count = dice.below(world.log.len());
            let mut state = PlayerState::replay(table.clone(), &world.log[..count]).unwrap();
            let text = serde_json::to_string(&state.snapshot()).unwrap();
            if let Ok(snapshot) = serde_json::from_str(&forged(&text, &mut dice)) {
                match PlayerState::restore(table.clone(), snapshot) {
                    Ok(restored) => state = restored,
                    Err(_) => refused += 1,
                }
            }
            for record in &world.log[count..] {
                let text = serde_json::to_string(record).unwrap();
                let text = if round % 2 == 0 { forged(&text, &mut dice) } else { text };
                let Ok(record) = serde_json::from_str::<Record>(&text) else { continue };
                if state.apply(&record).is_err() {
                    break;
                }
                if let RecordKind::Decided { started, held, .. } = &record.fact {
                    assert!(texts::decision(table, started, held).len() >= held.len());
                }
                fitted += 1;
            }
            let (mut out, epoch) = (PlayerOutbox::default(), state.epoch() + 1);
            let mut player = Coordination::begin(state, world.now, epoch, &mut out).unwrap();
            for seconds in [0, 60, 600] {
                player.step(
                    world.now + Duration::from_secs(seconds),
                    &[PlayerInput::Starts(true)],
                    &mut Fifo,
                    &mut out,
                );
            }
        }
    }
    assert!(fitted > 1000 && refused > 1000, "{fitted} {refused}");
}

/// Some of the numbers of a text are others.
fn forged(text: &str, dice: &mut Dice) -> String {
    let mut forged = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(|c: char| c.is_ascii_digit()) {
        let length = rest[at..].find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len() - at);
        forged.push_str(&rest[..at]);
        let own = &rest[at..at + length];
        let others = ["0", "1", "2", "5", "4000000000", "9223372036854775807", "18446744073709551615"];
        forged.push_str(if dice.one_in(12) { others[dice.below(others.len())] } else { own });
        rest = &rest[at + length..];
    }
    forged + rest
}

/// Records on disk have to be read by later programs. If this fails, the form has changed and needs another number.
#[test]
fn every_record_has_the_text_that_it_always_had() {
    let (key, mode, part) = (OrderKey { epoch: 2, id: 9 }, ModeId(4), Some(PartId(5)));
    let lost = |by| HoldReason::LostTo(LostDecision { to: mode, with: part, own: None, by });
    let worse = |instead, gain| HoldReason::LooksWorse(ProgressComparison { instead, gain });
    let facts = [
        (RecordKind::Epoch { epoch: 2 }, r#"{"epoch":{"epoch":2}}"#),
        (RecordKind::Memory { station: StationId(1), memory: 7 }, r#"{"memory":{"station":1,"memory":7}}"#),
        (
            RecordKind::Decided {
                question: 3,
                started: vec![(mode, part), (mode, None)],
                held: vec![
                    (mode, HoldReason::NotYet(Tick::from_millis(8))),
                    (mode, HoldReason::ReservedFor { part, mode }),
                    (mode, lost(DecidingRule::Waited)),
                    (mode, lost(DecidingRule::Helps { part: None })),
                    (mode, lost(DecidingRule::Inside)),
                    (mode, lost(DecidingRule::Order)),
                    (mode, HoldReason::NotOrdered),
                    (mode, HoldReason::PlannedOtherwise(mode)),
                    (mode, worse(Some((mode, None)), Gain::Tardiness(Duration::from_millis(1500)))),
                    (mode, worse(None, Gain::Nothing)),
                ],
            },
            concat!(
                r#"{"decided":{"question":3,"started":[[4,5],[4,null]],"held":[[4,{"not-yet":8000}],"#,
                r#"[4,{"reserved-for":{"part":5,"mode":4}}],"#,
                r#"[4,{"lost-to":{"to":4,"with":5,"own":null,"by":"waited"}}],"#,
                r#"[4,{"lost-to":{"to":4,"with":5,"own":null,"by":{"helps":{"part":null}}}}],"#,
                r#"[4,{"lost-to":{"to":4,"with":5,"own":null,"by":"inside"}}],"#,
                r#"[4,{"lost-to":{"to":4,"with":5,"own":null,"by":"order"}}],"#,
                r#"[4,"not-ordered"],[4,{"planned-otherwise":4}],"#,
                r#"[4,{"looks-worse":{"instead":[4,null],"gain":{"tardiness":{"secs":1,"nanos":500000000}}}}],"#,
                r#"[4,{"looks-worse":{"instead":null,"gain":"nothing"}}]]}}"#
            ),
        ),
        (
            RecordKind::Started { firing: FiringId(6), mode, part, orders: vec![key] },
            r#"{"started":{"firing":6,"mode":4,"part":5,"orders":[{"epoch":2,"id":9}]}}"#,
        ),
        (RecordKind::Acknowledged { key }, r#"{"acknowledged":{"key":{"epoch":2,"id":9}}}"#),
        (RecordKind::OrderEnded { key }, r#"{"order-ended":{"key":{"epoch":2,"id":9}}}"#),
        (
            RecordKind::OrderFailed { key, failure: OrderFailure::Refused(TaskRefusal::OldEpoch) },
            r#"{"order-failed":{"key":{"epoch":2,"id":9},"failure":{"refused":"old-epoch"}}}"#,
        ),
        (
            RecordKind::OrderFailed { key, failure: OrderFailure::Forgotten },
            r#"{"order-failed":{"key":{"epoch":2,"id":9},"failure":"forgotten"}}"#,
        ),
        (
            RecordKind::Raised {
                firing: FiringId(6),
                cause: ActivityFailure::Order { key, failure: OrderFailure::Code(12) },
            },
            r#"{"raised":{"firing":6,"cause":{"order":{"key":{"epoch":2,"id":9},"failure":{"code":12}}}}}"#,
        ),
        (
            RecordKind::Raised { firing: FiringId(6), cause: ActivityFailure::TimedOut },
            r#"{"raised":{"firing":6,"cause":"timed-out"}}"#,
        ),
        (RecordKind::Ended { firing: FiringId(6) }, r#"{"ended":{"firing":6}}"#),
        (RecordKind::Fired { mode, part: None }, r#"{"fired":{"mode":4,"part":null}}"#),
    ];
    for (fact, text) in facts {
        let record = Record { at: Tick::from_millis(1), fact };
        let text = format!(r#"{{"at":1000,"fact":{text}}}"#);
        assert_eq!(serde_json::to_string(&record).unwrap(), text);
        assert_eq!(serde_json::from_str::<Record>(&text).unwrap(), record);
    }
    // What rules measure, from a decision that they have made.
    let mut world = World::new(merged([0, 1, 1]), 3, 1);
    let mut rules = RuleDispatcher::new(&world.table, &[DispatchRule::Priority], Duration::from_secs(600));
    rules.jobs.parts.insert(PartId(2), PartPriority { due: None, priority: 3 });
    world.run(&mut rules, LONG);
    let decided = world.log.iter().find(|record| matches!(record.fact, RecordKind::Decided { .. })).unwrap();
    let text = serde_json::to_string(decided).unwrap();
    let by = concat!(
        r#""by":{"rule":{"rule":"priority","theirs":{"rule":"priority","class":0,"value":-3,"over":1},"#,
        r#""ours":{"rule":"priority","class":0,"value":0,"over":1}}}"#
    );
    assert!(text.contains(by), "{text}");
    assert_eq!(&serde_json::from_str::<Record>(&text).unwrap(), decided);
}

/// One station, one task; what is different from that.
struct Small {
    name: &'static str,
    task: &'static str,
    station: u16,
    parts: u32,
    weight: u32,
    limit_ms: u64,
}

const SMALL: Small = Small { name: "bench", task: "fetch", station: 0, parts: 2, weight: 1, limit_ms: 1000 };

fn small(of: &Small) -> Arc<CellTable> {
    let mut b = NetBuilder::new("small");
    let [stored, hand, out] =
        [("stored", of.parts), ("hands", 2), ("out", 0)].map(|(name, count)| b.place(name, count));
    let fetch = b.transition(of.name);
    b.input(fetch, stored, 1).input(fetch, hand, of.weight).output(fetch, hand, 1).output(fetch, out, 1);
    let net = ColouredBuilder::from_net(&b.build().unwrap()).build().unwrap();
    let kind = |name: &str| if name == "hands" { TOKENS } else { PARTS };
    Compiled::new(net, kind, |_| ordered(of.task, &[of.station], of.limit_ms)).table
}

#[test]
fn a_table_has_another_digest_exactly_if_its_records_mean_something_else() {
    let digest = |of: Small| small(&of).digest();
    let usual = digest(SMALL);
    assert_eq!(usual, digest(SMALL));
    let other = small(&Small { limit_ms: 9000, ..SMALL });
    let ActivityTiming::Decided { time, .. } = other.activity(ModeId(0)).kind else { panic!("it is decided") };
    assert_eq!((time, other.digest()), (Duration::from_millis(4500), usual), "times may be changed");
    let others = [
        digest(Small { name: "other", ..SMALL }),
        digest(Small { task: "bring", ..SMALL }),
        digest(Small { station: 1, ..SMALL }),
        digest(Small { parts: 3, ..SMALL }),
        digest(Small { weight: 2, ..SMALL }),
    ];
    for (at, one) in others.iter().enumerate() {
        assert!(*one != usual && !others[..at].contains(one), "{at}");
    }
}
