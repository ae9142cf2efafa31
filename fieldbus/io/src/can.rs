//! A CAN bus as a node sees it: a driver behind what every kind of field bus offers.

use linewright_canopen::codec::NmtState;
use linewright_canopen::manager::{DbcDeviceState, DeviceCondition, DeviceStatus};
use linewright_canopen::sdo::{Abort, ObjectId};
use linewright_canopen::{BusEvent, DeviceRequest, DeviceRequestError, Manager, ManagerError, NodeId};
use linewright_fieldbus_seam::{
    Answer, BusLost, BusRefusal, BusReply, BusRequest, BusTarget, Diagnosis, Fieldbus, InputImage, LastOrders, Level,
    NOT_HEARD, News, NextNews, ObjectAddress,
};
use linewright_line::{Canopen, Device, Owner, Timing};
use thiserror::Error;

use crate::bus::{Bus, BusError, BusOptions};
use crate::clock::Clock;
use crate::driver::Driver;
use crate::texts::RequestReply;

/// Why the bus of a node is not to be had.
#[derive(Debug, Error)]
pub enum BusOpenError {
    /// There is no such interface.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The devices cannot share a bus.
    #[error(transparent)]
    Manager(#[from] ManagerError),
}

/// The CAN bus of a node, with its manager at work.
pub struct CanFieldbus {
    driver: Driver,
    devices: Vec<Device>,
    pending: Vec<(u64, BusTarget, BusRequest)>,
    /// Number of requests answered at once. Their numbers begin far above the manager's.
    at_once: u64,
    answers: Vec<(u64, Answer)>,
}

/// Above every number of a request to the manager.
const AT_ONCE: u64 = 1 << 40;

impl CanFieldbus {
    /// Opens the bus of this name, with the manager of these devices. Nothing is sent yet.
    ///
    /// # Errors
    /// When there is no such bus, or the devices cannot share one.
    pub fn open(
        interface: &str,
        options: &BusOptions,
        devices: Vec<Device>,
        timing: Timing,
        clock: Clock,
    ) -> Result<Self, BusOpenError> {
        let manager = Manager::new(&devices, timing)?;
        let driver = Driver::new(Bus::open(interface, options)?, manager, clock);
        Ok(CanFieldbus { driver, devices, pending: Vec::new(), at_once: 0, answers: Vec::new() })
    }

    fn ask_at_once(&mut self, answer: Answer) -> u64 {
        self.at_once += 1;
        let number = AT_ONCE + self.at_once;
        self.answers.push((number, answer));
        number
    }

    fn device(&self, name: &str) -> Option<&Device> {
        self.devices.iter().find(|device| device.name == name)
    }

    fn diagnosis(&self, status: &DeviceStatus<'_>) -> Diagnosis {
        let (manager, now) = (self.driver.manager(), self.driver.now());
        let trouble = manager.trouble_of(now, status.node);
        let emergency = status.emergency.map_or_else(
            || "none".to_owned(),
            |(at, emergency)| format!("{} ({} s ago)", emergency.text(status.profile), now.since(at).as_secs()),
        );
        let state = state_word(status.nmt);
        Diagnosis {
            device: status.name.to_owned(),
            owner: status.owner,
            level: level(status, trouble.is_some()),
            message: trouble.or_else(|| manager.explain(now, status.node)).unwrap_or_default(),
            hardware_id: self.device(status.name).map(hardware_id).unwrap_or_default(),
            state: Some(state),
            error: status.emergency.map(|(_, emergency)| emergency.code),
            losses: status.losses,
            values: vec![
                ("node id", status.node.to_string()),
                ("state", state.to_owned()),
                ("last emergency", emergency),
                ("losses", status.losses.to_string()),
                ("frames ignored", status.ignored.to_string()),
            ],
        }
    }

    fn plain_diagnosis(&self, status: DbcDeviceState<'_>) -> Diagnosis {
        let frames = self.device(status.name).and_then(Device::frames);
        let file = frames.map(|frames| frames.file.name.clone()).unwrap_or_default();
        Diagnosis {
            device: status.name.to_owned(),
            owner: status.owner,
            level: match (status.live, status.received) {
                (true, _) => Level::Ok,
                (false, true) => Level::Error,
                (false, false) => Level::Stale,
            },
            message: status.is,
            hardware_id: format!("frames of {file}"),
            state: None,
            error: None,
            losses: status.losses,
            values: vec![("losses", status.losses.to_string())],
        }
    }
}

impl Fieldbus for CanFieldbus {
    fn describe(&self) -> String {
        self.driver.bus().describe()
    }

    fn next(&mut self) -> NextNews<'_> {
        Box::pin(async move {
            let events = self.driver.next().await.map_err(BusLost::new)?;
            Ok(events.into_iter().map(news).collect())
        })
    }

    fn inputs(&self, owner: Owner) -> Option<InputImage> {
        self.devices.iter().any(|device| device.owner == owner).then(|| self.driver.inputs(owner))
    }

    fn set_outputs(&mut self, owner: Owner, image: u128) {
        self.driver.set_outputs(owner, image);
    }

    fn release_outputs(&mut self) {
        self.driver.release_outputs();
    }

    fn last_orders(&self) -> LastOrders {
        let last = self.driver.last_frames();
        Box::new(move || _ = last.send())
    }

    fn trouble(&self, owner: Owner) -> Vec<String> {
        self.driver.manager().trouble(self.driver.now(), owner).collect()
    }

    fn diagnoses(&self) -> Vec<Diagnosis> {
        let manager = self.driver.manager();
        let canopen = manager.statuses().map(|status| self.diagnosis(&status));
        let plain = manager.plain_statuses(self.driver.now()).map(|status| self.plain_diagnosis(status));
        canopen.chain(plain).collect()
    }

    fn states(&self, take: &mut dyn FnMut(&str, &'static str)) {
        self.driver.manager().statuses().for_each(|status| take(status.name, state_word(status.nmt)));
    }

    fn ask(&mut self, target: &BusTarget, request: BusRequest) -> Option<u64> {
        let node = match target {
            BusTarget::Node(node) => *node,
            BusTarget::Device(name) => match self.device(name)?.node_id() {
                Some(node) => node,
                None => return Some(self.ask_at_once(Err(no_canopen(target, request)))),
            },
        };
        let described = self.devices.iter().any(|device| device.node_id() == Some(node));
        let id = NodeId::new(node).filter(|_| described)?;
        let ask = match request {
            BusRequest::Read(object) => DeviceRequest::Read(id_of(object)),
            BusRequest::Write { object, value, bytes } => DeviceRequest::Write { object: id_of(object), value, bytes },
            BusRequest::Reset => {
                self.driver.reset_node(id);
                let text = RequestReply::ResetOrdered.text().to_owned();
                return Some(self.ask_at_once(Ok(BusReply { value: Vec::new(), text })));
            }
            BusRequest::Start => {
                let started = self.driver.start_node(id);
                let done = |text| BusReply { value: Vec::new(), text };
                let answer = started.map(done).map_err(|text| BusRefusal { text, code: Abort::DEVICE_STATE.0 });
                return Some(self.ask_at_once(answer));
            }
        };
        let number = self.driver.ask(node, ask);
        self.pending.push((number, BusTarget::Node(node), request));
        Some(number)
    }

    fn take_answers(&mut self) -> Vec<(u64, Answer)> {
        let mut answers = std::mem::take(&mut self.answers);
        for (number, answer) in self.driver.take_answers() {
            let Some(at) = self.pending.iter().position(|pending| pending.0 == number) else { continue };
            let (_, target, request) = self.pending.swap_remove(at);
            let answer = answer.map(|value| BusReply { value, text: String::new() });
            answers.push((number, answer.map_err(|error| refusal(&target, request, &error))));
        }
        answers
    }
}

fn id_of(object: ObjectAddress) -> ObjectId {
    ObjectId::new(object.index, object.sub)
}

fn refusal(target: &BusTarget, request: BusRequest, error: &DeviceRequestError) -> BusRefusal {
    BusRefusal { text: format!("{target}, {request}: {error}"), code: error.abort().0 }
}

fn no_canopen(target: &BusTarget, request: BusRequest) -> BusRefusal {
    let text = format!("{target}, {request}: {}", RequestReply::NoCanopen.text());
    BusRefusal { text, code: Abort::NO_CONNECTION.0 }
}

fn news(event: BusEvent) -> News {
    match event {
        BusEvent::InputsChanged { owner } => News::InputsChanged { owner },
        BusEvent::Answered { .. } => News::Answered,
        BusEvent::Ignored { reason, frame } => News::Ignored(format!("frame {frame}: {reason}")),
        other => News::Noted(other.to_string()),
    }
}

/// As `ros2_canopen` writes it. A silent device has no state: the word for an unknown one.
fn state_word(state: Option<NmtState>) -> &'static str {
    match state {
        Some(NmtState::BootUp) => "BOOTUP",
        Some(NmtState::PreOperational) => "PREOP",
        Some(NmtState::Operational) => "START",
        Some(NmtState::Stopped) => "STOP",
        Some(NmtState::Unknown(_)) | None => NOT_HEARD,
    }
}

fn level(status: &DeviceStatus<'_>, trouble: bool) -> Level {
    let emergency = status.emergency.is_some_and(|(_, emergency)| emergency.code != 0);
    match status.condition {
        DeviceCondition::Absent => Level::Stale,
        DeviceCondition::Refused | DeviceCondition::Stopped => Level::Error,
        DeviceCondition::Booting => Level::Warn,
        DeviceCondition::Operational if trouble => Level::Error,
        DeviceCondition::Operational if emergency => Level::Warn,
        DeviceCondition::Operational => Level::Ok,
    }
}

/// Its identity as far as the description has it, and its bus and node id.
fn hardware_id(device: &Device) -> String {
    let Some(Canopen { node_id, setup }) = device.canopen() else { return String::new() };
    let identity = &setup.identity;
    let numbers = [("vendor", identity.vendor), ("product", identity.product), ("serial", identity.serial)];
    let known = numbers.iter().filter_map(|(what, number)| Some(format!(", {what} {:08X}h", (*number)?)));
    format!("CANopen node {node_id:02X}h{}", known.collect::<String>())
}
