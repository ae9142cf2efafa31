//! An operator's view of a running line over ROS 2: the newest state of every node, events, and the commands.
//!
//! Shared by every subcommand that looks at a line or operates it. It uses the same topics as the stock tools, and only
//! what the nodes publish.

use std::time::{Duration, Instant};

use linewright_fieldbus::Clock;
use linewright_line::{Line, StationId, Tick};
use linewright_msgs::{Flag, Header, LineState, StationEvent, StationState, Text};
use linewright_node_shell::{
    Forward, MessagePace, Participant, Publisher, RosArgs, RosNode, TopicError, forward, qos, watch_middleware,
};
use linewright_station_shell::NewestBySequence;
use miette::miette;
use tokio::sync::mpsc;

/// Something newer was heard.
#[derive(Debug)]
pub enum StateUpdate {
    /// The coordinator's state.
    Line,
    /// A station's state.
    Station(StationId),
    /// Something happened at a station.
    Event(StationId, StationEvent),
}

enum RawState {
    Line(LineState),
    Station(Box<StationState>),
    Event(StationEvent),
}

/// The newest state of one node, and its time of arrival.
#[derive(Debug, Clone)]
struct StampedState<T> {
    state: T,
    at: Instant,
}

/// An operator's connection to a line.
pub struct OperatorClient {
    line: Line,
    from: mpsc::Receiver<RawState>,
    line_state: Option<StampedState<LineState>>,
    stations: Vec<Option<StampedState<StationState>>>,
    clock: Clock,
    newest_line: NewestBySequence,
    newest: Vec<NewestBySequence>,
    line_pace: MessagePace,
    paces: Vec<MessagePace>,
    commands: Publisher<Text>,
    buttons: Publisher<Text>,
    node: RosNode,
    middleware: Forward,
    domain_id: u16,
    _tasks: Vec<Forward>,
}

/// Events come in bursts, one per motion of every station.
const QUEUE: usize = 4096;

/// A state is shown for this many times the age at which controllers ignore it, so that the picture does not flicker.
const SHOWN_FOR: u32 = 2;

/// Joins the ROS graph of a line as `name`; also gives the domain.
pub fn join(line: &Line, ros: &RosArgs, name: &str) -> miette::Result<(RosNode, u16)> {
    let participant = Participant::open(ros).map_err(|error| miette!("{error}"))?;
    // Several operators may look at the same line: each needs a name of its own.
    let name = format!("{name}_{}", std::process::id());
    let node = participant.node(&format!("/{}", line.name), &name).map_err(|error| miette!("{error}"))?;
    Ok((node, participant.domain_id()))
}

/// Error: no coordinator is found.
pub fn not_heard(of: &str, domain: u16) -> miette::Report {
    miette!("no coordinator of {of} found on ROS domain {domain}; check that it runs, with the same ROS_DOMAIN_ID")
}

impl OperatorClient {
    /// Joins the ROS graph as `name`.
    pub fn open(line: &Line, ros: &RosArgs, name: &str) -> miette::Result<Self> {
        let failed = |error: TopicError| miette!("{error}");
        let (mut node, domain_id) = join(line, ros, name)?;
        let (to, from) = mpsc::channel(QUEUE);
        let state = node.subscription("state", qos::latched_state()).map_err(failed)?;
        let mut tasks = vec![forward(state, to.clone(), |m, _| Some(RawState::Line(m)))];
        for station in &line.stations {
            let state = node.subscription(&format!("{}/state", station.name), qos::latched_state()).map_err(failed)?;
            tasks.push(forward(state, to.clone(), |m, _| Some(RawState::Station(Box::new(m)))));
            let event = node.subscription(&format!("{}/event", station.name), qos::event()).map_err(failed)?;
            tasks.push(forward(event, to.clone(), |m, _| Some(RawState::Event(m))));
        }
        let pace = MessagePace::new(line.timing.refresh, line.timing.stale * SHOWN_FOR);
        Ok(OperatorClient {
            from,
            line_state: None,
            stations: vec![None; line.stations.len()],
            clock: Clock::start(),
            newest_line: NewestBySequence::new(line.timing.stale),
            newest: vec![NewestBySequence::new(line.timing.stale); line.stations.len()],
            paces: vec![pace.clone(); line.stations.len()],
            line_pace: pace,
            commands: node.publisher("mode_cmd", qos::command()).map_err(failed)?,
            buttons: node.publisher("buttons", qos::command()).map_err(failed)?,
            line: line.clone(),
            domain_id,
            middleware: watch_middleware(),
            node,
            _tasks: tasks,
        })
    }

    /// The description.
    pub fn line(&self) -> &Line {
        &self.line
    }

    /// The coordinator's newest state, if it is fresh.
    pub fn coordinator(&self) -> Option<&LineState> {
        self.line_state.as_ref().filter(|aged| self.is_fresh(aged.at)).map(|aged| &aged.state)
    }

    /// Whether a coordinator was heard at all.
    pub fn has_heard_coordinator(&self) -> bool {
        self.line_state.is_some()
    }

    /// A station's newest state, if it is fresh.
    pub fn station(&self, id: StationId) -> Option<&StationState> {
        self.stations[id.index()].as_ref().filter(|aged| self.is_fresh(aged.at)).map(|aged| &aged.state)
    }

    /// How long the coordinator, which was heard, is not heard any more.
    pub fn coordinator_unheard_for(&self) -> Option<Duration> {
        self.line_state.as_ref().filter(|aged| !self.is_fresh(aged.at)).map(|aged| aged.at.elapsed())
    }

    /// How long a station that was heard is not heard any more.
    pub fn unheard_for(&self, id: StationId) -> Option<Duration> {
        self.stations[id.index()].as_ref().filter(|aged| !self.is_fresh(aged.at)).map(|aged| aged.at.elapsed())
    }

    /// The stations of which nothing fresh is heard.
    pub fn unheard(&self) -> impl Iterator<Item = &str> {
        let unheard = self.line.station_ids().filter(|&id| self.station(id).is_none());
        unheard.map(|id| self.line.station(id).name.as_str())
    }

    fn is_fresh(&self, at: Instant) -> bool {
        at.elapsed() < self.line.timing.stale * SHOWN_FOR
    }

    /// Waits for something newer. Cancel safe.
    pub async fn next(&mut self) -> miette::Result<StateUpdate> {
        loop {
            let raw = tokio::select! {
                raw = self.from.recv() => raw.ok_or_else(|| miette!("the middleware has failed"))?,
                () = self.middleware.finished() => return Err(miette!(
                    "ROS 2 is cut off; a command that was stopped for a moment (Ctrl-Z) has to be started again"
                )),
            };
            if let Some(heard) = self.take(raw) {
                return Ok(heard);
            }
        }
    }

    fn take(&mut self, raw: RawState) -> Option<StateUpdate> {
        let (at, now) = (Instant::now(), self.clock.now());
        match raw {
            RawState::Line(state) => {
                if !self.newest_line.offer(now, state.boot_id, state.sequence) {
                    return None;
                }
                if !self.line_pace.offer(now.since(Tick::ZERO), seconds(&state.header)) {
                    return None;
                }
                self.line_state = Some(StampedState { state, at });
                Some(StateUpdate::Line)
            }
            RawState::Station(state) => {
                let id = self.line.station_named(&state.station)?;
                let fits = state.done.len() == self.line.station(id).operations.len();
                if !fits || !self.newest[id.index()].offer(now, state.boot_id, state.sequence) {
                    return None;
                }
                if !self.paces[id.index()].offer(now.since(Tick::ZERO), seconds(&state.header)) {
                    return None;
                }
                self.stations[id.index()] = Some(StampedState { state: *state, at });
                Some(StateUpdate::Station(id))
            }
            RawState::Event(event) => Some(StateUpdate::Event(self.line.station_named(&event.station)?, event)),
        }
    }

    /// Waits until the coordinator and every station are heard as they are now, for so long at most; gives whether they are.
    ///
    /// # Errors
    /// When nothing of the line is heard.
    pub async fn until_all_heard(&mut self, within: Duration) -> miette::Result<bool> {
        let deadline = Instant::now() + within;
        loop {
            let is_heard = |id| self.station(id).is_some();
            let is_all = self.coordinator().is_some() && self.line.station_ids().all(is_heard);
            if is_all || Instant::now() >= deadline {
                let is_any = self.coordinator().is_some() || self.line.station_ids().any(is_heard);
                return if is_any { Ok(is_all) } else { Err(self.not_found()) };
            }
            self.listen(Duration::from_millis(30)).await?;
        }
    }

    /// Takes in whatever is heard for as long as `long`.
    pub async fn listen(&mut self, long: Duration) -> miette::Result<()> {
        let until = tokio::time::Instant::now() + long;
        while let Ok(heard) = tokio::time::timeout_at(until, self.next()).await {
            heard?;
        }
        Ok(())
    }

    /// Gives an operator's command. It is not latched: what starts later does not receive it.
    pub fn command(&self, word: &str) {
        self.commands.send(Text::from(word));
    }

    /// Publishes the hand-mode buttons that are held now; repeated while they are.
    pub fn hold(&self, names: &str) {
        self.buttons.send(Text::from(names));
    }

    /// A publisher for a button of a station's panel: `advance` or `return`.
    pub fn panel_button(&mut self, station: StationId, button: &str) -> miette::Result<Publisher<Flag>> {
        let topic = format!("{}/{button}", self.line.station(station).name);
        self.node.publisher(&topic, qos::command()).map_err(|error| miette!("{error}"))
    }

    /// A publisher for a station's selector.
    pub fn panel_selector(&mut self, station: StationId) -> miette::Result<Publisher<Text>> {
        let topic = format!("{}/selector", self.line.station(station).name);
        self.node.publisher(&topic, qos::command()).map_err(|error| miette!("{error}"))
    }

    /// A publisher for the confirmation of where a station stands.
    pub fn rejoin(&mut self, station: StationId) -> miette::Result<Publisher<Text>> {
        let topic = format!("{}/rejoin", self.line.station(station).name);
        self.node.publisher(&topic, qos::command()).map_err(|error| miette!("{error}"))
    }

    /// Waits until the coordinator is received and listens to commands.
    pub async fn until_connected(&mut self, within: Duration) -> miette::Result<()> {
        let deadline = Instant::now() + within;
        while Instant::now() < deadline {
            self.listen(Duration::from_millis(30)).await?;
            let listens = self.node.subscription_count("mode_cmd").is_ok_and(|count| count > 0);
            if listens && self.coordinator().is_some() {
                // Discovery is one-sided for a moment: let the other side find our publishers too.
                return self.listen(Duration::from_millis(150)).await;
            }
        }
        Err(self.not_found())
    }

    /// Error: no coordinator of this line is heard.
    pub fn not_found(&self) -> miette::Report {
        not_heard(&format!("line '{}'", self.line.name), self.domain_id)
    }
}

fn seconds(header: &Header) -> f64 {
    f64::from(header.stamp.sec) + f64::from(header.stamp.nanosec) * 1e-9
}
