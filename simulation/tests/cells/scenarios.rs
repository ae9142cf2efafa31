//! Every rule of a cell's scenario, broken once: edits of the shipped one, and the problems they raise, in `problems/*.cases`.

use linewright_cell::Cell;
use linewright_simulation::cell::CellScenario;
use linewright_text::Problem;

const PRODUCTION: &str = include_str!("../../../launch-config/lines/workcell-c1/scenarios/production.toml");

fn cell(name: &str) -> Cell {
    let file = format!("{}/../launch-config/lines/{name}/cell.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(file).expect("it is there");
    linewright_cell::parse("cell.toml", &text, None).unwrap_or_else(|why| panic!("{why:#}")).cell
}

fn problems(text: &str) -> Vec<Problem> {
    CellScenario::parse(&cell("workcell-c1"), "s.toml", text).err().map(|why| why.into_vec()).unwrap_or_default()
}

#[test]
fn rules_of_a_scenario() {
    let cases = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/problems");
    linewright_cases::check(cases, "scenario.cases", |_| PRODUCTION.to_owned(), problems);
}

#[test]
fn the_shipped_scenario_is_sound() {
    assert_eq!(problems(PRODUCTION), []);
}

#[test]
fn no_text_makes_the_reader_panic() {
    for cut in (0..PRODUCTION.len()).filter(|at| PRODUCTION.is_char_boundary(*at)).step_by(7) {
        let _ = problems(&PRODUCTION[..cut]);
        let _ = problems(&format!("{}{}", &PRODUCTION[..cut], &PRODUCTION[(cut + 40).min(PRODUCTION.len())..]));
    }
}
