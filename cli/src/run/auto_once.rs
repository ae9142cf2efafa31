//! Mode commands by which `run` brings the line to auto, once. After a change of mode that is not its own it gives no further command.

use linewright_msgs::{LineState, StationState};

/// Next thing to do on the way to auto.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AutoStep {
    /// Give this command.
    Give(&'static str),
    Wait,
    /// Auto is in force.
    InAuto,
    /// Somebody else has changed the mode: no command is given any more.
    HandsOver,
    /// The coordinator was started again, and with it the mode: no command is given any more.
    Restarted,
}

/// How far the line has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
enum Reached {
    #[default]
    Nothing,
    StandBy,
    Auto,
}

#[derive(Debug, Default)]
pub struct AutoOnce {
    reached: Reached,
    is_handed_over: bool,
    /// Life of the coordinator that was received first.
    boot_id: Option<u64>,
}

impl AutoOnce {
    /// Where a person operates from the beginning.
    pub fn by_others() -> Self {
        AutoOnce { is_handed_over: true, ..AutoOnce::default() }
    }

    /// Leaves it to others from now on; false where that was so already.
    pub fn hand_over(&mut self) -> bool {
        !std::mem::replace(&mut self.is_handed_over, true)
    }

    /// `ready`: the devices of every station are heard. Auto that ends by itself before it is in force, as where a device is late,
    /// leads to stand-by, and is given again.
    pub fn next(&mut self, line: &LineState, ready: bool) -> AutoStep {
        if line.mode == StationState::MODE_AUTO && line.enabled {
            return AutoStep::InAuto;
        }
        if self.is_handed_over {
            return AutoStep::Wait;
        }
        if *self.boot_id.get_or_insert(line.boot_id) != line.boot_id {
            self.is_handed_over = true;
            return AutoStep::Restarted;
        }
        let now = match line.mode {
            StationState::MODE_AUTO => Reached::Auto,
            StationState::MODE_STANDBY => Reached::StandBy,
            _ => Reached::Nothing,
        };
        let is_led_away = self.reached > Reached::Nothing && now == Reached::Nothing;
        if is_led_away || (self.reached == Reached::Auto && line.master_stop) {
            self.is_handed_over = true;
            return AutoStep::HandsOver;
        }
        self.reached = self.reached.max(now);
        match line.mode {
            StationState::MODE_HOME if ready => AutoStep::Give("start"),
            StationState::MODE_STANDBY if ready => AutoStep::Give("auto"),
            _ => AutoStep::Wait,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(mode: u8) -> LineState {
        LineState { mode, ..LineState::default() }
    }

    #[test]
    fn the_line_is_brought_to_auto_once() {
        let [home, stand_by, auto] =
            [StationState::MODE_HOME, StationState::MODE_STANDBY, StationState::MODE_AUTO].map(state);
        let mut way = AutoOnce::default();
        assert_eq!(way.next(&home, false), AutoStep::Wait);
        assert_eq!(way.next(&home, true), AutoStep::Give("start"));
        assert_eq!(way.next(&stand_by, true), AutoStep::Give("auto"));
        // It ended before it was in force.
        assert_eq!(way.next(&auto, true), AutoStep::Wait);
        assert_eq!(way.next(&stand_by, true), AutoStep::Give("auto"));
        assert_eq!(way.next(&LineState { enabled: true, ..auto }, true), AutoStep::InAuto);
    }

    /// A coordinator that is started again reports *home* although no station was brought there, so home alone is no reason to give *start* and
    /// *auto*.
    #[test]
    fn a_coordinator_that_is_started_again_is_given_nothing() {
        let stand_by = state(StationState::MODE_STANDBY);
        let mut way = AutoOnce::default();
        assert_eq!(way.next(&stand_by, true), AutoStep::Give("auto"));
        let again = LineState { boot_id: 2, ..state(StationState::MODE_HOME) };
        assert_eq!((way.next(&again, true), way.next(&again, true)), (AutoStep::Restarted, AutoStep::Wait));
    }

    #[test]
    fn who_leads_the_line_elsewhere_decides_when_it_goes_on() {
        let stand_by = state(StationState::MODE_STANDBY);
        for other in
            [StationState::MODE_HOME, StationState::MODE_MANUAL, StationState::MODE_HAND, StationState::MODE_ESTOP]
        {
            let mut way = AutoOnce::default();
            assert_eq!(way.next(&stand_by, true), AutoStep::Give("auto"));
            assert_eq!(way.next(&state(other), true), AutoStep::HandsOver, "{other}");
            assert_eq!(way.next(&stand_by, true), AutoStep::Wait, "{other}");
            let auto = LineState { enabled: true, ..state(StationState::MODE_AUTO) };
            assert_eq!(way.next(&auto, true), AutoStep::InAuto, "{other}: they have given it");
        }
        let mut way = AutoOnce::default();
        way.next(&state(StationState::MODE_AUTO), true);
        let stopping = LineState { master_stop: true, ..state(StationState::MODE_AUTO) };
        assert_eq!(way.next(&stopping, true), AutoStep::HandsOver);
        assert_eq!(AutoOnce::by_others().next(&stand_by, true), AutoStep::Wait);
        let mut way = AutoOnce::default();
        assert_eq!((way.hand_over(), way.next(&stand_by, true), way.hand_over()), (true, AutoStep::Wait, false));
    }
}
