//! Rules that are broken: in the world around the shells, or in the controllers.
//!
//! A world that breaks none of its promises finds nothing wrong with a sound product. It is worth believing only if it finds
//! something wrong with each of these. How messages are changed is in `broken.rs`; what else a rule is about asks for it.

use linewright_station_logic::Rules;
use linewright_station_shell::ShellRules;

macro_rules! mutants {
    ($($name:ident, $seed:expr, $breaks:literal;)*) => {
        /// One broken rule.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Mutant {
            $(#[doc = $breaks] $name,)*
        }

        /// All of them.
        pub const MUTANTS: &[MutantEntry] = &[
            $(MutantEntry { mutant: Mutant::$name, name: stringify!($name), breaks: $breaks, seed: $seed },)*
        ];
    };
}

/// A broken rule with what it costs to find it.
#[derive(Clone, Copy, Debug)]
pub struct MutantEntry {
    pub mutant: Mutant,
    pub name: &'static str,
    /// What is not done, or done wrongly.
    pub breaks: &'static str,
    /// The first seed that finds it, from 0 on; none where no seed has found it yet.
    pub seed: Option<u64>,
}

mutants! {
    // A station's record.
    RecordAfterEffects, Some(0), "a station writes its record after everything that follows from it";
    RecordNotKept, Some(0), "a station's record is acknowledged and never kept";
    AcknowledgedBeforeWritten, Some(1), "a station's record is acknowledged before it is written";
    RecordBeforeLastRead, Some(0), "a station is restarted from the record before its last one";
    HostStartIgnored, Some(3), "a record from before the last start of the host counts as the newest";
    GenerationAfterPowerCut, Some(3), "the same, of its counts alone";
    RecordWithoutCounts, Some(0), "a station's record has the counts of a station at home";
    RecordWithoutPath, Some(8), "a station's record leaves the recovery path out";
    RequestNumbersUsedAgain, Some(3), "numbers of requests begin anew with every start";
    MemorylessBelieved, Some(10), "a station without its journal has the generation of the others";
    HomeUnconfirmed, Some(101), "a station without its journal is at home, whatever its switches say, and its rests are not judged";
    LateEffects, Some(373), "what a slow record of a station held up is put out after it";
    OffAfterRecord, Some(1), "a station's outputs go off after its record";
    StopWaitsForRecord, Some(31), "an emergency stop waits for the record that is being written";
    // The coordinator's record.
    OrderBeforeRecord, Some(0), "the coordinator's order goes out before its record is written";
    EpochNotRecorded, Some(0), "the coordinator's record leaves the epoch out";
    CoordinatorRecordNotKept, Some(0), "the coordinator's record is acknowledged and never kept";
    CoordinatorAcknowledgedEarly, Some(31), "the coordinator's record is acknowledged before it is written";
    StopNotRecorded, Some(21), "the coordinator's record leaves the emergency stop out";
    FailedRecordIgnored, Some(569), "a record of the coordinator that failed counts as written";
    // Authority, leases, numbers.
    ForeignStopIgnored, Some(3), "an emergency stop of another coordinator is not obeyed";
    RivalObeyed, Some(0), "the orders of any coordinator count as those of the one that is followed";
    RivalsUnseen, Some(17), "two coordinators beside each other are not noticed";
    OldOrdersObeyed, Some(75), "an order counts whatever its epoch and its number";
    PoisonedEpochFollowed, Some(2), "an epoch that no coordinator can have given is followed";
    LeaseIgnored, Some(6), "a mode order holds until the next one arrives";
    LeaseOfStrangers, Some(169), "an order holds for as long as it says";
    NumbersIgnored, Some(6), "messages are taken in the order of their arrival, whatever their number";
    StaleViewBelieved, Some(274), "a station's state holds until the next one arrives";
    ClockStands, Some(123_235), "the clock stands while the machine sleeps";
    GapUnseen, Some(54), "after a standstill what was received before it counts as new";
    // The gateway and the devices.
    GatewayAgeIgnored, Some(12), "a station's outputs hold at the gateway until the next ones arrive";
    GatewayStopIgnored, Some(615), "the gateway puts out images from before an emergency stop, and manual does not wait for stations without it";
    ImagesDrivenAtOnce, Some(82), "the gateway puts out an image whatever the mode";
    SlowRecordKeepsOutputs, Some(373), "outputs stay on while a record takes longer than images are valid";
    LossesUnseen, Some(90), "a loss of devices shorter than a scan is not seen";
    OutputsKeptAtLoss, Some(63), "devices keep their outputs when their manager falls silent";
    OutputsKeptAtRestart, Some(90), "devices take up their former outputs after a restart";
    // The decision of modes.
    AutoAwayFromHome, Some(8), "every station counts as at home";
    LostPositionUnheard, Some(20), "no position counts as lost";
    IncompleteUnheard, Some(6), "no operation counts as stopped before its end";
    DevicesUnheard, Some(215), "devices count as received";
    MotionUnheard, Some(9), "every station counts as standing";
    GenerationsUnheard, Some(3), "every station counts as having the same generation";
    AcknowledgedUnheard, Some(34), "every order counts as acknowledged";
    StationStopUnheard, Some(16), "an emergency stop that a station has is not adopted";
    RestartUnheard, Some(0), "a station that was restarted counts as the same";
    ResetNotNeeded, Some(9), "manual ends an emergency stop that was not reset";
    // What stations take from orders.
    EnabledAlways, Some(3), "a mode is acted on before every station has acknowledged it";
    OrderOfAnotherLife, Some(113), "an order counts for whatever life of a station it reaches";
    GenerationsAlike, Some(0), "every generation has the same number";
    EpochsUnread, Some(0), "a station acknowledges no new epoch";
    FoundingLost, Some(0), "founding orders are not taken";
    // What stations take from each other.
    AgreementsInvented, Some(25), "every answer to a request is agreement";
    AgreementsOfEarlierLives, Some(25), "answers to a request of an earlier life count, and numbers begin anew with every start";
    RequestsUnread, Some(3), "a count that is being taken back is relied on";
    // Rules of the controllers.
    GenerationsOff, Some(8), "counts of another generation are compared";
    CountsOff, Some(0), "the barrier of counts is off";
    BooleansInstead, Some(0), "the barrier of counts has Booleans instead of counts";
    StuckSwitchCompletes, Some(16), "a switch that sticks completes the motion to it";
    ContradictionUnseen, Some(101_178), "one switch is believed, whatever those at the other places of its axis show";
    RestsUnjudged, Some(3), "an axis that stands still by the chart is not measured";
    PositionsOff, Some(3), "the barrier of measured positions is off";
    BarriersOff, Some(0), "both barriers are off";
    EntryNotAsked, Some(76), "without a generation in common two stations start by measured positions on one report";
    AgreementOff, Some(29), "counts are taken back without agreement";
    WithdrawnLate, Some(3), "a count is taken back after the motion";
    NumbersNotFresh, Some(1120), "all requests have the same number";
    RoundNotRedone, Some(11), "a recovery path leaves the counts of its round as they are";
    HomeDoesNotWait, Some(297), "a recovery path begins whatever the neighbours do";
}

impl Mutant {
    /// With this name.
    pub fn named(name: &str) -> Option<Mutant> {
        MUTANTS.iter().find(|rule| rule.name == name).map(|rule| rule.mutant)
    }

    /// The rules that its controllers keep.
    pub(crate) fn rules(self) -> Rules {
        let all = Rules::ALL;
        match self {
            Mutant::GenerationsOff => Rules { generations: false, ..all },
            Mutant::CountsOff => Rules { arrows: false, ..all },
            Mutant::BooleansInstead => Rules { counted: false, ..all },
            Mutant::StuckSwitchCompletes => Rules { seen_off: false, ..all },
            // Where both ends of an axis have a switch, the rests are judged too, and the claim would be seen.
            Mutant::HomeUnconfirmed | Mutant::RestsUnjudged => Rules { rests: false, ..all },
            Mutant::ContradictionUnseen => Rules { contradicted: false, ..all },
            Mutant::PositionsOff => Rules { positions: false, ..all },
            Mutant::BarriersOff => Rules { positions: false, arrows: false, ..all },
            Mutant::EntryNotAsked => Rules { entry: false, ..all },
            Mutant::AgreementOff => Rules { ask: false, ..all },
            Mutant::WithdrawnLate => Rules { withdraw_first: false, ..all },
            Mutant::NumbersNotFresh => Rules { fresh_numbers: false, ..all },
            Mutant::RoundNotRedone => Rules { redo_round: false, ..all },
            Mutant::HomeDoesNotWait => Rules { home_waits: false, ..all },
            _ => all,
        }
    }

    /// The rules that its shells keep.
    pub(crate) fn shell_rules(self) -> ShellRules {
        let all = ShellRules::ALL;
        match self {
            Mutant::PoisonedEpochFollowed => ShellRules { epochs: false, ..all },
            Mutant::LeaseOfStrangers => ShellRules { leases: false, ..all },
            Mutant::NumbersIgnored => ShellRules { numbers: false, ..all },
            Mutant::RivalsUnseen => ShellRules { rivals: false, ..all },
            Mutant::GapUnseen => ShellRules { gaps: false, ..all },
            Mutant::LateEffects => ShellRules { late: false, ..all },
            Mutant::OffAfterRecord => ShellRules { off_first: false, ..all },
            _ => all,
        }
    }

    /// The topic whose messages it renews.
    pub(crate) fn renews(self) -> Option<usize> {
        match self {
            Mutant::LeaseIgnored => Some(0),
            Mutant::StaleViewBelieved => Some(1),
            Mutant::GatewayAgeIgnored => Some(3),
            _ => None,
        }
    }
}
