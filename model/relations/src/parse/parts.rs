//! Machines, zones, conditions and functions of `relations.toml`.

use linewright_text::{LocatedName, NAME_MAX, Problem, suggestion};

use super::findings::{DescribedPart, TableFindings};
use super::raw::{RawComponent, RawMachine, RawRelations};
use crate::{
    CellFunction, CellMachine, CollisionZone, ComponentRef, ComponentState, ConditionId, MachineComponent, MachineId,
    Relations, StartCondition,
};

/// Words that names may not be: they mean something in cells.
const RESERVED: [&str; 4] = ["and", "or", "all", "initially"];

/// Whether a text can be a name in tables.
fn is_name(text: &str) -> bool {
    let fits = |sign: char| sign.is_alphanumeric() || sign == '_' || sign == '-';
    text.starts_with(|sign: char| sign.is_alphanumeric())
        && text.chars().all(fits)
        && text.chars().count() <= NAME_MAX
        && !RESERVED.contains(&text)
}

/// Reports a name that cells of tables could not contain; gives it back where it is one.
pub(super) fn name(findings: &mut TableFindings<'_>, file: usize, name: &LocatedName, what: &str) -> Option<String> {
    if is_name(&name.value) {
        return Some(name.value.clone());
    }
    let message = format!("`{}` cannot name {what}", name.value.escape_debug());
    let hint =
        format!("one word of letters, digits, `_` and `-`, at most {NAME_MAX}, and none of {}", RESERVED.join(", "));
    findings.reports[file].add(Problem::error(name.at.clone(), message).hint(hint));
    None
}

/// The parts that are well named, each name once.
struct Known<'a> {
    what: &'static str,
    names: Vec<&'a LocatedName>,
}

impl<'a> Known<'a> {
    fn of(what: &'static str) -> Self {
        Known { what, names: Vec::new() }
    }

    /// The name of a new part; none where it has none, or another part has it.
    fn add(&mut self, written: &'a Option<LocatedName>, findings: &mut TableFindings<'_>) -> Option<String> {
        let file = findings.description;
        let written = written.as_ref()?;
        let value = name(findings, file, written, self.what)?;
        if let Some(first) = self.names.iter().find(|first| first.value == value) {
            let message = format!("a second name `{value}` of {}", self.what);
            findings.reports[file].add(Problem::error(written.at.clone(), message).earlier(first.at.clone()));
            return None;
        }
        self.names.push(written);
        Some(value)
    }
}

fn title(title: &Option<LocatedName>, name: &str) -> String {
    title.as_ref().map_or_else(|| name.to_owned(), |title| title.value.clone())
}

/// Reads everything but the tables.
pub(super) fn read(raw: &RawRelations, findings: &mut TableFindings<'_>) -> Relations {
    let named = raw.name.as_ref().and_then(|written| name(findings, findings.description, written, "a cell"));
    let named = named.unwrap_or_default();
    let mut relations = Relations {
        title: title(&raw.title, &named),
        name: named,
        products_max: usize::try_from(raw.products_max).unwrap_or(1),
        machines: Vec::new(),
        zones: Vec::new(),
        conditions: Vec::new(),
        functions: Vec::new(),
        operations: Vec::new(),
        sequences: Vec::new(),
        executions: Vec::new(),
        interlocks: Vec::new(),
        files: Vec::new(),
    };
    let mut known = Known::of("a machine");
    for machine in &raw.machines {
        if let Some(name) = known.add(&machine.name, findings) {
            let id = MachineId(relations.machines.len());
            findings.note_part(DescribedPart::Machine(id), place(&machine.name));
            let components = components(machine, findings);
            relations.machines.push(CellMachine { title: title(&machine.title, &name), name, components });
        }
    }
    let mut known = Known::of("a zone");
    for zone in &raw.zones {
        if let Some(name) = known.add(&zone.name, findings) {
            relations.zones.push(CollisionZone { title: title(&zone.title, &name), name });
        }
    }
    let mut known = Known::of("a condition");
    for condition in &raw.conditions {
        let Some(name) = known.add(&condition.name, findings) else { continue };
        findings.note_part(DescribedPart::Condition(ConditionId(relations.conditions.len())), place(&condition.name));
        let written = condition.states.iter().flatten();
        let states = written.filter_map(|(of, state)| condition_state(&relations, of, state, findings)).collect();
        let product = condition.product.as_ref();
        let file = findings.description;
        let product = product.and_then(|product| self::name(findings, file, product, "a product"));
        let cycle = u32::try_from(condition.cycle).unwrap_or(1);
        relations.conditions.push(StartCondition {
            title: title(&condition.title, &name),
            name,
            product,
            cycle,
            states,
        });
    }
    let mut known = Known::of("a function");
    for function in &raw.functions {
        if let (Some(name), Some(block)) = (known.add(&function.name, findings), &function.block) {
            let block = block.value.clone();
            relations.functions.push(CellFunction { title: title(&function.title, &name), name, block });
        }
    }
    for (what, is_empty) in [("machine", raw.machines.is_empty()), ("condition", raw.conditions.is_empty())] {
        if is_empty {
            let problem = Problem::error(0..0, format!("this cell has no {what}"));
            findings.reports[findings.description]
                .add(problem.hint(format!("describe each under a header `[[{what}]]`")));
        }
    }
    relations
}

fn place(name: &Option<LocatedName>) -> linewright_text::TextRange {
    name.as_ref().map_or(0..0, |name| name.at.clone())
}

fn components(raw: &RawMachine, findings: &mut TableFindings<'_>) -> Vec<MachineComponent> {
    let mut known = Known::of("a component");
    let mut components = Vec::new();
    for written in &raw.components {
        let (Some(name), Some(kind)) = (known.add(&written.name, findings), &written.kind) else { continue };
        components.push(MachineComponent {
            title: title(&written.title, &name),
            kind: kind.value,
            states: states(written, &name, findings),
            subcomponents: written.subcomponents.iter().map(|part| part.value.clone()).collect(),
            block: written.block.as_ref().map(|block| block.value.clone()),
            name,
        });
    }
    components
}

/// The states of a component: at least two (rule 1).
fn states(raw: &RawComponent, component: &str, findings: &mut TableFindings<'_>) -> Vec<String> {
    let Some(written) = &raw.states else { return Vec::new() };
    let file = findings.description;
    let mut states: Vec<String> = Vec::new();
    for state in &written.value {
        let Some(word) = name(findings, file, state, "a state") else { continue };
        if states.contains(&word) {
            findings.reports[file].add(Problem::error(state.at.clone(), format!("state `{word}` twice")));
        } else {
            states.push(word);
        }
    }
    if written.value.len() < 2 {
        let message = format!("`{component}` has {} states", written.value.len());
        let hint = "a component can be in one of at least two states (rule 1); what never changes is left out";
        findings.reports[file].add(Problem::error(written.at.clone(), message).hint(hint));
    }
    states
}

fn condition_state(
    relations: &Relations,
    of: &LocatedName,
    state: &LocatedName,
    findings: &mut TableFindings<'_>,
) -> Option<(ComponentRef, ComponentState)> {
    let file = findings.description;
    if !of.value.contains('.') {
        let known: Vec<String> = all_components(relations);
        let problem = Problem::error(of.at.clone(), format!("`{}` names no machine", of.value))
            .maybe_hint(suggestion(&of.value, known.iter().map(String::as_str)))
            .label("as in \"MACHINE.component\"");
        findings.reports[file].add(problem);
        return None;
    }
    let of = findings.component(relations, file, of, None)?;
    Some((of, component_state(relations, of, state, file, findings)?))
}

fn all_components(relations: &Relations) -> Vec<String> {
    let machines = relations.machines.iter();
    machines.flat_map(|m| m.components.iter().map(move |component| format!("{}.{}", m.name, component.name))).collect()
}

/// The state of a component that a name stands for.
pub(super) fn component_state(
    relations: &Relations,
    of: ComponentRef,
    state: &LocatedName,
    file: usize,
    findings: &mut TableFindings<'_>,
) -> Option<ComponentState> {
    let what = format!("state of {}", relations.component_name(of));
    let known = relations.component(of).states.iter().map(String::as_str);
    findings.find(file, state, &what, known).map(ComponentState)
}
