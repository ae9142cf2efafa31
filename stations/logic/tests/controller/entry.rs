//! Motions by measured positions alone: requests, answers and their effects. The clamp closes into the state in which it is in
//! conflict with the bar; the two have no generation in common.

use linewright_line::net::ControlMode;
use linewright_line::{OpId, StationId};
use linewright_station_logic::{AgreementRequest, PanelCommand, StationReport};
use linewright_testkit::built::transfer_line;

use super::interlock::{BAR, GENERATION, InterlockBench, MILL};

fn asking() -> (InterlockBench, u64) {
    let mut bench = InterlockBench::new(transfer_line(), 0);
    bench.agree = false;
    bench.mode(ControlMode::Manual);
    bench.press(PanelCommand::Advance);
    let request = bench.clamp.request().unwrap_or_else(|| panic!("{}", bench.blocked()));
    assert_eq!((request.ops, bench.drives(bench.closing())), (0, false), "{}", bench.blocked());
    (bench, request.number)
}

fn answers(bench: &mut InterlockBench, boot_id: u64, number: u64, in_the_way: Option<OpId>) {
    bench.answer(boot_id, number, in_the_way);
    bench.play();
}

fn requests(of: fn(&mut InterlockBench) -> &mut StationReport, bench: &mut InterlockBench, number: Option<u64>) {
    of(bench).request = number.map(|number| AgreementRequest { number, ops: 0 });
    bench.play();
}

fn answer(bench: &InterlockBench, to: StationId) -> Option<(u64, Option<OpId>)> {
    let report = bench.clamp.report();
    report.answers.iter().find(|answer| answer.to == to).map(|answer| (answer.number, answer.in_the_way))
}

#[test]
fn it_starts_when_the_other_station_has_agreed_to_this_very_request() {
    let (mut bench, number) = asking();
    assert!(bench.blocked().contains("agreement of transfer to stand meanwhile"), "{}", bench.blocked());
    answers(&mut bench, 1, number + 1, None);
    answers(&mut bench, 2, number, None);
    assert!(!bench.drives(bench.closing()), "another request's, and that of another life");
    answers(&mut bench, 1, number, None);
    assert!(bench.drives(bench.closing()), "{}", bench.blocked());
    assert_eq!(bench.clamp.request(), None);
}

#[test]
fn with_a_generation_in_common_it_starts_at_once() {
    let mut bench = InterlockBench::new(transfer_line(), GENERATION);
    bench.mode(ControlMode::Manual);
    bench.press(PanelCommand::Advance);
    assert!(bench.drives(bench.closing()), "{}", bench.blocked());
}

#[test]
fn what_moves_there_is_named_and_the_command_is_given_again() {
    let (mut bench, number) = asking();
    answers(&mut bench, 1, number, Some(OpId(0)));
    let op = &bench.line.operation((BAR, OpId(0))).name;
    let expected =
        format!("transfer to stand ({op} is under way): nothing else keeps the two apart; command it again then");
    assert!(bench.blocked().contains(&expected), "{}", bench.blocked());
    for _ in 0..20 {
        bench.play();
    }
    assert_eq!(bench.clamp.request(), None, "held on, it is not made again");
    bench.release();
    bench.press(PanelCommand::Advance);
    assert_eq!(bench.clamp.request().map(|request| request.number), Some(number + 1));
}

#[test]
fn let_go_the_request_is_closed_and_a_late_agreement_moves_nothing() {
    let (mut bench, number) = asking();
    bench.release();
    assert_eq!(bench.clamp.request(), None);
    answers(&mut bench, 1, number, None);
    assert!(!bench.drives(bench.closing()));
}

#[test]
fn a_station_that_stands_agrees_and_makes_no_request_while_it_sees_one() {
    let mut bench = InterlockBench::new(transfer_line(), 0);
    bench.agree = false;
    bench.mode(ControlMode::Manual);
    requests(|bench| &mut bench.bar, &mut bench, Some(7));
    assert_eq!(answer(&bench, BAR), Some((7, None)));
    bench.press(PanelCommand::Advance);
    assert_eq!(bench.clamp.request(), None);
    assert!(bench.blocked().contains("transfer to stand (is about to move)"), "{}", bench.blocked());
    bench.release();
    requests(|bench| &mut bench.bar, &mut bench, None);
    bench.press(PanelCommand::Advance);
    assert!(bench.clamp.request().is_some(), "{}", bench.blocked());
}

#[test]
fn a_station_that_moves_does_not_agree() {
    let (mut bench, number) = asking();
    answers(&mut bench, 1, number, None);
    assert!(bench.drives(bench.closing()));
    requests(|bench| &mut bench.bar, &mut bench, Some(7));
    assert_eq!(answer(&bench, BAR), Some((7, Some(bench.op("advance clamp")))));
}

/// The image may be from before its outputs went off, and show a switch that it has left since.
#[test]
fn a_station_that_has_just_stopped_agrees_when_it_has_stood_and_is_measured() {
    let (mut bench, number) = asking();
    bench.under = 1;
    answers(&mut bench, 1, number, None);
    bench.release();
    assert!(!bench.drives(bench.closing()));
    requests(|bench| &mut bench.bar, &mut bench, Some(7));
    bench.wait();
    assert_eq!(answer(&bench, BAR), None, "its image is from before");
    bench.under = u64::MAX - 1;
    bench.play();
    assert_eq!(answer(&bench, BAR), Some((7, None)));
    // On a bus of its own an image has no number to compare.
    let (mut bench, number) = asking();
    answers(&mut bench, 1, number, None);
    bench.release();
    requests(|bench| &mut bench.bar, &mut bench, Some(7));
    assert_eq!(answer(&bench, BAR), None);
    bench.wait();
    assert_eq!(answer(&bench, BAR), Some((7, None)));
}

/// What is put out may be an earlier life's.
#[test]
fn a_station_that_has_just_started_does_not_agree_on_an_image_under_other_outputs() {
    let mut bench = InterlockBench::new(transfer_line(), 0);
    bench.agree = false;
    bench.under = 0;
    bench.mode(ControlMode::Manual);
    requests(|bench| &mut bench.bar, &mut bench, Some(7));
    bench.wait();
    assert_eq!(answer(&bench, BAR), None);
    bench.under = 1;
    bench.play();
    assert_eq!(answer(&bench, BAR), Some((7, None)));
}

/// The mill has lost its generation while the request to the bar was open; it was not asked, and may move.
#[test]
fn a_station_that_was_not_asked_and_has_lost_its_generation_since_ends_the_request() {
    let mut bench = InterlockBench::standing(transfer_line(), GENERATION, &["LS_open"]);
    bench.agree = false;
    bench.bar.generation = GENERATION + 1;
    bench.mode(ControlMode::Manual);
    bench.press(PanelCommand::Advance);
    let request = bench.clamp.request().unwrap_or_else(|| panic!("{}", bench.blocked()));
    bench.mill.generation = 0;
    requests(|bench| &mut bench.mill, &mut bench, Some(9));
    assert!(matches!(answer(&bench, MILL), Some((9, Some(_)))) || bench.clamp.request().is_none());
    answers(&mut bench, 1, request.number, None);
    assert!(!bench.drives(bench.closing()), "{}", bench.blocked());
}

#[test]
fn of_two_requests_that_cross_that_of_the_station_listed_first_stands() {
    let (mut bench, _) = asking();
    requests(|bench| &mut bench.bar, &mut bench, Some(7));
    assert_eq!((answer(&bench, BAR), bench.clamp.request()), (Some((7, None)), None));
    bench.release();
    // The mill is listed after the clamp; with it the clamp is in conflict when it opens.
    let mut bench = InterlockBench::standing(transfer_line(), 0, &["LS_closed"]);
    bench.agree = false;
    bench.mode(ControlMode::Manual);
    bench.press(PanelCommand::Advance);
    let request = bench.clamp.request();
    assert!(request.is_some(), "{}", bench.blocked());
    requests(|bench| &mut bench.mill, &mut bench, Some(9));
    assert!(matches!(answer(&bench, MILL), Some((9, Some(_)))), "{:?}", answer(&bench, MILL));
    assert_eq!(bench.clamp.request(), request);
}
