//! An operator: an ordinary ROS node that presses buttons.
//!
//! Publishes commands, selectors and held buttons (repeated while the finger is on them), and keeps the newest message
//! of every node. The topic names are written out here, as in `docs/ros.md`.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use linewright_line::Tick;
use linewright_msgs::{CycleTime, Flag, LineState, StationEvent, StationState, Text};
use linewright_node_shell::{Forward, Participant, Publisher, RosArgs, RosNode, forward, qos};
use linewright_station_shell::NewestBySequence;
use tokio::sync::{mpsc, oneshot};

use super::rig::Rig;
use super::{PATIENCE, pause, wait_for};

/// The stations of the shipped line.
pub const STATIONS: [&str; 3] = ["transfer", "clamp_1", "mill_1"];
/// Period at which a held button is repeated.
const REFRESH: Duration = Duration::from_millis(40);

/// The newest of everything.
#[derive(Default)]
pub struct Heard {
    /// Stations whose states are received.
    pub names: &'static [&'static str],
    pub line: LineState,
    pub stations: HashMap<String, StationState>,
    pub events: Vec<StationEvent>,
    pub cycle_time: Option<CycleTime>,
}

impl Heard {
    /// The newest state of a station.
    pub fn station(&self, name: &str) -> StationState {
        self.stations.get(name).cloned().unwrap_or_default()
    }

    /// Every station is received, and this holds for it.
    pub fn all(&self, what: impl Fn(&StationState) -> bool) -> bool {
        self.names.iter().all(|name| self.stations.get(*name).is_some_and(&what))
    }

    /// Boot ids of the nodes, the coordinator's first.
    pub fn boot_ids(&self) -> Vec<u64> {
        let stations = self.names.iter().map(|name| self.station(name).boot_id);
        std::iter::once(self.line.boot_id).chain(stations).collect()
    }

    /// The mode, once every station has acknowledged it.
    pub fn in_mode(&self, mode: u8) -> bool {
        self.line.mode == mode && self.line.enabled && self.all(|s| s.mode == mode && s.mode_epoch == self.line.epoch)
    }
}

enum Said {
    Line(Box<LineState>),
    Station(Box<StationState>),
    Event(Box<StationEvent>),
    Cycle(CycleTime),
}

/// An operator with a participant of his own.
pub struct Operator {
    heard: Arc<Mutex<Heard>>,
    commands: Publisher<Text>,
    buttons: Arc<Publisher<Text>>,
    panels: HashMap<String, Arc<Publisher<Flag>>>,
    selectors: HashMap<&'static str, Publisher<Text>>,
    node: RosNode,
    end: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Operator {
    /// Joins the shipped line under its own namespace.
    pub fn join(rig: &Rig) -> Self {
        Self::join_line(rig, "/transfer_line", &STATIONS)
    }

    /// Joins a line of these stations and waits until every node is received.
    pub fn join_line(rig: &Rig, namespace: &str, names: &'static [&'static str]) -> Self {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
        let args = RosArgs { domain_id: rig.domain(), ..RosArgs::default() };
        let participant = Participant::open(&args).expect("a participant");
        let mut node = participant.node(namespace, "test_operator").expect("a node");
        let (to, mut from) = mpsc::channel(4096);
        let entered = runtime.enter();
        let state = node.subscription("state", qos::latched_state()).expect("a topic");
        let mut tasks: Vec<Forward> = vec![forward(state, to.clone(), |m, _| Some(Said::Line(Box::new(m))))];
        let cycle_time = node.subscription("cycle_time", qos::latched_state()).expect("a topic");
        tasks.push(forward(cycle_time, to.clone(), |m, _| Some(Said::Cycle(m))));
        let (mut panels, mut selectors) = (HashMap::new(), HashMap::new());
        for &station in names {
            let state = node.subscription(&format!("{station}/state"), qos::latched_state()).expect("a topic");
            tasks.push(forward(state, to.clone(), |m, _| Some(Said::Station(Box::new(m)))));
            let event = node.subscription(&format!("{station}/event"), qos::event()).expect("a topic");
            tasks.push(forward(event, to.clone(), |m, _| Some(Said::Event(Box::new(m)))));
            for side in ["advance", "return"] {
                let topic = format!("{station}/{side}");
                let publisher = node.publisher(&topic, qos::command()).expect("a topic");
                panels.insert(topic, Arc::new(publisher));
            }
            let topic = format!("{station}/selector");
            selectors.insert(station, node.publisher(&topic, qos::command()).expect("a topic"));
        }
        drop(entered);
        let heard = Arc::new(Mutex::new(Heard { names, ..Heard::default() }));
        let (end, mut ended) = oneshot::channel();
        let notes = heard.clone();
        let size = |station: &str| rig.plan.operations.iter().filter(|o| o.station == station).count();
        let sizes: Vec<(&str, usize)> = names.iter().map(|station| (*station, size(station))).collect();
        let thread = std::thread::spawn(move || {
            let _tasks = tasks;
            let mut newest = Newest::new();
            runtime.block_on(async {
                loop {
                    tokio::select! {
                        said = from.recv() => if let Some(said) = said { take(&notes, &mut newest, &sizes, said) },
                        _ = &mut ended => break,
                    }
                }
            });
        });
        let operator = Operator {
            heard,
            commands: node.publisher("mode_cmd", qos::command()).expect("a topic"),
            buttons: Arc::new(node.publisher("buttons", qos::command()).expect("a topic")),
            panels,
            selectors,
            node,
            end: Some(end),
            thread: Some(thread),
        };
        operator.wait_until_connected();
        operator
    }

    /// Waits until every node is received and listens, and the devices are there.
    pub fn wait_until_connected(&self) {
        self.wait("everybody is heard", |h| h.line.boot_id != 0 && h.all(|s| s.devices_valid));
        let listened = |topic: &str| self.node.subscription_count(topic).is_ok_and(|count| count > 0);
        let all = || listened("mode_cmd") && listened("buttons") && self.panels.keys().all(|topic| listened(topic));
        assert!(wait_for(PATIENCE, all), "everybody listens");
        // Discovery is one-sided for a moment.
        pause(300);
    }

    /// Messages received so far.
    pub fn heard(&self) -> MutexGuard<'_, Heard> {
        lock(&self.heard)
    }

    /// The newest state of a station.
    pub fn station(&self, name: &str) -> StationState {
        self.heard().station(name)
    }

    /// Waits until the messages received satisfy this.
    pub fn wait(&self, what: &str, holds: impl Fn(&Heard) -> bool) {
        if !wait_for(PATIENCE, || holds(&self.heard())) {
            panic!("waited in vain: {what}; {}", self.picture());
        }
    }

    /// State of the line by its own messages.
    pub fn picture(&self) -> String {
        let heard = self.heard();
        let mut text = format!("mode {}; last refusal '{}'", heard.line.text, heard.line.refusal);
        for name in heard.names {
            let s = heard.station(name);
            text.push_str(&format!("; {name} {} fault '{}' waits for {:?}", s.operation, s.fault, s.blocked_by));
        }
        text
    }

    /// Publishes a word on `mode_cmd`, once.
    pub fn say(&self, word: &str) {
        self.commands.send(Text::from(word));
    }

    /// Gives a command until every station is in the mode it leads to.
    pub fn order(&self, word: &str, mode: u8) {
        for _ in 0..30 {
            self.say(word);
            if wait_for(Duration::from_millis(700), || self.heard().in_mode(mode)) {
                return;
            }
        }
        panic!("'{word}' should have been obeyed: {}", self.picture());
    }

    /// Gives a command that must be refused; gives the published reason.
    pub fn refused(&self, word: &str) -> String {
        let before = self.heard().line.refusals;
        self.say(word);
        self.wait(&format!("'{word}' is refused"), |h| h.line.refusals > before);
        self.heard().line.refusal.clone()
    }

    /// Turns a selector.
    pub fn select(&self, station: &str, word: &str) {
        self.selectors[station].send(Text::from(word));
    }

    /// Puts a finger on a panel's button: `advance` or `return`.
    pub fn hold(&self, station: &str, side: &str) -> Finger {
        let publisher = self.panels[&format!("{station}/{side}")].clone();
        Finger::on(move |held| publisher.send(Flag { data: held }))
    }

    /// Puts a finger on hand-mode buttons.
    pub fn hold_buttons(&self, names: &str) -> Finger {
        let (publisher, names) = (self.buttons.clone(), names.to_owned());
        Finger::on(move |held| publisher.send(Text::from(if held { names.as_str() } else { "" })))
    }

    /// Holds a panel's button until what it starts has ended; gives whether anything moved.
    pub fn jog(&self, station: &str, side: &str) -> bool {
        let before = self.station(station).places;
        let finger = self.hold(station, side);
        let moved = wait_for(Duration::from_secs(2), || self.station(station).places != before);
        if moved {
            self.wait("the motion ends", |h| h.station(station).stopped);
        }
        drop(finger);
        pause(150);
        moved
    }

    /// Brings the line from wherever it stands, at rest, to auto: through manual, resuming what was stopped.
    pub fn recover(&self) {
        self.wait("everything stands", |h| h.all(|s| s.stopped));
        if self.heard().line.mode == StationState::MODE_HOME {
            self.order("start", StationState::MODE_STANDBY);
        }
        self.order("manual", StationState::MODE_MANUAL);
        self.complete();
        self.order("auto", StationState::MODE_AUTO);
    }

    /// In manual: resumes what was stopped.
    pub fn complete(&self) {
        let names = self.heard().names;
        // One may have to be out of another's way first.
        for name in names.iter().cycle().take(3 * names.len()) {
            if !self.station(name).incomplete.is_empty() {
                self.jog(name, "advance");
            }
        }
        for name in names {
            assert!(self.station(name).incomplete.is_empty(), "{name} is recovered: {}", self.picture());
        }
    }

    /// In manual: leads every station home, one motion at a time, with whichever button moves it.
    pub fn lead_home(&self) {
        let names = self.heard().names;
        let mut back = vec![false; names.len()];
        for _ in 0..60 {
            let away: Vec<usize> = (0..names.len()).filter(|&at| !self.station(names[at]).at_home).collect();
            if away.is_empty() {
                return;
            }
            for at in away {
                let side = if back[at] { "return" } else { "advance" };
                back[at] ^= !self.jog(names[at], side);
            }
        }
        panic!("not all are home: {}", self.picture());
    }

    /// Stops at home.
    pub fn go_home(&self) {
        self.order("stop", StationState::MODE_HOME);
    }

    /// Waits until the mill has finished this many cycles more.
    pub fn cycles(&self, more: i32) {
        let last = |h: &Heard| h.station("mill_1").done.last().copied().unwrap_or(0);
        let goal = last(&self.heard()) + more;
        self.wait(&format!("{more} more cycles"), |h| last(h) >= goal);
    }

    /// Every station's counts.
    pub fn counts(&self) -> Vec<Vec<i32>> {
        STATIONS.iter().map(|name| self.station(name).done).collect()
    }
}

impl Drop for Operator {
    fn drop(&mut self) {
        if let Some(end) = self.end.take() {
            let _ = end.send(());
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn lock(heard: &Mutex<Heard>) -> MutexGuard<'_, Heard> {
    heard.lock().unwrap_or_else(PoisonError::into_inner)
}

/// By writer: time of its first message, and its newest message.
type Newest = HashMap<String, (std::time::Instant, NewestBySequence)>;

/// As the shipped lines have it.
const STALE: Duration = Duration::from_millis(250);

fn take(notes: &Mutex<Heard>, newest: &mut Newest, sizes: &[(&str, usize)], said: Said) {
    // A state of a station that is not in the description, or with another number of operations, is dropped.
    if let Said::Station(state) = &said
        && !sizes.contains(&(&state.station, state.done.len()))
    {
        return;
    }
    let mut offer = |who: &str, boot, sequence| {
        let new = || (std::time::Instant::now(), NewestBySequence::new(STALE));
        let (began, newest) = newest.entry(who.to_owned()).or_insert_with(new);
        newest.offer(Tick::ZERO + began.elapsed(), boot, sequence)
    };
    let mut heard = lock(notes);
    match said {
        Said::Line(state) if offer("", state.boot_id, state.sequence) => heard.line = *state,
        Said::Station(state) if offer(&state.station, state.boot_id, state.sequence) => {
            heard.stations.insert(state.station.clone(), *state);
        }
        Said::Event(event) => heard.events.push(*event),
        Said::Cycle(cycle) => heard.cycle_time = Some(cycle),
        Said::Line(_) | Said::Station(_) => {}
    }
}

/// A finger on a button; lifted when dropped.
pub struct Finger {
    lift: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Finger {
    fn on(say: impl Fn(bool) + Send + 'static) -> Self {
        let lift = Arc::new(AtomicBool::new(false));
        let lifted = lift.clone();
        let thread = std::thread::spawn(move || {
            while !lifted.load(Ordering::Relaxed) {
                say(true);
                std::thread::sleep(REFRESH);
            }
            say(false);
        });
        Finger { lift, thread: Some(thread) }
    }
}

impl Drop for Finger {
    fn drop(&mut self) {
        self.lift.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
