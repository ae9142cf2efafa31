//! The texts of a bus's manager, and of bus scans, in lists. A new variant without a text, or without a place in the list, does not
//! compile.

use std::time::Duration;

use linewright_canopen::bus_scan::{ScannedState, state_name};
use linewright_canopen::codec::{Emergency, NmtState, Profile};
use linewright_canopen::manager::{
    BootError, BootStage, ChannelFault, DbcDeviceText, FrameFault, StartReply, WriteProtection,
};
use linewright_canopen::sdo::{Abort, ObjectId, TransferError, TransferFailure};
use linewright_canopen::{BusEvent, DeviceRequestError, Frame, IgnoreReason, ManagerError, NodeId};
use linewright_line::{FrameId, Owner, SignalError, StationId, Tick};
use linewright_testkit::samples::{listed, samples};

const OBJECT: ObjectId = ObjectId::new(0x1018, 1);
/// One by which outputs go off without a manager.
const ERROR_BEHAVIOUR: ObjectId = ObjectId::new(0x1029, 1);
const ERROR_REGISTER: ObjectId = ObjectId::new(0x1001, 0);
const SHORTED: Emergency = Emergency { code: 0x2320, register: 0x03, vendor: [0; 5] };

fn node() -> NodeId {
    NodeId::new(6).expect("a node id")
}

fn message() -> FrameId {
    FrameId { id: 0x18FE_F100, extended: true }
}

const fn ms(millis: u64) -> Duration {
    Duration::from_millis(millis)
}

fn frame() -> Frame {
    "186#07".parse().expect("a frame")
}

fn unanswered(object: ObjectId) -> TransferError {
    TransferError { object, cause: TransferFailure::Silent { waited: ms(50), done: 0, asked: 3 } }
}

fn events() -> Vec<BusEvent> {
    let (node, silent_for) = (node(), ms(250));
    samples!(BusEvent {
        BusEvent::DeviceUp { .. } => BusEvent::DeviceUp { node };
        BusEvent::DeviceLost { .. } => BusEvent::DeviceLost { node, silent_for };
        BusEvent::NoSync { .. } => BusEvent::NoSync { node, silent_for };
        BusEvent::ChannelFault { .. } => BusEvent::ChannelFault { node, fault: ChannelFault::Late { object: 2 } };
        BusEvent::FramesUp { .. } => BusEvent::FramesUp { id: message() };
        BusEvent::FramesLost { .. } => BusEvent::FramesLost { id: message(), silent_for, why: FrameFault::Silent };
        BusEvent::DeviceRebooted { .. } => BusEvent::DeviceRebooted { node };
        BusEvent::DeviceLeft { .. } => BusEvent::DeviceLeft { node, state: NmtState::Stopped };
        BusEvent::BootFailed { .. } => BusEvent::BootFailed { node, why: BootError::NoSync { times: 3 } };
        BusEvent::Emergency { .. } => BusEvent::Emergency { node, emergency: SHORTED, profile: Profile::Io };
        BusEvent::ErrorRegister { .. } => BusEvent::ErrorRegister { node, register: 0 },
            BusEvent::ErrorRegister { node, register: 0x05 };
        BusEvent::Babbles { .. } => BusEvent::Babbles { node };
        BusEvent::InputsChanged { .. } => BusEvent::InputsChanged { owner: Owner::Station(StationId(1)) },
            BusEvent::InputsChanged { owner: Owner::Console };
        BusEvent::Answered { .. } => BusEvent::Answered { number: 4 };
        BusEvent::AnotherManager => BusEvent::AnotherManager;
        BusEvent::AloneAgain => BusEvent::AloneAgain;
        BusEvent::BusError { .. } => BusEvent::BusError { class: 0x40 }, BusEvent::BusError { class: 0x100 },
            BusEvent::BusError { class: 0x4 };
        BusEvent::Ignored { .. } => BusEvent::Ignored { reason: IgnoreReason::ShortPdo, frame: frame() };
    })
}

fn boot_errors() -> Vec<BootError> {
    samples!(BootError {
        BootError::Identity { .. } => BootError::Identity { object: OBJECT, expected: 0x111, found: 0x222 };
        BootError::NotANumber { .. } => BootError::NotANumber { object: OBJECT, bytes: 2 };
        BootError::NotKept { .. } => BootError::NotKept { object: ERROR_BEHAVIOUR, written: 1, found: 0 };
        BootError::NotReadBack(_) => BootError::NotReadBack(unanswered(ERROR_BEHAVIOUR));
        BootError::NoSync { .. } => BootError::NoSync { times: 3 };
        BootError::Transfer { .. } => BootError::Transfer { writing: true, error: unanswered(ERROR_BEHAVIOUR) },
            BootError::Transfer { writing: false, error: unanswered(OBJECT) },
            BootError::Transfer { writing: false, error: unanswered(ERROR_REGISTER) };
    })
}

fn stages() -> Vec<BootStage> {
    let (object, of) = (OBJECT, 5);
    samples!(BootStage {
        BootStage::Identifying(_) => BootStage::Identifying(object);
        BootStage::Configuring { .. } => BootStage::Configuring { object, reads_back: false, number: 2, of },
            BootStage::Configuring { object, reads_back: true, number: 2, of };
        BootStage::AskingForErrors(_) => BootStage::AskingForErrors(ERROR_REGISTER);
    })
}

fn channel_faults() -> Vec<ChannelFault> {
    samples!(ChannelFault {
        ChannelFault::Number { .. } => ChannelFault::Number { channel: 2, number: i16::MAX },
            ChannelFault::Number { channel: 2, number: -8 };
        ChannelFault::Late { .. } => ChannelFault::Late { object: 2 };
    })
}

fn frame_faults() -> Vec<FrameFault> {
    samples!(FrameFault {
        FrameFault::Silent => FrameFault::Silent;
        FrameFault::Short => FrameFault::Short;
        FrameFault::Checksum => FrameFault::Checksum;
        FrameFault::Counter => FrameFault::Counter;
        FrameFault::Value(_) => FrameFault::Value(SignalError::Limits(8));
        FrameFault::Page => FrameFault::Page;
    })
}

fn dbc_states() -> Vec<DbcDeviceText<'static>> {
    let (message, id, why) = ("Level", message(), FrameFault::Counter);
    samples!(DbcDeviceText<'static> {
        DbcDeviceText::NotHeard => DbcDeviceText::NotHeard;
        DbcDeviceText::Live => DbcDeviceText::Live;
        DbcDeviceText::Missing { .. } => DbcDeviceText::Missing { message, id, since: Some(ms(300)), why },
            DbcDeviceText::Missing { message, id, since: None, why };
    })
}

fn refusals() -> Vec<DeviceRequestError> {
    samples!(DeviceRequestError {
        DeviceRequestError::UnknownNode { .. } => DeviceRequestError::UnknownNode { node: 9 };
        DeviceRequestError::Full => DeviceRequestError::Full;
        DeviceRequestError::NotReady(_) => DeviceRequestError::NotReady("is not started".to_owned());
        DeviceRequestError::Waited(_) => DeviceRequestError::Waited("is not started".to_owned());
        DeviceRequestError::Overtaken(_) => DeviceRequestError::Overtaken("is not started".to_owned());
        DeviceRequestError::Guarded { .. } =>
            DeviceRequestError::Guarded { object: OBJECT, why: WriteProtection::Communication };
        DeviceRequestError::TooLarge { .. } =>
            DeviceRequestError::TooLarge { object: OBJECT, value: 300, bytes: 1 };
        DeviceRequestError::Transfer(_) => DeviceRequestError::Transfer(unanswered(OBJECT));
    })
}

fn protections() -> Vec<WriteProtection> {
    samples!(WriteProtection {
        WriteProtection::Described => WriteProtection::Described;
        WriteProtection::Heartbeat => WriteProtection::Heartbeat;
        WriteProtection::Mapping => WriteProtection::Mapping;
        WriteProtection::Communication => WriteProtection::Communication;
        WriteProtection::Process => WriteProtection::Process;
        WriteProtection::Unknown => WriteProtection::Unknown;
    })
}

fn start_replies() -> Vec<StartReply> {
    samples!(StartReply {
        StartReply::Woken => StartReply::Woken;
        StartReply::LookedAtAgain => StartReply::LookedAtAgain;
    })
}

fn transfers() -> Vec<TransferFailure> {
    samples!(TransferFailure {
        TransferFailure::Refused(_) => TransferFailure::Refused(Abort::NO_OBJECT);
        TransferFailure::Silent { .. } => TransferFailure::Silent { waited: ms(50), done: 0, asked: 1 },
            TransferFailure::Silent { waited: ms(50), done: 0, asked: 3 },
            TransferFailure::Silent { waited: ms(50), done: 14, asked: 1 };
        TransferFailure::Toggle { .. } => TransferFailure::Toggle { done: 14 };
        TransferFailure::Sequence { .. } => TransferFailure::Sequence { number: 9 };
        TransferFailure::BlockSize { .. } => TransferFailure::BlockSize { size: 0 };
        TransferFailure::Crc { .. } => TransferFailure::Crc { sent: 0x1234, computed: 0x4321 };
        TransferFailure::Length { .. } => TransferFailure::Length { announced: 10, came: 9 };
        TransferFailure::TooLong { .. } => TransferFailure::TooLong { len_max: 1024 };
        TransferFailure::Command { .. } => TransferFailure::Command { command: 0x43, done: 7 };
        TransferFailure::Interrupted { .. } => TransferFailure::Interrupted { by: OBJECT };
        TransferFailure::Cancelled => TransferFailure::Cancelled;
    })
}

fn manager_errors() -> Vec<ManagerError> {
    let device = || "clamp".to_owned();
    samples!(ManagerError {
        ManagerError::NodeId { .. } => ManagerError::NodeId { device: device(), node: 127 };
        ManagerError::Duplicate { .. } =>
            ManagerError::Duplicate { first: device(), second: "drill".to_owned(), node: 6 };
        ManagerError::Unread { .. } => ManagerError::Unread { device: device(), file: "gauge.dbc".to_owned() };
        ManagerError::FrameId { .. } =>
            ManagerError::FrameId { device: device(), id: message(), other: "device `drill`".to_owned() };
        ManagerError::TooWide { .. } => ManagerError::TooWide { device: device(), bits: 65 };
    })
}

/// At one second.
fn scanned() -> Vec<ScannedState> {
    let at = Tick::from_millis;
    let silent =
        ScannedState { state: None, heartbeat: None, period: None, last: at(0), boots: 0, emergency: None, inputs: 0 };
    let beats = |state, heartbeat, period| ScannedState {
        state: Some(state),
        heartbeat: Some(at(heartbeat)),
        period,
        ..silent
    };
    vec![
        silent,
        ScannedState { emergency: Some((at(990), SHORTED)), ..silent },
        beats(NmtState::BootUp, 900, None),
        beats(NmtState::Stopped, 900, None),
        beats(NmtState::Operational, 960, Some(ms(50))),
        beats(NmtState::Operational, 800, Some(ms(50))),
    ]
}

fn nmt_states() -> Vec<NmtState> {
    samples!(NmtState {
        NmtState::BootUp => NmtState::BootUp;
        NmtState::Stopped => NmtState::Stopped;
        NmtState::Operational => NmtState::Operational;
        NmtState::PreOperational => NmtState::PreOperational;
        NmtState::Unknown(_) => NmtState::Unknown(0x22);
    })
}

#[test]
fn all_texts_of_a_bus_scan() {
    let lists = [
        listed("nodes, behind the node", &scanned(), |node| node.explain(Tick::from_millis(1000))),
        listed("states", &nmt_states(), |state| state_name(*state)),
    ];
    insta::assert_snapshot!(lists.join("\n"));
}

#[test]
fn all_texts_of_a_manager() {
    let lists = [
        listed("events", &events(), ToString::to_string),
        listed("ignored frames", &IgnoreReason::ALL, ToString::to_string),
        listed("faults of a channel", &channel_faults(), ToString::to_string),
        listed("faults of a DBC device's message", &frame_faults(), ToString::to_string),
        listed("states of a DBC device, behind its name", &dbc_states(), ToString::to_string),
        listed("why a device is not started, behind the device", &boot_errors(), ToString::to_string),
        listed("stages of a boot-up, behind the device", &stages(), ToString::to_string),
        listed("failed transfers", &transfers(), ToString::to_string),
        listed("refused requests", &refusals(), ToString::to_string),
        listed("protected objects, behind the object", &protections(), |why| why.text().to_owned()),
        listed("replies to a request to start", &start_replies(), |reply| reply.text("not started")),
        listed("descriptions without a manager", &manager_errors(), ToString::to_string),
    ];
    insta::assert_snapshot!(lists.join("\n"));
}
