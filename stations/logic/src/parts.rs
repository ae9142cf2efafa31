//! State of a controller, in parts.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{BRANCHES_MAX, InputId, OpId, Panel, StationId, Tick};

use crate::event::StopCause;
use crate::peer_set::PeerSet;
use crate::report::AgreementRequest;

/// Transitions tried in one step before the next image is needed. An operation that completes leads on to the next at
/// once; a longer chain means a description with operations that take no time.
pub(crate) const PASSES_MAX: usize = 4;

/// The source of the command that keeps a motion going.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RunCommand {
    /// The controller.
    Auto,
    /// A held hand-mode button: the actuator is driven while it is down.
    Hand,
    /// A held panel button: the motion is stopped when it is released.
    Manual,
}

/// The position of one branch of the station.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Token {
    pub place: u16,
    pub run: RunCommand,
    /// The completion signal counts: it has been seen off since the motion left its other end.
    pub left_start: bool,
    /// It will count as it stands, in the first image taken while this motion is driven: the motion was stopped
    /// between its ends, and an image from before it may still show the switch that the mechanism has left since.
    pub awaits_image: bool,
    /// The output image that began to drive it.
    pub driven_since: u64,
    pub driven: bool,
    /// While driven: when the watchdog runs out.
    pub deadline: Tick,
    /// While not driven: rest of the watchdog.
    pub remaining: Duration,
    /// Of an index, the history of its switch since it began, also while it is stopped.
    pub progress: IndexProgress,
    /// Of an index, how long it was driven before it was stopped last.
    pub turned: Duration,
    /// Of an index, when it was driven last.
    pub last_driven: Tick,
}

/// Progress of an index by its switch since it began. The switch is on both where it begins and where it ends, so its state
/// at a moment is not enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum IndexProgress {
    /// It was not seen all the time: after a restart, or after the devices were lost where it had begun.
    Unseen,
    /// On ever since.
    AtStart,
    /// Off.
    Away,
    /// Off, and on again: at the next place.
    Arrived,
}

/// A switch that was on from the start of a motion, and has not been seen off since.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StuckSwitch {
    pub op: OpId,
    pub input: InputId,
    /// The switch of the end that the motion has left: off.
    pub behind: Option<InputId>,
}

/// Marking of the station.
#[derive(Clone, Debug)]
pub(crate) struct StationMarking {
    /// The first `count` are in use.
    pub tokens: [Token; BRANCHES_MAX],
    pub count: usize,
    /// The recovery path under way, by the operation it goes back from.
    pub path: Option<OpId>,
    /// Of each operation, why it was stopped last.
    pub causes_of_stop: Vec<StopCause>,
    /// First start of this station: the home position is still to be confirmed by the devices.
    pub unconfirmed: bool,
    /// The marking was read off the switches, or follows from a marking that was. False after a start away from home, and with
    /// a record that may be older than the mechanism's place.
    pub placed: bool,
    /// The place at which the endless axis of a drive stood last, or from which its index under way began; 0 while that is not
    /// known.
    pub axis_place: u16,
    /// The index of which it is not certain whether it is done, or at which place. Only a rejoin ends that.
    pub doubtful: Option<OpId>,
    /// The motion that counts as complete though its switch was on from its start.
    pub stuck: Option<StuckSwitch>,
    /// The lost position of which an event was given last (see `interlock`).
    pub lost_position: Option<(OpId, InputId)>,
}

/// The counted internal variables. done(o) ≤ started(o) ≤ cycle for every operation o.
#[derive(Clone, Debug)]
pub(crate) struct Counts {
    pub cycle: i32,
    pub done: Vec<i32>,
    pub started: Vec<i32>,
    /// `done` where the station stands at home before its first cycle.
    pub at_home: Vec<i32>,
    /// The cycle before the first one.
    pub initial_round: i32,
}

/// The input image.
#[derive(Clone, Debug)]
pub(crate) struct StationImage {
    /// Bit `i` is input `i` of the description; 0 while not valid.
    pub bits: u128,
    pub valid: bool,
    /// The image is unknown from then on.
    pub until: Tick,
    /// [`crate::Outbox::number`] of the newest output image in force when it was taken.
    pub under: u64,
    /// The inputs the panel is wired to.
    pub panel: u128,
    /// Those, and the ones that the marked places read: a change of any other has no effect.
    pub watched: u128,
}

impl StationImage {
    pub fn new(panel: &Panel) -> Self {
        let wired = [panel.manual, panel.advance, panel.retract].into_iter().flatten();
        let panel = wired.fold(0, |bits, input| bits | 1 << input.0);
        StationImage { bits: 0, valid: false, until: Tick::ZERO, under: 0, panel, watched: u128::MAX }
    }
}

/// Command levels, a bit each (`program::bit`), of this step and of the one before.
#[derive(Clone, Debug)]
pub(crate) struct Levels {
    pub now: u128,
    pub before: u128,
    /// The mode of the step before.
    pub mode: ControlMode,
}

/// A request that is open, and the command behind it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PendingAgreement {
    pub request: AgreementRequest,
    /// The rows whose transitions fire once agreed, the first `count` of them.
    pub rows: [u16; BRANCHES_MAX],
    pub count: usize,
    /// Levels the command must keep holding.
    pub hold: u128,
    pub mode: ControlMode,
    /// Peers that must agree to counts being taken back.
    pub needs: PeerSet,
    /// Peers that must agree to a motion by measured positions (see `entry`).
    pub entered: PeerSet,
}

impl PendingAgreement {
    pub fn rows(&self) -> &[u16] {
        &self.rows[..self.count]
    }
}

/// A request that another station did not agree to, or that was not made since the other has one open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AgreementRefusal {
    pub by: StationId,
    /// Its operation in the way; none where it has a request open.
    pub in_the_way: Option<OpId>,
    /// The own operations whose counts stay; none where the request was for a motion by measured positions.
    pub ops: u64,
}

/// What is done by agreement with other stations: counts taken back, motions by measured positions alone.
#[derive(Clone, Debug)]
pub(crate) struct Agreement {
    pub pending: Option<PendingAgreement>,
    pub next_request: u64,
    /// The last refusal, for the operator.
    pub refusal: Option<AgreementRefusal>,
}

/// The output image.
#[derive(Clone, Debug)]
pub(crate) struct StationOutput {
    /// Bit `i` is output `i` of the description.
    pub bits: u128,
    /// Grows with every change of the image, and with every motion that begins. It begins at 1: 0 is that of an input image under no
    /// outputs of this life.
    pub number: u64,
    /// A motion is driven by it.
    pub moves: bool,
    /// When the last motion ended.
    pub stood_at: Tick,
}

impl StationOutput {
    pub const NONE: StationOutput = StationOutput { bits: 0, number: 1, moves: false, stood_at: Tick::ZERO };
}

/// Work of the next step.
#[derive(Clone, Debug)]
pub(crate) struct Due {
    /// The output image is to be worked out again.
    pub outputs: bool,
    /// The report differs from the one given last.
    pub report: bool,
    /// The last step changed nothing, and nothing has arrived since: before the deadline a step has nothing to do.
    pub settled: bool,
    pub deadline: Tick,
}

/// As many transitions as one step can fire: every branch once in each pass.
const FIRED_MAX: usize = PASSES_MAX * BRANCHES_MAX;

/// The transitions that the last step fired, the first `count` of them.
#[derive(Clone, Debug)]
pub(crate) struct Fired {
    transitions: [u16; FIRED_MAX],
    count: usize,
}

impl Fired {
    pub const NONE: Fired = Fired { transitions: [0; FIRED_MAX], count: 0 };

    pub fn push(&mut self, transition: u16) {
        if let Some(slot) = self.transitions.get_mut(self.count) {
            *slot = transition;
            self.count += 1;
        }
    }

    pub fn as_slice(&self) -> &[u16] {
        &self.transitions[..self.count]
    }

    pub fn clear(&mut self) {
        self.count = 0;
    }
}
