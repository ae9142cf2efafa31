//! `rejoin`: an operator confirms where a station stands. The answer is the station's own: its event, or its state.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use clap::Args;
use linewright_line::{Parameter, Station, StationId};
use linewright_msgs::{StationEvent, StationState, Text};
use linewright_node_line::Confirmation;
use linewright_node_shell::RosArgs;
use linewright_station_logic::{HappeningKind, NUMBERS_LOST, RejoinAt, StationHappening};
use miette::miette;
use tokio::time::{Instant, timeout_at};

use super::{ANSWER, CONNECT, print_station};
use crate::client::{OperatorClient, StateUpdate};
use crate::load;

/// Confirm where a station stands.
#[derive(Debug, Args)]
#[command(
    after_help = "A station that started without its journal does not move. Check the machine first: this sets its place from its limit switches. Between two switches, name the operation it was stopped in. A task-driven station that stands at another rest than its journal says is confirmed in the same way. Within a task its parameters are lost with the journal, and are confirmed with the place: --with slot=2. A number that was given wrongly is given again; those of an order are not replaced. Then lead all stations home in manual and give auto."
)]
pub struct RejoinArgs {
    /// The line's directory, or its description file.
    line: PathBuf,
    /// The station.
    station: String,
    /// Operation in which it was stopped; where its switches fit the ends of several, the one that was done last.
    #[arg(long, value_name = "OPERATION")]
    within: Option<String>,
    /// Rest at which a task-driven station stands, where its switches fit several.
    #[arg(long, value_name = "REST", conflicts_with = "within")]
    rest: Option<String>,
    /// Number of a parameter of the task that it stands in, e.g. slot=2; each of them.
    #[arg(long, value_name = "NAME=NUMBER", value_parser = number)]
    with: Vec<(Arc<str>, i32)>,
}

fn number(text: &str) -> Result<(Arc<str>, i32), String> {
    Confirmation::number(text).map_err(|error| error.to_string())
}

/// `linewright rejoin`
pub async fn rejoin(args: RejoinArgs, ros: &RosArgs) -> miette::Result<ExitCode> {
    let line = load::line(&args.line, true)?;
    let id = load::station(&line, &args.station)?;
    let station = line.station(id);
    let at = place(station, &args)?;
    let confirmation = Confirmation { at, numbers: args.with.clone() };
    check_numbers(station, &confirmation)?;
    let mut client = OperatorClient::open(&line, &args.line, ros, "operator")?;
    let publisher = client.rejoin(id)?;
    client.until_connected(CONNECT).await?;
    client.listen(ANSWER).await?;
    let is_task_driven = station.is_task_driven();
    let stand = |client: &OperatorClient| client.station(id).map(|state| Stand { is_task_driven, ..Stand::of(state) });
    let before = stand(&client);
    publisher.send(Text::from(confirmation.text(station).as_str()));
    let events = events_of(&mut client, id).await?;
    print_station(&client, id);
    let confirmed = StationHappening { cycle: 0, what: HappeningKind::Rejoined }.text(&line, id);
    let after = stand(&client);
    let is_changed = is_confirmed(before.as_ref(), after.as_ref());
    if events.iter().any(|event| event.text == confirmed) || is_changed {
        if !is_changed {
            crate::out::say!("{}: confirmed, it stands as before", station.name);
        }
        return Ok(ExitCode::SUCCESS);
    }
    let named = args.within.as_ref().or(args.rest.as_ref());
    let why = unchanged(after.as_ref(), named.map(String::as_str), !args.with.is_empty());
    crate::out::complain!("nothing changed: {why}");
    Ok(ExitCode::FAILURE)
}

/// The place that is confirmed.
fn place(station: &Station, args: &RejoinArgs) -> miette::Result<RejoinAt> {
    if let Some(name) = &args.within {
        let names: Vec<&str> = station.operations.iter().map(|operation| operation.name.as_str()).collect();
        let error = || miette!("unknown operation '{name}' of {}; operations: {}", station.name, names.join(", "));
        let unknown = || load::or_meant(error(), name, names.iter().copied());
        return station.operation_named(name).map(RejoinAt::Within).ok_or_else(unknown);
    }
    let Some(name) = &args.rest else { return Ok(RejoinAt::Measured) };
    let names: Vec<&str> = station.rests.iter().map(|rest| rest.name.as_str()).collect();
    let known =
        if names.is_empty() { "it is not task-driven".to_owned() } else { format!("rests: {}", names.join(", ")) };
    let unknown =
        || load::or_meant(miette!("unknown rest '{name}' of {}; {known}", station.name), name, names.iter().copied());
    station.rest_named(name).map(RejoinAt::Rest).ok_or_else(unknown)
}

/// Numbers that the station would refuse whatever it measures.
fn check_numbers(station: &Station, confirmation: &Confirmation) -> miette::Result<()> {
    let task = match confirmation.at {
        RejoinAt::Within(op) => station.task_of(op),
        RejoinAt::Measured | RejoinAt::Rest(_) => None,
    };
    let tasks = station.task_ids().filter(|id| task.is_none_or(|task| task == *id));
    let known: Vec<&Parameter> = tasks.flat_map(|id| &station.task(id).parameters).collect();
    let mut names: Vec<&str> = known.iter().map(|of| of.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    for (name, number) in &confirmation.numbers {
        let mut most = known.iter().filter(|of| *of.name == **name).map(|of| of.most());
        let Some(first) = most.next() else {
            let of = task.map_or_else(|| station.name.clone(), |task| format!("task `{}`", station.task(task).name));
            let all = if names.is_empty() { "it has none".to_owned() } else { names.join(", ") };
            let error = miette!("unknown parameter '{name}' of {of}; parameters: {all}");
            return Err(load::or_meant(error, name, names));
        };
        let most = most.fold(first, i32::max);
        if !(0..=most).contains(number) {
            let text = format!("{name}={number} does not fit the outputs of `{name}`: 0 to {most}");
            return Err(load::WrongArgument::new(text).into());
        }
    }
    Ok(())
}

/// What happens at the station in the time of an answer.
async fn events_of(client: &mut OperatorClient, id: StationId) -> miette::Result<Vec<StationEvent>> {
    let mut events = Vec::new();
    let until = Instant::now() + ANSWER;
    while let Ok(heard) = timeout_at(until, client.next()).await {
        match heard? {
            StateUpdate::Event(station, event) if station == id => events.push(event),
            StateUpdate::Event(..) | StateUpdate::Line | StateUpdate::Station(_) => {}
        }
    }
    Ok(events)
}

/// What the advice begins with where a confirmation is waited for.
const REJOIN: &str = "rejoin: ";

/// Where a station stands, by its state.
#[derive(Clone, Debug, Default)]
struct Stand {
    places: Vec<u8>,
    generation: u64,
    /// It has counts in common with no station, and needs none.
    is_task_driven: bool,
    is_lost: bool,
    fault: String,
    stopped: bool,
    devices_valid: bool,
    blocked_by: Vec<String>,
}

impl Stand {
    fn of(state: &StationState) -> Self {
        Stand {
            places: state.places.to_vec(),
            generation: state.generation,
            is_task_driven: false,
            is_lost: state.position_lost,
            fault: state.fault.to_string(),
            stopped: state.stopped,
            devices_valid: state.devices_valid,
            blocked_by: state.blocked_by.iter().map(ToString::to_string).collect(),
        }
    }
}

impl Stand {
    /// What a confirmation changes; the rest changes by itself.
    fn confirmed(&self) -> (&[u8], u64, bool) {
        (&self.places, self.generation, self.is_lost)
    }

    /// Whether there is anything to confirm: its position is lost or unknown.
    fn is_to_be_confirmed(&self) -> bool {
        let is_unknown = self.generation == 0 && !self.is_task_driven;
        is_unknown || self.is_lost || self.blocked_by.iter().any(|why| why.starts_with(REJOIN))
    }
}

/// Whether the states before and after show a confirmation. A station that moves, or has nothing to be confirmed, changes by itself:
/// in auto it stands elsewhere a moment later.
fn is_confirmed(before: Option<&Stand>, after: Option<&Stand>) -> bool {
    let (Some(before), Some(after)) = (before, after) else { return false };
    let stood = before.stopped && after.stopped;
    stood && before.is_to_be_confirmed() && before.confirmed() != after.confirmed()
}

/// Reason why a confirmation has changed nothing.
fn unchanged(state: Option<&Stand>, named: Option<&str>, has_numbers: bool) -> String {
    let Some(state) = state else { return "no state received from the station".to_owned() };
    if !state.stopped && state.is_to_be_confirmed() {
        return "rejected: station moving; rejoin needs standstill".to_owned();
    }
    if !state.stopped {
        return "its position is known, and it moves: nothing to confirm".to_owned();
    }
    let advice = state.blocked_by.iter().find_map(|why| why.strip_prefix(REJOIN));
    match (advice, named) {
        (None, _) if !state.devices_valid => {
            "rejected: its I/O devices are not operational, so its switches measure nothing".to_owned()
        }
        (Some(advice), _) if advice.contains(NUMBERS_LOST) && !has_numbers => advice.to_owned(),
        (Some(advice), _) if has_numbers && !advice.contains(NUMBERS_LOST) => {
            format!(
                "the numbers of its task are known from its order, or it stands in none; confirm its place without --with: {advice}"
            )
        }
        (Some(advice), Some(named)) => {
            let advice = advice.replace("name its operation with", "name another operation with");
            let numbers = if has_numbers { ", or the numbers are not those of its task" } else { "" };
            format!("its switches do not fit `{named}`, neither at its end nor on its way{numbers}: {advice}")
        }
        (Some(advice), None) => advice.to_owned(),
        (None, Some(named)) if state.is_lost => format!("its switches do not fit `{named}`: {}", state.fault),
        (None, None) if state.is_lost => format!("its switches do not tell where it stands: {}", state.fault),
        (None, named) if state.generation == 0 && !state.is_task_driven => match named {
            Some(named) => format!("its switches do not fit `{named}`, or no answer was received; its log has the reason"),
            None => "its switches do not determine where it stands: look, and name its operation with --within, as `recover` lists it; \
                     its log has the reason"
                .to_owned(),
        },
        (None, _) if has_numbers => {
            "its position is known, and the numbers of its task from its order: nothing to confirm".to_owned()
        }
        (None, _) => "its position is known, and its switches agree: nothing to confirm".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::{NUMBERS_LOST, Stand, is_confirmed, unchanged};

    /// It was called known, while its position was lost.
    #[test]
    fn a_position_that_is_lost_is_never_called_known() {
        let fault = "position lost: in_place is off; the homing of its drive: hold advance at its panel in manual";
        let lost = Stand {
            is_lost: true,
            generation: 5,
            fault: fault.into(),
            stopped: true,
            devices_valid: true,
            blocked_by: vec![fault.into()],
            ..Stand::default()
        };
        for named in [None, Some("index")] {
            let why = unchanged(Some(&lost), named, false);
            assert!(why.contains("the homing of its drive") && !why.contains("is known"), "{why}");
        }
        let known = Stand { is_lost: false, fault: String::new(), blocked_by: Vec::new(), ..lost };
        assert!(unchanged(Some(&known), None, false).contains("nothing to confirm"));
        // Without counts in common it takes a confirmation each time: no answer is no refusal.
        let without = Stand { generation: 0, ..known };
        assert!(unchanged(Some(&without), None, false).contains("name its operation with --within"));
        // A task-driven station never has any.
        let driven = Stand { is_task_driven: true, ..without };
        assert!(unchanged(Some(&driven), None, false).contains("nothing to confirm"));
    }

    /// The station in auto that stood elsewhere after it was taken for one that was confirmed.
    #[test]
    fn what_moves_by_itself_is_not_confirmed() {
        let stands = |places: &[u8], generation| Stand {
            places: places.to_vec(),
            generation,
            stopped: true,
            devices_valid: true,
            ..Stand::default()
        };
        let [lost, found] = [stands(&[0, 0], 0), stands(&[1, 0], 0)];
        assert!(is_confirmed(Some(&lost), Some(&found)));
        assert!(!is_confirmed(Some(&lost), Some(&lost)), "the same as before");
        assert!(!is_confirmed(None, Some(&found)), "nothing was known of it");
        let [in_auto, a_moment_later] = [stands(&[0, 0], 5), stands(&[1, 0], 5)];
        assert!(!is_confirmed(Some(&in_auto), Some(&a_moment_later)));
        let moves = Stand { stopped: false, ..in_auto };
        assert!(!is_confirmed(Some(&moves), Some(&a_moment_later)));
        assert_eq!(unchanged(Some(&moves), None, false), "its position is known, and it moves: nothing to confirm");
        let lost_and_moves = Stand { is_lost: true, ..moves };
        assert!(!is_confirmed(Some(&lost_and_moves), Some(&a_moment_later)));
        assert!(unchanged(Some(&lost_and_moves), None, false).contains("needs standstill"));
        let driven = Stand { is_task_driven: true, ..stands(&[0, 1], 0) };
        assert!(!is_confirmed(Some(&driven), Some(&Stand { places: vec![1, 1], ..driven.clone() })));
    }

    #[test]
    fn an_operation_that_was_named_is_not_asked_for_again() {
        let advice = "rejoin: axis not where the chart has it; its switches fit no place; move the axis onto its switch by \
                      hand, or name its operation with rejoin";
        let state =
            Stand { stopped: true, devices_valid: true, blocked_by: vec![advice.to_owned()], ..Stand::default() };
        let why = unchanged(Some(&state), Some("suck in"), false);
        assert!(why.starts_with("its switches do not fit `suck in`, neither at its end nor on its way"), "{why}");
        assert!(why.ends_with("or name another operation with rejoin"), "{why}");
        // The operation is not what was wrong.
        let advice = format!("rejoin: between two switches; {NUMBERS_LOST}: give them too (--with slot=NUMBER)");
        let state = Stand { blocked_by: vec![advice.clone()], ..state };
        let why = |has_numbers| format!("rejoin: {}", unchanged(Some(&state), Some("suck in"), has_numbers));
        assert_eq!(why(false), advice);
        assert!(
            why(true).contains("do not fit `suck in`") && why(true).contains("or the numbers are not"),
            "{}",
            why(true)
        );
    }
}
