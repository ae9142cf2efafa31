//! Changes of production orders, and why one is refused.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::super::ids::{PartId, ProductionId};
use super::request::ProductionOrderRequest;

/// Operators' changes. To be written down before any reply.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ProductionChange {
    /// A request is an order now.
    Accepted {
        id: ProductionId,
        /// As requested.
        request: ProductionOrderRequest,
    },
    /// Nothing more of it enters.
    Cancelled(ProductionId),
    /// It is as if it had never been.
    Withdrawn(ProductionId),
    /// A part is no more, or is of no use: another one has to enter.
    Lost(PartId),
}

impl ProductionChange {
    /// The order that it changes; none if a part does.
    pub fn order(&self) -> Option<ProductionId> {
        match *self {
            ProductionChange::Accepted { id, request: _ }
            | ProductionChange::Cancelled(id)
            | ProductionChange::Withdrawn(id) => Some(id),
            ProductionChange::Lost(_) => None,
        }
    }
}

/// Reason why an order is not cancelled or withdrawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProductionRefusal {
    /// No production order has this name.
    Unknown {
        /// Name in the request.
        name: String,
        hint: Option<String>,
    },
    /// There is nothing left to change.
    Over(String),
    /// It can only be cancelled.
    Begun {
        name: String,
        /// Number of its parts that have entered, lost ones among them.
        entered: u32,
    },
    /// Others would wait for ever.
    Needed {
        name: String,
        /// The first that waits for it.
        by: String,
    },
}

/// A change that does not fit these orders.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("a change of production orders does not fit: {0}")]
pub struct ProductionMisfit(pub String);
