//! An operator's view of a running line over ROS 2: the newest state of every node, events, and the commands.
//!
//! Shared by every subcommand that looks at a line or operates it. It uses the same topics as the stock tools, and only
//! what the nodes publish.

use std::path::Path;
use std::time::{Duration, Instant};

use linewright_console_view::{Aged, state_fresh};
use linewright_fieldbus::Clock;
use linewright_line::{Line, StationId, Tick};
use linewright_msgs::{Flag, LineState, StationEvent, StationState, Text};
use linewright_node_shell::{
    Forward, MessagePace, Participant, Publisher, RosArgs, RosNode, TopicError, forward, forward_present, qos,
    watch_middleware,
};
use linewright_station_shell::NewestBySequence;
use miette::miette;
use tokio::sync::mpsc;

use crate::described::OwnDescription;

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

/// The newest state of one node, and its time of arrival by a clock that goes on while the machine sleeps.
#[derive(Debug, Clone)]
struct HeardNode<T> {
    newest: NewestBySequence,
    state: Option<(T, Tick)>,
}

impl<T> HeardNode<T> {
    fn new(line: &Line) -> Self {
        HeardNode { newest: NewestBySequence::new(line.timing.stale), state: None }
    }

    /// Whether a state in order has come.
    fn offer(&mut self, now: Tick, boot_id: u64, sequence: u64, state: T) -> bool {
        let is_newer = self.newest.offer(now, boot_id, sequence);
        if is_newer {
            self.state = Some((state, now));
        }
        is_newer
    }

    fn aged(&self, now: Tick) -> Option<Aged<'_, T>> {
        self.state.as_ref().map(|(state, at)| Aged { state, age: now.since(*at) })
    }
}

/// An operator's connection to a line.
pub struct OperatorClient {
    line: Line,
    from: mpsc::Receiver<RawState>,
    coordinator: HeardNode<LineState>,
    stations: Vec<HeardNode<StationState>>,
    own: OwnDescription,
    /// For each station the fingerprint of the description it was started with, and when that was received last.
    described: Vec<Option<(u64, Tick)>>,
    clock: Clock,
    commands: Publisher<Text>,
    buttons: Publisher<Text>,
    node: RosNode,
    middleware: Forward,
    domain_id: u16,
    _tasks: Vec<Forward>,
}

/// Events come in bursts, one per motion of every station.
const QUEUE: usize = 4096;

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
    /// Joins the ROS graph as `name`, for the line that was read from `path`.
    pub fn open(line: &Line, path: &Path, ros: &RosArgs, name: &str) -> miette::Result<Self> {
        let failed = |error: TopicError| miette!("{error}");
        let (mut node, domain_id) = join(line, ros, name)?;
        let (to, from) = mpsc::channel(QUEUE);
        let state = node.subscription("state", qos::latched_state()).map_err(failed)?;
        let pace = MessagePace::new(line.timing.refresh, state_fresh(line));
        let mut tasks = vec![forward_present(state, to.clone(), pace.clone(), |m, _| Some(RawState::Line(m)))];
        for station in &line.stations {
            let state = node.subscription(&format!("{}/state", station.name), qos::latched_state()).map_err(failed)?;
            tasks.push(forward_present(state, to.clone(), pace.clone(), |m, _| Some(RawState::Station(Box::new(m)))));
            let event = node.subscription(&format!("{}/event", station.name), qos::event()).map_err(failed)?;
            tasks.push(forward(event, to.clone(), |m, _| Some(RawState::Event(m))));
        }
        Ok(OperatorClient {
            from,
            coordinator: HeardNode::new(line),
            stations: vec![HeardNode::new(line); line.stations.len()],
            own: OwnDescription::of(path, line),
            described: vec![None; line.stations.len()],
            clock: Clock::start(),
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

    /// The coordinator's newest state with its age.
    pub fn coordinator_aged(&self) -> Option<Aged<'_, LineState>> {
        self.coordinator.aged(self.clock.now())
    }

    /// A station's newest state with its age.
    pub fn station_aged(&self, id: StationId) -> Option<Aged<'_, StationState>> {
        self.stations[id.index()].aged(self.clock.now())
    }

    /// The coordinator's newest state, if it is fresh.
    pub fn coordinator(&self) -> Option<&LineState> {
        self.coordinator_aged()?.fresh(state_fresh(&self.line))
    }

    /// Whether a coordinator was heard at all.
    pub fn has_heard_coordinator(&self) -> bool {
        self.coordinator.state.is_some()
    }

    /// A station's newest state, if it is fresh.
    pub fn station(&self, id: StationId) -> Option<&StationState> {
        self.station_aged(id)?.fresh(state_fresh(&self.line))
    }

    /// How long the coordinator, which was heard, is not heard any more.
    pub fn coordinator_unheard_for(&self) -> Option<Duration> {
        self.coordinator_aged()?.unheard_for(state_fresh(&self.line))
    }

    /// How long a station that was heard is not heard any more.
    pub fn unheard_for(&self, id: StationId) -> Option<Duration> {
        self.station_aged(id)?.unheard_for(state_fresh(&self.line))
    }

    /// The fingerprints of the stations that are received, by station.
    fn fingerprints(&self) -> impl Iterator<Item = (StationId, u64)> {
        let (now, limit) = (self.clock.now(), state_fresh(&self.line));
        let of = move |id: StationId| self.described[id.index()].filter(|(_, at)| now.since(*at) < limit);
        self.line.station_ids().filter_map(move |id| of(id).map(|(fingerprint, _)| (id, fingerprint)))
    }

    /// A station that was started with another description than this one.
    pub fn other_station(&self) -> Option<StationId> {
        self.fingerprints().find(|(_, of)| !self.own.is_of_station(*of)).map(|(id, _)| id)
    }

    /// That the coordinator was started with another description than this one, and what to do.
    pub fn other_coordinator(&self) -> Option<String> {
        let stations: Vec<u64> = self.fingerprints().map(|(_, of)| of).collect();
        self.own.of_coordinator(self.coordinator()?.description, &stations)
    }

    /// What runs with another description than this one, and what to do.
    pub fn other_descriptions(&self) -> Vec<String> {
        if let Some(text) = self.other_coordinator() {
            return vec![text];
        }
        let others = self.fingerprints().filter(|(_, of)| !self.own.is_of_station(*of));
        others.map(|(id, _)| self.own.of_station(&self.line.station(id).name)).collect()
    }

    /// The stations of which nothing fresh is heard.
    pub fn unheard(&self) -> impl Iterator<Item = &str> {
        let unheard = self.line.station_ids().filter(|&id| self.station(id).is_none());
        unheard.map(|id| self.line.station(id).name.as_str())
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
        let now = self.clock.now();
        match raw {
            RawState::Line(state) => {
                let is_newer = self.coordinator.offer(now, state.boot_id, state.sequence, state);
                is_newer.then_some(StateUpdate::Line)
            }
            RawState::Station(state) => {
                let id = self.line.station_named(&state.station)?;
                let fits = state.done.len() == self.line.station(id).operations.len();
                self.described[id.index()] = Some((state.description, now));
                let heard = &mut self.stations[id.index()];
                let is_newer = fits && heard.offer(now, state.boot_id, state.sequence, *state);
                is_newer.then_some(StateUpdate::Station(id))
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
                let is_any = self.coordinator().is_some()
                    || self.line.station_ids().any(is_heard)
                    || self.other_station().is_some();
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

    /// A publisher for resume at this console.
    pub fn resume(&mut self) -> miette::Result<Publisher<Flag>> {
        self.node.publisher("resume", qos::command()).map_err(|error| miette!("{error}"))
    }

    /// The node, for topics and services of one subcommand alone.
    pub fn node(&mut self) -> &mut RosNode {
        &mut self.node
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

    /// Waits until the coordinator is received and listens to commands. Prints what runs with another description.
    pub async fn until_connected(&mut self, within: Duration) -> miette::Result<()> {
        let deadline = Instant::now() + within;
        while Instant::now() < deadline {
            self.listen(Duration::from_millis(30)).await?;
            let listens = self.node.subscription_count("mode_cmd").is_ok_and(|count| count > 0);
            if listens && self.coordinator().is_some() {
                // Discovery is one-sided for a moment: let the other side find our publishers too.
                self.listen(Duration::from_millis(150)).await?;
                self.other_descriptions().iter().for_each(|text| crate::out::complain!("{text}"));
                return Ok(());
            }
        }
        Err(self.not_found())
    }

    /// Error: no coordinator of this line is heard.
    pub fn not_found(&self) -> miette::Report {
        not_heard(&format!("line '{}'", self.line.name), self.domain_id)
    }
}
