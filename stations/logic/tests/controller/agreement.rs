//! Withdrawal of a count by agreement: requests, answers, and their effects.

use linewright_line::net::ControlMode;
use linewright_line::{Line, OpId, StationId};
use linewright_station_logic::{AgreementAnswer, AgreementRequest, Restore, StationReport};

use super::rig::{Rig, peer_says};
use linewright_testkit::built::{arrow, line, r, station};

const A: StationId = StationId(0);
const B: StationId = StationId(1);

/// Op 0 of `b` may start when op 0 of `a` is done, and op 0 of `a` again when op 1 of `b` was done in the cycle before.
fn pair() -> Line {
    let stations = vec![station("a", 1, &[r(6), r(6)], 0, false), station("b", 1, &[r(6), r(6)], 8, false)];
    line(stations, vec![arrow((0, 0), (1, 0), 0), arrow((1, 1), (0, 0), 1)])
}

fn b_says(answer: Option<(u64, Option<OpId>)>) -> StationReport {
    let answers = answer.map(|(number, in_the_way)| AgreementAnswer { to: A, boot_id: 1, number, in_the_way });
    StationReport { answers: answers.into_iter().collect(), ..peer_says(&[0, 0]) }
}

/// `a` has done op 0 and holds the return button; its request is out.
fn asking() -> (Rig, u64) {
    let mut rig = Rig::new(pair());
    rig.hear(B, b_says(None));
    rig.mode(ControlMode::Manual);
    rig.advance_through(0);
    rig.events();
    rig.retract(true);
    let number = rig.report().request.expect("it asks").number;
    (rig, number)
}

#[test]
fn nothing_moves_before_the_dependent_station_has_agreed() {
    let (mut rig, number) = asking();
    assert_eq!((rig.outputs, rig.report().done), (0, vec![1, 0]));
    assert_eq!(rig.blocked_by().last().map(String::as_str), Some("agreement of b to take back op 0"));
    rig.hear(B, b_says(Some((number, None))));
    assert!(rig.drives_back(0));
    assert_eq!((rig.report().done, rig.report().request), (vec![0, 0], None), "withdrawn as the motion starts");
}

#[test]
fn a_refusal_names_the_operation_in_the_way_and_asks_no_more_until_pressed_again() {
    let (mut rig, number) = asking();
    rig.hear(B, b_says(Some((number, Some(OpId(0))))));
    assert_eq!(
        rig.events(),
        ["requested agreement (request 1)", "request rejected by b: op 0 has started", "rejected the command"]
    );
    assert_eq!(
        rig.blocked_by().last().map(String::as_str),
        Some("op 0 to be taken back: rejected by b, op 0 has started")
    );
    rig.wait_ms(1000);
    assert_eq!((rig.outputs, rig.report().request, rig.events()), (0, None, vec![]));
    rig.retract(false);
    rig.retract(true);
    assert_eq!(rig.report().request.map(|r| r.number), Some(number + 1));
}

/// t12 is a level: held against a refusal it would request again with every message.
#[test]
fn a_held_reverse_sequence_that_is_refused_asks_once() {
    let stations = vec![station("a", 2, &[r(3), r(5), r(6)], 0, false), station("b", 1, &[r(6), r(6)], 8, false)];
    let mut rig = Rig::new(line(stations, vec![arrow((0, 0), (1, 0), 0)]));
    rig.mode(ControlMode::Hand);
    rig.hear(B, peer_says(&[1, 0]));
    rig.hold(0);
    rig.arrive(0);
    rig.arrive(1);
    rig.release(0);
    rig.hold(1);
    rig.arrive_back(1);
    let number = rig.report().request.expect("t12 asks for op 0").number;
    rig.hear(B, b_says(Some((number, Some(OpId(0))))));
    rig.events();
    rig.wait_ms(1000);
    assert_eq!((rig.events(), rig.report().request), (vec![], None));
    rig.release(1);
    rig.hold(1);
    assert_eq!(rig.report().request.map(|r| r.number), Some(number + 1));
}

#[test]
fn an_agreement_to_an_earlier_request_is_worth_nothing() {
    let (mut rig, number) = asking();
    rig.retract(false);
    assert_eq!(rig.report().request, None, "released: given up");
    rig.retract(true);
    rig.hear(B, b_says(Some((number, None))));
    assert_eq!(rig.outputs, 0);
    rig.hear(B, b_says(Some((number + 1, None))));
    assert!(rig.drives_back(0));
}

#[test]
fn an_agreement_given_to_another_life_is_worth_nothing() {
    let (mut rig, number) = asking();
    let other = AgreementAnswer { to: A, boot_id: 99, number, in_the_way: None };
    rig.hear(B, StationReport { answers: vec![other], ..peer_says(&[0, 0]) });
    assert_eq!(rig.outputs, 0);
}

#[test]
fn an_agreement_whose_giver_has_fallen_silent_is_not_acted_on() {
    let (mut rig, number) = asking();
    rig.retract(false);
    rig.order.lease = std::time::Duration::from_secs(60);
    rig.order();
    rig.silence_ms(1200);
    rig.retract(true);
    assert_eq!(rig.outputs, 0);
    assert_eq!(
        rig.blocked_by().last().map(String::as_str),
        Some("agreement of b (no state received) to take back op 0")
    );
    rig.hear(B, b_says(Some((number + 1, None))));
    assert!(rig.drives_back(0));
}

/// The token left the place while the request was out: an agreement to the count that was is none to the next one.
#[test]
fn a_request_ends_when_its_token_moves_on() {
    let mut rig = Rig::new(pair());
    rig.hear(B, b_says(None));
    rig.mode(ControlMode::Hand);
    rig.hold(0);
    rig.arrive(0);
    rig.release(0);
    rig.hold(1);
    let number = rig.report().request.expect("it asks").number;
    rig.hold(2);
    assert!(rig.drives(1), "on to op 1 meanwhile");
    rig.step();
    assert_eq!(rig.report().request, None);
    rig.hear(B, b_says(Some((number, None))));
    assert!(rig.drives(1));
    assert_eq!(rig.report().done, [1, 0]);
}

fn answer_of_b(b: &Rig) -> Option<Option<OpId>> {
    b.report().answers.first().map(|answer| answer.in_the_way)
}

fn a_asks(number: u64) -> StationReport {
    StationReport { request: Some(AgreementRequest { number, ops: 1 }), ..peer_says(&[1, 0]) }
}

#[test]
fn an_operation_that_has_started_is_in_the_way_until_it_has_been_undone() {
    let mut b = Rig::of(pair(), B, Restore::Fresh);
    b.hear(A, peer_says(&[1, 0]));
    b.mode(ControlMode::Manual);
    b.advance(true);
    assert!(b.drives(0));
    b.hear(A, a_asks(1));
    assert_eq!(answer_of_b(&b), Some(Some(OpId(0))));
    b.advance(false);
    b.retract(true);
    b.hear(A, a_asks(2));
    assert_eq!(answer_of_b(&b), Some(Some(OpId(0))), "still on its way back");
    b.arrive_back(0);
    assert_eq!(answer_of_b(&b), Some(Some(OpId(0))), "an answer stands");
    b.hear(A, a_asks(3));
    assert_eq!(answer_of_b(&b), Some(None));
}

/// The arrows from one peer are not looked up among the counts of another, which may be fewer.
#[test]
fn a_station_with_two_peers_answers_each_by_its_own_counts() {
    let stations = vec![
        station("long", 4, &[r(6), r(6), r(6), r(6), r(6)], 0, false),
        station("middle", 1, &[r(6), r(6)], 10, false),
        station("short", 1, &[r(6), r(6)], 20, false),
    ];
    let line = line(stations, vec![arrow((0, 3), (1, 1), 0), arrow((2, 1), (1, 0), 1)]);
    let mut middle = Rig::of(line, B, Restore::Fresh);
    middle.hear(
        StationId(2),
        StationReport { request: Some(AgreementRequest { number: 1, ops: 0b10 }), ..peer_says(&[0, 0]) },
    );
    assert_eq!(answer_of_b(&middle), Some(None));
}

#[test]
fn nothing_starts_on_a_count_that_is_being_taken_back() {
    let mut b = Rig::of(pair(), B, Restore::Fresh);
    b.hear(A, a_asks(1));
    assert_eq!(answer_of_b(&b), Some(None));
    b.mode(ControlMode::Auto);
    assert_eq!(b.outputs, 0);
    assert_eq!(b.blocked_by(), ["a: op 0 (being taken back), for op 0"]);
    b.hear(A, peer_says(&[1, 0]));
    assert!(b.drives(0), "given up: the count stands");
}

#[test]
fn a_restart_forgets_the_answer_and_not_the_rule() {
    let mut b = Rig::of(pair(), B, Restore::Fresh);
    b.hear(A, a_asks(1));
    let mut again = Rig::of(pair(), B, Restore::From(b.controller.snapshot()));
    again.mode(ControlMode::Auto);
    again.hear(A, a_asks(1));
    assert_eq!(again.outputs, 0);
    assert_eq!(answer_of_b(&again), Some(None));
}
