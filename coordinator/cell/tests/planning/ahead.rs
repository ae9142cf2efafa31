//! Looking ahead: never worse than its rules where the horizon covers the work, bounded, the same every time, and no
//! part waits for ever because of it.

use std::time::Duration;

use linewright_coordinator_cell::ahead::{Ending, ForwardSimulation, LookAhead, Score, SimulationBasis};
use linewright_coordinator_cell::dispatch::{DispatchRule, RuleDispatcher};
use linewright_coordinator_cell::production::DispatchConfiguration;
use linewright_coordinator_cell::{DispatchDecision, Dispatcher, Fifo, HoldReason, Question, Record, RecordKind};
use linewright_line::Tick;

use super::shop::{ASSEMBLY, C1, Made, Shop};

const DAY: Duration = Duration::from_secs(86_400);
const LONG: Tick = Tick::from_millis(86_400_000);

fn desk(made: &Made, rules: &[DispatchRule], orders: &[(&str, u32, Option<u64>)]) -> DispatchConfiguration {
    DispatchConfiguration::new(RuleDispatcher::new(&made.table, rules, DAY), made.ordered(orders))
}

/// Result of a real run, by the same measures, from its log alone.
fn measured(made: &Made, shop: &Shop, due: impl Fn(&str) -> Option<u64>) -> (u64, u64) {
    let mut tardiness = 0;
    let mut product = std::collections::BTreeMap::new();
    let mut leaving = std::collections::BTreeMap::new();
    for record in &shop.log {
        match &record.fact {
            RecordKind::Started { firing, mode, part: Some(part), .. } => {
                let name = made.table.mode_name(*mode);
                if name.starts_with("enter") || name.starts_with("arrive") {
                    let of = name.split(['<', '.']).nth(1).unwrap().to_owned();
                    product.insert(*part, of);
                } else if name.starts_with("leave") || name.starts_with("depart") {
                    leaving.insert(*firing, *part);
                }
            }
            RecordKind::Ended { firing } => {
                if let Some(due) = leaving.get(firing).and_then(|part| due(&product[part])) {
                    tardiness += record.at.since(Tick::from_millis(due * 1000)).as_micros() as u64;
                }
            }
            _ => (),
        }
    }
    (tardiness, shop.makespan().as_micros())
}

const ORDERS: [&[(&str, u32, Option<u64>)]; 4] = [
    &[("1", 1, None), ("2", 1, None), ("3", 1, None)],
    &[("1", 2, Some(20)), ("2", 2, Some(15)), ("3", 1, Some(40))],
    &[("1", 2, None), ("2", 2, None), ("3", 2, None)],
    &[("1", 1, Some(60)), ("2", 2, Some(10)), ("3", 3, Some(25))],
];

/// Played for real, by nominal times: tardiness first, then makespan, are never worse than those of the rules looked ahead
/// over, and in some cases better.
#[test]
fn looking_ahead_over_all_of_it_is_never_worse_than_its_rules() {
    let (assembly, c1) = (Made::new(ASSEMBLY), Made::new(C1));
    let renamed = |orders: &[(&str, u32, Option<u64>)]| -> Vec<(&'static str, u32, Option<u64>)> {
        // One order of each product, so that a part's due date is known by what it is.
        let product = |name: &str| if name == "2" { "B" } else { "A" };
        let of_c1 = orders.iter().filter(|(name, ..)| *name != "3");
        of_c1.map(|&(name, count, due)| (product(name), count + 1, due.map(|due| due * 8))).collect()
    };
    let mut better = 0;
    for orders in ORDERS {
        for (made, orders) in [(&assembly, orders.to_vec()), (&c1, renamed(orders))] {
            for (_, rule) in DispatchRule::ALL.into_iter().filter(|(_, rule)| *rule != DispatchRule::Schedule) {
                let due = |name: &str| orders.iter().find(|(product, ..)| *product == name).and_then(|of| of.2);
                let mut base = desk(made, &[rule], &orders);
                let mut look = LookAhead::new(&made.table, base.clone(), DAY);
                look.effort = 100_000;
                let run = |dispatcher: &mut dyn Dispatcher| {
                    let mut shop = Shop::new(&made.table);
                    shop.run(dispatcher, LONG);
                    let parts: u32 = orders.iter().map(|(_, count, _)| count).sum();
                    assert_eq!(shop.state().left(), u64::from(parts), "all is done");
                    measured(made, &shop, due)
                };
                let (by_rules, ahead) = (run(&mut base), run(&mut look));
                assert!(ahead <= by_rules, "{rule} {orders:?}: {ahead:?} instead of {by_rules:?}");
                assert_eq!(look.worn(), 0);
                better += usize::from(ahead < by_rules);
            }
        }
    }
    assert!(better >= 10, "better in {better} of 48");
}

/// A simulation and the run after it agree, record for record, in a cell without deviations.
#[test]
fn a_cell_goes_as_simulated() {
    for (text, orders) in [(ASSEMBLY, vec![("1", 3, None), ("3", 3, None)]), (C1, vec![("A", 5, None), ("B", 4, None)])]
    {
        let made = Made::new(text);
        let desk = desk(&made, &[DispatchRule::ShortestProcessingTime], &orders);
        let mut shop = Shop::new(&made.table);
        shop.run(&mut desk.clone(), Tick::from_millis(20_000));
        // In the middle of it, with activities in progress.
        assert!(shop.state().firings().len() > 0);
        let mut simulated = desk.clone();
        shop.log.iter().for_each(|record| simulated.note(record));
        let mut real = simulated.clone();
        let basis = SimulationBasis::new(&made.table);
        let mut simulation = ForwardSimulation::new(shop.state(), basis.table(), shop.now);
        assert_eq!(simulation.play(&mut simulated, Tick::NEVER, 100_000), Ending::Still);
        let before = shop.starts().len();
        shop.run(&mut real, LONG);
        let name = |mode| made.table.mode_name(mode);
        let expected: Vec<_> = simulation.acts().iter().filter(|act| !act.was_running).collect();
        let expected: Vec<_> =
            expected.iter().map(|act| (act.from.as_micros() / 1000, name(act.mode), act.part)).collect();
        assert_eq!(shop.starts()[before..], expected);
        let score = Score::of(&simulation, &simulated, &basis, Ending::Still);
        assert_eq!((score.work, score.tardiness), (0, 0));
        assert_eq!(shop.makespan(), simulation.began() + Duration::from_micros(score.makespan));
    }
}

/// Bounded work: with too little of it the rules decide, and it is counted; nothing is simulated beyond it.
#[test]
fn with_too_little_effort_the_rules_decide() {
    let made = Made::new(C1);
    let orders = [("A", 3, None), ("B", 3, None)];
    let mut base = desk(&made, &[DispatchRule::Fifo], &orders);
    let mut look = LookAhead::new(&made.table, base.clone(), DAY);
    look.effort = 5;
    let run = |dispatcher: &mut dyn Dispatcher| {
        let mut shop = Shop::new(&made.table);
        shop.run(dispatcher, LONG);
        shop.log
            .iter()
            .filter(|record| !matches!(record.fact, RecordKind::Decided { .. }))
            .cloned()
            .collect::<Vec<Record>>()
    };
    assert_eq!(run(&mut look), run(&mut base));
    assert!(look.worn() > 10);
}

#[test]
fn the_same_questions_have_the_same_answers() {
    let made = Made::new(C1);
    let run = || {
        let mut look =
            LookAhead::new(&made.table, desk(&made, &[DispatchRule::Fifo], &[("A", 4, None), ("B", 4, None)]), DAY);
        let mut shop = Shop::new(&made.table);
        shop.run(&mut look, LONG);
        shop.log
    };
    assert_eq!(run(), run());
}

/// Counts how often the dispatcher beneath holds something because it looks worse.
struct Counting {
    look: LookAhead,
    held: usize,
    waits: usize,
}

impl Counting {
    fn new(look: LookAhead) -> Self {
        Counting { look, held: 0, waits: 0 }
    }
}

impl Dispatcher for Counting {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        let answer = self.look.decide(question);
        for held in &answer.held {
            if let HoldReason::LooksWorse(outlook) = held.reason {
                self.held += 1;
                self.waits += usize::from(outlook.instead.is_none());
            }
        }
        answer
    }

    fn note(&mut self, record: &Record) {
        self.look.note(record);
    }
}

/// M2 takes 200 s for what M1, which is just busy, takes 40 s for: it is better to wait, which no rule would.
#[test]
fn what_is_better_later_is_waited_for() {
    let made = Made::new(&C1.replace("time_s = 55", "time_s = 200"));
    let base = desk(&made, &[DispatchRule::Fifo], &[("A", 2, None)]);
    let run = |dispatcher: &mut dyn Dispatcher| {
        let mut shop = Shop::new(&made.table);
        shop.run(dispatcher, LONG);
        (shop.makespan(), shop.starts().iter().filter(|(_, name, _)| name.starts_with("load M2")).count())
    };
    let mut counting = Counting::new(LookAhead::new(&made.table, base.clone(), DAY));
    let (by_rules, ahead) = (run(&mut base.clone()), run(&mut counting));
    assert_eq!((by_rules.1, ahead.1), (1, 0));
    assert!(ahead.0 < by_rules.0 && counting.waits > 0, "{ahead:?} instead of {by_rules:?}");
}

/// It holds things back; and as soon as a part has waited too long it does not.
#[test]
fn patience_goes_before_looking_ahead() {
    let made = Made::new(C1);
    let orders = [("A", 6, None), ("B", 6, None)];
    let held = |patience: Duration| {
        let mut look = LookAhead::new(&made.table, desk(&made, &[DispatchRule::Fifo], &orders), DAY);
        look.effort = 20_000;
        look.desk.rules.fairness.patience = Some(patience);
        let mut counting = Counting::new(look);
        let mut shop = Shop::new(&made.table);
        shop.run(&mut counting, LONG);
        assert_eq!(shop.state().left(), 12);
        counting.held
    };
    assert!(held(DAY) > 0);
    assert_eq!(held(Duration::ZERO), 0);
}

/// A dispatcher that others follow after takes every record, once, in order.
#[test]
fn a_dispatcher_is_told_every_record() {
    struct Told(DispatchConfiguration, Vec<Record>);
    impl Dispatcher for Told {
        fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
            self.0.decide(question);
            Fifo.decide(question)
        }
        fn note(&mut self, record: &Record) {
            self.0.note(record);
            self.1.push(record.clone());
        }
    }
    let made = Made::new(ASSEMBLY);
    let mut told = Told(desk(&made, &[], &[("1", 1, None)]), Vec::new());
    let mut shop = Shop::new(&made.table);
    // First come, first served lets in whatever comes; so not for long.
    shop.run(&mut told, Tick::from_millis(30_000));
    // The life itself begins before any record is passed on.
    assert_eq!(shop.log[1..], told.1);
    assert!(told.1.len() > 20);
}
