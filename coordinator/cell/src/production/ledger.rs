//! All production orders of a cell: a fold over operators' changes and the cell's records.
//!
//! Which order a part that enters counts to is not decided when it enters but follows: the first in turn of those of its
//! product that are released. So a record of entering is enough, and a dispatcher that simulates can let simulated parts
//! enter as well.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use linewright_line::{Tick, suggestion};

use super::super::dispatch::{Admission, EntryCandidate, PartPriorities};
use super::super::exception::{ExceptionStep, Whereabouts};
use super::super::ids::{FiringId, ModeId, PartId, ProductionId};
use super::super::record::{Record, RecordKind};
use super::super::table::CellTable;
use super::super::tracking::{ModeEntry, PartFlow, ReportMetadata};
use super::change::{ProductionChange, ProductionMisfit, ProductionRefusal};
use super::order::{ProductionOrder, ProductionStatus};
use super::request::{ORDERS_MAX, ProductionOrderRequest, RequestProblem, find_circle, in_order};

/// Orders kept that are over, beside those that others wait for.
const KEPT: usize = 1000;

/// The production orders of a cell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Production {
    pub(super) products: Vec<Arc<str>>,
    /// The modes by which parts of each product enter.
    enters: BTreeMap<ModeId, usize>,
    leaves: BTreeSet<ModeId>,
    pub(super) orders: BTreeMap<ProductionId, ProductionOrder>,
    /// Order of each part inside, and the part's number in it.
    pub(super) of_part: BTreeMap<PartId, (ProductionId, u32)>,
    /// Activities in progress that take a part out.
    pub(super) leaving: BTreeMap<FiringId, PartId>,
    pub(super) last: u64,
    /// Orders that are over are kept.
    keeps_all: bool,
}

impl Production {
    /// Of a cell that makes the products of its table, without production orders yet.
    pub fn new(table: &CellTable) -> Self {
        let products = table.products();
        let modes = products.iter().enumerate().flat_map(|(at, of)| of.enters.iter().map(move |&mode| (mode, at)));
        let is_leave = |&mode: &ModeId| table.part_in(mode).is_some() && table.part_out(mode).is_none();
        Production {
            products: products.iter().map(|product| product.name.clone()).collect(),
            enters: modes.collect(),
            leaves: table.modes().filter(is_leave).collect(),
            ..Production::default()
        }
    }

    /// The same from the data of a report. All orders are kept.
    pub fn of_sheet(sheet: &ReportMetadata) -> Self {
        let modes = || (0..).map(ModeId).zip(&sheet.modes);
        let passing = |passing| move |(_, entry): &(ModeId, &ModeEntry)| entry.passing == passing;
        let enters = modes().filter(passing(PartFlow::Enters));
        Production {
            products: sheet.products.iter().map(|name| name.as_str().into()).collect(),
            enters: enters.filter_map(|(mode, entry)| Some((mode, entry.product?))).collect(),
            leaves: modes().filter(passing(PartFlow::Leaves)).map(|(mode, _)| mode).collect(),
            keeps_all: true,
            ..Production::default()
        }
    }

    /// All orders that are remembered, by number.
    pub fn orders(&self) -> impl ExactSizeIterator<Item = &ProductionOrder> {
        self.orders.values()
    }

    /// An order, if it is remembered.
    pub fn order(&self, id: ProductionId) -> Option<&ProductionOrder> {
        self.orders.get(&id)
    }

    /// The newest order of that name that was not withdrawn.
    pub fn named(&self, name: &str) -> Option<&ProductionOrder> {
        self.orders.values().rev().find(|order| order.request.name == name && !order.withdrawn)
    }

    /// The order that was made of the request with that key.
    pub fn by_key(&self, key: u128) -> Option<&ProductionOrder> {
        self.orders.values().find(|order| order.request.key == key)
    }

    /// Order that a part counts to; none if it has left, or was not ordered.
    pub fn order_of(&self, part: PartId) -> Option<&ProductionOrder> {
        self.order(self.of_part.get(&part)?.0)
    }

    /// The part's number in its order, from 1 to its quantity. A part that replaces a lost one has the number of that.
    pub fn number_in_order(&self, part: PartId) -> Option<u32> {
        Some(self.of_part.get(&part)?.1)
    }

    /// The change that makes orders of these requests, all of them or none. Those that are orders already change
    /// nothing.
    ///
    /// # Errors
    /// All errors of any of them.
    pub fn submit(&self, requests: &[ProductionOrderRequest]) -> Result<Vec<ProductionChange>, Vec<RequestProblem>> {
        let mut wrongs = Vec::new();
        let mut new: Vec<&ProductionOrderRequest> = Vec::new();
        for request in requests {
            let known = self.orders.values().map(|order| &order.request).chain(new.iter().copied());
            match known.into_iter().find(|other| other.key == request.key) {
                Some(same) if same == request => (),
                Some(other) => {
                    wrongs.push(RequestProblem::KeyTaken { name: request.name.clone(), other: other.name.clone() });
                }
                None => new.push(request),
            }
        }
        let all = self.orders.values().map(|order| (order.request.name.as_str(), order));
        let old: BTreeMap<&str, &ProductionOrder> = all.clone().filter(|(_, order)| !order.withdrawn).collect();
        let withdrawn: BTreeSet<&str> = all.filter(|(_, order)| order.withdrawn).map(|(name, _)| name).collect();
        let batch: BTreeSet<&str> = new.iter().map(|request| request.name.as_str()).collect();
        let mut seen = BTreeSet::new();
        for request in &new {
            wrongs.extend(request.validate(self.products.iter().map(AsRef::as_ref)));
            let name = || request.name.clone();
            if old.get(request.name.as_str()).is_some_and(|order| order.ended.is_none()) {
                wrongs.push(RequestProblem::NameTaken(name()));
            }
            if !seen.insert(request.name.as_str()) {
                wrongs.push(RequestProblem::NameTwice(name()));
            }
            for after in &request.after {
                if old.contains_key(after.as_str()) || batch.contains(after.as_str()) {
                    continue;
                }
                let was_withdrawn = withdrawn.contains(after.as_str());
                let known = old.keys().copied();
                wrongs.push(if was_withdrawn {
                    RequestProblem::AfterWithdrawn { name: name(), after: after.clone() }
                } else {
                    RequestProblem::NoSuchOrder { name: name(), after: after.clone(), hint: suggestion(after, known) }
                });
            }
        }
        wrongs.extend(find_circle(&new).map(RequestProblem::Circle));
        let open = self.orders.values().filter(|order| order.ended.is_none()).count() + new.len();
        if open > ORDERS_MAX {
            wrongs.push(RequestProblem::TooMany { open });
        }
        if !wrongs.is_empty() {
            return Err(wrongs);
        }
        let ids = (self.last + 1..).map(ProductionId);
        Ok(ids.zip(in_order(&new)).map(|(id, request)| ProductionChange::Accepted { id, request }).collect())
    }

    /// The change that cancels an order: nothing more of it enters.
    ///
    /// # Errors
    /// Reason why not.
    pub fn cancel(&self, name: &str) -> Result<ProductionChange, ProductionRefusal> {
        let order = self.open(name)?;
        if order.cancelled.is_some() {
            return Err(ProductionRefusal::Over(name.to_owned()));
        }
        Ok(ProductionChange::Cancelled(order.id))
    }

    /// The change that withdraws an order, as long as nothing of it has entered.
    ///
    /// # Errors
    /// Reason why not.
    pub fn withdraw(&self, name: &str) -> Result<ProductionChange, ProductionRefusal> {
        let order = self.open(name)?;
        if order.begun.is_some() || order.cancelled.is_some() {
            return Err(ProductionRefusal::Begun { name: name.to_owned(), entered: order.entered + order.lost });
        }
        if let Some(by) = self.waiting_for(order.id) {
            return Err(ProductionRefusal::Needed { name: name.to_owned(), by: by.request.name.clone() });
        }
        Ok(ProductionChange::Withdrawn(order.id))
    }

    fn open(&self, name: &str) -> Result<&ProductionOrder, ProductionRefusal> {
        let standing = self.orders.values().filter(|order| !order.withdrawn);
        let known = standing.map(|order| order.request.name.as_str());
        let unknown = || ProductionRefusal::Unknown { name: name.to_owned(), hint: suggestion(name, known) };
        let order = self.named(name).ok_or_else(unknown)?;
        if order.ended.is_some() { Err(ProductionRefusal::Over(name.to_owned())) } else { Ok(order) }
    }

    fn waiting_for(&self, id: ProductionId) -> Option<&ProductionOrder> {
        self.orders.values().find(|order| order.ended.is_none() && order.after.contains(&id))
    }

    /// Applies a change, or nothing of it.
    fn apply(&mut self, at: Tick, change: &ProductionChange) -> Result<(), ProductionMisfit> {
        match change {
            ProductionChange::Accepted { id, request } => self.accept(at, *id, request),
            ProductionChange::Cancelled(id) => {
                let order = self.changed(*id)?;
                order.cancelled = Some(at);
                self.close(*id, at);
                Ok(())
            }
            ProductionChange::Withdrawn(id) => {
                let order = self.changed(*id)?;
                if order.begun.is_some() {
                    return Err(ProductionMisfit(format!("{id} has begun")));
                }
                (order.withdrawn, order.ended) = (true, Some(at));
                Ok(())
            }
            ProductionChange::Lost(part) => {
                let (id, number) =
                    self.of_part.remove(part).ok_or_else(|| ProductionMisfit(format!("{part} counts to no order")))?;
                self.leaving.retain(|_, leaving| leaving != part);
                if let Some(order) = self.orders.get_mut(&id) {
                    order.entered = order.entered.saturating_sub(1);
                    order.lost += 1;
                    order.freed.push(number);
                }
                self.close(id, at);
                Ok(())
            }
        }
    }

    fn changed(&mut self, id: ProductionId) -> Result<&mut ProductionOrder, ProductionMisfit> {
        let order = self.orders.get_mut(&id).ok_or_else(|| ProductionMisfit(format!("there is no {id}")))?;
        let is_open = order.ended.is_none() && order.cancelled.is_none();
        if is_open { Ok(order) } else { Err(ProductionMisfit(format!("{id} is over already"))) }
    }

    fn accept(&mut self, at: Tick, id: ProductionId, request: &ProductionOrderRequest) -> Result<(), ProductionMisfit> {
        if id.0 != self.last + 1 {
            return Err(ProductionMisfit(format!("{id} after production order {}", self.last)));
        }
        let product = self.products.iter().position(|product| **product == *request.product);
        let product = product.ok_or_else(|| ProductionMisfit(format!("`{}` is not made here", request.product)))?;
        let before = |name: &String| {
            self.named(name)
                .map(|order| order.id)
                .ok_or_else(|| ProductionMisfit(format!("there is no order `{name}`")))
        };
        let after = request.after.iter().map(before).collect::<Result<Vec<_>, _>>()?;
        self.last = id.0;
        self.orders.insert(id, ProductionOrder::new(id, request.clone(), product, after, at));
        self.forget();
        Ok(())
    }

    /// Drops the oldest of those that are over and that no other order waits for.
    fn forget(&mut self) {
        if self.keeps_all {
            return;
        }
        let over = self.orders.values().filter(|order| order.ended.is_some());
        let too_many = over.clone().count().saturating_sub(KEPT);
        let dispensable = over.filter(|order| self.waiting_for(order.id).is_none()).map(|order| order.id);
        let oldest: Vec<ProductionId> = dispensable.take(too_many).collect();
        oldest.iter().for_each(|id| _ = self.orders.remove(id));
    }

    /// Ends an order of which nothing is missing and nothing is inside.
    fn close(&mut self, id: ProductionId, at: Tick) {
        if let Some(order) = self.orders.get_mut(&id)
            && order.ended.is_none()
            && order.missing() == 0
            && order.inside() == 0
        {
            order.ended = Some(at);
        }
    }

    /// Takes a record of the cell, and returns whether it changes anything. It takes time for what it touches, and for
    /// finding the order in turn when a part enters.
    ///
    /// # Errors
    /// A change that does not fit; nothing has changed then.
    pub fn note(&mut self, record: &Record) -> Result<bool, ProductionMisfit> {
        Ok(match &record.fact {
            RecordKind::Production { change } => {
                self.apply(record.at, change)?;
                true
            }
            RecordKind::Started { firing, mode, part: Some(part), orders: _ } => {
                if self.leaves.contains(mode) && self.of_part.contains_key(part) {
                    self.leaving.insert(*firing, *part);
                }
                self.enter(*mode, *part, record.at)
            }
            RecordKind::Fired { mode, part: Some(part) } => {
                let entered = self.enter(*mode, *part, record.at);
                (self.leaves.contains(mode) && self.leave(*part, record.at)) || entered
            }
            RecordKind::Ended { firing } => match self.leaving.remove(firing) {
                Some(part) => self.leave(part, record.at),
                None => false,
            },
            RecordKind::Started { part: None, .. }
            | RecordKind::Fired { part: None, .. }
            | RecordKind::Epoch { .. }
            | RecordKind::Memory { .. }
            | RecordKind::Decided { .. }
            | RecordKind::Acknowledged { .. }
            | RecordKind::OrderEnded { .. }
            | RecordKind::OrderFailed { .. }
            | RecordKind::Raised { .. } => false,
            RecordKind::Exception(step) => self.put_right(step, record.at),
        })
    }

    /// Of a failure, a part that has not come in counts as little as one that is no more.
    fn put_right(&mut self, step: &ExceptionStep, at: Tick) -> bool {
        if let ExceptionStep::Missing { part, .. } = step {
            return self.apply(at, &ProductionChange::Lost(*part)).is_ok();
        }
        let ExceptionStep::Closed { firing, mode, part: Some(part), ruling, .. } = step else { return false };
        self.leaving.remove(firing);
        match ruling.part {
            Whereabouts::To => self.leaves.contains(mode) && self.leave(*part, at),
            Whereabouts::From if !self.enters.contains_key(mode) => false,
            Whereabouts::From | Whereabouts::Gone => self.apply(at, &ProductionChange::Lost(*part)).is_ok(),
            Whereabouts::Carrier => false,
        }
    }

    fn enter(&mut self, mode: ModeId, part: PartId, at: Tick) -> bool {
        let Some(&product) = self.enters.get(&mode) else { return false };
        let Some(id) = self.in_turn(product, at).map(|order| order.id) else { return false };
        let Some(order) = self.orders.get_mut(&id) else { return false };
        order.entered += 1;
        order.begun.get_or_insert(at);
        order.newest = Some(at);
        // Numbers that are not free are those of all other parts that have entered.
        let number = order.freed.pop().unwrap_or(order.entered);
        self.of_part.insert(part, (id, number));
        true
    }

    fn leave(&mut self, part: PartId, at: Tick) -> bool {
        let Some((id, _)) = self.of_part.remove(&part) else { return false };
        if let Some(order) = self.orders.get_mut(&id) {
            order.done += 1;
            order.surplus += u32::from(order.cancelled.is_some());
        }
        self.close(id, at);
        true
    }

    /// Status of an order at a time.
    pub fn status(&self, order: &ProductionOrder, now: Tick) -> ProductionStatus {
        if order.withdrawn {
            return ProductionStatus::Withdrawn;
        }
        if let Some(at) = order.cancelled {
            return ProductionStatus::Cancelled { at, inside: order.inside() };
        }
        if let Some(at) = order.ended {
            return ProductionStatus::Done { at };
        }
        if let Some(begun) = order.begun {
            return ProductionStatus::InWork { begun };
        }
        let on = order.after.iter().copied().filter(|&id| self.end_of(id).is_none()).collect::<Vec<_>>();
        let until = order.request.release.filter(|&release| release > now);
        if on.is_empty() && until.is_none() {
            ProductionStatus::Released
        } else {
            ProductionStatus::Waiting { on, until }
        }
    }

    /// End of an order; the beginning for one that is not kept any more.
    fn end_of(&self, id: ProductionId) -> Option<Tick> {
        self.orders.get(&id).map_or(Some(Tick::ZERO), |order| order.ended)
    }

    /// Time from which parts of an order may enter; none as long as it is unknown.
    fn open_from(&self, order: &ProductionOrder) -> Option<Tick> {
        let from = order.request.release.unwrap_or(Tick::ZERO).max(order.accepted);
        order.after.iter().try_fold(from, |from, &id| Some(from.max(self.end_of(id)?)))
    }

    /// The orders of which parts have still to enter.
    pub fn missing(&self) -> impl Iterator<Item = &ProductionOrder> {
        self.orders.values().filter(|order| order.ended.is_none() && order.missing() > 0)
    }

    /// Order that the next part of a product counts to if it enters at a time.
    fn in_turn(&self, product: usize, at: Tick) -> Option<&ProductionOrder> {
        let may = self.missing().filter(|order| order.product == product);
        may.filter(|order| self.open_from(order).is_some_and(|from| from <= at)).min_by_key(|order| order.turn())
    }

    /// The modes by which parts of a product enter.
    pub fn entrances(&self, product: usize) -> impl Iterator<Item = ModeId> + '_ {
        self.enters.iter().filter(move |(_, of)| **of == product).map(|(&mode, _)| mode)
    }

    /// Data for a dispatcher at a time: of parts inside, and of those that may enter.
    pub fn jobs(&self, now: Tick) -> PartPriorities {
        let mut jobs = PartPriorities::default();
        let of = |(&part, (id, _)): (&PartId, &(ProductionId, u32))| Some((part, self.orders.get(id)?.job()));
        jobs.parts = self.of_part.iter().filter_map(of).collect();
        let count = self.products.len();
        let mut admission = Admission { product: self.enters.clone(), wanted: vec![0; count], more: vec![None; count] };
        for order in self.missing() {
            match self.open_from(order) {
                Some(from) if from <= now => {
                    let wanted = &mut admission.wanted[order.product];
                    *wanted = wanted.saturating_add(order.missing());
                }
                Some(from) => {
                    let more = &mut admission.more[order.product];
                    *more = Some(more.map_or(from, |known| known.min(from)));
                }
                None => (),
            }
        }
        for product in (0..count).filter(|&product| admission.wanted[product] > 0) {
            let Some(order) = self.in_turn(product, now) else { continue };
            // An order of many parts does not wait while one after the other enters.
            let since = self.open_from(order).into_iter().chain(order.newest).max().unwrap_or(now);
            let waiting = EntryCandidate { job: order.job(), since };
            jobs.outside.extend(self.entrances(product).map(|mode| (mode, waiting)));
        }
        jobs.admission = Some(admission);
        jobs
    }

    /// Next time after `now` at which the data for a dispatcher change by time alone.
    pub(in super::super) fn next_release(&self, now: Tick) -> Option<Tick> {
        self.missing().filter_map(|order| self.open_from(order)).filter(|&from| from > now).min()
    }
}
