//! The sections about the file and the device as a whole.

use crate::reader::{SectionReader, Weight};
use crate::value::NodeId;

/// `[FileInfo]`: about the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileInfo {
    pub file_name: Option<String>,
    pub file_version: Option<String>,
    pub file_revision: Option<String>,
    /// EDSVersion.
    pub eds_version: Option<String>,
    pub description: Option<String>,
    /// CreationDate and CreationTime, as they stand.
    pub created: Option<String>,
    pub created_by: Option<String>,
    /// ModificationDate and ModificationTime, as they stand.
    pub modified: Option<String>,
    pub modified_by: Option<String>,
    /// LastEDS: source of a DCF.
    pub last_eds: Option<String>,
}

/// `[DeviceInfo]`: about the device.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceInfo {
    pub vendor_name: Option<String>,
    /// VendorNumber, as in object 1018h sub 1.
    pub vendor_number: Option<u32>,
    pub product_name: Option<String>,
    /// ProductNumber, as in object 1018h sub 2.
    pub product_number: Option<u32>,
    /// RevisionNumber, as in object 1018h sub 3.
    pub revision_number: Option<u32>,
    pub order_code: Option<String>,
    /// The bit rates it has, in kbit/s, ascending.
    pub baud_rates: Vec<u16>,
    pub simple_boot_up_master: bool,
    pub simple_boot_up_slave: bool,
    /// Granularity: the smallest piece that can be mapped, in bits; 0 if mapping cannot be changed.
    pub granularity: Option<u8>,
    /// DynamicChannelsSupported is not 0.
    pub dynamic_channels: bool,
    pub group_messaging: bool,
    /// NrOfRXPDO.
    pub rx_pdos: Option<u16>,
    /// NrOfTXPDO.
    pub tx_pdos: Option<u16>,
    /// LSS_Supported.
    pub lss: bool,
    /// CompactPDO: which entries PDO objects have that the file does not list.
    pub compact_pdo: u8,
}

/// `[DeviceComissioning]`: which device of which net a DCF is for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Commissioning {
    pub node_id: Option<NodeId>,
    pub node_name: Option<String>,
    /// Baudrate, in kbit/s.
    pub baud_rate: Option<u16>,
    pub net_number: Option<u32>,
    pub network_name: Option<String>,
    /// CANopenManager.
    pub is_manager: bool,
    /// LSS_SerialNumber.
    pub serial_number: Option<u32>,
}

const BAUD_RATES: [u16; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

impl FileInfo {
    pub(crate) fn read(reader: &SectionReader<'_, '_>) -> Self {
        let joined = |date: &str, time: &str| {
            let parts: Vec<String> = [date, time].into_iter().filter_map(|key| reader.text(key)).collect();
            (!parts.is_empty()).then(|| parts.join(" "))
        };
        FileInfo {
            file_name: reader.text("FileName"),
            file_version: reader.text("FileVersion"),
            file_revision: reader.text("FileRevision"),
            eds_version: reader.text("EDSVersion"),
            description: reader.text("Description"),
            created: joined("CreationDate", "CreationTime"),
            created_by: reader.text("CreatedBy"),
            modified: joined("ModificationDate", "ModificationTime"),
            modified_by: reader.text("ModifiedBy"),
            last_eds: reader.text("LastEDS"),
        }
    }
}

impl DeviceInfo {
    pub(crate) fn read(reader: &mut SectionReader<'_, '_>) -> Self {
        let baud_rates = BAUD_RATES.into_iter().filter(|rate| reader.flag(&format!("BaudRate_{rate}"))).collect();
        DeviceInfo {
            vendor_name: reader.text("VendorName"),
            vendor_number: word(reader, "VendorNumber"),
            product_name: reader.text("ProductName"),
            product_number: word(reader, "ProductNumber"),
            revision_number: word(reader, "RevisionNumber"),
            order_code: reader.text("OrderCode"),
            baud_rates,
            simple_boot_up_master: reader.flag("SimpleBootUpMaster"),
            simple_boot_up_slave: reader.flag("SimpleBootUpSlave"),
            granularity: reader.number("Granularity", 64, Weight::Warning).and_then(|bits| u8::try_from(bits).ok()),
            dynamic_channels: word(reader, "DynamicChannelsSupported").is_some_and(|count| count > 0),
            group_messaging: reader.flag("GroupMessaging"),
            rx_pdos: half(reader, "NrOfRXPDO"),
            tx_pdos: half(reader, "NrOfTXPDO"),
            lss: reader.flag("LSS_Supported"),
            compact_pdo: compact_pdo(reader),
        }
    }
}

fn compact_pdo(reader: &mut SectionReader<'_, '_>) -> u8 {
    let Some((key, text)) = reader.key("CompactPDO") else { return 0 };
    let mask = reader.number_of(key, text, 0xFF, Weight::Warning).and_then(|mask| u8::try_from(mask).ok());
    if mask.is_some_and(|mask| mask > 0) {
        let message = "the PDO objects it stands for are not in the file and are not known here";
        reader.say(key, Weight::Warning, message, "describe the PDOs in sections of their own");
    }
    mask.unwrap_or_default()
}

impl Commissioning {
    pub(crate) fn read(reader: &mut SectionReader<'_, '_>) -> Self {
        Commissioning {
            node_id: node_id(reader),
            node_name: reader.text("NodeName"),
            baud_rate: half(reader, "Baudrate"),
            net_number: word(reader, "NetNumber"),
            network_name: reader.text("NetworkName"),
            is_manager: reader.flag("CANopenManager"),
            serial_number: word(reader, "LSS_SerialNumber"),
        }
    }
}

fn node_id(reader: &mut SectionReader<'_, '_>) -> Option<NodeId> {
    let (key, text) = reader.key("NodeID")?;
    let id = reader.number_of(key, text, 255, Weight::Error)?;
    let id = u8::try_from(id).ok()?;
    if id == 0 || id == 255 {
        // What tools write for "none yet"; LSS calls 255 an unconfigured device.
        return None;
    }
    let node = NodeId::new(id);
    if node.is_none() {
        reader.say(key, Weight::Error, format!("there is no node id {id}"), "node ids are 1 to 127");
    }
    node
}

fn word(reader: &mut SectionReader<'_, '_>, key: &str) -> Option<u32> {
    reader.number(key, u32::MAX.into(), Weight::Warning).and_then(|value| u32::try_from(value).ok())
}

fn half(reader: &mut SectionReader<'_, '_>, key: &str) -> Option<u16> {
    reader.number(key, u16::MAX.into(), Weight::Warning).and_then(|value| u16::try_from(value).ok())
}

/// `[Comments]`: its lines in their order.
pub(crate) fn comments(reader: &SectionReader<'_, '_>) -> Vec<String> {
    let mut lines: Vec<(u32, String)> = Vec::new();
    for key in reader.section.keys() {
        let name = reader.section.str(key.key).to_ascii_lowercase();
        if let Some(number) = name.strip_prefix("line").and_then(|number| number.parse().ok()) {
            lines.push((number, reader.section.str(key.value).to_owned()));
        }
    }
    lines.sort_by_key(|(number, _)| *number);
    lines.into_iter().map(|(_, line)| line).collect()
}

/// `[DummyUsage]`: the types, by their numbers, that stand for a gap in a PDO.
pub(crate) fn dummies(reader: &mut SectionReader<'_, '_>) -> Vec<u16> {
    let mut types = Vec::new();
    for key in reader.section.keys() {
        let name = reader.section.str(key.key).to_ascii_lowercase();
        let code = name.strip_prefix("dummy").and_then(|code| u16::from_str_radix(code, 16).ok());
        if let Some(code) = code
            && reader.flag(&name)
        {
            types.push(code);
        }
    }
    types.sort_unstable();
    types.dedup();
    types
}
