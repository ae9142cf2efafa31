//! Shared by the tests of this crate: texts around a part that is of interest, and problems in words.

use linewright_eds::{Eds, NodeId, read};

/// A drive, as a tool for DOS and ISO-8859-1 would write it.
pub const DRIVE: &[u8] = include_bytes!("../devices/drive.eds");
/// The shipped I/O device.
pub const IO: &[u8] = include_bytes!("../../../../launch-config/devices/linewright-io.eds");

/// Beginning of every description. Line 1 is the first; what follows it begins in line 8.
pub const HEAD: &str = "[MandatoryObjects]\nSupportedObjects=1\n1=0x1000\n\
    [1000]\nParameterName=Device type\nDataType=0x0007\nAccessType=ro\n";

pub fn node(id: u8) -> NodeId {
    NodeId::new(id).expect("1 to 127")
}

/// A description that is read.
pub fn sound(text: &str) -> Eds {
    read("a.eds", text.as_bytes()).unwrap_or_else(|problems| panic!("{problems:#}"))
}

/// All problems and warnings, one line each, without the name of the file.
pub fn said(bytes: &[u8]) -> Vec<String> {
    let problems = match read("a.eds", bytes) {
        Ok(eds) => eds.warnings().clone(),
        Err(problems) => problems,
    };
    format!("{problems:#}").lines().skip(1).map(|line| line.replacen("a.eds:", "", 1)).collect()
}
