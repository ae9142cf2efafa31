//! The automatic cycle of the transfer line as its observer sees it: in which order outputs come on.

use super::eye::Start;

/// One cycle, all but the bar's return: a chain in which each waits for the one before.
const CHAIN: [&str; 16] = [
    "transfer: lift_to_50",
    "transfer: lift_to_100",
    "transfer: lift_to_150",
    "transfer: lift_to_200",
    "transfer: advance",
    "transfer: lower_to_150",
    "transfer: lower_to_100",
    "transfer: lower_to_50",
    "transfer: lower_to_0",
    "clamp_1: close",
    "mill_1: rapid_advance",
    "mill_1: slow_advance",
    "mill_1: feed",
    "mill_1: rapid_return",
    "mill_1: reset",
    "clamp_1: open",
];
/// Runs beside the mill: after the clamp has closed, before the next lift.
pub const RETURN: &str = "transfer: return";

/// The starts seen are the chart's, cycle by cycle, and nothing else.
pub fn starts_follow_the_chart(starts: &[Start], cycles: usize) {
    let order: Vec<&str> = starts.iter().map(|start| start.what.as_str()).collect();
    let chain: Vec<&str> = order.iter().copied().filter(|what| *what != RETURN).collect();
    let expected: Vec<&str> = CHAIN.iter().copied().cycle().take(CHAIN.len() * cycles).collect();
    assert_eq!(chain, expected);
    assert_eq!(order.iter().filter(|what| **what == RETURN).count(), cycles);
    for (cycle, round) in order.chunks(CHAIN.len() + 1).enumerate() {
        // With as many starts in each round, a return in the wrong one would show in its neighbours.
        let at = round.iter().position(|what| *what == RETURN);
        let closed = round.iter().position(|what| *what == "clamp_1: close");
        assert!(at > closed && closed.is_some(), "cycle {}: {round:?}", cycle + 1);
    }
}
