//! The DBC files of a line's devices without CANopen: read, and bound to the description by their names.

use std::path::Path;

use linewright_canopen::Manager;
use linewright_dbc::{Database, FILE_BYTES_MAX, bind, read};
use linewright_line::{DeviceKind, Line, Problem, Problems};
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::files;

/// Reads the DBC file of every device that has one, beside the description `file`. What does not fit is shown in the
/// description, all of it at once.
pub fn complete(line: &mut Line, file: &Path) -> miette::Result<()> {
    let dir = file.parent().unwrap_or(Path::new(""));
    let mut problems: Vec<Problem> = Vec::new();
    for device in &mut line.devices {
        let DeviceKind::Frames(frames) = &mut device.kind else { continue };
        let database = files::beside(dir, &frames.file.name).and_then(|path| database(&path));
        let database = database.wrap_err_with(|| format!("device `{}`", device.name))?;
        match bind(frames, &database) {
            Ok(bound) => frames.bound = Some(bound),
            Err(found) => problems.extend(found),
        }
    }
    if !problems.is_empty() {
        let name = file.display().to_string();
        let text = files::description(file)?;
        return Err(miette::Report::new(Problems::new(&name, &text, problems)));
    }
    identifiers_are_one_devices(line)
}

fn database(path: &Path) -> miette::Result<Database> {
    let bytes = files::bytes(path, FILE_BYTES_MAX, "a DBC file")?;
    read(&bytes).map_err(|error| miette!("{}: {error}", path.display()))
}

/// Checks that no two devices of a bus use the same identifiers: only here are all of them loaded.
fn identifiers_are_one_devices(line: &Line) -> miette::Result<()> {
    for device in line.devices.iter().filter(|device| device.frames().is_some()) {
        let on_bus = line.devices.iter().filter(|other| other.bus == device.bus);
        Manager::new(on_bus, line.timing).into_diagnostic()?;
    }
    Ok(())
}
