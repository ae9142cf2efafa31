//! Acknowledging an alarm: that a person has seen it, whatever becomes of its cause.

use linewright_console_view::{AlarmPart, ConsolePage};
use linewright_msgs::Bounded;

use crate::bench::{ViewBench, ms};
use crate::cell::cell;

fn of<'p>(page: &'p ConsolePage, key: &str) -> &'p AlarmPart {
    // Those of a cell have the time at which they were raised behind.
    let is_it =
        |alarm: &&AlarmPart| alarm.key.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with(' '));
    page.alarms.iter().find(is_it).unwrap_or_else(|| panic!("{key}: {:?}", page.alarms))
}

fn by(page: &ConsolePage, key: &str) -> Option<(String, String, String)> {
    of(page, key).acknowledged.clone().map(|of| (of.by, of.note, of.age))
}

fn acknowledge(bench: &mut ViewBench, at: u64, shown: u64) -> Result<(), String> {
    bench.view.acknowledge(ms(at), shown, "Ada (127.0.0.1:1001)".to_owned(), "fetching a key".to_owned()).map(drop)
}

#[test]
fn an_alarm_is_acknowledged_with_a_note_and_stays_until_its_cause_is_gone() {
    let mut bench = ViewBench::received(0);
    let fault = "mill_1 fault watchdog";
    let at = bench.line.station_named("mill_1").expect("a mill").index();
    bench.stations[at].as_mut().expect("received").0.fault = "watchdog".to_owned();
    let page = bench.page(10);
    assert_eq!((of(&page, fault).state, by(&page, fault)), ("active, not acknowledged", None));
    let shown = of(&page, fault).shown;
    acknowledge(&mut bench, 20, shown).expect("it stands");
    let page = bench.page(400);
    assert_eq!(of(&page, fault).state, "active, acknowledged");
    let expected = ("Ada (127.0.0.1:1001)".to_owned(), "fetching a key".to_owned(), "0 s".to_owned());
    assert_eq!((by(&page, fault), page.alarms.len()), (Some(expected), 1));
    // Gone, and there again: it is another one.
    bench.stations[at].as_mut().expect("received").0.fault = String::new();
    assert!(bench.page(410).alarms.is_empty());
    assert_eq!(acknowledge(&mut bench, 420, shown), Err("not acknowledged: the alarm is over".to_owned()));
    bench.stations[at].as_mut().expect("received").0.fault = "watchdog".to_owned();
    let page = bench.page(430);
    assert_eq!((of(&page, fault).state, of(&page, fault).shown > shown), ("active, not acknowledged", true));
}

/// What was seen was another cause.
#[test]
fn an_alarm_of_the_line_with_another_text_is_not_acknowledged() {
    let mut bench = ViewBench::received(0);
    let obstacles = "line obstacles ";
    let put = |bench: &mut ViewBench, text: &str| {
        bench.coordinator.as_mut().expect("received").0.obstacles = vec![text.to_owned()];
    };
    put(&mut bench, "mill_1: I/O devices lost");
    let shown = of(&bench.page(10), obstacles).shown;
    acknowledge(&mut bench, 20, shown).expect("it stands");
    assert_eq!(of(&bench.page(30), obstacles).state, "active, acknowledged");
    put(&mut bench, "clamp_1: no memory of the cycle");
    assert_eq!(of(&bench.page(40), obstacles).state, "active, not acknowledged");
}

/// A cell that was started anew without its log gives its alarms the same numbers again.
#[test]
fn an_alarm_of_a_cell_raised_anew_is_another_one() {
    let mut bench = ViewBench::new(true);
    bench.cell = Some((cell(), 0));
    let shown = of(&bench.page(0), "cell 4").shown;
    acknowledge(&mut bench, 0, shown).expect("it stands");
    let mut anew = cell();
    let mut alarms = anew.alarms.as_slice().to_vec();
    alarms.iter_mut().for_each(|alarm| alarm.raised.sec += 100);
    anew.alarms = Bounded::new(alarms).expect("it fits");
    bench.cell = Some((anew, 9_000));
    assert_eq!(of(&bench.page(9_000), "cell 4").state, "active, not acknowledged");
}

/// A connection that is lost for a while is no end of an alarm.
#[test]
fn an_acknowledgement_outlasts_the_time_in_which_its_node_is_not_received() {
    let mut bench = ViewBench::new(true);
    bench.cell = Some((cell(), 0));
    let page = bench.page(0);
    let shown = of(&page, "cell 4").shown;
    assert_ne!(shown, of(&page, "cell 9").shown);
    acknowledge(&mut bench, 0, shown).expect("it stands");
    // That it is not received is an alarm of its own, with an acknowledgement of its own.
    let page = bench.page(5_000);
    assert!(page.alarms.iter().all(|alarm| alarm.number.is_none()));
    let silence = of(&page, "cell not received ").shown;
    acknowledge(&mut bench, 5_000, silence).expect("it stands");
    bench.cell = Some((cell(), 6_000));
    let page = bench.page(6_000);
    assert_eq!((of(&page, "cell 4").shown, of(&page, "cell 4").state), (shown, "active, acknowledged"));
    assert_eq!(of(&page, "cell 9").state, "active, not acknowledged");
    // Over, while it is received.
    let mut without = cell();
    without.alarms = Bounded::default();
    bench.cell = Some((without, 7_000));
    bench.page(7_000);
    assert!(acknowledge(&mut bench, 7_000, shown).is_err());
    let page = bench.page(12_000);
    assert_eq!(of(&page, "cell not received ").state, "active, not acknowledged", "it is another silence");
}
