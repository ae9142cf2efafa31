//! Actions: something that takes time, can be cancelled, and has a result.
//!
//! As with services ([`crate::service`]) there are two ways of relating an answer to its request, and which one a
//! client uses is not known in advance. Here the client library fixes the shape of the answers, so the trick used there
//! does not work: instead an action is offered twice under one name, once in each way. Each request arrives at both,
//! and makes sense to one of them: the other finds sixteen bytes too many or too few, and stays silent. Feedback and
//! status need no answer and are sent once.
//!
//! A goal that the owner refuses is accepted and ends as aborted: ROS 2's own rejection has no room for a reason. Only
//! a goal that does not decode, or for which there is no room, is rejected, or not answered at all.

mod caller;
mod goals;
mod server;

use ros2_client::QosProfile;
use ros2_client::action::{ActionClientQosPolicies, ActionServerQosPolicies};

pub use caller::{ActionCaller, GoalError, GoalOutcome};
pub use goals::GoalEnd;
pub(crate) use server::RawActionServer;
pub use server::{ActionOffer, ActionOwner, GoalAsked, GoalHandle, GoalRequest, serve_action};

use crate::qos;

/// Feedback is for people: the newest few.
fn feedback() -> QosProfile {
    qos::event()
}

pub(crate) fn server_qos() -> ActionServerQosPolicies {
    ActionServerQosPolicies {
        goal_service: qos::service(),
        result_service: qos::service(),
        cancel_service: qos::service(),
        feedback_publisher: feedback(),
        status_publisher: qos::latched_state(),
    }
}

pub(crate) fn client_qos() -> ActionClientQosPolicies {
    ActionClientQosPolicies {
        goal_service: qos::service(),
        result_service: qos::service(),
        cancel_service: qos::service(),
        feedback_subscription: feedback(),
        status_subscription: qos::latched_state(),
    }
}
