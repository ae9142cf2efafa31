//! Names → numbers: from the description as written to a [`DraftCell`].
//!
//! The only pass that looks names up. Each reference either becomes a number or is reported with what it could have
//! been; what the numbers may be combined to is for the rules.

use linewright_line::Line;
use linewright_text::{Located, LocatedName, NameTable, Problem, Report, Scalar, TextRange, suggestion};

use super::draft::{DraftActivity, DraftCell, DraftException, DraftOrder, DraftPart, DraftResource, DraftStep};
use super::names::{CellNames, OUTSIDE};
use super::plan::{plan, variant};
use super::raw::{RawCell, RawCellAction, RawException, RawOrder, RawPart, RawResource, RawSync};
use crate::{
    ActivityId, ActivityKind, ControllerId, LeftOut, ParameterSource, Prototype, ResourceAction, ResourceId, Role,
    StopOf, Use, Whereabouts,
};

/// Resolves everything that can be.
pub(super) fn resolve<'a>(
    raw: &'a RawCell,
    names: &CellNames<'a>,
    line: Option<&'a Line>,
    report: &mut Report,
) -> DraftCell<'a> {
    let controllers = controllers(raw);
    let resources: Vec<_> = raw.resources.iter().map(|r| resource(r, &controllers, report)).collect();
    let mut scope = CellScope { names, resources: &resources, controllers: &controllers };
    let mut activities: Vec<_> = raw.syncs.iter().map(|sync| scope.sync(sync, report)).collect();
    activities.extend(scope.processes(&raw.actions, report));
    let mut parts = Vec::new();
    for (raw, steps) in raw.parts.iter().zip(&names.steps) {
        let part = scope.part(raw, steps, report);
        let variants: Vec<_> = raw.variants.iter().map(|raw| variant(&part, raw, steps, report)).collect();
        parts.push(part);
        parts.extend(variants);
    }
    let among = (&activities[..], &resources[..], &controllers);
    let exceptions = raw.exceptions.iter().map(|raw| exception(raw, among, names, report)).collect();
    DraftCell { raw, line, controllers, resources, activities, parts, exceptions }
}

/// The stations, in the order in which they are named: by resources first, then by orders.
fn controllers(raw: &RawCell) -> NameTable<'_> {
    let orders = raw.syncs.iter().map(|sync| &sync.orders).chain(raw.actions.iter().map(|action| &action.orders));
    let of_resources = raw.resources.iter().filter_map(|resource| resource.station.as_ref());
    let (mut table, mut next) = (NameTable::default(), 0);
    for name in of_resources.chain(orders.flatten().filter_map(|order| order.station.as_ref())) {
        next += usize::from(table.define(name, next).is_none());
    }
    table
}

fn resource<'a>(raw: &'a RawResource, controllers: &NameTable<'a>, report: &mut Report) -> DraftResource<'a> {
    let prototype = raw.prototype.as_ref().and_then(|name| {
        let found = Prototype::ALL.into_iter().find(|prototype| prototype.name() == name.value);
        if found.is_none() {
            report.add(
                Problem::error(name.at.clone(), format!("unknown prototype `{}`", name.value))
                    .maybe_hint(suggestion(&name.value, Prototype::ALL.map(Prototype::name))),
            );
        }
        found
    });
    let most = prototype.and_then(Prototype::capacity_max);
    let given = raw.capacity.as_ref().and_then(|capacity| u32::try_from(capacity.value).ok());
    let given = given.filter(|given| most.is_some_and(|most| (1..=most).contains(given)));
    DraftResource {
        raw,
        name: raw.name.as_ref().map_or("?", |name| name.value.as_str()),
        prototype,
        capacity: given.or_else(|| prototype.filter(|_| raw.capacity.is_none())?.usual_capacity()),
        controller: raw.station.as_ref().and_then(|name| controllers.get(&name.value)).map(ControllerId::at),
    }
}

/// Meanings of names.
struct CellScope<'a, 's> {
    names: &'s CellNames<'a>,
    resources: &'s [DraftResource<'a>],
    controllers: &'s NameTable<'a>,
}

impl<'a> CellScope<'a, '_> {
    fn sync(&mut self, raw: &'a RawSync, report: &mut Report) -> DraftActivity<'a> {
        let written = raw.actions.iter().flat_map(|actions| &actions.value);
        let uses: Vec<_> = written.map(|name| self.action(name, report)).collect();
        let is_whole = raw.actions.is_some() && uses.iter().all(Option::is_some);
        let uses: Vec<_> = uses.into_iter().flatten().collect();
        let does = |action| uses.iter().any(|part: &Located<Use>| part.value.action == action);
        let kind = match (does(ResourceAction::In), does(ResourceAction::Out)) {
            (true, _) => ActivityKind::Enter,
            (false, true) => ActivityKind::Leave,
            (false, false) => ActivityKind::Transport,
        };
        DraftActivity {
            name: raw.name.as_ref().map_or_else(|| "?".to_owned(), |name| name.value.clone()),
            at: raw.name.as_ref().map_or_else(|| raw.at.clone(), |name| name.at.clone()),
            kind,
            uses,
            is_whole,
            time: raw.time.clone(),
            orders: raw.orders.iter().map(|order| self.order(order, report)).collect(),
        }
    }

    /// `resource.action`, or `outside.in` and `outside.out`.
    fn action(&self, name: &LocatedName, report: &mut Report) -> Option<Located<Use>> {
        let Some((holder, action)) = name.value.rsplit_once('.') else {
            report.add(
                Problem::error(name.at.clone(), format!("`{}` names no action", name.value))
                    .label("no full stop")
                    .hint("write \"resource.action\", as in \"M1.load\""),
            );
            return None;
        };
        let (of, can): (_, &[ResourceAction]) = if holder == OUTSIDE {
            (None, &[ResourceAction::In, ResourceAction::Out])
        } else {
            let id = self.resource_named(holder, &name.at, report)?;
            (Some(id), self.resources[id.index()].prototype?.actions())
        };
        if let Some(&action) = can.iter().find(|known| known.name() == action) {
            return Some(Located::new(Use { of, action }, name.at.clone()));
        }
        let what = of.and_then(|id| self.resources[id.index()].prototype);
        let what = what.map_or_else(String::new, |prototype| format!(" ({})", prototype.name()));
        report.add(
            Problem::error(name.at.clone(), format!("`{holder}`{what} has no action `{action}`"))
                .maybe_hint(suggestion(action, can.iter().map(|action| action.name()))),
        );
        None
    }

    fn resource_named(&self, name: &str, at: &TextRange, report: &mut Report) -> Option<ResourceId> {
        let found = self.names.resources.find(&Located::new(name.to_owned(), at.clone()), "resource", report);
        found.map(ResourceId::at)
    }

    /// One activity for each resource that works on parts, with the orders of its `[[action]]`.
    fn processes(&self, raw: &'a [RawCellAction], report: &mut Report) -> Vec<DraftActivity<'a>> {
        let mut described = NameTable::default();
        for (id, action) in raw.iter().enumerate() {
            let Some(of) = &action.of else { continue };
            linewright_text::unique(&mut described, of, id, "description of action", report);
            let Some(found) = self.action(of, report) else { continue };
            if found.value.action.role() != Role::Worker {
                report.add(
                    Problem::error(of.at.clone(), format!("`{}` happens in synchronisations only", of.value))
                        .hint("write its orders under the `[[sync]]` it is part of; here stands `….process`"),
                );
            }
        }
        let working = self.resources.iter().enumerate().filter(|(_, r)| r.prototype.is_some_and(Prototype::processes));
        working
            .map(|(id, resource)| {
                let name = format!("{}.{}", resource.name, ResourceAction::Process.name());
                let described = described.get(&name).map(|id| &raw[id]);
                let part = Use { of: Some(ResourceId::at(id)), action: ResourceAction::Process };
                DraftActivity {
                    at: resource.place(),
                    kind: ActivityKind::Process,
                    uses: vec![Located::new(part, resource.place())],
                    is_whole: true,
                    time: None,
                    orders: described
                        .map(|raw| raw.orders.iter().map(|order| self.order(order, report)).collect())
                        .unwrap_or_default(),
                    name,
                }
            })
            .collect()
    }

    fn order(&self, raw: &'a RawOrder, report: &mut Report) -> DraftOrder<'a> {
        let mut parameters = Vec::new();
        for (name, value) in &raw.parameters {
            parameters.extend(self.parameter(value, report).map(|source| (name.value.as_str(), source)));
        }
        let controller = raw.station.as_ref().and_then(|name| self.controllers.get(&name.value));
        DraftOrder { raw, controller: controller.map(ControllerId::at), parameters }
    }

    /// A number, `step.program`, or the position in a store.
    fn parameter(&self, value: &Located<Scalar>, report: &mut Report) -> Option<ParameterSource> {
        let text = match &value.value {
            Scalar::Integer(number) => {
                let fits = i32::try_from(*number);
                if fits.is_err() {
                    report.add(
                        Problem::error(value.at.clone(), format!("the parameter {number} is too large"))
                            .hint("a parameter has 32 bits"),
                    );
                }
                return fits.ok().map(ParameterSource::Number);
            }
            Scalar::Text(text) => text,
        };
        match text.rsplit_once('.') {
            Some(("step", "program")) => Some(ParameterSource::Program),
            Some((store, "position")) => {
                Some(ParameterSource::Position(self.resource_named(store, &value.at, report)?))
            }
            Some(_) | None => {
                report.add(
                    Problem::error(value.at.clone(), format!("`{text}` is no value of a parameter"))
                        .hint("a whole number, \"step.program\", or \"….position\" of a store"),
                );
                None
            }
        }
    }

    fn part(&self, raw: &'a RawPart, names: &NameTable<'a>, report: &mut Report) -> DraftPart<'a> {
        let plan = plan(raw, names, report);
        let mut is_whole = plan.is_whole;
        let mut steps = Vec::with_capacity(raw.steps.len());
        for (step, &(from, to)) in raw.steps.iter().zip(&plan.steps) {
            let on: Vec<_> = step
                .on
                .iter()
                .map(|on| {
                    let name = on.resource.as_ref()?;
                    self.resource_named(&name.value, &name.at, report)
                })
                .collect();
            is_whole &= on.iter().all(Option::is_some);
            let name = step.name.as_ref().map_or("?", |name| name.value.as_str());
            steps.push(DraftStep { raw: step, name, from, to, on });
        }
        let name = raw.name.as_ref().map_or("?", |name| name.value.as_str());
        DraftPart { raw, variant: None, name, stages: plan.stages, steps, is_whole }
    }
}

fn exception<'a>(
    raw: &'a RawException,
    (activities, resources, controllers): (&[DraftActivity<'_>], &[DraftResource<'_>], &NameTable<'_>),
    names: &CellNames<'_>,
    report: &mut Report,
) -> DraftException<'a> {
    let stopped = raw.emergency_stop.iter().flat_map(|names| &names.value);
    let emergency_stop = stopped.filter_map(|name| stop_of(name, resources, controllers, report)).collect();
    let always = left_out(raw.down.as_ref(), names, report);
    let down = raw.answers.iter().map(|answer| {
        let mut down = left_out(answer.down.as_ref(), names, report);
        down.extend(always.iter().filter(|of| !down.contains(of)).copied().collect::<Vec<_>>());
        down
    });
    let down = down.collect();
    let Some(pattern) = &raw.within else {
        return DraftException { raw, activities: Vec::new(), down, emergency_stop };
    };
    let meant = activities.iter().enumerate().filter(|(_, activity)| fits(&pattern.value, &activity.name));
    let found: Vec<_> = meant.map(|(id, _)| ActivityId::at(id)).collect();
    if found.is_empty() {
        let names = activities.iter().map(|activity| activity.name.as_str());
        report.add(
            Problem::error(pattern.at.clone(), format!("`{}` fits no synchronisation and no action", pattern.value))
                .maybe_hint(suggestion(&pattern.value, names)),
        );
    }
    DraftException { raw, activities: found, down, emergency_stop }
}

/// A station by its name, or all of the activity.
fn stop_of(
    name: &LocatedName,
    resources: &[DraftResource<'_>],
    controllers: &NameTable<'_>,
    report: &mut Report,
) -> Option<StopOf> {
    if name.value == "*" {
        return Some(StopOf::Activity);
    }
    if let Some(id) = controllers.get(&name.value) {
        return Some(StopOf::Station(ControllerId::at(id)));
    }
    let own = resources.iter().find(|resource| resource.name == name.value);
    let problem = Problem::error(name.at.clone(), format!("there is no station `{}`", name.value));
    report.add(match own {
        Some(resource) => match &resource.raw.station {
            Some(station) => {
                problem.hint(format!("`{}` is a resource; its station is `{}`", name.value, station.value))
            }
            None => problem.hint(format!("`{}` is a resource, and has none", name.value)),
        },
        None => problem.maybe_hint(suggestion(&name.value, controllers.names())),
    });
    None
}

/// Resources by name, or by their role for the part: a resource of such a name comes first.
fn left_out(written: Option<&Located<Vec<LocatedName>>>, names: &CellNames<'_>, report: &mut Report) -> Vec<LeftOut> {
    let roles = [("from", Whereabouts::From), ("to", Whereabouts::To), ("carrier", Whereabouts::Carrier)];
    let mut one = |name: &LocatedName| {
        let role = roles.iter().find(|(word, _)| *word == name.value).map(|&(_, part)| LeftOut::As(part));
        let role = role.filter(|_| names.resources.get(&name.value).is_none());
        role.or_else(|| names.resources.find(name, "resource", report).map(|id| LeftOut::Resource(ResourceId::at(id))))
    };
    written.into_iter().flat_map(|names| &names.value).filter_map(&mut one).collect()
}

/// Whether a name fits a pattern in which `*` stands for anything.
pub fn fits(pattern: &str, name: &str) -> bool {
    let mut pieces = pattern.split('*');
    let first = pieces.next().unwrap_or_default();
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let mut pieces = pieces.peekable();
    if pieces.peek().is_none() {
        return rest.is_empty();
    }
    while let Some(piece) = pieces.next() {
        if pieces.peek().is_none() {
            return rest.ends_with(piece);
        }
        let Some(at) = rest.find(piece) else { return false };
        rest = &rest[at + piece.len()..];
    }
    true
}
