//! What the coordinator tells: the mode it orders and the state of the line.

use crate::invalid::{parallel, present, within};
use crate::macros::message;
use crate::{Header, Invalid, StationState};

message! {
    /// The coordinator's mode, sent again well within its lease. Never latched.
    "linewright_msgs" / ModeOrder
    fields {
        /// When it was decided.
        header: Header,
        /// Random, new with every start of the process; never 0.
        boot_id: u64,
        /// Grows with every message of this boot.
        sequence: u64,
        /// Grows with every change of mode; stations refuse an older one.
        epoch: u64,
        /// The mode, one of [`StationState`]'s `MODE_` constants.
        mode: u8,
        /// Every station has acknowledged the epoch: motion is allowed.
        enabled: bool,
        /// Each station halts at its home place.
        master_stop: bool,
        /// The round at whose end they halt there: how often a station has come home since it last stood at home with
        /// all others at the beginning.
        stop_round: i32,
        /// Every station's panel counts as switched to manual.
        manual_all: bool,
        /// Held hand buttons, one bit each.
        buttons: u32,
        /// A station that hears nothing for this long falls to stand-by.
        lease_ms: u32,
        /// The generation of counts that is founded, all stations standing at home; 0 for none.
        found_generation: u64,
        /// For each station, in the order of the description, the boot id that was seen at home: the life it is for.
        found_lives: Vec<u64>,
        /// Stations for which the mode is emergency stop, whatever it is for the others.
        stopped: Vec<String>,
    }
    ros name "ModeOrder", meaning |m| {
        present("boot_id", m.boot_id != 0)?;
        within("mode", m.mode, StationState::MODE_STANDBY, StationState::MODE_HOME)
    }
}

message! {
    /// What the coordinator knows and decides: latched, on change and at a fixed rate.
    "linewright_msgs" / LineState
    constants {
        /// Never heard.
        const HEARD_UNKNOWN: u8 = 0;
        /// Heard lately.
        const HEARD_FRESH: u8 = 1;
        /// Heard once, but not lately.
        const HEARD_STALE: u8 = 2;
    }
    fields {
        /// When this was true.
        header: Header,
        /// Random, new with every start of the process; never 0.
        boot_id: u64,
        /// Grows with every message of this boot.
        sequence: u64,
        /// Epoch of the mode.
        epoch: u64,
        /// The mode, one of [`StationState`]'s `MODE_` constants.
        mode: u8,
        /// Every station has acknowledged the epoch.
        enabled: bool,
        /// Each station halts at its home place.
        master_stop: bool,
        /// The mode in words.
        text: String,
        /// Why the last command was refused; empty if it was not.
        refusal: String,
        /// Refused commands since the start.
        refusals: u64,
        /// The stations of the line.
        stations: Vec<String>,
        /// How each is heard (`HEARD_`).
        station_heard: Vec<u8>,
        /// Whose acknowledgement is missing.
        waiting_for: Vec<String>,
    }
    ros name "LineState", meaning line_state
}

fn line_state(m: &LineState) -> Result<(), Invalid> {
    present("boot_id", m.boot_id != 0)?;
    within("mode", m.mode, StationState::MODE_STANDBY, StationState::MODE_HOME)?;
    parallel(("station_heard", m.station_heard.len()), ("stations", m.stations.len()))
}
