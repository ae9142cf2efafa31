//! The same as robots' recordings: MCAP, as Foxglove Studio and others open it.
//!
//! Messages are JSON, each with its JSON schema in the file. `/resources/NAME` shows when a resource is idle, busy or
//! down, and with what: a panel of state transitions draws the cell's chart of it. `/cell` counts parts inside and
//! activities in progress, `/activities` has the actual and planned time of each, for plots. `/log` has every event as
//! `foxglove.Log`, `/events` with all its data. The times of messages are those of the events, in nanoseconds; of a
//! simulation they begin at zero.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use linewright_coordinator_cell::tracking::FinishedActivity;
use linewright_history::HistoryEvent;
use linewright_line::Tick;
pub use mcap::McapError;
use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use miette::miette;
use serde_json::{Value, json};

use super::rows::{EventRow, event_row};
use super::story::{ReportSource, failed};

/// Levels of a line of `foxglove.Log`.
const DEBUG: u8 = 1;
const INFO: u8 = 2;
const WARNING: u8 = 3;

/// Writes the file.
pub fn write(story: &ReportSource, path: &Path) -> miette::Result<()> {
    let cannot = |why: &dyn std::fmt::Display| miette!("cannot write {}: {why}", path.display());
    let mut recording = Recording::create(path)?;
    resources(story, &mut recording).map_err(|error| cannot(&error))?;
    counts(story, &mut recording).map_err(|error| cannot(&error))?;
    activities(story, &mut recording).map_err(|error| cannot(&error))?;
    events(story, &mut recording)?.map_err(|error| cannot(&error))?;
    recording.finish().map_err(|error| cannot(&error))
}

/// A file of messages, with its channels by topic.
pub struct Recording {
    writer: Writer<BufWriter<File>>,
    channels: BTreeMap<String, (u16, u32)>,
}

impl Recording {
    pub fn create(path: &Path) -> miette::Result<Self> {
        let made = File::create(path).map_err(McapError::from).and_then(Self::new);
        made.map_err(|error| miette!("cannot write {}: {error}", path.display()))
    }

    pub fn finish(mut self) -> Result<(), McapError> {
        self.writer.finish().map(drop)
    }

    fn new(file: File) -> Result<Self, McapError> {
        // Chunks are not compressed: it would need libraries in C, and is better done in storage.
        let writer = WriteOptions::new().compression(None).create(BufWriter::new(file))?;
        Ok(Recording { writer, channels: BTreeMap::new() })
    }

    pub fn say(&mut self, topic: &str, schema: Schema, at: Tick, message: &Value) -> Result<(), McapError> {
        if !self.channels.contains_key(topic) {
            let (name, text) = schema.text();
            let schema = self.writer.add_schema(name, "jsonschema", text.to_string().as_bytes())?;
            let channel = self.writer.add_channel(schema, topic, "json", &BTreeMap::new())?;
            self.channels.insert(topic.to_owned(), (channel, 0));
        }
        let Some((channel_id, sequence)) = self.channels.get_mut(topic) else { return Ok(()) };
        *sequence = sequence.wrapping_add(1);
        let time = at.as_micros().saturating_mul(1000);
        let header = MessageHeader { channel_id: *channel_id, sequence: *sequence, log_time: time, publish_time: time };
        self.writer.write_to_known_channel(&header, message.to_string().as_bytes())
    }
}

/// Schema of a message.
#[derive(Clone, Copy)]
pub enum Schema {
    Resource,
    Cell,
    Activity,
    Line,
    Station,
    CycleTime,
    Event,
    Log,
}

impl Schema {
    fn text(self) -> (&'static str, Value) {
        let (string, number) = (json!({"type": "string"}), json!({"type": "number"}));
        let maybe = |of: &str| json!({"type": [of, "null"]});
        let (name, properties) = match self {
            Schema::Resource => (
                "linewright.Resource",
                json!({"state": {"type": "string", "enum": ["idle", "busy", "down"]}, "activity": string,
                    "part": maybe("integer"), "cause": string, "in_progress": {"type": "integer"}}),
            ),
            Schema::Cell => (
                "linewright.Cell",
                json!({"inside": {"type": "integer"}, "left": {"type": "integer"}, "in_progress": {"type": "integer"},
                    "failed": {"type": "integer"}}),
            ),
            Schema::Activity => (
                "linewright.Activity",
                json!({"firing": {"type": "integer"}, "activity": string, "mode": string, "part": maybe("integer"),
                    "duration_s": number, "nominal_s": number, "late_s": maybe("number")}),
            ),
            Schema::Line => ("linewright.Line", json!({"state": string, "cause": string})),
            Schema::Station => (
                "linewright.Station",
                json!({"state": {"type": "string", "enum": ["idle", "busy", "waiting"]}, "about": string}),
            ),
            Schema::CycleTime => (
                "linewright.CycleTime",
                json!({"number": {"type": "integer"}, "duration_s": number, "planned_s": maybe("number")}),
            ),
            Schema::Event => (
                "linewright.Event",
                json!({"log": maybe("integer"), "kind": string, "station": maybe("string"),
                    "activity": maybe("string"), "part": maybe("integer"), "firing": maybe("integer"),
                    "data": {"type": ["object", "null"]}}),
            ),
            // As its publisher has it: https://docs.foxglove.dev/docs/sdk/schemas/log
            Schema::Log => (
                "foxglove.Log",
                json!({"timestamp": {"type": "object", "title": "time", "properties": {
                        "sec": {"type": "integer", "minimum": 0},
                        "nsec": {"type": "integer", "minimum": 0, "maximum": 999_999_999}}},
                    "level": {"title": "foxglove.LogLevel", "type": "integer"}, "message": string, "name": string,
                    "file": string, "line": {"type": "integer", "minimum": 0}}),
            ),
        };
        (name, json!({"title": name, "type": "object", "properties": properties}))
    }
}

/// When what begins or ends, in the order of time; what ends at a moment comes before what begins.
fn edges(story: &ReportSource) -> Vec<(Tick, SpanEdge, &FinishedActivity)> {
    let mut edges = Vec::new();
    for done in &story.activities {
        edges.push((done.began.max(story.from), SpanEdge::Begins, done));
        edges.extend(done.failed.as_ref().map(|failed| (failed.at.max(story.from), SpanEdge::Fails, done)));
        edges.extend(done.ended.map(|ended| (ended, SpanEdge::Ends, done)));
    }
    edges.sort_by_key(|(at, edge, done)| (*at, *edge, done.firing));
    edges
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum SpanEdge {
    Ends,
    Fails,
    Begins,
}

/// State of each resource, whenever that changes.
fn resources(story: &ReportSource, to: &mut Recording) -> Result<(), McapError> {
    let sheet = &story.about.sheet;
    let takes_part = |done: &FinishedActivity, resource: usize| {
        sheet.entry(done.mode).is_some_and(|entry| entry.resources.contains(&resource))
    };
    let edges = edges(story);
    for (resource, of) in sheet.resources.iter().enumerate() {
        let topic = format!("/resources/{}", of.name);
        let idle = json!({"state": "idle", "activity": "", "part": null, "cause": "", "in_progress": 0});
        to.say(&topic, Schema::Resource, story.from, &idle)?;
        let mut going_on: Vec<(&FinishedActivity, bool)> = Vec::new();
        let mut own = edges.iter().filter(|(.., done)| takes_part(done, resource)).peekable();
        while let Some(&(at, edge, done)) = own.next() {
            match edge {
                // An activity that begins and ends at one moment is not shown.
                SpanEdge::Begins if done.ended == Some(at) => (),
                SpanEdge::Begins => going_on.push((done, done.failed.as_ref().is_some_and(|failed| failed.at <= at))),
                // A store works on for other parts.
                SpanEdge::Fails if of.stores() => going_on.retain(|(of, _)| of.firing != done.firing),
                SpanEdge::Fails => {
                    going_on.iter_mut().filter(|(of, _)| of.firing == done.firing).for_each(|of| of.1 = true);
                }
                SpanEdge::Ends => going_on.retain(|(of, _)| of.firing != done.firing),
            }
            if own.peek().is_none_or(|(next, ..)| *next > at) {
                to.say(&topic, Schema::Resource, at, &doing(story, &going_on))?;
            }
        }
    }
    Ok(())
}

/// Activity of a resource: first of all one that has failed, then the one that began first.
fn doing(story: &ReportSource, going_on: &[(&FinishedActivity, bool)]) -> Value {
    let shown = going_on.iter().find(|(_, failed)| *failed).or(going_on.first());
    let state = match shown {
        Some((_, true)) => "down",
        Some((_, false)) => "busy",
        None => "idle",
    };
    let entry = shown.and_then(|(done, _)| story.about.sheet.entry(done.mode));
    let cause = shown.filter(|(_, failed)| *failed).and_then(|(done, _)| done.failed.as_ref());
    json!({
        "state": state,
        "activity": entry.map_or("", |entry| entry.activity.as_str()),
        "part": shown.and_then(|(done, _)| done.part).map(|part| part.0),
        "cause": cause.map_or("", |failed| failed.cause.as_str()),
        "in_progress": going_on.len(),
    })
}

/// Numbers of parts and activities, whenever they change.
fn counts(story: &ReportSource, to: &mut Recording) -> Result<(), McapError> {
    let mut changes: BTreeMap<Tick, [i64; 4]> = BTreeMap::from([(story.from, [0; 4])]);
    let mut add = |at: Tick, index: usize, by: i64| {
        changes.entry(at.max(story.from)).or_default()[index] += by;
    };
    for passage in story.tracking.passages() {
        add(passage.entered, 0, 1);
        if let Some(left) = passage.left {
            add(left, 0, -1);
            add(left, 1, 1);
        }
    }
    for (at, edge, done) in edges(story) {
        match edge {
            SpanEdge::Begins => add(at, 2, 1),
            SpanEdge::Fails => {
                add(at, 2, -1);
                add(at, 3, 1);
            }
            SpanEdge::Ends => add(at, if done.failed.is_some() { 3 } else { 2 }, -1),
        }
    }
    let mut now = [0; 4];
    for (at, change) in changes {
        now.iter_mut().zip(change).for_each(|(now, change)| *now += change);
        let [inside, left, in_progress, failed] = now;
        let message = json!({"inside": inside, "left": left, "in_progress": in_progress, "failed": failed});
        to.say("/cell", Schema::Cell, at, &message)?;
    }
    Ok(())
}

/// Durations of all activities that have ended.
fn activities(story: &ReportSource, to: &mut Recording) -> Result<(), McapError> {
    for done in &story.activities {
        let (Some(ended), Some(entry)) = (done.ended, story.about.sheet.entry(done.mode)) else { continue };
        let late = story.planned.get(&done.firing).map(|(from, _)| {
            let seconds = |tick: Tick| tick.as_secs_f64();
            seconds(done.began) - seconds(*from)
        });
        let message = json!({
            "firing": done.firing.0,
            "activity": entry.activity,
            "mode": entry.name,
            "part": done.part.map(|part| part.0),
            "duration_s": ended.since(done.began).as_secs_f64(),
            "nominal_s": entry.nominal.as_secs_f64(),
            "late_s": late,
        });
        to.say("/activities", Schema::Activity, ended, &message)?;
    }
    Ok(())
}

/// Everything that has happened, for people and for programs.
fn events(story: &ReportSource, to: &mut Recording) -> miette::Result<Result<(), McapError>> {
    let mut written = Ok(());
    let take = |event: HistoryEvent| {
        if event.at >= story.from && written.is_ok() {
            written = say_event(to, &story.about.cell, &event_row(story, &event), event.at);
        }
    };
    story.reader.each(story.to, take).map_err(failed)?;
    Ok(written)
}

/// An event of the cell or line that is called so.
pub fn say_event(to: &mut Recording, name: &str, row: &EventRow, at: Tick) -> Result<(), McapError> {
    let data: Value = serde_json::from_str(&row.data).unwrap_or_default();
    let message = json!({"log": row.log, "kind": row.kind, "station": row.station, "activity": row.activity,
        "part": row.part, "firing": row.firing, "data": data});
    to.say("/events", Schema::Event, at, &message)?;
    to.say("/log", Schema::Log, at, &log_line(name, row, at))
}

/// An event as a line of `foxglove.Log`.
fn log_line(name: &str, row: &EventRow, at: Tick) -> Value {
    let level = match row.kind.as_str() {
        "decided" | "acknowledged" | "memory" | "order-ended" | "planned" | "observed" => DEBUG,
        "raised" | "order-failed" | "alarm" | "mismatch" | "down" | "missing" | "gap" | "emergency-stop" | "fault" => {
            WARNING
        }
        // Whatever else there is, or will be.
        _ => INFO,
    };
    let micros = at.as_micros();
    let words = [row.activity.clone(), row.part.map(|part| format!("part {part}")), row.station.clone()];
    let words: Vec<String> = std::iter::once(row.kind.clone()).chain(words.into_iter().flatten()).collect();
    json!({
        "timestamp": {"sec": micros / 1_000_000, "nsec": micros % 1_000_000 * 1000},
        "level": level,
        "message": format!("{} {}", words.join(" "), row.data),
        "name": name,
        "file": "",
        "line": row.log.unwrap_or(0),
    })
}
