//! The shells of the nodes, without sockets and clocks: a controller or the coordinator with what it has said last.

use std::collections::VecDeque;
use std::rc::Rc;

use linewright_coordinator_logic::{Coordinator, Heard, Input as Told, Outbox as Orders};
use linewright_line::{Line, StationId, Tick};
use linewright_station_logic::{
    CompileError, Controller, Event, Input, ModeOrder, NO_DELAY, Outbox, Report, Restore, Rules, Snapshot,
};

use crate::link::Said;

/// A station's process.
pub(crate) struct StationNode {
    pub(crate) id: StationId,
    pub(crate) controller: Controller,
    /// What its disk holds while it is down.
    pub(crate) journal: Option<Snapshot>,
    outbox: Outbox,
    pub(crate) outputs: u128,
    /// The image it was told last.
    image: (u128, bool),
    /// Its state as reported last, and that state's number.
    pub(crate) report: Rc<Report>,
    pub(crate) version: u64,
    /// Something may differ from the report.
    pub(crate) is_unsaid: bool,
    /// Reports nobody may be reading any more, oldest first.
    spare: VecDeque<Rc<Report>>,
}

/// Reports kept for reuse; as many as are ever on their way at once, in practice.
const SPARE_MAX: usize = 16;

impl StationNode {
    pub(crate) fn start(
        line: &Line,
        id: StationId,
        life: u64,
        how: Restore,
        rules: Rules,
    ) -> Result<Self, CompileError> {
        let controller = Controller::new(line, id, life, how)?.with_rules(rules);
        Ok(StationNode {
            id,
            report: Rc::new(controller.report()),
            controller,
            journal: None,
            outbox: Outbox::default(),
            outputs: 0,
            image: (0, false),
            version: 1,
            is_unsaid: true,
            spare: VecDeque::new(),
        })
    }

    pub(crate) fn is_up(&self) -> bool {
        self.journal.is_none()
    }

    /// Takes a message from `from`.
    pub(crate) fn hear(&mut self, now: Tick, from: usize, said: &Said) {
        let input = match said {
            Said::Report(report) => Input::View(StationId::at(from), report),
            Said::Order(order) => Input::Order(*order),
            Said::Panel(command) => Input::Panel(*command),
            Said::Again | Said::Heard(_) | Said::Command(_) | Said::Buttons(_) => return,
        };
        self.controller.handle(now, input);
    }

    /// Takes its devices' image; gives whether it differs from the last one.
    pub(crate) fn see(&mut self, now: Tick, image: (u128, bool)) -> bool {
        if image == self.image {
            return false;
        }
        self.image = image;
        let (bits, valid) = image;
        // The image follows the outputs at once, and whoever gives it says when the devices are lost.
        self.controller.handle(now, Input::Inputs { bits, valid, until: Tick::NEVER, under: NO_DELAY });
        true
    }

    /// Plays the controller one image further. Gives whether its state is to be said now.
    pub(crate) fn step(&mut self, now: Tick) -> bool {
        self.controller.step(now, &mut self.outbox);
        self.is_unsaid |= self.outbox.changed || self.outbox.outputs != self.outputs;
        self.outputs = self.outbox.outputs;
        self.outbox.changed
    }

    pub(crate) fn events(&mut self) -> &mut Vec<Event> {
        &mut self.outbox.events
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
            Some(free) => self.controller.report_into(free),
            None => report = Rc::new(self.controller.report()),
        }
        let before = std::mem::replace(&mut self.report, report);
        if self.spare.len() < SPARE_MAX {
            self.spare.push_back(before);
        }
    }

    /// What the coordinator looks at.
    pub(crate) fn heard(&self) -> Heard {
        let report = &self.report;
        Heard {
            boot_id: report.boot_id,
            mode_epoch: report.mode_epoch,
            at_home: report.at_home,
            round: report.round,
            stopped: report.stopped,
            incomplete: !report.incomplete.is_empty(),
            selector_manual: report.selector_manual,
            devices_valid: report.devices_valid,
        }
    }
}

/// The coordinator's process.
pub(crate) struct CoordinatorNode {
    pub(crate) coordinator: Coordinator,
    pub(crate) is_up: bool,
    pub(crate) life: u64,
    pub(crate) outbox: Orders,
    console: Option<(u128, bool)>,
    /// The number of the order it gives now.
    pub(crate) version: u64,
    order: Option<ModeOrder>,
}

impl CoordinatorNode {
    pub(crate) fn start(line: &Line, life: u64, last_epoch: u64, estopped: bool) -> Self {
        let coordinator = Coordinator::new(line.clone(), last_epoch);
        CoordinatorNode {
            coordinator: if estopped { coordinator.with_estop() } else { coordinator },
            is_up: true,
            life,
            outbox: Orders::default(),
            console: None,
            version: 0,
            order: None,
        }
    }

    pub(crate) fn hear(&mut self, now: Tick, from: usize, said: &Said) {
        let told = match said {
            Said::Heard(heard) => Told::Station(StationId::at(from), *heard),
            Said::Command(command) => Told::Command(*command),
            Said::Buttons(held) => Told::Buttons(*held),
            Said::Again | Said::Report(_) | Said::Order(_) | Said::Panel(_) => return,
        };
        self.coordinator.handle(now, told);
    }

    /// Takes the console's image; gives whether it differs from the last one.
    pub(crate) fn see(&mut self, now: Tick, image: (u128, bool)) -> bool {
        if self.console == Some(image) {
            return false;
        }
        self.console = Some(image);
        self.coordinator.handle(now, Told::Console { bits: image.0, valid: image.1 });
        true
    }

    /// The order as it stands; its number grows when it differs from the last one asked for.
    pub(crate) fn order(&mut self) -> ModeOrder {
        let order = self.coordinator.order();
        let order = ModeOrder {
            boot_id: self.life,
            epoch: order.epoch,
            mode: order.mode,
            enabled: order.enabled,
            master_stop: order.master_stop,
            manual_all: order.manual_all,
            buttons: order.buttons,
            lease: order.lease,
        };
        if self.order != Some(order) {
            self.order = Some(order);
            self.version += 1;
        }
        order
    }
}
