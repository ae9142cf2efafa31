//! The devices of a bus as ROS 2 sees them: services and states named like those of `ros2_canopen`, and diagnostics.
//!
//! Whoever runs a CANopen manager has one of these beside it: the coordinator's node, and a station's with a bus of its
//! own. It passes on what is asked and what is answered. Whether and when a device is asked, the manager decides.

mod diagnostics;
mod names;
mod services;
mod trouble;

use std::time::Duration;

use linewright_canopen::manager::{Condition, PlainStatus, Status};
use linewright_canopen::{Event, NodeId};
use linewright_fieldbus::Driver;
use linewright_line::{Device, Line, Tick};
use linewright_msgs::{DiagnosticArray, Text};
use linewright_node_shell::{Forward, Node, Publisher, TopicError, qos, stamp};
use tokio::sync::mpsc;

pub use names::device_names;
pub use services::Asked;
use services::Pending;
pub use trouble::{TROUBLE_BYTES_MAX, Trouble, in_words};

/// How often everything is told when nothing changes.
const EVERY: Duration = Duration::from_secs(1);
/// How soon news may follow news: a device that comes and goes must not flood a reliable topic.
const NEWS_EVERY: Duration = Duration::from_millis(50);
/// How many states of one device are told at once within a second; after that, only the newest every [`NEWS_EVERY`].
const STATES_MAX: u32 = 20;
/// Requests that wait for this node; more wait in the middleware, ten for each service.
const QUEUE: usize = 64;

/// One device, and what was last told of it.
struct Told {
    device: Device,
    owner: String,
    state: Publisher<Text>,
    word: &'static str,
    /// States told at once since the last regular diagnosis.
    at_once: u32,
    /// What its last request has come to, if it failed.
    failed: String,
}

/// A device that speaks no CANopen: its name, whose it is, and what describes its frames.
struct Plain {
    name: String,
    owner: String,
    file: String,
}

/// Condition, state, emergency code and losses of each device, and whether and how often one that speaks no CANopen was
/// lost: what makes a diagnosis news.
type Key = (Vec<(Condition, &'static str, Option<u16>, u32)>, Vec<(bool, u32)>);

/// The devices of one bus.
pub struct Devices {
    node: String,
    told: Vec<Told>,
    plain: Vec<Plain>,
    diagnostics: Publisher<DiagnosticArray>,
    key: Key,
    due: Tick,
    last: Tick,
    from: mpsc::Receiver<Asked>,
    pending: Vec<Pending>,
    tasks: Vec<Forward>,
}

impl Devices {
    /// Opens the services and topics of these devices, and of the bus they are on, as part of `node`.
    pub fn open<'a>(
        node: &mut Node,
        line: &Line,
        devices: impl IntoIterator<Item = &'a Device>,
    ) -> Result<Self, TopicError> {
        let owner = |device: &Device| line.owner_name(device.owner).to_owned();
        // The services are those of CANopen; whoever speaks none has none.
        let (devices, of_frames): (Vec<&Device>, Vec<&Device>) =
            devices.into_iter().partition(|device| device.frames.is_none());
        let plain = |device: &&Device| {
            let file = device.frames.as_ref().map(|frames| frames.file.name.clone()).unwrap_or_default();
            Plain { name: device.name.clone(), owner: owner(device), file }
        };
        let (to, from) = mpsc::channel(QUEUE);
        let mut tasks = services::open_bus(node, &to)?;
        let mut told = Vec::with_capacity(devices.len());
        for (device, name) in devices.iter().zip(device_names(line, &devices)) {
            tasks.extend(services::open_device(node, &name, device.node_id, &to)?);
            let state = node.publisher(&format!("{name}/nmt_state"), qos::latched_state())?;
            let (device, owner) = ((*device).clone(), owner(device));
            told.push(Told { device, owner, state, word: "", at_once: 0, failed: String::new() });
        }
        Ok(Devices {
            node: node.name().to_owned(),
            told,
            plain: of_frames.iter().map(plain).collect(),
            diagnostics: node.publisher("/diagnostics", qos::event())?,
            key: Key::default(),
            due: Tick::ZERO,
            last: Tick::ZERO,
            from,
            pending: Vec::new(),
            tasks,
        })
    }

    /// Waits for a request; hand it to [`Devices::ask`]. Cancel safe.
    pub async fn next(&mut self) -> Asked {
        match self.from.recv().await {
            Some(asked) => asked,
            // Every service has failed; `is_failed` says so.
            None => std::future::pending().await,
        }
    }

    /// A service has ended; the middleware has failed.
    pub fn is_failed(&self) -> bool {
        self.tasks.iter().any(Forward::is_finished)
    }

    /// When [`Devices::act`] has something to do next.
    pub fn deadline(&self) -> Tick {
        self.due
    }

    /// Takes what the bus reports: news are told at once, answers passed on.
    pub fn bus_events(&mut self, events: &[Event], driver: &mut Driver) {
        let quiet = |event: &Event| matches!(event, Event::InputsChanged { .. } | Event::Answered { .. });
        if !events.iter().all(quiet) {
            self.due = self.due.min(self.last + NEWS_EVERY);
        }
        // A device that boots is up again in a millisecond; whoever waits for it to boot wants to see that it did.
        self.states(driver, STATES_MAX);
        self.answer(driver);
    }

    /// Tells the states that have changed, of devices that have not done so too often.
    fn states(&mut self, driver: &Driver, most: u32) {
        for status in driver.manager().statuses() {
            let word = names::state_word(status.nmt);
            let Some(told) = self.told(status.node.get()) else { continue };
            if told.word != word && told.at_once < most {
                told.word = word;
                told.at_once = told.at_once.saturating_add(1);
                told.state.send(Text::from(word));
            }
        }
    }

    /// Tells what is due.
    pub fn act(&mut self, now: Tick, driver: &Driver) {
        if now < self.due {
            return;
        }
        self.states(driver, u32::MAX);
        let statuses: Vec<Status<'_>> = driver.manager().statuses().collect();
        let plain: Vec<PlainStatus<'_>> = driver.manager().plain_statuses(now).collect();
        let of_node = |s: &Status<'_>| {
            (s.condition, names::state_word(s.nmt), s.emergency.map(|(_, emergency)| emergency.code), s.losses)
        };
        let key: Key = (statuses.iter().map(of_node).collect(), plain.iter().map(|s| (s.live, s.losses)).collect());
        if self.key != key || self.last + EVERY <= now {
            if self.last + EVERY <= now {
                self.told.iter_mut().for_each(|told| told.at_once = 0);
            }
            self.key = key;
            self.last = now;
            let status = statuses.iter().filter_map(|status| {
                let told = self.told.iter().find(|told| told.device.node_id == status.node.get())?;
                Some(self.diagnosis(now, driver, status, told))
            });
            let plain = plain.iter().filter_map(|status| {
                let plain = self.plain.iter().find(|plain| plain.name == status.name)?;
                Some(self.plain_diagnosis(status, plain))
            });
            let status = status.chain(plain).collect();
            self.diagnostics.send(DiagnosticArray { header: stamp(), status });
        }
        self.due = self.last + EVERY;
    }

    fn told(&mut self, node: u8) -> Option<&mut Told> {
        self.told.iter_mut().find(|told| told.device.node_id == node)
    }
}

fn node_id(id: u8) -> Option<NodeId> {
    NodeId::new(id)
}
