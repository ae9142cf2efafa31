//! Production orders: what is to be made, how many, from when, until when, and after what.
//!
//! # Map
//! - [`Request`]: what somebody asks for; [`Wrong`]: what is wrong with it, all of it at once.
//! - [`Order`], [`Status`]: an order that was accepted, and where it is.
//! - [`Production`]: all of them. It changes by [`Change`]s, which people cause, and by the records of the cell, which say
//!   what has entered and what has left. Both are folded in the order in which they were written, so a restart has them
//!   all again.
//! - [`Desk`]: the dispatcher with rules, who lets in what is on order and knows when each part is due.
//!
//! ```text
//!  waiting ──released, and all before it are over──▶ released ──its first part enters──▶ in work ──its last leaves──▶ done
//!     │                                                 │                                   │
//!     ├──── withdraw: before anything has entered ──────┤                                   │
//!     ▼                                                 ▼                                   ▼
//!  withdrawn                                        withdrawn             cancelled (at any time before it is done)
//! ```
//! *Withdrawn* orders are as if they had never been. Of a *cancelled* one nothing more enters; parts that are inside are
//! finished as surplus, and it is over when the last of them has left. Nothing here knows how products are made.

mod book;
mod desk;
mod order;
mod request;

pub use book::{Change, Production, Refused, Unfit};
pub use desk::Desk;
pub use order::{Order, Status};
pub use request::{NAME_MAX, ORDERS_MAX, QUANTITY_MAX, Request, Wrong};
