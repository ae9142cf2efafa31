//! Two operators at the panels, in manual, pressing whatever they like at the same time.

use std::collections::HashMap;

use linewright_msgs::{StationEvent, StationState};

use crate::support::operator::{Finger, Operator, STATIONS};
use crate::support::pause;
use crate::support::rig::{Rig, line};

/// Presses of each operator.
const PRESSES: usize = 90;

/// Marsaglia's xorshift: enough to press buttons with, and the same for the same seed everywhere.
struct Dice(u64);

impl Dice {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % bound
    }
}

#[test]
fn two_operators_press_at_random_and_never_reach_a_conflict() {
    let mut rig = Rig::new(&line(0.3));
    rig.start(&["--no-auto"]);
    let operators = [Operator::join(&rig), Operator::join(&rig)];
    operators[0].order("start", StationState::MODE_STANDBY);
    operators[0].order("manual", StationState::MODE_MANUAL);
    let refused = operators[0].jog("mill_1", "advance");
    assert!(!refused, "no tool on an open clamp");
    std::thread::scope(|scope| {
        for (operator, seed) in operators.iter().zip([0x9E37_79B9, 0x85EB_CA6B]) {
            scope.spawn(move || fidget(operator, Dice(seed)));
        }
    });
    operators[0].wait("everything stands", |heard| heard.all(|state| state.stopped));
    {
        let seen = rig.eye.seen();
        assert_eq!(seen.conflicts(), [""; 0]);
        let of: HashMap<&str, usize> = seen.starts().iter().fold(HashMap::new(), |mut counts, start| {
            *counts.entry(start.what.split(':').next().unwrap_or_default()).or_default() += 1;
            counts
        });
        assert!(of.get("transfer").is_some_and(|starts| *starts > 5), "much has moved: {of:?}");
    }
    for operator in &operators {
        let heard = operator.heard();
        let mut refusals = heard.events.iter().filter(|event| event.kind == StationEvent::KIND_REFUSED);
        assert!(refusals.any(|event| event.text.contains("advance clamp")), "the reason of a refusal is published");
    }
    // However they have left it, the line goes on.
    operators[1].recover();
    operators[1].cycles(2);
    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}

/// One hand on a button of the bar or the clamp, or sometimes the mill; forward more often than back, or they would
/// never get anywhere.
fn fidget(operator: &Operator, mut dice: Dice) {
    let mut finger: Option<Finger> = None;
    for _ in 0..PRESSES {
        drop(finger.take());
        let station = STATIONS[[0, 0, 0, 1, 1, 2][dice.below(6) as usize]];
        let side = if dice.below(10) < 6 { "advance" } else { "return" };
        finger = Some(operator.hold(station, side));
        pause(20 + dice.below(180));
    }
}
