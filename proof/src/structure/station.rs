//! One station's controller: the propositions of seed 002 §5.5, checked though they follow from the construction.

use linewright_line::net::{Conjunction, ControlMode, StationNet, StationPlace, overlaps};
use linewright_line::{Line, OpId, Station, StationId};
use linewright_nets::structure::{PlaceGroup, reduce};
use linewright_nets::{Net, PlaceId, StateMachineVerdict, state_machine_verdict};
use linewright_station_logic::Program;

use super::{Check, StructureReport};

/// Checks the net of one station.
pub fn judge(line: &Line, id: StationId) -> StructureReport {
    let station = line.station(id);
    let net = StationNet::of(line, id);
    let mut report = StructureReport::of(station, net.net().place_count(), net.net().transition_count());
    report.checks.push(Check::of("places", places(&report)));
    report.checks.push(Check::of("token", one_token(station, &net)));
    report.checks.extend(structure(&net, &groups(station, &net)));
    report.checks.push(Check::of("exclusive", exclusive(station, &net)));
    report.checks.push(Check::of("conditions", conditions(&net)));
    let tables = Program::compile(line, id);
    report.checks.push(Check::of("tables", tables.map(|_| "compiles".to_owned()).map_err(|e| e.to_string())));
    report
}

/// A station with j reversible and k irreversible operations has 6j + 3k places.
fn places(report: &StructureReport) -> Result<String, String> {
    let (j, k) = (report.reversible, report.irreversible);
    let expected = 6 * j + 3 * k;
    if report.places == expected {
        Ok(format!("6·{j} + 3·{k} = {expected}"))
    } else {
        Err(format!("{} places, not 6·{j} + 3·{k} = {expected}", report.places))
    }
}

fn one_token(station: &Station, net: &StationNet) -> Result<String, String> {
    let marking = net.net().initial_marking();
    let home = net.place_index(StationPlace::completed(station.home));
    let marked: Vec<usize> = marking.marked().map(PlaceId::index).collect();
    if marking.total() == 1 && home.is_some_and(|home| marked == [home]) {
        Ok(format!("on the completed `{}`", station.operations[station.home.index()].name))
    } else {
        Err(format!("starts with {}, not with one token at home", net.net().describe(&marking)))
    }
}

/// The places of each concurrent group, branch by branch.
fn groups(station: &Station, net: &StationNet) -> Vec<PlaceGroup> {
    let of_operation = |&op: &OpId| {
        let places = net.places().iter().zip(net.net().places());
        places.filter(|(place, _)| place.op == op).map(|(_, id)| id).collect()
    };
    station.steps.iter().filter(|step| step.len() > 1).map(|step| step.iter().map(of_operation).collect()).collect()
}

/// State machine, connection and verdict, of the net itself or of what it reduces to.
fn structure(net: &StationNet, groups: &[PlaceGroup]) -> Vec<Check> {
    let reduced = match reduce(net.net(), groups) {
        Ok(reduced) => reduced,
        Err(why) => return vec![Check::of("state machine", Err(why.to_string()))],
    };
    let mut checks = vec![
        Check::of("state machine", state_machine(&reduced, groups)),
        Check::of(
            "strongly connected",
            reduced
                .is_strongly_connected()
                .map_err(|why| why.to_string())
                .map(|()| "every place from every other".to_owned()),
        ),
    ];
    if let Ok(StateMachineVerdict { live, safe, reversible }) = state_machine_verdict(&reduced) {
        let say = |holds: &str| holds.to_owned();
        checks.push(Check::of("live", live.map(|()| say("connected, with a token")).map_err(|why| why.to_string())));
        checks.push(Check::of("safe", safe.map(|()| say("no two tokens can meet")).map_err(|why| why.to_string())));
        let back = reversible.map(|()| say("the token can return home")).map_err(|why| why.to_string());
        checks.push(Check::of("reversible", back));
    }
    checks
}

fn state_machine(reduced: &Net, groups: &[PlaceGroup]) -> Result<String, String> {
    reduced.is_state_machine().map_err(|why| why.to_string())?;
    Ok(match groups.len() {
        0 => "one input and one output place each".to_owned(),
        1 => "with its concurrent group taken as one place".to_owned(),
        n => format!("with its {n} concurrent groups taken as one place each"),
    })
}

/// Output transitions of a place exclude each other, mode by mode.
fn exclusive(station: &Station, net: &StationNet) -> Result<String, String> {
    let found = overlaps(net);
    let Some(first) = found.first() else {
        return Ok("conditions of the transitions of each place are exclusive".to_owned());
    };
    let name = net.place_index(first.place).map_or_else(
        || station.operations[first.place.op.index()].name.clone(),
        |index| net.net().place_name(PlaceId(index as u32)).to_owned(),
    );
    let (a, b) = (first.a.0, first.b.0);
    Err(format!("{} pairs overlap; the first: {a:?} and {b:?} out of `{name}` in {}", found.len(), first.mode))
}

/// No transition is dead by its own conditions: in some mode some term contradicts nothing in itself.
fn conditions(net: &StationNet) -> Result<String, String> {
    let possible = |term: &Conjunction| !term.iter().any(|a| term.iter().any(|b| a.excludes(*b)));
    let dead = net
        .transitions()
        .iter()
        .zip(net.net().transitions())
        .find(|(transition, _)| !ControlMode::ALL.iter().any(|&mode| transition.terms(mode).iter().any(possible)));
    match dead {
        None => Ok("each transition has a satisfiable condition in some mode".to_owned()),
        Some((_, id)) => Err(format!("`{}` can fire in no mode", net.net().transition_name(id))),
    }
}
