//! The keys of a scenario and of its steps.

use std::time::Duration;

use linewright_line::{Line, Tick};
use linewright_plant::Fault;

use super::Scenario;
use super::fields::{At, Fields, Report};
use super::words;
use crate::operator::{Action, Way};
use crate::options::Network;
use crate::script::{Deed, Script, Step};

/// Steps in one scenario.
const STEPS_MAX: usize = 10_000;

pub(super) fn scenario(line: &Line, text: &str, report: &mut Report) -> Option<Scenario> {
    let document = match toml_edit::Document::parse(text) {
        Ok(document) => document,
        Err(error) => {
            report.error(error.span().unwrap_or(0..0), error.message().to_owned(), None);
            return None;
        }
    };
    let mut fields = Fields::new(document.as_table(), 0..0, "a scenario");
    let title = fields.text(report, "title").map(|(title, _)| title.to_owned());
    let cycles = fields.number(report, "cycles", 0.0, 1e7).map(|(cycles, _)| cycles as usize);
    let starts = fields.flag(report, "starts").is_none_or(|(starts, _)| starts);
    let variation = fields.number(report, "variation_percent", 0.0, 90.0).map_or(0.0, |(percent, _)| percent / 100.0);
    let network = fields.table(report, "network", "`network`").map(|table| network(table, Network::default(), report));
    let blocks = fields.blocks(report, "step", "a step", STEPS_MAX);
    fields.finish(report);
    let network = network.unwrap_or_default();
    let steps = blocks.into_iter().filter_map(|block| step(line, text, network, block, report)).collect();
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

fn network(mut table: Fields<'_>, before: Network, report: &mut Report) -> Network {
    let mut millis = |key: &'static str, before: Duration| {
        let number = table.number(report, key, 0.0, 10_000.0);
        number.map_or(before, |(millis, _)| Duration::from_secs_f64(millis / 1e3))
    };
    let (delay, jitter) = (millis("delay_ms", before.delay), millis("jitter_ms", before.jitter));
    let loss = table.number(report, "loss_percent", 0.0, 100.0);
    table.finish(report);
    let loss_per_mille = loss.map_or(before.loss_per_mille, |(percent, _)| (percent * 10.0).round() as u32);
    Network { delay, jitter, loss_per_mille }
}

fn step(line: &Line, text: &str, before: Network, mut fields: Fields<'_>, report: &mut Report) -> Option<Step> {
    let span = fields.at.clone();
    let at = fields.seconds(report, "at_s").map(|(at, _)| Tick::ZERO + at);
    let when = fields.text(report, "when").and_then(|when| words::condition(line, when, report));
    let after = fields.seconds(report, "after_s").map_or(Duration::ZERO, |(after, _)| after);
    let expects = fields.text(report, "expect");
    let expect_text = expects.as_ref().map_or(String::new(), |(text, _)| (*text).to_owned());
    let expect = expects.and_then(|expect| words::condition(line, expect, report));
    let mut deeds = Deeds { found: Vec::new() };
    deeds.people(line, &mut fields, report);
    deeds.faults(line, &mut fields, report);
    if let Some(table) = fields.table(report, "network", "`network`") {
        let at = table.at.clone();
        deeds.found.push((Deed::Act(Action::Network(network(table, before, report))), at));
    }
    fields.finish(report);
    if let [_, (_, second), ..] = deeds.found.as_slice() {
        let hint = "give the second one a step of its own; steps follow each other without a pause";
        report.error(second.clone(), "a step does one thing", Some(hint.to_owned()));
    }
    let deed = deeds.found.into_iter().next().map_or(Deed::Nothing, |(deed, _)| deed);
    let number = text[..span.start.min(text.len())].matches('\n').count() + 1;
    Some(Step { at, when, after, deed, expect, expect_text, span, line: number })
}

/// What a step does, as far as it is found.
struct Deeds {
    found: Vec<At<Deed>>,
}

impl Deeds {
    fn add(&mut self, at: std::ops::Range<usize>, deed: Option<Deed>) {
        self.found.extend(deed.map(|deed| (deed, at)));
    }

    fn people(&mut self, line: &Line, fields: &mut Fields<'_>, report: &mut Report) {
        for key in ["command", "refused"] {
            if let Some(word) = fields.text(report, key) {
                let deed = if key == "command" { Deed::Order } else { Deed::Refused };
                self.add(word.1.clone(), words::command(word, report).map(deed));
            }
        }
        let time = fields.seconds(report, "for_s").map_or(Duration::from_secs(1), |(time, _)| time);
        for key in ["jog", "press", "hold", "release"] {
            let Some(word) = fields.text(report, key) else { continue };
            let at = word.1.clone();
            let deed = words::panel(line, word, report).map(|(station, advance)| match key {
                "jog" => Deed::Jog(station, advance),
                "press" => Deed::Press(station, advance, time),
                _ => Deed::Act(Action::Panel { station, advance, down: key == "hold" }),
            });
            self.add(at, deed);
        }
        if let Some(word) = fields.text(report, "selector") {
            let at = word.1.clone();
            let turned = words::selector(line, word, report);
            self.add(at, turned.map(|(station, manual)| Deed::Act(Action::Selector(station, manual))));
        }
        if let Some((names, at)) = fields.texts(report, "buttons") {
            let held = names.into_iter().filter_map(|name| words::button(line, name, report));
            let held = held.fold(0, |held, button| held | 1 << button);
            self.add(at, Some(Deed::Act(Action::Buttons(held))));
        }
    }

    fn faults(&mut self, line: &Line, fields: &mut Fields<'_>, report: &mut Report) {
        let way = fields.text(report, "motion").map_or(Some(Way::Both), |word| words::way(word, report));
        let faults = [
            ("jam", Some(Fault::Stick)),
            ("slow", Some(Fault::Slip)),
            ("break", Some(Fault::Break)),
            ("slip_back", Some(Fault::SlipBack)),
            ("repair", None),
        ];
        for (key, fault) in faults {
            let Some(word) = fields.text(report, key) else { continue };
            let at = word.1.clone();
            let op = words::operation(line, word, report);
            self.add(at, op.zip(way).map(|(op, way)| Deed::Act(Action::Fail(op, way, fault))));
        }
        for (key, value) in [("input_on", Some(true)), ("input_off", Some(false)), ("input_free", None)] {
            let Some(word) = fields.text(report, key) else { continue };
            let at = word.1.clone();
            let input = words::input(line, word, report);
            self.add(at, input.map(|(owner, input)| Deed::Act(Action::Force(owner, input, value))));
        }
        for (key, lost) in [("device_lost", true), ("device_back", false)] {
            let Some(word) = fields.text(report, key) else { continue };
            let at = word.1.clone();
            let device = words::device(line, word, report);
            self.add(at, device.map(|device| Deed::Act(Action::Device(device, lost))));
        }
        for (key, kill) in [("kill", true), ("restart", false)] {
            let Some(word) = fields.text(report, key) else { continue };
            let at = word.1.clone();
            let process = words::process(line, word, report);
            let act = |process| if kill { Action::Kill(process) } else { Action::Restart(process) };
            self.add(at, process.map(|process| Deed::Act(act(process))));
        }
    }
}
