//! What leads to the homing of a drive that turns an endless axis, and what it waits for.

use linewright_line::net::ControlMode;
use linewright_line::{InputId, Line, Owner, StationId, Tick};

use crate::controller::Controller;
use crate::homing::HomingNeed;
use crate::texts::{HOMING, StationWait};

impl Controller {
    /// What a person does to have the drive homed, where advance leads on to that.
    pub(crate) fn homing_way(&self, line: &Line) -> Option<String> {
        let op = self.to_be_homed()?;
        let is_under_way = self.marking().any(|place| place.op == op && place.is_incomplete());
        let way =
            if is_under_way { StationWait::Homing { op: self.op_name(line, op) } } else { StationWait::HomingAtRest };
        Some(way.text())
    }

    /// What keeps the homing at a rest from beginning, or from going on.
    pub(crate) fn explain_homing(&self, line: &Line, now: Tick, reasons: &mut Vec<String>) {
        if self.mode() == ControlMode::Manual && !self.panel_is_live() {
            reasons.push(StationWait::Selector.text());
        }
        let Some((op, need)) = self.rests_to_be_homed().and_then(|op| Some((op, self.homing_need(op)?))) else {
            return;
        };
        let name = |station: StationId| line.station(station).name.as_str();
        reasons.push(match need {
            HomingNeed::Position(guard) => {
                let detail = self.interlock(&guard).detail(line, self.program.station);
                StationWait::Position { detail: &detail, own: HOMING }.text()
            }
            HomingNeed::State(station) => StationWait::NoState { station: name(station), own: HOMING }.text(),
            HomingNeed::PlaceOf(station) => StationWait::PositionOf { station: name(station), own: HOMING }.text(),
            HomingNeed::Standstill(station) => StationWait::Standstill { station: name(station) }.text(),
            HomingNeed::Outside(station, conflict) => {
                let why = &line.conflicts[usize::from(conflict)].why;
                StationWait::LedOut { station: name(station), why }.text()
            }
            HomingNeed::Arrow(arrow) => {
                let cycle = self.cycle_of_start(self.program.step_of[op.index()]);
                self.cause_text(line, arrow, cycle, now)
            }
            HomingNeed::Fault(bits) => {
                let input = InputId(bits.trailing_zeros() as u16);
                let input = line.input_text(Owner::Station(self.program.station), input);
                StationWait::HomingFault { input: &input }.text()
            }
            // Over before it is read.
            HomingNeed::OldViews => return,
        });
    }
}
