//! The check of a flexible cell: what was found as data, and in words.

use std::fmt::Write;
use std::path::Path;

use linewright_cell::net::Detail;
use linewright_cell::{Cell, ParsedCell};
use linewright_line::{Line, Problems};
use linewright_proof::cell::protocol::{ProtocolSetting, check_protocol_watched, properties};
use linewright_proof::cell::recovery::check_recovery;
use linewright_proof::cell::{
    CellExploration, CellPath, CellProperty, Checked, GroupExplored, Holding, Verdict, WaitingPart, check,
    check_conflicts,
};
use linewright_proof::explore::SearchLimits;
use miette::miette;
use serde::Serialize;

use super::explorer::Explorer;
use super::options::ExploreOptions;
use super::report::TextPlace;
use crate::load;
use crate::parts::PartList;

/// Property that no exploration of a cell decides.
pub const BREAKDOWN: &str = "whether parts are finished in time, or with a resource failed: exploration has no \
     failures and no time";
/// Property that is open without exploration.
pub const NOT_EXPLORED: &str = "whether parts of the cell get stuck: explore for that, without --structure";
/// More groups than this are not listed one by one.
const GROUPS_SHOWN: usize = 12;
/// Nor are more resources of one.
const RESOURCES_SHOWN: usize = 12;

/// Everything that was found of a cell.
#[derive(Debug, Serialize)]
pub struct CellReport {
    /// Its name; none if the description could not be understood.
    pub name: Option<String>,
    /// No violation and no error in the text.
    pub ok: bool,
    /// With so many parts at once nothing is wrong; none if nothing was explored.
    pub sound_parts: Option<u32>,
    /// Groups explored: resources that have nothing to do with each other, each for itself.
    pub groups: Vec<GroupReport>,
    pub properties: Vec<CellFinding>,
    /// Warnings on the text.
    pub warnings: Vec<TextPlace>,
    /// Errors in the text.
    pub problems: Vec<TextPlace>,
}

/// One exploration.
#[derive(Debug, Serialize)]
pub struct GroupReport {
    pub resources: Vec<String>,
    /// With so many parts at once; the figures are those of this search.
    pub parts: u32,
    /// States seen.
    pub states: u64,
    /// Steps from state to state.
    pub arcs: u64,
    /// Memory it took, about.
    pub bytes: usize,
    /// With so many parts at once nothing is wrong here.
    pub sound_parts: u32,
    /// Everything was seen, or something wrong.
    pub exhausted: bool,
}

/// One property.
#[derive(Debug, Serialize)]
pub struct CellFinding {
    /// Name of the property.
    pub name: &'static str,
    /// `holds`, `fails`, `undecided` or `remark`.
    pub verdict: &'static str,
    /// Reason of the verdict.
    pub reason: String,
    /// Remedy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
    /// Path to the violation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counterexample: Option<CellCounterexample>,
}

/// A story as data.
#[derive(Debug, Serialize)]
pub struct CellCounterexample {
    /// Steps, in order.
    pub steps: Vec<String>,
    /// Violation at the end.
    pub end: String,
    /// Content of each resource then.
    pub resources: Vec<FinalResource>,
}

/// A resource at the end of a story.
#[derive(Debug, Serialize)]
pub struct FinalResource {
    /// Name, as in the description.
    pub name: String,
    /// Number of parts it can hold or carry.
    pub capacity: u32,
    /// Those that it has.
    pub parts: Vec<FinalPart>,
}

/// A part at the end of a story.
#[derive(Debug, Serialize)]
pub struct FinalPart {
    pub part: String,
    /// Its stage.
    pub stage: String,
    /// Its position in the resource, if there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<String>,
    /// Needs of each way on; none if it can go on.
    pub needs: Vec<String>,
}

impl CellReport {
    fn nothing() -> Self {
        CellReport {
            name: None,
            ok: false,
            sound_parts: None,
            groups: Vec::new(),
            properties: Vec::new(),
            warnings: Vec::new(),
            problems: Vec::new(),
        }
    }

    fn add(&mut self, found: Checked) {
        self.ok = found.holds();
        self.sound_parts = Some(found.sound);
        self.groups = found.groups.into_iter().map(GroupReport::from).collect();
        self.properties = found.properties.into_iter().map(CellFinding::from).collect();
    }
}

impl CellReport {
    fn add_more(&mut self, found: Vec<CellProperty>) {
        let is_right = |property: &CellProperty| matches!(property.verdict, Verdict::Holds | Verdict::Remark);
        self.ok &= found.iter().all(is_right);
        self.properties.extend(found.into_iter().map(CellFinding::from));
    }

    /// Adds what is found of tasks in conflict.
    fn keep_apart(&mut self, setting: &CellExploration<'_>, line: &Line) {
        match check_conflicts(setting, line) {
            Ok(found) => self.add_more(found),
            Err(why) => (self.ok, self.problems) = (false, vec![placeless(why.to_string())]),
        }
    }

    /// Adds what is found of the order protocol, activity by activity.
    fn follow_orders(&mut self, cell: &Cell, line: &Line, explorer: &Explorer<'_>) {
        let Explorer { options, progress } = explorer;
        let mut setting = ProtocolSetting::new(cell, line);
        let SearchLimits { states, bytes } = options.order_limits();
        (setting.states, setting.bytes) = (states, bytes);
        let begins = |nth, number, name: &str| progress.shows(&format!("orders of activity {nth} of {number}, {name}"));
        match check_protocol_watched(&setting, &progress.search, begins) {
            Ok(found) => {
                let mut properties = properties(&found);
                let help = found.iter().find_map(|one| one.limit).map(|limit| options.further_orders(limit));
                let open = properties.iter_mut().filter(|property| property.verdict == Verdict::Undecided);
                open.for_each(|property| property.help = help.clone());
                self.add_more(properties);
            }
            // A cell without reserved grasps is checked, and not played.
            Err(why) => self.properties.push(CellFinding {
                name: "the orders of its activities keep their rules",
                verdict: "remark",
                reason: why.to_string(),
                help: None,
                counterexample: None,
            }),
        }
    }
}

/// Reads the description of a cell; its problems and warnings are drawn on standard error unless `quiet`. A report where it is none.
///
/// # Errors
/// When the warnings cannot be drawn in their text.
pub fn read(file: &Path, line: Option<&Line>, quiet: bool) -> miette::Result<Result<ParsedCell, CellReport>> {
    match load::cell(file, line) {
        Ok(parsed) => {
            if !quiet {
                super::draw_warnings(file, parsed.warnings.clone())?;
            }
            Ok(Ok(parsed))
        }
        Err(error) => {
            if !quiet {
                crate::out::complain!("{error:?}");
            }
            Ok(Err(of_error(&error)))
        }
    }
}

/// Checks the cell of a description.
///
/// # Errors
/// When the options name things that the cell does not have.
pub fn judge(parsed: &ParsedCell, line: Option<&Line>, explorer: &Explorer<'_>) -> miette::Result<CellReport> {
    let options = explorer.options;
    let mut report = CellReport {
        name: Some(parsed.cell.name.clone()),
        ok: true,
        warnings: parsed.warnings.iter().map(TextPlace::from).collect(),
        ..CellReport::nothing()
    };
    if options.asks_to_explore() {
        let setting = setting(&parsed.cell, options)?;
        explorer.progress.shows("whether parts of the cell get stuck");
        match check(&setting) {
            Ok(found) => report.add(found),
            Err(why) => (report.ok, report.problems) = (false, vec![placeless(why.to_string())]),
        }
        if report.ok {
            report.add_more(check_recovery(&parsed.cell, line));
        }
        if let Some(line) = line.filter(|_| report.ok) {
            report.keep_apart(&setting, line);
        }
        if let Some(line) = line.filter(|_| report.ok) {
            report.follow_orders(&parsed.cell, line, explorer);
        }
    }
    Ok(report)
}

/// An error without a place in the text.
fn placeless(message: String) -> TextPlace {
    TextPlace { line: None, column: None, message, help: None }
}

fn of_error(error: &miette::Report) -> CellReport {
    let Some(problems) = error.downcast_ref::<Problems>() else {
        return CellReport { problems: vec![placeless(format!("{error:#}"))], ..CellReport::nothing() };
    };
    let (warnings, errors): (Vec<_>, Vec<_>) = problems.iter().partition(|problem| problem.is_warning);
    CellReport {
        warnings: warnings.into_iter().map(TextPlace::from).collect(),
        problems: errors.into_iter().map(TextPlace::from).collect(),
        ..CellReport::nothing()
    }
}

fn setting<'c>(cell: &'c Cell, options: &ExploreOptions) -> miette::Result<CellExploration<'c>> {
    let mut setting = CellExploration::new(cell);
    setting.limits = options.cell_limits();
    if options.expanded {
        setting.detail = Detail::Expanded;
    }
    if !options.parts.is_empty() {
        let mut counts = vec![0; cell.part_types.len()];
        for (name, count) in PartList::sum(&options.parts) {
            let id = cell.part_type_named(&name).ok_or_else(|| {
                let known: Vec<&str> = cell.part_types.iter().map(|part| part.name.as_str()).collect();
                miette!("no part type '{name}'; the cell has {}", known.join(", "))
            })?;
            counts[id.index()] = count;
        }
        setting.parts = Some(counts);
    }
    Ok(setting)
}

impl From<GroupExplored> for GroupReport {
    fn from(GroupExplored { resources, parts, states, arcs, bytes, sound, exhausted }: GroupExplored) -> Self {
        GroupReport { resources, parts, states, arcs, bytes, sound_parts: sound, exhausted }
    }
}

impl From<CellProperty> for CellFinding {
    fn from(CellProperty { name, verdict, reason, help, counterexample }: CellProperty) -> Self {
        let verdict = match verdict {
            Verdict::Holds => "holds",
            Verdict::Fails => "fails",
            Verdict::Undecided => "undecided",
            Verdict::Remark => "remark",
        };
        CellFinding { name, verdict, reason, help, counterexample: counterexample.map(CellCounterexample::from) }
    }
}

impl From<CellPath> for CellCounterexample {
    fn from(CellPath { steps, end, resources }: CellPath) -> Self {
        CellCounterexample { steps, end, resources: resources.into_iter().map(FinalResource::from).collect() }
    }
}

impl From<Holding> for FinalResource {
    fn from(Holding { name, capacity, parts }: Holding) -> Self {
        FinalResource { name, capacity, parts: parts.into_iter().map(FinalPart::from).collect() }
    }
}

impl From<WaitingPart> for FinalPart {
    fn from(WaitingPart { part, stage, at, needs }: WaitingPart) -> Self {
        FinalPart { part, stage, at, needs }
    }
}

/// The result in words.
pub fn write(report: &CellReport, out: &mut String) -> std::fmt::Result {
    writeln!(out)?;
    for group in report.groups.iter().take(GROUPS_SHOWN) {
        let GroupReport { resources, parts, states, arcs, bytes, .. } = group;
        let mebibytes = bytes.div_ceil(1 << 20);
        let shown = resources.iter().take(RESOURCES_SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = match resources.len().saturating_sub(RESOURCES_SHOWN) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        writeln!(out, "{shown}{more}: with up to {parts} parts at once")?;
        writeln!(out, "  {states} states, {arcs} arcs, {mebibytes} MiB")?;
    }
    if let Some(more @ 1..) = report.groups.len().checked_sub(GROUPS_SHOWN) {
        writeln!(out, "and {more} groups of resources more")?;
    }
    for problem in report.problems.iter().filter(|problem| problem.line.is_none()) {
        writeln!(out, "✗ {}", problem.message)?;
    }
    for (nth, finding) in report.properties.iter().enumerate() {
        let CellFinding { name, verdict, reason, help, counterexample } = finding;
        writeln!(out, "{} {name}: {reason}", super::show::sign(verdict))?;
        if let Some(counterexample) = counterexample {
            story(counterexample, out)?;
        }
        // Of several in a row with the same help, the last has it.
        let next = report.properties.get(nth + 1).and_then(|next| next.help.as_ref());
        if let Some(help) = help.as_ref().filter(|help| next != Some(help)) {
            writeln!(out, "  help: {help}")?;
        }
    }
    Ok(())
}

fn story(story: &CellCounterexample, out: &mut String) -> std::fmt::Result {
    writeln!(out)?;
    for (nth, step) in story.steps.iter().enumerate() {
        writeln!(out, "{:6}. {step}", nth + 1)?;
    }
    writeln!(out, "        and so: {}\n", story.end)?;
    for FinalResource { name, capacity, parts } in &story.resources {
        if parts.is_empty() {
            writeln!(out, "    {name} has nothing")?;
            continue;
        }
        writeln!(out, "    {name} has {} of {capacity}:", parts.len())?;
        for FinalPart { part, stage, at, needs } in parts {
            let at = at.as_ref().map(|at| format!(", {at}")).unwrap_or_default();
            let needs = if needs.is_empty() { "can go on".to_owned() } else { needs.join(", or ") };
            writeln!(out, "      {part} ({stage}){at}: {needs}")?;
        }
    }
    writeln!(out)
}
