//! I/O lists, as used in cabinet wiring: one row for each digital bit, and the description with such a list in it.
//!
//! It works on the text, so that comments and order stay, and on a text that is not sound yet: names that no device carries
//! are bound by the list. Whether the result is sound, [`crate::parse`] has the word. Channels, drives and frames are no
//! bits and stand in no list.

mod absolute;
mod address;
mod change;
mod devices;

use linewright_text::{Problems, Report, document};

pub use absolute::{DeviceBegin, within_devices};
pub use address::{BitAddress, IoDirection};
pub use change::IoChange;

use devices::WrittenDevice;

/// A row of an I/O list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct IoRow {
    /// Its line in the file, from 1.
    pub line: u64,
    /// The signal; empty for a bit that is not connected.
    pub name: String,
    /// The bit of the device, as [`BitAddress`] has it.
    pub address: String,
    pub device: String,
    /// The station, or `console`. A list without that column has none.
    pub station: Option<String>,
    /// Comment. A list without that column has none, and leaves comments as they are.
    pub comment: Option<String>,
}

/// The columns of a list, in the order in which it is written.
pub const IO_COLUMNS: [&str; 5] = ["name", "address", "device", "station", "comment"];

/// Error in a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowProblem {
    pub line: u64,
    /// One of [`IO_COLUMNS`].
    pub column: &'static str,
    pub message: String,
}

/// Reason why a list is not taken.
#[derive(Clone, Debug)]
pub enum IoListError {
    /// The description is not even TOML, or its station types are wrong.
    Description(Box<Problems>),
    /// Rows are wrong.
    Rows(Vec<RowProblem>),
    /// With the list in it the description would be wrong.
    Result(Box<Problems>),
}

/// The I/O list of a description.
///
/// # Errors
/// The description cannot be read.
pub fn io_list(file_name: &str, text: &str) -> Result<Vec<IoRow>, IoListError> {
    let devices = read(file_name, text)?;
    let rows = devices.iter().flat_map(|device| {
        [IoDirection::Input, IoDirection::Output].into_iter().flat_map(move |direction| {
            device.bits(direction).iter().enumerate().map(move |(bit, name)| IoRow {
                line: 0,
                name: name.clone(),
                address: BitAddress { direction, bit }.to_string(),
                device: device.name.clone(),
                station: Some(device.owner.clone()),
                comment: Some(device.comments.get(name).cloned().unwrap_or_default()),
            })
        })
    });
    Ok(rows.collect())
}

/// The names in `begins` that no device of the description with inputs and outputs has, in words.
///
/// # Errors
/// The description cannot be read.
pub fn unknown_devices(file_name: &str, text: &str, begins: &[DeviceBegin]) -> Result<Vec<String>, IoListError> {
    let devices = read(file_name, text)?;
    let mut names: Vec<&str> = begins.iter().map(DeviceBegin::device).collect();
    names.retain(|name| !devices.iter().any(|device| device.name == *name));
    names.dedup();
    Ok(names.into_iter().map(|name| change::unknown_device(name, &devices)).collect())
}

/// The description with a list in it, and what is different.
///
/// # Errors
/// Nothing of a list is taken of which a row is wrong, or that makes the description wrong.
pub fn with_io_list(file_name: &str, text: &str, rows: &[IoRow]) -> Result<IoChange, IoListError> {
    let before = read(file_name, text)?;
    let after = change::changed(&before, rows).map_err(IoListError::Rows)?;
    let changes = change::differences(&before, &after);
    let text = devices::write(text, &before, &after);
    match crate::parse(file_name, &text) {
        Ok(parsed) => Ok(IoChange { text, changes, warnings: parsed.warnings }),
        Err(problems) => Err(IoListError::Result(Box::new(problems))),
    }
}

/// The devices with bits, those of station types written out.
fn read(file_name: &str, text: &str) -> Result<Vec<WrittenDevice>, IoListError> {
    let failed = |problems: Problems| IoListError::Description(Box::new(problems));
    let expanded = crate::expand(file_name, text).map_err(failed)?;
    let toml = |text: &str| {
        let mut report = Report::default();
        let document = document(text, &mut report).map(toml_edit::Document::into_mut);
        report.close(document, file_name, text).map(|(document, _)| document).map_err(failed)
    };
    Ok(devices::read(&toml(text)?, &toml(&expanded)?))
}
