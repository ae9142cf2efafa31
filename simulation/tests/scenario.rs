//! Scenarios as text: what they may contain, and the messages for mistakes.

use std::time::Duration;

use linewright_simulation::{
    Compare, CriticalPath, Network, OperationCondition, RunEnd, RunGoal, Scenario, ScenarioCondition, SimOptions,
    StationCondition, run,
};

use crate::common::*;

fn problems(text: &str) -> Vec<String> {
    let line = transfer_line(1);
    let problems = Scenario::parse(&line, "s.toml", text).expect_err("it has mistakes");
    let shown = |p: &linewright_line::Problem| {
        let hint = p.hint.as_ref().map_or(String::new(), |hint| format!(" ({hint})"));
        format!("{}:{}: {}{hint}", p.line, p.column, p.message)
    };
    problems.iter().map(shown).collect()
}

#[test]
fn all_mistakes_are_reported_at_once_each_in_its_place() {
    let text = r#"titel = "A slip"
[[step]]
when = "cycles >= three"
stick = "clmp_1: advance clamp"
[[step]]
when = "clamp_1 is incomplet"
command = "atuo"
[[step]]
jog = "clamp_1: advanse"
clear = "clamp_1: advance clam"
[[step]]
expect = "all is well"
whn = "now"
kill = "mill_2"
"#;
    assert_eq!(
        problems(text),
        [
            "1:1: unknown key `titel` in a scenario (did you mean `title`?)",
            "3:19: `three` is no whole number",
            "4:10: unknown station `clmp_1` (did you mean `clamp_1`?)",
            "6:20: unknown state of a station `incomplet` (did you mean `incomplete`?)",
            "7:11: unknown command `atuo` (did you mean `auto`?)",
            "9:17: unknown panel button `advanse` (did you mean `advance`?)",
            "10:19: unknown operation `advance clam` (did you mean `advance clamp`?)",
            "12:18: unknown state of a station `well` (known here: `home`, `stopped`, `moving`, `incomplete`, `blocked`, \
             `up`, `down`, `heard`)",
            "13:1: unknown key `whn` in a step (did you mean `when`?)",
            "14:8: unknown process `mill_2` (did you mean `mill_1`?)",
        ]
    );
}

#[test]
fn a_step_does_one_thing_and_text_that_is_no_toml_says_where() {
    assert_eq!(problems("[[step]]\nstick = \"clamp_1: advance clamp\"\nkill = \"mill_1\"\n").len(), 1);
    assert!(problems("[[step]\n")[0].starts_with("1:"));
    assert!(problems("[[step]]\nbuttons = [\"PB_9\", 3]\nat_s = -1\n").len() == 3);
}

#[test]
fn any_text_is_answered() {
    let line = transfer_line(1);
    let sound = include_str!("../../launch-config/lines/transfer-line/scenarios/jammed-clamp.toml");
    let mut rng = linewright_simulation::Rng::new(5);
    for _ in 0..2000 {
        let mut bytes = sound.as_bytes().to_vec();
        for _ in 0..rng.within(1, 6) {
            let at = rng.below(bytes.len().max(1) as u64) as usize;
            if at >= bytes.len() {
                break;
            }
            match rng.below(3) {
                0 => bytes[at] = *rng.pick(b"\"[]=:.\n ax0\\u{}"),
                1 => drop(bytes.remove(at)),
                _ => bytes.truncate(at.max(1)),
            }
        }
        let _ = Scenario::parse(&line, "s.toml", &String::from_utf8_lossy(&bytes)).map_err(|p| format!("{p:#}"));
    }
}

#[test]
fn an_expectation_that_does_not_hold_is_shown_where_it_stands() {
    let text = "[[step]]\nwhen = \"cycles >= 1\"\nexpect = \"line is hand\"\n";
    let (sim, end) = play(text);
    let RunEnd::Failed { step: Some(step), why } = end else { panic!("{end:?}") };
    assert_eq!(step, 0);
    assert!(why.starts_with("expected line is hand, which does not hold at 3."), "{why}");
    let scenario = Scenario::parse(sim.line(), "s.toml", text).expect("it is sound");
    let shown = scenario.failed_at(step, &why).expect("it is one of its steps");
    assert_eq!(shown.iter().next().map(|p| p.line), Some(1));
}

#[test]
fn waiting_in_vain_ends() {
    let (_, end) = play(
        "[[step]]\nwhen = \"cycles >= 1\"\nstick = \"clamp_1: advance clamp\"\n[[step]]\nwhen = \"cycles >= 9\"\n",
    );
    let RunEnd::Failed { step: Some(1), why } = end else { panic!("{end:?}") };
    assert!(why.contains("waited in vain") && why.contains("clamp_1 waits for"), "{why}");
    let (_, end) = play("[[step]]\nat_s = 5\ncommand = \"hand\"\n");
    let RunEnd::Failed { step: Some(0), why } = end else { panic!("{end:?}") };
    assert!(why.contains("not obeyed"), "{why}");
}

#[test]
fn what_would_be_without_effect_is_a_mistake() {
    let text = r#"cycles = 2.5
[[step]]
command = "stop"
for_s = 3
[[step]]
when = "all are home"
motion = "normal"
[[step]]
stick = "mill_1: feed main slide"
motion = "recovery"
[[step]]
"#;
    assert_eq!(
        problems(text),
        [
            "1:10: `cycles` must be a whole number",
            "4:9: `for_s` without `press` (a step waits with `after_s`)",
            "7:10: `motion` of nothing (it says which motions of one of these are meant: `stick`, `slip`, `break`, `slip-back`, `miss`, `drop`, `clear`)",
            "10:10: `feed main slide` is irreversible: no motion undoes it (what its recovery path does are motions of the \
             operations it names)",
            "11:1: an empty step (a step waits, does one thing, or expects)",
        ]
    );
    assert_eq!(problems("cycles = -1\n"), ["1:10: `cycles` is -1 (between 0 and 10000000)"]);
}

/// By images and over frames.
#[test]
fn a_person_puts_a_part_in_and_takes_it_out() {
    let text = include_str!("../../model/line/tests/descriptions/task_driven.toml");
    let line = linewright_line::parse("task_driven.toml", text).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let steps = |steps: &[&str]| steps.iter().map(|step| format!("[[step]]\n{step}\n")).collect::<String>();
    for frames in [false, true] {
        let failed = |wanted: &[&str]| match play_line(&line, &steps(wanted), SimOptions { frames, ..logged() }) {
            (_, RunEnd::Failed { step: Some(step), why }) => (step, why),
            (sim, end) => panic!("{end:?}: {}", sim.log().tail(sim.line(), 20)),
        };
        let [put, take] = ["put = \"ST: 2\"", "take = \"ST: 2\""];
        assert_eq!(failed(&[put, put]), (1, "position 2 of `ST` has a part already".to_owned()));
        assert_eq!(failed(&[put, take, take]), (2, "position 2 of `ST` has no part".to_owned()));
        assert_eq!(failed(&["put = \"m1.clamp\"", "put = \"ST: 9\""]).0, 1);
    }
    let problems = |text: &str| {
        let found = Scenario::parse(&line, "test.toml", text).expect_err("it is wrong");
        found.iter().map(|problem| problem.message.clone()).collect::<Vec<_>>()
    };
    assert_eq!(problems(&steps(&["take = \"m1.clmp\""])), ["unknown place for parts `m1.clmp`"]);
    assert_eq!(problems(&steps(&["take = \"ST: x\""])), ["`x` is no position"]);
}

#[test]
fn a_step_that_changes_nothing_fails() {
    for (step, expected) in [
        ("restart = \"mill_1\"", "mill_1 is up"),
        ("restart = \"coordinator\"", "coordinator is up"),
        ("device_back = \"mill 1 io\"", "mill 1 io is not lost"),
        ("release = \"clamp_1: return\"", "return of clamp_1 is not held"),
    ] {
        let (_, end) = play(&format!("[[step]]\n{step}\n"));
        assert_eq!(end, RunEnd::Failed { step: Some(0), why: expected.to_owned() });
    }
    for (step, expected) in [
        ("kill = \"mill_1\"", "mill_1 is down already"),
        ("device_lost = \"mill 1 io\"", "mill 1 io is lost already"),
        ("hold = \"clamp_1: return\"", "return of clamp_1 is held already"),
    ] {
        let (_, end) = play(&format!("[[step]]\n{step}\n[[step]]\n{step}\n"));
        assert_eq!(end, RunEnd::Failed { step: Some(1), why: expected.to_owned() });
    }
}

#[test]
fn an_operation_may_have_the_words_of_a_condition_in_its_name() {
    let mut line = transfer_line(1);
    let (mill, decel) = op(&line, "mill_1", "decel");
    line.stations[mill.index()].operations[decel.index()].name = "turn and is slow and are low".to_owned();
    let text = "[[step]]\nwhen = \"cycles >= 0 and mill_1: turn and is slow and are low is done and all are home\"\n";
    let scenario = Scenario::parse(&line, "s.toml", text).unwrap_or_else(|problems| panic!("{problems:#}"));
    let done = ScenarioCondition::Operation((mill, decel), OperationCondition::Done);
    let all = [ScenarioCondition::Cycles(Compare::AtLeast, 0), done, ScenarioCondition::Every(StationCondition::Home)];
    assert_eq!(scenario.script.steps[0].when, Some(ScenarioCondition::All(all.to_vec())));
}

#[test]
fn a_step_changes_of_the_network_what_it_names() {
    let line = transfer_line(1);
    let text = "[network]\ndelay_ms = 5\n[[step]]\nwhen = \"cycles >= 1\"\nnetwork = { loss_percent = 0 }\n";
    let scenario = Scenario::parse(&line, "s.toml", text).expect("it is sound");
    assert_eq!(scenario.network.delay, Duration::from_millis(5));
    // As if another delay had been given on the command line.
    let network = Network { delay: Duration::from_millis(20), ..scenario.network };
    let goal = RunGoal { cycles: 4, starts: true, script: scenario.script };
    let (sim, end) = run(&line, SimOptions { network, ..logged() }, &goal).expect("the line compiles");
    assert_eq!(end, RunEnd::Done);
    let path = CriticalPath::of(&line, sim.record()).expect("four cycles are steady");
    let late: Duration = path.links.iter().map(|link| link.late).sum();
    assert_eq!(late, Duration::from_millis(4 * 20), "four arrows, a message each");
}

#[test]
fn what_somebody_does_after_a_long_time_is_given_its_time() {
    let sim = played(
        r#"
        [[step]]
        when = "mill_1: decel is operating"
        kill = "mill_1"
        [[step]]
        after_s = 600
        restart = "mill_1"
        [[step]]
        when = "all are heard"
        command = "manual"
        [[step]]
        after_s = 600
        hold = "mill_1: advance"
        [[step]]
        when = "mill_1: decel is done"
        release = "mill_1: advance"
        [[step]]
        command = "auto"
        "#,
    );
    assert!(sim.now().as_micros() > 1_200_000_000);
}
