//! Synthesis by diagrams agrees with the monolithic way: the same states, and nothing more forbidden than needed.

use std::collections::BTreeSet;

use linewright_relations::{ConditionId, Relations};
use linewright_synthesis::monolithic::{OperationKey, explore};
use linewright_synthesis::{AddedGuard, Composition, Mark, Supervisor, Synthesis, SynthesisLimits, synthesise};

use crate::cases::cases;
use crate::generate::cell;

/// More states are not compared.
const STATES_MAX: usize = 5_000;

type Marks = Vec<(OperationKey, Mark)>;

fn key(composition: &Composition, of: usize) -> OperationKey {
    let operation = &composition.operations[of];
    (operation.instance, operation.operations[0], operation.way.clone(), operation.is_left_out)
}

fn allows(guard: &AddedGuard, state: &BTreeSet<(usize, Mark)>) -> bool {
    let holds =
        guard.terms.iter().any(|term| term.iter().all(|value| state.contains(&(value.of, value.mark)) == value.is_set));
    holds == guard.allows
}

/// Every state that is reached where the added conditions are obeyed.
fn played(supervisor: &Supervisor) -> BTreeSet<Marks> {
    let composition = &supervisor.composition;
    let mut seen: BTreeSet<BTreeSet<(usize, Mark)>> = BTreeSet::from([BTreeSet::new()]);
    let mut open = vec![BTreeSet::new()];
    while let Some(state) = open.pop() {
        for event in composition.enabled(&state) {
            let is_start = |of: usize| of == event.of && event.mark == Mark::Started;
            let is_held = supervisor.added.iter().any(|added| is_start(added.of) && !allows(&added.guard, &state));
            let mut next = state.clone();
            next.insert((event.of, event.mark));
            if !is_held && seen.insert(next.clone()) {
                open.push(next);
            }
        }
    }
    let marks = |state: BTreeSet<(usize, Mark)>| {
        let mut marks: Marks = state.into_iter().map(|(of, mark)| (key(composition, of), mark)).collect();
        marks.sort();
        marks
    };
    seen.into_iter().map(marks).collect()
}

/// What was compared.
#[derive(Default, Debug)]
struct Compared {
    supervisors: u64,
    restricted: u64,
    contradictions: u64,
}

fn compare(seed: u64, relations: &Relations, products: &[ConditionId], compared: &mut Compared) -> bool {
    let Some(explored) = explore(relations, products, STATES_MAX) else { return false };
    match synthesise(relations, products, &SynthesisLimits::default()).expect("it is small") {
        Synthesis::Supervisor(found) => {
            assert_eq!(found.sizes.reachable, explored.reachable as f64, "seed {seed}: states that the tables allow");
            let all: BTreeSet<Marks> = explored.supervised.into_iter().collect();
            let played = played(&found);
            if let Some(state) = all.difference(&played).next() {
                panic!(
                    "seed {seed}: {} states instead of {}, without {state:?}; {:?}",
                    played.len(),
                    all.len(),
                    found.added
                );
            }
            assert_eq!(played.len(), all.len(), "seed {seed}: states where the added conditions are obeyed");
            assert_eq!(found.sizes.supervised, all.len() as f64, "seed {seed}: states under supervision");
            compared.supervisors += 1;
            compared.restricted += u64::from(!found.added.is_empty());
            for added in &found.added {
                let is_explained = !added.reason.locked.is_empty() || added.reason.violated.is_some();
                assert!(is_explained, "seed {seed}: no reason for {added:?}");
            }
        }
        Synthesis::Contradiction(found) => {
            assert!(explored.supervised.is_empty(), "seed {seed}: there is a supervisor");
            assert!(found.trap.is_some(), "seed {seed}: no way into the trap");
            compared.contradictions += 1;
        }
    }
    true
}

#[test]
fn diagrams_and_single_states_agree_on_random_cells() {
    let (mut compared, mut seed) = (Compared::default(), 0);
    let wanted = cases(1000);
    while compared.supervisors + compared.contradictions < wanted {
        if let Some((relations, products)) = cell(seed) {
            compare(seed, &relations, &products, &mut compared);
        }
        seed += 1;
        assert!(seed < 20 * wanted + 100, "few cells are sound: {compared:?}");
    }
    println!("{compared:?} of {seed} seeds");
    let Compared { supervisors, restricted, contradictions } = compared;
    assert!(
        wanted < 100 || (20 * restricted > supervisors && 20 * contradictions > wanted),
        "{compared:?} shows little"
    );
}
