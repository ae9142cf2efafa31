//! The transport system and the distributing station of FASTorium (seed 003 §4), as far as its text preserves them.
//!
//! The drawings of the nets are lost. What is rebuilt and not read is marked as such at the place.

use std::collections::BTreeSet;

use linewright_nets::tnces::{
    ArcClock, ComponentId, Composite, Interval, Latest, Policy, Semantics, Tnces, TncesModule, TncesPlayer, parts,
};
use linewright_nets::{Net, NetBuilder, PlaceId, StateId, TransitionId, explore};

// The transport system.

/// L834: "one pallet in the operation positions 1, 5 and 6; two pallets in the queue positions 1 and 6; one pallet in
/// the queue position 5".
const OPERATIONS: [u32; 6] = [1, 0, 0, 0, 1, 1];
const QUEUES: [u32; 6] = [2, 0, 0, 0, 1, 2];

/// p1 to p24 of L834: operation and queue in turn, then what is free of each. The order of p13 to p24 is not given.
fn transport_places() -> Vec<(String, u32)> {
    let capacity = |i: usize| if i.is_multiple_of(2) { 1 } else { 2 };
    let pallets = |i: usize| if i.is_multiple_of(2) { OPERATIONS[i / 2] } else { QUEUES[i / 2] };
    let busy = (0..12).map(|i| (format!("p{}", i + 1), pallets(i)));
    busy.chain((0..12).map(|i| (format!("p{}", i + 13), capacity(i) - pallets(i)))).collect()
}

/// From, to and time of the transitions: queue k to operation k in 1 s, operation k to queue k+1 in 2 s (L836), around
/// the closed rectangle (L622). Positions are numbered as the places, from 0.
fn moves() -> Vec<(usize, usize, u32)> {
    (0..6).flat_map(|k| [(2 * k + 1, 2 * k, 1), (2 * k, (2 * k + 3) % 12, 2)]).collect()
}

fn transport() -> Net {
    let mut b = NetBuilder::new("transport");
    let p: Vec<_> = transport_places().into_iter().map(|(name, n)| b.place(name, n)).collect();
    for (from, to, _) in moves() {
        let t = b.transition(format!("p{} to p{}", from + 1, to + 1));
        b.input(t, p[from], 1).input(t, p[12 + to], 1).output(t, p[to], 1).output(t, p[12 + from], 1);
    }
    b.build().unwrap()
}

/// The same as a module: a condition input `free k` per operation position, and the times.
fn transport_module() -> TncesModule {
    let mut m = TncesModule::new("transport");
    let p: Vec<_> = transport_places().into_iter().map(|(name, n)| m.place(name, n)).collect();
    for (from, to, seconds) in moves() {
        let t = m.transition(format!("p{} to p{}", from + 1, to + 1));
        m.input(t, p[from], 1, Interval::exactly(seconds)).input(t, p[12 + to], 1, Interval::ANY);
        m.output(t, p[to], 1).output(t, p[12 + from], 1);
        if from % 2 == 0 {
            let free = m.condition_in(format!("free {}", from / 2 + 1));
            m.only_if(free, t);
        }
    }
    m
}

/// A stopper that does not move.
fn fixed(name: String, retracted: bool) -> TncesModule {
    let mut m = TncesModule::new(name);
    let [odd, even] = [("retracted", retracted), ("advanced", !retracted)].map(|(name, n)| m.place(name, u32::from(n)));
    m.condition_out("retracted", odd).condition_out("advanced", even);
    m
}

/// With stoppers: rebuilt so that the stopper of an operation position holds what would leave it (L834 has the places of
/// stoppers, not their arcs). `switched` is moved by the environment, `advanced` stands in the way for good.
fn transport_with_stoppers(switched: Option<usize>, advanced: Option<usize>) -> Tnces {
    let mut line = Composite::new("transport system");
    let transport = line.add(transport_module());
    for k in 1..=6 {
        let name = format!("stopper {k}");
        let (part, port) = if switched == Some(k) {
            (line.add(parts::switch(name, true)), "on")
        } else {
            (line.add(fixed(name, advanced != Some(k))), "retracted")
        };
        line.condition((part, port), (transport, format!("free {k}").as_str()));
    }
    line.flatten(Semantics::default()).unwrap()
}

/// All ways to put eight pallets on six places for one and six for two: one array, one loop.
fn placements() -> BTreeSet<[u32; 12]> {
    fn fill(at: usize, left: u32, line: &mut [u32; 12], found: &mut BTreeSet<[u32; 12]>) {
        if at == 12 {
            if left == 0 {
                found.insert(*line);
            }
            return;
        }
        let capacity = if at.is_multiple_of(2) { 1 } else { 2 };
        for n in 0..=capacity.min(left) {
            line[at] = n;
            fill(at + 1, left - n, line, found);
        }
        line[at] = 0;
    }
    let mut found = BTreeSet::new();
    fill(0, 8, &mut [0; 12], &mut found);
    found
}

/// Pallets that can move: there is a pallet, and room where it goes.
fn can_move(line: &[u32; 12]) -> usize {
    let capacity = |i: usize| if i.is_multiple_of(2) { 1 } else { 2 };
    moves().iter().filter(|&&(from, to, _)| line[from] > 0 && line[to] < capacity(to)).count()
}

/// The coefficient of x⁸ in (1 + x)⁶ (1 + x + x²)⁶.
fn coefficient() -> usize {
    let times = |a: &[usize], b: &[usize]| {
        let mut product = vec![0; a.len() + b.len() - 1];
        a.iter().enumerate().for_each(|(i, x)| b.iter().enumerate().for_each(|(j, y)| product[i + j] += x * y));
        product
    };
    (0..6).fold(vec![1], |product, _| times(&times(&product, &[1, 1]), &[1, 1, 1]))[8]
}

#[test]
fn the_transport_system_has_every_placement_and_never_stops() {
    let net = transport();
    assert_eq!(net.initial_marking().as_slice()[..12].iter().sum::<u32>(), 8, "eight pallets (L622)");
    let reach = explore(&net, 100_000).unwrap();
    let found: BTreeSet<[u32; 12]> = reach.states().iter().map(|m| m.as_slice()[..12].try_into().unwrap()).collect();
    let expected = placements();
    assert_eq!(reach.states().len(), coefficient());
    assert_eq!(found, expected);
    assert_eq!(reach.steps().len(), expected.iter().map(can_move).sum::<usize>());
    assert!(reach.is_live());
    assert_eq!(reach.is_reversible(), Ok(()));
    assert_eq!((reach.deadlocks().count(), reach.bound()), (0, 2));
    assert!(reach.states().iter().all(|m| (0..12).all(|i| m.as_slice()[i] + m.as_slice()[i + 12] <= 2)));
    println!("transport: {} markings, {} arcs", reach.states().len(), reach.steps().len());
}

#[test]
fn stoppers_that_are_all_retracted_change_nothing() {
    let system = transport_with_stoppers(None, None);
    let graph = system.untimed_space(100_000).unwrap();
    assert_eq!(graph.states().len(), coefficient());
    assert_eq!(graph.arcs().len(), placements().iter().map(can_move).sum::<usize>());
    assert_eq!(graph.deadlocks().count(), 0);
    assert_eq!(graph.shape().loops.len(), 1);
    assert!(graph.shape().transient.is_empty(), "reversible");
}

#[test]
fn a_stopper_that_moves_doubles_the_states_and_one_that_stays_advanced_jams_the_line() {
    let graph = transport_with_stoppers(Some(3), None).untimed_space(100_000).unwrap();
    assert_eq!(graph.states().len(), 2 * coefficient());
    // The stopper itself can always move; what leaves operation 3 moves only while it is retracted.
    let held = |line: &&[u32; 12]| line[4] > 0 && line[7] < 2;
    let all: usize = placements().iter().map(can_move).sum();
    let blocked = placements().iter().filter(held).count();
    assert_eq!(graph.arcs().len(), 2 * coefficient() + 2 * all - blocked);
    assert_eq!((graph.deadlocks().count(), graph.shape().transient.len()), (0, 0));

    let jammed = transport_with_stoppers(None, Some(3)).untimed_space(100_000).unwrap();
    let stuck: Vec<_> = jammed.deadlocks().collect();
    // Operation and queue 3 and 2 are full with three pallets each; the last two stand at operation and queue 1.
    assert_eq!(stuck.len(), 1);
    assert_eq!(jammed.state(stuck[0]).as_slice()[..12], [1, 1, 1, 2, 1, 2, 0, 0, 0, 0, 0, 0]);
}

/// The times of L836, in seconds. With everything released the line never stands still, and in every reading of the
/// clock what happens is an untimed run.
#[test]
fn the_transport_system_in_time() {
    let untimed: BTreeSet<_> = explore(&transport(), 100_000).unwrap().states().iter().cloned().collect();
    for clock in [ArcClock::TokenAge, ArcClock::SinceMarked, ArcClock::SinceEnabled] {
        let system = transport_with_stoppers(None, None).with_semantics(Semantics { clock, ..Semantics::default() });
        let graph = system.timed_space(200_000).unwrap();
        println!("transport in time, {clock:?}: {} states, {} arcs", graph.states().len(), graph.arcs().len());
        assert_eq!((graph.deadlocks().count(), graph.standstill()), (0, None));
        let marking =
            |m: &linewright_nets::Marking| linewright_nets::Marking::from_tokens(m.as_slice()[..24].iter().copied());
        assert!(graph.states().iter().all(|state| untimed.contains(&marking(state.marking()))));
        // Operation 1 and queue 1 are full, queue 2 is empty: the pallet of operation 1 is there after 2 s sharp.
        let span = graph.span(StateId::INITIAL, |state| state.marking().tokens(PlaceId(3)) > 0).unwrap();
        assert_eq!((span.earliest, span.latest), (2, Latest::After(2)));
    }
}

// The distributing station, its controller and its plant in a closed loop.

/// Signals from the plant (L651-660), as far as the controller waits for them.
const SENSORS: [(&str, bool); 6] = [
    ("START", false),
    ("Mat_sen", true),
    ("Arm_put", false),
    ("Mag_front", false),
    ("Arm_take", false),
    ("Vacuum", false),
];

/// Signals to the plant (L661-665).
const SOLENOIDS: [&str; 5] = ["Mag", "Vacumon", "Vacumoff", "Armleft", "Armright"];

/// A transition of the sequence: from, to, the signal waited for, what is set and what is reset.
type Row = (&'static str, &'static str, &'static str, &'static [&'static str], &'static [&'static str]);

/// The sequence of L713. Two entries are rebuilt: the
/// last one waits for Arm_put and sets Vacumoff (the text: "reset_Vacumon and set_Vacumon", "where the vacuum will
/// later be deactivated"); it leads back to where a work piece is pushed (L698, "from step 2").
const SEQUENCE: [Row; 7] = [
    ("S0", "S1", "START", &[], &[]),
    ("S1", "S2", "not_Mat_sen", &["Armright"], &[]),
    ("S2", "S3", "Arm_put", &["Mag"], &["Armright"]),
    ("S3", "S4", "Mag_front", &["Armleft"], &["Mag"]),
    ("S4", "S5", "Arm_take", &["Vacumon"], &["Armleft", "Vacumoff"]),
    ("S5", "S6", "Vacuum", &["Armright"], &[]),
    ("S6", "S2", "Arm_put", &["Vacumoff"], &["Vacumon"]),
];

/// The sequence as a module; `third` is what its third transition waits for.
fn sequence(third: &str) -> TncesModule {
    let mut m = TncesModule::new("sequence");
    let places: Vec<PlaceId> = (0..7).map(|i| m.place(format!("S{i}"), u32::from(i == 0))).collect();
    let at = |name: &str| places[name[1..].parse::<usize>().unwrap()];
    let mut sets: Vec<(String, Vec<TransitionId>)> = Vec::new();
    let mut waits: Vec<(String, Vec<TransitionId>)> = Vec::new();
    let push = |all: &mut Vec<(String, Vec<TransitionId>)>, key: String, t| match all.iter_mut().find(|e| e.0 == key) {
        Some((_, ts)) => ts.push(t),
        None => all.push((key, vec![t])),
    };
    for (i, (from, to, signal, set, reset)) in SEQUENCE.into_iter().enumerate() {
        let t = m.change(format!("{}", i + 1), at(from), at(to), Interval::ANY);
        push(&mut waits, if i == 2 { third } else { signal }.to_owned(), t);
        set.iter().for_each(|s| push(&mut sets, format!("set_{s}"), t));
        reset.iter().for_each(|s| push(&mut sets, format!("reset_{s}"), t));
    }
    for (signal, ts) in waits {
        let port = m.condition_in(signal);
        ts.into_iter().for_each(|t| _ = m.only_if(port, t));
    }
    sets.into_iter().for_each(|(name, ts)| _ = m.event_out(name, ts));
    m
}

/// Sequence, input modules and output modules (L442, L531).
fn controller(third: &str) -> Composite {
    let mut c = Composite::new("controller");
    c.event_in("update").event_out("changed");
    let sequence = c.add(sequence(third));
    for (name, on) in SENSORS {
        let input = c.add(parts::input(name, on));
        connect_input(&mut c, input, name);
        let (port, driven) = if name == "Mat_sen" { ("off", "not_Mat_sen") } else { ("on", name) };
        let used = SEQUENCE.iter().enumerate().any(|(i, row)| driven == if i == 2 { third } else { row.2 });
        if used {
            c.condition((input, port), (sequence, driven));
        }
    }
    for name in SOLENOIDS {
        let output = c.add(parts::output(name, false));
        for way in ["set", "reset"] {
            c.event((sequence, format!("{way}_{name}").as_str()), (output, way));
        }
        connect_output(&mut c, output, name);
    }
    c
}

/// An input module reads `name` and `not_name` of the composite when this is updated.
fn connect_input(c: &mut Composite, input: ComponentId, name: &str) {
    let not = format!("not_{name}");
    c.condition_in(name).condition_in(not.as_str());
    c.condition(name, (input, "x")).condition(not.as_str(), (input, "not_x")).event("update", (input, "update"));
}

/// An output module shows `name` and `not_name`, and its changes are those of the composite.
fn connect_output(c: &mut Composite, output: ComponentId, name: &str) {
    let not = format!("not_{name}");
    c.condition_out(name).condition_out(not.as_str());
    c.condition((output, "on"), name).condition((output, "off"), not.as_str()).event((output, "changed"), "changed");
}

/// A transition of a plant module: name, from, to, milliseconds, input that moves it, outputs it sets and resets.
type Motion = (&'static str, usize, usize, u32, Option<&'static str>, &'static [&'static str]);

/// A plant module from its places and motions. The transitions and arcs of the plants are lost with their drawings:
/// here each motion takes its time from where it starts, while the input that drives it is on, and its end sets and
/// resets the sensors.
fn plant_module(name: &str, places: &[(&str, u32)], motions: &[Motion]) -> TncesModule {
    let mut m = TncesModule::new(name);
    let p: Vec<_> = places.iter().map(|&(name, n)| m.place(name, n)).collect();
    for &(name, from, to, time, driver, events) in motions {
        let t = m.change(name, p[from], p[to], Interval::exactly(time));
        if let Some(driver) = driver {
            let port = m.condition_in(format!("{name} by {driver}"));
            m.only_if(port, t);
        }
        events.iter().for_each(|event| _ = m.event_out(format!("{name}: {event}"), [t]));
    }
    m
}

/// L729 and L731: 900 ms for the magazine, 2 s for the arm from side to side, 100 ms for the vacuum. From the middle,
/// where the arm is before the first cycle, 1 s is assumed. The feeder and the operator's button are rebuilt: a piece
/// comes after 0.5 s, START after 1 s.
fn plant_modules() -> [(TncesModule, &'static [Motion]); 5] {
    const MAGAZINE: &[Motion] = &[
        ("extend", 0, 1, 900, Some("Mag"), &["set_Mag_front"]),
        ("retract", 1, 0, 900, Some("not_Mag"), &["reset_Mag_front"]),
    ];
    const ARM: &[Motion] = &[
        ("take to put", 0, 1, 2_000, Some("Armright"), &["set_Arm_put", "reset_Arm_take"]),
        ("put to take", 1, 0, 2_000, Some("Armleft"), &["set_Arm_take", "reset_Arm_put"]),
        ("middle to put", 2, 1, 1_000, Some("Armright"), &["set_Arm_put"]),
        ("middle to take", 2, 0, 1_000, Some("Armleft"), &["set_Arm_take"]),
    ];
    const SUCTION: &[Motion] =
        &[("on", 0, 1, 100, Some("Vacumon"), &["set_Vacuum"]), ("off", 1, 0, 100, Some("Vacumoff"), &["reset_Vacuum"])];
    const FEEDER: &[Motion] =
        &[("fill", 0, 1, 500, None, &["reset_Mat_sen"]), ("empty", 1, 0, 0, Some("never"), &["set_Mat_sen"])];
    const BUTTON: &[Motion] =
        &[("press", 0, 1, 1_000, None, &["set_START"]), ("release", 1, 0, 0, Some("never"), &["reset_START"])];
    [
        (plant_module("magazine", &[("p1", 1), ("p2", 0)], MAGAZINE), MAGAZINE),
        (plant_module("charger", &[("p1", 0), ("p2", 0), ("p3", 1)], ARM), ARM),
        (plant_module("suction", &[("p4", 1), ("p5", 0)], SUCTION), SUCTION),
        (plant_module("feeder", &[("empty", 1), ("filled", 0)], FEEDER), FEEDER),
        (plant_module("button", &[("free", 1), ("pressed", 0)], BUTTON), BUTTON),
    ]
}

fn plant() -> Composite {
    let mut c = Composite::new("plant");
    c.event_in("update").event_out("changed");
    let never = c.add(fixed("never".to_owned(), true));
    let inputs = SOLENOIDS.map(|name| {
        let input = c.add(parts::input(name, false));
        connect_input(&mut c, input, name);
        (name, input)
    });
    let outputs = SENSORS.map(|(name, on)| {
        let output = c.add(parts::output(name, on));
        connect_output(&mut c, output, name);
        (name, output)
    });
    for (module, motions) in plant_modules() {
        let part = c.add(module);
        for &(name, _, _, _, driver, events) in motions {
            let port = driver.map(|driver| (part, format!("{name} by {driver}"), driver));
            if let Some((part, port, driver)) = port {
                let signal = driver.strip_prefix("not_").unwrap_or(driver);
                let from = inputs
                    .iter()
                    .find(|(name, _)| *name == signal)
                    .map_or((never, "advanced"), |&(_, input)| (input, if signal == driver { "on" } else { "off" }));
                c.condition(from, (part, port.as_str()));
            }
            for event in events {
                let (way, sensor) = event.split_once('_').unwrap();
                let output = outputs.iter().find(|(name, _)| *name == sensor).unwrap().1;
                c.event((part, format!("{name}: {event}").as_str()), (output, way));
            }
        }
    }
    c
}

/// Controller and plant, with an update module each way (L533: "executed twice in the sequence of the closed-loop").
fn distributing(third: &str) -> Tnces {
    let mut line = Composite::new("distributing");
    let (controller, plant) = (line.add(controller(third)), line.add(plant()));
    let signals = |from: ComponentId, to: ComponentId, name: &str, line: &mut Composite| {
        for port in [name.to_owned(), format!("not_{name}")] {
            line.condition((from, port.as_str()), (to, port.as_str()));
        }
    };
    SOLENOIDS.into_iter().for_each(|name| signals(controller, plant, name, &mut line));
    SENSORS.into_iter().for_each(|(name, _)| signals(plant, controller, name, &mut line));
    for (name, from, to) in [("down", controller, plant), ("up", plant, controller)] {
        let update = line.add(parts::update(name, 100));
        line.event((from, "changed"), (update, "event")).event((update, "changed"), (to, "update"));
    }
    line.flatten(Semantics::default()).unwrap()
}

/// L872: no deadlock; L877, L884: some states of start-up, then one closed loop. The source's figure has 50 states; its
/// nets are lost and its notion of a state with time is not given, so the number is no test.
#[test]
fn the_distributing_station_starts_up_and_then_repeats_one_cycle() {
    let system = distributing("Arm_put");
    let graph = system.timed_space(10_000).unwrap();
    assert_eq!((graph.deadlocks().count(), graph.standstill()), (0, None));
    let shape = graph.shape();
    assert!(!shape.transient.is_empty());
    assert_eq!(shape.loops.len(), 1);
    let cycle = &shape.loops[0];
    assert!(cycle.is_final);
    assert_eq!(graph.cycles_through(cycle.states[0]), Some(1));
    println!("distributing: {} states, {} of start-up", graph.states().len(), shape.transient.len());
    // Four times a signal goes down and an answer comes up, 100 ms each way; between, the magazine, the arm, the vacuum
    // and the arm move.
    assert_eq!(cycle.period, Some(4 * 200 + 900 + 2_000 + 100 + 2_000));
    // All its transitions of the sequence but the two of start-up fire in the cycle, once each.
    let mut fired: Vec<&str> = Vec::new();
    for &state in &cycle.states {
        let arc = graph.arcs_from(state)[0];
        let names = graph.fired(&arc).iter().map(|&t| system.net().transition_name(t));
        fired.extend(names.filter_map(|name| name.strip_prefix("controller.sequence.")));
    }
    fired.sort_unstable();
    assert_eq!(fired, ["3", "4", "5", "6", "7"]);
    // The loop is entered by the third transition: a piece is there and the charger at the next station (L884).
    let s3 = system.net().place_named("controller.sequence.S3").unwrap();
    let first = graph.span(StateId::INITIAL, |state| state.marking().tokens(s3) > 0).unwrap();
    // START after 1 s, 100 ms up, 100 ms down, 1 s from the middle, 100 ms up.
    assert_eq!((first.earliest, first.latest), (2_300, Latest::After(2_300)));
}

#[test]
fn a_player_goes_round_as_the_state_space_says() {
    let system = distributing("Arm_put");
    let push = system.net().transition_named("controller.sequence.3").unwrap();
    let mut player = TncesPlayer::new(&system, Policy::Soonest);
    let fired = player.advance(2_300 + 3 * 5_800, 10_000).unwrap();
    let pushes: Vec<u64> = fired.iter().filter(|f| f.step[0] == push).map(|f| f.time).collect();
    assert_eq!(pushes, [2_300, 8_100, 13_900, 19_700]);
}

/// Without deadlock and in one loop in the other readings of the clock too; the times are others, because a mechanism
/// that has rested long enough moves at once.
#[test]
fn the_shape_is_the_same_however_the_clock_is_read() {
    for clock in [ArcClock::TokenAge, ArcClock::SinceMarked] {
        let system = distributing("Arm_put").with_semantics(Semantics { clock, ..Semantics::default() });
        let graph = system.timed_space(50_000).unwrap();
        let shape = graph.shape();
        assert_eq!((graph.deadlocks().count(), shape.loops.len()), (0, 1));
        assert!(shape.loops[0].is_final && !shape.transient.is_empty());
        let push = system.net().transition_named("controller.sequence.3").unwrap();
        let fired = TncesPlayer::new(&system, Policy::Soonest).advance(60_000, 10_000).unwrap();
        let pushes: Vec<u64> = fired.iter().filter(|f| f.step[0] == push).map(|f| f.time).collect();
        let rounds: BTreeSet<u64> = pushes.windows(2).skip(1).map(|two| two[1] - two[0]).collect();
        println!("distributing, {clock:?}: {} states, a round takes {rounds:?}", graph.states().len());
        assert!(rounds.len() == 1 && rounds.first() < Some(&5_800));
    }
}

/// Use of the state space: a controller that waits for the wrong end of the arm stops.
#[test]
fn a_controller_that_waits_for_the_wrong_signal_is_found_to_stop() {
    let system = distributing("Arm_take");
    let graph = system.timed_space(10_000).unwrap();
    let stuck: Vec<_> = graph.deadlocks().collect();
    assert_eq!(stuck.len(), 1);
    let marked = system.net().describe(graph.state(stuck[0]).marking());
    assert!(marked.contains("controller.sequence.S2") && marked.contains("plant.charger.p2"), "{marked}");
    assert!(graph.shape().loops.is_empty());
}
