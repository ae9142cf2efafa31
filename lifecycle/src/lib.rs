//! The state of a managed node of ROS 2, and the transitions that lead from one state to the next.
//!
//! A node is *unconfigured*, *inactive*, *active* or *finalized*. A request begins a transition; while its work is done the node is in one of
//! the states between, and how the work ended decides where the transition leads. Numbers and labels are those that `rcl_lifecycle`
//! publishes, so tools and lifecycle managers of ROS 2 find what they know.
//!
//! This crate knows no node, no message and no time: what a transition does is done by its caller.
//!
//! ```
//! use linewright_lifecycle::{LifecycleOutcome, LifecycleRequest, LifecycleState, NodeLifecycle};
//!
//! let mut node = NodeLifecycle::default();
//! let configure = LifecycleRequest::Label("configure");
//! assert_eq!(node.begin(configure).unwrap().to, LifecycleState::Configuring);
//! // The journal cannot be read: the node stays as it was.
//! assert_eq!(node.conclude(LifecycleOutcome::Failure).unwrap().to, LifecycleState::Unconfigured);
//! // Nothing leads from there to activity at once.
//! assert!(node.begin(LifecycleRequest::Label("activate")).is_none());
//! ```

mod machine;
mod state;
mod table;

pub use machine::{LifecycleOutcome, LifecycleRequest, NodeLifecycle};
pub use state::LifecycleState;
pub use table::{LIFECYCLE_TABLE, LifecycleStep, steps_from};
