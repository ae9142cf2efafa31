//! What synthesis has found, as text, CSV and JSON.

use std::fmt::Write as _;

use linewright_relations::{ConditionId, Relations, csv_text};
use linewright_synthesis::{Contradiction, CoordinatedStep, Supervisor, Synthesis, Texts, Trap};
use serde_json::{Value, json};

/// Names of the products' conditions: `A, A`.
pub fn names(relations: &Relations, products: &[ConditionId]) -> String {
    products.iter().map(|id| relations.conditions[id.0].name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Everything, for people.
pub fn text(relations: &Relations, found: &[Synthesis]) -> String {
    let mut out = String::new();
    for synthesis in found {
        match synthesis {
            Synthesis::Supervisor(found) => of_supervisor(relations, found, &mut out),
            Synthesis::Contradiction(found) => of_contradiction(relations, found, &mut out),
        }
        out.push('\n');
    }
    out
}

fn head(relations: &Relations, products: &[ConditionId], out: &mut String) {
    let count = match products.len() {
        1 => "one product".to_owned(),
        count => format!("{count} products"),
    };
    let _ = writeln!(out, "{}: {count} ({})", relations.name, names(relations, products));
}

fn of_supervisor(relations: &Relations, found: &Supervisor, out: &mut String) {
    let texts = Texts { relations, composition: &found.composition };
    head(relations, &found.products, out);
    let sizes = &found.sizes;
    let _ = writeln!(
        out,
        "  {} operations; {} states allowed by the tables, {} under supervision; {} nodes at most, {} steps, by {}",
        sizes.operations, sizes.reachable, sizes.supervised, sizes.peak_nodes, sizes.steps, sizes.order
    );
    match found.added.len() {
        0 => out.push_str("  nothing is added: no order that the tables allow ends in a deadlock\n"),
        1 => out.push_str("  one predecessor is added:\n"),
        count => {
            let _ = writeln!(out, "  {count} predecessors are added:");
        }
    }
    for added in &found.added {
        let _ = writeln!(out, "    {}: {}", texts.operation_with_comment(added.of), texts.guard(&added.guard));
        let _ = writeln!(out, "      otherwise:");
        for line in texts.trap(&added.reason) {
            let _ = writeln!(out, "        {line}");
        }
    }
    for cop in &found.coordinated {
        let machine = &relations.machine(cop.machine).name;
        let _ = writeln!(out, "  {machine}, P{}:", cop.instance + 1);
        for (nth, step) in cop.steps.iter().enumerate() {
            let is_choice = nth > 0 && cop.steps[nth - 1].place == step.place;
            let operation = relations.operation(step.operation);
            let name = format!("{} {}", operation.id, operation.comment);
            let after = conditions(&texts, step, cop.instance);
            let begin = if is_choice { "or " } else { "" };
            let line = format!("    {:<36} {after}", format!("{begin}{}", name.trim()));
            let _ = writeln!(out, "{}", line.trim_end());
        }
    }
}

/// Predecessors and what is added, of one step.
fn conditions(texts: &Texts<'_>, step: &CoordinatedStep, instance: usize) -> String {
    let after = texts.predecessors(step, instance);
    let after = if after.is_empty() { after } else { format!("after {after}") };
    let added = step.added.iter().map(|(way, guard)| {
        let way = way.as_ref().map_or_else(String::new, |way| format!("{way}: "));
        format!("added: {way}{}", texts.guard(guard))
    });
    let all = std::iter::once(after).chain(added).filter(|part| !part.is_empty());
    all.collect::<Vec<_>>().join("; ")
}

fn of_contradiction(relations: &Relations, found: &Contradiction, out: &mut String) {
    let texts = Texts { relations, composition: &found.composition };
    head(relations, &found.products, out);
    match found.conflict.len() {
        0 => out.push_str("  no order finishes all operations, whatever restricts them: see the order and the choices of each machine\n"),
        count => {
            let _ = writeln!(out, "  the tables contradict each other: {count} of them, of which none may be missing");
        }
    }
    for restriction in &found.conflict {
        let _ = writeln!(out, "    {}", texts.restriction(restriction));
    }
    let Some(trap) = &found.trap else { return };
    let _ = writeln!(
        out,
        "  with these alone the cell gets stuck{}:",
        if trap.is_shortest { "; no way into it is shorter" } else { "" }
    );
    for step in texts.way(trap) {
        let _ = writeln!(out, "    start {step}");
    }
    for line in texts.trap(trap) {
        let _ = writeln!(out, "    {line}");
    }
}

/// The coordinated operations of every machine, as a table.
pub fn csv(relations: &Relations, found: &[Synthesis]) -> String {
    let columns = ["products", "product", "machine", "operation", "comment", "after", "added"];
    let mut rows = vec![columns.map(str::to_owned).to_vec()];
    for found in found.iter().filter_map(supervisor) {
        let texts = Texts { relations, composition: &found.composition };
        for cop in &found.coordinated {
            for step in &cop.steps {
                let operation = relations.operation(step.operation);
                let added = step.added.iter().map(|(way, guard)| {
                    let way = way.as_ref().map_or_else(String::new, |way| format!("{way}: "));
                    format!("{way}{}", texts.guard(guard))
                });
                rows.push(vec![
                    names(relations, &found.products).replace(", ", " "),
                    format!("P{}", cop.instance + 1),
                    relations.machine(cop.machine).name.clone(),
                    operation.id.clone(),
                    operation.comment.clone(),
                    texts.predecessors(step, cop.instance),
                    added.collect::<Vec<_>>().join("; "),
                ]);
            }
        }
    }
    csv_text(&rows)
}

fn supervisor(found: &Synthesis) -> Option<&Supervisor> {
    match found {
        Synthesis::Supervisor(found) => Some(found),
        Synthesis::Contradiction(_) => None,
    }
}

/// Everything, for programs.
pub fn json(relations: &Relations, found: &[Synthesis]) -> Value {
    let all = found.iter().map(|found| match found {
        Synthesis::Supervisor(found) => json_of_supervisor(relations, found),
        Synthesis::Contradiction(found) => {
            let texts = Texts { relations, composition: &found.composition };
            let conflict: Vec<String> = found.conflict.iter().map(|row| texts.restriction(row)).collect();
            json!({
                "products": products(relations, &found.products),
                "ok": false,
                "conflict": conflict,
                "syntheses": found.syntheses,
                "trap": found.trap.as_ref().map(|trap| json_of_trap(&texts, trap)),
            })
        }
    });
    let all: Vec<Value> = all.collect();
    let ok = found.iter().all(|found| supervisor(found).is_some());
    json!({ "name": relations.name, "title": relations.title, "ok": ok, "supervisors": all })
}

fn products(relations: &Relations, products: &[ConditionId]) -> Vec<String> {
    products.iter().map(|id| relations.conditions[id.0].name.clone()).collect()
}

fn json_of_trap(texts: &Texts<'_>, trap: &Trap) -> Value {
    json!({ "way": texts.way(trap), "is_shortest": trap.is_shortest, "waits": texts.trap(trap) })
}

fn json_of_supervisor(relations: &Relations, found: &Supervisor) -> Value {
    let texts = Texts { relations, composition: &found.composition };
    let added = found.added.iter().map(|added| {
        json!({
            "operation": texts.operation(added.of),
            "condition": texts.guard(&added.guard),
            "otherwise": json_of_trap(&texts, &added.reason),
        })
    });
    let cops = found.coordinated.iter().map(|cop| {
        let steps = cop.steps.iter().map(|step| {
            let added = step.added.iter().map(|(way, guard)| json!({ "way": way, "condition": texts.guard(guard) }));
            json!({
                "operation": relations.operation(step.operation).id,
                "place": step.place,
                "after": texts.predecessors(step, cop.instance),
                "added": added.collect::<Vec<Value>>(),
            })
        });
        let steps: Vec<Value> = steps.collect();
        json!({ "product": cop.instance + 1, "machine": relations.machine(cop.machine).name, "steps": steps })
    });
    let sizes = &found.sizes;
    json!({
        "products": products(relations, &found.products),
        "ok": true,
        "added": added.collect::<Vec<Value>>(),
        "coordinated": cops.collect::<Vec<Value>>(),
        "sizes": {
            "operations": sizes.operations,
            "variables": sizes.variables,
            "states": sizes.reachable,
            "supervised": sizes.supervised,
            "peak_nodes": sizes.peak_nodes,
            "steps": sizes.steps,
            "order": sizes.order,
        },
    })
}
