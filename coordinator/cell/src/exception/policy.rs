//! Recovery policy of a cell: the resources of a mode, what to do, and texts for operators.
//!
//! Plain data beside the table, filled from the description of a cell. In a cell without any, failed activities are
//! secured and alarmed all the same, by the mode's name and with the usual answers.

use std::sync::Arc;
use std::time::Duration;

use linewright_cell::NominalLimit;
use linewright_line::{RestId, StationId};

use super::super::ids::{CellId, ModeId, ResourceId, TokenDemand};
use super::super::record::{ActivityFailure, OrderFailure, TaskRefusal};
use super::fact::{RecoveryDecision, Strategy, Whereabouts};

/// Recovery policy of a cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecoveryPolicy {
    /// The resources, in the order of their numbers.
    pub resources: Vec<ResourcePolicy>,
    /// By mode, in the order of the table; modes beyond the end have nothing.
    pub modes: Vec<ModeHandling>,
    /// Recovery rules; the first of a mode's that fits counts.
    pub rules: Vec<RecoveryRule>,
    /// Stations, by operators' names.
    pub stations: Vec<(StationId, Arc<str>)>,
    /// Where stations rest and how they come from rest to rest; none without a line.
    pub rests: Vec<StationRests>,
    /// Time without a report after which a station with an order is lost; none: never.
    pub lost_after: Option<Duration>,
    /// Longest wait for a station that was ordered to come to rest.
    pub secure: Duration,
}

/// One resource.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResourcePolicy {
    pub name: Arc<str>,
    pub station: Option<StationId>,
    /// That station reports whether a part is there ([`super::super::TaskReport::presence`]).
    pub is_sensed: bool,
    /// The cells on which the parts are that it has.
    pub has: Vec<CellId>,
    /// Those on which its sensor sees them: of a row the end from which parts are taken.
    pub sees: Vec<CellId>,
    /// It has room for one part.
    pub is_single: bool,
}

/// The rests of a station and the tasks between them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationRests {
    pub station: StationId,
    /// Name, and behind it the title in brackets where that differs.
    pub label: Arc<str>,
    /// What the rests are called, by number.
    pub names: Vec<Arc<str>>,
    pub tasks: Vec<RestTask>,
}

/// A task as a way from rest to rest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RestTask {
    pub name: Arc<str>,
    pub from: RestId,
    pub to: RestId,
    /// Longest time that the station gives any order for it.
    pub limit: Duration,
    /// The button that begins it in hand mode.
    pub button: Arc<str>,
    /// The button that takes all of it back in hand mode, from the rest where it has ended; none if none does.
    pub back: Option<Arc<str>>,
    /// Other stations that a button of these moves too, each with the button.
    pub shared: Vec<(Arc<str>, Arc<str>)>,
    /// One of its motions waits for inputs.
    pub waits: bool,
    /// The inputs that its operations wait for, or have to bring about.
    pub awaited: Vec<AwaitedInput>,
}

/// An input that a task waits for in one of its operations.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AwaitedInput {
    /// Code with which an order ends when the input is not on in time.
    pub code: u16,
    /// Its bit in the station's image.
    pub bit: u128,
    pub input: Arc<str>,
    /// The operation that waits for it, or has to bring it about.
    pub operation: Arc<str>,
}

/// Recovery data of a mode.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ModeHandling {
    /// The activity, by its operators' name; empty for the mode's own name.
    pub activity: Arc<str>,
    pub part_type: Arc<str>,
    /// Holder of the part before; a worker holds it before and afterwards.
    pub from: Option<ResourceId>,
    /// Holder of the part afterwards.
    pub to: Option<ResourceId>,
    pub carrier: Option<ResourceId>,
    /// The rules that are about it, as positions.
    pub rules: Vec<usize>,
    /// The rests at which ordered tasks begin; none without a line.
    pub begins: Vec<(StationId, RestId)>,
    /// By order, where it states no limit: what `safety` of the cell makes of the activity's time.
    pub nominal: Vec<Option<NominalLimit>>,
    /// What is given back if its part is no more; none if that is not known.
    pub gone: Option<Vec<TokenDemand>>,
}

/// Recovery rule of one kind of failure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecoveryRule {
    /// Failures that it is for.
    pub code: FailureMatch,
    /// Text for operators, with names in braces.
    pub tell: Arc<str>,
    /// Most repetitions of the same with one part.
    pub retries: u32,
    /// Applied without an answer as long as all stations are at rest.
    pub is_automatic: bool,
    /// These stations go into emergency stop.
    pub stops: Vec<StationId>,
    /// And so do all that have an order in the activity.
    pub stops_activity: bool,
    pub answers: Vec<PermittedAnswer>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PermittedAnswer {
    /// The word, where the part is, how to go on.
    pub ruling: RecoveryDecision,
    /// Resources left out then: these, and the activity's own that hold this part.
    pub down: Vec<ResourceId>,
    /// Their roles: from, to, carrier.
    pub down_as: Vec<Whereabouts>,
}

/// Failures that a rule is for, as descriptions write it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FailureMatch {
    /// All.
    Any,
    /// Those of this word.
    Word(Arc<str>),
}

impl PermittedAnswer {
    /// The answer of the same word once it may not be tried again; none of other answers.
    pub(super) fn anew(&self) -> Option<PermittedAnswer> {
        let ruling = RecoveryDecision { then: Strategy::Backward, ..self.ruling.clone() };
        (self.ruling.then == Strategy::Redo).then(|| PermittedAnswer { ruling, ..self.clone() })
    }

    /// Whether it says no more than that the part is where it was.
    pub(super) fn leaves_it_where_it_was(&self) -> bool {
        self.ruling.part == Whereabouts::From && self.down.is_empty() && self.down_as.is_empty()
    }
}

impl Default for RecoveryPolicy {
    fn default() -> Self {
        RecoveryPolicy {
            resources: Vec::new(),
            modes: Vec::new(),
            rules: Vec::new(),
            stations: Vec::new(),
            rests: Vec::new(),
            lost_after: None,
            secure: Duration::from_secs(30),
        }
    }
}

impl RecoveryPolicy {
    /// Recovery data of a mode.
    pub fn mode(&self, mode: ModeId) -> &ModeHandling {
        self.modes.get(mode.index()).unwrap_or(&NOTHING)
    }

    /// A resource, if there is one of that number.
    pub fn resource(&self, id: ResourceId) -> Option<&ResourcePolicy> {
        self.resources.get(id.index())
    }

    /// All resources.
    pub fn resource_ids(&self) -> impl ExactSizeIterator<Item = ResourceId> + use<> {
        // Descriptions are bounded far below 32 bits.
        (0..self.resources.len() as u32).map(ResourceId)
    }

    pub fn resource_named(&self, name: &str) -> Option<ResourceId> {
        self.resource_ids().find(|id| self.resources[id.index()].name.as_ref() == name)
    }

    /// The resource of this name, or the only one with the station of this name.
    ///
    /// # Errors
    /// The resources of the station, if they are several; none where there is no such name.
    pub fn resource_or_station_named(&self, name: &str) -> Result<ResourceId, Vec<ResourceId>> {
        if let Some(id) = self.resource_named(name) {
            return Ok(id);
        }
        let station = self.stations.iter().find(|(_, of)| **of == *name).map(|(id, _)| *id);
        let is_its = |id: &ResourceId| station.is_some() && self.resources[id.index()].station == station;
        let its: Vec<ResourceId> = self.resource_ids().filter(is_its).collect();
        if let [only] = its[..] { Ok(only) } else { Err(its) }
    }

    /// Operators' name of a resource.
    pub fn resource_name(&self, id: ResourceId) -> &str {
        self.resource(id).map_or("?", |resource| &resource.name)
    }

    /// Whether a station is one of the cell's.
    pub(super) fn knows_station(&self, station: StationId) -> bool {
        self.stations.iter().any(|(id, _)| *id == station)
    }

    /// Operators' name of a station.
    pub fn station_name(&self, station: StationId) -> String {
        let known = self.stations.iter().find(|(id, _)| *id == station);
        known.map_or_else(|| format!("station {}", station.0), |(_, name)| name.to_string())
    }

    /// The label of a station: its name, and behind it the title in brackets where that differs.
    pub fn station_label(&self, station: StationId) -> String {
        let known = self.rests.iter().find(|of| of.station == station);
        known.map_or_else(|| self.station_name(station), |of| of.label.to_string())
    }

    /// Longest time that a station gives an order for a task.
    pub fn task_limit(&self, station: StationId, task: &str) -> Option<Duration> {
        let of = self.rests.iter().find(|of| of.station == station)?;
        of.tasks.iter().find(|of| *of.name == *task).map(|of| of.limit)
    }

    /// The inputs that a station waited for when an order for this task failed with this code, each with its operation; none if no
    /// motion has it. Of several those that are `off`; all where none is known to be.
    pub fn awaited(&self, station: StationId, task: &str, code: u16, off: u128) -> Option<String> {
        let of = self.rests.iter().find(|of| of.station == station)?;
        let tasks = of.tasks.iter().filter(|of| *of.name == *task).flat_map(|of| &of.awaited);
        let all: Vec<&AwaitedInput> = tasks.filter(|of| of.code == code).collect();
        let is_one_off = all.iter().any(|of| of.bit & off != 0);
        let missing = all.iter().filter(|of| !is_one_off || of.bit & off != 0);
        let inputs: Vec<String> = missing.map(|of| format!("{} at `{}`", of.input, of.operation)).collect();
        (!inputs.is_empty()).then(|| inputs.join(", "))
    }

    /// The rule for a failure of a mode: the first that fits. One of the station's own code goes before one of time-outs,
    /// which fits as well where the code gives what a station waited for until its time was over.
    pub(crate) fn rule(&self, mode: ModeId, cause: ActivityFailure) -> Option<&RecoveryRule> {
        let word = word(cause);
        let rules = || self.mode(mode).rules.iter().filter_map(|&at| self.rules.get(at));
        let own = rules().find(|rule| matches!(&rule.code, FailureMatch::Word(code) if **code == word));
        own.or_else(|| {
            rules().find(|rule| match &rule.code {
                FailureMatch::Any => true,
                FailureMatch::Word(code) => cause.is_expiry() && **code == *TIME_OUT,
            })
        })
    }
}

impl ResourcePolicy {
    /// Whether its sensor sees a part wherever that is in it.
    pub(super) fn sees_all(&self) -> bool {
        self.sees.len() == self.has.len()
    }
}

impl ModeHandling {
    /// Resources of the activity, each once.
    pub fn resources(&self) -> impl Iterator<Item = ResourceId> {
        let to = self.to.filter(|&to| Some(to) != self.from);
        let carrier = self.carrier.filter(|&carrier| Some(carrier) != self.from && Some(carrier) != to);
        [self.from, to, carrier].into_iter().flatten()
    }

    /// Holder of the part in this place.
    pub(super) fn holder(&self, part: Whereabouts) -> Option<ResourceId> {
        match part {
            Whereabouts::From => self.from,
            Whereabouts::To => self.to,
            Whereabouts::Carrier => self.carrier,
            Whereabouts::Gone => None,
        }
    }
}

static NOTHING: std::sync::LazyLock<ModeHandling> = std::sync::LazyLock::new(ModeHandling::default);

const TIME_OUT: &str = "time-out";

/// The word for a cause, as descriptions write it: a code in digits is the station's own.
pub(super) fn word(cause: ActivityFailure) -> String {
    match cause {
        ActivityFailure::TimedOut => TIME_OUT.to_owned(),
        ActivityFailure::ByHand { .. } => "alarm".to_owned(),
        ActivityFailure::Order { key: _, failure } => match failure {
            OrderFailure::TimedOut => TIME_OUT.to_owned(),
            OrderFailure::Code(code) => code.to_string(),
            OrderFailure::Refused(TaskRefusal::Devices) | OrderFailure::DevicesLost => "device-lost".to_owned(),
            OrderFailure::Refused(
                TaskRefusal::Busy
                | TaskRefusal::Mode
                | TaskRefusal::OtherMemory
                | TaskRefusal::OldEpoch
                | TaskRefusal::Old
                | TaskRefusal::Late
                | TaskRefusal::NotThere
                | TaskRefusal::Unknown
                | TaskRefusal::Incomplete
                | TaskRefusal::Isolated,
            ) => "refused".to_owned(),
            OrderFailure::Lost | OrderFailure::Forgotten => "station-lost".to_owned(),
        },
    }
}

/// Permitted answers where none are described.
pub(super) fn usual() -> [PermittedAnswer; 3] {
    [
        ("as-before", Whereabouts::From, Strategy::Backward),
        ("as-done", Whereabouts::To, Strategy::Forward),
        ("gone", Whereabouts::Gone, Strategy::Backward),
    ]
    .map(|(word, part, then)| PermittedAnswer {
        ruling: RecoveryDecision { word: word.to_owned(), part, then },
        down: Vec::new(),
        down_as: Vec::new(),
    })
}
