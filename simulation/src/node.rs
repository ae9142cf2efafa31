//! The processes of the nodes: their shells, with their last messages.

use std::collections::{BTreeSet, VecDeque};
use std::rc::Rc;

use linewright_coordinator_logic::StationView;
use linewright_coordinator_shell::{CoordinatorArrival, CoordinatorEffect, CoordinatorRecord, CoordinatorShell, heard};
use linewright_line::{Line, StationId, Tick};
use linewright_station_logic::{CompileError, Controller, Restore, StationReport, StationSnapshot};
use linewright_station_shell::{ParticipantId, StationArrival, StationEffect, StationShell};

use crate::field::SeenInputs;
use crate::link::{LinkPayload, WholeMessage};
use crate::options::SimOptions;

/// Participant of the coordinator, the only sender of orders here.
const COORDINATOR: ParticipantId = [1; 12];

/// A station's process.
pub(crate) struct StationNode {
    pub(crate) id: StationId,
    shell: StationShell,
    /// Its journal while it is down.
    pub(crate) journal: Option<StationSnapshot>,
    /// The last record, kept with frames only. Without them the state at its death is what was written down.
    disk: Option<StationSnapshot>,
    /// It dies at its next change, after the record is written and before anything else that follows.
    pub(crate) dies_at_next_record: bool,
    pub(crate) is_dying: bool,
    pub(crate) effects: Vec<StationEffect>,
    pub(crate) outputs: u128,
    /// Last image it received.
    image: (u128, bool),
    /// Where links keep the order of messages each is newer than the one before.
    taken: u64,
    /// Its state as reported last, and that state's number.
    pub(crate) report: Rc<StationReport>,
    pub(crate) version: u64,
    /// Something may differ from the report.
    is_unsaid: bool,
    /// Reports that may have no reader any more, oldest first.
    spare: VecDeque<Rc<StationReport>>,
}

/// Identity of the one console.
const CONSOLE: u64 = 1;
/// Reports kept for reuse; as many as are ever on their way at once, in practice.
const SPARE_MAX: usize = 16;

impl StationNode {
    pub(crate) fn start(
        line: &Line,
        id: StationId,
        life: u64,
        how: Restore,
        options: &SimOptions,
    ) -> Result<Self, CompileError> {
        let mut shell = StationShell::new(line, id, life, how)?.with_rules(options.rules);
        if !options.frames {
            shell = shell.without_refresh();
        }
        Ok(StationNode {
            disk: options.frames.then(|| shell.snapshot()),
            dies_at_next_record: false,
            is_dying: false,
            id,
            report: Rc::new(shell.controller().report()),
            shell,
            journal: None,
            effects: Vec::new(),
            outputs: 0,
            image: (0, false),
            taken: 0,
            version: 1,
            is_unsaid: true,
            spare: VecDeque::new(),
        })
    }

    pub(crate) fn controller(&self) -> &Controller {
        self.shell.controller()
    }

    pub(crate) fn is_up(&self) -> bool {
        self.journal.is_none()
    }

    pub(crate) fn life(&self) -> u64 {
        self.shell.boot_id()
    }

    /// Takes a message from `from`.
    pub(crate) fn hear(&mut self, now: Tick, from: usize, said: &LinkPayload) {
        self.taken += 1;
        let (station, sequence) = (StationId::at(from), self.taken);
        let arrival = match said {
            LinkPayload::Report(report) => StationArrival::State { station, sequence, report },
            LinkPayload::Order(order) => StationArrival::Order { sequence, from: COORDINATOR, order: *order },
            LinkPayload::Whole(message) => match &message.said {
                WholeMessage::Report(report) => StationArrival::State { station, sequence: message.number, report },
                WholeMessage::Order(order) => {
                    StationArrival::Order { sequence: message.number, from: COORDINATOR, order: *order }
                }
                WholeMessage::Inputs(image) => StationArrival::Inputs(*image),
                WholeMessage::Heard(_) | WholeMessage::Outputs(_) => return,
            },
            LinkPayload::Panel(command) => StationArrival::Panel { console: CONSOLE, command: *command },
            LinkPayload::Rejoin(within) => StationArrival::Rejoin((*within).into(), &[]),
            LinkPayload::Again
            | LinkPayload::Heard(_)
            | LinkPayload::Command(_)
            | LinkPayload::Buttons(_)
            | LinkPayload::Resume(_) => return,
        };
        self.shell.handle(now, arrival, &mut self.effects);
    }

    /// Takes the image of its own bus.
    pub(crate) fn look(&mut self, now: Tick, SeenInputs { bits, valid, losses }: SeenInputs) {
        self.shell.handle(now, StationArrival::Devices { bits, valid, losses }, &mut self.effects);
    }

    /// Takes its devices' image; gives whether it differs from the last one.
    pub(crate) fn see(&mut self, now: Tick, image: (u128, bool)) -> bool {
        if image == self.image {
            return false;
        }
        self.image = image;
        let (bits, valid) = image;
        // The image follows the outputs at once, and its source reports when the devices are lost.
        self.shell.handle(now, StationArrival::Devices { bits, valid, losses: 0 }, &mut self.effects);
        true
    }

    /// Plays the station one step further and returns the effects.
    pub(crate) fn step(&mut self, now: Tick) -> Vec<StationEffect> {
        self.shell.act(now, &mut self.effects);
        std::mem::take(&mut self.effects)
    }

    /// Puts out an image.
    pub(crate) fn drive(&mut self, outputs: u128) {
        self.is_unsaid |= outputs != self.outputs;
        self.outputs = outputs;
    }

    /// Something may differ from the report.
    pub(crate) fn is_to_say(&mut self) {
        self.is_unsaid = true;
    }

    /// Writes the record. Without a disk it is taken when the station dies.
    pub(crate) fn remember(&mut self) {
        if let Some(disk) = &mut self.disk {
            *disk = self.shell.snapshot();
        }
        self.is_dying |= self.dies_at_next_record;
    }

    /// Ends its process.
    pub(crate) fn kill(&mut self) {
        self.journal = Some(self.disk.take().unwrap_or_else(|| self.shell.snapshot()));
    }

    pub(crate) fn next_deadline(&self) -> Tick {
        self.shell.next_deadline()
    }

    /// Brings the report up to date.
    pub(crate) fn write_report(&mut self) {
        if !std::mem::take(&mut self.is_unsaid) {
            return;
        }
        self.version += 1;
        let reuse = self.spare.iter().position(|report| Rc::strong_count(report) == 1);
        let mut report = match reuse {
            Some(at) => self.spare.swap_remove_back(at).unwrap_or_default(),
            None => Rc::default(),
        };
        match Rc::get_mut(&mut report) {
            Some(free) => self.shell.controller().report_into(free),
            None => report = Rc::new(self.shell.controller().report()),
        }
        let before = std::mem::replace(&mut self.report, report);
        if self.spare.len() < SPARE_MAX {
            self.spare.push_back(before);
        }
    }

    /// The part that the coordinator uses.
    pub(crate) fn heard(&self) -> StationView {
        heard(&self.report)
    }
}

/// The coordinator's process.
pub(crate) struct CoordinatorNode {
    pub(crate) shell: CoordinatorShell,
    pub(crate) is_up: bool,
    pub(crate) effects: Vec<CoordinatorEffect>,
    pub(crate) journal: CoordinatorRecord,
    /// Its disk takes no record.
    pub(crate) disk_is_full: bool,
    console: Option<(u128, bool)>,
    /// Stations away from their rests: no cell gives any an order.
    away: BTreeSet<StationId>,
    /// Where links keep the order of messages each is newer than the one before.
    taken: u64,
}

impl CoordinatorNode {
    pub(crate) fn start(line: &Line, life: u64, journal: CoordinatorRecord, options: &SimOptions) -> Self {
        let shell = CoordinatorShell::new(line, life, journal);
        CoordinatorNode {
            shell: if options.frames { shell } else { shell.without_refresh_and_gateway() },
            is_up: true,
            disk_is_full: false,
            effects: Vec::new(),
            journal,
            console: None,
            away: BTreeSet::new(),
            taken: 0,
        }
    }

    /// Takes a message from `from`.
    pub(crate) fn hear(&mut self, now: Tick, from: usize, said: &LinkPayload) {
        self.taken += 1;
        let (station, sequence) = (StationId::at(from), self.taken);
        let arrival = match said {
            LinkPayload::Heard(heard) => CoordinatorArrival::State { station, sequence, heard: *heard },
            LinkPayload::Whole(message) => match &message.said {
                WholeMessage::Heard(heard) => {
                    CoordinatorArrival::State { station, sequence: message.number, heard: *heard }
                }
                WholeMessage::Outputs(image) => {
                    CoordinatorArrival::Outputs { station, sequence: message.number, image: *image }
                }
                WholeMessage::Report(_) | WholeMessage::Order(_) | WholeMessage::Inputs(_) => return,
            },
            LinkPayload::Command(command) => CoordinatorArrival::Command(*command),
            LinkPayload::Buttons(held) => CoordinatorArrival::Buttons { console: CONSOLE, held: *held },
            LinkPayload::Resume(held) => CoordinatorArrival::Resume { console: CONSOLE, held: *held },
            LinkPayload::Again
            | LinkPayload::Report(_)
            | LinkPayload::Order(_)
            | LinkPayload::Panel(_)
            | LinkPayload::Rejoin(_) => return,
        };
        if let CoordinatorArrival::State { station, heard, .. } = &arrival {
            let is_new = if heard.at_home { self.away.remove(station) } else { self.away.insert(*station) };
            if is_new {
                self.shell.hold(|id| self.away.contains(&id));
            }
        }
        self.shell.handle(now, arrival);
    }

    /// Takes the console's image; gives whether it differs from the last one.
    pub(crate) fn see(&mut self, now: Tick, image: (u128, bool)) -> bool {
        if self.console == Some(image) {
            return false;
        }
        self.console = Some(image);
        self.shell.handle(now, CoordinatorArrival::Console { bits: image.0, valid: image.1 });
        true
    }

    /// Writes a record down. False if the effects after it are not to be performed.
    pub(crate) fn remember(&mut self, now: Tick, record: CoordinatorRecord) -> bool {
        if !self.disk_is_full {
            self.journal = record;
        }
        self.shell.remembered(now, record, !self.disk_is_full)
    }
}
