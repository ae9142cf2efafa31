//! Holders, reaches and sensors: from the text to a draft, and from a draft to the line.
//!
//! They name axes, inputs and outputs of several stations, so this comes when all stations are known.

use linewright_text::{Located, LocatedName, NameTable, Problem, Report, TextRange, suggestion, tag, unique};

use super::draft::{DraftHandling, DraftHolder, DraftReach, DraftSensor, DraftSign, DraftStand, DraftStation};
use super::names::LineNames;
use super::raw::{RawHolder, RawLine, RawReach, RawSensor, RawSign, RawStand};
use super::wiring;
use crate::{AxisId, Grip, Holder, HolderId, InputId, MaterialFlow, OutputId, Reach, Sensor, Sign, Stand, StationId};

/// Separator between a station and its holder or axis.
const DOT: char = '.';

/// Resolves all names that it can, and records at each station which of its inputs see parts.
pub(super) fn resolve<'a>(
    raw: &'a RawLine,
    names: &LineNames<'a>,
    stations: &mut [DraftStation<'a>],
    report: &mut Report,
) -> DraftHandling<'a> {
    let holders = holders(raw, names, report);
    let full: Vec<LocatedName> =
        holders.iter().map(|holder| Located::new(holder.name.clone(), holder.raw.at.clone())).collect();
    let mut table = NameTable::default();
    for (id, (name, holder)) in full.iter().zip(&holders).enumerate() {
        table.note(name, holder.is_well_named);
        table.define(name, id);
    }
    let scope = HolderScope { raw, names, stations, holders: &table };
    let mut reaches = Vec::new();
    for (station, of) in raw.stations.iter().enumerate() {
        reaches.extend(of.reaches.iter().map(|reach| scope.reach(station, reach, report)));
    }
    let sensors: Vec<_> = raw.sensors.iter().map(|sensor| scope.sensor(sensor, report)).collect();
    for (station, input) in sensors.iter().filter_map(|sensor| sensor.input.clone()) {
        stations[station.index()].sensed.push(input);
    }
    DraftHandling { holders, reaches, sensors }
}

/// Those of stations come first, in the order of the text.
fn holders<'a>(raw: &'a RawLine, names: &LineNames<'a>, report: &mut Report) -> Vec<DraftHolder<'a>> {
    let mut holders = Vec::new();
    for (id, station) in raw.stations.iter().enumerate() {
        let mut inside = NameTable::default();
        let prefix = station.name.as_ref().map_or("?", |name| name.value.as_str());
        let is_station_well_named = !names.stations.is_malformed(id);
        for holder in &station.holders {
            let closes = holder.closes.as_ref().and_then(|closes| {
                let RawStand { axis, position, .. } = closes;
                let axis = axis.as_ref()?;
                let found = names.inside[id].axes.find(axis, "axis", report)?;
                let place = position.as_ref()?.at.clone();
                Some(stand(id, found, position.as_ref()?.value, place))
            });
            let (name, fits) = named(holder, &mut inside, holders.len(), report);
            let is_well_named = fits && is_station_well_named;
            holders.push(DraftHolder { raw: holder, name: format!("{prefix}{DOT}{name}"), is_well_named, closes });
        }
    }
    let mut free = NameTable::default();
    for holder in &raw.holders {
        let (name, is_well_named) = named(holder, &mut free, holders.len(), report);
        holders.push(DraftHolder { raw: holder, name: name.to_owned(), is_well_named, closes: None });
    }
    holders
}

/// Its name, and whether that is well formed.
fn named<'a>(raw: &'a RawHolder, table: &mut NameTable<'a>, id: usize, report: &mut Report) -> (&'a str, bool) {
    let Some(name) = &raw.name else { return ("?", true) };
    let has_dot = name.value.contains(DOT);
    if has_dot {
        report.add(
            Problem::error(name.at.clone(), format!("`{}` cannot name this holder", name.value))
                .hint("one word without a full stop: a station's holder is called `station.holder` elsewhere"),
        );
    }
    unique(table, name, id, "holder", report);
    (&name.value, tag(name, "holder", report) && !has_dot)
}

fn stand(station: usize, axis: usize, at: f64, place: TextRange) -> DraftStand {
    Located::new(Stand { station: StationId::at(station), axis: AxisId::at(axis), at }, place)
}

struct HolderScope<'a, 's> {
    raw: &'a RawLine,
    names: &'s LineNames<'a>,
    stations: &'s [DraftStation<'a>],
    holders: &'s NameTable<'s>,
}

impl HolderScope<'_, '_> {
    fn reach<'r>(&self, station: usize, raw: &'r RawReach, report: &mut Report) -> DraftReach<'r> {
        let station_name = self.stations[station].name;
        let hand = raw.hand.as_ref().and_then(|name| {
            let full = Located::new(format!("{station_name}{DOT}{}", name.value), name.at.clone());
            let found = self.holders.meant(&full.value);
            if found.is_none() {
                let prefix = format!("{station_name}{DOT}");
                let mine = self.holders.names().filter_map(|name| name.strip_prefix(&prefix));
                report.add(
                    Problem::error(name.at.clone(), format!("unknown holder `{}` of this station", name.value))
                        .maybe_hint(suggestion(&name.value, mine)),
                );
            }
            found.map(HolderId::at)
        });
        let axes = &self.names.inside[station].axes;
        let when = raw.when.iter().map(|(name, at)| {
            let axis = axes.find(name, "axis", report)?;
            Some(stand(station, axis, *at, name.at.clone()))
        });
        let when: Vec<_> = when.collect();
        let bits = raw.position.iter().flat_map(|bits| &bits.value);
        let position = bits.map(|bit| self.output(station, bit, report)).collect();
        DraftReach { raw, hand, to: self.holder(raw.to.as_ref(), report), when, position }
    }

    fn sensor(&self, raw: &RawSensor, report: &mut Report) -> DraftSensor {
        let station = raw.station.as_ref().and_then(|name| self.names.stations.find(name, "station", report));
        let input = station.and_then(|station| {
            let name = raw.input.as_ref()?;
            let inputs = &self.stations[station].wiring.inputs;
            let found = self.bit(station, name, "input", inputs, report)?;
            Some((StationId::at(station), Located::new(InputId::at(found), name.at.clone())))
        });
        DraftSensor { at: raw.at.clone(), input, when: raw.when.iter().map(|sign| self.sign(sign, report)).collect() }
    }

    /// A part in a holder, or an axis at a position, written as `station.axis`.
    fn sign(&self, raw: &RawSign, report: &mut Report) -> Option<DraftSign> {
        match (&raw.part, &raw.axis, &raw.position) {
            (Some(part), None, None) => {
                let holder = self.holder(Some(part), report)?;
                Some(DraftSign::Part(holder.value))
            }
            (None, Some(axis), Some(position)) => {
                let (station, found) = self.axis(axis, report)?;
                Some(DraftSign::Stands(stand(station, found, position.value, position.at.clone())))
            }
            _ => {
                report.add(
                    Problem::error(raw.at.clone(), "this says nothing that a sensor could see")
                        .hint("`{ part = \"robot.hand\" }`, or `{ axis = \"robot.arm\", at = 100 }`"),
                );
                None
            }
        }
    }

    fn axis(&self, name: &LocatedName, report: &mut Report) -> Option<(usize, usize)> {
        let Some((station, axis)) = name.value.split_once(DOT) else {
            report.add(
                Problem::error(name.at.clone(), format!("`{}` names no axis", name.value))
                    .hint("write `station.axis`, as in \"robot.arm\""),
            );
            return None;
        };
        let half = |text: &str| Located::new(text.to_owned(), name.at.clone());
        let station = self.names.stations.find(&half(station), "station", report)?;
        // A malformed name may contain the full stop at which this was taken apart.
        let is_whole = !self.names.stations.is_malformed(station);
        let axis = if is_whole { axis } else { axis.rsplit(DOT).next().unwrap_or(axis) };
        let axis = self.names.inside[station].axes.find(&half(axis), "axis of this station", report)?;
        Some((station, axis))
    }

    fn holder(&self, name: Option<&LocatedName>, report: &mut Report) -> Option<Located<HolderId>> {
        let name = name?;
        let found = self.holders.find(name, "holder", report)?;
        Some(Located::new(HolderId::at(found), name.at.clone()))
    }

    fn output(&self, station: usize, name: &LocatedName, report: &mut Report) -> Option<Located<OutputId>> {
        let outputs = &self.stations[station].wiring.outputs;
        let found = self.bit(station, name, "output", outputs, report)?;
        Some(Located::new(OutputId::at(found), name.at.clone()))
    }

    fn bit(
        &self,
        station: usize,
        name: &LocatedName,
        what: &str,
        bits: &[Located<String>],
        report: &mut Report,
    ) -> Option<usize> {
        let bits = NameTable::of_tags(bits);
        let found = bits.meant(&name.value);
        if found.is_none() && !report.is_full() && !wiring::is_on_unowned(self.raw, self.names, &name.value) {
            let of = self.stations[station].name;
            report.add_unknown(
                Problem::error(name.at.clone(), format!("no device of station `{of}` has an {what} `{}`", name.value))
                    .maybe_hint(suggestion(&name.value, bits.names())),
            );
        }
        found
    }
}

/// Material flow of the line.
pub(super) fn finish(draft: &DraftHandling<'_>) -> Option<MaterialFlow> {
    let holder = |holder: &DraftHolder<'_>| {
        let places = holder.raw.places.as_ref().map_or(Some(1), |places| u16::try_from(places.value).ok())?;
        let closes = holder.closes.as_ref().map(|stand| stand.value);
        let grip = match (holder.raw.is_hand, closes) {
            (true, closes) => Grip::Hand(closes?),
            (false, Some(closes)) => Grip::Clamp(closes),
            (false, None) => Grip::Loose,
        };
        Some(Holder { name: holder.name.clone(), places, grip })
    };
    let reach = |reach: &DraftReach<'_>| {
        let when = reach.when.iter().map(|stand| Some(stand.as_ref()?.value));
        let position = reach.position.iter().map(|bit| Some(bit.as_ref()?.value));
        Some(Reach {
            hand: reach.hand?,
            to: reach.to.as_ref()?.value,
            when: when.collect::<Option<_>>()?,
            position: position.collect::<Option<_>>()?,
        })
    };
    let sensor = |sensor: &DraftSensor| {
        let (station, input) = sensor.input.as_ref()?;
        let when = sensor.when.iter().map(|sign| match sign.as_ref()? {
            DraftSign::Part(holder) => Some(Sign::Part(*holder)),
            DraftSign::Stands(stand) => Some(Sign::Stands(stand.value)),
        });
        Some(Sensor { station: *station, input: input.value, when: when.collect::<Option<_>>()? })
    };
    Some(MaterialFlow {
        holders: draft.holders.iter().map(holder).collect::<Option<_>>()?,
        reaches: draft.reaches.iter().map(reach).collect::<Option<_>>()?,
        sensors: draft.sensors.iter().map(sensor).collect::<Option<_>>()?,
    })
}
