//! Requests of people to a cell, and what the token player is told.

use linewright_coordinator_cell::exception::ResourceRequest;
use linewright_coordinator_cell::production::ProductionOrderRequest;
use linewright_coordinator_cell::{
    AlarmId, OrderKey, PlayerInput, ProductionCommand, RequestId, TaskReply as Answered, TaskReport,
};
use linewright_line::StationId;
use linewright_msgs::{
    AnswerAlarmResponse, ChangeOrderResponse, SetResourceRequest, SetResourceResponse, SubmitOrders,
};
use linewright_node_line::quoted;
use linewright_node_shell::{GoalAsked, ServiceReply, fresh_key};
use linewright_orders::LeaveWay;

use super::pending_replies::{AnsweringOperator, Requester, denied_all};
use super::play::CellLoop;
use super::topics::CellInbound;
use super::wire;
use super::words::by_whom;

/// Something for the token player.
pub(super) enum PlayerMessage {
    State(StationId, TaskReport),
    Reply(StationId, OrderKey, Answered),
    Secured(StationId, OrderKey, LeaveWay, Answered),
    Submit(RequestId, Vec<ProductionOrderRequest>),
    Cancel(RequestId, String),
    Withdraw(RequestId, String),
    Say(ResourceRequest, String),
}

impl PlayerMessage {
    pub fn input(&self) -> PlayerInput<'_> {
        match self {
            PlayerMessage::State(station, heard) => PlayerInput::Station(*station, heard),
            PlayerMessage::Reply(station, key, reply) => PlayerInput::Reply(*station, *key, *reply),
            PlayerMessage::Secured(station, key, way, reply) => PlayerInput::Secured(*station, *key, *way, *reply),
            PlayerMessage::Submit(ticket, requests) => {
                PlayerInput::Production(*ticket, ProductionCommand::Submit(requests))
            }
            PlayerMessage::Cancel(ticket, name) => PlayerInput::Production(*ticket, ProductionCommand::Cancel(name)),
            PlayerMessage::Withdraw(ticket, name) => {
                PlayerInput::Production(*ticket, ProductionCommand::Withdraw(name))
            }
            PlayerMessage::Say(said, text) => match *said {
                ResourceRequest::Answer(alarm) => PlayerInput::Answer { alarm, word: text },
                ResourceRequest::Alarm(resource) => PlayerInput::Alarm { resource, text },
                ResourceRequest::Down(resource) => PlayerInput::Resource { resource, up: false },
                ResourceRequest::Up(resource) => PlayerInput::Resource { resource, up: true },
                ResourceRequest::Reset(station) => PlayerInput::Reset(station),
            },
        }
    }

    /// Whether a person waits for its reply.
    pub fn is_request(&self) -> bool {
        match self {
            PlayerMessage::State(..) | PlayerMessage::Reply(..) | PlayerMessage::Secured(..) => false,
            PlayerMessage::Submit(..)
            | PlayerMessage::Cancel(..)
            | PlayerMessage::Withdraw(..)
            | PlayerMessage::Say(..) => true,
        }
    }
}

impl CellLoop {
    /// What has arrived is not taken: stations repeat their states, which would be of unknown age, and requests are refused for this reason.
    pub(super) fn drop_arrivals(&mut self, why: &str) {
        if self.told.iter().any(PlayerMessage::is_request) {
            self.people.refuse(&format!("not taken: {why}"));
        }
        self.told.clear();
    }

    /// This process has stood, or its machine has slept: of what has waited meanwhile the age is not known.
    pub(super) fn stood(&mut self) {
        tracing::warn!("the cell's thread stood still: all stations count as not received");
        self.drop_arrivals("the coordinator stood still meanwhile; look at the state, then ask again");
        self.reports.clear();
        let now = self.now();
        self.coordination.stood(now);
    }

    /// Takes a request, unless its result could not be written down.
    pub(super) fn request(&mut self, request: CellInbound) {
        let now = self.now();
        let is_new = match &request {
            CellInbound::Submit(..) => true,
            CellInbound::Goal(asked) => matches!(asked.asked, GoalAsked::New(_)),
            _ => false,
        };
        let refusal = self.log.as_mut().and_then(|log| log.refusal(now, is_new));
        match (request, refusal) {
            (CellInbound::Answer(_, _, _, reply), Some(reason)) => {
                reply.send(AnswerAlarmResponse { accepted: false, reason });
            }
            (CellInbound::Answer(alarm, word, by, reply), None) => {
                tracing::info!("alarm {alarm}: request answer {}{}", quoted(&word), by_whom(&by));
                self.say(ResourceRequest::Answer(AlarmId(alarm)), word, AnsweringOperator::Answer(reply));
            }
            (CellInbound::Resource(_, reply), Some(reason)) => {
                reply.send(SetResourceResponse { accepted: false, reason });
            }
            (CellInbound::Resource(said, reply), None) => {
                let SetResourceRequest { resource, what, text, by } = said;
                tracing::info!(
                    "resource {}: request {what}{}, text {}",
                    quoted(&resource),
                    by_whom(&by),
                    quoted(&text)
                );
                match wire::said(self.coordination.state(), &resource, what) {
                    Ok(said) => self.say(said, text, AnsweringOperator::Resource(reply)),
                    Err(reason) => reply.send(SetResourceResponse { accepted: false, reason }),
                }
            }
            (CellInbound::Goal(asked), refusal) => self.goal(asked, refusal),
            (CellInbound::Submit(_, reply), Some(reason)) => reply.send(denied_all(vec![reason])),
            (CellInbound::Submit(asked, reply), None) => self.submit(&asked.requests, reply),
            (CellInbound::Cancel(_, reply) | CellInbound::Withdraw(_, reply), Some(reason)) => {
                reply.send(ChangeOrderResponse { done: false, reason });
            }
            (CellInbound::Cancel(name, reply), None) => {
                let ticket = self.people.ticket(Requester::Change(reply));
                self.told.push(PlayerMessage::Cancel(ticket, name));
            }
            (CellInbound::Withdraw(name, reply), None) => {
                let ticket = self.people.ticket(Requester::Change(reply));
                self.told.push(PlayerMessage::Withdraw(ticket, name));
            }
            // No requests.
            (CellInbound::Heard(..) | CellInbound::State(..) | CellInbound::Why(..), _) => {}
        }
    }

    fn say(&mut self, said: ResourceRequest, text: String, operator: AnsweringOperator) {
        self.told.push(PlayerMessage::Say(said, text));
        self.people.expect(said, operator);
    }

    fn submit(&mut self, asked: &[linewright_msgs::ProductionRequest], reply: ServiceReply<SubmitOrders>) {
        let (mut requests, mut problems) = (Vec::new(), Vec::new());
        for request in asked {
            match wire::request(request, fresh_key()) {
                Ok(request) => requests.push(request),
                Err(problem) => problems.push(problem),
            }
        }
        if problems.is_empty() {
            let ticket = self.people.ticket(Requester::Submit(reply));
            self.told.push(PlayerMessage::Submit(ticket, requests));
        } else {
            reply.send(denied_all(problems));
        }
    }
}
