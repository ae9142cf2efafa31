//! Identity of a device: object 1018h, and the same numbers in `[DeviceInfo]`.

use std::collections::BTreeMap;

use linewright_diagnostics::Report;

use crate::info::DeviceInfo;
use crate::ini::Document;
use crate::model::Object;
use crate::reader::{SectionReader, Weight};
use crate::value::NodeId;
use crate::{Commissioning, Eds};

/// Identity that a device of this description answers. What the description leaves open, or calls 0, is `None`: there
/// is nothing to compare (as in objects 1F84h to 1F88h of CiA 302).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct EdsIdentity {
    /// Object 1000h.
    pub device_type: Option<u32>,
    /// Object 1018h sub 1.
    pub vendor: Option<u32>,
    /// Object 1018h sub 2.
    pub product: Option<u32>,
    /// Object 1018h sub 3.
    pub revision: Option<u32>,
    /// Object 1018h sub 4, or the LSS_SerialNumber of a DCF.
    pub serial: Option<u32>,
}

impl Eds {
    /// Identity of a device of this description. Object 1018h counts first, then `[DeviceInfo]`.
    pub fn identity(&self) -> EdsIdentity {
        let node = self.node_id().unwrap_or(NodeId::FIRST);
        let stated = |index, sub| stated(&self.objects, index, sub, node);
        let device = &self.device;
        let serial = self.commissioning.as_ref().and_then(|Commissioning { serial_number, .. }| *serial_number);
        EdsIdentity {
            device_type: stated(0x1000, 0),
            vendor: stated(0x1018, 1).or(device.vendor_number.filter(|number| *number > 0)),
            product: stated(0x1018, 2).or(device.product_number.filter(|number| *number > 0)),
            revision: stated(0x1018, 3).or(device.revision_number.filter(|number| *number > 0)),
            serial: stated(0x1018, 4).or(serial.filter(|number| *number > 0)),
        }
    }
}

fn stated(objects: &BTreeMap<u16, Object>, index: u16, sub: u8, node: NodeId) -> Option<u32> {
    let value = objects.get(&index)?.entry(sub)?.effective(node)?.as_u64()?;
    u32::try_from(value).ok().filter(|number| *number > 0)
}

/// Checks that the same number in two places is the same.
pub(crate) fn check(
    device: &DeviceInfo,
    objects: &BTreeMap<u16, Object>,
    document: &Document,
    node: NodeId,
    report: &mut Report,
) {
    let both = [
        (1, "VendorNumber", device.vendor_number),
        (2, "ProductNumber", device.product_number),
        (3, "RevisionNumber", device.revision_number),
    ];
    for (sub, key, number) in both {
        let Some(number) = number.filter(|number| *number > 0) else { continue };
        let Some(object) = stated(objects, 0x1018, sub, node).filter(|object| *object != number) else { continue };
        let section = document.sections().find(|section| section.name().eq_ignore_ascii_case("DeviceInfo"));
        let Some(section) = section else { continue };
        let mut reader = SectionReader::new(section, report);
        if let Some((key, _)) = reader.key(key) {
            let message = format!("0x{number:X} here, 0x{object:X} in object 1018h sub {sub}, which counts");
            reader.say(key, Weight::Warning, message, "find out which of them the device answers");
        }
    }
}
