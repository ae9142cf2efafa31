//! Stations that a plan leads back to where their cycle began, before *auto* begins it anew.
//!
//! What they had begun to do with a part is taken back, and the counts that would tell the next station so are gone. Where the part is,
//! no state says: a person sees it, and may lead the station on instead.

use linewright_line::net::Block;
use linewright_line::{Grip, Line, OpId, StationId};

use crate::plan::RecoveryPlan;
use crate::reason::presses_home;
use crate::situation::LineSituation;
use crate::step::{PanelButton, RecoveryAction, RecoveryStep};

/// A station that is led back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LedBack {
    pub station: StationId,
    /// The operations that are taken back, in the order in which they are.
    pub taken_back: Vec<OpId>,
    /// How many presses of *advance* alone lead it on to the end of its cycle instead, the others standing where they do; none where
    /// they do not.
    pub presses_on: Option<usize>,
    /// Its position is to be confirmed first, so that the presses are not counted.
    pub is_unconfirmed: bool,
}

/// The stations that a plan leads back, if auto begins anew after it.
pub(crate) fn all(line: &Line, situation: &LineSituation, plan: &RecoveryPlan) -> Vec<LedBack> {
    if !plan.begins_anew {
        return Vec::new();
    }
    let taken_back = |id: StationId| -> Vec<OpId> {
        let presses = plan.steps.iter().filter(|step| step.action == RecoveryAction::Press(id, PanelButton::Return));
        let (moving, still): (Vec<_>, Vec<_>) = presses.partition(|step| !step.moves.is_empty());
        // What had begun, and has not left its switch yet, is taken back without a motion.
        let report = situation.stations[id.index()].as_ref().filter(|_| !still.is_empty());
        let begun = report.into_iter().flat_map(|report| report.incomplete.iter().map(|(op, _)| *op));
        let undone = moving.into_iter().flat_map(|step| &step.moves);
        let undone = undone.filter(|motion| motion.place.block == Block::Recovery).map(|motion| motion.place.op);
        begun.chain(undone).collect()
    };
    let all: Vec<(StationId, Vec<OpId>)> = line.station_ids().map(|id| (id, taken_back(id))).collect();
    let mut led_back = all.into_iter().filter(|(_, taken_back)| !taken_back.is_empty()).peekable();
    let Some((floor, units)) = led_back.peek().and_then(|_| plan.begin_in_manual(line, situation)) else {
        return Vec::new();
    };
    let of = |(station, taken_back)| {
        let presses_on = presses_home(&floor, units.clone(), station, PanelButton::Advance);
        let confirms =
            |step: &RecoveryStep| matches!(&step.action, RecoveryAction::Rejoin { station: of, .. } if *of == station);
        LedBack { station, taken_back, presses_on, is_unconfirmed: plan.steps.iter().any(confirms) }
    };
    led_back.map(of).collect()
}

impl LedBack {
    /// What becomes of a part, and what the other way is.
    pub fn text(&self, line: &Line) -> String {
        let LedBack { station, taken_back, presses_on, is_unconfirmed } = self;
        let name = |id: StationId| line.station(id).name.as_str();
        let arrows = line.arrows.iter().filter(|arrow| arrow.to.0 == *station && taken_back.contains(&arrow.to.1));
        let since: Vec<String> =
            arrows.map(|arrow| format!("`{}` of {}", line.operation(arrow.from).name, name(arrow.from.0))).collect();
        let follows = if since.is_empty() { String::new() } else { format!(" (after {})", since.join(" and ")) };
        let taken_back: Vec<String> =
            taken_back.iter().map(|&op| format!("`{}`", line.operation((*station, op)).name)).collect();
        let on = match presses_on {
            Some(1) => "the other way: 1 press of advance, on to the end of its cycle".to_owned(),
            Some(presses) => format!("the other way: {presses} presses of advance, on to the end of its cycle"),
            // Counted from where its position is confirmed: before that no press moves it.
            None if *is_unconfirmed => {
                format!("the other way, if there is one, is listed by `recover --on {}`", name(*station))
            }
            None => "advance alone does not lead it on from here".to_owned(),
        };
        let holders = &line.handling.holders;
        let hands = holders
            .iter()
            .filter_map(|holder| if let Grip::Hand(closed) = holder.grip { Some(closed.station) } else { None });
        // Where a line describes no holders, its stations may grip all the same.
        let lets_go = match hands.into_iter().any(|of| of == *station) {
            true => "; what it grips it lets go",
            false if holders.is_empty() => "; if it grips anything, it lets it go",
            false => "",
        };
        format!(
            "{} is led back to where its cycle began, before {}{follows}. The part that it was to take then stays in the machine before it, \
             and the next one may come onto it; what it was working on is not finished{lets_go}. Look where its part is; \
             {on}",
            name(*station),
            taken_back.join(" and "),
        )
    }
}
