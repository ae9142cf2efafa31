//! Cells that are queues of the textbook: the figures of a study agree with theory, within its own intervals.

use linewright_coordinator_cell::production::ORDERS_MAX;
use linewright_simulation::cell::{
    CellScenario, CellStudy, Estimate, ReplicationFigures, ReplicationGoal, StudyOptions,
};

/// A machine behind a large store: parts come in, wait, are worked on for ten seconds, and leave.
///
/// ```text
///   in ──▶ Q ──▶ M ──▶ out
/// ```
const QUEUE: &str = r#"
name = "queue"
[cell]
wip_max = 1000
[[resource]]
name = "Q"
prototype = "random-access-store"
capacity = 1000
[[resource]]
name = "M"
prototype = "machine"
station = "m"
[[sync]]
name = "enter"
actions = ["outside.in", "Q.store"]
[[sync]]
name = "load"
actions = ["Q.retrieve", "M.load"]
[[sync]]
name = "leave"
actions = ["M.unload", "outside.out"]
[[action]]
of = "M.process"
orders = [{ station = "m", task = "work" }]
[[part]]
name = "A"
step = [{ name = "work", on = [{ resource = "M", time_s = 10 }] }]
"#;

const OPTIONS: StudyOptions = StudyOptions {
    seed: 1,
    delay: (std::time::Duration::ZERO, std::time::Duration::ZERO),
    spread: 0.0,
    planned: false,
};

fn study(scenario: &str) -> CellStudy {
    study_of(QUEUE, scenario)
}

/// The same with a store for four parts: where there is always work, what waits outside need not stand inside.
fn saturated(scenario: &str) -> CellStudy {
    study_of(&QUEUE.replace("= 1000", "= 4"), scenario)
}

fn study_of(cell: &str, scenario: &str) -> CellStudy {
    let cell = linewright_cell::parse("cell.toml", cell, None).unwrap_or_else(|why| panic!("{why:#}")).cell;
    let scenario = CellScenario::parse(&cell, "s.toml", scenario).unwrap_or_else(|why| panic!("{why:#}"));
    CellStudy::new(&cell, None, scenario, OPTIONS).expect("it can be played")
}

fn figures(scenario: &str, replications: usize) -> Vec<ReplicationFigures> {
    figures_of(&study(scenario), replications)
}

fn figures_of(study: &CellStudy, replications: usize) -> Vec<ReplicationFigures> {
    let goal = ReplicationGoal { replications, precision: None, most: replications };
    let figures = study.replicate(&goal, 2);
    assert!(figures.len() == replications && figures.iter().all(|of| of.problem.is_none()), "{:?}", figures[0].problem);
    figures
}

fn estimate(figures: &[ReplicationFigures], of: impl Fn(&ReplicationFigures) -> f64 + Clone) -> Estimate {
    Estimate::of(figures.iter().map(of), 0.99).expect("there are values")
}

/// An interval that holds the known value, and is narrow enough.
fn agrees(found: Estimate, known: f64, within: f64) {
    assert!(found.has(known), "{found:?}, by theory {known}");
    assert!(found.half_width.is_some_and(|half| half < known * within), "{found:?}, by theory {known}");
}

const POISSON: &str = r#"
duration_s = 100000
warm_up_s = 5000
[[arrivals]]
part = "A"
every_s = { distribution = "exponential", mean = 20 }
"#;

/// ρ = 1/2, service 10 s: the mean waiting time of M/M/1 is ρ/(1 − ρ) of a service, of M/D/1 half of that (Pollaczek and
/// Khinchine); by Little as many are inside as arrive in a time in the system.
#[test]
#[ignore = "long: `cargo xtask test --long`"]
fn waiting_times_of_m_m_1_and_m_d_1_are_those_of_theory() {
    let exponential = "[[time]]\nof = [\"M.process\"]\nfactor = { distribution = \"exponential\", mean = 1 }\n";
    let m_m_1 = figures(&format!("{POISSON}{exponential}"), 8);
    let m_d_1 = figures(POISSON, 8);
    let waited = |of: &ReplicationFigures| of.waited.expect("parts have left");
    agrees(estimate(&m_m_1, waited), 10.0, 0.15);
    agrees(estimate(&m_d_1, waited), 5.0, 0.1);
    agrees(estimate(&m_m_1, |of| of.in_cell.expect("parts have left")), 20.0, 0.15);
    agrees(estimate(&m_m_1, |of| of.inside), 1.0, 0.15);
    for all in [&m_m_1, &m_d_1] {
        agrees(estimate(all, |of| of.throughput), 180.0, 0.05);
        agrees(estimate(all, |of| of.resources[1].worked), 0.5, 0.05);
    }
    // The same orders come in both: common random numbers.
    let orders = |of: &[ReplicationFigures]| of[0].each.iter().map(|order| order.released).collect::<Vec<_>>();
    assert_eq!(orders(&m_m_1)[..4000], orders(&m_d_1)[..4000]);
}

/// Of 1000 s between failures and 250 s for a repair 80 % remain, whatever the distributions, as long as the calendar counts;
/// a machine that is never without work makes as many parts as that leaves time for.
#[test]
fn a_machine_is_available_for_mtbf_of_mtbf_and_mttr() {
    let scenario = r#"
        duration_s = 200000
        [[order]]
        part = "A"
        quantity = 100000
        [[breakdown]]
        resource = "M"
        between_failures_s = { distribution = "exponential", mean = 1000 }
        repair_s = { distribution = "lognormal", mean = 250, deviation = 100 }
    "#;
    let all = figures_of(&saturated(scenario), 8);
    agrees(estimate(&all, |of| of.resources[1].down), 0.2, 0.1);
    agrees(estimate(&all, |of| of.resources[1].worked), 0.8, 0.03);
    agrees(estimate(&all, |of| of.throughput), 0.8 * 360.0, 0.03);
    assert!(
        all.iter().all(|of| (of.resources[1].worked + of.resources[1].down - 1.0).abs() < 1e-9),
        "always one of both"
    );
}

/// Half idle, it fails half as often by its own work as by the calendar.
#[test]
#[ignore = "long: `cargo xtask test --long`"]
fn breakdowns_by_operating_time_are_fewer_with_less_work() {
    let scenario = |clock: &str| {
        format!(
            "duration_s = 80000\n[[arrivals]]\npart = \"A\"\nevery_s = 20\n[[breakdown]]\nresource = \"M\"\nclock = \
             \"{clock}\"\nbetween_failures_s = {{ distribution = \"weibull\", shape = 10, scale = 500 }}\nrepair_s = 10\n"
        )
    };
    // Γ(1.1) × 500 s.
    let mtbf = 475.675;
    let by_calendar = estimate(&figures(&scenario("calendar"), 5), |of| of.resources[1].down);
    let by_work = estimate(&figures(&scenario("operating"), 5), |of| of.resources[1].down);
    agrees(by_calendar, 10.0 / (mtbf + 10.0), 0.1);
    agrees(by_work, 10.0 / (2.0 * mtbf), 0.1);
}

#[test]
fn what_comes_out_does_not_depend_on_the_number_of_threads() {
    let scenario = format!("{POISSON}[[breakdown]]\nresource = \"M\"\nbetween_failures_s = 1000\nrepair_s = 30\n")
        .replace("duration_s = 100000", "duration_s = 9000");
    let with = |threads, precision| {
        study(&scenario).replicate(&ReplicationGoal { replications: 4, precision, most: 40 }, threads)
    };
    assert_eq!(with(1, None), with(3, None));
    let precise = with(1, Some(0.1));
    assert!((5..40).contains(&precise.len()), "{}", precise.len());
    assert_eq!(precise, with(4, Some(0.1)));
    // Each differs from the others.
    assert!(precise.windows(2).all(|two| two[0].in_cell != two[1].in_cell));
}

#[test]
fn a_breakdown_more_changes_no_other_stream() {
    let base = POISSON.replace("duration_s = 100000", "duration_s = 9000");
    let with = format!("{base}[[breakdown]]\nresource = \"M\"\nbetween_failures_s = 2000\nrepair_s = 200\n");
    let released = |scenario: &str| {
        figures(scenario, 1)[0].each.iter().map(|order| (order.name.clone(), order.released)).collect::<Vec<_>>()
    };
    assert_eq!(released(&base), released(&with));
}

/// ```text
///   0 s            25 s                 65 s          115 s
///   ├── part 1, 2 ──┤ M breaks           ├ M works ──────┤ ...
/// ```
#[test]
fn what_stands_goes_on_where_it_stood_and_its_order_is_late() {
    let scenario = r#"
        [[order]]
        name = "four"
        part = "A"
        quantity = 4
        due_s = 50
        [[order]]
        name = "later"
        part = "A"
        release_s = 200
        due_s = 210
        after = ["four"]
        [[step]]
        at_s = 25
        break = "M"
        [[step]]
        after_s = 40
        clear = "M"
    "#;
    for word in ["break", "stick"] {
        let all = figures(&scenario.replace("break", word), 1);
        let [four, later] = &all[0].each[..] else { panic!("{all:?}") };
        let done = |order: &linewright_simulation::cell::OrderFigures| order.done.map(|at| at.as_micros() / 1_000_000);
        assert_eq!((done(four), done(later)), (Some(80), Some(210)), "{word}");
        let of = &all[0];
        assert_eq!((of.in_time, of.tardiness, of.tardiness_sum), (Some(0.5), Some(15.0), Some(30.0)));
        assert!(
            (of.resources[1].down - 40.0 / 210.0).abs() < 1e-9 && (of.resources[1].worked - 50.0 / 210.0).abs() < 1e-9
        );
        assert_eq!(of.lead, Some((80.0 + 10.0) / 2.0));
    }
}

#[test]
fn what_never_ends_is_a_problem_with_its_reason() {
    let problem = |scenario: &str| {
        let goal = ReplicationGoal { replications: 1, precision: None, most: 1 };
        let figures = saturated(scenario).replicate(&goal, 1);
        figures.last().and_then(|of| of.problem.clone()).map(|problem| problem.to_string()).unwrap_or_default()
    };
    let broken = "[[order]]\npart = \"A\"\n[[step]]\nat_s = 5\nbreak = \"M\"\n";
    assert!(problem(broken).contains("0 parts finished, 1 are inside; no further event"), "{}", problem(broken));
    let with_others = format!("{broken}[[breakdown]]\nresource = \"M\"\nbetween_failures_s = 1000\nrepair_s = 100\n");
    assert!(problem(&with_others).contains("no further event"), "{}", problem(&with_others));
    // Nearly as many from the beginning as may be open: to take one in is the slower the more there are.
    let open = "[[order]]\npart = \"A\"\n".repeat(ORDERS_MAX - 10);
    let flood = problem(&format!("duration_s = 1e6\n{open}[[arrivals]]\npart = \"A\"\nevery_s = 1\n"));
    assert!(flood.contains("orders come faster than the cell makes them"), "{flood}");
}
