//! Additions to a line's description from its devices' own files (EDS, DCF).
//!
//! The description names the file; here it is read and compared with the description itself. Where both have a value
//! they must agree: a mixture of two devices is never intended.

use std::path::Path;

use linewright_eds::{DownloadContent, Eds, NodeId, limits, read};
use linewright_line::{Canopen, Device, DeviceKind, DriveMode, Line, ObjectWrite, is_the_managers, keeps_an_output};
use miette::{WrapErr, miette};

use crate::files;

/// Reads the file of every device that names one, beside the description in `dir`.
pub fn complete(line: &mut Line, dir: &Path, quiet: bool) -> miette::Result<()> {
    for device in &mut line.devices {
        let Some(file) = device.canopen().and_then(|canopen| canopen.setup.file.clone()) else { continue };
        let path = files::beside(dir, &file).wrap_err_with(|| format!("device `{}`", device.name))?;
        let name = path.display().to_string();
        let eds = description(&path).wrap_err_with(|| format!("device `{}`", device.name))?;
        if !quiet {
            for warning in eds.warnings().iter() {
                crate::out::complain!("{name}:{}:{}: warning: {}", warning.line, warning.column, warning.message);
            }
        }
        apply(device, &eds).map_err(|why| miette!("device `{}`, {name}: {why}", device.name))?;
    }
    Ok(())
}

fn description(path: &Path) -> miette::Result<Eds> {
    let bytes = files::bytes(path, limits::FILE_BYTES_MAX, "a device's file")?;
    read(&path.display().to_string(), &bytes).map_err(miette::Report::new)
}

/// Adds the content of the file.
fn apply(device: &mut Device, eds: &Eds) -> Result<(), String> {
    let Canopen { node_id, setup } = device.canopen_mut().ok_or("it speaks no CANopen")?;
    let node = NodeId::new(*node_id).ok_or("its node id is none")?;
    let said = eds.identity();
    let identity = &mut setup.identity;
    let parts = [
        ("type", &mut identity.device_type, said.device_type),
        ("vendor", &mut identity.vendor, said.vendor),
        ("product", &mut identity.product, said.product),
        ("revision", &mut identity.revision, said.revision),
        ("serial", &mut identity.serial, said.serial),
    ];
    for (name, here, there) in parts {
        match (*here, there) {
            (Some(here), Some(there)) if here != there => {
                return Err(format!("{name} is {there:#X} there and {here:#X} in the description"));
            }
            (None, there) => *here = there,
            _ => {}
        }
    }
    for setting in &setup.settings {
        fits(setting, eds, node)?;
    }
    let mut settings = Vec::new();
    for download in eds.downloads(node).map_err(|error| error.to_string())? {
        let DownloadContent::Bytes(data) = download.content else {
            return Err(format!("line {}: a DownloadFile is not sent to devices here", download.line));
        };
        if !is_the_managers(download.index) {
            settings.push(ObjectWrite { index: download.index, sub: download.sub, data });
        }
    }
    // The description's own settings come last, and so stay.
    settings.append(&mut setup.settings);
    setup.settings = settings;
    moves(device, eds)?;
    lets_go(device, eds)
}

/// Checks that the EDS of a drive has the objects that it is ordered by (CiA 402).
fn moves(device: &Device, eds: &Eds) -> Result<(), String> {
    let Some(drive) = device.drive() else { return Ok(()) };
    let by_mode = match drive.mode {
        DriveMode::Position => [0x607A, 0x6064],
        DriveMode::Velocity => [0x60FF, 0x606C],
    };
    let missing = [0x6040, 0x6041, 0x6060, 0x6061].into_iter().chain(by_mode).find(|&i| eds.entry(i, 0).is_none());
    missing.map_or(Ok(()), |index| {
        Err(format!("no object {index:04X}h, which a drive is ordered by: is it a drive's file?"))
    })
}

/// Checks that the EDS has the objects by which the device turns its outputs off when its manager's heartbeat is missed
/// (CiA 401, 6206h and 6207h). The error names the missing object and the remedy.
fn lets_go(device: &Device, eds: &Eds) -> Result<(), String> {
    let DeviceKind::Io(Canopen { setup, .. }, io) = &device.kind else { return Ok(()) };
    if setup.without_error_values.is_some() {
        return Ok(());
    }
    let remedy = "use a device that switches its outputs off, or state in `without_error_values` why it is safe";
    let settings = &setup.settings;
    // The last value stays.
    let last =
        |nth: usize| !settings[nth + 1..].iter().any(|l| (l.index, l.sub) == (settings[nth].index, settings[nth].sub));
    let mut keeps = settings.iter().enumerate().filter(|(nth, own)| last(*nth) && keeps_an_output(&io.outputs, own));
    if let Some((_, ObjectWrite { index, sub, .. })) = keeps.next() {
        return Err(format!("object {index:04X}h:{sub:02X} keeps an output on after loss of the manager: {remedy}"));
    }
    for (sub, _) in (1..).zip(io.outputs.chunks(8)).filter(|(_, byte)| byte.iter().any(Option::is_some)) {
        if let Some(index) = [0x6206, 0x6207].into_iter().find(|index| eds.entry(*index, sub).is_none()) {
            return Err(format!(
                "no object {index:04X}h:{sub:02X}, by which outputs go off after loss of the manager: {remedy}"
            ));
        }
    }
    Ok(())
}

/// Checks that the device has an object like this, that can be written with so many bytes.
fn fits(setting: &ObjectWrite, eds: &Eds, node: NodeId) -> Result<(), String> {
    let ObjectWrite { index, sub, data } = setting;
    let entry = eds.entry(*index, *sub).ok_or_else(|| format!("there is no object {index:04X}h:{sub:02X}"))?;
    let what = format!("object {index:04X}h:{sub:02X} ({}, line {})", entry.name, entry.line);
    if !entry.access.is_writable() {
        return Err(format!("{what} is {}, and cannot be written", entry.access));
    }
    let value = entry.data_type.decode(data).map_err(|error| format!("{what}: {error}"))?;
    match entry.limit_broken(&value, node) {
        Some((limit, end)) => Err(format!("{what}: {value} is beyond {limit}, which is {end}")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use linewright_line::{DeviceBus, DeviceIdentity, Owner};

    use super::*;

    const IO: &[u8] = include_bytes!("../../launch-config/devices/linewright-io.eds");

    fn device() -> Device {
        Device {
            name: "io".to_owned(),
            owner: Owner::Console,
            bus: DeviceBus::Line,
            kind: DeviceKind::io(4, Vec::new(), Vec::new()),
        }
    }

    fn eds() -> Eds {
        read("io.eds", IO).expect("the simulated device's own file is sound")
    }

    #[test]
    fn a_file_says_who_the_device_has_to_be() {
        let mut device = device();
        apply(&mut device, &eds()).expect("an EDS alone sets nothing");
        assert_eq!(device.canopen_mut().expect("CANopen").setup.identity.device_type, eds().identity().device_type);
        assert!(device.canopen_mut().expect("CANopen").setup.settings.is_empty(), "an EDS has no parameter values");
    }

    #[test]
    fn a_drive_has_the_file_of_a_drive() {
        let text = include_str!("../../model/line/tests/descriptions/drives.toml");
        let line = linewright_line::parse("drives.toml", text).expect("it is sound").line;
        let mut drive = line.devices.into_iter().find(|device| device.drive().is_some()).expect("it has one");
        let why = apply(&mut drive.clone(), &eds()).expect_err("this is an I/O device's");
        assert_eq!(why, "no object 6040h, which a drive is ordered by: is it a drive's file?");
        let own = include_bytes!("../../launch-config/devices/linewright-drive.eds");
        apply(&mut drive, &read("drive.eds", own).expect("it is sound")).expect("this is a drive's");
    }

    #[test]
    fn a_description_that_contradicts_the_file_is_refused() {
        let mut device = device();
        device.canopen_mut().expect("CANopen").setup.identity =
            DeviceIdentity { device_type: Some(0x192), ..DeviceIdentity::default() };
        let why = apply(&mut device, &eds()).expect_err("a drive is no I/O device");
        assert!(why.starts_with("type is 0x"), "{why}");
    }

    #[test]
    fn settings_are_checked_against_the_file() {
        let setting = |index, sub, data: &[u8]| ObjectWrite { index, sub, data: data.to_vec() };
        let refused = |setting: ObjectWrite| {
            let mut device = device();
            device.canopen_mut().expect("CANopen").setup.settings = vec![setting];
            apply(&mut device, &eds()).expect_err("it must not be sent")
        };
        assert!(refused(setting(0x7777, 0, &[1])).contains("there is no object 7777h:00"));
        assert!(refused(setting(0x1000, 0, &[0; 4])).contains("cannot be written"));
        let why = refused(setting(0x1029, 1, &[0; 4]));
        assert!(why.contains("object 1029h:01"), "{why}");
        let why = refused(setting(0x1029, 1, &[3]));
        assert!(why.contains("3 is beyond HighLimit, which is 2"), "{why}");
    }

    #[test]
    fn outputs_that_would_stay_on_without_a_manager_are_found_in_the_file() {
        let tried = |change: &dyn Fn(&mut Device), eds: &Eds| {
            let mut device = device();
            device.io_mut().expect("I/O").outputs = vec![Some(linewright_line::OutputId(0))];
            change(&mut device);
            apply(&mut device, eds)
        };
        assert_eq!(tried(&|_| {}, &eds()), Ok(()));
        let without = String::from_utf8(IO.to_vec()).expect("ASCII").replace("[6206sub1]", "[6205sub1]");
        let without = read("io.eds", without.as_bytes());
        let keeps = |device: &mut Device| {
            device.canopen_mut().expect("CANopen").setup.settings =
                vec![ObjectWrite { index: 0x6206, sub: 1, data: vec![0] }];
        };
        let why = tried(&keeps, &eds()).expect_err("it stays as it is");
        assert!(why.starts_with("object 6206h:01 keeps an output on after loss of the manager"), "{why}");
        let excused = |device: &mut Device| {
            keeps(device);
            device.canopen_mut().expect("CANopen").setup.without_error_values = Some("a safety relay".to_owned());
        };
        assert_eq!(tried(&excused, &eds()), Ok(()));
        if let Ok(without) = without {
            let why = tried(&|_| {}, &without).expect_err("the object is missing");
            assert!(why.starts_with("no object 6206h:01") && why.contains("without_error_values"), "{why}");
        }
    }

    #[test]
    fn limits_hold_for_numbers_of_every_kind() {
        // The same entry as INTEGER8 and as REAL32.
        let of = |data_type: &str, low: &str, high: &str| {
            let text = String::from_utf8(IO.to_vec()).expect("ASCII");
            let entry = "ParameterName=Communication error\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\nDefaultValue=0\n\
                         HighLimit=2\n";
            assert!(text.contains(entry), "the file has changed");
            let other = format!(
                "ParameterName=Other\nObjectType=0x7\nDataType={data_type}\nAccessType=rw\nLowLimit={low}\nHighLimit={high}\n"
            );
            read("io.eds", text.replace(entry, &other).as_bytes()).expect("sound")
        };
        let node = NodeId::new(4).expect("a node");
        let tried =
            |eds: &Eds, data: &[u8]| fits(&ObjectWrite { index: 0x1029, sub: 1, data: data.to_vec() }, eds, node);
        let signed = of("0x0002", "-2", "5");
        for (value, is_allowed) in [(-3i8, false), (-2, true), (5, true), (6, false)] {
            assert_eq!(tried(&signed, &value.to_le_bytes()).is_ok(), is_allowed, "{value}");
        }
        let real = of("0x0008", "-0.5", "1.5");
        for (value, is_allowed) in [(-0.6f32, false), (-0.5, true), (1.5, true), (1.6, false)] {
            assert_eq!(tried(&real, &value.to_le_bytes()).is_ok(), is_allowed, "{value}");
        }
    }
}
