//! `linewright synthesise`: from the relations of operations of a cell to its coordinated operations.
//!
//! The tables are read by `linewright-relations`, supervisors found by `linewright-synthesis`; this file reads files, chooses which
//! products are looked at, and prints.

mod show;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use linewright_relations::{ConditionId, DESCRIPTION, ParsedRelations, Relations, SourceText, TableKind, parse};
use linewright_synthesis::{Synthesis, SynthesisLimits, combinations, synthesise};
use miette::{IntoDiagnostic, WrapErr, miette};

use crate::files::text;

/// A table may be this large; the parser refuses more.
const TABLE_BYTES_MAX: usize = 4 << 20;
/// So many combinations of products are looked at, where none is named.
const COMBINATIONS_MAX: usize = 64;
/// So many files are read.
const FILES_MAX: usize = 200;

/// Synthesise a supervisor from relations of operations: added predecessors with reasons, coordinated operations, contradictions.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The directory with relations.toml and its tables, or relations.toml.
    cell: PathBuf,
    /// Cycle start conditions of the products that are in the cell at once, the one that came first first, as `A,A`; without it
    /// every combination, up to `products_max`.
    #[arg(long, value_name = "CONDITION", value_delimiter = ',')]
    products: Vec<String>,
    /// Most nodes of decision diagrams, in millions; each takes about 30 bytes.
    #[arg(long, value_name = "MILLIONS", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=1000))]
    nodes: u32,
    /// Print the coordinated operations of every machine as CSV.
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// `linewright synthesise`
pub fn run(args: &Args) -> miette::Result<ExitCode> {
    let ParsedRelations { relations, warnings } = read(&args.cell)?;
    for problems in warnings {
        crate::out::complain!("{:?}", miette::Report::new(problems));
    }
    let limits = SynthesisLimits { nodes: args.nodes as usize * 1_000_000 };
    let mut found = Vec::new();
    for products in asked(&relations, &args.products)? {
        let synthesis = synthesise(&relations, &products, &limits).map_err(|too_large| {
            let names = show::names(&relations, &products);
            miette!(help = "try fewer products at once (--products), or more nodes (--nodes)", "{names}: {too_large}")
        })?;
        found.push(synthesis);
    }
    match (args.json, args.csv) {
        (true, _) => crate::out::json(&show::json(&relations, &found))?,
        (false, true) => crate::out::bytes(show::csv(&relations, &found).as_bytes()),
        (false, false) => crate::out::say!("{}", show::text(&relations, &found).trim_end()),
    }
    let is_good = found.iter().all(|found| matches!(found, Synthesis::Supervisor(_)));
    Ok(if is_good { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The combinations of products that are asked for.
fn asked(relations: &Relations, products: &[String]) -> miette::Result<Vec<Vec<ConditionId>>> {
    if products.is_empty() {
        return combinations(relations, COMBINATIONS_MAX).ok_or_else(|| {
            miette!(
                help = "name the products that are in the cell at once, as in --products A,A",
                "more than {COMBINATIONS_MAX} combinations of products can be in this cell at once"
            )
        });
    }
    if products.len() > relations.products_max {
        return Err(miette!(
            "--products has {} products, and `products_max` is {}",
            products.len(),
            relations.products_max
        ));
    }
    let known = || relations.conditions.iter().map(|condition| condition.name.as_str());
    let find = |name: &String| {
        known().position(|known| known == name).map(ConditionId).ok_or_else(|| {
            let hint = linewright_text::suggestion(name, known()).unwrap_or_default();
            miette!(help = hint, "--products: unknown condition `{name}`")
        })
    };
    let found = products.iter().map(find).collect::<miette::Result<Vec<_>>>()?;
    let mut cycles = found.iter().map(|id| relations.conditions[id.0].cycle);
    let first = cycles.next();
    if cycles.any(|cycle| Some(cycle) != first) {
        return Err(miette!("--products: conditions of different work cycles are never in the cell at once"));
    }
    Ok(vec![found])
}

/// Reads relations.toml and the tables beside it.
fn read(path: &Path) -> miette::Result<ParsedRelations> {
    let dir = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) };
    let is_named = path.is_dir() || path.file_name().is_some_and(|name| name == DESCRIPTION);
    if !is_named || !dir.join(DESCRIPTION).is_file() {
        let name = path.display();
        return Err(miette!(
            help = "expected a directory with relations.toml and tables beside it",
            "{name} has no relations of operations"
        ));
    }
    let listed = if dir.as_os_str().is_empty() { Path::new(".") } else { dir };
    let entries =
        std::fs::read_dir(listed).into_diagnostic().wrap_err_with(|| format!("cannot read {}", listed.display()))?;
    let names = entries.flatten().filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| TableKind::of_file(name).is_some()).take(FILES_MAX).collect();
    names.sort_unstable();
    names.insert(0, DESCRIPTION.to_owned());
    let texts = names.iter().map(|name| text(&dir.join(name), TABLE_BYTES_MAX, "a table"));
    let texts = texts.collect::<miette::Result<Vec<String>>>()?;
    let sources: Vec<SourceText<'_>> = names.iter().zip(&texts).map(|(name, text)| SourceText { name, text }).collect();
    parse(&sources).map_err(|mut problems| {
        let last = problems.pop();
        for problems in problems {
            crate::out::complain!("{:?}", miette::Report::new(problems));
        }
        last.map_or_else(|| miette!("the tables cannot be read"), miette::Report::new)
    })
}
