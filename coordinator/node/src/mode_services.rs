//! Commands of the mode by services: `~/set_mode`, and `~/stop`, `~/estop` without anything to fill in.
//!
//! They are the commands of the topic `mode_cmd`: queued, decided and refused with them. Here is only how a request is put into the words
//! of the topic, and that its answer follows what the command has caused, its record included.

use linewright_coordinator_logic::ModeCommand;
use linewright_msgs::{SetMode, SetModeRequest, SetModeResponse, Time, Trigger, TriggerResponse, fitting};
use linewright_node_line::quoted;
use linewright_node_shell::{ClientDelays, Forward, RosNode, ServiceReply, TopicError, serve};
use linewright_station_shell::ParticipantId;
use tokio::sync::mpsc;

use crate::command::words_of;
use crate::node::CoordinatorLoop;
use crate::topics::CoordinatorInbound;

/// A command by a service.
#[derive(Debug)]
pub struct ModeRequest {
    /// The command in the words of the topic, or what is wrong with the request.
    words: Result<String, String>,
    /// Operator and reason, for the log.
    remark: String,
    /// Why it may be late, if it may.
    lateness: Option<&'static str>,
    reply: ModeReply,
}

#[derive(Debug)]
enum ModeReply {
    Set(ServiceReply<SetMode>),
    Trigger(ServiceReply<Trigger>),
}

/// A command that was taken: its answer waits for the effects.
#[derive(Debug)]
pub(crate) struct TakenCommand {
    reply: ModeReply,
    refused: Option<String>,
    is_stop: bool,
}

/// The commands that have a service of their own, without a stamp. They only stop: a request that a cut link has held up does no harm. *Start*
/// would take back a stop that was given meanwhile, and *reset* end an emergency stop.
const TRIGGERS: [ModeCommand; 2] = [ModeCommand::Stop, ModeCommand::EStop];

impl ModeRequest {
    fn set(request: &SetModeRequest, delays: &mut ClientDelays, reply: ServiceReply<SetMode>) -> Self {
        let only_stops = [SetModeRequest::STOP, SetModeRequest::ESTOP].contains(&request.command);
        let lateness = match request.stamp == Time::default() {
            true if only_stops => None,
            true => Some("without `stamp`, the time of the command, nothing shows whether it comes late"),
            false if delays.offer(reply.client(), &request.stamp) => None,
            false => Some("it came more than 2 s late; give it again"),
        };
        let remark = match (request.by.trim(), request.note.trim()) {
            ("", "") => String::new(),
            (by, "") => format!(", by {}", quoted(by)),
            ("", note) => format!(": {}", quoted(note)),
            (by, note) => format!(", by {}: {}", quoted(by), quoted(note)),
        };
        ModeRequest { words: words_of(request), remark, lateness, reply: ModeReply::Set(reply) }
    }

    fn trigger(command: ModeCommand, reply: ServiceReply<Trigger>) -> Self {
        let (words, remark) = (Ok(command.name().to_owned()), String::new());
        ModeRequest { words, remark, lateness: None, reply: ModeReply::Trigger(reply) }
    }

    /// Whether it is the emergency stop, which waits for nothing and is never too late.
    pub fn is_emergency_stop(&self) -> bool {
        self.words.as_deref().ok().and_then(ModeCommand::parse) == Some(ModeCommand::EStop)
    }
}

impl ModeReply {
    fn participant(&self) -> ParticipantId {
        match self {
            ModeReply::Set(reply) => reply.participant(),
            ModeReply::Trigger(reply) => reply.participant(),
        }
    }

    fn send(self, accepted: bool, reason: String, epoch: u64) {
        match self {
            ModeReply::Set(reply) => reply.send(SetModeResponse { accepted, reason: fitting(reason), epoch }),
            ModeReply::Trigger(reply) => {
                let message = if accepted { format!("epoch {epoch}: {reason}") } else { reason };
                reply.send(TriggerResponse { success: accepted, message: fitting(message) });
            }
        }
    }
}

/// Opens the services.
///
/// # Errors
/// When the middleware refuses one.
pub fn open(node: &mut RosNode, to: &mpsc::Sender<CoordinatorInbound>) -> Result<Vec<Forward>, TopicError> {
    let mut delays = ClientDelays::default();
    let set = node.service::<SetMode>("~/set_mode")?;
    let mut tasks = vec![serve(set, to.clone(), move |asked, reply| {
        CoordinatorInbound::Asked(ModeRequest::set(&asked, &mut delays, reply))
    })];
    for command in TRIGGERS {
        let service = node.service::<Trigger>(&format!("~/{}", command.name()))?;
        tasks.push(serve(service, to.clone(), move |_, reply| {
            CoordinatorInbound::Asked(ModeRequest::trigger(command, reply))
        }));
    }
    Ok(tasks)
}

impl CoordinatorLoop {
    /// Takes a command by a service. It is answered by [`CoordinatorLoop::answer_commands`].
    pub(crate) fn mode_asked(&mut self, asked: ModeRequest) {
        let (from, is_stop) = (asked.reply.participant(), asked.is_emergency_stop());
        let doubt = if is_stop { None } else { self.shell.against_requests(self.clock.now()).map(str::to_owned) };
        let late = asked.lateness.filter(|_| !is_stop).map(str::to_owned);
        let refused = match (asked.words, late.or(doubt)) {
            (Err(unknown), _) => Some(self.refuse(from, unknown)),
            (Ok(words), Some(why)) => Some(self.refuse(from, format!("{}: {why}", quoted(&words)))),
            (Ok(words), None) => self.operated(from, &words, &asked.remark),
        };
        self.taken.push(TakenCommand { reply: asked.reply, refused, is_stop });
    }

    /// Answers the commands by services, after everything that they have caused.
    pub(crate) fn answer_commands(&mut self) {
        if self.taken.is_empty() {
            return;
        }
        let coordinator = self.shell.coordinator();
        let (epoch, text, is_unwritten) = (coordinator.epoch(), coordinator.text(), self.shell.is_unwritten());
        for TakenCommand { reply, refused, is_stop } in self.taken.drain(..) {
            match refused {
                Some(why) => reply.send(false, why, epoch),
                // Its epoch is not on the disk; the emergency stop is in force, and waits for no record.
                None if is_unwritten && !is_stop => reply.send(false, text.clone(), epoch),
                None => reply.send(true, text.clone(), epoch),
            }
        }
    }
}
