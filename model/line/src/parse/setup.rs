//! A device's `identity` and `settings` → numbers and bytes.

use linewright_text::Located;

use super::raw::{RawDevice, RawIdentity, RawSetting, RawTransmission, Width};
use crate::{DeviceIdentity, DeviceSetup, ObjectWrite, Transmission};

/// An object as people write it, in hexadecimal: `6206:01`, `6206h:1`, `0x1029`; without a subindex it is 0.
pub(super) fn object(text: &str) -> Option<(u16, u8)> {
    let (index, sub) = text.split_once(':').unwrap_or((text, "0"));
    let hex = |digits: &str, most: usize| {
        let digits = digits.strip_prefix("0x").unwrap_or(digits);
        let digits = digits.strip_suffix('h').unwrap_or(digits);
        let plain = (1..=most).contains(&digits.len()) && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
        plain.then(|| u16::from_str_radix(digits, 16).ok())?
    };
    Some((hex(index, 4)?, u8::try_from(hex(sub, 2)?).ok()?))
}

impl Width {
    /// The least and the greatest number.
    pub fn limits(self) -> (i64, i64) {
        let bits = 8 * u32::from(self.bytes);
        if self.signed { (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) } else { (0, (1 << bits) - 1) }
    }

    /// The bytes of a number, least significant first; `None` if it does not fit.
    pub fn bytes_of(self, value: i64) -> Option<Vec<u8>> {
        let (least, most) = self.limits();
        (least..=most).contains(&value).then(|| value.to_le_bytes()[..usize::from(self.bytes)].to_vec())
    }
}

/// A part of an identity, if it can be one.
pub(super) fn part(value: i64) -> Option<u32> {
    u32::try_from(value).ok()
}

/// The setup a device describes; `None` if a part is missing.
pub(super) fn finish(raw: &RawDevice) -> Option<DeviceSetup> {
    let identity = raw.identity.as_ref().map_or(Some(DeviceIdentity::default()), identity)?;
    let settings = raw.settings.iter().map(setting).collect::<Option<_>>()?;
    let transmission = raw.transmission.as_ref().map_or(Some(Transmission::default()), types)?;
    Some(DeviceSetup {
        file: raw.file.as_ref().map(|file| file.value.clone()),
        identity,
        settings,
        without_error_values: raw.without_error_values.as_ref().map(|why| why.value.clone()),
        transmission,
        on_emergency: raw.on_emergency.as_ref().map(|reaction| reaction.value),
        when_lost: raw.when_lost.as_ref().map(|reaction| reaction.value).unwrap_or_default(),
    })
}

/// A transmission type, if it can be one. 0 is none here: inputs that are sent only when they have changed are never
/// made good when a frame is lost.
pub(super) fn transmission(value: i64) -> Option<u8> {
    u8::try_from(value).ok().filter(|kind| matches!(kind, 1..=240 | 254 | 255))
}

fn types(raw: &RawTransmission) -> Option<Transmission> {
    let kind = |number: &Option<Located<i64>>| match number {
        Some(number) => transmission(number.value).map(Some),
        None => Some(None),
    };
    Some(Transmission { inputs: kind(&raw.inputs)?, outputs: kind(&raw.outputs)? })
}

fn identity(raw: &RawIdentity) -> Option<DeviceIdentity> {
    let mut numbers = [None; 5];
    for (number, raw) in numbers.iter_mut().zip(raw.parts()) {
        *number = match raw {
            Some(raw) => Some(part(raw.value)?),
            None => None,
        };
    }
    let [device_type, vendor, product, revision, serial] = numbers;
    Some(DeviceIdentity { device_type, vendor, product, revision, serial })
}

pub(super) fn setting(raw: &RawSetting) -> Option<ObjectWrite> {
    let (index, sub) = object(&raw.object.as_ref()?.value)?;
    Some(ObjectWrite { index, sub, data: raw.width.bytes_of(raw.value.as_ref()?.value)? })
}
