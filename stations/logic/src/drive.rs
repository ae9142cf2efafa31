//! Output of the controller: the output image, the next deadline, the report.

use linewright_line::net::ControlMode;

use crate::controller::Controller;
use crate::parts::RunCommand;
use crate::report::StationReport;

impl Controller {
    /// Works out the outputs and the deadline.
    ///
    /// An actuator is on only if: its place is operating; the image by which that was judged is valid; the mode is not the
    /// emergency stop; a motion that a person holds has its button down; and the measured positions allow the motion.
    /// Everything else is off, but for a homing at a rest (see `homing`). Parameters of a task are on while it runs.
    pub(crate) fn drive(&mut self) {
        let mut outputs = 0;
        self.image.watched = self.image.panel | self.program.interlocks.read_by_others;
        let mut deadline = self.commands.deadline(self.now).min(self.views.deadline(self.now));
        if self.image.valid {
            deadline = deadline.min(self.image.until);
            outputs |= self.parameter_outputs() | self.homing_output();
        }
        deadline = deadline.min(self.order_limit()).min(self.result_limit());
        self.image.watched |= self.homing_inputs();
        self.image.watched |= self.program.tasks.as_ref().map_or(0, |tasks| tasks.watched);
        self.image.watched |= self.program.places_of_axis.as_ref().map_or(0, |axis| axis.numbers.report(u16::MAX));
        self.image.watched |= self.marking.stuck.map_or(0, |stuck| stuck.input.bit());
        let mode = self.commands.mode();
        let number = self.output.number + 1;
        let mut begun = false;
        for index in 0..self.marking.count {
            let order = self.place_order(index);
            // A motion that a person lets go of and takes up again starts once more: what is not measured blocks it.
            let paused = self.marking.tokens[index];
            let place = self.place(&paused);
            let blocked = place.is_operating() && !paused.driven && self.violated(place, self.marking.path).is_some();
            let token = &mut self.marking.tokens[index];
            let table = &self.program.places[token.place as usize];
            let held = token.run != RunCommand::Hand || (table.hold != 0 && self.levels.now & table.hold == table.hold);
            let driven = table.actuator != 0 && self.image.valid && held && !blocked && mode != ControlMode::EStop;
            match (token.driven, driven) {
                (false, true) => {
                    token.deadline = self.now + token.remaining;
                    token.driven_since = number;
                    begun = true;
                }
                (true, false) => token.remaining = token.deadline.since(self.now),
                (true, true) | (false, false) => {}
            }
            token.driven = driven;
            if driven {
                outputs |= table.actuator | order;
                deadline = deadline.min(token.deadline);
            }
            outputs |= table.lamp;
            self.image.watched |= table.complete | table.behind | table.fault | table.watched_at_rest() | table.turns;
        }
        // A motion that begins is a new image even if the outputs are the same: inputs are needed that were taken under
        // it.
        if begun || outputs != self.output.bits {
            self.output.bits = outputs;
            self.output.number = number;
        }
        let moves = self.homing.is_driven || self.tokens().iter().any(|token| token.driven);
        if self.output.moves && !moves {
            self.output.stood_at = self.now;
        }
        self.output.moves = moves;
        self.due.deadline = deadline;
        self.due.outputs = false;
    }

    /// The report of the present state.
    pub fn report(&self) -> StationReport {
        let mut report = StationReport::default();
        self.report_into(&mut report);
        report
    }

    /// Writes the report of the present state, reusing the memory of `report`.
    pub fn report_into(&self, report: &mut StationReport) {
        report.boot_id = self.boot_id;
        report.mode_epoch = self.commands.epoch();
        report.mode = Some(self.commands.mode());
        report.generation = self.views.generation;
        report.measured = self.image.bits;
        report.measured_age = self.image_age();
        report.position_lost = self.position_lost();
        report.placed = self.marking.placed && !self.marking.unconfirmed;
        report.place = self.marking.axis_place;
        report.cycle = self.counts.cycle;
        report.done.clone_from(&self.counts.done);
        report.started.clone_from(&self.counts.started);
        report.places.clear();
        report.places.resize(self.counts.done.len(), 0);
        report.incomplete.clear();
        for place in self.marking() {
            report.places[place.op.index()] = place.number();
            if place.is_incomplete() {
                report.incomplete.push((place.op, self.marking.causes_of_stop[place.op.index()]));
            }
        }
        report.recovering_home = self.marking.path.is_some();
        report.at_home = self.is_at_home();
        report.round = self.home_round() + i32::from(!report.at_home);
        report.stopped = !self.output.moves;
        report.selector_manual = self.commands.selector_manual();
        report.devices_valid = self.image.valid;
        report.request = self.agreement.pending.map(|p| p.request);
        self.report_orders(&mut report.order);
        report.answers.clear();
        report.answers.extend(self.views.peers.iter().filter_map(|v| v.answer));
    }
}
