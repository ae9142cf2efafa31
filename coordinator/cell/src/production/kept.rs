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
    /// Numbers of these parts in their orders; without them those that have left were the first.
    #[serde(default)]
    numbers: Vec<u32>,
    leaving: Vec<(FiringId, PartId)>,
    last: u64,
}

impl Production {
    /// The part of it that is written down.
    pub(in super::super) fn kept(&self) -> SavedProduction {
        SavedProduction {
            orders: self.orders.values().cloned().collect(),
            of_part: self.of_part.iter().map(|(&part, &(id, _))| (part, id)).collect(),
            numbers: self.of_part.values().map(|&(_, number)| number).collect(),
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
        let mut numbers = kept.numbers.into_iter();
        for (part, id) in kept.of_part {
            let inside = inside.entry(id).or_default();
            *inside += 1;
            let done = new.orders.get(&id).map_or(0, |order| order.done);
            let number = numbers.next().unwrap_or_else(|| done.saturating_add(*inside));
            if new.of_part.insert(part, (id, number)).is_some() {
                return Err(format!("{part} counts to two orders"));
            }
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
