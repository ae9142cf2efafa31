//! What a station tells: its state, its events, its process image.

use crate::describe::Bounded;
use crate::invalid::{indices, parallel, present, within};
use crate::macros::message;
use crate::{Header, Invalid};

message! {
    /// A station's answer to another station's request to withdraw a count.
    "linewright_msgs" / Answer
    fields {
        /// Station that made the request.
        station: String,
        /// In which life of its process.
        boot_id: u64,
        /// Which request; the answer counts for this number alone.
        request_number: u64,
        /// Whether the count may be withdrawn.
        agreed: bool,
        /// If not: the operation in the way.
        in_the_way: String,
    }
    ros name "Answer", meaning |m| {
        present("station", !m.station.is_empty())?;
        present("boot_id", m.boot_id != 0)?;
        present("request_number", m.request_number != 0)
    }
}

message! {
    /// The whole public state of one station: latched, sent on change and at a fixed rate.
    "linewright_msgs" / StationState
    constants {
        /// Stand-by: finish what runs, start nothing.
        const MODE_STANDBY: u8 = 0;
        /// Auto.
        const MODE_AUTO: u8 = 1;
        /// Hand.
        const MODE_HAND: u8 = 2;
        /// Manual.
        const MODE_MANUAL: u8 = 3;
        /// Emergency stop: all outputs off.
        const MODE_ESTOP: u8 = 4;
        /// Home: nothing started yet.
        const MODE_HOME: u8 = 5;
        /// No place of the operation is marked.
        const PLACE_NONE: u8 = 0;
        /// p1.
        const PLACE_OPERATING: u8 = 1;
        /// p2.
        const PLACE_INCOMPLETE: u8 = 2;
        /// p3.
        const PLACE_COMPLETED: u8 = 3;
        /// p4.
        const PLACE_UNDOING: u8 = 4;
        /// p5.
        const PLACE_UNDO_INCOMPLETE: u8 = 5;
        /// p6.
        const PLACE_UNDONE: u8 = 6;
    }
    fields {
        /// When this was true.
        header: Header,
        /// Random, new with every start of the process; never 0.
        boot_id: u64,
        /// Grows with every message of this boot.
        sequence: u64,
        /// The station's name.
        station: String,
        /// Newest epoch heard: the acknowledgement of a mode order.
        mode_epoch: u64,
        /// Boot id of the coordinator that gave the order it took last; 0 for none.
        coordinator_boot_id: u64,
        /// Mode in force here (`MODE_`).
        mode: u8,
        /// The generation its counts belong to, drawn when all stations stood at home together; 0 for none.
        generation: u64,
        /// Cycle the station is in. Signed: undoing the home operation of a station that never ran leads below zero.
        cycle: i32,
        /// Per operation: the cycle in which it was last completed.
        done: Vec<i32>,
        /// Per operation: the cycle in which it was last started.
        started: Vec<i32>,
        /// Per operation: its marked place (`PLACE_`).
        places: Vec<u8>,
        /// On the way home along a recovery path.
        recovering_home: bool,
        /// At the home place.
        at_home: bool,
        /// How often it has come home since the line first stood at home together, plus one while it is away.
        round: i32,
        /// No operation in motion.
        stopped: bool,
        /// The selector at the station stands on manual.
        selector_manual: bool,
        /// The image of the devices is fresh.
        devices_valid: bool,
        /// Its input image: bit n is bit `n % 8` of byte `n / 8`. It counts only while `devices_valid`.
        measured: Bounded<u8, 16>,
        /// How old that image was when this was sent, in milliseconds.
        measured_age_ms: u32,
        /// A mechanism that stands still by the chart is not measured there.
        position_lost: bool,
        /// Operations, by index, in an incomplete place.
        incomplete: Vec<u16>,
        /// What the station does, in words.
        operation: String,
        /// What is wrong, or empty.
        fault: String,
        /// What it waits for.
        blocked_by: Vec<String>,
        /// Number of the open request to withdraw counts; 0 = none.
        request_number: u64,
        /// Operations, by index, the open request names.
        request_operations: Vec<u16>,
        /// Answers to other stations' open requests.
        answers: Vec<Answer>,
    }
    ros name "StationState", meaning station_state
}

fn station_state(m: &StationState) -> Result<(), Invalid> {
    present("boot_id", m.boot_id != 0)?;
    present("station", !m.station.is_empty())?;
    within("mode", m.mode, StationState::MODE_STANDBY, StationState::MODE_HOME)?;
    parallel(("started", m.started.len()), ("done", m.done.len()))?;
    parallel(("places", m.places.len()), ("done", m.done.len()))?;
    for &place in &m.places {
        within("places", place, StationState::PLACE_NONE, StationState::PLACE_UNDONE)?;
    }
    indices("incomplete", &m.incomplete, m.done.len())?;
    indices("request_operations", &m.request_operations, m.done.len())?;
    m.answers.iter().try_for_each(crate::RosMessage::validate)
}

message! {
    /// Something that happened at a station, once. The truth is [`StationState`].
    "linewright_msgs" / StationEvent
    constants {
        /// An operation started.
        const KIND_STARTED: u8 = 1;
        /// An operation completed.
        const KIND_COMPLETED: u8 = 2;
        /// An operation was stopped on its way.
        const KIND_STOPPED: u8 = 3;
        /// A fault.
        const KIND_FAULT: u8 = 4;
        /// A recovery operation started.
        const KIND_UNDO_STARTED: u8 = 5;
        /// A recovery operation completed.
        const KIND_UNDONE: u8 = 6;
        /// A command was refused.
        const KIND_REFUSED: u8 = 7;
        /// Counts were withdrawn.
        const KIND_WITHDRAWN: u8 = 8;
        /// The mode in force changed.
        const KIND_MODE: u8 = 9;
        /// Devices were lost or found.
        const KIND_DEVICES: u8 = 10;
        /// Something received was not used.
        const KIND_IGNORED: u8 = 11;
    }
    fields {
        /// When it happened.
        header: Header,
        /// Station of the event.
        station: String,
        /// Grows with every event of the station's process.
        sequence: u64,
        /// What (`KIND_`); a reader keeps kinds it does not know.
        kind: u8,
        /// Which operation, or empty.
        operation: String,
        /// In which cycle.
        cycle: i32,
        /// Event in a sentence.
        text: String,
    }
    ros name "StationEvent", meaning |m| present("station", !m.station.is_empty())
}

message! {
    /// The inputs or the outputs of one station.
    "linewright_msgs" / ProcessImage
    fields {
        /// When it was read or decided.
        header: Header,
        /// Random, new with every start of the process; never 0.
        boot_id: u64,
        /// Grows with every message of this boot.
        sequence: u64,
        /// False: not all devices are heard, every bit is unknown.
        valid: bool,
        /// Inputs: a number that changes whenever the devices behind them are lost or the gateway starts anew. Outputs:
        /// that number in the inputs they were decided on; outputs decided before a loss are not obeyed after it.
        lives: u64,
        /// Outputs: grows with every change of the image, in one life. Inputs: that number of the output image in force
        /// when they were taken; 0 while none is.
        number: u64,
        /// Inputs: the life of the station that number belongs to.
        number_boot_id: u64,
        /// Outputs: the newest mode epoch the station had heard when it decided them. Those from before an emergency stop are
        /// not obeyed after it.
        mode_epoch: u64,
        /// Bit n is bit `n % 8` of byte `n / 8`.
        bits: Bounded<u8, 16>,
    }
    ros name "ProcessImage", meaning |m| present("boot_id", m.boot_id != 0)
}

impl ProcessImage {
    /// The image as one number, bit n in bit n.
    pub fn word(&self) -> u128 {
        word_of(&self.bits)
    }

    /// Sets all 128 bits.
    pub fn set_word(&mut self, word: u128) {
        self.bits = image_of(word);
    }
}

impl StationState {
    /// Its input image as one number, bit n in bit n.
    pub fn measured_word(&self) -> u128 {
        word_of(&self.measured)
    }

    /// Sets all 128 bits of its input image.
    pub fn set_measured(&mut self, word: u128) {
        self.measured = image_of(word);
    }
}

fn word_of(bits: &Bounded<u8, 16>) -> u128 {
    let mut bytes = [0; 16];
    for (to, from) in bytes.iter_mut().zip(bits.as_slice()) {
        *to = *from;
    }
    u128::from_le_bytes(bytes)
}

/// Sixteen bytes are exactly the bound, so this cannot be refused.
fn image_of(word: u128) -> Bounded<u8, 16> {
    Bounded::new(word.to_le_bytes().to_vec()).unwrap_or_default()
}
