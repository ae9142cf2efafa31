//! Digest of the meaning of a cell's records.
//!
//! Records name modes, cells and stations by number, so they are about one table and no other. Their meaning depends on
//! the net, on the names of its modes and cells, and on the stations' orders; it does not depend on times and limits,
//! which may be changed between two lives of a coordinator: what is in progress then has the new ones.

use linewright_line::Fnv;

use super::plan::{ActivityTiming, CellKind, PartPick, TaskParameterValue};
use super::table::CellTable;

impl CellTable {
    /// Equal for tables whose records mean the same; otherwise different, except in one case in 2⁶⁴.
    pub fn digest(&self) -> u64 {
        let mut sum = Fnv::default();
        sum.number(self.cell_count() as u64);
        for cell in self.cells() {
            sum.text(self.cell_name(cell));
            sum.number(match self.kind(cell) {
                CellKind::Tokens => 0,
                CellKind::Parts(PartPick::Any) => 1,
                CellKind::Parts(PartPick::Oldest) => 2,
                CellKind::Parts(PartPick::Newest) => 3,
            });
            sum.number(self.initial()[cell.index()]);
        }
        sum.number(self.mode_count() as u64);
        for mode in self.modes() {
            sum.text(self.mode_name(mode));
            let mut takes = self.takes(mode).to_vec();
            takes.sort_unstable();
            for arcs in [&takes[..], self.gives(mode)] {
                sum.number(arcs.len() as u64);
                for &(cell, weight) in arcs {
                    sum.number(u64::from(cell.0));
                    sum.number(u64::from(weight));
                }
            }
            let activity = self.activity(mode);
            sum.text(&activity.name);
            sum.number(match activity.kind {
                ActivityTiming::Immediate => 0,
                ActivityTiming::Decided { time: _, limit: _ } => 1,
            });
            sum.number(u64::from(activity.servers));
            sum.number(activity.orders.len() as u64);
            for order in &activity.orders {
                sum.number(u64::from(order.station.0));
                sum.text(&order.task);
                sum.number(order.parameters.len() as u64);
                for (name, value) in &order.parameters {
                    sum.text(name);
                    sum.number(match *value {
                        TaskParameterValue::Number(number) => u64::from(number.cast_unsigned()),
                        TaskParameterValue::Source => 1 << 32,
                        TaskParameterValue::Target => 2 << 32,
                    });
                }
            }
        }
        sum.number(self.products().len() as u64);
        for product in self.products() {
            sum.text(&product.name);
            sum.number(product.enters.len() as u64);
            product.enters.iter().for_each(|mode| sum.number(u64::from(mode.0)));
        }
        sum.number(self.stores().len() as u64);
        for store in self.stores() {
            sum.number(store.cells.len() as u64);
            store.cells.iter().for_each(|cell| sum.number(u64::from(cell.0)));
        }
        for resource in &self.handling().resources {
            sum.text(&resource.name);
        }
        sum.sum()
    }
}
