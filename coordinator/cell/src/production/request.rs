//! A request for a production order, and its validation.
//!
//! Requests come in batches, so that some of a batch can be after others of it. A batch is accepted whole or not at all, and
//! all errors are reported at once. Names are operators': any text of one line.

use std::collections::{BTreeMap, BTreeSet};

use linewright_line::{Tick, suggestion};
use serde::{Deserialize, Serialize};

use super::super::serial;

/// The longest name, in letters.
pub const NAME_MAX: usize = 64;
/// The most parts of one order.
pub const QUANTITY_MAX: u32 = 1_000_000;
/// The most orders that are not over, at once.
pub const ORDERS_MAX: usize = 10_000;

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProductionOrderRequest {
    /// Drawn by the requester. The same request twice is one order.
    #[serde(with = "serial::key")]
    pub key: u128,
    /// Operators' name of it. Of orders that are not over each has a name of its own.
    pub name: String,
    /// Product to be made.
    pub product: String,
    /// Number of parts, from 1 to [`QUANTITY_MAX`].
    pub quantity: u32,
    /// Nothing of it enters before this; none for at once.
    #[serde(default, with = "serial::maybe", skip_serializing_if = "Option::is_none")]
    pub release: Option<Tick>,
    /// Due date of all of it; none if it does not matter.
    #[serde(default, with = "serial::maybe", skip_serializing_if = "Option::is_none")]
    pub due: Option<Tick>,
    /// Priority; more comes first.
    pub priority: i32,
    /// The orders that have to be over before anything of it enters, by name.
    pub after: Vec<String>,
}

/// Error in a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RequestProblem {
    /// Not usable as a name.
    Name(String),
    /// An order of that name is not over.
    NameTaken(String),
    /// Two of one batch.
    NameTwice(String),
    /// Another request had this key.
    KeyTaken {
        name: String,
        /// The one that had the key before.
        other: String,
    },
    /// Nothing of that name is made here.
    Product {
        name: String,
        /// Product requested.
        product: String,
        hint: Option<String>,
    },
    /// None, or too many.
    Quantity {
        name: String,
        /// Quantity requested.
        quantity: u32,
    },
    /// It could not be in time.
    DueBeforeRelease {
        name: String,
        /// Due date.
        due: Tick,
        release: Tick,
    },
    /// It waits for an order that does not exist.
    NoSuchOrder { name: String, after: String, hint: Option<String> },
    /// It waits for an order that was withdrawn.
    AfterWithdrawn { name: String, after: String },
    /// Each waits for the next, and the last for the first.
    Circle(Vec<String>),
    /// More than are kept.
    TooMany {
        /// Number of orders there would be.
        open: usize,
    },
}

impl ProductionOrderRequest {
    /// Errors in the request itself.
    pub(super) fn validate<'a>(&self, products: impl Iterator<Item = &'a str> + Clone) -> Vec<RequestProblem> {
        let (mut wrongs, name) = (Vec::new(), || self.name.clone());
        let letters = self.name.chars().count();
        if letters == 0 || letters > NAME_MAX || self.name.trim().is_empty() || self.name.chars().any(char::is_control)
        {
            // What is too long to be a name is not repeated whole.
            wrongs.push(RequestProblem::Name(self.name.chars().take(NAME_MAX).collect()));
        }
        if !products.clone().any(|product| product == self.product) {
            let hint = suggestion(&self.product, products);
            wrongs.push(RequestProblem::Product { name: name(), product: self.product.clone(), hint });
        }
        if self.quantity == 0 || self.quantity > QUANTITY_MAX {
            wrongs.push(RequestProblem::Quantity { name: name(), quantity: self.quantity });
        }
        if let (Some(due), Some(release)) = (self.due, self.release)
            && due < release
        {
            wrongs.push(RequestProblem::DueBeforeRelease { name: name(), due, release });
        }
        wrongs
    }
}

/// A circle among requests that are after one another, if there is one, from its smallest name; by depth-first search
/// without recursion, since a batch may be a long chain.
pub(super) fn find_circle(requests: &[&ProductionOrderRequest]) -> Option<Vec<String>> {
    let after: BTreeMap<&str, &[String]> =
        requests.iter().map(|request| (request.name.as_str(), request.after.as_slice())).collect();
    let mut over: BTreeSet<&str> = BTreeSet::new();
    for &root in after.keys() {
        let (mut path, mut on_path) = (vec![(root, 0)], BTreeSet::from([root]));
        if over.contains(root) {
            continue;
        }
        while let Some((at, next)) = path.last_mut() {
            let name = *at;
            let Some(before) = after.get(name).and_then(|names| names.get(*next)) else {
                over.insert(name);
                on_path.remove(name);
                path.pop();
                continue;
            };
            *next += 1;
            if on_path.contains(before.as_str()) {
                let from = path.iter().position(|(name, _)| name == before).unwrap_or(0);
                return Some(path[from..].iter().map(|(name, _)| (*name).to_owned()).collect());
            }
            if after.contains_key(before.as_str()) && !over.contains(before.as_str()) {
                on_path.insert(before);
                path.push((before, 0));
            }
        }
    }
    None
}

/// Requests of which each comes after those it is after, otherwise as they are (Kahn 1962). There is no circle.
pub(super) fn in_order(requests: &[&ProductionOrderRequest]) -> Vec<ProductionOrderRequest> {
    let place: BTreeMap<&str, usize> = requests.iter().enumerate().map(|(at, of)| (of.name.as_str(), at)).collect();
    let before =
        |of: &ProductionOrderRequest| of.after.iter().filter_map(|name| place.get(name.as_str()).copied()).collect();
    let mut waits: Vec<BTreeSet<usize>> = requests.iter().map(|request| before(request)).collect();
    let mut followers: Vec<Vec<usize>> = vec![Vec::new(); requests.len()];
    for (at, before) in waits.iter().enumerate() {
        before.iter().for_each(|&earlier| followers[earlier].push(at));
    }
    let mut ready: BTreeSet<usize> = (0..requests.len()).filter(|&at| waits[at].is_empty()).collect();
    let mut sorted = Vec::with_capacity(requests.len());
    while let Some(at) = ready.pop_first() {
        sorted.push(requests[at].clone());
        for &follower in &followers[at] {
            waits[follower].remove(&at);
            if waits[follower].is_empty() {
                ready.insert(follower);
            }
        }
    }
    sorted
}
