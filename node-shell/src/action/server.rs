//! Action server.
//!
//! One task owns both servers and the goals; the owner of the action receives goals and cancellations through a
//! channel, and reports progress and ends through another. Nothing here waits for others, and nothing grows without
//! bound: goals, waiting clients and held answers are all counted.

use std::collections::VecDeque;
use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll};

use linewright_msgs::RosAction;
use ros2_client::action::{ActionServer, GetResultResponse, SendGoalResponse};
use ros2_client::action_msgs::{CancelGoalRequest, CancelGoalResponse, GoalId, GoalInfo, GoalStatusEnum};
use ros2_client::builtin_interfaces::Time;
use ros2_client::{ReadError, RmwRequestId};
use tokio::sync::mpsc;
use tokio::time::Instant;

use super::goals::{GoalEnd, Goals};
use crate::bytes::{Bytes, exactly};
use crate::caller::WireMessage;
use crate::service::{HOLD, KnownClients};
use crate::subscription::{Forward, participant_of};

/// Most bytes of a goal that are looked at.
const GOAL_MAX: usize = 16 * 1024;
/// Answers that are held at once. A flood of new clients loses the oldest.
const HELD_MAX: usize = 64;

pub(crate) type RawActionServer<A> =
    ActionServer<Bytes<GOAL_MAX>, WireMessage<<A as RosAction>::Result>, WireMessage<<A as RosAction>::Feedback>>;

/// An action that is offered. Hand it to [`serve_action`].
pub struct ActionOffer<A: RosAction> {
    /// One for each form of request. The first sends feedback and status.
    pub(crate) servers: [RawActionServer<A>; 2],
    pub(crate) name: String,
}

/// Id of a goal, until it has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct GoalHandle(pub(crate) GoalId);

impl GoalHandle {
    /// The 16 bytes that its client has given it, as a number.
    pub fn key(self) -> u128 {
        self.0.uuid.as_u128()
    }
}

/// Request to the owner of an action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GoalRequest<G> {
    /// The participant that it came from, as in [`MessageSource::participant`](crate::MessageSource::participant).
    pub from: [u8; 12],
    /// The goal that it is about.
    pub goal: GoalHandle,
    pub asked: GoalAsked<G>,
}

/// What is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum GoalAsked<G> {
    /// A new goal. It is accepted already; one that is refused is [ended](ActionOwner::end) at once.
    New(G),
    /// Cancellation. The goal goes on until it is ended, with whatever end.
    Cancel,
}

/// Report of the owner.
enum GoalUpdate<A: RosAction> {
    Feedback(GoalHandle, A::Feedback),
    End(GoalHandle, GoalEnd, A::Result),
    /// It goes on although its cancellation was asked for.
    GoesOn(GoalHandle),
}

/// The owner's side of an action that is served.
pub struct ActionOwner<A: RosAction>(mpsc::UnboundedSender<GoalUpdate<A>>);

impl<A: RosAction> ActionOwner<A> {
    /// Publishes the progress of a goal. Never waits.
    pub fn feedback(&self, goal: GoalHandle, feedback: A::Feedback) {
        // The server has ended: the process is ending.
        let _ = self.0.send(GoalUpdate::Feedback(goal, feedback));
    }

    /// A cancellation that is not followed: the goal is executing again, and a later cancellation is passed on. Never waits.
    pub fn goes_on(&self, goal: GoalHandle) {
        let _ = self.0.send(GoalUpdate::GoesOn(goal));
    }

    /// Ends a goal, and answers the clients that wait for its result. Never waits. Only the first end of a goal counts.
    pub fn end(&self, goal: GoalHandle, ended: GoalEnd, result: A::Result) {
        let _ = self.0.send(GoalUpdate::End(goal, ended, result));
    }
}

/// Client of a request, after the server (of the two) that it used.
type GoalClient = (usize, RmwRequestId);

/// An answer, ready to be sent.
enum EncodedReply<A: RosAction> {
    Goal(SendGoalResponse),
    Cancel(CancelGoalResponse),
    Result(GoalStatusEnum, A::Result),
}

/// Request to one of the services.
enum ActionRequest {
    Goal(GoalId, Vec<u8>),
    Cancel(CancelGoalRequest),
    Result(GoalId),
}

/// Merges an action's requests into `to`, as [`serve`](crate::serve) does with services. Must be called inside a tokio
/// runtime.
pub fn serve_action<A, U>(
    action: ActionOffer<A>,
    to: mpsc::Sender<U>,
    mut map: impl FnMut(GoalRequest<A::Goal>) -> U + Send + 'static,
) -> (ActionOwner<A>, Forward)
where
    A: RosAction,
    U: Send + 'static,
{
    // Not bounded, but filled by the owner alone, with a few reports for each goal.
    let (owner, mut said) = mpsc::unbounded_channel();
    let mut serving = Serving {
        action,
        goals: Goals::new(),
        known: KnownClients::new(),
        held: VecDeque::new(),
        rejected: 0,
        turn: 0,
    };
    let forward = Forward::spawn(async move {
        serving.publish_status();
        loop {
            let due = serving.held.front().map(|(at, ..)| *at);
            let news = tokio::select! {
                received = std::future::poll_fn(|context| serving.poll(context)) => match received {
                    Ok((who, request)) => serving.take(who, request),
                    Err(error) => {
                        tracing::error!("{}: the middleware failed: {error}", serving.action.name);
                        return;
                    }
                },
                Some(said) = said.recv() => {
                    serving.hear(said);
                    continue;
                }
                () = tokio::time::sleep_until(due.unwrap_or_else(Instant::now)), if due.is_some() => {
                    serving.release(Instant::now());
                    continue;
                }
                () = to.closed() => return,
            };
            for asked in news {
                if to.send(map(asked)).await.is_err() {
                    return;
                }
            }
            // As with messages: a flood of rubbish must not keep the other tasks waiting.
            tokio::task::yield_now().await;
        }
    });
    (ActionOwner(owner), forward)
}

/// The task's belongings.
struct Serving<A: RosAction> {
    action: ActionOffer<A>,
    goals: Goals<A::Result, GoalClient>,
    known: KnownClients,
    /// First answers to a client, held until it can be expected to receive them.
    held: VecDeque<(Instant, GoalClient, EncodedReply<A>)>,
    /// Requests that the server that got them could not decode.
    rejected: u64,
    /// The service polled last.
    turn: usize,
}

impl<A: RosAction> Serving<A> {
    /// The next request of any service of any server, or a failure of the middleware. They are looked at in turn, so
    /// that a flood of one kind does not keep the others waiting. Between two calls nothing is lost: a request stays
    /// with the middleware until it is taken, and every poll registers the waker.
    fn poll(&mut self, context: &mut Context<'_>) -> Poll<Result<(GoalClient, ActionRequest), ReadError>> {
        for _ in 0..SERVICES * self.action.servers.len() {
            self.turn = (self.turn + 1) % (SERVICES * self.action.servers.len());
            let (which, service) = (self.turn / SERVICES, self.turn % SERVICES);
            match poll_one::<A>(&mut self.action.servers[which], service, context) {
                Poll::Ready(Ok((id, request))) => return Poll::Ready(Ok(((which, id), request))),
                Poll::Ready(Err(ReadError::Deserialization { .. } | ReadError::Malformed)) => {
                    self.reject();
                    // There may be more, but others have waited.
                    context.waker().wake_by_ref();
                    return Poll::Pending;
                }
                Poll::Ready(Err(error)) => return Poll::Ready(Err(error)),
                Poll::Pending => {}
            }
        }
        Poll::Pending
    }

    /// Takes a request; gives the resulting requests to the owner.
    fn take(&mut self, who: GoalClient, request: ActionRequest) -> Vec<GoalRequest<A::Goal>> {
        let from = participant_of(&who.1.writer_gid.to_bytes16());
        match request {
            ActionRequest::Goal(id, bytes) => {
                let Some(goal) = exactly::<A::Goal>(&bytes) else {
                    // Most likely it is meant for the other server.
                    self.reject();
                    return Vec::new();
                };
                let stamp = Time::now();
                let accepted = self.goals.begin(id, stamp);
                self.answer(who, EncodedReply::Goal(SendGoalResponse { accepted, stamp }));
                if !accepted {
                    return Vec::new();
                }
                self.publish_status();
                vec![GoalRequest { from, goal: GoalHandle(id), asked: GoalAsked::New(goal) }]
            }
            ActionRequest::Cancel(request) => {
                let Some((response, new)) = goal_info(&request).and_then(|info| self.goals.cancel(&info)) else {
                    self.reject();
                    return Vec::new();
                };
                self.answer(who, EncodedReply::Cancel(response));
                if !new.is_empty() {
                    self.publish_status();
                }
                let cancelled = |id| GoalRequest { from, goal: GoalHandle(id), asked: GoalAsked::Cancel };
                new.into_iter().map(cancelled).collect()
            }
            ActionRequest::Result(id) => {
                if let Some((status, result, who)) = self.goals.ask(id, who) {
                    self.answer(who, EncodedReply::Result(status, result));
                }
                Vec::new()
            }
        }
    }

    fn hear(&mut self, said: GoalUpdate<A>) {
        match said {
            GoalUpdate::Feedback(GoalHandle(goal_id), feedback) => {
                let sent = self.action.servers[0].send_feedback(goal_id, WireMessage(feedback));
                if let Err(error) = sent {
                    tracing::debug!("{}: feedback not sent: {error}", self.action.name);
                }
            }
            GoalUpdate::GoesOn(GoalHandle(goal_id)) => {
                if self.goals.goes_on(goal_id) {
                    self.publish_status();
                }
            }
            GoalUpdate::End(GoalHandle(goal_id), ended, result) => {
                if let Some((status, waiting)) = self.goals.end(goal_id, ended, result.clone()) {
                    self.publish_status();
                    for who in waiting {
                        self.answer(who, EncodedReply::Result(status, result.clone()));
                    }
                }
            }
        }
    }

    /// A first answer is held, as with services; those that follow it to the same client are not sent before it.
    fn answer(&mut self, who: GoalClient, answer: EncodedReply<A>) {
        let client = who.1.writer_gid;
        if !self.known.meets(client) && !self.held.iter().any(|(_, (_, id), _)| id.writer_gid == client) {
            self.send(who, answer);
            return;
        }
        if self.held.len() >= HELD_MAX {
            self.held.pop_front();
        }
        self.held.push_back((Instant::now() + HOLD, who, answer));
    }

    fn release(&mut self, now: Instant) {
        while self.held.front().is_some_and(|(at, ..)| *at <= now) {
            if let Some((_, who, answer)) = self.held.pop_front() {
                self.send(who, answer);
            }
        }
    }

    fn send(&self, (which, id): GoalClient, answer: EncodedReply<A>) {
        let server = &self.action.servers[which];
        let sent = match answer {
            EncodedReply::Goal(response) => server.send_goal_response(id, response),
            EncodedReply::Cancel(response) => server.send_cancel_response(id, response),
            EncodedReply::Result(status, result) => {
                server.send_result(id, GetResultResponse { status, result: WireMessage(result) })
            }
        };
        if let Err(error) = sent {
            tracing::warn!("{}: answer not sent: {error}", self.action.name);
        }
    }

    fn publish_status(&self) {
        if let Err(error) = self.action.servers[0].send_goal_statuses(self.goals.statuses()) {
            tracing::debug!("{}: status not sent: {error}", self.action.name);
        }
    }

    fn reject(&mut self) {
        self.rejected += 1;
        if self.rejected.is_power_of_two() {
            tracing::debug!(action = self.action.name, self.rejected, "ignored a request that does not decode");
        }
    }
}

/// Services of a server: goals, cancellations, results.
const SERVICES: usize = 3;

/// Looks at one service of a server. A future that is dropped while it waits leaves its waker with the reader, so that
/// looking at the next one does not lose the wake-up of this one.
fn poll_one<A: RosAction>(
    server: &mut RawActionServer<A>,
    service: usize,
    context: &mut Context<'_>,
) -> Poll<Result<(RmwRequestId, ActionRequest), ReadError>> {
    match service {
        0 => pin!(server.goal_server().async_receive_request())
            .poll(context)
            .map(|received| received.map(|(id, request)| (id, ActionRequest::Goal(request.goal_id, request.goal.0)))),
        1 => pin!(server.cancel_server().async_receive_request())
            .poll(context)
            .map(|received| received.map(|(id, request)| (id, ActionRequest::Cancel(request)))),
        _ => pin!(server.result_server().async_receive_request())
            .poll(context)
            .map(|received| received.map(|(id, request)| (id, ActionRequest::Result(request.goal_id)))),
    }
}

/// The goal to cancel. The library has the field and does not show it; its bytes do.
fn goal_info(request: &CancelGoalRequest) -> Option<GoalInfo> {
    let bytes = cdr_encoding::to_vec::<_, byteorder::LittleEndian>(request).ok()?;
    cdr_encoding::from_bytes::<GoalInfo, byteorder::LittleEndian>(&bytes).ok().map(|(info, _)| info)
}

#[cfg(test)]
mod tests {
    use super::*;
    use linewright_msgs::RunTaskGoal;

    fn goal() -> RunTaskGoal {
        let names = vec!["slot".to_owned()];
        RunTaskGoal {
            epoch: 1,
            id: 2,
            task: "clamp".into(),
            parameter_names: names,
            parameters: vec![3],
            ..Default::default()
        }
    }

    #[test]
    fn a_goal_is_read_whole_or_not_at_all() {
        let bytes = cdr_encoding::to_vec::<_, byteorder::LittleEndian>(&goal()).expect("encodes");
        assert_eq!(exactly(&bytes), Some(goal()));
        for padding in 1..=3 {
            assert_eq!(exactly(&[&bytes[..], &vec![0; padding]].concat()), Some(goal()));
        }
        assert_eq!(exactly::<RunTaskGoal>(&[&bytes[..], &[0; 4]].concat()), None);
        assert_eq!(exactly::<RunTaskGoal>(&bytes[..bytes.len() - 1]), None);
        // View of the server for the other form: the goal's id is taken for a header, or the other way round.
        for id in [GoalId::new_random(), GoalId::new_random()] {
            let id = cdr_encoding::to_vec::<_, byteorder::LittleEndian>(&id).expect("encodes");
            assert_eq!(exactly::<RunTaskGoal>(&[&id[..], &bytes].concat()), None);
        }
        assert_eq!(exactly::<RunTaskGoal>(&bytes[16..]), None);
        let nobody = RunTaskGoal { id: 0, ..goal() };
        let bytes = cdr_encoding::to_vec::<_, byteorder::LittleEndian>(&nobody).expect("encodes");
        assert_eq!(exactly::<RunTaskGoal>(&bytes), None, "it decodes, and is not valid");
    }

    proptest::proptest! {
        #[test]
        fn noise_is_no_goal_and_no_panic(bytes in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..400)) {
            let _ = exactly::<RunTaskGoal>(&bytes);
        }
    }

    #[test]
    fn what_is_to_be_cancelled_is_found_in_the_bytes() {
        let (id, stamp) = (GoalId::new_random(), Time::new(7, 8));
        let info = GoalInfo { goal_id: id, stamp };
        let bytes = cdr_encoding::to_vec::<_, byteorder::LittleEndian>(&info).expect("encodes");
        assert_eq!(bytes.len(), 24);
        let (request, _) =
            cdr_encoding::from_bytes::<CancelGoalRequest, byteorder::LittleEndian>(&bytes).expect("decodes");
        let read = goal_info(&request).expect("it is there");
        assert_eq!((read.goal_id, read.stamp.to_nanos()), (id, stamp.to_nanos()));
    }
}
