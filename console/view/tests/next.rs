//! What comes next, and which station is to be confirmed by it.

use linewright_console_view::NextStep;
use linewright_line::StationId;
use linewright_line::net::ControlMode;
use linewright_msgs::StationState;
use linewright_recovery::{RecoveryAction, RecoveryEnd, RecoveryPlan, RecoveryStep, RejoinChoice};
use linewright_station_logic::RejoinAt;

/// `watch` named rejoin where `recover` had another way, which rejoin closes.
#[test]
fn a_confirmation_is_offered_where_it_comes_next_and_nowhere_else() {
    let line = linewright_line::parse("line.toml", &linewright_line::TransferLine::default().text());
    let line = line.expect("parses").line;
    let [first, second] = [StationId(0), StationId(1)];
    let confirm = RecoveryStep {
        action: RecoveryAction::Rejoin {
            station: second,
            at: RejoinChoice { at: RejoinAt::Measured, places: Vec::new(), on: 0, numbers: Vec::new(), activity: None },
            or: Vec::new(),
        },
        moves: Vec::new(),
        is_doubtful: false,
        mode: ControlMode::Manual,
        after: None,
    };
    let plan = RecoveryPlan::ends;
    let not_yet =
        |next: &NextStep| vec![format!("the confirmation of its position, which does not come next: {}", next.text())];
    let asks = StationState { blocked_by: vec!["rejoin: confirm it".to_owned()], ..StationState::default() };
    let waits = |next: &NextStep, id| next.shown(id, &asks).blocked_by.to_vec();
    let next = NextStep::of(&line, &plan(vec![confirm.clone()], RecoveryEnd::Auto)).expect("a step");
    assert_eq!((waits(&next, first), waits(&next, second)), (not_yet(&next), asks.blocked_by.to_vec()));
    assert!(next.line().starts_with(&format!("next: {}: look, and if", line.station(second).name)));
    let no_way = RecoveryEnd::NoWay { reasons: Vec::new(), is_certain: true };
    let next = NextStep::of(&line, &plan(vec![confirm], no_way)).expect("what is done by hand");
    assert_eq!((waits(&next, first), waits(&next, second)), (not_yet(&next), not_yet(&next)));
    assert!(next.line().contains("bring every station home by hand"), "{}", next.line());
    assert!(NextStep::of(&line, &plan(Vec::new(), RecoveryEnd::Auto)).is_none());
}
