//! A list put into the devices, row by row, and what is different then.

use std::collections::{BTreeMap, HashMap};

use linewright_text::{Problem, TEXT_MAX, suggestion};

use super::address::counted;
use super::devices::WrittenDevice;
use super::{BitAddress, IoDirection, IoRow, RowProblem};

/// A description with a list in it.
#[derive(Clone, Debug)]
pub struct IoChange {
    /// The whole description.
    pub text: String,
    /// Differences, line by line.
    pub changes: Vec<String>,
    /// Warnings about the description.
    pub warnings: Vec<Problem>,
}

/// So many differences of a device of a type are named.
const TYPE_CHANGES_SHOWN: usize = 8;

/// A row that is understood.
struct Placed<'a> {
    row: &'a IoRow,
    /// The device of this number.
    device: usize,
    at: BitAddress,
}

/// The devices with all rows in them, or everything that is wrong with rows.
pub(super) fn changed(before: &[WrittenDevice], rows: &[IoRow]) -> Result<Vec<WrittenDevice>, Vec<RowProblem>> {
    let mut problems = Vec::new();
    let placed: Vec<Placed<'_>> = rows.iter().filter_map(|row| place(before, row, &mut problems)).collect();
    each_once(before, &placed, &mut problems);
    if !problems.is_empty() {
        problems.sort_by_key(|problem: &RowProblem| problem.line);
        return Err(problems);
    }
    let mut after = before.to_vec();
    // Everything that has a row leaves its old place first, so that signals can change places.
    let mut comments: HashMap<(&str, &str), String> = HashMap::new();
    for Placed { row, device, .. } in placed.iter().filter(|placed| !placed.row.name.is_empty()) {
        let owner = before[*device].owner.as_str();
        for other in after.iter_mut().filter(|other| other.owner == owner) {
            let bits = other.inputs.iter_mut().chain(&mut other.outputs);
            bits.filter(|bit| **bit == row.name).for_each(String::clear);
            if let Some(comment) = other.comments.remove(&row.name) {
                comments.insert((owner, &row.name), comment);
            }
        }
    }
    for Placed { row, device, at } in &placed {
        let owner = before[*device].owner.as_str();
        let bits = after[*device].bits_mut(at.direction);
        if bits.len() <= at.bit {
            if row.name.is_empty() {
                continue;
            }
            bits.resize(at.bit + 1, String::new());
        }
        let there = std::mem::replace(&mut bits[at.bit], row.name.clone());
        if !there.is_empty() && !row.name.is_empty() {
            problems.push(RowProblem {
                line: row.line,
                column: "address",
                message: format!("{at} of {} carries `{there}`, which has no row: give it one", row.device),
            });
        }
        let kept = comments.get(&(owner, row.name.as_str())).cloned();
        let comment = row.comment.clone().or(kept).filter(|comment| !comment.is_empty() && !row.name.is_empty());
        if !there.is_empty() {
            after[*device].comments.remove(&there);
        }
        if let Some(comment) = comment {
            after[*device].comments.insert(row.name.clone(), comment);
        }
    }
    for (was, after) in before.iter().zip(&mut after) {
        for direction in [IoDirection::Input, IoDirection::Output] {
            trim(was.bits(direction), after.bits_mut(direction));
        }
    }
    of_types(before, &after, &placed, &mut problems);
    problems.sort_by_key(|problem| problem.line);
    if problems.is_empty() { Ok(after) } else { Err(problems) }
}

/// Reports devices of station types that would be different: a list is put into no type.
fn of_types(before: &[WrittenDevice], after: &[WrittenDevice], placed: &[Placed<'_>], problems: &mut Vec<RowProblem>) {
    let written = before.iter().zip(after).filter(|(was, is)| was.is_of_a_type() && was != is);
    for (was, is) in written {
        let differs = |placed: &&Placed<'_>| {
            let Placed { row, at, device } = placed;
            let there = was.bits(at.direction).get(at.bit).map_or("", String::as_str);
            let comment = was.comments.get(&row.name).map_or("", String::as_str);
            match row.device == was.name {
                true => there != row.name || row.comment.as_ref().is_some_and(|wanted| wanted != comment),
                // It is taken away from this one.
                false => !row.name.is_empty() && was.carries(&row.name) && before[*device].owner == was.owner,
            }
        };
        let Some(Placed { row, .. }) = placed.iter().find(differs) else { continue };
        let of_it = |of: &&Difference<'_>| of.owner == was.owner && (was.carries(of.name) || is.carries(of.name));
        let all = every_difference(before, after);
        let mut shown: Vec<String> = all.iter().filter(of_it).map(|of| format!("{}: {}", of.name, of.what)).collect();
        let count = shown.len();
        shown.truncate(TYPE_CHANGES_SHOWN);
        if count > shown.len() {
            shown.push(format!("and {} more", count - shown.len()));
        }
        problems.push(RowProblem {
            line: row.line,
            column: "device",
            message: format!(
                "`{}` is written in a station type, and the list differs ({}): change the type",
                was.name,
                shown.join("; ")
            ),
        });
    }
}

/// Bits that have become free at the end of a list are left out; those that were written stay.
fn trim(before: &[String], after: &mut Vec<String>) {
    if before != &after[..] && before.last().is_some_and(|last| !last.is_empty()) {
        let used = after.iter().rposition(|bit| !bit.is_empty()).map_or(0, |last| last + 1);
        after.truncate(used);
    }
}

pub(super) fn unknown_device(name: &str, devices: &[WrittenDevice]) -> String {
    let known = devices.iter().map(|device| device.name.as_str());
    let hint = suggestion(name, known).map(|hint| format!(": {hint}")).unwrap_or_default();
    format!("no device with inputs and outputs is called `{name}`{hint}")
}

fn place<'a>(devices: &[WrittenDevice], row: &'a IoRow, problems: &mut Vec<RowProblem>) -> Option<Placed<'a>> {
    let before = problems.len();
    let mut add = |column, message| problems.push(RowProblem { line: row.line, column, message });
    let device = devices.iter().position(|device| device.name == row.device);
    match device {
        None if row.device.is_empty() => add("device", "no device".to_owned()),
        None => {
            add("device", unknown_device(&row.device, devices));
        }
        Some(device) => {
            let owner = &devices[device].owner;
            if let Some(station) = row.station.as_ref().filter(|station| !station.is_empty() && *station != owner) {
                add("station", format!("`{}` is a device of `{owner}`, not of `{station}`", row.device));
            }
        }
    }
    let at = BitAddress::read(&row.address);
    if at.is_none() {
        let message = match counted(&row.address) {
            Some((_, byte, _)) => format!(
                "`{}` is in byte {byte}, and a device has bytes 0 to 7, counted in each: of a list that is counted through a \
                 whole controller say where each device begins, as in --begin '{}={byte}'",
                row.address, row.device
            ),
            None => format!("`{}` is no address of a bit: %IX0.0 to %IX7.7, or %QX0.0 to %QX7.7", row.address),
        };
        add("address", message);
    }
    if row.comment.as_ref().is_some_and(|comment| comment.len() > TEXT_MAX) {
        add("comment", format!("over {TEXT_MAX} bytes"));
    }
    if row.name.chars().any(|letter| !letter.is_ascii_graphic()) {
        add(
            "name",
            format!("`{}` cannot name a signal: one word of letters, digits and signs", row.name.escape_debug()),
        );
    }
    let (device, at) = (device?, at?);
    (problems.len() == before).then_some(Placed { row, device, at })
}

/// Reports bits, and signals of one owner, that have two rows.
fn each_once(devices: &[WrittenDevice], placed: &[Placed<'_>], problems: &mut Vec<RowProblem>) {
    let mut bits = HashMap::new();
    let mut names = HashMap::new();
    for Placed { row, device, at } in placed {
        if let Some(earlier) = bits.insert((device, at), row.line) {
            let message = format!("{at} of {} has a row already, line {earlier}", row.device);
            problems.push(RowProblem { line: row.line, column: "address", message });
        }
        let owner = &devices[*device].owner;
        if !row.name.is_empty()
            && let Some(earlier) = names.insert((owner, &row.name), row.line)
        {
            let message = format!("`{}` of `{owner}` has a row already, line {earlier}", row.name);
            problems.push(RowProblem { line: row.line, column: "name", message });
        }
    }
}

/// What is different about a signal.
struct Difference<'a> {
    owner: &'a str,
    name: &'a str,
    /// In words.
    what: String,
}

/// Differences, in words.
pub(super) fn differences(before: &[WrittenDevice], after: &[WrittenDevice]) -> Vec<String> {
    let all = every_difference(before, after);
    all.into_iter().map(|Difference { owner, name, what }| format!("{owner}: {name}: {what}")).collect()
}

fn every_difference<'a>(before: &'a [WrittenDevice], after: &'a [WrittenDevice]) -> Vec<Difference<'a>> {
    let (old, new) = (places(before), places(after));
    let mut all: Vec<&(&str, &str)> = new.keys().chain(old.keys().filter(|key| !new.contains_key(*key))).collect();
    all.sort_unstable();
    let mut changes = Vec::new();
    for key @ &(owner, name) in all {
        let what = match (old.get(key), new.get(key)) {
            (Some((was, _)), Some((is, _))) if was != is => Some(format!("{was} → {is}")),
            (None, Some((is, _))) => Some(format!("new, {is}")),
            (Some((was, _)), None) => Some(format!("{was} → not connected")),
            _ => None,
        };
        changes.extend(what.map(|what| Difference { owner, name, what }));
        let comment = |of: Option<&(String, Option<&String>)>| of.and_then(|(_, comment)| *comment).cloned();
        let (was, is) = (comment(old.get(key)), comment(new.get(key)));
        if was != is && new.contains_key(key) {
            let quoted =
                |comment: Option<String>| comment.map_or("none".to_owned(), |comment| format!("\"{comment}\""));
            changes.push(Difference { owner, name, what: format!("comment {} → {}", quoted(was), quoted(is)) });
        }
    }
    changes
}

/// Place of each signal, with its comment, by owner and name.
fn places(devices: &[WrittenDevice]) -> BTreeMap<(&str, &str), (String, Option<&String>)> {
    let mut places = BTreeMap::new();
    for device in devices {
        for direction in [IoDirection::Input, IoDirection::Output] {
            for (bit, name) in device.bits(direction).iter().enumerate().filter(|(_, name)| !name.is_empty()) {
                let place = format!("{} {}", device.name, BitAddress { direction, bit });
                places.insert((device.owner.as_str(), name.as_str()), (place, device.comments.get(name)));
            }
        }
    }
    places
}
