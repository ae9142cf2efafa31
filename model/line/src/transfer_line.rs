//! The shipped transfer line, with a chosen number of machines and times, for tests and demonstrations.
//!
//! There is one source, the file in `launch-config/lines/transfer-line/`: this module copies that file's clamp 1 and
//! mill 1 for every further machine, and scales its times. It works on the text and not on a [`crate::Line`] so that its
//! result is a description like any other, to be checked, read and changed by hand.

use std::fmt::Write;
use std::ops::Range;

/// The shipped file.
const SHIPPED: &str = include_str!("../../../launch-config/lines/transfer-line/line.toml");
/// A watchdog is no shorter than this, however fast the line: a loaded computer may be late by that much.
const WATCHDOG_MIN_S: f64 = 1.0;
/// Largest value of the shipped drives (32 bits of increments), in mm/s².
const ACCELERATION_MAX: f64 = 1e7;
/// Number of devices of a pair, and so the distance of the node ids of the next.
const DEVICES_EACH: usize = 4;

/// A transfer bar with a number of clamp-and-mill pairs along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferLine {
    /// Number of pairs, 1 to [`TransferLine::MACHINES_MAX`].
    pub machines: usize,
    /// Factor on every duration, within [`TransferLine::TIME_SCALE`]. A watchdog is scaled too, but does not fall below
    /// one second.
    pub time_scale: f64,
}

impl Default for TransferLine {
    /// The shipped line.
    fn default() -> Self {
        TransferLine { machines: 1, time_scale: 1.0 }
    }
}

impl TransferLine {
    /// At most this many pairs: each has four devices on the one bus, with node ids from 0x21 to 0x7c.
    pub const MACHINES_MAX: usize = 23;
    /// From a hundredth of the shipped durations to a thousand times as much.
    pub const TIME_SCALE: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

    /// The description of this line.
    ///
    /// # Panics
    /// When `machines` or `time_scale` is out of its bounds.
    pub fn text(&self) -> String {
        assert!((1..=Self::MACHINES_MAX).contains(&self.machines), "{} machines", self.machines);
        assert!(Self::TIME_SCALE.contains(&self.time_scale), "a time scale of {}", self.time_scale);
        let shipped = without_schema(SHIPPED);
        let mut text = String::with_capacity(shipped.len() * (self.machines + 1));
        for block in blocks(shipped) {
            text.push_str(block);
            if is_of_machine_1(block) {
                for machine in 2..=self.machines {
                    text.push_str(&copy(block, machine));
                }
            }
        }
        if self.time_scale == 1.0 { text } else { self.scaled(&text) }
    }

    fn scaled(&self, text: &str) -> String {
        let scale = self.time_scale;
        // Microseconds are as fine as a description is read.
        let seconds = |s: f64| (s * 1e6).round() / 1e6;
        let duration = |s: f64| seconds(s * scale);
        let watchdog = |s: f64| seconds((s * scale).max(WATCHDOG_MIN_S));
        let velocity = |v: f64| v / scale;
        let acceleration = |a: f64| (a / (scale * scale)).min(ACCELERATION_MAX);
        let rules: [(&str, &dyn Fn(f64) -> f64); 5] = [
            ("duration_s", &duration),
            ("watchdog_s", &watchdog),
            ("velocity", &velocity),
            ("acceleration", &acceleration),
            ("quick_stop", &acceleration),
        ];
        let mut scaled = String::with_capacity(text.len());
        for line in text.lines() {
            let rule = rules.iter().find_map(|(key, rule)| Some((value_of(line, key)?, rule)));
            match rule {
                Some(((at, number), rule)) => {
                    writeln!(scaled, "{}{:?}{}", &line[..at.start], rule(number), &line[at.end..])
                }
                None => writeln!(scaled, "{line}"),
            }
            .expect("writing to a string does not fail");
        }
        scaled
    }
}

/// The text without its first line, which names a schema by the path from that one file.
fn without_schema(text: &str) -> &str {
    let rest = |(first, rest): (&str, _)| first.starts_with("#:schema").then_some(rest);
    text.split_once('\n').and_then(rest).unwrap_or(text)
}

/// Place and value of a number that a line of the shipped text, or an inline table in it, gives to `key`.
fn value_of(line: &str, key: &str) -> Option<(Range<usize>, f64)> {
    let assignment = format!("{key} = ");
    let at = line.find(&assignment).filter(|_| !line.starts_with('#'))?;
    let start = at + assignment.len();
    let end = line[start..].find([' ', ',']).map_or(line.len(), |length| start + length);
    Some((start..end, line[start..end].parse().ok()?))
}

/// The shipped text in blocks, each from one top-level header to the next; a station's operations are part of it, and a
/// device's drive.
fn blocks(text: &str) -> Vec<&str> {
    let is_part = |line: &str| line.starts_with("[[station.operation]]") || line.starts_with("[device.");
    let is_header = |line: &str| line.starts_with('[') && !is_part(line);
    let mut starts = vec![0];
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if is_header(line) && at != 0 {
            starts.push(at);
        }
        at += line.len();
    }
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    starts.iter().zip(ends).map(|(&start, end)| &text[start..end]).collect()
}

/// Whether a block is about clamp 1 or mill 1; the first block, before any header, is so only in its comments.
fn is_of_machine_1(block: &str) -> bool {
    block.starts_with('[') && without_comments(block).any(|line| line.contains("clamp_1") || line.contains("mill_1"))
}

/// The block for another machine: its names and node ids instead of the first one's, and no comments, which explain
/// what follows the block rather than the block itself.
fn copy(block: &str, machine: usize) -> String {
    let mut copy = String::with_capacity(block.len());
    for line in without_comments(block) {
        let mut line = line.to_owned();
        for kind in ["clamp", "mill", "Clamp", "Mill"] {
            for separator in ["_", " "] {
                line = line.replace(&format!("{kind}{separator}1"), &format!("{kind}{separator}{machine}"));
            }
        }
        if let Some(first) = line.strip_prefix("node = 0x")
            && let Ok(first) = u8::from_str_radix(first, 16)
        {
            line = format!("node = 0x{:02x}", usize::from(first) + DEVICES_EACH * (machine - 1));
        }
        copy.push_str(&line);
        copy.push('\n');
    }
    copy.truncate(copy.trim_end().len());
    copy.push_str("\n\n");
    copy
}

fn without_comments(block: &str) -> impl Iterator<Item = &str> {
    block.lines().filter(|line| !line.starts_with('#'))
}
