//! The error codes of emergencies, in words: CiA 301 (table 26), and the additions of CiA 401 for I/O devices.
//!
//! A code without a row of its own is described by its group: 8131h is in 8100h, and that in 8000h. Drives have a table
//! of their own (`profile::drive`), in which the same groups are divided otherwise.

/// Meaning of a code of a device without a profile known here.
pub(super) fn general(code: u16) -> Option<&'static str> {
    nearest(code, &[GENERAL])
}

/// Meaning of a code of an I/O device.
pub(super) fn io(code: u16) -> Option<&'static str> {
    nearest(code, &[IO, GENERAL])
}

/// The row of a code in these tables, or that of the smallest group it is in.
pub(crate) fn nearest(code: u16, tables: &[&[(u16, &'static str)]]) -> Option<&'static str> {
    // The manufacturer's own codes are FF00h to FFFFh; the rest of F000h is for additional functions.
    let masks = [0xFFFF, 0xFFF0, 0xFF00, 0xF000];
    let row = |code: u16| tables.iter().flat_map(|table| table.iter()).find(|(known, _)| *known == code);
    masks.iter().find_map(|mask| row(code & mask)).map(|(_, meaning)| *meaning)
}

const GENERAL: &[(u16, &str)] = &[
    (0x0000, "errors gone"),
    (0x1000, "generic error"),
    (0x2000, "current"),
    (0x2100, "current on the input side"),
    (0x2200, "current inside the device"),
    (0x2300, "current on the output side"),
    (0x3000, "voltage"),
    (0x3100, "mains voltage"),
    (0x3200, "voltage inside the device"),
    (0x3300, "output voltage"),
    (0x4000, "temperature"),
    (0x4100, "ambient temperature"),
    (0x4200, "device temperature"),
    (0x5000, "device hardware"),
    (0x6000, "device software"),
    (0x6100, "internal software"),
    (0x6200, "user software"),
    (0x6300, "data set"),
    (0x7000, "additional modules"),
    (0x8000, "monitoring"),
    (0x8100, "communication"),
    (0x8110, "CAN overrun, frames were lost"),
    (0x8120, "CAN error passive"),
    (0x8130, "heartbeat or life guard error: it does not hear its manager"),
    (0x8140, "recovered from bus-off"),
    (0x8150, "another node uses its CAN identifier"),
    (0x8200, "protocol error"),
    (0x8210, "PDO not processed, it is too short"),
    (0x8220, "PDO longer than mapped"),
    (0x8230, "MPDO not processed, its object is not there"),
    (0x8240, "SYNC of unexpected length"),
    (0x8250, "an expected PDO has not come"),
    (0x9000, "external error"),
    (0xF000, "additional functions"),
    (0xFF00, "the manufacturer's own error"),
];

const IO: &[(u16, &str)] = &[
    (0x2310, "current at outputs too high, overload"),
    (0x2320, "short circuit at outputs"),
    (0x2330, "load dump at outputs"),
    (0x3110, "input voltage too high"),
    (0x3120, "input voltage too low"),
    (0x3210, "internal voltage too high"),
    (0x3220, "internal voltage too low"),
    (0x3310, "output voltage too high"),
    (0x3320, "output voltage too low"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_means_what_its_nearest_row_says() {
        assert_eq!(general(0x8131), Some("heartbeat or life guard error: it does not hear its manager"));
        assert_eq!(general(0x8199), Some("communication"));
        assert_eq!(general(0x2320), Some("current on the output side"));
        assert_eq!(io(0x2320), Some("short circuit at outputs"));
        assert_eq!(io(0x8210), Some("PDO not processed, it is too short"));
        assert_eq!(general(0xFF7A), Some("the manufacturer's own error"));
        assert_eq!(general(0xA000), None);
        assert_eq!(io(0x0000), Some("errors gone"));
    }
}
