//! A device: kind, bits, identity, settings, and the effect of its trouble.

use linewright_text::{
    KeyKind, KeyPresence, Located, LocatedName, Shape, flag, integer, keys, one_of, part, table, tables, text, texts,
    texts_by_name, word,
};

use super::{RawAnalogue, RawDrive, RawFrames, RawModbus};
use crate::Reaction;

/// Bits of one device each way: one PDO of 8 bytes (CiA 401's default mapping).
const DEVICE_BITS: usize = 64;
/// As many signals as one device can have, and more.
const COMMENTS_MAX: usize = 1000;
/// At most this many objects of one device that are written before it is started.
const SETTINGS_MAX: usize = 256;

/// Storage of a setting's number. Four bytes first: the default.
const WIDTHS: [(&str, Width); 6] = [
    ("u32", Width { bytes: 4, signed: false }),
    ("u8", Width { bytes: 1, signed: false }),
    ("u16", Width { bytes: 2, signed: false }),
    ("i8", Width { bytes: 1, signed: true }),
    ("i16", Width { bytes: 2, signed: true }),
    ("i32", Width { bytes: 4, signed: true }),
];

keys! {
    /// A device with digital and analogue inputs and outputs (CiA 401), a drive (CiA 402), or one described by a DBC file.
    pub(in crate::parse) struct RawDevice is "a device" {
        /// Names in the order of the bits of TPDO1, lowest bit of the first byte first; `""` is not connected. At most 64.
        inputs: Vec<LocatedName> = texts(DEVICE_BITS).entries(),
        /// Names in the order of the bits of RPDO1, lowest bit of the first byte first; `""` is not connected. At most 64.
        outputs: Vec<LocatedName> = texts(DEVICE_BITS).entries(),
        /// Comments on signals for people: `{ LS_open = "at the top, -B12" }`.
        comments: Vec<(LocatedName, LocatedName)> = texts_by_name(COMMENTS_MAX).or_default(),
        /// A device without CANopen, described by a DBC file; it then has none of the keys of CANopen.
        frames as "dbc": Option<RawFrames> = table(),
        /// Field bus of the device. `"modbus"` needs a `modbus` table; then all other keys but name, station, console, inputs and
        /// outputs are left out.
        kind: Option<Located<RawDeviceKind>> = one_of(&[("canopen", RawDeviceKind::Canopen), ("modbus", RawDeviceKind::Modbus)]),
        /// Address, registers and times of a device in Modbus TCP.
        modbus: Option<RawModbus> = table(),
        /// CANopen node id, 1 to 126, unique on its bus; 127 is the bus manager.
        node: Option<Located<i64>> = integer().required_unless(&["dbc", "modbus"]).from_to(1, 126),
        /// Its name, unique in the line.
        name: Option<LocatedName> = text().required(),
        /// Station whose signals it carries; required without `console`.
        station: Option<LocatedName> = text().missed(KeyPresence::Unless(&["console"])),
        /// `true` if it carries the main console's signals.
        console: Option<Located<bool>> = flag(),
        /// EDS or DCF of the device, by its path from this file; its identity and settings are added to those given
        /// here.
        file: Option<LocatedName> = text(),
        /// Expected answers in objects 1000h and 1018h; a device that answers otherwise is not started.
        identity: Option<RawIdentity> = table(),
        /// Objects written before it is started, in this order; at most 256.
        settings: Vec<RawSetting> = tables(SETTINGS_MAX),
        /// Reason, in words, why the device may have no error values for its outputs, or keep one on: what turns them
        /// off when the manager is gone.
        without_error_values: Option<LocatedName> = text(),
        /// Transmission types of its process data (CiA 301).
        transmission: Option<RawTransmission> = table(),
        /// Reaction to an emergency of the device; if left out `"fault"`, but `"report"` for a drive with a `fault`
        /// signal and for a device that may be lost.
        on_emergency: Option<Located<Reaction>> = reaction(),
        /// Reaction to the loss of the device. `"report"`: the device may be absent; only for one whose inputs decide
        /// nothing and whose outputs move nothing.
        when_lost: Option<Located<Reaction>> = reaction().usually(linewright_text::Usual::Word("fault")),
        /// The device is a drive; it then has no `inputs` and `outputs`.
        drive: Option<RawDrive> = table(),
        /// Its analogue channels.
        analogue: RawAnalogue = part(),
    }

    /// Identity of a device, objects 1000h and 1018h; each key is optional and a number from 0 to 0xFFFFFFFF.
    pub(in crate::parse) struct RawIdentity is "`identity`" {
        /// The device type, object 1000h.
        device_type as "type": Option<Located<i64>> = number_of_32_bits(),
        /// The vendor, object 1018h:01.
        vendor: Option<Located<i64>> = number_of_32_bits(),
        /// The product, object 1018h:02.
        product: Option<Located<i64>> = number_of_32_bits(),
        /// The revision, object 1018h:03; a newer minor revision (lower half) serves.
        revision: Option<Located<i64>> = number_of_32_bits(),
        /// The serial number, object 1018h:04.
        serial: Option<Located<i64>> = number_of_32_bits(),
    }

    /// Transmission types of process data: 1 to 240 for that number of SYNCs, 254 or 255 for at once.
    pub(in crate::parse) struct RawTransmission is "`transmission`" {
        /// Of its inputs.
        inputs: Option<Located<i64>> = transmission(),
        /// Of its outputs; with SYNC only if the inputs are.
        outputs: Option<Located<i64>> = transmission(),
    }

    /// An object that is written before the device is started.
    pub(in crate::parse) struct RawSetting is "a setting" {
        /// Index and subindex in hexadecimal: `"6206:01"`.
        object: Option<LocatedName> = text().required().like(|| Shape::Like(OBJECT)),
        /// Number of bits of the value, and whether it has a sign.
        width as "type": Width = word(&WIDTHS),
        /// Value to write, within the range of `type`.
        value: Option<Located<i64>> = integer().required().from_to(i32::MIN.into(), u32::MAX.into()),
    }
}

/// An object as people write it: `6206:01`, `6206h:1`, `0x1029`.
const OBJECT: &str = "^(0x)?[0-9A-Fa-f]{1,4}h?(:(0x)?[0-9A-Fa-f]{1,2}h?)?$";

/// Field bus of a device, where its `kind` gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::parse) enum RawDeviceKind {
    Canopen,
    Modbus,
}

/// Number of bytes of a number, and whether it has a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::parse) struct Width {
    pub bytes: u8,
    pub signed: bool,
}

impl RawIdentity {
    /// Device type, vendor, product, revision, serial.
    pub fn parts(&self) -> [Option<&Located<i64>>; 5] {
        [&self.device_type, &self.vendor, &self.product, &self.revision, &self.serial].map(Option::as_ref)
    }
}

fn number_of_32_bits() -> KeyKind<Option<Located<i64>>> {
    integer().from_to(0, u32::MAX.into())
}

fn transmission() -> KeyKind<Option<Located<i64>>> {
    integer().like(|| Shape::Either(vec![Shape::Whole(1, 240), Shape::Whole(254, 255)]))
}

/// Effect of trouble on the owner.
fn reaction() -> KeyKind<Option<Located<Reaction>>> {
    one_of(&[("fault", Reaction::Fault), ("report", Reaction::Report)])
}
