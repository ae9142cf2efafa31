//! Course of an activity that has failed: secured, alarmed, answered, restored (seed 001 §5.2, L203-206, and §6, L229).
//!
//! ```text
//!  Raised ──▶ securing ──all stations at rest, held, or not heard for long──▶ waiting for an answer to alarm n
//!                │                                                              │ (an answer that stations
//!                └── its rule is automatic, and all stations are at rest ──┐    │  contradict is refused)
//!                                                                          ▼    ▼
//!                      closed ◀── model and plant agree, or cannot tell ── restoring
//!                                                                            │
//!               waiting for an answer to another alarm ◀── they differ: Mismatch
//! ```
//!
//! Every arrow is a [`super::RecordKind::Exception`], so that a crash anywhere goes on where it was: securing is ordered again
//! and changes nothing, an alarm keeps its number, and the marking is restored by one record. Closing puts tokens and part to
//! where they are by the answer: where they were, where they were to go, or nowhere. Nothing else changes a marking: sensors
//! can contradict an answer, which gives another alarm; they never correct the model by themselves.
//!
//! Securing ends what stations do, and takes them back to where their orders began as far as nothing relies on where they stand (`secure`).
//! Where alarm was given of a resource it stops them where they are.
//!
//! A resource can be *down* beside that: by hand, by a rule, or since its station could not come to rest. Its tokens
//! stay where they are, so nothing can get lost by it, and no mode is enabled that needs it; all else that a plan allows
//! is. An operator puts it back, which is refused unless its station can work and its sensor agrees.
//!
//! [`RecoveryPolicy`] is the part of a description about all this, and [`Exceptions`] the state of it.

mod answer;
mod apply;
mod book;
mod compare;
mod current;
mod direction;
mod drive;
mod emergency;
mod fact;
mod isolation;
mod kept;
mod policy;
mod request;
mod secure;
mod standing;
mod watch;

pub use book::{Alarm, ExceptionStage, Exceptions, FailedActivity, OutOfService};
pub use direction::{LeadDirection, LeadReason, StationsToLead};
pub use fact::{
    AlarmSubject, AnsweredBy, ExceptionStep, OutOfServiceReason, RecoveryDecision, SecuredState, SensorMismatch,
    Strategy, Whereabouts,
};
pub use isolation::{Participation, isolated};
pub use kept::SavedExceptions;
pub use policy::{
    AwaitedInput, FailureMatch, ModeHandling, PermittedAnswer, RecoveryPolicy, RecoveryRule, ResourcePolicy, RestTask,
    StationRests,
};
pub use request::{AlarmAnswerRefusal, Presence, ResourceRequest, StationUnavailable};
pub(crate) use standing::{OtherRest, WrongRest};
pub(super) use watch::StationMonitor;
