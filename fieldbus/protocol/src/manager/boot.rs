//! Boot-up procedure of one device: identification and configuration, before it may be started.
//!
//! As in the boot process of CiA 302-2: the device type and the identity are read and compared with what is expected;
//! only then are objects written, in the order given, and those read back on which safety rests (`on_error.rs`); only
//! when all are as required may the device be started. Last, object 1001h is read: a standing error is reported before
//! the owner relies on the device. A device with another identity than described is not written to.
//!
//! Every step is one SDO transfer, so a boot always waits for exactly one object. Heartbeats and other devices are not
//! handled here: all devices boot side by side, and one that does not answer delays none.

use std::time::Duration;

use linewright_line::{DeviceIdentity, DeviceSetup, Tick, Timing};

use super::MANAGER_NODE;
use super::errors::ERROR_REGISTER;
use super::on_error::judged;
use super::process::ProcessData;
use super::transfer::Transfer;
use crate::codec::NodeId;
use crate::frame::Frame;
use crate::sdo::wire::SdoBytes;
use crate::sdo::{Abort, ObjectId, SdoWrite, TransferError, TransferFailure, TransferProgress};

/// Required identity and settings of a device before it is started.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct BootPlan {
    /// Required identity.
    pub identity: DeviceIdentity,
    /// Objects to write, in this order.
    pub settings: Vec<SdoWrite>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BootError {
    /// It is another device.
    Identity {
        object: ObjectId,
        /// Expected value.
        expected: u32,
        /// Value that the device reports.
        found: u32,
    },
    NotANumber {
        object: ObjectId,
        /// Its bytes; a number has four.
        bytes: usize,
    },
    /// It has taken a setting, and gives back something else.
    NotKept {
        object: ObjectId,
        /// Written value, as a number.
        written: u32,
        found: u32,
    },
    /// The device does not report whether it has kept a setting.
    NotReadBack(TransferError),
    /// The identity is right, but the device loses SYNC, which its outputs wait for.
    NoSync { times: u32 },
    Transfer {
        /// It was to be written; otherwise read.
        writing: bool,
        error: TransferError,
    },
}

/// How far a boot is: the object it waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BootStage {
    Identifying(ObjectId),
    Configuring {
        object: ObjectId,
        /// It is read back; otherwise written.
        reads_back: bool,
        /// Number of the setting, from 1.
        number: usize,
        /// Number of settings in all.
        of: usize,
    },
    /// Configured; whether an error stands is read.
    AskingForErrors(ObjectId),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BootStep {
    Busy,
    /// Everything is as it has to be. With the error register, from a device that has one.
    Done(Option<u8>),
    Failed(BootError),
}

/// One device being brought up.
#[derive(Debug)]
pub(super) struct Boot {
    node: NodeId,
    /// Number of transfers done: first the reads, then the writes.
    at: usize,
    /// The last setting is being read back.
    reads_back: bool,
    transfer: Transfer,
}

/// Present in every device and read first: its answer also shows that a device is there.
pub(super) const DEVICE_TYPE: ObjectId = ObjectId::new(0x1000, 0);

/// Objects to read, in order; after the device type, only those that are compared.
const READ: [ObjectId; 5] = [
    DEVICE_TYPE,
    ObjectId::new(0x1018, 1),
    ObjectId::new(0x1018, 2),
    ObjectId::new(0x1018, 3),
    ObjectId::new(0x1018, 4),
];

fn expected(identity: &DeviceIdentity, nth: usize) -> Option<u32> {
    let DeviceIdentity { device_type, vendor, product, revision, serial } = *identity;
    [device_type, vendor, product, revision, serial][nth]
}

fn compare(identity: &DeviceIdentity, nth: usize, bytes: &[u8]) -> Result<(), BootError> {
    let object = READ[nth];
    let Some(expected) = expected(identity, nth) else { return Ok(()) };
    let number = bytes.try_into().map_err(|_| BootError::NotANumber { object, bytes: bytes.len() })?;
    let found = u32::from_le_bytes(number);
    let same = match nth {
        // The major revision must be the same, the minor one at least the expected.
        3 => found >> 16 == expected >> 16 && found & 0xFFFF >= expected & 0xFFFF,
        _ => found == expected,
    };
    if same { Ok(()) } else { Err(BootError::Identity { object, expected, found }) }
}

/// Result of reading a setting back.
fn read_back(setting: &SdoWrite, result: Result<Vec<u8>, TransferError>) -> Result<(), BootError> {
    let number = |bytes: &[u8]| bytes.iter().take(4).rev().fold(0, |all, byte| all << 8 | u32::from(*byte));
    match result {
        Ok(bytes) if setting.excused || setting.is_kept(&bytes) => Ok(()),
        Ok(bytes) => {
            let (written, found) = (number(&setting.data), number(&bytes));
            Err(BootError::NotKept { object: setting.object, written, found })
        }
        Err(TransferError { cause: TransferFailure::Refused(code), .. }) if setting.may_be_refused(code) => Ok(()),
        Err(error) => Err(BootError::NotReadBack(error)),
    }
}

impl Boot {
    /// Begins by reading the device type.
    pub fn start(now: Tick, node: NodeId, out: &mut Vec<Frame>) -> Self {
        Boot { node, at: 0, reads_back: false, transfer: Transfer::read(now, node, DEVICE_TYPE, out) }
    }

    /// Takes eight bytes of the device's SDO server.
    pub fn handle(&mut self, now: Tick, plan: &BootPlan, raw: &SdoBytes, out: &mut Vec<Frame>) -> BootStep {
        let progress = self.transfer.handle(now, raw, out);
        self.go_on(now, plan, progress, out)
    }

    pub fn poll(&mut self, now: Tick, plan: &BootPlan, out: &mut Vec<Frame>) -> BootStep {
        let progress = self.transfer.poll(now, out);
        self.go_on(now, plan, progress, out)
    }

    pub fn transfer(&self) -> &Transfer {
        &self.transfer
    }

    pub fn transfer_mut(&mut self) -> &mut Transfer {
        &mut self.transfer
    }

    pub fn deadline(&self) -> Tick {
        self.transfer.deadline()
    }

    /// What it waits for.
    pub fn stage(&self, plan: &BootPlan) -> BootStage {
        let object = self.transfer.object();
        match self.at.checked_sub(READ.len()) {
            None => BootStage::Identifying(object),
            Some(nth) if nth == plan.settings.len() => BootStage::AskingForErrors(object),
            Some(nth) => {
                BootStage::Configuring { object, reads_back: self.reads_back, number: nth + 1, of: plan.settings.len() }
            }
        }
    }

    fn go_on(&mut self, now: Tick, plan: &BootPlan, progress: TransferProgress, out: &mut Vec<Frame>) -> BootStep {
        match progress {
            TransferProgress::Busy => BootStep::Busy,
            TransferProgress::Done(result) if self.at == READ.len() + plan.settings.len() => match result {
                Ok(bytes) => BootStep::Done(bytes.first().copied()),
                // Every device should have one (CiA 301 §7.5.2.2); a device without it reports no errors there.
                Err(TransferError { cause: TransferFailure::Refused(_), .. }) => BootStep::Done(None),
                Err(error) => BootStep::Failed(BootError::Transfer { writing: false, error }),
            },
            TransferProgress::Done(result) => match self.setting(plan) {
                None => match result {
                    Ok(bytes) => self.done(now, plan, &bytes, out),
                    Err(error) => BootStep::Failed(BootError::Transfer { writing: false, error }),
                },
                Some(setting) if self.reads_back => match read_back(setting, result) {
                    Ok(()) => self.done(now, plan, &[], out),
                    Err(why) => BootStep::Failed(why),
                },
                Some(setting) => self.written(now, plan, setting, result.err(), out),
            },
        }
    }

    /// The setting that is being written or read back.
    fn setting<'a>(&self, plan: &'a BootPlan) -> Option<&'a SdoWrite> {
        self.at.checked_sub(READ.len()).and_then(|nth| plan.settings.get(nth))
    }

    /// A setting is written, or not.
    fn written(
        &mut self,
        now: Tick,
        plan: &BootPlan,
        setting: &SdoWrite,
        error: Option<TransferError>,
        out: &mut Vec<Frame>,
    ) -> BootStep {
        match error.map(|error| (error, error.cause)) {
            // One that cannot be changed may be as it has to be.
            None | Some((_, TransferFailure::Refused(Abort::READ_ONLY))) if setting.compared.is_some() => {
                self.reads_back = true;
                self.transfer = Transfer::read(now, self.node, setting.object, out);
                BootStep::Busy
            }
            None => self.done(now, plan, &[], out),
            Some((_, TransferFailure::Refused(code))) if setting.may_be_refused(code) => self.done(now, plan, &[], out),
            Some((error, _)) => BootStep::Failed(BootError::Transfer { writing: true, error }),
        }
    }

    /// One transfer is done; the next begins.
    fn done(&mut self, now: Tick, plan: &BootPlan, bytes: &[u8], out: &mut Vec<Frame>) -> BootStep {
        if self.at < READ.len()
            && let Err(error) = compare(&plan.identity, self.at, bytes)
        {
            return BootStep::Failed(error);
        }
        self.at += 1;
        self.reads_back = false;
        // Objects that are not compared may be absent.
        while self.at < READ.len() && expected(&plan.identity, self.at).is_none() {
            self.at += 1;
        }
        self.transfer = match (READ.get(self.at), plan.settings.get(self.at.saturating_sub(READ.len()))) {
            (Some(object), _) => Transfer::read(now, self.node, *object, out),
            (None, Some(setting)) => Transfer::write(now, self.node, setting, out),
            (None, None) => Transfer::read(now, self.node, ERROR_REGISTER, out),
        };
        BootStep::Busy
    }
}

/// Required identity of a device, and all its settings before it is started.
pub(super) fn plan(node: NodeId, setup: &DeviceSetup, process: &ProcessData, timing: &Timing) -> BootPlan {
    let millis = |span: Duration| u16::try_from(span.as_millis()).unwrap_or(u16::MAX);
    // Object 1017h, producer heartbeat time in ms.
    let produce = SdoWrite::new(0x1017, 0, millis(timing.heartbeat).to_le_bytes());
    // Object 1016h sub 1, consumer heartbeat time: node id in bits 16 to 23, ms below. It makes outputs safe when the
    // manager is gone, so a device with outputs must accept it; others may lack the object.
    let watched = u32::from(MANAGER_NODE.get()) << 16 | u32::from(millis(timing.heartbeat_timeout));
    let consume = process.has_outputs().then(|| SdoWrite::new(0x1016, 1, watched.to_le_bytes()));
    // The description's settings come first: those on which the safety of a drive rests come after them, and stay.
    let described = setup.settings.iter().map(|own| SdoWrite::new(own.index, own.sub, own.data.clone()));
    let described = described.chain(super::sync::settings(setup, timing));
    let settings = described.chain([produce]).chain(consume).chain(process.settings(node, &setup.settings));
    BootPlan { identity: setup.identity, settings: judged(setup, settings) }
}
