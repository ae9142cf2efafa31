//! The keys of a scenario and of its steps.

use std::time::Duration;

use linewright_line::{BUTTONS_MAX, Line, OperationModule, Tick};
use linewright_plant::{InputFault, PartByHand};

use linewright_text::{Fields, Located, Problem, Report, TextRange};

use super::Scenario;
use super::vocabulary;
use crate::operator::{MotionSelection, OperatorAction};
use crate::options::{Network, NetworkChange};
use crate::script::{Script, ScriptAction, ScriptStep};

/// Steps in one scenario.
const STEPS_MAX: usize = 10_000;
/// Most cycles of a scenario.
const CYCLES_MAX: i64 = 10_000_000;

pub(super) fn scenario(line: &Line, text: &str, report: &mut Report) -> Option<Scenario> {
    let document = linewright_text::document(text, report)?;
    let mut fields = Fields::new(document.as_table(), 0..0, "a scenario");
    let title = fields.text(report, "title").map(|title| title.value);
    let cycles = fields.whole(report, "cycles", 0, CYCLES_MAX).map(|cycles| cycles.value as usize);
    let starts = fields.flag(report, "starts").is_none_or(|starts| starts.value);
    let variation = fields.within(report, "variation_percent", 0.0, 90.0).map_or(0.0, |percent| percent.value / 100.0);
    let network = fields.table(report, "network", "`network`").map(|table| network(table, report));
    let blocks = fields.tables(report, "step", "a step", STEPS_MAX);
    fields.finish(report);
    let network = network.unwrap_or_default().of(Network::default());
    let steps = blocks.into_iter().filter_map(|block| step(line, block, report)).collect();
    Some(Scenario {
        title,
        cycles,
        starts,
        variation,
        network,
        script: Script { steps },
        file_name: String::new(),
        text: String::new(),
    })
}

fn network(mut table: Fields<'_>, report: &mut Report) -> NetworkChange {
    let mut millis = |key: &'static str| {
        let number = table.within(report, key, 0.0, 10_000.0);
        number.map(|millis| Duration::from_secs_f64(millis.value / 1e3))
    };
    let (delay, jitter) = (millis("delay_ms"), millis("jitter_ms"));
    let loss = table.within(report, "loss_percent", 0.0, 100.0);
    table.finish(report);
    let loss_per_mille = loss.map(|percent| (percent.value * 10.0).round() as u32);
    NetworkChange { delay, jitter, loss_per_mille }
}

fn step(line: &Line, mut fields: Fields<'_>, report: &mut Report) -> Option<ScriptStep> {
    let span = fields.at.clone();
    if fields.is_empty() {
        report.add(Problem::error(span, "an empty step").hint("a step waits, does one thing, or expects"));
        return None;
    }
    let at = seconds(&mut fields, report, "at_s").map(|at| Tick::ZERO + at.value);
    let when = fields.text(report, "when").and_then(|when| vocabulary::condition(line, &when, report));
    let after = seconds(&mut fields, report, "after_s").map_or(Duration::ZERO, |after| after.value);
    let expects = fields.text(report, "expect");
    let expect_text = expects.as_ref().map_or(String::new(), |text| text.value.clone());
    let expect = expects.and_then(|expect| vocabulary::condition(line, &expect, report));
    let mut deeds = Deeds { found: Vec::new() };
    deeds.people(line, &mut fields, report);
    deeds.faults(line, &mut fields, report);
    if let Some(table) = fields.table(report, "network", "`network`") {
        let at = table.at.clone();
        deeds.add(at, Some(ScriptAction::Act(OperatorAction::Network(network(table, report)))));
    }
    fields.finish(report);
    if let [_, Located { at: second, .. }, ..] = deeds.found.as_slice() {
        let hint = "give the second one a step of its own; steps follow each other without a pause";
        report.add(Problem::error(second.clone(), "a step does one thing").hint(hint));
    }
    let deed = deeds.found.into_iter().next().map_or(ScriptAction::Nothing, |deed| deed.value);
    Some(ScriptStep { at, when, after, deed, expect, expect_text, span })
}

/// A time in seconds, at most a day; unlike the time of a mechanism it may be none at all.
fn seconds(fields: &mut Fields<'_>, report: &mut Report, key: &'static str) -> Option<Located<Duration>> {
    Some(fields.within(report, key, 0.0, 86_400.0)?.map(Duration::from_secs_f64))
}

/// Actions of a step, as far as they are found.
struct Deeds {
    found: Vec<Located<ScriptAction>>,
}

impl Deeds {
    fn add(&mut self, at: TextRange, deed: Option<ScriptAction>) {
        self.found.extend(deed.map(|deed| Located::new(deed, at)));
    }

    fn people(&mut self, line: &Line, fields: &mut Fields<'_>, report: &mut Report) {
        for key in ["command", "refused"] {
            if let Some(word) = fields.text(report, key) {
                let deed = if key == "command" { ScriptAction::Order } else { ScriptAction::Refused };
                self.add(word.at.clone(), vocabulary::command(&word, report).map(deed));
            }
        }
        let held = seconds(fields, report, "for_s");
        let time = held.as_ref().map_or(Duration::from_secs(1), |time| time.value);
        let mut presses = false;
        for key in ["jog", "press", "hold", "release"] {
            let Some(word) = fields.text(report, key) else { continue };
            presses |= key == "press";
            let at = word.at.clone();
            let deed = vocabulary::panel(line, &word, report).map(|(station, advance)| match key {
                "jog" => ScriptAction::Jog(station, advance),
                "press" => ScriptAction::Press(station, advance, time),
                _ => ScriptAction::Act(OperatorAction::Panel { station, advance, down: key == "hold" }),
            });
            self.add(at, deed);
        }
        if let Some(held) = held.filter(|_| !presses) {
            report.add(Problem::error(held.at, "`for_s` without `press`").hint("a step waits with `after_s`"));
        }
        if let Some(word) = fields.text(report, "selector") {
            let at = word.at.clone();
            let turned = vocabulary::selector(line, &word, report);
            self.add(at, turned.map(|(station, manual)| ScriptAction::Act(OperatorAction::Selector(station, manual))));
        }
        if let Some(Located { value: names, at }) = fields.texts(report, "buttons", BUTTONS_MAX) {
            let held = names.iter().filter_map(|name| vocabulary::button(line, name, report));
            let held = held.fold(0, |held, button| held | 1 << button);
            self.add(at, Some(ScriptAction::Act(OperatorAction::Buttons(held))));
        }
    }

    fn faults(&mut self, line: &Line, fields: &mut Fields<'_>, report: &mut Report) {
        let motion = fields.text(report, "motion");
        let motion_at = motion.as_ref().map(|motion| motion.at.clone());
        let way = motion.map_or(Some(MotionSelection::Both), |word| vocabulary::way(&word, report));
        let mut fails = false;
        for (fault, word) in super::faults::read(fields, report) {
            let at = word.at.clone();
            // What is cleared may be an input as well.
            if fault.is_none()
                && let Some((owner, input)) = vocabulary::known_input(line, &word)
            {
                self.add(at, Some(ScriptAction::Act(OperatorAction::Force(owner, input, None))));
                continue;
            }
            fails = true;
            let op = vocabulary::operation(line, &word, report);
            if let (Some(op), Some(MotionSelection::Recovery), Some(at)) = (op, way, &motion_at)
                && let OperationModule::Irreversible { .. } = line.operation(op).module
            {
                let name = &line.operation(op).name;
                let hint = "what its recovery path does are motions of the operations it names";
                let message = format!("`{name}` is irreversible: no motion undoes it");
                report.add(Problem::error(at.clone(), message).hint(hint));
            }
            self.add(at, op.zip(way).map(|(op, way)| ScriptAction::Act(OperatorAction::Fail(op, way, fault))));
        }
        if let Some(at) = motion_at.filter(|_| !fails) {
            let words: Vec<String> = super::faults::words().map(|(word, _)| format!("`{word}`")).collect();
            let hint = format!("it says which motions of one of these are meant: {}", words.join(", "));
            report.add(Problem::error(at, "`motion` of nothing").hint(hint));
        }
        for fault in InputFault::ALL {
            let Some(word) = fields.text(report, fault.name()) else { continue };
            let (at, value) = (word.at.clone(), Some(fault.value()));
            let input = vocabulary::input(line, &word, report);
            self.add(at, input.map(|(owner, input)| ScriptAction::Act(OperatorAction::Force(owner, input, value))));
        }
        for what in PartByHand::ALL {
            let Some(word) = fields.text(report, what.name()) else { continue };
            let at = word.at.clone();
            let place = vocabulary::place(line, &word, report);
            self.add(at, place.map(|place| ScriptAction::Act(OperatorAction::Part(what, place))));
        }
        for (key, lost) in [("device_lost", true), ("device_back", false)] {
            let Some(word) = fields.text(report, key) else { continue };
            let at = word.at.clone();
            let device = vocabulary::device(line, &word, report);
            self.add(at, device.map(|device| ScriptAction::Act(OperatorAction::Device(device, lost))));
        }
        for (key, kill) in [("kill", true), ("restart", false)] {
            let Some(word) = fields.text(report, key) else { continue };
            let at = word.at.clone();
            let process = vocabulary::process(line, &word, report);
            let act = |process| if kill { OperatorAction::Kill(process) } else { OperatorAction::Restart(process) };
            self.add(at, process.map(|process| ScriptAction::Act(act(process))));
        }
    }
}
