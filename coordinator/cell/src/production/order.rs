//! One production order and its progress.
//!
//! Counts and moments, no decisions. A part counts from its entering on, and is done when it has left; lateness is that of
//! the last one, as for a customer of the whole order.

use linewright_line::Tick;
use serde::{Deserialize, Serialize};

use super::super::dispatch::PartPriority;
use super::super::ids::ProductionId;
use super::super::serial;
use super::request::ProductionOrderRequest;

/// An order that was accepted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProductionOrder {
    pub id: ProductionId,
    pub request: ProductionOrderRequest,
    /// Its product, as an index.
    pub product: usize,
    pub after: Vec<ProductionId>,
    /// Time of acceptance.
    #[serde(with = "serial::micros")]
    pub accepted: Tick,
    /// Number of parts inside or left, without those that are lost.
    pub entered: u32,
    /// Number of parts that have left.
    pub done: u32,
    /// Of those, the number that left after the order had been cancelled.
    pub surplus: u32,
    /// Number of parts lost; others have entered, or will, in their place.
    pub lost: u32,
    /// Numbers in the order of lost parts that no other part has taken.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub freed: Vec<u32>,
    /// Time at which its first part entered.
    #[serde(default, with = "serial::maybe", skip_serializing_if = "Option::is_none")]
    pub begun: Option<Tick>,
    /// Time at which its last part so far entered.
    #[serde(default, with = "serial::maybe", skip_serializing_if = "Option::is_none")]
    pub newest: Option<Tick>,
    /// Time of cancellation.
    #[serde(default, with = "serial::maybe", skip_serializing_if = "Option::is_none")]
    pub cancelled: Option<Tick>,
    /// It was withdrawn.
    pub withdrawn: bool,
    /// End: the last part has left, or it was withdrawn.
    #[serde(default, with = "serial::maybe", skip_serializing_if = "Option::is_none")]
    pub ended: Option<Tick>,
}

/// Status of an order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProductionStatus {
    /// Nothing of it may enter yet.
    Waiting {
        /// Orders that it is after and that are not over.
        on: Vec<ProductionId>,
        /// Time until which it is not released, if that is to come.
        until: Option<Tick>,
    },
    /// Its parts may enter.
    Released,
    /// Some have.
    InWork {
        /// Time at which its first part entered.
        begun: Tick,
    },
    /// All have left.
    Done {
        /// Time at which its last part left.
        at: Tick,
    },
    /// Nothing more enters.
    Cancelled {
        at: Tick,
        /// Number of parts still inside.
        inside: u32,
    },
    /// As if it had never been.
    Withdrawn,
}

impl ProductionOrder {
    pub(super) fn new(
        id: ProductionId,
        request: ProductionOrderRequest,
        product: usize,
        after: Vec<ProductionId>,
        at: Tick,
    ) -> Self {
        ProductionOrder {
            id,
            request,
            product,
            after,
            accepted: at,
            entered: 0,
            done: 0,
            surplus: 0,
            lost: 0,
            freed: Vec::new(),
            begun: None,
            newest: None,
            cancelled: None,
            withdrawn: false,
            ended: None,
        }
    }

    /// Number of parts that have still to enter.
    pub fn missing(&self) -> u32 {
        let closed = self.withdrawn || self.cancelled.is_some();
        if closed { 0 } else { self.request.quantity.saturating_sub(self.entered) }
    }

    /// Number of parts inside.
    pub fn inside(&self) -> u32 {
        self.entered.saturating_sub(self.done)
    }

    /// By how many microseconds it was late when it was done, negative if it was early; none while it is not done, if it is
    /// not due, or was cancelled.
    pub fn lateness(&self) -> Option<i64> {
        let (due, ended) = (self.request.due?, self.ended.filter(|_| self.cancelled.is_none() && !self.withdrawn)?);
        let micros = |tick: Tick| i64::try_from(tick.as_micros()).unwrap_or(i64::MAX);
        Some(micros(ended).saturating_sub(micros(due)))
    }

    /// Due date and priority of its parts. Those of a cancelled one do not matter any more.
    pub fn job(&self) -> PartPriority {
        match self.cancelled {
            Some(_) => PartPriority::default(),
            None => PartPriority { due: self.request.due, priority: self.request.priority },
        }
    }

    /// Of two orders of one product, the one whose parts enter first has the smaller key: highest priority, then earliest
    /// due date, then first accepted.
    pub(super) fn turn(&self) -> impl Ord + use<> {
        (std::cmp::Reverse(self.request.priority), self.request.due.unwrap_or(Tick::NEVER), self.id)
    }
}
