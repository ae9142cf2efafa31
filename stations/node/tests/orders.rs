//! Orders in messages.

use linewright_msgs::RunTaskResult;
use linewright_station_logic::TaskRefusal;

#[test]
fn refusals_have_the_codes_that_messages_give_them() {
    let codes = [
        RunTaskResult::REFUSED_BUSY,
        RunTaskResult::REFUSED_MODE,
        RunTaskResult::REFUSED_OTHER_MEMORY,
        RunTaskResult::REFUSED_OLD_EPOCH,
        RunTaskResult::REFUSED_OLD,
        RunTaskResult::REFUSED_LATE,
        RunTaskResult::REFUSED_NOT_THERE,
        RunTaskResult::REFUSED_DEVICES,
        RunTaskResult::REFUSED_UNKNOWN,
        RunTaskResult::REFUSED_INCOMPLETE,
        RunTaskResult::REFUSED_ISOLATED,
    ];
    assert_eq!(TaskRefusal::ALL.map(TaskRefusal::code), codes);
}
