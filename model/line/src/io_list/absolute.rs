//! Lists counted through a whole controller: which device a row is of follows from where each device begins.

use super::address::{BITS_MAX, BitAddress, IoDirection, area, byte, counted, number};
use super::{IoRow, RowProblem};

/// Where a device begins in the addresses of a controller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceBegin {
    device: String,
    /// The first byte of its inputs, and of its outputs; none has no row.
    inputs: Option<usize>,
    outputs: Option<usize>,
}

impl DeviceBegin {
    /// `drill io=%I4,%Q2`, or `drill io=4` for both.
    ///
    /// # Errors
    /// The text is not of this form, or gives inputs or outputs twice.
    pub fn read(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}` is not as in `drill io=%I4,%Q2` or `drill io=4`");
        let (device, begins) = text.rsplit_once('=').ok_or_else(wrong)?;
        let mut begin = DeviceBegin { device: device.trim().to_owned(), inputs: None, outputs: None };
        if let Some(both) = number(begins.trim(), 10, 5) {
            (begin.inputs, begin.outputs) = (Some(both), Some(both));
            return Ok(begin);
        }
        for part in begins.split(',') {
            let (direction, at) = byte(part).ok_or_else(wrong)?;
            let place = match direction {
                IoDirection::Input => &mut begin.inputs,
                IoDirection::Output => &mut begin.outputs,
            };
            if place.replace(at).is_some() {
                return Err(wrong());
            }
        }
        Ok(begin)
    }

    /// The device that it is about.
    pub fn device(&self) -> &str {
        &self.device
    }

    fn of(&self, direction: IoDirection) -> Option<usize> {
        match direction {
            IoDirection::Input => self.inputs,
            IoDirection::Output => self.outputs,
        }
    }
}

/// The rows with their devices, and addresses counted within these. Rows that are of no digital input or output are left out:
/// a controller's list has marks, words and timers as well.
///
/// # Errors
/// Every row of which the device is not certain.
pub fn within_devices(rows: Vec<IoRow>, begins: &[DeviceBegin]) -> Result<Vec<IoRow>, Vec<RowProblem>> {
    let (mut within, mut problems) = (Vec::new(), Vec::new());
    for row in rows.into_iter().filter(|row| !is_of_no_bit(&row.address)) {
        match placed(&row, begins) {
            Ok((device, address)) => within.push(IoRow { device, address: address.to_string(), ..row }),
            Err((column, message)) => problems.push(RowProblem { line: row.line, column, message }),
        }
    }
    if problems.is_empty() { Ok(within) } else { Err(problems) }
}

fn placed(row: &IoRow, begins: &[DeviceBegin]) -> Result<(String, BitAddress), (&'static str, String)> {
    let address = row.address.trim();
    let (direction, byte, bit) = counted(address)
        .ok_or_else(|| ("address", format!("`{address}` is no address of a bit, as %I4.0 or %Q4.0 is")))?;
    // A list that names devices is taken at its word.
    let named = |begin: &&DeviceBegin| row.device.is_empty() || begin.device == row.device;
    let of_it = || begins.iter().filter(named).filter_map(|begin| Some((begin.of(direction)?, begin)));
    let Some((at, begin)) = of_it().filter(|(at, _)| *at <= byte).max_by_key(|(at, _)| *at) else {
        let whom = if row.device.is_empty() { "a device".to_owned() } else { format!("`{}`", row.device) };
        return Err(("address", format!("no --begin says that {whom} begins at `{address}` or before it")));
    };
    if let Some((_, other)) = of_it().find(|(other, of)| *other == at && of.device != begin.device) {
        let message = format!("`{}` and `{}` begin at the same byte by their --begin", begin.device, other.device);
        return Err(("address", message));
    }
    let behind = byte - at;
    if behind >= BITS_MAX / 8 {
        let message = format!(
            "`{address}` is {behind} bytes behind the beginning of `{}`, and a device has {} at most: give --begin for the \
             device that it is of, or leave the row out of the list",
            begin.device,
            BITS_MAX / 8
        );
        return Err(("address", message));
    }
    Ok((begin.device.clone(), BitAddress { direction, bit: 8 * behind + bit }))
}

/// Memory, words, timers, blocks, and tags without an address.
fn is_of_no_bit(address: &str) -> bool {
    if let Some((_, rest)) = area(address) {
        return rest.starts_with(['W', 'D', 'B']);
    }
    // M memory, D data blocks, T timers, Z and C counters, P periphery, O F S U V blocks and tables of STEP 7.
    let first = address.trim().trim_start_matches('%').chars().next();
    first.is_none_or(|first| "MDTZCPOFSUV".contains(first.to_ascii_uppercase()))
}
