//! The devices of a node as ROS 2 sees them: services and states named like those of `ros2_canopen`, and diagnostics.
//!
//! Each node with a field bus has one of these beside it: the coordinator's node, and a station's with a bus of its
//! own. It passes on requests and answers. Whether and when a request goes to a device, the bus decides.

mod diagnostics;
mod names;
pub mod numbers;
mod services;
mod trouble;

use std::sync::Arc;
use std::time::Duration;

use linewright_fieldbus_seam::{BusTarget, Diagnosis, Joined, Level, News};
use linewright_line::{Device, DeviceKind, Line, Owner, Tick};
use linewright_msgs::{DiagnosticArray, Text};
use linewright_node_shell::{Forward, Publisher, RosNode, TopicError, qos, stamp};
use tokio::sync::mpsc;

pub use names::device_names;
pub use services::DeviceServiceRequest;
use services::PendingTransfer;
pub use trouble::{DeviceDiagnosticsTopic, TROUBLE_BYTES_MAX, cause, in_words, since_start};

/// Period of full reports when nothing changes, until [`Devices::report_every`] sets another one; and of texts of trouble.
const EVERY: Duration = Duration::from_secs(1);
/// Least time between two reports of news: a device that comes and goes must not flood a reliable topic.
const NEWS_EVERY: Duration = Duration::from_millis(50);
/// Most states of one device published at once; after that, only the newest every [`NEWS_EVERY`], until a period of full reports has passed without news.
const STATES_MAX: u32 = 20;
/// Requests that wait for this node; more wait in the middleware, ten for each service.
const QUEUE: usize = 64;

/// One device with services and a state, and its last report.
struct ReportedDevice {
    name: String,
    target: BusTarget,
    state: Publisher<Text>,
    word: &'static str,
    /// States published at once since the last regular diagnosis.
    at_once: u32,
    /// Result of its last request, if it failed.
    failed: String,
}

/// Key whose change makes a diagnosis news, device by device.
type PlainReportKey = Vec<(Level, Option<&'static str>, Option<u16>, u32)>;

pub struct Devices {
    node: String,
    told: Vec<ReportedDevice>,
    owners: Vec<(Owner, String)>,
    diagnostics: Arc<Publisher<DiagnosticArray>>,
    key: PlainReportKey,
    due: Tick,
    last: Tick,
    /// Period of full reports.
    every: Duration,
    from: mpsc::Receiver<DeviceServiceRequest>,
    pending: Vec<PendingTransfer>,
    tasks: Vec<Forward>,
}

impl Devices {
    /// Opens the services and topics of these devices, and of the buses they are on, as part of `node`, which publishes its diagnostics
    /// by `diagnostics`.
    pub fn open<'a>(
        node: &mut RosNode,
        diagnostics: &Arc<Publisher<DiagnosticArray>>,
        line: &Line,
        devices: impl IntoIterator<Item = &'a Device>,
    ) -> Result<Self, TopicError> {
        let devices: Vec<&Device> = devices.into_iter().collect();
        let mut owners: Vec<(Owner, String)> = Vec::new();
        for device in &devices {
            if !owners.iter().any(|(owner, _)| *owner == device.owner) {
                owners.push((device.owner, line.owner_name(device.owner).to_owned()));
            }
        }
        // Devices of plain frames accept no requests.
        let with_services = devices.into_iter().filter(|device| !matches!(device.kind, DeviceKind::Frames(_)));
        let with_services: Vec<&Device> = with_services.collect();
        let (to, from) = mpsc::channel(QUEUE);
        let mut tasks = services::open_bus(node, &to)?;
        let mut told = Vec::with_capacity(with_services.len());
        for (device, name) in with_services.iter().zip(device_names(line, &with_services)) {
            let target = device.node_id().map_or_else(|| BusTarget::Device(device.name.clone()), BusTarget::Node);
            tasks.extend(services::open_device(node, &name, &target, &to)?);
            let state = node.publisher(&format!("{name}/nmt_state"), qos::latched_state())?;
            told.push(ReportedDevice {
                name: device.name.clone(),
                target,
                state,
                word: "",
                at_once: 0,
                failed: String::new(),
            });
        }
        Ok(Devices {
            node: node.name().to_owned(),
            told,
            owners,
            diagnostics: Arc::clone(diagnostics),
            key: PlainReportKey::default(),
            due: Tick::ZERO,
            last: Tick::ZERO,
            every: EVERY,
            from,
            pending: Vec::new(),
            tasks,
        })
    }

    /// Waits for a request; pass it to [`Devices::ask`]. Cancel safe.
    pub async fn next(&mut self) -> DeviceServiceRequest {
        match self.from.recv().await {
            Some(asked) => asked,
            // Every service has failed; see `is_failed`.
            None => std::future::pending().await,
        }
    }

    /// A service has ended; the middleware has failed.
    pub fn is_failed(&self) -> bool {
        self.tasks.iter().any(Forward::is_finished)
    }

    pub fn deadline(&self) -> Tick {
        self.due
    }

    /// Sets the period of full reports.
    pub fn report_every(&mut self, every: Duration) {
        self.every = every;
        self.due = self.due.min(self.last + every);
    }

    /// Takes what the buses report: news are published at once, answers passed on.
    pub fn bus_news(&mut self, news: &[News], buses: &mut Joined) {
        let quiet = |news: &News| matches!(news, News::InputsChanged { .. } | News::Answered);
        if !news.iter().all(quiet) {
            self.due = self.due.min(self.last + NEWS_EVERY);
        }
        // A device that boots is up again in a millisecond; a client that waits for the boot must see it.
        self.states(buses, STATES_MAX);
        self.answer(buses);
    }

    /// Publishes changed states, except of devices that change too often.
    fn states(&mut self, buses: &Joined, most: u32) {
        let mut at = 0;
        buses.states(&mut |name, word| {
            // They mostly come in the same order.
            let found = match self.told.get(at) {
                Some(told) if told.name == name => Some(at),
                _ => self.told.iter().position(|told| told.name == name),
            };
            let Some(found) = found else { return };
            at = found + 1;
            let told = &mut self.told[found];
            if told.word != word && told.at_once < most {
                told.word = word;
                told.at_once = told.at_once.saturating_add(1);
                told.state.send(Text::from(word));
            }
        });
    }

    /// Publishes what is due.
    pub fn act(&mut self, now: Tick, buses: &Joined) {
        if now < self.due {
            return;
        }
        self.states(buses, u32::MAX);
        let diagnoses = buses.diagnoses();
        let key: PlainReportKey = diagnoses.iter().map(Diagnosis::key).collect();
        let is_regular = self.last + self.every <= now;
        if self.key != key || is_regular {
            if is_regular {
                self.told.iter_mut().for_each(|told| told.at_once = 0);
            }
            self.key = key;
            self.last = now;
            let status = diagnoses.into_iter().map(|diagnosis| self.message(diagnosis)).collect();
            self.diagnostics.send(DiagnosticArray { header: stamp(), status });
        }
        self.due = self.last + self.every;
    }
}
