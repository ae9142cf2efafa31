//! From relations of operations to supervisors.
//!
//! Tables say which operation needs which before it, which zones it takes, what each actuator may do when. Which orders of work that
//! leaves, and which of them end in a deadlock, follows: [`synthesise`] composes automata of operations, machines and zones, machine
//! sequences, relations and safety specifications, and finds the supervisor that keeps the cell out of every deadlock and holds back
//! nothing else. What it adds are *added predecessors*, one condition for the start of an operation, each with the deadlock that it
//! prevents. Where there is no supervisor, rows of the tables contradict each other: those of which none can be left out are named ([`Contradiction`]).
//!
//! It does not know how operations are carried out, how long they take, or when they run. It reads no file and no clock.
//!
//! ```
//! use linewright_relations::{ConditionId, SourceText, parse};
//! use linewright_synthesis::{Synthesis, SynthesisLimits, Texts, synthesise};
//!
//! // Two machines take two tools in opposite orders.
//! let description = "name = \"c\"\n[[machine]]\nname = \"R1\"\n[[machine]]\nname = \"R2\"\n[[zone]]\nname = \"t\"\n[[zone]]\nname = \"u\"\n\
//!                    [[condition]]\nname = \"A\"\n";
//! let operations = "id,machine,conditions\n11,R1,A\n12,R1,A\n21,R2,A\n22,R2,A\n";
//! let relations = "machine,operation,after,zones_before,zones_after\nR1,11,,t,t\nR1,12,,t u,\nR2,21,,u,u\nR2,22,,t u,\n";
//! let sources = [("relations.toml", description), ("operations.csv", operations), ("relations.csv", relations)];
//! let relations = parse(&sources.map(|(name, text)| SourceText { name, text })).expect("it is sound").relations;
//! let Ok(Synthesis::Supervisor(found)) = synthesise(&relations, &[ConditionId(0)], &SynthesisLimits::default()) else {
//!     panic!("one after the other there is no deadlock");
//! };
//! let texts = Texts { relations: &relations, composition: &found.composition };
//! let added: Vec<String> = found.added.iter().map(|a| format!("{}: {}", texts.operation(a.of), texts.guard(&a.guard))).collect();
//! assert_eq!(added, ["11(P1): not while 21(P1) started and 22(P1) not finished", "21(P1): not while 11(P1) started and 12(P1) not finished"]);
//! ```

mod compose;
mod conflict;
mod cops;
mod fixpoint;
mod guard;
mod lock;
mod model;
pub mod monolithic;
mod supervisor;
mod symbolic;
mod text;

pub use conflict::Contradiction;
pub use cops::{CoordinatedSequence, CoordinatedStep};
pub use guard::{AddedGuard, MarkValue};
pub use lock::{Trap, WaitingMachine};
pub use model::{Composition, Mark, ModelEvent, ModelOperation, Nth, Predicate, Requirement, Restriction};
pub use supervisor::{
    AddedPredecessor, Supervisor, Synthesis, SynthesisLimits, SynthesisSizes, TooLarge, combinations, synthesise,
};
pub use text::Texts;
