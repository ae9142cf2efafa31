//! Form of production orders in a snapshot.
//!
//! What is in the table is not written down. On the way in everything is checked against the table and against itself: what
//! has passed is what records have made, or could have.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::super::ids::{FiringId, PartId, ProductionId};
use super::super::table::CellTable;
use super::ledger::Production;
use super::order::ProductionOrder;

/// Production orders, to be written down.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct SavedProduction {
    orders: Vec<ProductionOrder>,
    of_part: Vec<(PartId, ProductionId)>,
    leaving: Vec<(FiringId, PartId)>,
    last: u64,
}

impl Production {
    /// The part of it that is written down.
    pub(in super::super) fn kept(&self) -> SavedProduction {
        SavedProduction {
            orders: self.orders.values().cloned().collect(),
            of_part: self.of_part.iter().map(|(&part, &id)| (part, id)).collect(),
            leaving: self.leaving.iter().map(|(&firing, &part)| (firing, part)).collect(),
            last: self.last,
        }
    }

    /// The production orders that were written down.
    pub(in super::super) fn restored(table: &CellTable, kept: SavedProduction) -> Result<Self, String> {
        let mut new = Production::new(table);
        new.last = kept.last;
        for order in kept.orders {
            let id = order.id;
            let product = new.products.iter().position(|product| **product == *order.request.product);
            if product != Some(order.product) || id.0 > kept.last || order.after.iter().any(|&after| after >= id) {
                return Err(format!("{id}: product unknown, or predecessor has a later number"));
            }
            if order.done > order.entered || order.begun.is_none() && order.entered + order.lost > 0 {
                return Err(format!("of {id} more parts have left than entered"));
            }
            if new.orders.insert(id, order).is_some() {
                return Err(format!("{id} is in it twice"));
            }
        }
        let mut inside: BTreeMap<ProductionId, u32> = BTreeMap::new();
        for (part, id) in kept.of_part {
            if new.of_part.insert(part, id).is_some() {
                return Err(format!("{part} counts to two orders"));
            }
            *inside.entry(id).or_default() += 1;
        }
        let counts = |order: &ProductionOrder| order.inside() == inside.remove(&order.id).unwrap_or(0);
        if !new.orders.values().all(counts) || !inside.is_empty() {
            return Err("parts count to other orders than those that have parts inside".to_owned());
        }
        for (firing, part) in kept.leaving {
            if !new.of_part.contains_key(&part) || new.leaving.insert(firing, part).is_some() {
                return Err(format!("{firing} takes out a part of no order, or two"));
            }
        }
        Ok(new)
    }
}
