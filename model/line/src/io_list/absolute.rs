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

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str, address: &str, device: &str) -> IoRow {
        let (name, address, device) = (name.to_owned(), address.to_owned(), device.to_owned());
        IoRow { line: 2, name, address, device, ..IoRow::default() }
    }

    fn begins(texts: &[&str]) -> Vec<DeviceBegin> {
        texts.iter().map(|text| DeviceBegin::read(text).expect("it is as it has to be")).collect()
    }

    #[test]
    fn rows_find_their_devices_by_where_these_begin() {
        let begins = begins(&["load io=0", "drill io=%I4,%Q2"]);
        let rows = vec![
            row("a", "%I3.7", ""),
            row("b", "E 4.0", ""),
            row("c", "%Q2.1", ""),
            row("d", "A 1.1", "load io"),
            row("m", "%M4.0", ""),
            row("w", "%IW64", ""),
            row("t", "T 5", ""),
            row("n", "", ""),
        ];
        let found = within_devices(rows, &begins).expect("all are certain");
        let found: Vec<_> =
            found.iter().map(|row| (row.name.as_str(), row.device.as_str(), row.address.as_str())).collect();
        let places = [
            ("a", "load io", "%IX3.7"),
            ("b", "drill io", "%IX0.0"),
            ("c", "drill io", "%QX0.1"),
            ("d", "load io", "%QX1.1"),
        ];
        assert_eq!(found, places);
    }

    #[test]
    fn a_row_of_which_the_device_is_not_certain_is_refused() {
        let problem =
            |row: IoRow, given: &[&str]| within_devices(vec![row], &begins(given)).expect_err("refused")[0].clone();
        let before = problem(row("a", "%I3.0", ""), &["load io=4"]);
        assert_eq!(before.message, "no --begin says that a device begins at `%I3.0` or before it");
        let behind = problem(row("a", "%I12.0", ""), &["load io=4"]);
        assert!(behind.message.contains("8 bytes behind the beginning of `load io`"), "{}", behind.message);
        let unnamed = problem(row("a", "%I4.0", "drill io"), &["load io=4"]);
        assert!(unnamed.message.contains("`drill io`"), "{}", unnamed.message);
        let outputs = problem(row("a", "%Q4.0", ""), &["load io=%I4"]);
        assert!(outputs.message.starts_with("no --begin"), "{}", outputs.message);
        let same = problem(row("a", "%I4.0", ""), &["load io=4", "drill io=4"]);
        assert!(same.message.contains("begin at the same byte"), "{}", same.message);
        assert!(problem(row("a", "%I4.9", ""), &["load io=4"]).message.contains("no address of a bit"));
        for wrong in ["load io", "load io=", "load io=%M4", "load io=%I4,%I5", "load io=-1", "load io=%I4.0"] {
            assert!(DeviceBegin::read(wrong).is_err(), "{wrong}");
        }
    }
}
