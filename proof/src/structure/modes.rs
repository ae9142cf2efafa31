//! The mode decision: the same net for every line, checked with each all the same.

use linewright_coordinator_logic::decision::{ARCS, ModeFacts, net};
use linewright_line::net::ControlMode;
use linewright_nets::state_machine_verdict;

/// A live, safe and reversible state machine with its token on home.
pub fn verdict() -> Result<String, String> {
    let net = net();
    let verdict = state_machine_verdict(&net).map_err(|why| why.to_string())?;
    if !verdict.holds() {
        return Err(verdict.to_string());
    }
    Ok(format!("{} modes, {} arcs: live, safe, reversible", net.place_count(), net.transition_count()))
}

/// Under all facts at most one arc leads out of each mode.
pub fn at_most_one_arc() -> Result<String, String> {
    let mut cases = 0;
    for mode in ControlMode::ALL {
        for facts in ModeFacts::all() {
            let allowed: Vec<ControlMode> =
                ARCS.iter().filter(|arc| arc.from == mode && (arc.when)(&facts)).map(|arc| arc.to).collect();
            if let [one, other, ..] = allowed[..] {
                return Err(format!("from {mode} both {one} and {other} under {facts:?}"));
            }
            cases += 1;
        }
    }
    Ok(format!("one arc at most in all {cases} cases of mode, command and facts"))
}

/// From every mode an operator can come to manual, whatever is wrong: pressing and resetting the emergency stop,
/// requesting manual, and waiting until what moves has stopped is enough. Recovery relies on it.
pub fn manual_from_everywhere() -> Result<String, String> {
    let at_hand = || ModeFacts::all().filter(|facts| facts.trouble && facts.all_stopped && !facts.all_home);
    let mut leads = vec![ControlMode::Manual];
    loop {
        let before = leads.len();
        for mode in ControlMode::ALL {
            let on =
                |arc: &&linewright_coordinator_logic::decision::ModeArc| arc.from == mode && leads.contains(&arc.to);
            let follows = ARCS.iter().filter(on).any(|arc| at_hand().any(|facts| (arc.when)(&facts)));
            if follows && !leads.contains(&mode) {
                leads.push(mode);
            }
        }
        if leads.len() == before {
            break;
        }
    }
    match ControlMode::ALL.iter().find(|mode| !leads.contains(mode)) {
        None => Ok("by commands alone, whatever is wrong with stations and devices".to_owned()),
        Some(mode) => Err(format!("nothing leads from {mode} to manual while there is trouble")),
    }
}
