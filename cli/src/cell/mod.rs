//! An operator's view of a running cell over ROS 2: its newest state, and the requests to its coordinator.
//!
//! Shared by the subcommands about cells: `order`, `why`, `answer`, `resource` and `run`. Like [`crate::client`] it
//! uses only what the stock tools can use.

mod operate;
mod requests;
mod why;

use std::sync::Arc;
use std::time::Duration;

use linewright_console_view::{Aged, CELL_FRESH, ReasonsByResource};
use linewright_fieldbus::Clock;
use linewright_line::{Line, Tick};
use linewright_msgs::{
    AnswerAlarm, AnswerAlarmRequest, Bounded, CellState, ChangeOrder, ChangeOrderRequest, ProductionRequest,
    RosService, SetResource, SetResourceRequest, SubmitOrders, SubmitOrdersRequest, WhyNot, WhyNotRequest,
};
use linewright_node_shell::{CallError, Caller, Forward, Mapping, RosArgs, RosNode, forward, fresh_key, qos};
use linewright_station_shell::NewestBySequence;
use miette::miette;
use tokio::sync::mpsc;

use crate::client::{join, not_heard};

pub use operate::{AnswerArgs, CellJson, OrderArgs, ResourceArgs, answer, order, resource};
pub use requests::{CellReply, REPLY_WITHIN};
pub use why::{WhyArgs, why};

/// Time for an answer. A request sent before the other side is discovered gets none, so it is repeated.
const ANSWER: Duration = Duration::from_millis(700);
/// Attempts before a service counts as missing.
const TRIES: u32 = 10;

/// Time for a newer state after the first: while something changes it is published ten times a second.
const SETTLE: Duration = Duration::from_millis(250);

/// A person's connection to a cell.
pub struct CellClient {
    name: String,
    from: mpsc::Receiver<CellState>,
    clock: Clock,
    newest: NewestBySequence,
    /// With its time of arrival.
    state: Option<(CellState, Tick)>,
    callers: Arc<CellCallers>,
    domain_id: u16,
    _task: Forward,
    // The node must outlive what it has opened.
    node: RosNode,
}

/// The services of a cell's coordinator.
struct CellCallers {
    submit: Caller<SubmitOrders>,
    cancel: Caller<ChangeOrder>,
    withdraw: Caller<ChangeOrder>,
    why: Caller<WhyNot>,
    answer: Caller<AnswerAlarm>,
    resource: Caller<SetResource>,
}

impl CellCallers {
    fn open(node: &mut RosNode) -> miette::Result<Self> {
        Ok(CellCallers {
            submit: caller(node, "submit_order")?,
            cancel: caller(node, "cancel_order")?,
            withdraw: caller(node, "withdraw_order")?,
            why: caller(node, "why_not")?,
            answer: caller(node, "answer_alarm")?,
            resource: caller(node, "set_resource")?,
        })
    }

    /// Answers an alarm. `by`: the user, for the coordinator's log.
    async fn answer(&self, alarm: u64, word: &str, by: String) -> miette::Result<()> {
        let asked = AnswerAlarmRequest { alarm, word: word.to_owned(), by };
        let response = ask(&self.answer, &asked).await?;
        done(response.accepted, &response.reason)
    }

    /// Changes the state of a resource: one of the constants of [`SetResourceRequest`].
    async fn resource(&self, resource: &str, what: u8, text: &str, by: String) -> miette::Result<()> {
        let asked = SetResourceRequest { resource: resource.to_owned(), what, text: text.to_owned(), by };
        let response = ask(&self.resource, &asked).await?;
        done(response.accepted, &response.reason)
    }
}

impl CellClient {
    /// Joins the ROS graph as `name`.
    pub fn open(line: &Line, ros: &RosArgs, name: &str) -> miette::Result<Self> {
        let (mut node, domain_id) = join(line, ros, name)?;
        let (to, from) = mpsc::channel(64);
        let state = node.subscription("coordinator/cell_state", qos::latched_state());
        let state = state.map_err(|error| miette!("{error}"))?;
        Ok(CellClient {
            name: line.name.clone(),
            from,
            clock: Clock::start(),
            newest: NewestBySequence::new(CELL_FRESH),
            state: None,
            callers: Arc::new(CellCallers::open(&mut node)?),
            domain_id,
            _task: forward(state, to, |message, _| Some(message)),
            node,
        })
    }

    /// The newest state, if one was received.
    pub fn state(&self) -> Option<&CellState> {
        self.state.as_ref().map(|(state, _)| state)
    }

    /// The newest state with its age.
    pub fn aged(&self) -> Option<Aged<'_, CellState>> {
        self.state.as_ref().map(|(state, at)| Aged { state, age: self.clock.now().since(*at) })
    }

    /// The newest state, unless the coordinator is silent.
    pub fn heard_lately(&self) -> Option<&CellState> {
        self.aged()?.fresh(CELL_FRESH)
    }

    /// Waits for a newer state. Cancel safe.
    pub async fn next(&mut self) -> miette::Result<&CellState> {
        loop {
            let state = self.from.recv().await.ok_or_else(|| miette!("the middleware has failed"))?;
            let now = self.clock.now();
            if self.newest.offer(now, state.boot_id, state.sequence) {
                return Ok(&self.state.insert((state, now)).0);
            }
        }
    }

    /// Waits for the cell's present state: the first one that a late reader receives may be older.
    pub async fn until_heard(&mut self, within: Duration) -> miette::Result<&CellState> {
        match tokio::time::timeout(within, self.next()).await {
            Ok(state) => _ = state?,
            Err(_) => return Err(self.not_found()),
        }
        let until = tokio::time::Instant::now() + SETTLE;
        while let Ok(state) = tokio::time::timeout_at(until, self.next()).await {
            state?;
        }
        self.state().ok_or_else(|| self.not_found())
    }

    fn not_found(&self) -> miette::Report {
        not_heard(&format!("cell '{}'", self.name), self.domain_id)
    }

    /// Submits production orders. Because of their keys, repeating the request orders nothing twice.
    ///
    /// # Errors
    /// All faults of the requests, or no answer.
    pub async fn submit(&self, requests: Vec<ProductionRequest>) -> miette::Result<Vec<u64>> {
        let response = ask(&self.callers.submit, &SubmitOrdersRequest { requests }).await?;
        if response.accepted { Ok(response.ids) } else { Err(miette!("{}", response.problems.join("\n"))) }
    }

    /// Nothing more of an order enters.
    pub async fn cancel(&self, name: &str) -> miette::Result<()> {
        change(&self.callers.cancel, name).await
    }

    /// An order of which nothing has entered is as if it had never been.
    pub async fn withdraw(&self, name: &str) -> miette::Result<()> {
        change(&self.callers.withdraw, name).await
    }

    /// Why resources are left out; without those of which the coordinator does not answer.
    pub fn reasons(&self, resources: Vec<String>) -> impl Future<Output = ReasonsByResource> + use<> {
        let callers = self.callers.clone();
        async move {
            let mut known = ReasonsByResource::new();
            for about in resources {
                if let Ok(response) = ask(&callers.why, &WhyNotRequest { about: about.clone() }).await {
                    known.insert(about, response.lines);
                }
            }
            known
        }
    }

    /// Why a part or an order does not go on.
    pub async fn why(&self, about: &str) -> miette::Result<Vec<String>> {
        let response = ask(&self.callers.why, &WhyNotRequest { about: about.to_owned() }).await?;
        if response.known { Ok(response.lines) } else { Err(miette!("{}", response.lines.join("\n"))) }
    }

    /// Answers an alarm, after its instruction was carried out.
    pub async fn answer(&self, alarm: u64, word: &str) -> miette::Result<()> {
        self.callers.answer(alarm, word, who()).await
    }

    /// Changes the state of a resource: one of the constants of [`SetResourceRequest`].
    pub async fn resource(&self, resource: &str, what: u8, text: &str) -> miette::Result<()> {
        self.callers.resource(resource, what, text, who()).await
    }
}

/// The user, for the coordinator's log.
fn who() -> String {
    std::env::var("USER").unwrap_or_default()
}

fn caller<S: RosService>(node: &mut RosNode, service: &str) -> miette::Result<Caller<S>> {
    let name = format!("coordinator/{service}");
    node.caller(&name, Mapping::Enhanced).map_err(|error| miette!("{error}"))
}

async fn ask<S: RosService>(caller: &Caller<S>, request: &S::Request) -> miette::Result<S::Response> {
    let mut last = None;
    for _ in 0..TRIES {
        match caller.call(request.clone(), ANSWER).await {
            Ok(response) => return Ok(response),
            Err(error @ CallError::NoAnswer { .. }) => last = Some(error),
            Err(error @ (CallError::Invalid { .. } | CallError::Middleware { .. })) => return Err(miette!("{error}")),
        }
    }
    Err(miette!("{}", last.map(|error| error.to_string()).unwrap_or_default()))
}

async fn change(caller: &Caller<ChangeOrder>, name: &str) -> miette::Result<()> {
    // If the answer to the first is lost, that to the second is that the order is over already.
    let response = ask(caller, &ChangeOrderRequest { name: name.to_owned() }).await?;
    done(response.done, &response.reason)
}

/// Result of a request, or the reason against it.
fn done(is_done: bool, reason: &str) -> miette::Result<()> {
    if is_done { Ok(()) } else { Err(miette!("{reason}")) }
}

/// A request with a key of its own.
pub fn request(name: &str, product: &str, quantity: u32) -> ProductionRequest {
    ProductionRequest {
        key: Bounded::new(fresh_key().to_be_bytes().to_vec()).unwrap_or_default(),
        name: name.to_owned(),
        product: product.to_owned(),
        quantity,
        ..ProductionRequest::default()
    }
}
