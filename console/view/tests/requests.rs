//! Requests of a page to the coordinator of a cell: which the state of the cell permits, that the page needs control for them, and that
//! the reply is shown on the page that has asked.

use std::time::Duration;

use linewright_console_view::{
    CellRequest, ControlDesk, DeskEffect, OperateStates, PageAct, PageMessage, PageOperation, ResourceCommand, why_not,
};
use linewright_line::Line;
use linewright_msgs::CellState;

use crate::cell::cell;

const NOW: Duration = Duration::from_millis(1000);

fn line() -> Line {
    linewright_line::parse("line.toml", &linewright_line::TransferLine::default().text()).expect("parses").line
}

fn answer(alarm: u64, word: &str) -> PageAct {
    PageAct::Answer { alarm, word: word.to_owned() }
}

fn submit(quantity: u32) -> PageAct {
    PageAct::Submit { product: "A".to_owned(), quantity, name: " rush ".to_owned(), due_s: Some(600) }
}

fn cancel(order: &str) -> PageAct {
    PageAct::Cancel { order: order.to_owned() }
}

fn why() -> PageAct {
    PageAct::Why { about: "rush".to_owned() }
}

/// A desk with two pages, of which the first, Ada's, has control.
struct Bench {
    desk: ControlDesk,
    line: Line,
    cell: Option<CellState>,
}

impl Bench {
    fn new() -> Self {
        let line = line();
        let mut bench = Bench { desk: ControlDesk::new(&line), line, cell: Some(cell()) };
        bench.desk.opened(1, "127.0.0.1:1001");
        bench.desk.opened(2, "127.0.0.1:1002");
        bench.act(1, PageAct::Take { name: "Ada".to_owned() });
        bench
    }

    fn act(&mut self, connection: u64, act: PageAct) -> Vec<DeskEffect> {
        let states = OperateStates {
            coordinator: None,
            stations: vec![None; self.line.stations.len()],
            is_other_description: false,
            cell: self.cell.as_ref(),
        };
        let operation = PageOperation { seen_ms: NOW.as_millis() as u64, act, step: None };
        self.desk.take(NOW, connection, &operation, |act| why_not(&self.line, &states, act, |_| "manual"))
    }

    fn asked(&mut self, connection: u64, act: PageAct) -> Option<CellRequest> {
        self.act(connection, act).into_iter().find_map(|effect| match effect {
            DeskEffect::Ask { connection: of, request } => Some(request).filter(|_| of == connection),
            _ => None,
        })
    }

    fn note(&self, connection: u64) -> (String, String) {
        let note = self.desk.part(NOW).notes.remove(&connection);
        note.map(|of| (of.key, of.text)).unwrap_or_default()
    }
}

#[test]
fn an_answer_goes_to_the_coordinator_with_the_operator_and_its_reply_to_the_page_that_has_given_it() {
    let mut bench = Bench::new();
    let by = "Ada (127.0.0.1:1001)".to_owned();
    let effects = bench.act(1, answer(4, "scrap"));
    let request = CellRequest::Answer { alarm: 4, word: "scrap".to_owned(), by };
    let log = "answer \"scrap\" to alarm 4 by Ada (127.0.0.1:1001)".to_owned();
    assert_eq!(effects, [DeskEffect::Log(log), DeskEffect::Ask { connection: 1, request }]);
    // One at a time, and what was not given is not given later.
    assert_eq!(bench.asked(1, submit(1)), None);
    assert!(bench.note(1).1.contains("has no reply yet"), "{:?}", bench.note(1));
    let effects = bench.desk.answered(1, Err("robot moves; wait until it stands".to_owned()));
    let log = "answer \"scrap\" to alarm 4: refused: robot moves; wait until it stands".to_owned();
    assert_eq!(effects, [DeskEffect::Log(log)]);
    assert_eq!(bench.note(1), ("answer".to_owned(), "robot moves; wait until it stands".to_owned()));
    assert_eq!(bench.note(2), Default::default());
    assert!(bench.desk.answered(1, Ok("twice".to_owned())).is_empty(), "there is no request");
    // The page that has asked is gone: its reply is nobody else's.
    assert!(bench.asked(1, submit(1)).is_some());
    bench.desk.closed(NOW, 1);
    bench.desk.opened(1, "127.0.0.1:1003");
    assert!(bench.desk.answered(1, Ok("an order".to_owned())).is_empty());
    assert_eq!(bench.note(1), Default::default());
}

#[test]
fn what_is_not_possible_by_the_state_of_the_cell_is_refused_with_the_reason() {
    let mut bench = Bench::new();
    let mut refused = |act: PageAct| {
        assert_eq!(bench.asked(1, act.clone()), None, "{act:?}");
        bench.note(1).1
    };
    assert_eq!(refused(answer(5, "scrap")), "alarm 5 is over; another one may ask for something else");
    assert_eq!(refused(answer(4, "explode")), "\"explode\" is no answer to alarm 4; its answers: in-store, scrap");
    assert_eq!(refused(submit(0)), "a number of parts from 1 to 1000000");
    assert_eq!(refused(cancel("old")), "no order `old` that is not over");
    // What sensors contradict may be given: they are compared anew. What would be refused may not.
    assert!(bench.asked(1, answer(4, "in-store")).is_some());
    bench.desk.answered(1, Ok(String::new()));
    let mut refusing = cell();
    let alarms = refusing.alarms.as_slice().iter().cloned().map(|mut of| {
        of.verdicts[1] = linewright_msgs::AlarmState::VERDICT_REFUSED;
        of.verdict_reasons[1] = "robot moves".to_owned();
        of
    });
    refusing.alarms = linewright_msgs::Bounded::new(alarms.collect()).expect("few");
    bench.cell = Some(refusing);
    assert_eq!(bench.asked(1, answer(4, "scrap")), None);
    assert_eq!(bench.note(1).1, "refused now: robot moves");
    bench.cell = None;
    for act in [answer(4, "scrap"), submit(1), cancel("rush"), why()] {
        assert_eq!(bench.asked(1, act), None);
        assert_eq!(bench.note(1).1, "the state of the cell is not received");
    }
}

#[test]
fn only_the_page_in_control_asks_for_changes_and_every_page_asks_why() {
    let mut bench = Bench::new();
    let down = PageAct::Resource { resource: "M1".to_owned(), to: ResourceCommand::Down };
    for act in [
        answer(4, "scrap"),
        submit(1),
        cancel("rush"),
        down.clone(),
        PageAct::Acknowledge { shown: 1, note: String::new() },
    ] {
        assert!(bench.act(2, act).is_empty());
        assert_eq!(bench.note(2).1, "not given: this page has no control; take it first");
    }
    assert_eq!(bench.asked(2, why()), Some(CellRequest::Why { about: "rush".to_owned() }));
    let name = "rush".to_owned();
    let expected = CellRequest::Submit { product: "A".to_owned(), quantity: 2, name, due_s: Some(600) };
    assert_eq!(bench.asked(1, submit(2)), Some(expected));
    bench.desk.answered(1, Ok("production order 3: `rush`".to_owned()));
    assert_eq!(bench.note(1), ("submit".to_owned(), "production order 3: `rush`".to_owned()));
    let by = "Ada (127.0.0.1:1001)".to_owned();
    let expected = CellRequest::Resource { resource: "M1".to_owned(), to: ResourceCommand::Down, by };
    assert_eq!(bench.asked(1, down), Some(expected));
    // A note is one line, and short.
    let note = format!(" see\nthe fitter {}", "x".repeat(400));
    let effects = bench.act(1, PageAct::Acknowledge { shown: 7, note });
    let [DeskEffect::Acknowledge { connection: 1, shown: 7, by, note }] = &effects[..] else { panic!("{effects:?}") };
    assert_eq!((by.as_str(), note.chars().count()), ("Ada (127.0.0.1:1001)", 100));
    assert!(note.starts_with("see the fitter"), "{note}");
}

/// A page cannot make the console keep more than this, whatever it sends.
#[test]
fn requests_without_a_reply_are_bounded() {
    let mut bench = Bench::new();
    let asked = (10..100).filter(|connection| {
        bench.desk.opened(*connection, "127.0.0.1:2000");
        bench.asked(*connection, why()).is_some()
    });
    assert_eq!(asked.count(), 16);
    assert!(bench.note(50).1.contains("too many requests"), "{:?}", bench.note(50));
    bench.desk.answered(10, Ok("released".to_owned()));
    assert!(bench.asked(50, why()).is_some());
}

#[test]
fn requests_are_read_strictly() {
    let parse = |act: &str| PageMessage::parse(&format!(r#"{{"seen_ms":5,"act":{act}}}"#));
    let read = |act: &str| match parse(act) {
        Ok(PageMessage::Operated(of)) => of.act,
        other => panic!("{act}: {other:?}"),
    };
    assert_eq!(read(r#"{"answer":{"alarm":4,"word":"scrap"}}"#), answer(4, "scrap"));
    assert_eq!(
        read(r#"{"submit":{"product":"A","quantity":1}}"#),
        PageAct::Submit { product: "A".to_owned(), quantity: 1, name: String::new(), due_s: None }
    );
    assert_eq!(
        read(r#"{"resource":{"resource":"M1","to":"up"}}"#),
        PageAct::Resource { resource: "M1".to_owned(), to: ResourceCommand::Up }
    );
    for bad in [
        r#"{"answer":{"alarm":-1,"word":"scrap"}}"#,
        r#"{"answer":{"alarm":4}}"#,
        r#"{"submit":{"product":"A","quantity":1,"priority":9}}"#,
        r#"{"submit":{"product":"A","quantity":1.5}}"#,
        r#"{"resource":{"resource":"M1","to":"explode"}}"#,
        r#"{"acknowledge":{"shown":1}}"#,
    ] {
        assert!(parse(bad).is_err(), "{bad}");
    }
}
