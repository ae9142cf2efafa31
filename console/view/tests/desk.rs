//! Control by one page at a time, and buttons that are held: by example, and under everything that may get lost or late.

use std::sync::LazyLock;
use std::time::Duration;

use linewright_console_view::{
    BEAT_WITHIN, ControlDesk, DeskEffect, HoldButton, HoldMessage, INERT_FOR, OperateButton, PUBLISH_EVERY, PageAct,
    PageMessage, PageOperation, PlanPart, PlanStepPart, SEEN_WITHIN,
};
use linewright_line::Line;
use proptest::prelude::*;

fn line() -> &'static Line {
    static LINE: LazyLock<Line> = LazyLock::new(|| {
        linewright_line::parse("line.toml", &linewright_line::TransferLine::default().text()).expect("parses").line
    });
    &LINE
}

fn ms(of: u64) -> Duration {
    Duration::from_millis(of)
}

fn button() -> HoldButton {
    HoldButton::named(line(), Some("mill_1"), "advance").expect("a button")
}

fn press(number: u64) -> PageAct {
    PageAct::Press { number, station: Some("mill_1".to_owned()), button: "advance".to_owned() }
}

fn take() -> PageAct {
    PageAct::Take { name: String::new() }
}

fn command(word: &str) -> PageAct {
    PageAct::Command { word: word.to_owned(), station: None }
}

/// A desk with two pages, of which the first has control.
struct Bench {
    desk: ControlDesk,
    now: u64,
}

impl Bench {
    fn new() -> Self {
        let mut desk = ControlDesk::new(line());
        desk.opened(1, "127.0.0.1:1001");
        desk.opened(2, "127.0.0.1:1002");
        let mut bench = Bench { desk, now: 1000 };
        bench.act(1, take());
        bench
    }

    fn act(&mut self, connection: u64, act: PageAct) -> Vec<DeskEffect> {
        self.act_of(connection, act, 0)
    }

    /// What is done at a page that shows what is so old.
    fn act_of(&mut self, connection: u64, act: PageAct, age: u64) -> Vec<DeskEffect> {
        let operation = PageOperation { seen_ms: self.now - age, act, step: None };
        self.desk.take(ms(self.now), connection, &operation, |_| None)
    }

    fn due(&mut self) -> Vec<bool> {
        self.desk.due(ms(self.now), |_| None).0.into_iter().map(|of| of.is_held).collect()
    }

    /// Passes time with a beat before each look, until the button is held.
    fn hold(&mut self, number: u64) {
        self.act(1, press(number));
        for _ in 0..3 {
            self.due();
            self.now += 50;
            self.act(1, PageAct::Beat { number });
        }
        assert_eq!(self.due(), [true]);
    }

    fn note(&self) -> String {
        self.note_of(1)
    }

    fn note_of(&self, connection: u64) -> String {
        self.desk.part(ms(self.now)).notes.remove(&connection).map(|note| note.text).unwrap_or_default()
    }

    /// What is published over the next second without a word of any page.
    fn silence(&mut self) -> Vec<bool> {
        let mut all = Vec::new();
        for _ in 0..100 {
            self.now += 10;
            all.extend(self.due());
        }
        all
    }
}

#[test]
fn a_press_begins_and_ends_with_released_and_is_held_between() {
    let mut bench = Bench::new();
    bench.act(1, press(1));
    assert_eq!(bench.due(), [false]);
    assert!(bench.due().is_empty(), "not before the period is over");
    bench.now += 50;
    assert_eq!(bench.due(), [false]);
    bench.now += 50;
    bench.act(1, PageAct::Beat { number: 1 });
    assert_eq!(bench.due(), [true]);
    bench.now += 1;
    bench.act(1, PageAct::Release { number: 1 });
    assert_eq!(bench.due(), [false], "at once");
    assert_eq!(bench.silence(), [false, false]);
    assert_eq!(bench.note(), "", "letting go is nothing to be noted");
}

#[test]
fn whatever_ends_a_press_its_number_is_dead() {
    type End = fn(&mut Bench);
    let ends: [(&str, End); 8] = [
        ("let go", |of| drop(of.act(1, PageAct::Release { number: 1 }))),
        ("another number", |of| drop(of.act(1, PageAct::Beat { number: 2 }))),
        ("another press", |of| drop(of.act(1, press(2)))),
        ("a command", |of| drop(of.act(1, command("stop")))),
        ("control taken by another", |of| drop(of.act(2, take()))),
        ("a page that is behind", |of| drop(of.act_of(1, PageAct::Beat { number: 1 }, 501))),
        ("silence", |of| of.now += 260),
        ("what the button does is not possible any more", |of| {
            drop(of.desk.due(ms(of.now), |_| Some("not now".to_owned())));
        }),
    ];
    for (what, end) in ends {
        let mut bench = Bench::new();
        bench.hold(1);
        end(&mut bench);
        let after = |bench: &mut Bench| {
            bench.now += 50;
            bench.act(1, PageAct::Beat { number: 1 });
            bench.due()
        };
        let all: Vec<bool> = (0..20).flat_map(|_| after(&mut bench)).collect();
        assert!(all.len() >= 2 && !all.contains(&true), "{what}: {all:?}");
        bench.act(1, take());
        bench.act(1, press(1));
        assert!(!(0..20).flat_map(|_| after(&mut bench)).any(|held| held), "{what}: the same number again");
        bench.now += 1000;
        bench.hold(9);
    }
}

#[test]
fn without_a_beat_a_button_is_held_no_longer_than_its_bound() {
    let mut bench = Bench::new();
    bench.hold(1);
    let all = bench.silence();
    let held = all.iter().filter(|held| **held).count();
    assert_eq!(held as u128, BEAT_WITHIN.as_millis() / PUBLISH_EVERY.as_millis(), "{all:?}");
    assert_eq!(all[held..], [false; 3]);
    assert!(bench.note().contains("nothing came from the page for"), "{}", bench.note());
}

#[test]
fn a_connection_that_ends_takes_its_press_and_its_control_with_it() {
    let mut bench = Bench::new();
    bench.hold(1);
    bench.desk.closed(ms(bench.now), 1);
    assert!(bench.desk.part(ms(bench.now)).holder.is_none());
    assert_eq!(bench.silence(), [false; 3]);
}

#[test]
fn one_page_commands_and_the_other_is_answered_why_not() {
    let mut bench = Bench::new();
    let is_given = |effects: &[DeskEffect], word: &str| effects.contains(&DeskEffect::Command(word.to_owned()));
    assert!(is_given(&bench.act(1, command("start")), "start"));
    assert!(bench.act(2, command("stop")).is_empty());
    assert_eq!(bench.note_of(2), "not given: this page has no control; take it first");
    let taken = bench.act(2, PageAct::Take { name: " Ada\u{7} ".to_owned() });
    assert_eq!(taken, [DeskEffect::Log("control taken from 127.0.0.1:1001 by Ada (127.0.0.1:1002)".to_owned())]);
    assert!(bench.act(1, command("start")).is_empty());
    let effects = bench.act(2, command("stop"));
    assert_eq!(effects[0], DeskEffect::Log("stop commanded by Ada (127.0.0.1:1002)".to_owned()));
    assert!(is_given(&effects, "stop"));
    let holder = bench.desk.part(ms(bench.now + 62_000)).holder.expect("one has it");
    assert_eq!((holder.connection, &*holder.since), (2, "1 min 2 s"));
    bench.act(2, PageAct::GiveUp {});
    assert!(bench.desk.part(ms(bench.now)).holder.is_none() && bench.act(2, command("stop")).is_empty());
}

#[test]
fn a_note_belongs_to_the_page_that_has_asked() {
    let mut bench = Bench::new();
    bench.act_of(1, command("auto"), 600);
    bench.act(2, command("auto"));
    assert!(bench.note_of(1).contains("600 ms old") && bench.note_of(2).contains("no control"));
    // What is given at the one takes nothing from the other.
    bench.act(1, command("auto"));
    assert_eq!((bench.note_of(1), bench.note_of(2).is_empty()), (String::new(), false));
    bench.hold(1);
    bench.act(2, take());
    assert_eq!((bench.note_of(1).contains("no control any more"), bench.note_of(2)), (true, String::new()));
    bench.desk.closed(ms(bench.now), 1);
    assert!(bench.desk.part(ms(bench.now)).notes.is_empty(), "it ends with its connection");
    bench.desk.closed(ms(bench.now), 2);
    bench.act(2, command("auto"));
    assert!(bench.desk.part(ms(bench.now)).notes.is_empty(), "and a connection that is gone has none");
}

/// A plan whose next step is this, with the button of *advance* of this station.
fn plan(text: &str, station: &str) -> PlanPart {
    let act = PageAct::Press { number: 0, station: Some(station.to_owned()), button: "advance".to_owned() };
    let (label, key) = (format!("advance of {station}"), act.key().expect("a button"));
    let step = PlanStepPart { text: text.to_owned(), since: None, stands: Vec::new() };
    let button = Some(OperateButton { key, label, act, why_not: None });
    PlanPart { begin: Vec::new(), steps: vec![step], end: Vec::new(), next: Some(0), button, step: 0 }
}

/// One button does one thing after the other: the second press of a hurried finger is for the step before.
#[test]
fn the_button_of_the_next_step_does_nothing_for_a_while_after_its_step_has_changed() {
    let mut bench = Bench::new();
    let inert = INERT_FOR.as_millis() as u64;
    let shown = |bench: &mut Bench, station: &str| {
        let plan = bench.desk.plan(ms(bench.now), Some(plan("hold advance", station)), true).expect("it is shown");
        (plan.step, plan.button.expect("a button").why_not)
    };
    let at_button = |bench: &mut Bench, number: u64, step: u64| {
        let operation = PageOperation { seen_ms: bench.now, act: press(number), step: Some(step) };
        bench.desk.take(ms(bench.now), 1, &operation, |_| None);
        bench.desk.live().map(|(number, _)| number)
    };
    let (first, why) = shown(&mut bench, "mill_1");
    assert_eq!(why.as_deref(), Some("the step has just changed: read it, then press"));
    assert_eq!(at_button(&mut bench, 1, first), None, "inert at the beginning too");
    bench.now += inert;
    assert_eq!(shown(&mut bench, "mill_1"), (first, None));
    assert_eq!(at_button(&mut bench, 2, first), Some(2));
    bench.act(1, PageAct::Release { number: 2 });
    // What was just done is not what comes next, before that is known.
    assert_eq!(at_button(&mut bench, 3, first), None);
    // Another station's button stands there now.
    let (second, why) = shown(&mut bench, "clamp_1");
    assert!(second > first && why.is_some());
    assert_eq!(at_button(&mut bench, 3, first), None);
    assert_eq!(bench.note(), "not given: another step comes next by now; read it, then press");
    assert_eq!(at_button(&mut bench, 4, second), None);
    assert_eq!(bench.note(), "the step has just changed: read it, then press");
    bench.now += inert - 1;
    assert_eq!(at_button(&mut bench, 5, second), None);
    bench.now += 1;
    assert_eq!(at_button(&mut bench, 5, second), None, "the number was used");
    assert_eq!(at_button(&mut bench, 6, second), Some(6));
    bench.act(1, PageAct::Release { number: 6 });
    // Steps that are not those of what is received now are looked for.
    bench.desk.plan(ms(bench.now), Some(plan("hold advance", "clamp_1")), false);
    assert_eq!(at_button(&mut bench, 7, second), None);
    // The stop has no step to be late for, and a panel's own button none either.
    let operation = PageOperation { seen_ms: bench.now, act: command("estop"), step: Some(first) };
    assert!(!bench.desk.take(ms(bench.now), 1, &operation, |_| None).is_empty());
    bench.hold(8);
    // Without steps there is no button.
    bench.act(1, PageAct::Release { number: 8 });
    bench.desk.plan(ms(bench.now), None, true);
    bench.now += inert;
    for step in 0..20 {
        assert_eq!(at_button(&mut bench, 9 + step, step), None);
    }
}

#[test]
fn what_is_late_is_not_given_but_the_stop() {
    let mut bench = Bench::new();
    let bound = SEEN_WITHIN.as_millis() as u64;
    assert!(!bench.act_of(1, command("auto"), bound).is_empty());
    assert!(bench.act_of(1, command("auto"), bound + 1).is_empty());
    assert!(bench.note().contains("the page showed what was 501 ms old"), "{}", bench.note());
    assert!(bench.act_of(1, command("estop"), bound + 1).contains(&DeskEffect::Command("estop".to_owned())));
    assert!(bench.act_of(2, take(), bound + 1).is_empty(), "nor is control taken");
    // Of another console: later than now.
    let operation = PageOperation { seen_ms: bench.now + 1, act: command("auto"), step: None };
    assert!(bench.desk.take(ms(bench.now), 1, &operation, |_| None).is_empty());
    // What the mode does not take, and what does not exist.
    let operation = PageOperation { seen_ms: bench.now, act: command("hand"), step: None };
    assert!(bench.desk.take(ms(bench.now), 1, &operation, |_| Some("not possible in auto".to_owned())).is_empty());
    assert_eq!(bench.note(), "not possible in auto");
    assert!(bench.act(1, command("explode")).is_empty());
}

#[test]
fn messages_of_a_page_are_read_strictly() {
    let text = r#"{"seen_ms":5,"act":{"press":{"number":1,"station":"mill_1","button":"advance"}}}"#;
    let expected = PageOperation { seen_ms: 5, act: press(1), step: None };
    assert_eq!(PageMessage::parse(text), Ok(PageMessage::Operated(expected)));
    assert_eq!(PageMessage::parse("17"), Ok(PageMessage::Acknowledged(17)));
    for bad in ["", "+1", "99999999999999999999", "{}", "null", r#"{"seen_ms":5,"act":{"take":{}}}"#, "[1]", "1 "] {
        assert!(PageMessage::parse(bad).is_err(), "{bad}");
    }
    let long = format!(r#"{{"seen_ms":5,"act":{{"take":{{"name":"{}"}}}}}}"#, "x".repeat(600));
    assert!(PageMessage::parse(&long).is_err());
}

/// What may happen.
#[derive(Clone, Debug)]
enum Happening {
    Passes(u64),
    Acts { connection: u64, act: PageAct, age: u64 },
    Closes(u64),
    Looks { possible: bool },
}

fn happening() -> impl Strategy<Value = Happening> {
    let act = prop_oneof![
        // 0 stands for the number of the last press, or the one after it.
        40 => Just(PageAct::Beat { number: 0 }),
        1 => (1..6u64).prop_map(|number| PageAct::Beat { number }),
        4 => Just(press(0)),
        1 => (1..6u64).prop_map(press),
        1 => Just(PageAct::Release { number: 0 }),
        1 => Just(take()),
        1 => Just(command("stop")),
    ];
    let age = prop_oneof![20 => 0..400u64, 1 => 450..700u64];
    prop_oneof![
        60 => (1..120u64).prop_map(Happening::Passes),
        3 => (200..400u64).prop_map(Happening::Passes),
        90 => (prop_oneof![30 => Just(1u64), 1 => Just(2u64)], act, age)
            .prop_map(|(connection, act, age)| Happening::Acts { connection, act, age }),
        1 => (1..3u64).prop_map(Happening::Closes),
        90 => (0..60u8).prop_map(|of| Happening::Looks { possible: of > 0 }),
    ]
}

/// What is known of the present press by all that has happened, without the desk.
#[derive(Clone, Copy, Debug)]
struct Judged {
    number: u64,
    beat_at: u64,
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(600) })]
    #[test]
    fn a_button_is_held_only_while_fresh_beats_of_a_live_press_come_from_the_page_in_control(
        all in proptest::collection::vec(happening(), 1..150)
    ) {
        let mut bench = Bench::new();
        let (mut control, mut used, mut open) = (Some(1), [0u64; 3], [true; 3]);
        let mut judged: Option<Judged> = None;
        let mut was_held = false;
        for of in all {
            let now = bench.now;
            if judged.is_some_and(|of| now - of.beat_at > 250) {
                judged = None;
            }
            match of {
                Happening::Passes(long) => bench.now += long,
                Happening::Closes(connection) => {
                    bench.desk.closed(ms(now), connection);
                    open[connection as usize] = false;
                    if control == Some(connection) {
                        (control, judged) = (None, None);
                    }
                }
                Happening::Acts { connection, mut act, age } => {
                    let newest = used[connection as usize];
                    match &mut act {
                        PageAct::Beat { number } | PageAct::Release { number } if *number == 0 => *number = newest,
                        PageAct::Press { number, .. } if *number == 0 => *number = newest + 1,
                        _ => {}
                    }
                    // One that has run out unseen, since nothing has looked, is ended by the next press, which begins nothing then.
                    let was_live = bench.desk.live().is_some();
                    bench.act_of(connection, act.clone(), age);
                    let (at, is_fresh) = (connection as usize, age <= 500);
                    if !open[at] {
                        continue;
                    }
                    match act {
                        PageAct::Take { .. } if is_fresh => (control, judged) = (Some(connection), None),
                        _ if control != Some(connection) => {}
                        PageAct::Beat { number } => {
                            judged = judged.filter(|of| of.number == number && is_fresh).map(|of| Judged { beat_at: now, ..of });
                        }
                        PageAct::Press { number, .. } => {
                            let begins = judged.is_none() && !was_live && is_fresh && number > used[at];
                            used[at] = used[at].max(number);
                            judged = begins.then_some(Judged { number, beat_at: now });
                        }
                        PageAct::Take { .. } => {}
                        _ => judged = None,
                    }
                }
                Happening::Looks { possible } => {
                    let why_not = |_: &PageAct| (!possible).then(|| "not now".to_owned());
                    let (messages, _) = bench.desk.due(ms(now), why_not);
                    judged = judged.filter(|_| possible);
                    for HoldMessage { button: of, is_held } in messages {
                        prop_assert_eq!(of, button());
                        prop_assert!(!is_held || judged.is_some(), "held at {} ms without a live press", now);
                        was_held = is_held;
                    }
                    // The first look after an end publishes it, whenever the last message was.
                    prop_assert!(!was_held || judged.is_some(), "still held at {} ms", now);
                }
            }
        }
    }
}
