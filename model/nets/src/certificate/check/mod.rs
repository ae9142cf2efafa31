//! The checker: whether the evidence of a certificate proves its claim.
//!
//! It is short enough to be read as a whole. It uses the net, numbers, and nothing of the analyses that find the
//! evidence: no components, no semiflows, no search. It computes every figure that it can, refuses what it does not
//! understand, and takes time about linear in the net and the certificate, the rank aside.

mod rank;
mod replay;
mod sets;
mod theorems;

use thiserror::Error;

use super::evidence::{Certificate, Dead, Evidence, NetProperty, NoReturn, Sums, UnboundedCycle};
use crate::{NamedId, Net, NetNode, PlaceId};
use replay::ReplayTokens;

/// Reason why a certificate proves nothing.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("the certificate is not accepted: {rule}{}", at.as_ref().map(|at| format!(", but not for {at}")).unwrap_or_default())]
pub struct Rejected {
    /// Rule that does not hold.
    pub rule: CertificateRule,
    /// Node where it does not hold, if there is one.
    pub at: Option<NamedId<NetNode>>,
}

/// Condition of a certificate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]

pub enum CertificateRule {
    #[error("evidence of this kind has to be able to prove the claim")]
    Kind,
    #[error("places and transitions have to be those of the net")]
    Known,
    #[error("nothing may be listed twice")]
    Once,
    #[error("arcs have to have weight 1")]
    Ordinary,
    #[error("each place next to a listed transition has one producer and one consumer, listed too")]
    Closed,
    #[error("the order has to rise along every empty place")]
    Rising,
    #[error("all transitions have to be covered")]
    AllTransitions,
    #[error("something has to be listed")]
    NotEmpty,
    #[error("transitions that are not listed have to be disabled")]
    Still,
    #[error("every transition has one input place and one output place")]
    StateMachine,
    #[error("the walks have to connect all places of a component with its root")]
    Connected,
    #[error("no transition may lead out of a component")]
    Terminal,
    #[error("a token is needed")]
    Marked,
    #[error("all tokens have to be in components")]
    AllTokens,
    #[error("whatever takes from the trap has to give to it")]
    Trap,
    #[error("whatever gives to the siphon has to take from it")]
    Siphon,
    #[error("the set has to be empty")]
    Empty,
    #[error("each place of the trap has to have a transition that needs nothing else")]
    Free,
    #[error("each place has a bound, and it is the one that its sum gives")]
    Bound,
    #[error("no transition that can fire may change the sum the wrong way")]
    Monotone,
    #[error("bounds have to be at most 1")]
    Safe,
    #[error("numbers have to be small enough to compute with")]
    Size,
    #[error("each transition of the sequence has to be enabled")]
    Enabled,
    #[error("the sequence has to end where nothing is enabled")]
    DeadEnd,
    #[error("the place has to have more than one token in the end")]
    Overfull,
    #[error("the cycle may take away nothing and has to add tokens")]
    Gain,
    #[error("the sum has to be larger after the sequence")]
    Larger,
    #[error("the transition has to take from the siphon")]
    Depends,
    #[error("transitions with a common input place have to have the same input places")]
    FreeChoice,
    #[error("the net has to be connected, with places and transitions")]
    OnePiece,
    #[error("weights have to be positive, one for each")]
    Positive,
    #[error("the weighted sum of tokens has to be conserved")]
    Conserved,
    #[error("the firings have to lead back")]
    LeadsBack,
    #[error("the rank has to be one less than the number of clusters")]
    Rank,
}

impl Rejected {
    fn rule(rule: CertificateRule) -> Rejected {
        Rejected { rule, at: None }
    }

    fn at(rule: CertificateRule, net: &Net, node: impl Into<NetNode>) -> Rejected {
        Rejected { rule, at: Some(net.node(node.into())) }
    }
}

/// `Ok` if the condition holds.
fn require(holds: bool, rule: CertificateRule) -> Result<(), Rejected> {
    if holds { Ok(()) } else { Err(Rejected::rule(rule)) }
}

/// Whether the certificate proves its claim about this net and its initial marking.
pub fn check(net: &Net, certificate: &Certificate) -> Result<(), Rejected> {
    let (property, holds) = (certificate.property, certificate.holds);
    match (&certificate.evidence, property, holds) {
        (Evidence::Order(order), NetProperty::Live, true) => theorems::live_order(net, order),
        (Evidence::Order(order), NetProperty::DeadlockFree, true) => theorems::moving_order(net, order),
        (Evidence::Order(order), NetProperty::Reversible, true) => theorems::returning_order(net, order),
        (Evidence::Components(parts), NetProperty::Live, true) => theorems::live_components(net, parts),
        (Evidence::Components(parts), NetProperty::DeadlockFree, true) => theorems::moving_components(net, parts),
        (Evidence::Components(parts), NetProperty::Reversible, true) => theorems::returning_components(net, parts),
        (Evidence::Trap(trap), NetProperty::DeadlockFree, true) => theorems::moving_trap(net, trap),
        (Evidence::Sums(sums), NetProperty::Bounded, true) => check_sums(net, sums),
        (Evidence::Sums(sums), NetProperty::Safe, true) => {
            check_sums(net, sums)?;
            require(sums.bounds.iter().all(|&(_, bound)| bound <= 1), CertificateRule::Safe)
        }
        (Evidence::WellFormed(formed), NetProperty::Live | NetProperty::DeadlockFree, true) => {
            theorems::well_formed(net, formed)
        }
        (Evidence::WellFormed(formed), NetProperty::Reversible, true) => {
            theorems::well_formed(net, formed)?;
            require(sets::no_empty_trap(net), CertificateRule::Marked)
        }
        (Evidence::UnmarkedTrap(formed, trap), NetProperty::Reversible, false) => {
            theorems::well_formed(net, formed)?;
            require(!trap.is_empty(), CertificateRule::NotEmpty)?;
            sets::trap(net, trap)?;
            sets::empty(net, trap, &ReplayTokens::initial(net))
        }
        (Evidence::Dead(dead), NetProperty::Live, false) => check_dead(net, dead),
        (Evidence::Deadlock(run), NetProperty::DeadlockFree, false) => {
            let mut tokens = ReplayTokens::initial(net);
            tokens.play(net, run)?;
            match net.transitions().find(|&t| tokens.enables(net, t)) {
                Some(t) => Err(Rejected::at(CertificateRule::DeadEnd, net, t)),
                None => Ok(()),
            }
        }
        (Evidence::Overfull(run, place), NetProperty::Safe, false) => {
            sets::known_place(net, *place)?;
            let mut tokens = ReplayTokens::initial(net);
            tokens.play(net, run)?;
            require(tokens.on(*place) > 1, CertificateRule::Overfull)
        }
        (Evidence::Pump(pump), NetProperty::Bounded, false) => check_pump(net, pump),
        (Evidence::NoReturn(no_return), NetProperty::Reversible, false) => check_no_return(net, no_return),
        _ => Err(Rejected::rule(CertificateRule::Kind)),
    }
}

/// Whether the rank theorem applies and proves "live and bounded".
pub(super) fn check_well_formed(net: &Net, formed: &super::evidence::WellFormed) -> Result<(), Rejected> {
    theorems::well_formed(net, formed)
}

/// An empty siphon: what takes from it never fires.
fn check_empty_siphon(net: &Net, siphon: &[PlaceId], tokens: &ReplayTokens) -> Result<Vec<bool>, Rejected> {
    sets::siphon(net, siphon)?;
    sets::empty(net, siphon, tokens)?;
    let mut dead = vec![false; net.transition_count()];
    for &place in siphon {
        net.consumers(place).iter().for_each(|&(t, _)| dead[t.index()] = true);
    }
    Ok(dead)
}

fn check_sums(net: &Net, sums: &Sums) -> Result<(), Rejected> {
    let dead = check_empty_siphon(net, &sums.dead, &ReplayTokens::initial(net))?;
    let initial = net.initial_marking();
    let mut totals = Vec::with_capacity(sums.sums.len());
    for sum in &sums.sums {
        let weights: Vec<(PlaceId, i128)> = sum.iter().map(|&(place, weight)| (place, weight.into())).collect();
        sets::known(net, weights.iter().map(|&(place, _)| place))?;
        for (t, change) in sets::changes(net, &weights)? {
            if change > 0 && !dead[t.index()] {
                return Err(Rejected::at(CertificateRule::Monotone, net, t));
            }
        }
        // 64 bits of weight, 32 of tokens, and 24 of places, since none is listed twice.
        let total: u128 = sum.iter().map(|&(p, weight)| u128::from(weight) * u128::from(initial.tokens(p))).sum();
        totals.push(total);
    }
    require(sums.bounds.len() == net.place_count(), CertificateRule::Bound)?;
    // Each sum is looked up by its places once, not searched for every place.
    let mut weights_of: Vec<Vec<(usize, u64)>> = vec![Vec::new(); net.place_count()];
    for (number, sum) in sums.sums.iter().enumerate() {
        sum.iter().for_each(|&(place, weight)| weights_of[place.index()].push((number, weight)));
    }
    for (place, &(number, bound)) in net.places().zip(&sums.bounds) {
        let weight = weights_of[place.index()].iter().find(|&&(other, _)| other == number).map_or(0, |entry| entry.1);
        if weight == 0 || totals[number] / u128::from(weight) != bound {
            return Err(Rejected::at(CertificateRule::Bound, net, place));
        }
    }
    Ok(())
}

fn check_dead(net: &Net, dead: &Dead) -> Result<(), Rejected> {
    sets::known_transition(net, dead.transition)?;
    let mut tokens = ReplayTokens::initial(net);
    tokens.play(net, &dead.run)?;
    let never = check_empty_siphon(net, &dead.siphon, &tokens)?;
    require(never[dead.transition.index()], CertificateRule::Depends)
}

fn check_pump(net: &Net, pump: &UnboundedCycle) -> Result<(), Rejected> {
    sets::known_place(net, pump.place)?;
    let mut tokens = ReplayTokens::initial(net);
    tokens.play(net, &pump.prefix)?;
    let before = tokens.clone();
    tokens.play(net, &pump.cycle)?;
    match net.places().find(|&place| tokens.on(place) < before.on(place)) {
        Some(place) => Err(Rejected::at(CertificateRule::Gain, net, place)),
        None => require(tokens.on(pump.place) > before.on(pump.place), CertificateRule::Gain),
    }
}

fn check_no_return(net: &Net, no_return: &NoReturn) -> Result<(), Rejected> {
    let mut tokens = ReplayTokens::initial(net);
    let dead = check_empty_siphon(net, &no_return.dead, &tokens)?;
    let weights: Vec<(PlaceId, i128)> = no_return.weights.iter().map(|&(p, weight)| (p, weight.into())).collect();
    sets::known(net, weights.iter().map(|&(place, _)| place))?;
    for (t, change) in sets::changes(net, &weights)? {
        if change < 0 && !dead[t.index()] {
            return Err(Rejected::at(CertificateRule::Monotone, net, t));
        }
    }
    let before = tokens.sum(&weights)?;
    tokens.play(net, &no_return.run)?;
    require(tokens.sum(&weights)? > before, CertificateRule::Larger)
}
