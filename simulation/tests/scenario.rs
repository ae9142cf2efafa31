//! Scenarios as text: what they may say, and how mistakes are answered.

mod common;

use common::*;
use linewright_simulation::{End, Scenario};

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
jam = "clmp_1: advance clamp"
[[step]]
when = "clamp_1 is incomplet"
command = "atuo"
[[step]]
jog = "clamp_1: advanse"
repair = "clamp_1: advance clam"
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
            "4:8: unknown station `clmp_1` (did you mean `clamp_1`?)",
            "6:20: unknown state of a station `incomplet` (did you mean `incomplete`?)",
            "7:11: unknown command `atuo` (did you mean `auto`?)",
            "9:17: unknown panel button `advanse` (did you mean `advance`?)",
            "10:20: unknown operation `advance clam` (did you mean `advance clamp`?)",
            "12:18: unknown state of a station `well` (known here: `home`, `stopped`, `moving`, `incomplete`, `blocked`, \
             `up`, `down`, `heard`)",
            "13:1: unknown key `whn` in a step (did you mean `when`?)",
            "14:8: unknown process `mill_2` (did you mean `mill_1`?)",
        ]
    );
}

#[test]
fn a_step_does_one_thing_and_text_that_is_no_toml_says_where() {
    assert_eq!(problems("[[step]]\njam = \"clamp_1: advance clamp\"\nkill = \"mill_1\"\n").len(), 1);
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
    let End::Failed { step: Some(step), why } = end else { panic!("{end:?}") };
    assert_eq!(step, 0);
    assert!(why.starts_with("expected line is hand, which does not hold at 3."), "{why}");
    let scenario = Scenario::parse(sim.line(), "s.toml", text).expect("it is sound");
    let shown = scenario.failed_at(step, &why).expect("it is one of its steps");
    assert_eq!(shown.iter().next().map(|p| p.line), Some(1));
}

#[test]
fn waiting_in_vain_ends() {
    let (_, end) =
        play("[[step]]\nwhen = \"cycles >= 1\"\njam = \"clamp_1: advance clamp\"\n[[step]]\nwhen = \"cycles >= 9\"\n");
    let End::Failed { step: Some(1), why } = end else { panic!("{end:?}") };
    assert!(why.contains("waited in vain") && why.contains("clamp_1 waits for"), "{why}");
    let (_, end) = play("[[step]]\nat_s = 5\ncommand = \"hand\"\n");
    let End::Failed { step: Some(0), why } = end else { panic!("{end:?}") };
    assert!(why.contains("not obeyed"), "{why}");
}
