//! The error codes of drives (CiA 402, emergency codes and object 603Fh), in words.
//!
//! A code without a row of its own is described by its group, the way the profile nests them: 2310h is in 2300h, and
//! that in 2000h.

use crate::codec::emcy_codes::nearest;

/// Code "following error".
pub const FOLLOWING_ERROR: u16 = 0x8611;
/// Code "incremental sensor 1 fault".
pub const SENSOR_1: u16 = 0x7305;

/// Meaning of an error code of a drive; `None` for a code without one in the profile.
pub fn meaning(code: u16) -> Option<&'static str> {
    nearest(code, &[&TABLE])
}

/// Whether the code makes the position unreliable: an encoder, resolver or tacho has failed.
pub fn loses_position(code: u16) -> bool {
    (0x7300..=0x730F).contains(&code) || code == 0x7320
}

/// In the order of the codes.
const TABLE: [(u16, &str); 134] = [
    (0x0000, "no error"),
    (0x1000, "generic error"),
    (0x2000, "current"),
    (0x2100, "current on device input side"),
    (0x2110, "short circuit or earth leakage, input"),
    (0x2120, "earth leakage, input"),
    (0x2121, "earth leakage phase L1"),
    (0x2122, "earth leakage phase L2"),
    (0x2123, "earth leakage phase L3"),
    (0x2130, "short circuit, input"),
    (0x2131, "short circuit phases L1-L2"),
    (0x2132, "short circuit phases L2-L3"),
    (0x2133, "short circuit phases L3-L1"),
    (0x2200, "internal current"),
    (0x2211, "internal current no. 1"),
    (0x2212, "internal current no. 2"),
    (0x2213, "over-current in ramp function"),
    (0x2214, "over-current in the sequence"),
    (0x2220, "continuous over-current, device internal"),
    (0x2221, "continuous over-current no. 1"),
    (0x2222, "continuous over-current no. 2"),
    (0x2230, "short circuit or earth leakage, device internal"),
    (0x2240, "earth leakage, device internal"),
    (0x2250, "short circuit, device internal"),
    (0x2300, "current on device output side"),
    (0x2310, "continuous over-current, output"),
    (0x2311, "continuous over-current no. 1, output"),
    (0x2312, "continuous over-current no. 2, output"),
    (0x2320, "short circuit or earth leakage, motor side"),
    (0x2330, "earth leakage, motor side"),
    (0x2331, "earth leakage phase U"),
    (0x2332, "earth leakage phase V"),
    (0x2333, "earth leakage phase W"),
    (0x2340, "short circuit, motor side"),
    (0x2341, "short circuit phases U-V"),
    (0x2342, "short circuit phases V-W"),
    (0x2343, "short circuit phases W-U"),
    (0x2350, "load level fault, thermal state"),
    (0x2351, "load level warning, thermal state"),
    (0x3000, "voltage"),
    (0x3100, "mains voltage"),
    (0x3110, "mains over-voltage"),
    (0x3120, "mains under-voltage"),
    (0x3130, "phase failure"),
    (0x3134, "phase sequence"),
    (0x3140, "mains frequency"),
    (0x3141, "mains frequency too great"),
    (0x3142, "mains frequency too small"),
    (0x3200, "DC link voltage"),
    (0x3210, "DC link over-voltage"),
    (0x3220, "DC link under-voltage"),
    (0x3230, "load error"),
    (0x3300, "output voltage"),
    (0x3310, "output over-voltage"),
    (0x3320, "armature circuit"),
    (0x3330, "field circuit"),
    (0x4000, "temperature"),
    (0x4100, "ambient temperature"),
    (0x4110, "excess ambient temperature"),
    (0x4120, "too low ambient temperature"),
    (0x4130, "temperature of supply air"),
    (0x4140, "temperature of air outlet"),
    (0x4200, "temperature of the device"),
    (0x4210, "excess temperature of the device"),
    (0x4220, "too low temperature of the device"),
    (0x4300, "temperature of the drive"),
    (0x4310, "excess temperature of the drive"),
    (0x4320, "too low temperature of the drive"),
    (0x4400, "temperature of the supply"),
    (0x4410, "excess temperature of the supply"),
    (0x4420, "too low temperature of the supply"),
    (0x5000, "device hardware"),
    (0x5100, "supply"),
    (0x5110, "supply low voltage"),
    (0x5120, "supply intermediate circuit"),
    (0x5200, "control"),
    (0x5210, "measurement circuit"),
    (0x5220, "computing circuit"),
    (0x5300, "operating unit"),
    (0x5400, "power section"),
    (0x5410, "output stages"),
    (0x5420, "chopper"),
    (0x5430, "input stages"),
    (0x5440, "contacts"),
    (0x5450, "fuses"),
    (0x5500, "hardware memory"),
    (0x5510, "RAM"),
    (0x5520, "ROM or EPROM"),
    (0x5530, "EEPROM"),
    (0x6000, "device software"),
    (0x6010, "software reset by watchdog"),
    (0x6100, "internal software"),
    (0x6200, "user software"),
    (0x6300, "data record"),
    (0x6310, "loss of parameters"),
    (0x6320, "parameter error"),
    (0x7000, "additional modules"),
    (0x7100, "power, additional modules"),
    (0x7110, "brake chopper"),
    (0x7111, "failure of brake chopper"),
    (0x7112, "over-current of brake chopper"),
    (0x7113, "protective circuit of brake chopper"),
    (0x7120, "motor"),
    (0x7121, "motor blocked"),
    (0x7122, "motor error or commutation malfunction"),
    (0x7123, "motor tilted"),
    (0x7200, "measurement circuit, additional modules"),
    (0x7300, "sensor"),
    (0x7301, "tacho fault"),
    (0x7302, "tacho wrong polarity"),
    (0x7303, "resolver 1 fault"),
    (0x7304, "resolver 2 fault"),
    (0x7305, "incremental sensor 1 fault"),
    (0x7306, "incremental sensor 2 fault"),
    (0x7307, "incremental sensor 3 fault"),
    (0x7310, "speed sensor"),
    (0x7320, "position sensor"),
    (0x7400, "computation circuit, additional modules"),
    (0x7500, "communication, additional modules"),
    (0x7600, "data storage, additional modules"),
    (0x8000, "monitoring"),
    (0x8100, "communication"),
    (0x8130, "life guard or heartbeat error"),
    (0x8200, "protocol"),
    (0x8300, "torque control"),
    (0x8311, "excess torque"),
    (0x8400, "velocity controller"),
    (0x8500, "position controller"),
    (0x8600, "positioning controller"),
    (0x8611, "following error"),
    (0x8612, "reference limit"),
    (0x9000, "external error"),
    (0xF000, "additional functions"),
    (0xFF00, "manufacturer's own error"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_order_and_groups_catch_what_has_no_row() {
        assert!(TABLE.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert_eq!(meaning(0x8611), Some("following error"));
        assert_eq!(meaning(0x2345), Some("short circuit, motor side"), "its group of sixteen");
        assert_eq!(meaning(0x42FF), Some("temperature of the device"), "its group of 256");
        assert_eq!(meaning(0x3FFF), Some("voltage"), "its class");
        assert_eq!(meaning(0xA123), None);
        assert_eq!(meaning(0xFF42), Some("manufacturer's own error"));
        assert!(loses_position(SENSOR_1) && !loses_position(FOLLOWING_ERROR));
    }

    #[test]
    fn every_code_is_answered() {
        for code in 0..=u16::MAX {
            assert!(meaning(code).is_none_or(|text| !text.is_empty()));
        }
    }
}
