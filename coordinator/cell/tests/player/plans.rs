//! Plans for nets of the tests, and what they are compiled to.

use std::sync::Arc;
use std::time::Duration;

use linewright_coordinator_cell::{
    ActivityTiming, CellId, CellKind, CellTable, ModeId, PartPick, PlayPlan, PlayedActivity, PlayedOrderTemplate,
    TaskParameterValue,
};
use linewright_line::StationId;
use linewright_nets::coloured::{ColouredNet, Colours, Unfolding, unfold};

/// A net, its long form, and the table made of it.
pub struct Compiled {
    pub net: ColouredNet,
    pub long: Unfolding,
    pub table: Arc<CellTable>,
}

impl Compiled {
    /// Compiles a net; `kind` is the kind of the tokens of a cell and `activity` the activity of a mode, both by name.
    pub fn new(net: ColouredNet, kind: impl Fn(&str) -> CellKind, activity: impl Fn(&str) -> PlayedActivity) -> Self {
        let long = unfold(&net, Colours::Reachable, 100_000).unwrap();
        let names = long.net();
        let activities: Vec<_> = names.transitions().map(|t| activity(names.transition_name(t))).collect();
        let plan = PlayPlan {
            cells: names.places().map(|p| kind(names.place_name(p))).collect(),
            activity_of: (0..activities.len()).collect(),
            activities,
            repeat_interval: Duration::from_millis(200),
            grace: Duration::from_secs(1),
            products: Vec::new(),
            stores: Vec::new(),
        };
        let table = Arc::new(CellTable::compile(&long, plan).unwrap());
        Compiled { net, long, table }
    }

    pub fn mode(&self, name: &str) -> ModeId {
        self.table.modes().find(|&mode| self.table.mode_name(mode) == name).unwrap_or_else(|| panic!("no mode {name}"))
    }

    pub fn cell(&self, name: &str) -> CellId {
        self.table.cells().find(|&cell| self.table.cell_name(cell) == name).unwrap_or_else(|| panic!("no cell {name}"))
    }

    pub fn names(&self, modes: impl IntoIterator<Item = ModeId>) -> Vec<&str> {
        modes.into_iter().map(|mode| self.table.mode_name(mode)).collect()
    }
}

pub const TOKENS: CellKind = CellKind::Tokens;
pub const PARTS: CellKind = CellKind::Parts(PartPick::Any);

/// An activity that happens by itself.
pub fn immediate() -> PlayedActivity {
    PlayedActivity { name: "immediate".into(), kind: ActivityTiming::Immediate, servers: 1, orders: Vec::new() }
}

/// An activity that is decided and takes so many milliseconds, without stations.
pub fn alone(millis: u64) -> PlayedActivity {
    let kind = ActivityTiming::Decided { time: Duration::from_millis(millis), limit: None };
    PlayedActivity { name: "alone".into(), kind, servers: 1, orders: Vec::new() }
}

/// An activity of these stations together, each of them in so many milliseconds at most.
pub fn ordered(task: &str, stations: &[u16], limit_ms: u64) -> PlayedActivity {
    let order = |&station: &u16| PlayedOrderTemplate {
        station: StationId(station),
        task: task.into(),
        parameters: vec![("program".into(), TaskParameterValue::Number(i32::from(station)))],
        limit: Duration::from_millis(limit_ms),
    };
    let orders = stations.iter().map(order).collect();
    PlayedActivity { orders, name: task.into(), ..alone(limit_ms / 2) }
}
