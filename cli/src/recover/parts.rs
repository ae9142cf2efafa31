//! Where parts are when a line is led back, as far as that is known: what an operator compares with the machine.

use linewright_msgs::CellState;
use linewright_recovery::{RecoveryAction, RecoveryPlan};

/// The parts above a plan that moves something or asks about one; none above others.
///
/// The coordinator of a cell has an account of them. A line without a cell has none.
pub fn lines(plan: &RecoveryPlan, cell: Option<&CellState>) -> Vec<String> {
    let moves = plan.steps.iter().any(|step| {
        matches!(
            step.action,
            RecoveryAction::Press(..)
                | RecoveryAction::Resume
                | RecoveryAction::Hold { .. }
                | RecoveryAction::Rejoin { .. }
        )
    });
    match cell {
        _ if !moves && !plan.has_alarms() => Vec::new(),
        None => vec![NOT_KNOWN.to_owned()],
        Some(cell) => of_cell(cell),
    }
}

const NOT_KNOWN: &str = "parts: no state says where they lie: look at each station before it is led";

fn of_cell(cell: &CellState) -> Vec<String> {
    if cell.parts_inside == 0 {
        return vec!["parts: none, as the coordinator has it: take out what lies in the cell all the same".to_owned()];
    }
    let in_failed = |part: u64| cell.activities.as_slice().iter().any(|of| of.part == part && !of.running);
    let lines = cell.parts.as_slice().iter().map(|of| {
        let check = if in_failed(of.id) { ": look where it is; the answer to its alarm says so" } else { "" };
        format!("  part {}: {}{check}", of.id, of.place)
    });
    let mut lines: Vec<String> =
        std::iter::once("parts, as the coordinator has them; see that they are there:".to_owned())
            .chain(lines)
            .collect();
    let more = (cell.parts_inside as usize).saturating_sub(cell.parts.as_slice().len());
    lines.extend((more > 0).then(|| format!("  and {more} more")));
    lines
}

#[cfg(test)]
mod tests {
    use linewright_line::StationId;
    use linewright_line::net::ControlMode;
    use linewright_msgs::{ActivityState, Bounded, PartState};
    use linewright_recovery::{PanelButton, RecoveryEnd, RecoveryStep};

    use super::*;

    #[test]
    fn the_parts_of_a_cell_stand_above_a_list_that_moves_something() {
        let part = |id, place: &str| PartState { id, place: place.to_owned(), ..PartState::default() };
        let failed = ActivityState { part: 2, running: false, ..ActivityState::default() };
        let cell = CellState {
            parts_inside: 2,
            parts: Bounded::new(vec![part(1, "in ST"), part(2, "`load M1`, which has failed")]).expect("few"),
            activities: Bounded::new(vec![failed]).expect("few"),
            ..CellState::default()
        };
        let action = RecoveryAction::Press(StationId(0), PanelButton::Advance);
        let press =
            RecoveryStep { action, moves: Vec::new(), mode: ControlMode::Manual, after: None, is_doubtful: false };
        let led = RecoveryPlan::ends(vec![press], RecoveryEnd::Auto);
        let of_cell = lines(&led, Some(&cell));
        assert_eq!(of_cell.len(), 3);
        assert_eq!(of_cell[1], "  part 1: in ST");
        assert!(
            of_cell[2].starts_with("  part 2: `load M1`") && of_cell[2].contains("look where it is"),
            "{of_cell:?}"
        );
        assert_eq!(lines(&led, None), [NOT_KNOWN]);
        let nothing = RecoveryPlan::ends(Vec::new(), RecoveryEnd::Auto);
        assert!(lines(&nothing, Some(&cell)).is_empty());
    }
}
