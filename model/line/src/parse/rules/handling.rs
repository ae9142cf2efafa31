//! Places of parts: do hands close, can they come to what they reach, and can a number give every position?

use linewright_text::{Located, Problem, Report};

use super::operations::same_place;
use crate::parse::draft::{DraftHolder, DraftLine, DraftReach, DraftSensor, DraftSign, DraftStand};
use crate::{InputId, Motion, Stand};

/// Applies the rules.
pub(super) fn check(draft: &DraftLine<'_>, report: &mut Report) {
    let handling = &draft.handling;
    for (id, holder) in handling.holders.iter().enumerate() {
        hands_close(holder, report);
        let reaches = handling.reaches.iter().any(|reach| reach.hand.is_some_and(|hand| hand.index() == id));
        if holder.raw.is_hand && !reaches && handling.reaches.iter().all(|reach| reach.hand.is_some()) {
            report.add(
                Problem::warning(holder.place(), format!("`{}` reaches nothing", holder.name))
                    .hint("say from where it takes parts, with `[[station.reach]]`"),
            );
        }
    }
    for reach in &handling.reaches {
        hands_reach_nests(draft, reach, report);
        positions_can_be_told(draft, reach, report);
    }
    let of_sensors = handling.sensors.iter().flat_map(|sensor| &sensor.when).flatten().filter_map(|sign| match sign {
        DraftSign::Stands(stand) => Some(stand),
        DraftSign::Part(_) => None,
    });
    let of_reaches = handling.reaches.iter().flat_map(|reach| &reach.when).flatten();
    let of_holders = handling.holders.iter().filter_map(|holder| holder.closes.as_ref());
    for stand in of_holders.chain(of_reaches).chain(of_sensors) {
        axes_come_there(draft, stand, report);
    }
    hands_are_looked_into(draft, report);
    one_nest_at_a_time(&handling.reaches, report);
    for sensor in handling.sensors.iter().filter(|sensor| sensor.when.is_empty()) {
        report.add(
            Problem::error(sensor.at.clone(), "a sensor that sees nothing")
                .hint("say what it sees: `when = [{ part = \"…\" }]`"),
        );
    }
}

fn hands_close(holder: &DraftHolder<'_>, report: &mut Report) {
    if holder.raw.is_hand && holder.raw.closes.is_none() {
        report.add(
            Problem::error(holder.place(), format!("nothing closes the hand `{}`", holder.name))
                .hint("say where it is closed: `closes = { axis = \"…\", at = … }`"),
        );
    }
}

fn hands_reach_nests(draft: &DraftLine<'_>, reach: &DraftReach<'_>, report: &mut Report) {
    let holders = &draft.handling.holders;
    if let (Some(hand), Some(name)) = (reach.hand, &reach.raw.hand)
        && !holders[hand.index()].raw.is_hand
    {
        report.add(
            Problem::error(name.at.clone(), format!("`{}` is no hand", holders[hand.index()].name))
                .hint("what reaches others is a hand: `kind = \"hand\"`"),
        );
    }
    if let Some(to) = &reach.to
        && holders[to.value.index()].raw.is_hand
    {
        report.add(
            Problem::error(to.at.clone(), format!("`{}` is a hand", holders[to.value.index()].name))
                .hint("a hand takes from a nest, and puts down in one"),
        );
    }
}

fn positions_can_be_told(draft: &DraftLine<'_>, reach: &DraftReach<'_>, report: &mut Report) {
    let Some(to) = &reach.to else { return };
    let nest = &draft.handling.holders[to.value.index()];
    let places = nest.raw.places.as_ref().map_or(1, |places| places.value);
    let bits = reach.position.len();
    match &reach.raw.position {
        None if places > 1 => report.add(
            Problem::error(to.at.clone(), format!("`{}` has {places} positions", nest.name))
                .hint("say which outputs tell at which one: `position = [\"…\", \"…\"]`, the lowest bit first"),
        ),
        Some(position) if places == 1 => report.add(
            Problem::error(position.at.clone(), format!("`{}` has one position", nest.name))
                .hint("leave `position` out, or give it `places`"),
        ),
        Some(position) if (1i64 << bits) <= places => report.add(
            Problem::error(position.at.clone(), format!("{bits} outputs cannot tell {places} positions apart"))
                .also(&to.at, "these")
                .hint("positions are numbered from 1"),
        ),
        Some(position) => {
            for (nth, bit) in position.value.iter().enumerate() {
                if let Some(earlier) = position.value[..nth].iter().find(|earlier| earlier.value == bit.value) {
                    report.add(
                        Problem::error(bit.at.clone(), format!("`{}` is two bits of one number", bit.value))
                            .also(&earlier.at, "the other one"),
                    );
                }
            }
        }
        None => {}
    }
}

/// An axis that stands nowhere but at the ends of its motions must end one there.
fn axes_come_there(draft: &DraftLine<'_>, stand: &DraftStand, report: &mut Report) {
    let Stand { station, axis, at } = stand.value;
    let station = &draft.stations[station.index()];
    if station.operations.iter().any(|operation| operation.motion.is_none()) {
        return;
    }
    let motions = station.operations.iter().flat_map(|operation| &operation.motion);
    let mine = motions.filter(|motion| motion.value.axis == axis);
    let home = station.axes[axis.index()].home;
    let mut ends: Vec<f64> = mine.flat_map(|motion| [motion.value.from, motion.value.to]).chain([home]).collect();
    if ends.iter().any(|end| same_place(*end, at)) {
        return;
    }
    ends.sort_by(f64::total_cmp);
    ends.dedup_by(|a, b| same_place(*a, *b));
    let ends: Vec<String> = ends.iter().map(f64::to_string).collect();
    report.add(
        Problem::error(stand.at.clone(), format!("`{}` never stands at {at}", station.axes[axis.index()].name))
            .hint(format!("its motions end at {}", ends.join(", "))),
    );
}

/// A grasp without a part shows at once only in a sensor of the hand. So something in its task has to look at that after the hand has
/// closed; the last operation is exempt, since nothing follows it.
fn hands_are_looked_into(draft: &DraftLine<'_>, report: &mut Report) {
    for (id, holder) in draft.handling.holders.iter().enumerate().filter(|(_, holder)| holder.raw.is_hand) {
        let Some(Stand { station, axis, at }) = holder.closes.as_ref().map(|closes| closes.value) else { continue };
        let of = &draft.stations[station.index()];
        let sees_it =
            |sensor: &&DraftSensor| matches!(&sensor.when[..], [Some(DraftSign::Part(seen))] if seen.index() == id);
        let seen = draft.handling.sensors.iter().filter(sees_it).filter_map(|sensor| sensor.input.as_ref());
        let inputs: Vec<InputId> = seen.filter(|(sees, _)| *sees == station).map(|(_, input)| input.value).collect();
        let Some(input) = inputs.first() else { continue };
        let input = &of.wiring.inputs[input.index()].value;
        for task in &of.tasks {
            let operations = &of.operations[task.ops.clone()];
            for (nth, closing) in operations.iter().enumerate().take(operations.len().saturating_sub(1)) {
                let is_closing =
                    |motion: &Located<Motion>| motion.value.axis == axis && same_place(motion.value.to, at);
                let results = operations[nth..].iter().flat_map(|op| &op.result);
                let mut looks = operations[nth + 1..].iter().flat_map(|op| &op.waits).chain(results);
                if closing.motion.as_ref().is_some_and(is_closing) && !looks.any(|look| inputs.contains(&look.value)) {
                    let message = format!(
                        "`{}` closes `{}`, and nothing in its task looks whether there is a part in it",
                        closing.name, holder.name
                    );
                    let hint =
                        format!("`{input}` shows that: `result = {{ input = \"{input}\", within_s = 0.5, code = … }}`");
                    report.add(Problem::warning(closing.place(), message).hint(hint));
                }
            }
        }
    }
}

/// Two reaches of a hand exclude each other by an axis that cannot stand at two places.
fn one_nest_at_a_time(reaches: &[DraftReach<'_>], report: &mut Report) {
    for (nth, reach) in reaches.iter().enumerate() {
        let differ =
            |a: &DraftStand, b: &DraftStand| a.value.axis == b.value.axis && !same_place(a.value.at, b.value.at);
        let excluded = |other: &DraftReach<'_>| {
            reach.when.iter().flatten().any(|a| other.when.iter().flatten().any(|b| differ(a, b)))
        };
        let whole = |reach: &DraftReach<'_>| reach.when.iter().all(Option::is_some);
        let mut earlier = reaches[..nth].iter().filter(|other| other.hand == reach.hand && reach.hand.is_some());
        if let Some(other) = earlier.find(|other| whole(other) && whole(reach) && !excluded(other)) {
            report.add(
                Problem::error(reach.raw.at.clone(), "the hand would reach two nests at once")
                    .also(&other.raw.at, "this one, too")
                    .hint("let an axis stand elsewhere in the one than in the other"),
            );
        }
    }
}
