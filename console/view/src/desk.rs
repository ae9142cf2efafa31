//! Control of a line by one page at a time, and what is given from there.
//!
//! One connection has control, from its taking until it gives it up, ends, or another one takes it. Only that one commands, and only while
//! what it shows is at most [`SEEN_WITHIN`] old; *estop* is given whatever the page shows. What is not given is answered with the reason,
//! and is never given later. Whatever is done beside a button that is held ends that press.

use std::collections::BTreeMap;
use std::time::Duration;

use linewright_coordinator_logic::ModeCommand;
use linewright_line::{Line, StationId};
use serde::Serialize;

use crate::bounds;
use crate::hold::{HoldButton, HoldEnd, HoldMachine, HoldMessage, SEEN_WITHIN};
use crate::lanes::ms;
use crate::message::{PageAct, PageOperation};
use crate::plan::{NextButton, PlanPart};
use crate::request::{CellRequest, NOTE_MAX};
use crate::texts::span;

/// Most characters of an operator's name.
const NAME_MAX: usize = 40;

/// Most requests that have no reply yet.
const ASKED_MAX: usize = 16;

/// Number of a connection, that of no other one of this console.
pub type ConnectionNumber = u64;

/// What a desk has to be done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DeskEffect {
    /// A mode command to be sent to the coordinator, as its topic `mode_cmd` has it, e.g. `auto` or `manual robot`.
    Command(String),
    /// A station's selector: true is manual.
    Select(StationId, bool),
    /// An alarm of the page, by its number there, is acknowledged by this operator with this note.
    Acknowledge { connection: ConnectionNumber, shown: u64, by: String, note: String },
    /// To be asked of the coordinator of the cell; its reply is for this connection (see [`ControlDesk::answered`]).
    Ask { connection: ConnectionNumber, request: CellRequest },
    /// To be logged.
    Log(String),
}

/// Control, as a page shows it.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ControlPart {
    /// The connection in control. Without one no page can give anything but *estop*.
    pub holder: Option<HolderPart>,
    /// The press that is held now.
    pub press: Option<PressPart>,
    /// Of each connection the last thing that was not given there, or has ended by itself.
    pub notes: BTreeMap<ConnectionNumber, DeskNote>,
}

/// The connection that has control.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct HolderPart {
    pub connection: ConnectionNumber,
    /// Its address, with the name of its operator where one was given.
    pub name: String,
    /// For how long.
    pub since: String,
}

/// A press that is held.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PressPart {
    pub number: u64,
    /// Name of the button.
    pub button: String,
}

/// Why something was not given, or has ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeskNote {
    /// That of the button (see [`PageAct::key`]).
    pub key: String,
    /// Number of the press that it is about.
    pub press: Option<u64>,
    pub text: String,
}

#[derive(Debug)]
struct OpenPage {
    address: String,
    /// The highest number of a press. None below it begins anything any more.
    last_press: u64,
}

#[derive(Debug)]
struct ControlHolder {
    connection: ConnectionNumber,
    name: String,
    since: Duration,
}

/// Who has control, and what is held.
#[derive(Debug)]
pub struct ControlDesk {
    line: Line,
    open: BTreeMap<ConnectionNumber, OpenPage>,
    holder: Option<ControlHolder>,
    hold: HoldMachine,
    notes: BTreeMap<ConnectionNumber, DeskNote>,
    next: NextButton,
    /// Connections whose request has no reply yet, with the key of its button.
    asked: BTreeMap<ConnectionNumber, (String, CellRequest)>,
}

impl ControlDesk {
    /// A desk without connections, and so without one in control.
    pub fn new(line: &Line) -> Self {
        ControlDesk {
            line: line.clone(),
            open: BTreeMap::new(),
            holder: None,
            hold: HoldMachine::default(),
            notes: BTreeMap::new(),
            next: NextButton::default(),
            asked: BTreeMap::new(),
        }
    }

    /// A page has connected, from this address.
    pub fn opened(&mut self, connection: ConnectionNumber, address: &str) {
        self.open.insert(connection, OpenPage { address: address.to_owned(), last_press: 0 });
    }

    /// A connection has ended, and with it its control.
    pub fn closed(&mut self, now: Duration, connection: ConnectionNumber) -> Vec<DeskEffect> {
        let mut effects = Vec::new();
        if self.has_control(connection) {
            self.end(now, HoldEnd::NoControl, &mut effects);
            effects.extend(self.holder.take().map(|of| DeskEffect::Log(format!("control ended with {}", of.name))));
        }
        self.open.remove(&connection);
        self.asked.remove(&connection);
        self.notes.remove(&connection);
        effects
    }

    /// Takes what is done at a page. `why_not`: why an act is not possible now; none where it is.
    pub fn take(
        &mut self,
        now: Duration,
        connection: ConnectionNumber,
        operation: &PageOperation,
        why_not: impl Fn(&PageAct) -> Option<String>,
    ) -> Vec<DeskEffect> {
        let mut effects = Vec::new();
        let Some(page) = self.open.get(&connection) else { return effects };
        let act = &operation.act;
        if let PageAct::Take { name } = act {
            let name = named(&page.address, name);
            match behind(now, operation) {
                Some(age) => self.refuse(connection, act, too_old(age)),
                None => self.take_control(now, connection, name, &mut effects),
            }
            return effects;
        }
        // It changes nothing, and ends nothing that is held.
        if let PageAct::Why { .. } = act {
            match behind(now, operation).map(too_old).or_else(|| why_not(act)) {
                Some(why) => self.refuse(connection, act, why),
                None => self.ask(connection, act, "", &mut effects),
            }
            return effects;
        }
        let is_stop = act.is_stop();
        if !self.has_control(connection) && !is_stop {
            if !matches!(act, PageAct::Beat { .. } | PageAct::Release { .. }) {
                self.refuse(connection, act, "not given: this page has no control; take it first".to_owned());
            }
            return effects;
        }
        if let PageAct::Beat { number } = act {
            self.beat(now, *number, behind(now, operation), why_not, &mut effects);
            return effects;
        }
        let is_own_release =
            matches!((act, self.hold.live()), (PageAct::Release { number }, Some((live, _))) if *number == live);
        let end = if is_own_release { HoldEnd::Released } else { HoldEnd::Another };
        let was_held = self.hold.live().is_some();
        self.end(now, end, &mut effects);
        if matches!(act, PageAct::Release { .. }) {
            return effects;
        }
        if let PageAct::GiveUp {} = act {
            effects.extend(self.holder.take().map(|of| DeskEffect::Log(format!("control given up by {}", of.name))));
            return effects;
        }
        let late = behind(now, operation).filter(|_| !is_stop).map(too_old);
        let former = operation.step.filter(|_| !is_stop).and_then(|step| self.next.why_not(now, step));
        if let Some(why) = late.or(former).or_else(|| why_not(act)) {
            if let PageAct::Press { number, .. } = act {
                self.number_is_new(connection, *number);
            }
            self.refuse(connection, act, why);
            return effects;
        }
        self.give(now, connection, act, was_held, &mut effects);
        effects
    }

    fn give(
        &mut self,
        now: Duration,
        connection: ConnectionNumber,
        act: &PageAct,
        was_held: bool,
        effects: &mut Vec<DeskEffect>,
    ) {
        self.notes.remove(&connection);
        let holder = self.holder.as_ref().filter(|of| of.connection == connection).map(|of| of.name.clone());
        let by = holder.or_else(|| Some(self.open.get(&connection)?.address.clone())).unwrap_or_default();
        match act {
            PageAct::Command { word, station } => {
                let known = ModeCommand::parse(word);
                let is_known = station.as_ref().is_none_or(|name| self.line.station_named(name).is_some());
                let Some(command) = known.filter(|_| is_known) else {
                    return self.refuse(connection, act, "not given: no such command".to_owned());
                };
                let of = station.as_ref().map_or_else(String::new, |name| format!(" {name}"));
                self.next.begin_anew(now);
                effects.push(DeskEffect::Log(format!("{}{of} commanded by {by}", command.name())));
                effects.push(DeskEffect::Command(format!("{}{of}", command.name())));
            }
            PageAct::Select { station, manual } => {
                let Some(id) = self.line.station_named(station) else {
                    return self.refuse(connection, act, "not given: no such station".to_owned());
                };
                let to = if *manual { "manual" } else { "auto" };
                self.next.begin_anew(now);
                effects.push(DeskEffect::Log(format!("selector of {station} turned to {to} by {by}")));
                effects.push(DeskEffect::Select(id, *manual));
            }
            PageAct::Press { number, station, button } => {
                let is_new = self.number_is_new(connection, *number);
                let Some(button) = HoldButton::named(&self.line, station.as_deref(), button) else {
                    return self.refuse(connection, act, "not held: no such button".to_owned());
                };
                if was_held || !is_new {
                    return self.refuse(connection, act, HoldEnd::Another.text().unwrap_or_default());
                }
                self.hold.press(now, *number, button);
                effects.push(DeskEffect::Log(format!("{} held by {by}", button.name(&self.line))));
            }
            PageAct::Acknowledge { shown, note } => {
                let note = line_of(note, NOTE_MAX);
                effects.push(DeskEffect::Acknowledge { connection, shown: *shown, by, note });
            }
            PageAct::Answer { .. }
            | PageAct::Submit { .. }
            | PageAct::Cancel { .. }
            | PageAct::Withdraw { .. }
            | PageAct::Resource { .. } => {
                self.next.begin_anew(now);
                self.ask(connection, act, &by, effects);
            }
            PageAct::Take { .. }
            | PageAct::GiveUp {}
            | PageAct::Beat { .. }
            | PageAct::Release { .. }
            | PageAct::Why { .. } => {}
        }
    }

    /// Asks the coordinator of the cell, one request of a connection at a time.
    fn ask(&mut self, connection: ConnectionNumber, act: &PageAct, by: &str, effects: &mut Vec<DeskEffect>) {
        let (Some(request), Some(key)) = (CellRequest::of(act, by), act.key()) else { return };
        if self.asked.contains_key(&connection) {
            return self.refuse(connection, act, "not given: the request before has no reply yet".to_owned());
        }
        if self.asked.len() == ASKED_MAX {
            return self.refuse(
                connection,
                act,
                "not given: too many requests have no reply yet; give it again".to_owned(),
            );
        }
        if !request.only_reads() {
            effects.push(DeskEffect::Log(format!("{} by {by}", request.text())));
        }
        self.notes.remove(&connection);
        self.asked.insert(connection, (key, request.clone()));
        effects.push(DeskEffect::Ask { connection, request });
    }

    /// The reply to the request of a connection, or why there is none.
    pub fn answered(&mut self, connection: ConnectionNumber, reply: Result<String, String>) -> Vec<DeskEffect> {
        let Some((key, request)) = self.asked.remove(&connection) else { return Vec::new() };
        let (outcome, text) = match reply {
            Ok(text) => ("done", text),
            Err(why) => ("refused", why),
        };
        let log = DeskEffect::Log(format!("{}: {outcome}: {text}", request.text()));
        self.note(connection, DeskNote { key, press: None, text: bounds::text(&text) });
        if request.only_reads() { Vec::new() } else { vec![log] }
    }

    /// That an acknowledgement has come too late for its alarm.
    pub fn not_acknowledged(&mut self, connection: ConnectionNumber, why: &str) {
        self.note(connection, DeskNote { key: "acknowledge".to_owned(), press: None, text: why.to_owned() });
    }

    fn beat(
        &mut self,
        now: Duration,
        number: u64,
        behind: Option<Duration>,
        why_not: impl Fn(&PageAct) -> Option<String>,
        effects: &mut Vec<DeskEffect>,
    ) {
        let Some((live, button)) = self.hold.live() else { return };
        let end = if let Some(age) = behind {
            Some(HoldEnd::Behind(age))
        } else if number != live {
            Some(HoldEnd::Another)
        } else {
            why_not(&button.act(&self.line)).map(HoldEnd::NotAllowed)
        };
        match end {
            Some(end) => self.end(now, end, effects),
            None => {
                let end = self.hold.beat(now, number);
                effects.extend(end.and_then(|end| self.ended(now, live, button, &end)));
            }
        }
    }

    /// Messages of held buttons that are to be published now. `why_not` as for [`ControlDesk::take`].
    pub fn due(
        &mut self,
        now: Duration,
        why_not: impl Fn(&PageAct) -> Option<String>,
    ) -> (Vec<HoldMessage>, Vec<DeskEffect>) {
        let mut effects = Vec::new();
        let live = self.hold.live();
        if let Some(why) = live.and_then(|(_, button)| why_not(&button.act(&self.line))) {
            self.end(now, HoldEnd::NotAllowed(why), &mut effects);
        }
        let (messages, end) = self.hold.due(now);
        if let (Some(end), Some((number, button))) = (end, live) {
            effects.extend(self.ended(now, number, button, &end));
        }
        (messages, effects)
    }

    /// The press that is live: its number and its button.
    pub fn live(&self) -> Option<(u64, HoldButton)> {
        self.hold.live()
    }

    /// Ends control and what is held, when the console ends.
    pub fn close(&mut self, now: Duration) -> Vec<DeskEffect> {
        self.holder.as_ref().map(|of| of.connection).map_or_else(Vec::new, |connection| self.closed(now, connection))
    }

    /// What the live press leads has arrived.
    pub fn arrived(&mut self, now: Duration) -> Vec<DeskEffect> {
        let mut effects = Vec::new();
        self.end(now, HoldEnd::Arrived, &mut effects);
        effects
    }

    /// The steps back to auto as pages show them from now on: the button of the next one does nothing for a while after that has changed.
    /// `is_current`: they are those of what is received now.
    pub fn plan(&mut self, now: Duration, plan: Option<PlanPart>, is_current: bool) -> Option<PlanPart> {
        self.next.shown(now, plan, is_current)
    }

    /// Control as it is at this time.
    pub fn part(&self, now: Duration) -> ControlPart {
        ControlPart {
            holder: self.holder.as_ref().map(|of| HolderPart {
                connection: of.connection,
                name: of.name.clone(),
                since: span(now.saturating_sub(of.since).as_secs_f64()),
            }),
            press: self.hold.live().map(|(number, button)| PressPart { number, button: button.name(&self.line) }),
            notes: self.notes.clone(),
        }
    }

    /// Whether this connection has control.
    pub fn has_control(&self, connection: ConnectionNumber) -> bool {
        self.holder.as_ref().is_some_and(|of| of.connection == connection)
    }

    fn take_control(
        &mut self,
        now: Duration,
        connection: ConnectionNumber,
        name: String,
        effects: &mut Vec<DeskEffect>,
    ) {
        self.end(now, HoldEnd::NoControl, effects);
        let from = self.holder.as_ref().filter(|of| of.connection != connection);
        let from = from.map_or_else(String::new, |of| format!(" from {}", of.name));
        effects.push(DeskEffect::Log(format!("control taken{from} by {name}")));
        self.notes.remove(&connection);
        self.holder = Some(ControlHolder { connection, name, since: now });
    }

    /// Whether a press has a number above all before of its connection. It is used with this.
    fn number_is_new(&mut self, connection: ConnectionNumber, number: u64) -> bool {
        let Some(page) = self.open.get_mut(&connection) else { return false };
        let is_new = number > page.last_press;
        page.last_press = page.last_press.max(number);
        is_new
    }

    fn end(&mut self, now: Duration, end: HoldEnd, effects: &mut Vec<DeskEffect>) {
        if let Some((number, button)) = self.hold.live() {
            self.hold.end(now);
            effects.extend(self.ended(now, number, button, &end));
        }
    }

    /// Notes the end of a press.
    fn ended(&mut self, now: Duration, number: u64, button: HoldButton, end: &HoldEnd) -> Option<DeskEffect> {
        let name = button.name(&self.line);
        let text = end.text();
        self.next.begin_anew(now);
        let log = DeskEffect::Log(format!("{name} {}", text.as_deref().unwrap_or("released")));
        let connection = self.holder.as_ref()?.connection;
        let key = button.act(&self.line).key().unwrap_or_default();
        match text {
            Some(text) => self.note(connection, DeskNote { key, press: Some(number), text }),
            None => drop(self.notes.remove(&connection)),
        }
        Some(log)
    }

    fn refuse(&mut self, connection: ConnectionNumber, act: &PageAct, text: String) {
        let press = match act {
            PageAct::Press { number, .. } => Some(*number),
            _ => None,
        };
        let key = bounds::text(&act.key().unwrap_or_default());
        self.note(connection, DeskNote { key, press, text });
    }

    /// Notes something for a connection that is there.
    fn note(&mut self, connection: ConnectionNumber, note: DeskNote) {
        if self.open.contains_key(&connection) {
            self.notes.insert(connection, note);
        }
    }
}

/// The age of what a page showed, where it is too old, or of another console.
fn behind(now: Duration, operation: &PageOperation) -> Option<Duration> {
    let age = ms(now).checked_sub(operation.seen_ms).map_or(Duration::MAX, Duration::from_millis);
    (age > SEEN_WITHIN).then_some(age)
}

fn too_old(age: Duration) -> String {
    match age {
        Duration::MAX => "not given: the page shows what another console has sent; load it again".to_owned(),
        age => format!("not given: the page showed what was {} ms old; look, then give it again", age.as_millis()),
    }
}

/// Text of an operator as one line of so many characters at most.
fn line_of(text: &str, most: usize) -> String {
    let line: String = text.chars().map(|of| if of.is_control() { ' ' } else { of }).collect();
    line.trim().chars().take(most).collect()
}

/// An address, with the name that was given.
fn named(address: &str, name: &str) -> String {
    let name = line_of(name, NAME_MAX);
    if name.is_empty() { address.to_owned() } else { format!("{name} ({address})") }
}
