//! One run: the plan of a seed, played to its end.

use std::time::Duration;

use linewright_line::Tick;

use crate::mutants::Mutant;
use crate::people::NOT_HOME;
use crate::plan::FaultPlan;
use crate::world::World;

/// A check that does not hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    pub at: Tick,
    pub text: String,
}

/// What has become of a seed.
#[derive(Clone, Debug)]
pub struct PlayedSeed {
    pub finding: Option<Finding>,
    /// On a generated line, whose conflicts need not be measured: stations stand where no panel leads them home.
    pub is_left_standing: bool,
    /// Faults, changes of mode and ends of processes, with their times.
    pub story: Vec<(Tick, String)>,
    /// Of every event and every output: the same for the same seed.
    pub hash: u64,
    pub events: u64,
    /// Virtual time of the run.
    pub end: Tick,
}

/// Plays the plan of a seed.
pub fn play(seed: u64, mutant: Option<Mutant>) -> PlayedSeed {
    play_plan(&FaultPlan::of(seed), mutant)
}

/// Plays a plan. The line is brought to auto first; then the faults happen; then they end, and it is brought back.
pub fn play_plan(plan: &FaultPlan, mutant: Option<Mutant>) -> PlayedSeed {
    let mut world = World::new(plan.line.clone(), plan.seed, plan.faults.clone(), mutant);
    world.run_for(Duration::from_millis(400));
    for command in [linewright_coordinator_logic::ModeCommand::Start, linewright_coordinator_logic::ModeCommand::Auto] {
        world.say_command(command);
        world.run_for(Duration::from_millis(150));
    }
    world.run_to(plan.end);
    world.mend();
    let mut is_left_standing = false;
    if world.observer.finding.is_none()
        && let Err(text) = if plan.follows_plan { world.recover() } else { world.bring_back() }
    {
        let at = world.now;
        is_left_standing = !plan.is_shipped && text.starts_with(NOT_HOME);
        if !is_left_standing {
            world.observer.find(at, format!("not brought back: {text}"));
        }
    }
    PlayedSeed {
        is_left_standing,
        finding: world.observer.finding.take(),
        story: std::mem::take(&mut world.story),
        hash: world.hash,
        events: world.events,
        end: world.now,
    }
}
