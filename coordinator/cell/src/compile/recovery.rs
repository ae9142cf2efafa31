//! The net with failures: error places, and the ways out of them (seed 000 §5.3, L3045-3129).
//!
//! ```text
//!                     ┌────────────── end ──────────────▶ what the activity gives
//!   start ──▶ X.busy ─┤
//!                     └─ fails ─▶ X.failed ─ diagnosis ─▶ X.asked ─┬─ from.redo, from.backward ─▶ what it took
//!                                                                  ├─ to.forward ───────────────▶ what it gives
//!                                                                  ├─ gone.backward ────────────▶ what is left
//!                                                                  └─ carrier.forward ─▶ X.carried ─┬─ as above
//! ```
//!
//! `X.busy` is the source's pa, `X.failed` its pe, and `X.idle` its ~pe: it holds one token for each that may be in progress,
//! which the start takes and every end of the activity gives back. Until an operator's answer, or a rule that needs none,
//! there is only diagnosis. The recoveries are the answers that the description's rules allow, and those of the player where
//! they allow none; they move tokens as closing an activity does in the player's marking. Redo puts tokens back as backward
//! does: the marking does not show that the same then starts again before anything else is decided.

use std::collections::BTreeSet;
use std::time::Duration;

use linewright_nets::{Net, NetBuilder, NetError, PlaceId, TransitionId};

use crate::exception::{FailureMatch, RecoveryPolicy, Strategy, Whereabouts};
use crate::{ActivityTiming, CellTable, ModeId, TokenDemand};

/// A cell's net with failures.
#[derive(Clone, Debug)]
pub struct RecoveryNet {
    /// The cells of the table, in their order, then the places of activities in progress.
    pub net: Net,
    /// Modes that can fail.
    pub errors: Vec<ErrorPart>,
}

/// Nodes of a mode beside its start and its end.
#[derive(Clone, Debug)]
pub struct ErrorPart {
    pub mode: ModeId,
    /// It is in progress.
    pub busy: PlaceId,
    pub failed: PlaceId,
    /// The failure is diagnosed, and an operator's answer is awaited.
    pub asked: PlaceId,
    /// The carrier has the part, and another answer is awaited.
    pub carried: Option<PlaceId>,
    /// The ways out of `asked`.
    pub recoveries: Vec<Recovery>,
    /// The ways out of `carried`.
    pub brought: Vec<Recovery>,
}

/// A way out of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recovery {
    pub transition: TransitionId,
    /// Place of the part then.
    pub part: Whereabouts,
    /// Strategy that follows.
    pub then: Strategy,
}

/// Answered place of a part, and strategy.
type RecoveryChoice = (Whereabouts, Strategy);

/// Answers where no rule has others.
const USUAL: [RecoveryChoice; 3] = [
    (Whereabouts::From, Strategy::Backward),
    (Whereabouts::To, Strategy::Forward),
    (Whereabouts::Gone, Strategy::Backward),
];

/// The answers to failures of a mode, of whatever code, and however often it was tried again.
fn ways(handling: &RecoveryPolicy, mode: ModeId) -> Vec<RecoveryChoice> {
    let handled = handling.mode(mode);
    let can_be = |part: Whereabouts| match part {
        Whereabouts::Gone => handled.gone.is_some(),
        Whereabouts::Carrier => handled.carrier.is_some(),
        Whereabouts::From | Whereabouts::To => true,
    };
    let rules: Vec<_> = handled.rules.iter().filter_map(|&at| handling.rules.get(at)).collect();
    let (mut ways, mut usual) = (BTreeSet::new(), !rules.iter().any(|rule| rule.code == FailureMatch::Any));
    for rule in rules {
        let possible = rule.answers.iter().map(|answer| (answer.ruling.part, answer.ruling.then));
        let possible = possible.filter(|&(part, then)| can_be(part) && (then != Strategy::Redo || rule.retries > 0));
        // Once it has been tried often enough, it is decided anew; where a rule has nothing else, the usual answers are given.
        usual |= !possible.clone().any(|(_, then)| then != Strategy::Redo);
        let anew = possible.clone().filter(|&(_, then)| then == Strategy::Redo);
        ways.extend(anew.map(|(part, _)| (part, Strategy::Backward)));
        ways.extend(possible);
    }
    if usual {
        ways.extend(USUAL.into_iter().filter(|(part, _)| can_be(*part)));
    }
    ways.into_iter().collect()
}

fn word((part, then): RecoveryChoice) -> String {
    let part = match part {
        Whereabouts::From => "from",
        Whereabouts::To => "to",
        Whereabouts::Carrier => "carrier",
        Whereabouts::Gone => "gone",
    };
    let then = match then {
        Strategy::Redo => "redo",
        Strategy::Backward => "backward",
        Strategy::Forward => "forward",
    };
    format!("{part}.{then}")
}

struct RecoveryNetBuilder<'t> {
    table: &'t CellTable,
    net: NetBuilder,
}

/// The net of the table, with failures.
///
/// # Errors
/// When it is too large for a net.
pub fn recovery_net(name: &str, table: &CellTable) -> Result<RecoveryNet, Vec<NetError>> {
    let mut builder = RecoveryNetBuilder { table, net: NetBuilder::new(name) };
    for cell in table.cells() {
        // Descriptions are bounded far below 32 bits.
        builder.net.place(table.cell_name(cell), table.initial()[cell.index()] as u32);
    }
    let mut errors = Vec::new();
    for mode in table.modes() {
        let activity = table.activity(mode);
        let takes_time = match activity.kind {
            ActivityTiming::Immediate => false,
            ActivityTiming::Decided { time, .. } => time > Duration::ZERO || !activity.orders.is_empty(),
        };
        if takes_time {
            errors.push(builder.in_progress(mode));
        } else {
            let t = builder.net.transition(table.mode_name(mode));
            builder.input(t, table.takes(mode));
            builder.output(t, table.gives(mode));
        }
    }
    Ok(RecoveryNet { net: builder.net.build()?, errors })
}

impl RecoveryNetBuilder<'_> {
    fn input(&mut self, t: TransitionId, tokens: &[TokenDemand]) {
        tokens.iter().for_each(|&(cell, weight)| _ = self.net.input(t, PlaceId(cell.0), weight));
    }

    fn output(&mut self, t: TransitionId, tokens: &[TokenDemand]) {
        tokens.iter().for_each(|&(cell, weight)| _ = self.net.output(t, PlaceId(cell.0), weight));
    }

    /// A transition from one place of an activity in progress to another.
    fn step(&mut self, name: String, from: PlaceId, to: PlaceId) -> TransitionId {
        let t = self.net.transition(name);
        self.net.input(t, from, 1);
        self.net.output(t, to, 1);
        t
    }

    fn in_progress(&mut self, mode: ModeId) -> ErrorPart {
        let (table, name) = (self.table, self.table.mode_name(mode));
        let ways = ways(table.handling(), mode);
        let idle = self.net.place(format!("{name}.idle"), table.activity(mode).servers);
        let [busy, failed, asked] =
            ["busy", "failed", "asked"].map(|state| self.net.place(format!("{name}.{state}"), 0));
        let start = self.step(format!("{name}.start"), idle, busy);
        self.input(start, table.takes(mode));
        let end = self.step(format!("{name}.end"), busy, idle);
        self.output(end, table.gives(mode));
        self.step(format!("{name}.fails"), busy, failed);
        self.step(format!("{name}.diagnosis"), failed, asked);
        let is_carried = ways.iter().any(|(part, _)| *part == Whereabouts::Carrier);
        let carried = is_carried.then(|| self.net.place(format!("{name}.carried"), 0));
        let recoveries = self.ways_out(mode, name, ways, [asked, idle], carried);
        let usual = USUAL
            .into_iter()
            .filter(|(part, _)| *part != Whereabouts::Gone || table.handling().mode(mode).gone.is_some());
        let brought = carried
            .map(|carried| self.ways_out(mode, &format!("{name}.carried"), usual.collect(), [carried, idle], None))
            .unwrap_or_default();
        ErrorPart { mode, busy, failed, asked, carried, recoveries, brought }
    }

    fn ways_out(
        &mut self,
        mode: ModeId,
        name: &str,
        ways: Vec<RecoveryChoice>,
        [out_of, idle]: [PlaceId; 2],
        carried: Option<PlaceId>,
    ) -> Vec<Recovery> {
        let table = self.table;
        let mut found = Vec::new();
        for (part, then) in ways {
            let left = match part {
                Whereabouts::From => table.takes(mode),
                Whereabouts::To => table.gives(mode),
                Whereabouts::Gone => table.handling().mode(mode).gone.as_deref().unwrap_or_default(),
                Whereabouts::Carrier => &[],
            };
            let to = carried.filter(|_| part == Whereabouts::Carrier).unwrap_or(idle);
            let transition = self.step(format!("{name}.{}", word((part, then))), out_of, to);
            self.output(transition, left);
            found.push(Recovery { transition, part, then });
        }
        found
    }
}
