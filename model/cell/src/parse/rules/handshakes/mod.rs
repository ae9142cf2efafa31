//! Handshakes of an activity, beside the line that describes its stations: can the orders complete together, by what the
//! sensors show? Without a line nothing is checked here.
//!
//! The tasks are played in every order of events: an operation starts where its `waits` may all be on, and ends some time
//! later. Whatever the description does not fix may be so: inputs without a `[[sensor]]`, stations without an order in the
//! activity, parts in nests; there is a part in a hand whenever it is closed. A sensor is on while an axis passes it. So only what no
//! order of events completes is reported, as an error. Where another input of the same axis completes it, two inputs have been
//! taken for each other.

mod clamps;
mod places;
mod transfers;

use std::collections::BTreeSet;

use linewright_line::{AxisId, Grip, InputId, Line, Operation, Sensor, Sign, Stand, Station, StationId};
use linewright_text::{Problem, Report};

use crate::parse::draft::{DraftActivity, DraftCell, DraftOrder};

/// Positions nearer than this are the same place, as for the motions of a line.
const SAME_PLACE: f64 = 1e-6;
/// States that are looked at for one activity, those with other inputs included; a warning states what is not decided by then. An
/// activity of two stations has some hundred.
const STATES_MAX: usize = 100_000;

/// Applies the rule to each activity.
pub(super) fn activities_can_complete(draft: &DraftCell<'_>, report: &mut Report) {
    let Some(line) = draft.line else { return };
    for activity in &draft.activities {
        let Some(handshake) = Handshake::of(line, activity) else { continue };
        let mut left = STATES_MAX;
        let problems = match handshake.course(None, SwitchEdge::Sharp, &mut left) {
            Course::Stuck(waiting) => handshake.stuck(&activity.name, &waiting, &mut left).into_iter().collect(),
            Course::Completes => {
                let mut problems = handshake.unordered_transfers(&mut left);
                problems.extend(handshake.unordered_clamps(draft, activity, &mut left));
                problems
            }
            Course::Undecided => vec![undecided(activity)],
        };
        problems.into_iter().chain(handshake.misplaced(draft, activity)).for_each(|problem| report.add(problem));
    }
}

/// When a switch goes off that an axis leaves, and on at which it arrives.
#[derive(Clone, Copy)]
enum SwitchEdge {
    /// With the beginning and the end of the motion.
    Sharp,
    /// At any moment of the motion. Another one that begins at the same moment finds it as it was.
    Late,
}

/// The orders of an activity, each with where its station stands from step to step.
struct Handshake<'d, 'a> {
    line: &'d Line,
    players: Vec<Player<'d, 'a>>,
}

struct Player<'d, 'a> {
    order: &'d DraftOrder<'a>,
    id: StationId,
    station: &'d Station,
    operations: Vec<&'d Operation>,
    /// Position of each axis before each operation and during it, in turns, and at the end; none of an axis that moves.
    places: Vec<Vec<Option<f64>>>,
}

/// Progress of each player: an index of its `places`.
type State = Vec<usize>;

/// What becomes of the orders.
enum Course {
    /// Some order of events leads to the end of all.
    Completes,
    /// None does; in this state nothing goes on.
    Stuck(State),
    Undecided,
}

/// An input that an operation waits for, and another one in its stead.
#[derive(Clone, Copy)]
struct Mistaken {
    player: usize,
    operation: usize,
    input: InputId,
    instead: InputId,
}

impl<'d, 'a> Player<'d, 'a> {
    fn of(line: &'d Line, order: &'d DraftOrder<'a>) -> Option<Self> {
        let id = line.station_named(&order.raw.station.as_ref()?.value)?;
        let station = line.station(id);
        let task = station.task(station.task_named(&order.raw.task.as_ref()?.value)?);
        let steps = station.steps.get(task.steps.clone())?;
        let operations: Vec<_> = steps.iter().flatten().map(|op| &station.operations[op.index()]).collect();
        let mut now: Vec<_> = station.rests.get(task.from.index())?.at.iter().copied().map(Some).collect();
        let mut places = vec![now.clone()];
        for operation in &operations {
            for place in [None, Some(operation.motion.to)] {
                now[operation.motion.axis.index()] = place;
                places.push(now.clone());
            }
        }
        Some(Player { order, id, station, operations, places })
    }

    fn has_ended(&self, progress: usize) -> bool {
        progress + 1 == self.places.len()
    }

    /// Whether a switch at a stand of this station may be on.
    fn may_stand(&self, progress: usize, stand: &Stand, edge: SwitchEdge) -> bool {
        if let Some(at) = self.places[progress][stand.axis.index()] {
            return same_place(at, stand.at);
        }
        let motion = self.operations[progress / 2].motion;
        let is_end = same_place(motion.from, stand.at) || same_place(motion.to, stand.at);
        let is_passed = (motion.from - stand.at) * (motion.to - stand.at) < 0.0;
        let turns = self.station.axes[stand.axis.index()].index.is_some();
        match edge {
            SwitchEdge::Sharp => (is_passed && !is_end) || turns,
            SwitchEdge::Late => is_passed || is_end || turns,
        }
    }
}

impl<'d, 'a> Handshake<'d, 'a> {
    /// None where an order is not understood, or a station has two.
    fn of(line: &'d Line, activity: &'d DraftActivity<'a>) -> Option<Self> {
        let players: Vec<_> = activity.orders.iter().map(|order| Player::of(line, order)).collect::<Option<_>>()?;
        let stations: BTreeSet<StationId> = players.iter().map(|player| player.id).collect();
        (stations.len() == players.len()).then_some(Handshake { line, players })
    }

    fn course(&self, instead: Option<Mistaken>, edge: SwitchEdge, left: &mut usize) -> Course {
        let Some(states) = self.states(instead, edge, left) else { return Course::Undecided };
        let has_ended =
            |state: &State| self.players.iter().zip(state).all(|(player, progress)| player.has_ended(*progress));
        if states.iter().any(has_ended) {
            return Course::Completes;
        }
        let stuck = states.into_iter().rfind(|state| self.next(state, instead, edge).is_empty());
        stuck.map_or(Course::Undecided, Course::Stuck)
    }

    /// Plays the orders: every state that is reached. Takes them from those that are left; none where they are too many.
    fn states(&self, instead: Option<Mistaken>, edge: SwitchEdge, left: &mut usize) -> Option<Vec<State>> {
        let first: State = vec![0; self.players.len()];
        let mut known = BTreeSet::from([first.clone()]);
        let (mut open, mut reached) = (vec![first], Vec::new());
        while let Some(state) = open.pop() {
            let before = known.len();
            open.extend(self.next(&state, instead, edge).into_iter().filter(|state| known.insert(state.clone())));
            *left = left.checked_sub(known.len() - before)?;
            reached.push(state);
        }
        Some(reached)
    }

    /// The states after one event: an operation that starts, or ends.
    fn next(&self, state: &State, instead: Option<Mistaken>, edge: SwitchEdge) -> Vec<State> {
        let goes_on = |at: usize| {
            let is_moving = state[at] % 2 == 1;
            !self.players[at].has_ended(state[at]) && (is_moving || self.may_start(state, at, instead, edge))
        };
        let after = |at: usize| {
            let mut state = state.clone();
            state[at] += 1;
            state
        };
        (0..state.len()).filter(|&at| goes_on(at)).map(after).collect()
    }

    /// Whether the next operation of a player may start: what it waits for may be on.
    fn may_start(&self, state: &State, at: usize, instead: Option<Mistaken>, edge: SwitchEdge) -> bool {
        let id = self.players[at].id;
        self.awaited(at, state[at] / 2, instead).all(|input| self.may_be_on(state, id, input, edge))
    }

    /// What an operation waits for, and the result of the one before it, with another input instead of a mistaken one.
    fn awaited(&self, player: usize, operation: usize, instead: Option<Mistaken>) -> impl Iterator<Item = InputId> {
        let change = instead.filter(|change| (change.player, change.operation) == (player, operation));
        let operations = &self.players[player].operations;
        let before = operation.checked_sub(1).and_then(|before| operations[before].result.as_ref());
        let waits = operations[operation].waits.iter().chain(before.map(|result| &result.input));
        waits.map(move |input| change.filter(|change| change.input == *input).map_or(*input, |change| change.instead))
    }

    fn may_be_on(&self, state: &State, station: StationId, input: InputId, edge: SwitchEdge) -> bool {
        let mut sensors = self.sensors(station, input).peekable();
        let is_seen = |sensor: &Sensor| sensor.when.iter().all(|sign| self.may_be_so(state, sign, edge));
        sensors.peek().is_none() || sensors.any(is_seen)
    }

    fn may_be_so(&self, state: &State, sign: &Sign, edge: SwitchEdge) -> bool {
        let Some(stand) = self.stand_of(sign) else { return true };
        let mut players = self.players.iter().zip(state).filter(|(player, _)| player.id == stand.station);
        players.all(|(player, progress)| player.may_stand(*progress, &stand, edge))
    }

    /// Where an axis stands if a sign is so; none of a part in a nest.
    fn stand_of(&self, sign: &Sign) -> Option<Stand> {
        match sign {
            Sign::Stands(stand) => Some(*stand),
            Sign::Part(holder) => match self.line.handling.holder(*holder).grip {
                Grip::Hand(closed) => Some(closed),
                Grip::Loose | Grip::Clamp(_) => None,
            },
        }
    }

    fn sensors(&self, station: StationId, input: InputId) -> impl Iterator<Item = &'d Sensor> + use<'d> {
        let sensors = self.line.handling.sensors.iter();
        sensors.filter(move |sensor| (sensor.station, sensor.input) == (station, input))
    }

    /// The first input with whose opposite the orders complete, in the way in which parts are handed over.
    fn mistaken(&self, left: &mut usize) -> Option<Mistaken> {
        let operations = |at: usize| (0..self.players[at].operations.len()).map(move |nth| (at, nth));
        let mut all = (0..self.players.len()).flat_map(operations).flat_map(|(at, nth)| self.changes(at, nth));
        all.find(|change| matches!(self.course(Some(*change), SwitchEdge::Sharp, left), Course::Completes))
    }

    /// The inputs that an operation waits for, each with each of its opposites.
    fn changes(&self, at: usize, nth: usize) -> Vec<Mistaken> {
        let player = &self.players[at];
        let Some(is_closed) = self.other_is_closed(player, nth) else { return Vec::new() };
        let of = |&input: &InputId| {
            let change = move |instead| Mistaken { player: at, operation: nth, input, instead };
            self.opposites(player.id, input, is_closed).map(change)
        };
        player.operations[nth].waits.iter().flat_map(of).collect()
    }

    /// Whether the other holder is closed when an operation hands a part over: one of them always holds it, and nothing is pulled
    /// out of a closed one, or pushed into it. None where nothing is handed over.
    fn other_is_closed(&self, player: &Player<'_, '_>, operation: usize) -> Option<bool> {
        let moved = (player.id, player.operations[operation].motion.axis);
        let mut own = self.grips().filter(|(_, closed)| closed.station == player.id);
        if own.clone().any(|(_, closed)| axis_of(closed) == moved) {
            return Some(true);
        }
        let during = &player.places[operation * 2 + 1];
        let holds = |closed: &Stand| during[closed.axis.index()].is_some_and(|at| same_place(at, closed.at));
        own.any(|(is_hand, closed)| is_hand && holds(closed)).then_some(false)
    }

    /// Inputs of the station that show a holder of another station closed, or open, and that are on while an axis stands elsewhere
    /// than for this one; those of the same axes first.
    fn opposites(&self, station: StationId, input: InputId, is_closed: bool) -> impl Iterator<Item = InputId> {
        let stands: Vec<Stand> = self.sensors(station, input).flat_map(stands_of).collect();
        let axes: BTreeSet<_> = stands.iter().map(axis_of).collect();
        let differ = |a: &Stand, b: &Stand| axis_of(a) == axis_of(b) && !same_place(a.at, b.at);
        let shows = |sensor: &Sensor| {
            let mut shown = stands_of(sensor).filter_map(|stand| self.is_closed(&stand)).peekable();
            shown.peek().is_some() && shown.all(|closed| closed == is_closed)
        };
        let is_opposite = |sensor: &&Sensor| {
            let others = || stands_of(sensor).filter(|other| other.station != station);
            sensor.station == station
                && others().any(|other| stands.iter().any(|stand| differ(stand, &other)))
                && shows(sensor)
        };
        let mut found: Vec<&Sensor> = self.line.handling.sensors.iter().filter(is_opposite).collect();
        found.sort_by_key(|sensor| stands_of(sensor).map(|stand| axis_of(&stand)).collect::<BTreeSet<_>>() != axes);
        found.into_iter().map(|sensor| sensor.input)
    }

    /// The problem of an activity that no order of events completes.
    fn stuck(&self, activity: &str, waiting: &State, left: &mut usize) -> Option<Problem> {
        let is_never = matches!(self.course(None, SwitchEdge::Late, left), Course::Stuck(_));
        let what =
            if is_never { "never completes" } else { "completes only where two motions begin at the same moment" };
        let what = format!("`{activity}` {what}");
        match self.mistaken(left) {
            Some(mistaken) => self.taken_for_each_other(&what, &mistaken),
            None => self.waiting_for_ever(&what, waiting),
        }
    }

    fn taken_for_each_other(&self, what: &str, mistaken: &Mistaken) -> Option<Problem> {
        let player = &self.players[mistaken.player];
        let (operation, station) = (&player.operations[mistaken.operation].name, &player.station.name);
        let name = |input: InputId| &player.station.inputs[input.index()];
        let message = format!(
            "{what}: `{operation}` of `{station}` waits for `{}`, which is on while {}",
            name(mistaken.input),
            self.shown(player.id, mistaken.input)
        );
        let hint = format!(
            "with `{}`, which is on while {}, its orders complete: look at `waits` of the operation, and at `when` of the two inputs' \
             `[[sensor]]`, in the line's description",
            name(mistaken.instead),
            self.shown(player.id, mistaken.instead)
        );
        let task = player.order.raw.task.as_ref()?;
        Some(Problem::error(task.at.clone(), message).label("waits for the opposite").hint(hint))
    }

    fn waiting_for_ever(&self, what: &str, state: &State) -> Option<Problem> {
        let waiting = |at: usize| {
            let (player, progress) = (&self.players[at], state[at]);
            let operation = player.operations.get(progress / 2)?;
            let mut off = self
                .awaited(at, progress / 2, None)
                .filter(|input| !self.may_be_on(state, player.id, *input, SwitchEdge::Sharp));
            let input = off.next()?;
            let mut signs = self.sensors(player.id, input).flat_map(|sensor| &sensor.when);
            let unlike = signs.find_map(|sign| self.unlike(state, sign)).unwrap_or_default();
            let (station, name, awaited) =
                (&player.station.name, &operation.name, &player.station.inputs[input.index()]);
            let shown = self.shown(player.id, input);
            Some(format!("`{name}` of `{station}` waits for `{awaited}`, which is on while {shown}{unlike}"))
        };
        let all: Vec<String> = (0..state.len()).filter_map(waiting).collect();
        let order = self.players.iter().zip(state).find(|(player, progress)| !player.has_ended(**progress))?.0.order;
        let message = format!("{what}: {}", all.join(", and "));
        let hint = "by what the `[[sensor]]`s show nothing goes on then: look at `waits` of the operations, and at `when` of the \
                    inputs, in the line's description";
        Some(Problem::error(order.raw.task.as_ref()?.at.clone(), message).label("waits for ever").hint(hint))
    }

    /// Where the axis of a sign stands instead, e.g. `: it stands at 60 (closed)`.
    fn unlike(&self, state: &State, sign: &Sign) -> Option<String> {
        let stand = self.stand_of(sign).filter(|_| !self.may_be_so(state, sign, SwitchEdge::Sharp))?;
        let (player, progress) = self.players.iter().zip(state).find(|(player, _)| player.id == stand.station)?;
        let at = player.places[*progress][stand.axis.index()]?;
        let axis = &player.station.axes[stand.axis.index()].name;
        let now = Stand { at, ..stand };
        Some(format!("; `{}.{axis}` stands at {at}{} then", player.station.name, self.grip_text(&now)))
    }

    /// What an input shows, e.g. `m1.clamp` stands at 60 (closed).
    fn shown(&self, station: StationId, input: InputId) -> String {
        let all: Vec<String> = self.sensors(station, input).map(|sensor| self.seen_by(sensor)).collect();
        all.join(", or ")
    }

    fn seen_by(&self, sensor: &Sensor) -> String {
        let sign = |sign: &Sign| match sign {
            Sign::Part(holder) => format!("a part is in `{}`", self.line.handling.holder(*holder).name),
            Sign::Stands(stand) => {
                let station = self.line.station(stand.station);
                let axis = &station.axes[stand.axis.index()].name;
                format!("`{}.{axis}` stands at {}{}", station.name, stand.at, self.grip_text(stand))
            }
        };
        sensor.when.iter().map(sign).collect::<Vec<_>>().join(" and ")
    }

    /// Whether a hand or a clamp is closed by its axis there.
    fn grip_text(&self, stand: &Stand) -> &'static str {
        match self.is_closed(stand) {
            Some(true) => " (closed)",
            Some(false) => " (open)",
            None => "",
        }
    }

    /// Whether the hand or clamp of this axis is closed there; none of another axis.
    fn is_closed(&self, stand: &Stand) -> Option<bool> {
        let (_, closed) = self.grips().find(|(_, closed)| axis_of(closed) == axis_of(stand))?;
        Some(same_place(closed.at, stand.at))
    }

    /// Hands and clamps: whether it is a hand, and where it is closed.
    fn grips(&self) -> impl Iterator<Item = (bool, &'d Stand)> + Clone + use<'d> {
        self.line.handling.holders.iter().filter_map(|holder| match &holder.grip {
            Grip::Hand(closed) | Grip::Clamp(closed) => Some((holder.is_hand(), closed)),
            Grip::Loose => None,
        })
    }
}

fn undecided(activity: &DraftActivity<'_>) -> Problem {
    let message = format!(
        "whether the orders of `{}` can complete is not decided: they have more than {STATES_MAX} states",
        activity.name
    );
    let hint = "fewer stations in one activity, or tasks with fewer operations, can be decided";
    Problem::warning(activity.at.clone(), message).label("not decided").hint(hint)
}

fn same_place(a: f64, b: f64) -> bool {
    (a - b).abs() < SAME_PLACE
}

fn stands_of(sensor: &Sensor) -> impl Iterator<Item = Stand> + '_ {
    sensor.when.iter().filter_map(|sign| match sign {
        Sign::Stands(stand) => Some(*stand),
        Sign::Part(_) => None,
    })
}

fn axis_of(stand: &Stand) -> (StationId, AxisId) {
    (stand.station, stand.axis)
}
