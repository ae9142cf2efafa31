//! Writes of a configuration into a device, in an order the device accepts.
//!
//! By index, with three exceptions. A PDO is switched off while it is changed, and its mapping has no elements while
//! they are written (CiA 301 §7.5.2.36 and §7.5.2.38); PDOs come last, because what they map may come to be only by
//! other objects. The date of the configuration (1020h) is written when all is there, and storing (1010h) behind that.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use crate::Eds;
use crate::model::SubObject;
use crate::value::{NodeId, ObjectValue};

/// Contents of a write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DownloadContent {
    /// These bytes.
    Bytes(Vec<u8>),
    /// The content of the file with this name (DownloadFile).
    File(String),
}

/// Reason of a write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteReason {
    /// By the file.
    Value,
    /// The PDO is off while it is changed.
    SwitchOff,
    /// The mapping has no elements while they are written.
    ClearMapping,
    /// The PDO or its mapping is again what it was before.
    Restore,
}

/// One SDO download of a configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Download {
    /// Index of the object.
    pub index: u16,
    /// Its subindex.
    pub sub: u8,
    pub content: DownloadContent,
    pub reason: WriteReason,
    /// The line of the entry's section in the file.
    pub line: u32,
}

impl fmt::Display for Download {
    /// As in `1A00h sub 1: 08 01 00 60`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", address(self.index, self.sub))?;
        match &self.content {
            DownloadContent::Bytes(bytes) => ObjectValue::Bytes(bytes.clone()).fmt(f)?,
            DownloadContent::File(name) => write!(f, "the file {name}")?,
        }
        f.write_str(match self.reason {
            WriteReason::Value => "",
            WriteReason::SwitchOff => " (switched off)",
            WriteReason::ClearMapping => " (no mapping)",
            WriteReason::Restore => " (as before)",
        })
    }
}

/// Index and subindex as people write them.
pub(crate) fn address(index: u16, sub: u8) -> String {
    if sub == 0 { format!("{index:04X}h") } else { format!("{index:04X}h sub {sub}") }
}

/// Reason why a description is no configuration for a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DownloadError {
    pub file: NodeId,
    /// The node requested.
    pub asked: NodeId,
}

impl fmt::Display for DownloadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the file is for node {}, not for node {}; correct NodeID in its [DeviceComissioning]",
            self.file, self.asked
        )
    }
}

impl std::error::Error for DownloadError {}

/// Values of the file for one entry.
type WantedEntry = BTreeMap<(u16, u8), Download>;

/// The bit of a COB-ID of a PDO that does not exist.
const INVALID: u64 = 1 << 31;
/// From the communication parameters of a PDO to its mapping.
const TO_MAPPING: u16 = 0x200;

impl Eds {
    /// Writes of this file to a device with this node id, in their order. Nothing for an EDS, which has no parameter
    /// values; entries that cannot be written, or whose ObjFlags forbid it, are left out: tools note there what they
    /// have read.
    ///
    /// # Errors
    /// The file is for another node.
    pub fn downloads(&self, node: NodeId) -> Result<Vec<Download>, DownloadError> {
        if let Some(file) = self.node_id().filter(|file| *file != node) {
            return Err(DownloadError { file, asked: node });
        }
        let mut wanted = self.wanted(node);
        let pdos: BTreeSet<u16> = wanted.keys().filter_map(|(index, _)| pdo_of(*index)).collect();
        let mut order = Vec::new();
        let mut last = Vec::new();
        for (index, sub) in wanted.keys().copied().collect::<Vec<_>>() {
            if pdo_of(index).is_none()
                && let Some(download) = wanted.remove(&(index, sub))
            {
                let is_last = matches!(index, 0x1010 | 0x1020);
                if is_last { &mut last } else { &mut order }.push(download);
            }
        }
        for pdo in pdos {
            self.pdo(pdo, node, &mut wanted, &mut order);
        }
        // 1020h before 1010h.
        last.sort_by_key(|download: &Download| std::cmp::Reverse(download.index));
        order.append(&mut last);
        Ok(order)
    }

    fn wanted(&self, node: NodeId) -> WantedEntry {
        let mut wanted = BTreeMap::new();
        for (index, sub, entry) in self.entries() {
            if !entry.access.is_writable() || entry.refuses_download() {
                continue;
            }
            let content = match (&entry.download_file, entry.value_for(node)) {
                (Some(file), _) => DownloadContent::File(file.clone()),
                (None, Some(value)) => match entry.data_type.encode(&value) {
                    Ok(bytes) => DownloadContent::Bytes(bytes),
                    // What was read has been checked to fit.
                    Err(_) => continue,
                },
                (None, None) => continue,
            };
            let line = entry.line;
            wanted.insert((index, sub), Download { index, sub, content, reason: WriteReason::Value, line });
        }
        wanted
    }

    /// One PDO: off, its mapping, its other parameters, and on again.
    fn pdo(&self, index: u16, node: NodeId, wanted: &mut WantedEntry, order: &mut Vec<Download>) {
        let cob_id = self.entry(index, 1).filter(|entry| entry.access.is_writable() && !entry.refuses_download());
        let set_on = wanted.remove(&(index, 1));
        let mut on = None;
        if let Some(entry) = cob_id
            && let Some(target) = entry.effective(node).and_then(|value| value.as_u64())
        {
            // A device may refuse another identifier together with the bit, so the one it has is used where known.
            let present = entry.default_for(node).and_then(|value| value.as_u64()).unwrap_or(target);
            order.extend(written(&entry, (index, 1), present | INVALID, WriteReason::SwitchOff));
            on = set_on.or_else(|| written(&entry, (index, 1), target, WriteReason::Restore));
        }
        let mapping = index + TO_MAPPING;
        self.mapping(mapping, node, wanted, order);
        let rest: Vec<_> = wanted.range((index, 0)..=(index, u8::MAX)).map(|(key, _)| *key).collect();
        order.extend(rest.into_iter().filter_map(|key| wanted.remove(&key)));
        order.extend(on);
    }

    fn mapping(&self, index: u16, node: NodeId, wanted: &mut WantedEntry, order: &mut Vec<Download>) {
        let set_count = wanted.remove(&(index, 0));
        let elements: Vec<_> = wanted.range((index, 1)..=(index, u8::MAX)).map(|(key, _)| *key).collect();
        let highest = elements.last().map(|(_, sub)| *sub);
        let elements: Vec<_> = elements.into_iter().filter_map(|key| wanted.remove(&key)).collect();
        let count = self.entry(index, 0).filter(|entry| entry.access.is_writable() && !entry.refuses_download());
        let (Some(highest), Some(count)) = (highest, count) else {
            order.extend(elements);
            return order.extend(set_count);
        };
        order.extend(written(&count, (index, 0), 0, WriteReason::ClearMapping));
        order.extend(elements);
        let before = count.default_for(node).and_then(|value| value.as_u64()).unwrap_or(highest.into());
        order.extend(set_count.or_else(|| written(&count, (index, 0), before, WriteReason::Restore)));
    }
}

fn written(entry: &SubObject, (index, sub): (u16, u8), value: u64, reason: WriteReason) -> Option<Download> {
    let bytes = entry.data_type.encode(&ObjectValue::Unsigned(value)).ok()?;
    Some(Download { index, sub, content: DownloadContent::Bytes(bytes), reason, line: entry.line })
}

/// The communication parameters of the PDO that an object belongs to.
fn pdo_of(index: u16) -> Option<u16> {
    match index {
        0x1400..=0x15FF | 0x1800..=0x19FF => Some(index),
        0x1600..=0x17FF | 0x1A00..=0x1BFF => Some(index - TO_MAPPING),
        _ => None,
    }
}
