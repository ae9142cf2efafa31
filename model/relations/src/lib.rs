//! Relations of operations: tables of planners → checked [`Relations`], and back.
//!
//! The work of a cell such as one in a body shop has no bar chart: its order depends on products and on what happens. Its planners
//! know *relations*: which operation needs which before it, which zones it takes, what each actuator may do when. They keep them
//! as tables. This crate reads these ([`parse()`]), explains everything that is wrong with them, and writes them out again
//! ([`write()`]). It follows Richardsson, *Automated Verification and Generation of Flexible Automation Control* (seed 004).
//!
//! It does not know what follows from relations: which orders of work are possible, and which end in a deadlock. It reads no file.
//!
//! ```
//! use linewright_relations::{SourceText, parse, write};
//!
//! let description = "name = \"cell\"\n[[machine]]\nname = \"R1\"\n[[machine]]\nname = \"F1\"\n[[condition]]\nname = \"A\"\n";
//! let operations = "id,machine,conditions\n23,R1,A\n32,F1,A\n";
//! let relations = "machine,operation,after\nR1,23,\nF1,32,23\n";
//! let sources = [("relations.toml", description), ("operations.csv", operations), ("relations.csv", relations)];
//! let sources = sources.map(|(name, text)| SourceText { name, text });
//! let parsed = parse(&sources).expect("it is sound");
//! assert_eq!(parsed.relations.operations.len(), 2);
//! assert!(write(&parsed.relations).iter().any(|file| file.text.contains("F1,32,23")));
//!
//! let wrong = [sources[0], sources[1], SourceText { name: "relations.csv", text: "machine,operation,after\nR1,23,\nF1,32,24\n" }];
//! let problems = parse(&wrong).expect_err("operation 24 is not declared");
//! assert!(format!("{:#}", problems[0]).starts_with("relations.csv: 1 error\nrelations.csv:3:7: unknown operation `24`"));
//! ```

mod parse;
mod precondition;
mod relations;
mod write;

pub use parse::{DESCRIPTION, ParsedRelations, SourceText, TableKind, parse, schema};
pub use precondition::Precondition;
pub use relations::*;
pub use write::{WrittenFile, csv_text, write};
