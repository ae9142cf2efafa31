//! What may be reported how often.

use std::time::Duration;

use linewright_fieldbus_seam::Budget;
use linewright_line::Tick;

#[test]
fn a_budget_lets_a_few_through_and_then_one_every_so_often() {
    let mut budget = Budget::new(3, Duration::from_millis(100));
    let at = Tick::from_millis;
    let through = |budget: &mut Budget, now: u64| (0..10).filter(|_| budget.take(at(now))).count();
    assert_eq!(through(&mut budget, 1000), 3);
    assert_eq!(through(&mut budget, 1050), 0);
    assert_eq!(through(&mut budget, 1150), 1);
    assert_eq!(through(&mut budget, 9000), 3);
    // Called all the time, it gives no more than it earns.
    assert_eq!((9001..10001).map(|now| through(&mut budget, now)).sum::<usize>(), 10);
}
