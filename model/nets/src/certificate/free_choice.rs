//! Verdicts on nets of extended free choice, and what remains for any other net.
//!
//! For connected free-choice nets the rank theorem (Desel and Esparza, *Free Choice Petri Nets*, 1995, chapter 6)
//! decides "live and bounded" together, in polynomial time, and its conditions can be checked. If it fails, Commoner's
//! theorem still decides liveness, but its list of all minimal siphons cannot be checked for completeness; a negative
//! answer then needs a sequence that runs a siphon empty, which a short search looks for. Where it finds none the
//! answer is [`Unknown`], with what is known without a certificate.

use super::evidence::{Dead, Evidence, NetProperty, Sums, WellFormed};
use super::play::find;
use super::{CertificateAnswer, NetClass, StructuralVerdict, TokenBound, Unknown};
use crate::semiflows::{self, Semiflow, SemiflowLimits, Semiflows, place_semiflows, transition_semiflows};
use crate::siphons::{self, commoner, largest_empty_siphon, largest_trap_in};
use crate::{Marking, Net, PlaceId};

/// Most markings that the search for a sequence visits.
const MARKINGS: usize = 5_000;

/// The verdict on a net that is neither a state machine nor a marked graph.
pub(super) fn decide(net: &Net) -> StructuralVerdict {
    let free_choice = net.is_extended_free_choice().is_ok();
    let class = if free_choice { NetClass::FreeChoice } else { NetClass::Other };
    let flows = place_semiflows(net, &SemiflowLimits::default());
    let formed = if free_choice { well_formed(net, &flows) } else { Err(Unknown::Class(class)) };
    let (bounds, bounded, safe) = bounds(net, &flows, formed.is_ok());
    let mut verdict = StructuralVerdict {
        class,
        deadlock_free: CertificateAnswer::Unknown(Unknown::Class(class)),
        live: CertificateAnswer::Unknown(Unknown::Class(class)),
        bounded,
        safe,
        reversible: CertificateAnswer::Unknown(Unknown::Class(class)),
        bounds,
    };
    match formed {
        Ok(formed) => {
            verdict.live = CertificateAnswer::yes(NetProperty::Live, Evidence::WellFormed(formed.clone()));
            verdict.deadlock_free =
                CertificateAnswer::yes(NetProperty::DeadlockFree, Evidence::WellFormed(formed.clone()));
            verdict.reversible = reversible(net, formed);
        }
        Err(unknown) => {
            verdict.live = not_live(net, free_choice, unknown);
            let initial = net.initial_marking();
            if net.enabled(&initial).next().is_none() {
                verdict.deadlock_free =
                    CertificateAnswer::no(NetProperty::DeadlockFree, Evidence::Deadlock(Vec::new()));
            }
        }
    }
    verdict
}

/// Evidence for the rank theorem, if it applies and holds.
fn well_formed(
    net: &Net,
    flows: &Result<Semiflows<PlaceId>, semiflows::SemiflowsUndecided>,
) -> Result<WellFormed, Unknown> {
    let flows = flows.as_ref().map_err(|error| Unknown::Semiflows(error.clone()))?;
    let repeated = transition_semiflows(net, &SemiflowLimits::default()).map_err(Unknown::Semiflows)?;
    let unfit = || Unknown::NotWellFormed;
    let conserved = total(flows.all(), net.place_count(), |place| place.index()).ok_or_else(unfit)?;
    let repeated = total(repeated.all(), net.transition_count(), |t| t.index()).ok_or_else(unfit)?;
    let basis = semiflows::transition_flow_basis(net).map_err(Unknown::Semiflows)?;
    let formed = WellFormed { conserved, repeated, flows: basis.into_iter().map(|flow| flow.entries).collect() };
    // The rest of the conditions are what the checker looks at anyway.
    super::check::check_well_formed(net, &formed).map_err(|_| Unknown::NotWellFormed)?;
    Ok(formed)
}

/// A positive weight for every node, as a sum of semiflows; none if a node is in none of them, or if the sum is too
/// large.
fn total<I: Copy + Ord>(flows: &[Semiflow<I>], count: usize, index: impl Fn(I) -> usize) -> Option<Vec<u64>> {
    let mut weights = vec![0_u64; count];
    for flow in flows {
        if flow.support().any(|node| weights[index(node)] == 0) {
            for &(node, weight) in &flow.weights {
                weights[index(node)] = weights[index(node)].checked_add(weight)?;
            }
        }
    }
    weights.iter().all(|&weight| weight > 0).then_some(weights)
}

fn reversible(net: &Net, formed: WellFormed) -> CertificateAnswer {
    let initial = net.initial_marking();
    let empty: Vec<PlaceId> = net.places().filter(|&place| initial.tokens(place) == 0).collect();
    let trap = largest_trap_in(net, &empty);
    if trap.is_empty() {
        CertificateAnswer::yes(NetProperty::Reversible, Evidence::WellFormed(formed))
    } else {
        CertificateAnswer::no(NetProperty::Reversible, Evidence::UnmarkedTrap(formed, trap))
    }
}

/// A siphon that is empty, or that can be emptied; the transition that depends on it.
fn dead(net: &Net, run: Vec<super::evidence::RepeatedFiring>, marking: &Marking) -> Option<CertificateAnswer> {
    let siphon = largest_empty_siphon(net, marking);
    let transition = siphon.iter().find_map(|&place| net.consumers(place).first()).map(|&(t, _)| t)?;
    Some(CertificateAnswer::no(NetProperty::Live, Evidence::Dead(Dead { run, siphon, transition })))
}

fn not_live(net: &Net, free_choice: bool, unknown: Unknown) -> CertificateAnswer {
    if let Some(answer) = dead(net, Vec::new(), &net.initial_marking()) {
        return answer;
    }
    if !free_choice {
        return CertificateAnswer::Unknown(unknown);
    }
    match commoner(net, &siphons::SiphonLimits::default()) {
        Err(error) => CertificateAnswer::Unknown(Unknown::Siphons(error)),
        Ok(Ok(())) => CertificateAnswer::Unknown(Unknown::Uncertified),
        Ok(Err(uncontrolled)) => {
            // By the theorem some reachable marking has an empty siphon that a transition depends on.
            let empties = |marking: &Marking| dead(net, Vec::new(), marking).is_some();
            let answer = find(net, MARKINGS, empties).and_then(|(run, marking)| dead(net, run, &marking));
            answer.unwrap_or(CertificateAnswer::Unknown(Unknown::NotFound {
                siphon: uncontrolled.siphon,
                markings: MARKINGS,
            }))
        }
    }
}

/// Bounds by conserved sums. They are exact in live and bounded free-choice nets, where every place is in a state
/// machine component whose tokens can all come to it (Desel and Esparza 1995, chapter 5).
fn bounds(
    net: &Net,
    flows: &Result<Semiflows<PlaceId>, semiflows::SemiflowsUndecided>,
    exact: bool,
) -> (Vec<TokenBound>, CertificateAnswer, CertificateAnswer) {
    let flows = match flows {
        Ok(flows) => flows,
        Err(error) => {
            let unknown = || CertificateAnswer::Unknown(Unknown::Semiflows(error.clone()));
            return (vec![TokenBound::Unknown; net.place_count()], unknown(), unknown());
        }
    };
    let initial = net.initial_marking();
    let found: Vec<Option<(u128, &Semiflow<PlaceId>)>> = net.places().map(|p| flows.bound(p, &initial)).collect();
    let bounds: Vec<TokenBound> = found
        .iter()
        .map(|found| match found {
            Some((bound, _)) if exact => TokenBound::Exactly(*bound),
            Some((bound, _)) => TokenBound::AtMost(*bound),
            None => TokenBound::Unknown,
        })
        .collect();
    let Some(found) = found.into_iter().collect::<Option<Vec<_>>>() else {
        return (bounds, CertificateAnswer::Unknown(Unknown::Uncovered), overfull(net, false));
    };
    let mut sums = Sums::default();
    let mut numbers = std::collections::HashMap::new();
    for (bound, flow) in found {
        let number = *numbers.entry(flow).or_insert_with(|| {
            sums.sums.push(flow.weights.clone());
            sums.sums.len() - 1
        });
        sums.bounds.push((number, bound));
    }
    let safe = if sums.bounds.iter().all(|&(_, bound)| bound <= 1) {
        CertificateAnswer::yes(NetProperty::Safe, Evidence::Sums(sums.clone()))
    } else {
        overfull(net, exact)
    };
    (bounds, CertificateAnswer::yes(NetProperty::Bounded, Evidence::Sums(sums)), safe)
}

/// Two tokens on a place: initially, or, where it is possible by theory, after a sequence.
fn overfull(net: &Net, possible: bool) -> CertificateAnswer {
    let over = |marking: &Marking| marking.marked().find(|&place| marking.tokens(place) > 1);
    let most = if possible { MARKINGS } else { 1 };
    match find(net, most, |marking| over(marking).is_some()) {
        Some((run, marking)) => {
            let place = over(&marking).expect("the search ended at such a marking");
            CertificateAnswer::no(NetProperty::Safe, Evidence::Overfull(run, place))
        }
        None => CertificateAnswer::Unknown(Unknown::Loose),
    }
}
