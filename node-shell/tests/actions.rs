//! Actions between two participants of this machine, in both forms of requests.

use std::time::Duration;

use linewright_msgs::{RunTask, RunTaskFeedback, RunTaskGoal, RunTaskResult};
use linewright_node_shell::{
    ActionCaller, ActionOwner, GoalAsked, GoalEnd, GoalHandle, GoalOutcome, GoalRequest, Mapping, Participant, RosArgs,
    RosNode, serve_action,
};
use tokio::sync::mpsc;

const PATIENT: Duration = Duration::from_secs(10);

/// Domains 101 to 112, away from those of the other tests.
fn node(test: u16, name: &str) -> RosNode {
    let domain_id = 101 + (std::process::id() % 4) as u16 * 3 + test;
    let participant = Participant::open(&RosArgs { domain_id, ..RosArgs::default() }).expect("participant");
    participant.node("/cell", name).expect("node")
}

fn order(id: u64, task: &str) -> RunTaskGoal {
    RunTaskGoal { memory: 9, epoch: 1, id, task: task.to_owned(), limit_ms: 1000, ..RunTaskGoal::default() }
}

/// Repeats the goal until it is accepted: one sent before discovery is lost.
async fn begin(caller: &ActionCaller<RunTask>, goal: &RunTaskGoal) -> GoalHandle {
    for _ in 0..40 {
        if let Ok(id) = caller.begin(goal.clone(), Duration::from_millis(500)).await {
            return id;
        }
    }
    panic!("no answer");
}

fn ended(goal: &RunTaskGoal, end: u8, code: u16) -> RunTaskResult {
    RunTaskResult { epoch: goal.epoch, id: goal.id, end, code, text: goal.task.clone() }
}

/// A station that does `clamp` at once, refuses unknown tasks, and holds until it is cancelled.
async fn station(mut from: mpsc::Receiver<GoalRequest<RunTaskGoal>>, owner: ActionOwner<RunTask>) {
    let mut held = Vec::new();
    while let Some(asked) = from.recv().await {
        match (asked.goal, asked.asked) {
            (id, GoalAsked::New(goal)) => match goal.task.as_str() {
                "clamp" => {
                    let phase = RunTaskFeedback::PHASE_RUNNING;
                    owner.feedback(id, RunTaskFeedback { phase, operation: "close".into(), step: 1, steps: 1 });
                    tokio::time::sleep(Duration::from_millis(300)).await;
                    owner.end(id, GoalEnd::Succeeded, ended(&goal, RunTaskResult::END_DONE, 0));
                }
                "hold" => held.push((id, goal)),
                _ => {
                    let code = RunTaskResult::REFUSED_UNKNOWN;
                    owner.end(id, GoalEnd::Aborted, ended(&goal, RunTaskResult::END_REFUSED, code));
                }
            },
            (id, GoalAsked::Cancel) => {
                held.retain(|(other, goal)| {
                    if *other == id {
                        owner.end(id, GoalEnd::Canceled, ended(goal, RunTaskResult::END_SECURED, 0));
                    }
                    *other != id
                });
            }
        }
    }
}

/// One line has clients of one kind, as a rule: the client library's own takes an answer that was meant for one of the
/// other kind for a failure.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn goals_are_answered_in_the_way_they_came() {
    for (test, mapping) in (0..).zip([Mapping::Enhanced, Mapping::Cyclone]) {
        let mut server = node(test, "m1");
        let (to, from) = mpsc::channel(16);
        let action = server.action::<RunTask>("~/run_task").expect("action");
        let (owner, _task) = serve_action(action, to, |asked| asked);
        tokio::spawn(station(from, owner));
        let mut client = node(test, "coordinator");
        let caller = client.action_caller::<RunTask>("/cell/m1/run_task", mapping).expect("caller");
        goals_are_answered(&caller, mapping).await;
    }
}

async fn goals_are_answered(caller: &ActionCaller<RunTask>, mapping: Mapping) {
    let clamp = order(1, "clamp");
    let goal = begin(caller, &clamp).await;
    let (outcome, result) = caller.result(goal, PATIENT).await.expect("a result");
    assert_eq!((outcome, &result), (GoalOutcome::Succeeded, &ended(&clamp, RunTaskResult::END_DONE, 0)), "{mapping:?}");
    assert_eq!(caller.feedback(goal).map(|feedback| feedback.operation), Some("close".to_owned()), "{mapping:?}");
    let (again, _) = caller.result(goal, PATIENT).await.expect("still known");
    assert_eq!(again, GoalOutcome::Succeeded);
    assert!(!caller.cancel(goal, PATIENT).await.expect("answered"), "it has ended");

    let goal = begin(caller, &order(2, "dance")).await;
    let (outcome, result) = caller.result(goal, PATIENT).await.expect("a result");
    assert_eq!((outcome, result.code), (GoalOutcome::Aborted, RunTaskResult::REFUSED_UNKNOWN), "{mapping:?}");

    let hold = order(3, "hold");
    let goal = begin(caller, &hold).await;
    let early = caller.result(goal, Duration::from_millis(300)).await;
    assert!(early.is_err(), "it has not ended: {early:?}");
    let (result, cancelled) = tokio::join!(caller.result(goal, PATIENT), caller.cancel(goal, PATIENT));
    assert!(cancelled.expect("answered"), "{mapping:?}");
    let (outcome, result) = result.expect("a result");
    assert_eq!((outcome, result), (GoalOutcome::Canceled, ended(&hold, RunTaskResult::END_SECURED, 0)), "{mapping:?}");
}
