//! Cells in `run`: parts are ordered when the cell is in auto, and their production is awaited.

use std::collections::BTreeSet;
use std::time::Instant;

use linewright_cell::Cell;
use linewright_console_view::{answers, is_over};
use linewright_line::Line;
use linewright_msgs::{CellState, ProductionState};
use linewright_node_shell::RosArgs;
use miette::miette;

use crate::cell::{CellClient, request};

/// A cell that runs.
pub struct CellRun {
    client: CellClient,
    /// Part types ordered, with their quantities.
    wanted: Vec<(String, u32)>,
    /// Numbers of the production orders, once they are accepted.
    ids: Option<BTreeSet<u64>>,
    /// Alarms that were shown.
    shown: BTreeSet<u64>,
    /// Parts that had left when the cell was first heard.
    left_before: Option<u64>,
    /// When something last went on, and what it was.
    progress: (u64, Instant),
}

impl CellRun {
    /// What is to be shown next of a cell; of a line without one never anything.
    pub async fn next_of(cell: &mut Option<CellRun>) -> miette::Result<Vec<String>> {
        match cell {
            Some(cell) => cell.next().await,
            None => std::future::pending().await,
        }
    }

    /// Looks at the cell; nothing is ordered yet.
    pub fn open(line: &Line, cell: &Cell, parts: Vec<(String, u32)>, ros: &RosArgs) -> miette::Result<Self> {
        for (name, _) in &parts {
            if cell.part_type_named(name).is_none() {
                let known: Vec<&str> = cell.part_types.iter().map(|part| part.name.as_str()).collect();
                return Err(miette!("there is no part type '{name}'; the cell makes {}", known.join(", ")));
            }
        }
        let client = CellClient::open(line, ros, "run_cell")?;
        let wanted = parts.into_iter().filter(|(_, count)| *count > 0).collect();
        Ok(CellRun {
            client,
            wanted,
            ids: None,
            shown: BTreeSet::new(),
            left_before: None,
            progress: (0, Instant::now()),
        })
    }

    /// What is received of it.
    pub fn client(&self) -> &CellClient {
        &self.client
    }

    /// Waits for a newer state; gives what a person should read. Cancel safe.
    pub async fn next(&mut self) -> miette::Result<Vec<String>> {
        let state = self.client.next().await?;
        self.left_before.get_or_insert(state.parts_left);
        let mut lines = Vec::new();
        for alarm in state.alarms.as_slice() {
            if self.shown.insert(alarm.id) {
                lines.push(format!("alarm {}: {} Answer: {}.", alarm.id, alarm.text, answers(alarm)));
            }
        }
        let newest = state.activities.as_slice().iter().map(|activity| activity.id).max().unwrap_or(0);
        let progress = newest + state.parts_left + state.activities.as_slice().len() as u64;
        if progress != self.progress.0 {
            self.progress = (progress, Instant::now());
        }
        Ok(lines)
    }

    /// The newest state, unless the coordinator is silent.
    pub fn state(&self) -> Option<&CellState> {
        self.client.heard_lately()
    }

    /// When something last went on.
    pub fn since(&self) -> Instant {
        self.progress.1
    }

    /// Submits the production orders, once.
    pub async fn begin(&mut self) -> miette::Result<()> {
        if self.ids.is_some() || self.wanted.is_empty() {
            return Ok(());
        }
        let name = |product: &str| format!("{product} of run {}", std::process::id());
        let requests = self.wanted.iter().map(|(product, count)| request(&name(product), product, *count));
        self.ids = Some(self.client.submit(requests.collect()).await?.into_iter().collect());
        self.progress.1 = Instant::now();
        Ok(())
    }

    fn ours(&self) -> impl Iterator<Item = &ProductionState> {
        let ids = self.ids.as_ref();
        let orders = self.client.state().into_iter().flat_map(|state| state.orders.as_slice());
        orders.filter(move |order| ids.is_some_and(|ids| ids.contains(&order.id)))
    }

    /// Whether all that was ordered here is over.
    pub fn is_over(&self) -> bool {
        let over = self.ours().filter(|order| is_over(order)).count();
        self.ids.as_ref().is_some_and(|ids| over == ids.len())
    }

    /// Number of parts made of those ordered here, and number ordered.
    pub fn made(&self) -> (u32, u32) {
        (self.ours().map(|order| order.done).sum(), self.wanted.iter().map(|(_, count)| count).sum())
    }

    /// Alarms that were raised, and parts ordered here that were lost and made again.
    pub fn exceptions(&self) -> (usize, u32) {
        (self.shown.len(), self.ours().map(|order| order.lost).sum())
    }

    /// Number of parts that have left since the cell was first heard.
    pub fn left(&self) -> u64 {
        let now = self.client.state().map(|state| state.parts_left);
        now.zip(self.left_before).map_or(0, |(now, before)| now.saturating_sub(before))
    }

    /// What it waits for, in words.
    pub fn waits(&self) -> Vec<String> {
        let Some(state) = self.client.state() else { return vec!["no state received from the cell".to_owned()] };
        let alarms = state.alarms.as_slice().iter().map(|alarm| format!("alarm {}: {}", alarm.id, alarm.text));
        let activities = |state: &CellState| {
            let line = |a: &linewright_msgs::ActivityState| format!("`{}` of part {}: {}", a.name, a.part, a.text);
            state.activities.as_slice().iter().map(line).collect::<Vec<_>>()
        };
        alarms.chain(activities(state)).collect()
    }
}
