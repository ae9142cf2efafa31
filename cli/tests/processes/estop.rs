//! Emergency stop by topic, in the middle of a motion.
//!
//! ```text
//!   auto ── estop ──▶ every output off ── reset ──▶ still e-stop ── manual ──▶ recovered ──▶ auto
//! ```

use std::time::Duration;

use linewright_msgs::StationState;

use crate::support::pause;
use crate::support::rig::{Rig, line};

/// It takes milliseconds; this is for a machine that is busy with other things.
const PROMPTLY: Duration = Duration::from_millis(1500);

#[test]
fn an_emergency_stop_switches_everything_off_and_only_manual_leads_out() {
    // Slow enough that a motion is still under way when the stop arrives.
    let mut rig = Rig::new(&line(1.0));
    let operator = rig.in_stand_by();
    operator.order("auto", StationState::MODE_AUTO);
    // The bar runs back while the mill works: two motions at once.
    rig.eye.wait("two motions", |seen| seen.energised().len() == 2);
    operator.say("estop");
    rig.eye.within(PROMPTLY, "every output off", |seen| seen.energised().is_empty());
    operator.wait("e-stop", |heard| heard.all(|state| state.mode == StationState::MODE_ESTOP));
    let stopped = ["transfer", "mill_1"].map(|name| operator.station(name).incomplete);
    assert!(stopped.iter().all(|incomplete| !incomplete.is_empty()), "both were stopped on their way: {stopped:?}");

    let started = rig.eye.seen().starts().len();
    for command in ["auto", "hand", "start", "manual"] {
        let refusal = operator.refused(command);
        assert!(refusal.contains("emergency stop"), "{refusal}");
    }
    operator.say("reset");
    pause(500);
    assert_eq!(operator.heard().line.mode, StationState::MODE_ESTOP, "a reset leads nowhere");
    let refusal = operator.refused("auto");
    assert!(refusal.contains("emergency stop"), "{refusal}");
    assert_eq!(&rig.eye.seen().starts()[started..], [], "and nothing has moved");

    operator.recover();
    assert_eq!(rig.eye.seen().conflicts(), [""; 0]);
}
