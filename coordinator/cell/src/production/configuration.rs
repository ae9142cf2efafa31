//! The dispatcher with rules, and the production orders.
//!
//! Rules use due date and priority of parts, and let in the parts wanted; both follow from production orders. This joins
//! the two: it takes every record, and passes changes to the rules before they decide.

use std::collections::BTreeMap;

use linewright_line::Tick;

use super::super::dispatch::{PartPriority, RuleDispatcher};
use super::super::ids::{ModeId, PartId};
use super::super::question::{DispatchDecision, Dispatcher, Question};
use super::super::record::Record;
use super::ledger::Production;
use super::order::ProductionOrder;

/// Rules, and production orders.
#[derive(Clone, Debug)]
pub struct DispatchConfiguration {
    /// The rules. Where there are production orders, their `jobs` follow from these.
    pub rules: RuleDispatcher,
    production: Option<Production>,
    /// The rules have the state of the orders until then; none if it must be passed to them.
    fresh_until: Option<Tick>,
}

impl DispatchConfiguration {
    /// With production orders: those of the cell's state ([`super::super::PlayerState::production`]), whose records it takes
    /// from now on.
    pub fn new(rules: RuleDispatcher, production: Production) -> Self {
        DispatchConfiguration { rules, production: Some(production), fresh_until: None }
    }

    /// Without: parts enter as the net lets them, and their data are in `rules`.
    pub fn without_orders(rules: RuleDispatcher) -> Self {
        DispatchConfiguration { rules, production: None, fresh_until: Some(Tick::NEVER) }
    }

    /// The production orders, if there are any.
    pub fn production(&self) -> Option<&Production> {
        self.production.as_ref()
    }

    /// Due date and priority of a part.
    pub fn job(&self, part: PartId) -> PartPriority {
        match &self.production {
            Some(production) => production.order_of(part).map(ProductionOrder::job).unwrap_or_default(),
            None => self.rules.jobs.parts.get(&part).copied().unwrap_or_default(),
        }
    }

    /// Whether a part may enter by a mode, as far as orders go. A mode without a part may always start.
    pub(in super::super) fn admits(&self, question: &Question<'_>, mode: ModeId) -> bool {
        let enters = question.state.table().part_out(mode).is_some();
        let admission = self.rules.jobs.admission.as_ref().filter(|_| enters);
        admission.is_none_or(|admission| admission.room(mode, &BTreeMap::new()) > 0)
    }

    /// Passes the state of the orders to the rules.
    pub fn refresh(&mut self, now: Tick) {
        let Some(production) = &self.production else { return };
        if self.fresh_until.is_none_or(|until| until <= now) {
            self.rules.jobs = production.jobs(now);
            self.fresh_until = Some(production.next_release(now).unwrap_or(Tick::NEVER));
        }
    }
}

impl Dispatcher for DispatchConfiguration {
    fn decide(&mut self, question: &Question<'_>) -> DispatchDecision {
        self.refresh(question.now);
        self.rules.decide(question)
    }

    fn note(&mut self, record: &Record) {
        let Some(production) = &mut self.production else { return };
        // A record that fitted the cell's own production orders fits these, which have taken the same ones.
        if production.note(record).unwrap_or(true) {
            self.fresh_until = None;
        }
    }
}
