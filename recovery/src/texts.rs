//! Plans in words, for operators: what to do, where, what moves; one line for each step.

use std::time::Duration;

use linewright_coordinator_cell::texts::ListedAnswer;
use linewright_coordinator_logic::ModeCommand;
use linewright_line::net::{Block, StationPlace};
use linewright_line::{Line, OpId, Owner, StationId};

use crate::confirm;
use crate::ends::{LedActivity, LedOrder};
use crate::image;
use crate::plan::{RecoveryEnd, RecoveryPlan};
use crate::reason::{BackReason, OwnReason, StepReason};
use crate::situation::ActivityEnd;
use crate::step::{Need, PanelButton, PlannedMotion, RecoveryAction, RecoveryStep};

impl PanelButton {
    /// The button as panels and `linewright press` name it.
    pub const fn name(self) -> &'static str {
        match self {
            PanelButton::Advance => "advance",
            PanelButton::Return => "return",
        }
    }
}

impl Need {
    /// What is to be done, without the station.
    fn text(&self, line: &Line) -> String {
        match self {
            Need::Heard(_) => "no state received: start it again, or look at its host and network".to_owned(),
            Need::Devices(_) => "I/O devices lost: bring them back".to_owned(),
            Need::Console => "console: bring its I/O devices back".to_owned(),
            Need::Button => "release the emergency stop button at the console".to_owned(),
            Need::Standstill(_) => "wait until it stands".to_owned(),
            Need::FaultSignal(station, input) => {
                format!("fault signal {} on: remove its cause", line.input_text(Owner::Station(*station), *input))
            }
            Need::Axis { station, op, input, conflicts } => {
                let axis = &line.station(*station).axes[line.operation((*station, *op)).motion.axis.index()].name;
                let of = axis_of(line, *station, *input).unwrap_or(axis);
                let input = line.input_text(Owner::Station(*station), *input);
                let way: String = conflicts.iter().map(|&conflict| in_the_way_text(line, conflict, *station)).collect();
                format!("bring `{of}` by hand, with its drive off, onto {input}{way}")
            }
            Need::Selector(station, input) => {
                format!(
                    "turn the selector at its panel to auto: {} on",
                    line.input_text(Owner::Station(*station), *input)
                )
            }
            Need::Reset(_) => "in emergency stop by itself: reset it with `linewright resource`".to_owned(),
            Need::Bring(station, rest) => {
                format!("bring it to rest \"{}\", as its alarm says", line.station(*station).rests[rest.index()].name)
            }
            Need::Halt => "wait until the others have ended their tasks, and the mode is stand-by".to_owned(),
            Need::Acknowledged => "wait until every station has acknowledged the mode".to_owned(),
            Need::Settled { activity, stations } => {
                let names: Vec<&str> = stations.iter().map(|id| line.station(*id).name.as_str()).collect();
                let at = if names.is_empty() { String::new() } else { format!(" (left out: {})", names.join(" and ")) };
                format!("wait: {activity}{at}")
            }
            Need::Answer(alarm) => {
                let answers = alarm.answers.iter().map(ListedAnswer::text).collect::<Vec<_>>().join(" or ");
                let first = match alarm.answers.iter().all(ListedAnswer::is_contradicted) && !alarm.answers.is_empty() {
                    true => {
                        "No answer agrees with the sensors: see where the part is, and put it or the sensor right. "
                    }
                    false => "",
                };
                format!("alarm {}: {} {first}Then answer what you find at the machine: {answers}", alarm.id, alarm.text)
            }
            Need::Other(text) => text.clone(),
        }
    }
}

/// The axis that a switch measures.
fn axis_of(line: &Line, station: StationId, input: linewright_line::InputId) -> Option<&str> {
    let described = line.station(station);
    let ends_at = |op: &OpId| {
        let places = [StationPlace::operating(*op), StationPlace::undoing(*op)];
        places.iter().any(|&place| image::motion(described, place).0.complete == input)
    };
    let op = described.op_ids().find(ends_at)?;
    Some(&described.axes[described.operations[op.index()].motion.axis.index()].name)
}

/// What to look at before an axis is brought by hand to where, or past where, another station may stand.
fn in_the_way_text(line: &Line, conflict: usize, station: StationId) -> String {
    let conflict = &line.conflicts[conflict];
    let other = if conflict.a.station == station { conflict.b.station } else { conflict.a.station };
    format!(
        "; look first whether {} is in its way, there or on the way there ({})",
        line.station(other).name,
        conflict.why
    )
}

impl PlannedMotion {
    /// The motion, e.g. `advance clamp` to LS_closed; clamp to 40.
    pub fn text(&self, line: &Line) -> String {
        let station = line.station(self.station);
        let (name, undoing) =
            (&line.operation((self.station, self.place.op)).name, self.place.block == Block::Recovery);
        let way = station.operations[self.place.op.index()].motion;
        let (signals, _) = image::motion(station, self.place);
        let axis = &station.axes[way.axis.index()].name;
        if self.homes {
            let time = self.time.as_secs_f64();
            return format!(
                "the drive of `{axis}` is homed: it turns to its reference, forwards or back, its place is measured, within {time:.1} s"
            );
        }
        let to = match (station.index_of(self.place.op), self.to_place) {
            (Some(by), Some(place)) => format!("on by {by} to place {place}"),
            (Some(by), None) => format!("on by {by} to the next place"),
            (None, _) => format!("to {}", if undoing { way.from } else { way.to }),
        };
        let until = &station.inputs[signals.complete.index()];
        let verb = if undoing { "undone" } else { "done" };
        format!("`{name}` is {verb}: {axis} {to}, {until} on, {:.1} s", self.time.as_secs_f64())
    }
}

impl RecoveryStep {
    /// The step in one line.
    pub fn text(&self, line: &Line) -> String {
        let name = |id: StationId| line.station(id).name.as_str();
        let believed =
            if self.is_doubtful { "; its switch is on already: if that is reported as a fault, once more" } else { "" };
        match &self.action {
            RecoveryAction::First(need) => match need.station() {
                Some(station) => format!("{}: {}", name(station), need.text(line)),
                None => need.text(line),
            },
            RecoveryAction::Command(ModeCommand::Stop) => "command stop, and wait until nothing moves".to_owned(),
            RecoveryAction::Command(command) => format!("command {}", command.name()),
            RecoveryAction::ManualAlone(station) => {
                format!("{}: command manual for it alone; the others stay in auto: stay clear of them", name(*station))
            }
            RecoveryAction::AutoAgain(station) => format!("{}: command auto for it alone", name(*station)),
            RecoveryAction::Selector(station, manual) => {
                format!("{}: selector to {}", name(*station), if *manual { "manual" } else { "auto" })
            }
            RecoveryAction::Hold { button, station, rest } => {
                let moves = self.moves.iter().map(|motion| format!("{} {}", name(motion.station), motion.text(line)));
                format!(
                    "hold {} until {} stands at rest \"{}\": {}",
                    line.buttons[button.index()],
                    name(*station),
                    line.station(*station).rests[rest.index()].name,
                    moves.collect::<Vec<_>>().join(", then ")
                )
            }
            RecoveryAction::Press(station, button) if self.moves.is_empty() => {
                let places = self.after.iter().flat_map(|after| &after.places);
                let places: Vec<String> = places.map(|&place| confirm::place_text(line, *station, place)).collect();
                let (time, button) = (self.hold(line).as_secs_f64(), button.name());
                format!(
                    "{}: hold {button} for {time:.1} s: it is at the end already, so nothing moves, and the press counts ({}){believed}",
                    name(*station),
                    places.join(" and ")
                )
            }
            RecoveryAction::Press(station, button) => {
                let moves: Vec<String> = self.moves.iter().map(|motion| motion.text(line)).collect();
                format!("{}: hold {} until {}{believed}", name(*station), button.name(), moves.join(" and "))
            }
            RecoveryAction::Resume => {
                let moves = self.moves.iter().map(|motion| format!("{} {}", name(motion.station), motion.text(line)));
                format!("hold resume at the console until {}", moves.collect::<Vec<_>>().join(" and "))
            }
            RecoveryAction::Rejoin { station, at, or } => confirm::text(line, *station, (at, or)),
        }
    }

    /// Where several commands confirm a position: how the station stands in that of each, in the order of
    /// [`commands`](Self::commands). Empty for other steps.
    pub fn stands(&self, line: &Line) -> Vec<String> {
        match &self.action {
            RecoveryAction::Rejoin { station, or, .. } if !or.is_empty() => {
                self.action.choices().map(|choice| confirm::stands_text(line, *station, choice)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Time for which a button is held; all motions one after the other where several follow, or may have to.
    ///
    /// Half as long again as the motion takes by the description, for what messages take, and longer than its watchdog: what still
    /// keeps the motion from its end is reported as a fault then, and not as a button that was released. Where nothing is to move the
    /// same holds of a switch that is not taken for the arrival; it counts with the next press.
    pub fn hold(&self, line: &Line) -> Duration {
        let longest = self.moves.iter().map(|motion| motion.time).max().filter(|_| !self.is_doubtful);
        let watchdog = |station: StationId, op: OpId| line.operation((station, op)).watchdog;
        let moved = self.moves.iter().map(|motion| watchdog(motion.station, motion.place.op));
        let after =
            self.after.iter().flat_map(|after| after.places.iter().map(|place| watchdog(after.station, place.op)));
        let one = match longest {
            Some(time) => (time * 3 / 2).max(moved.max().unwrap_or_default()) + Duration::from_millis(500),
            None => after.max().unwrap_or_default() + Duration::from_secs(1),
        };
        let all: Duration = self.moves.iter().map(|motion| motion.time).sum();
        match self.action {
            RecoveryAction::Resume | RecoveryAction::Hold { .. } => one.max(all * 3 / 2 + Duration::from_millis(500)),
            _ => one,
        }
    }

    /// The commands of `linewright` for it, as arguments with `LINE` for the line. Of several one is given, by what is so at the
    /// machine; none for what no command does. An answer that sensors contradict would not be taken, and has none.
    pub fn commands(&self, line: &Line) -> Vec<Vec<String>> {
        let name = |id: StationId| line.station(id).name.clone();
        let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let one = match &self.action {
            RecoveryAction::First(Need::Answer(alarm)) => {
                let id = alarm.id.to_string();
                let taken = alarm.answers.iter().filter(|of| !of.is_contradicted());
                return taken.map(|of| words(&["answer", "LINE", &id, &of.word])).collect();
            }
            RecoveryAction::First(Need::Reset(station)) => words(&["resource", "LINE", &name(*station), "reset"]),
            RecoveryAction::First(_) => return Vec::new(),
            // What follows is refused before that.
            RecoveryAction::Command(ModeCommand::Stop) => words(&["mode", "LINE", "stop", "--wait"]),
            RecoveryAction::Command(command) => words(&["mode", "LINE", command.name()]),
            RecoveryAction::ManualAlone(station) => words(&["mode", "LINE", "manual", "--station", &name(*station)]),
            RecoveryAction::AutoAgain(station) => words(&["mode", "LINE", "auto", "--station", &name(*station)]),
            RecoveryAction::Press(station, button) => {
                let time = self.hold(line).as_secs_f64();
                words(&["press", "LINE", button.name(), "--station", &name(*station), "--for", &format!("{time:.1}")])
            }
            RecoveryAction::Hold { button, .. } => {
                let time = self.hold(line).as_secs_f64();
                words(&["press", "LINE", &line.buttons[button.index()], "--for", &format!("{time:.1}")])
            }
            RecoveryAction::Resume => {
                let time = self.hold(line).as_secs_f64();
                words(&["press", "LINE", "resume", "--for", &format!("{time:.1}")])
            }
            RecoveryAction::Selector(station, manual) => {
                words(&["press", "LINE", if *manual { "manual" } else { "auto" }, "--station", &name(*station)])
            }
            RecoveryAction::Rejoin { station, .. } => return confirm::commands(line, *station, self.action.choices()),
        };
        vec![one]
    }
}

/// A station that has been led to an end of its task, as a reason for the others of its activity.
pub(crate) fn reached(line: &Line, station: StationId, end: ActivityEnd) -> String {
    let name = &line.station(station).name;
    match end {
        ActivityEnd::Done => format!("{name} stands at the end of its task"),
        ActivityEnd::TakenBack => format!("{name} stands where its task began"),
    }
}

impl StepReason {
    /// Why the step is there, e.g. `feed` of mill_1 is incomplete; otherwise clamp_1 is refused `open`.
    pub fn text(&self, line: &Line) -> String {
        let name = |id: StationId| line.station(id).name.as_str();
        let mut parts: Vec<String> = self.own.iter().map(|&(id, own)| own.text(line, id)).collect();
        parts.extend(self.otherwise.map(|(id, place)| {
            let (op, undone) = (&line.operation((id, place.op)).name, place.block == Block::Recovery);
            format!("otherwise {} is refused {}`{op}`", name(id), if undone { "undoing " } else { "" })
        }));
        parts.extend(self.back.map(|back| match back {
            BackReason::NoWayOn => "advance does not move it".to_owned(),
            BackReason::EndNotSeen => "on, its switch is on already, and no motion would be seen to arrive".to_owned(),
            BackReason::Shorter => "back is shorter than on".to_owned(),
        }));
        parts.join("; ")
    }
}

impl OwnReason {
    fn text(self, line: &Line, id: StationId) -> String {
        let name = &line.station(id).name;
        match self {
            OwnReason::Incomplete(place) => {
                let undoing = if place.block == Block::Recovery { "undoing " } else { "" };
                format!("{undoing}`{}` of {name} is incomplete", line.operation((id, place.op)).name)
            }
            OwnReason::PositionLost => format!("the position of {name} is lost"),
            OwnReason::OnTheWayHome => format!("{name} is on its recovery path"),
            OwnReason::AtTheEndOfTheWayHome => {
                format!("{name} is on its recovery path, and stands at the end of it: this press ends the path")
            }
            OwnReason::BetweenRests => format!("{name} stands between two rests"),
            OwnReason::Away => format!("{name} is not at home, where all begin anew"),
        }
    }
}

impl LedActivity {
    /// Which way its stations are led, and why.
    pub fn text(&self, line: &Line) -> String {
        let names: Vec<&str> = self.stations.iter().map(|id| line.station(*id).name.as_str()).collect();
        let names = names.join(" and ");
        let unordered = match self.order {
            LedOrder::Kept => "",
            LedOrder::GivenUp => {
                ". No presses keep the order of their operations: before each see that one of them holds the part"
            }
            LedOrder::Unknown => {
                ". The description does not tell the order of their operations: before each press see that one of them holds the part"
            }
        };
        let (are, their) = if self.stations.len() > 1 { ("are", "their tasks") } else { ("is", "its task") };
        let Some(end) = self.end else {
            let are_not = if self.is_certain { "cannot be led" } else { "are not led, as far as was searched," };
            return format!(
                "alarm {}: {names} {are_not} to the same end of {their}: see where the part is, and answer by that{unordered}",
                self.alarm
            );
        };
        let (way, other, answer) = match end {
            ActivityEnd::Done => (format!("led on to the end of {their}"), "back", "done"),
            ActivityEnd::TakenBack => (format!("led back to where {their} began"), "on", "not begun"),
        };
        let why = match &self.decided {
            Some(decided) if decided.end == end => format!("since {}", decided.because),
            Some(decided) if self.is_certain => format!("although {}: no presses lead {other}", decided.because),
            Some(decided) => format!("although {}: no presses were found that lead {other}", decided.because),
            None => "which is shorter".to_owned(),
        };
        format!(
            "alarm {}: {names} {are} {way}, {why}. The answer is then that for what is {answer}{unordered}",
            self.alarm
        )
    }
}

impl RecoveryPlan {
    /// What is to be known before its steps: of stations that were to be led on, and cannot be.
    pub fn begin_text(&self, line: &Line) -> Option<String> {
        let names: Vec<&str> = self.not_led_on.iter().map(|id| line.station(*id).name.as_str()).collect();
        (!names.is_empty()).then(|| {
            format!(
                "{}: no presses lead on and to auto from here; the list is the one without that",
                names.join(" and ")
            )
        })
    }

    /// That a shorter list may exist, where the search was ended at its bound.
    pub fn shorter_text(&self) -> Option<&'static str> {
        (!self.is_shortest).then_some("there may be a shorter way: the search was ended")
    }

    /// What is to be known of its end: what auto does then, or why it does not lead there.
    pub fn end_text(&self, line: &Line) -> Vec<String> {
        match &self.end {
            RecoveryEnd::Auto if self.begins_anew && !self.steps.is_empty() => vec![
                "auto begins a new cycle at every station, as of an empty line: what lies in it passes on as it is, finished or not, and the \
                 next part may come onto it. Look at every station before; take parts out, or finish them in manual"
                    .to_owned(),
            ],
            RecoveryEnd::Auto => Vec::new(),
            RecoveryEnd::LookAgain if self.is_unsettled() => {
                vec!["not finished: what follows shows with the alarm of what has failed".to_owned()]
            }
            RecoveryEnd::LookAgain
                if matches!(self.steps.last(), Some(RecoveryStep { action: RecoveryAction::Rejoin { .. }, .. })) =>
            {
                vec!["what follows shows when that is confirmed".to_owned()]
            }
            RecoveryEnd::LookAgain => vec!["what follows shows when every station is heard".to_owned()],
            RecoveryEnd::Misfit(misfit) => {
                let name = &line.station(misfit.0).name;
                vec![format!("{name}: its report does not fit this description; give the one that it runs with")]
            }
            RecoveryEnd::NoWay { reasons, is_certain } => {
                let head = match is_certain {
                    true => {
                        "no presses lead to auto from here; look at the machine, and free by hand what is in the way; where a journal is \
                         lost, confirm that station once more, with another operation that fits (`rejoin --within`), or bring every \
                         station home by hand, drives off: from there `start` begins anew"
                    }
                    false => {
                        "no way to auto was found within the bounds of the search; lead the stations home in manual"
                    }
                };
                let waits = |(id, reasons): &(StationId, Vec<String>)| {
                    format!("{} waits for {}", line.station(*id).name, reasons.join("; "))
                };
                std::iter::once(head.to_owned()).chain(reasons.iter().map(waits)).collect()
            }
        }
    }
}
