//! A device: the bits it carries, its protocol, its identity, and its settings before it is started.
//!
//! Numbers and bytes only. Their source, the description or a device's own file (EDS, DCF), is no matter here; the
//! effect of an object is in the device's manual.

use crate::{Analogue, DeviceBus, Drive, FrameTable, InputId, Line, Modbus, OutputId, StationId};

/// A device of an owner.
#[derive(Clone, Debug, PartialEq)]
pub struct Device {
    /// Name, unique in the line.
    pub name: String,
    /// Owner of the image it carries.
    pub owner: Owner,
    /// The bus it hangs on.
    pub bus: DeviceBus,
    /// Its protocol, and its bits.
    pub kind: DeviceKind,
}

/// Kind of device, with its address and its settings.
#[derive(Clone, Debug, PartialEq)]
pub enum DeviceKind {
    /// Inputs and outputs in CANopen (CiA 401).
    Io(Canopen, Io),
    /// A drive in CANopen (CiA 402).
    Drive(Canopen, Drive),
    /// Plain CAN frames, as a DBC file describes them.
    Frames(FrameTable),
    /// Inputs and outputs in Modbus TCP.
    Modbus(Modbus),
}

impl DeviceKind {
    /// An I/O device in CANopen with these bits, and nothing else given.
    pub fn io(node_id: u8, inputs: Vec<Option<InputId>>, outputs: Vec<Option<OutputId>>) -> Self {
        let canopen = Canopen { node_id, setup: DeviceSetup::default() };
        DeviceKind::Io(canopen, Io { inputs, outputs, analogue: Analogue::default() })
    }
}

/// A device in CANopen.
#[derive(Clone, Debug, PartialEq)]
pub struct Canopen {
    /// Its node id, 1 to 126, unique on its bus.
    pub node_id: u8,
    /// Its identity, and its settings before it is started.
    pub setup: DeviceSetup,
}

/// Inputs and outputs in the default mapping of CiA 401: one PDO of up to 64 bits each way, and three of four analogue
/// channels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Io {
    /// For each bit of its input PDO (TPDO1, 0x180 + id), the input of its owner's image it carries.
    pub inputs: Vec<Option<InputId>>,
    /// For each bit of its output PDO (RPDO1, 0x200 + id), the output of its owner's image it carries.
    pub outputs: Vec<Option<OutputId>>,
    /// Its analogue channels.
    pub analogue: Analogue,
}

/// Owner of the process image that a device carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Owner {
    /// A station's.
    Station(StationId),
    /// The main console's, which the coordinator reads itself.
    Console,
}

/// Identity that a device must have. `None` is not compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct DeviceIdentity {
    /// Object 1000h: the profile in the lower half.
    pub device_type: Option<u32>,
    /// Object 1018h sub 1.
    pub vendor: Option<u32>,
    /// Object 1018h sub 2.
    pub product: Option<u32>,
    /// Object 1018h sub 3. The lower half, the minor revision, may be newer: it does not change the CANopen behaviour
    /// (CiA 301 §7.5.2.19).
    pub revision: Option<u32>,
    /// Object 1018h sub 4.
    pub serial: Option<u32>,
}

/// One object that is written before the device is started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObjectWrite {
    /// Index.
    pub index: u16,
    /// Subindex.
    pub sub: u8,
    /// The bytes, least significant first, as SDO carries them.
    pub data: Vec<u8>,
}

/// Transmission types of a device's first process data objects (CiA 301 §7.5.2.35): 1 to 240 with every so many SYNCs,
/// 254 and 255 by event. `None`: as the device has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Transmission {
    /// Of its inputs, object 1800h sub 2.
    pub inputs: Option<u8>,
    /// Of its outputs, object 1400h sub 2. Those of a type up to 240 take effect with the next SYNC.
    pub outputs: Option<u8>,
}

impl Transmission {
    /// With every how many SYNCs inputs come, if they come with SYNC.
    pub fn inputs_every(self) -> Option<u8> {
        self.inputs.filter(|kind| is_synchronous(*kind))
    }

    /// Whether anything waits for SYNC.
    pub fn is_synchronous(self) -> bool {
        [self.inputs, self.outputs].into_iter().flatten().any(is_synchronous)
    }
}

/// Whether process data of this transmission type wait for SYNC (CiA 301 §7.5.2.35).
pub(crate) fn is_synchronous(kind: u8) -> bool {
    kind <= 240
}

/// Whether the manager writes this object itself, whatever else is given: the supervision between it and the devices.
pub fn is_the_managers(index: u16) -> bool {
    matches!(index, 0x1016 | 0x1017)
}

/// The bits of a byte of outputs that something is wired to.
pub fn wired_bits<T>(byte: &[Option<T>]) -> u8 {
    byte.iter().enumerate().filter(|(_, output)| output.is_some()).fold(0, |mask, (bit, _)| mask | 1 << bit)
}

/// Whether a device with this setting would not turn off one of these outputs by itself when its manager is gone: it stays
/// as it is or goes on (CiA 401 6206h, 6207h), or the loss has no effect (CiA 301 1029h).
pub fn keeps_an_output<T>(outputs: &[Option<T>], setting: &ObjectWrite) -> bool {
    let value = setting.data.first().copied().unwrap_or(0);
    let byte = usize::from(setting.sub).checked_sub(1).and_then(|nth| outputs.chunks(8).nth(nth)).unwrap_or(&[]);
    let wired = wired_bits(byte);
    match (setting.index, setting.sub) {
        (0x1029, 1) => value == 1,
        (0x6206, _) => value & wired != wired,
        (0x6207, _) => value & wired != 0,
        _ => false,
    }
}

/// Effect of trouble with a device on its owner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Reaction {
    /// Its owner's inputs are invalid until it is over, and every output of the owner is off.
    #[default]
    Fault,
    /// It is reported, and nothing else.
    Report,
}

/// Identity and settings of a device, and the effect of its trouble.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceSetup {
    /// Its EDS or DCF, by its path from the description's directory. The reader of the description reads it too, and
    /// adds its contents to the rest.
    pub file: Option<String>,
    /// Identity that it must have.
    pub identity: DeviceIdentity,
    /// Settings to be written, in this order.
    pub settings: Vec<ObjectWrite>,
    /// Reason why it may be without error values for its outputs (objects 1029h, 6206h, 6207h, 6443h, 6444h): what else
    /// turns them off when the manager is gone. `None`: it may not.
    pub without_error_values: Option<String>,
    /// Times at which its process data are sent and taken.
    pub transmission: Transmission,
    /// Effect of an emergency of the device on its owner; `None` where the description leaves it open, see
    /// [`Device::on_emergency`].
    pub on_emergency: Option<Reaction>,
    /// Effect of its loss on its owner. [`Reaction::Report`] only for a device nothing depends on: a rule of the
    /// description checks that.
    pub when_lost: Reaction,
}

impl Device {
    /// Its CANopen part, if it has one.
    pub fn canopen(&self) -> Option<&Canopen> {
        match &self.kind {
            DeviceKind::Io(canopen, _) | DeviceKind::Drive(canopen, _) => Some(canopen),
            DeviceKind::Frames(_) | DeviceKind::Modbus(_) => None,
        }
    }

    /// Its CANopen settings, to be completed from files.
    pub fn canopen_mut(&mut self) -> Option<&mut Canopen> {
        match &mut self.kind {
            DeviceKind::Io(canopen, _) | DeviceKind::Drive(canopen, _) => Some(canopen),
            DeviceKind::Frames(_) | DeviceKind::Modbus(_) => None,
        }
    }

    /// Its node id, if it is a CANopen device.
    pub fn node_id(&self) -> Option<u8> {
        self.canopen().map(|canopen| canopen.node_id)
    }

    /// Its inputs and outputs, if it is an I/O device in CANopen.
    pub fn io(&self) -> Option<&Io> {
        match &self.kind {
            DeviceKind::Io(_, io) => Some(io),
            _ => None,
        }
    }

    /// Its inputs and outputs, to be changed.
    pub fn io_mut(&mut self) -> Option<&mut Io> {
        match &mut self.kind {
            DeviceKind::Io(_, io) => Some(io),
            _ => None,
        }
    }

    /// The drive, if it is one.
    pub fn drive(&self) -> Option<&Drive> {
        match &self.kind {
            DeviceKind::Drive(_, drive) => Some(drive),
            _ => None,
        }
    }

    /// Its frames, if it is a device of plain CAN.
    pub fn frames(&self) -> Option<&FrameTable> {
        match &self.kind {
            DeviceKind::Frames(frames) => Some(frames),
            _ => None,
        }
    }

    /// Its registers, if it is a Modbus device.
    pub fn modbus(&self) -> Option<&Modbus> {
        match &self.kind {
            DeviceKind::Modbus(modbus) => Some(modbus),
            _ => None,
        }
    }

    /// Whether it hangs on a CAN bus.
    pub fn is_on_can(&self) -> bool {
        match self.kind {
            DeviceKind::Io(..) | DeviceKind::Drive(..) | DeviceKind::Frames(_) => true,
            DeviceKind::Modbus(_) => false,
        }
    }

    /// For each of its digital inputs, the input of its owner's image; none of a device without such bits.
    pub fn input_bits(&self) -> &[Option<InputId>] {
        match &self.kind {
            DeviceKind::Io(_, io) => &io.inputs,
            DeviceKind::Modbus(modbus) => &modbus.inputs,
            DeviceKind::Drive(..) | DeviceKind::Frames(_) => &[],
        }
    }

    /// For each of its digital outputs, the output of its owner's image; none of a device without such bits.
    pub fn output_bits(&self) -> &[Option<OutputId>] {
        match &self.kind {
            DeviceKind::Io(_, io) => &io.outputs,
            DeviceKind::Modbus(modbus) => &modbus.outputs,
            DeviceKind::Drive(..) | DeviceKind::Frames(_) => &[],
        }
    }

    /// Every input of its owner's image it carries: its bits' and its channels', its drive's, or its frames'.
    pub fn carried_inputs(&self) -> Vec<InputId> {
        match &self.kind {
            DeviceKind::Io(_, io) => io.inputs.iter().flatten().copied().chain(io.analogue.carried_inputs()).collect(),
            DeviceKind::Drive(_, drive) => drive.inputs().collect(),
            DeviceKind::Frames(frames) => frames.inputs().collect(),
            DeviceKind::Modbus(modbus) => modbus.inputs.iter().flatten().copied().collect(),
        }
    }

    /// Every output of its owner's image it carries.
    pub fn carried_outputs(&self) -> Vec<OutputId> {
        match &self.kind {
            DeviceKind::Io(_, io) => {
                io.outputs.iter().flatten().copied().chain(io.analogue.carried_outputs()).collect()
            }
            DeviceKind::Drive(_, drive) => drive.outputs().collect(),
            DeviceKind::Frames(frames) => frames.outputs().collect(),
            DeviceKind::Modbus(modbus) => modbus.outputs.iter().flatten().copied().collect(),
        }
    }

    /// Effect of an emergency of the device on its owner.
    ///
    /// Usually a fault: of a device in error, neither inputs nor outputs can be relied on. Two kinds are excepted unless
    /// the description includes them. A drive with a fault signal reports to its station by that signal, which stops the
    /// operation under way and no other. And of a device whose loss does not matter, its emergency matters less.
    pub fn on_emergency(&self) -> Reaction {
        let Some(Canopen { setup, .. }) = self.canopen() else { return Reaction::Fault };
        let tells_itself = self.drive().is_some_and(|drive| drive.fault.is_some());
        let usual = if tells_itself { Reaction::Report } else { setup.when_lost };
        setup.on_emergency.unwrap_or(usual)
    }
}

impl Line {
    /// The devices on the bus that is reached over this CAN interface: a station's own bus of that name, else the
    /// coordinator's, which a description gives no name.
    pub fn devices_on(&self, interface: &str) -> impl Iterator<Item = &Device> {
        let own = DeviceBus::Own(interface.to_owned());
        let bus = if self.devices.iter().any(|device| device.bus == own) { own } else { DeviceBus::Line };
        self.devices.iter().filter(move |device| device.bus == bus)
    }
}
