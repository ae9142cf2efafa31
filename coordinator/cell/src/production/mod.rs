//! Production orders: what is to be made, how many, from when, until when, and after what.
//!
//! # Map
//! - [`ProductionOrderRequest`]: a request; [`RequestProblem`]: its errors, all at once.
//! - [`ProductionOrder`], [`ProductionStatus`]: an order that was accepted, and where it is.
//! - [`Production`]: all of them, a fold over the records of the cell: those of operators' changes ([`ProductionChange`]), and
//!   those of parts that have entered or left. It is part of the cell's state. A dispatcher has one of its own, since it also
//!   decides in forward simulations.
//! - [`DispatchConfiguration`]: the dispatcher with rules; it lets in the parts of production orders and has their due
//!   dates.
//!
//! ```text
//!  waiting ──released, and all before it are over──▶ released ──its first part enters──▶ in work ──its last leaves──▶ done
//!     │                                                 │                                   │
//!     ├──── withdraw: before anything has entered ──────┤                                   │
//!     ▼                                                 ▼                                   ▼
//!  withdrawn                                        withdrawn             cancelled (at any time before it is done)
//! ```
//! *Withdrawn* orders are as if they had never been. Of a *cancelled* one nothing more enters; parts that are inside are
//! finished as surplus, and it is over when the last of them has left. Nothing here depends on how products are made.

mod change;
mod configuration;
mod kept;
mod ledger;
mod order;
mod request;

pub use change::{ProductionChange, ProductionMisfit, ProductionRefusal};
pub use configuration::DispatchConfiguration;
pub(super) use kept::SavedProduction;
pub use ledger::Production;
pub use order::{ProductionOrder, ProductionStatus};
pub use request::{NAME_MAX, ORDERS_MAX, ProductionOrderRequest, QUANTITY_MAX, RequestProblem};
