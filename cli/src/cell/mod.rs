//! A person's view of a running cell over ROS 2: its newest state, and what can be asked of its coordinator.
//!
//! Shared by the subcommands about cells: `order`, `why` and `run`. Like [`crate::client`] it uses what anybody can use with
//! the stock tools.

mod operate;

use std::time::Duration;

use linewright_line::Line;
use linewright_msgs::{
    AnswerAlarm, AnswerAlarmRequest, Bounded, CellState, ChangeOrder, ChangeOrderRequest, ProductionRequest,
    ProductionState, RosService, SubmitOrders, SubmitOrdersRequest, WhyNot, WhyNotRequest,
};
use linewright_node_shell::{
    CallError, Caller, Forward, Mapping, NewestBySequence, Node, Participant, RosArgs, TopicError, forward,
    fresh_boot_id, qos,
};
use miette::miette;
use tokio::sync::mpsc;

pub use operate::{AnswerArgs, OrderArgs, WhyArgs, answer, order, why};

/// A request that is sent before the other side is discovered gets no answer: so it is asked again, this long each time.
const ANSWER: Duration = Duration::from_millis(700);
/// How often.
const TRIES: u32 = 10;

/// A person's connection to a cell.
pub struct CellClient {
    name: String,
    from: mpsc::Receiver<CellState>,
    newest: NewestBySequence,
    state: Option<CellState>,
    submit: Caller<SubmitOrders>,
    cancel: Caller<ChangeOrder>,
    withdraw: Caller<ChangeOrder>,
    why: Caller<WhyNot>,
    answer: Caller<AnswerAlarm>,
    domain_id: u16,
    _task: Forward,
    // The node must outlive what it has opened.
    _node: Node,
}

impl CellClient {
    /// Joins the ROS graph as `name`.
    pub fn open(line: &Line, ros: &RosArgs, name: &str) -> miette::Result<Self> {
        let failed = |error: TopicError| miette!("{error}");
        let participant = Participant::open(ros).map_err(|error| miette!("{error}"))?;
        let name = format!("{name}_{}", std::process::id());
        let mut node = participant.node(&format!("/{}", line.name), &name).map_err(|error| miette!("{error}"))?;
        let (to, from) = mpsc::channel(64);
        let state = node.subscription("coordinator/cell_state", qos::latched_state()).map_err(failed)?;
        Ok(CellClient {
            name: line.name.clone(),
            from,
            newest: NewestBySequence::new(),
            state: None,
            submit: caller(&mut node, "submit_order")?,
            cancel: caller(&mut node, "cancel_order")?,
            withdraw: caller(&mut node, "withdraw_order")?,
            why: caller(&mut node, "why_not")?,
            answer: caller(&mut node, "answer_alarm")?,
            domain_id: participant.domain_id(),
            _task: forward(state, to, |message, _| Some(message)),
            _node: node,
        })
    }

    /// The newest state, if one was heard.
    pub fn state(&self) -> Option<&CellState> {
        self.state.as_ref()
    }

    /// Waits for a newer state. Cancel safe.
    pub async fn next(&mut self) -> miette::Result<&CellState> {
        loop {
            let state = self.from.recv().await.ok_or_else(|| miette!("the middleware has failed"))?;
            if self.newest.offer(state.boot_id, state.sequence).is_newest() {
                return Ok(self.state.insert(state));
            }
        }
    }

    /// Waits until the cell is heard.
    pub async fn until_heard(&mut self, within: Duration) -> miette::Result<&CellState> {
        let (name, domain) = (self.name.clone(), self.domain_id);
        match tokio::time::timeout(within, self.next()).await {
            Ok(state) => state,
            Err(_) => Err(miette!(
                "no coordinator of cell '{name}' is heard on ROS domain {domain} (is it running, and on the same ROS_DOMAIN_ID?)"
            )),
        }
    }

    /// Puts on order. The keys make sure that asking again is not asking for more.
    ///
    /// # Errors
    /// All that is wrong with the requests, or that nobody answers.
    pub async fn submit(&self, requests: Vec<ProductionRequest>) -> miette::Result<Vec<u64>> {
        let response = ask(&self.submit, &SubmitOrdersRequest { requests }).await?;
        if response.accepted { Ok(response.ids) } else { Err(miette!("{}", response.problems.join("\n"))) }
    }

    /// Nothing more of an order enters.
    pub async fn cancel(&self, name: &str) -> miette::Result<()> {
        change(&self.cancel, name).await
    }

    /// An order of which nothing has entered is as if it had never been.
    pub async fn withdraw(&self, name: &str) -> miette::Result<()> {
        change(&self.withdraw, name).await
    }

    /// Why a part or an order does not go on.
    pub async fn why(&self, about: &str) -> miette::Result<Vec<String>> {
        let response = ask(&self.why, &WhyNotRequest { about: about.to_owned() }).await?;
        if response.known { Ok(response.lines) } else { Err(miette!("{}", response.lines.join("\n"))) }
    }
}

impl CellClient {
    /// Says what is true, now that what an alarm asked for was done.
    pub async fn answer(&self, alarm: u64, word: &str) -> miette::Result<()> {
        let by = std::env::var("USER").unwrap_or_default();
        let response = ask(&self.answer, &AnswerAlarmRequest { alarm, word: word.to_owned(), by }).await?;
        if response.accepted { Ok(()) } else { Err(miette!("{}", response.reason)) }
    }
}

fn caller<S: RosService>(node: &mut Node, service: &str) -> miette::Result<Caller<S>> {
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
    // Asked twice, the answer to the first may be lost: then the second says that it is over already, which is no mistake.
    let response = ask(caller, &ChangeOrderRequest { name: name.to_owned() }).await?;
    if response.done { Ok(()) } else { Err(miette!("{}", response.reason)) }
}

/// A request with a key of its own.
pub fn request(name: &str, product: &str, quantity: u32) -> ProductionRequest {
    let key = [fresh_boot_id().to_be_bytes(), fresh_boot_id().to_be_bytes()].concat();
    ProductionRequest {
        key: Bounded::new(key).unwrap_or_default(),
        name: name.to_owned(),
        product: product.to_owned(),
        quantity,
        ..ProductionRequest::default()
    }
}

/// Whether nothing more comes of an order.
pub fn is_over(order: &ProductionState) -> bool {
    order.ended.sec != 0 || order.ended.nanosec != 0
}
