//! Small cells with everything that restricts, from a seed.

use std::fmt::Write as _;

use linewright_random::Random;
use linewright_relations::{ConditionId, Relations, SourceText, parse};

/// Tables of a cell, as text.
#[derive(Default)]
struct Tables {
    description: String,
    operations: String,
    relations: String,
    executions: String,
    interlocks: String,
}

/// An operation that is being made up.
struct Made {
    id: String,
    machine: usize,
    /// Later ones may have earlier ones as predecessors.
    rank: usize,
}

/// A cell and its products; `None` where what was made up is no sound description.
pub fn cell(seed: u64) -> Option<(Relations, Vec<ConditionId>)> {
    let mut random = Random::new(seed);
    let tables = tables(&mut random);
    let sources = [
        ("relations.toml", &tables.description),
        ("operations.csv", &tables.operations),
        ("relations.csv", &tables.relations),
        ("executions.csv", &tables.executions),
        ("interlocks.csv", &tables.interlocks),
    ];
    let sources = sources.map(|(name, text)| SourceText { name, text });
    let relations = parse(&sources).ok()?.relations;
    let products = (0..random.within(&(1..=2))).map(|_| ConditionId(random.below(2))).collect();
    Some((relations, products))
}

/// Reads tables that have to be sound.
pub fn read(files: &[(&str, &str)]) -> Relations {
    let sources: Vec<_> = files.iter().map(|(name, text)| SourceText { name, text }).collect();
    parse(&sources).unwrap_or_else(|problems| panic!("{:#}", problems[0])).relations
}

fn tables(random: &mut Random) -> Tables {
    let machines = random.within(&(2..=4));
    let zones = random.within(&(0..=3));
    let mut tables = Tables::default();
    tables.description += "name = \"c\"\nproducts_max = 2\n";
    for zone in 0..zones {
        let _ = write!(tables.description, "[[zone]]\nname = \"Z{zone}\"\n");
    }
    tables.operations += "id,machine,conditions,every\n";
    tables.relations += "machine,operation,after,kind,group,zones_before,zones_after\n";
    tables.executions += "operation,step,way";
    tables.interlocks += "action,automatic,not_started,not_ongoing";
    let mut made: Vec<Made> = Vec::new();
    let mut steps: Vec<Vec<Step>> = Vec::new();
    for machine in 0..machines {
        let own = steps_of(random, machine, &mut made, zones);
        steps.push(own);
    }
    for machine in 0..machines {
        let _ = write!(tables.description, "[[machine]]\nname = \"M{machine}\"\n");
        let component = "[[machine.component]]\nname = \"a\"\nkind = \"actuator\"\nstates = [\"p\", \"q\"]\n";
        tables.description += component;
        let _ = write!(tables.executions, ",M{machine}.a");
        let _ = write!(tables.interlocks, ",M{machine}.a");
    }
    tables.description +=
        "[[condition]]\nname = \"A\"\nproduct = \"a\"\n[[condition]]\nname = \"B\"\nproduct = \"b\"\n";
    tables.executions += "\n";
    tables.interlocks += "\n";
    let pair = random.chance(20).then(|| (random.below(machines), random.below(machines)));
    for (machine, own) in steps.iter().enumerate() {
        for step in own {
            step.write(random, machine, machines, &made, &mut tables);
        }
        if pair.is_some_and(|(one, other)| one != other && (machine == one || machine == other)) {
            let _ = writeln!(tables.operations, "{machine}99,M{machine},all,");
            let _ = writeln!(tables.relations, "M{machine},{machine}99,,parallel,both,,");
        }
    }
    tables
}

/// A place in the sequence of a machine.
struct Step {
    ids: Vec<String>,
    kind: &'static str,
    before: Vec<usize>,
    after: Vec<usize>,
    /// States of the machine's component before and after; none where it has no execution.
    states: Option<(char, char)>,
    /// It is executed in two ways, by the component of another machine.
    by_other: Option<usize>,
    every: usize,
}

fn steps_of(random: &mut Random, machine: usize, made: &mut Vec<Made>, zones: usize) -> Vec<Step> {
    let plain = |id: String| Step {
        ids: vec![id],
        kind: "basic",
        before: Vec::new(),
        after: Vec::new(),
        states: None,
        by_other: None,
        every: 1,
    };
    let mut steps = vec![Step { states: Some(('p', 'p')), ..plain(format!("{machine}00")) }];
    let count = random.within(&(1..=4));
    let mut state = 'p';
    for nth in 1..=count {
        let id = format!("{machine}0{nth}");
        made.push(Made { id: id.clone(), machine, rank: 10 * nth + random.below(15) });
        let mut step = plain(id);
        match random.below(12) {
            0 | 1 => {
                let other = if state == 'p' { 'q' } else { 'p' };
                step.states = Some((state, other));
                state = other;
            }
            2 => {
                step.kind = "alternative";
                step.ids.push(format!("{machine}1{nth}"));
            }
            3 => step.kind = "uncontrolled",
            4 => step.every = 2,
            5 => {
                step.kind = "alternative-execution";
                step.states = Some((state, state));
                step.by_other = Some(random.below(4));
            }
            _ => {}
        }
        steps.push(step);
    }
    if state == 'q' {
        steps.push(Step { states: Some(('q', 'p')), ..plain(format!("{machine}08")) });
    }
    // A zone over some of them: kept from the first to the last.
    for zone in 0..zones {
        let free: Vec<usize> =
            (1..steps.len()).filter(|nth| steps[*nth].states.is_none() && steps[*nth].every == 1).collect();
        if free.is_empty() || random.chance(30) {
            continue;
        }
        let (one, other) = (*random.pick(&free), *random.pick(&free));
        let (from, to) = (one.min(other), one.max(other));
        let has_choice = (from..=to).any(|nth| steps[nth].kind == "alternative");
        for nth in (from..=to).filter(|nth| free.contains(nth)) {
            steps[nth].before.push(zone);
            if nth < to && !has_choice {
                steps[nth].after.push(zone);
            }
        }
    }
    steps
}

impl Step {
    fn write(&self, random: &mut Random, machine: usize, machines: usize, made: &[Made], tables: &mut Tables) {
        let zones = |of: &[usize]| of.iter().map(|zone| format!("Z{zone}")).collect::<Vec<_>>().join(" ");
        let rank = made.iter().find(|made| made.id == self.ids[0]).map(|made| made.rank);
        let earlier: Vec<&Made> =
            made.iter().filter(|made| made.machine != machine && rank.is_some_and(|rank| made.rank < rank)).collect();
        for id in &self.ids {
            let every = if self.every == 1 { String::new() } else { self.every.to_string() };
            let _ = writeln!(tables.operations, "{id},M{machine},all,{every}");
            let mut after = String::new();
            if !earlier.is_empty() && random.chance(45) {
                after.clone_from(&random.pick(&earlier).id);
                if random.chance(25) {
                    let word = if random.chance(50) { "and" } else { "or" };
                    after = format!("{after} {word} {}", random.pick(&earlier).id);
                }
            }
            let group = if self.ids.len() > 1 { self.ids[0].as_str() } else { "" };
            let (before, kept) = (zones(&self.before), zones(&self.after));
            let _ = writeln!(tables.relations, "M{machine},{id},{after},{},{group},{before},{kept}", self.kind);
            let blank = |nth: usize| ",".repeat(nth);
            if let Some((from, to)) = self.states {
                let other = self.by_other.map(|other| other % machines).filter(|other| *other != machine);
                match other {
                    Some(other) => {
                        for state in ["p", "q"] {
                            let mut cells = vec![String::new(); machines];
                            cells[machine] = from.to_string();
                            cells[other] = state.to_owned();
                            let _ = writeln!(tables.executions, "{id},initial,{state},{}", cells.join(","));
                        }
                    }
                    None => {
                        let (left, right) = (blank(machine), blank(machines - 1 - machine));
                        let _ = writeln!(tables.executions, "{id},initial,,{left}{from}{right}");
                        if from != to {
                            let _ = writeln!(tables.executions, "{id},1,,{left}{to}{right}");
                        }
                    }
                }
            }
            if made.len() > 1 && random.chance(15) {
                let others: Vec<&Made> = made.iter().filter(|made| made.machine != machine).collect();
                let mut cells = vec![String::new(); machines];
                let (mut not_started, mut not_ongoing) = ("", "");
                match random.below(3) {
                    0 if !others.is_empty() => not_started = &random.pick(&others).id,
                    1 if !others.is_empty() => not_ongoing = &random.pick(&others).id,
                    _ => {
                        let other = random.below(machines);
                        let begin = if random.chance(40) { "initially " } else { "" };
                        let state = if random.chance(60) { "p" } else { "q" };
                        if other != machine {
                            cells[other] = format!("{begin}{state}");
                        }
                    }
                }
                let _ = writeln!(tables.interlocks, "{id},yes,{not_started},{not_ongoing},{}", cells.join(","));
            }
        }
    }
}
