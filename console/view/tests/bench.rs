//! The shipped line with states that a test chooses, at times that it chooses.

use std::time::Duration;

use linewright_console_view::{Aged, CellChoices, ConsoleInputs, ConsolePage, ConsoleView, state_fresh};
use linewright_line::{Line, StationId};
use linewright_msgs::{CellState, LineState, StationState};

/// A time since the begin of the console.
pub fn ms(of: u64) -> Duration {
    Duration::from_millis(of)
}

/// What the cell of a test has.
pub fn names() -> CellChoices {
    CellChoices { products: vec!["A".to_owned()], resources: vec!["M1".to_owned(), "R".to_owned()] }
}

/// States with the times at which they were received.
pub struct ViewBench {
    pub line: Line,
    pub view: ConsoleView,
    pub coordinator: Option<(LineState, u64)>,
    pub stations: Vec<Option<(StationState, u64)>>,
    pub cell: Option<(CellState, u64)>,
}

fn mode_name(code: u8) -> &'static str {
    if code == StationState::MODE_AUTO { "auto" } else { "other" }
}

impl ViewBench {
    /// Nothing is received yet.
    pub fn new(is_cell: bool) -> Self {
        let text = linewright_line::TransferLine::default().text();
        let line = linewright_line::parse("line.toml", &text).expect("parses").line;
        let view = ConsoleView::new(&line, is_cell.then(names), mode_name);
        ViewBench { view, coordinator: None, stations: vec![None; line.stations.len()], cell: None, line }
    }

    /// Begins anew with the line as it is now.
    pub fn retitled(&mut self) {
        self.view = ConsoleView::new(&self.line, None, mode_name);
    }

    /// Everything is received at this time, in auto and at rest.
    pub fn received(at: u64) -> Self {
        let mut bench = ViewBench::new(false);
        let auto =
            LineState { mode: StationState::MODE_AUTO, text: "auto".to_owned(), enabled: true, ..LineState::default() };
        bench.coordinator = Some((auto, at));
        for id in bench.line.station_ids() {
            bench.stations[id.index()] = Some((bench.at_rest(id), at));
        }
        bench
    }

    /// A state of a station that does nothing.
    pub fn at_rest(&self, id: StationId) -> StationState {
        let operations = self.line.station(id).operations.len();
        StationState {
            mode: StationState::MODE_AUTO,
            boot_id: 1,
            stopped: true,
            devices_valid: true,
            operation: "at rest".to_owned(),
            places: vec![StationState::PLACE_COMPLETED; operations],
            done: vec![0; operations],
            ..StationState::default()
        }
    }

    /// The age from which nothing is shown any more, in ms.
    pub fn fresh(&self) -> u64 {
        u64::try_from(state_fresh(&self.line).as_millis()).expect("short")
    }

    /// The page of this time.
    pub fn page(&mut self, now: u64) -> ConsolePage {
        fn aged<T>(of: &Option<(T, u64)>, now: u64) -> Option<Aged<'_, T>> {
            of.as_ref().map(|(state, at)| Aged { state, age: ms(now - at) })
        }
        let inputs = ConsoleInputs {
            line: aged(&self.coordinator, now),
            stations: self.stations.iter().map(|of| aged(of, now)).collect(),
            cell: aged(&self.cell, now),
            ..ConsoleInputs::nothing(ms(now), &self.line)
        };
        self.view.page(&inputs)
    }
}
