//! `linewright recover --publish`: the plan for consoles, as a latched topic and a service.
//!
//! A process of its own. A search takes processor time and memory, so it stands in no node that moves anything; what becomes of it
//! changes nothing at the line, and it orders nothing. Requests are answered with the newest plan, which is made at most once in
//! [`LOOK_EVERY`]: a flood of them makes no more of it.

use std::process::ExitCode;
use std::time::Duration;

use linewright_msgs::{Text, Trigger, TriggerResponse};
use linewright_node_shell::{ServiceReply, TopicError, qos, serve};
use miette::miette;
use tokio::sync::mpsc;

use super::newest::{NewestPlan, ReasonedPlan};
use super::{LOOK_EVERY, RecoveryJson, next_of};
use crate::cell::CellClient;
use crate::client::{OperatorClient, StateUpdate};
use crate::interrupts::Interrupts;

/// Period at which a plan that stays the same is sent again: a reader sees by it that the plan is of now.
const AGAIN_EVERY: Duration = Duration::from_secs(1);
/// Requests that wait; of more the middleware keeps some.
const REQUESTS: usize = 16;

/// A plan as it is published.
struct PublishedPlan {
    text: String,
    /// It leads to auto, and everything is heard.
    leads_to_auto: bool,
}

impl PublishedPlan {
    fn of(client: &OperatorClient, path: &str, found: Option<&ReasonedPlan>) -> miette::Result<Self> {
        let leads_there = found.is_some_and(|found| found.plan.leads_to_auto());
        let text = serde_json::to_string(&RecoveryJson::of(client, path, found));
        Ok(PublishedPlan {
            text: text.map_err(|error| miette!("the plan as JSON: {error}"))?,
            leads_to_auto: leads_there && client.unheard().next().is_none(),
        })
    }
}

/// Publishes until an interrupt.
pub async fn run(
    client: &mut OperatorClient,
    mut cell: Option<CellClient>,
    mut newest: NewestPlan,
    path: &str,
) -> miette::Result<ExitCode> {
    let failed = |error: TopicError| miette!("{error}");
    let plans = client.node().publisher::<Text>("recovery_plan", qos::latched_state()).map_err(failed)?;
    let service = client.node().service::<Trigger>("recovery").map_err(failed)?;
    let (to, mut requests) = mpsc::channel::<ServiceReply<Trigger>>(REQUESTS);
    let _serving = serve(service, to, |_, reply| reply);
    let mut interrupts = Interrupts::listen()?;
    let mut looks = tokio::time::interval(LOOK_EVERY);
    let mut again = tokio::time::interval(AGAIN_EVERY);
    newest.settle(client, &mut cell).await?;
    let mut plan = PublishedPlan::of(client, path, newest.look(client, cell.as_ref()))?;
    crate::out::say!("publishes {}", plans.topic());
    loop {
        tokio::select! {
            heard = client.next() => drop::<StateUpdate>(heard?),
            heard = next_of(&mut cell) => heard?,
            // What is no longer heard changes a plan as well, and no message tells of that.
            _ = looks.tick() => {
                let found = newest.look(client, cell.as_ref()).cloned();
                if newest.searching().is_some() {
                    continue;
                }
                let before = std::mem::replace(&mut plan, PublishedPlan::of(client, path, found.as_ref())?);
                if before.text != plan.text {
                    plans.send(Text { data: plan.text.clone() });
                }
            }
            _ = again.tick() => plans.send(Text { data: plan.text.clone() }),
            request = requests.recv() => {
                let reply = request.ok_or_else(|| miette!("the middleware has failed"))?;
                reply.send(TriggerResponse { success: plan.leads_to_auto, message: plan.text.clone() });
            }
            () = interrupts.next() => return Ok(ExitCode::SUCCESS),
        }
    }
}
