//! Playing the sequences of a certificate, many firings of one transition at a time.

use super::{CertificateRule, Rejected, require, sets};
use crate::certificate::evidence::RepeatedFiring;
use crate::{Net, PlaceId, TransitionId};

/// Tokens per place, with more room than a marking has.
#[derive(Clone)]
pub(super) struct ReplayTokens(Vec<u64>);

impl ReplayTokens {
    pub fn initial(net: &Net) -> ReplayTokens {
        ReplayTokens(net.initial_marking().as_slice().iter().map(|&count| u64::from(count)).collect())
    }

    pub fn on(&self, place: PlaceId) -> u64 {
        self.0[place.index()]
    }

    pub fn enables(&self, net: &Net, transition: TransitionId) -> bool {
        net.preset(transition).iter().all(|&(place, weight)| self.on(place) >= u64::from(weight))
    }

    pub fn sum(&self, weights: &[(PlaceId, i128)]) -> Result<i128, Rejected> {
        weights.iter().try_fold(0_i128, |sum, &(place, weight)| {
            weight
                .checked_mul(self.on(place).into())
                .and_then(|term| sum.checked_add(term))
                .ok_or(Rejected::rule(CertificateRule::Size))
        })
    }

    /// Fires all of it, or returns the transition that is not enabled.
    pub fn play(&mut self, net: &Net, runs: &[RepeatedFiring]) -> Result<(), Rejected> {
        runs.iter().try_for_each(|run| self.fire(net, run))
    }

    fn fire(&mut self, net: &Net, run: &RepeatedFiring) -> Result<(), Rejected> {
        let t = run.transition;
        sets::known_transition(net, t)?;
        require(run.times > 0, CertificateRule::NotEmpty)?;
        let gives = |place: PlaceId| {
            net.postset(t).iter().find(|&&(other, _)| other == place).map_or(0, |&(_, weight)| u64::from(weight))
        };
        for &(place, weight) in net.preset(t) {
            // The last firing needs the whole weight, every one before it what it does not give back.
            let lost = u64::from(weight).saturating_sub(gives(place));
            let needs = (run.times - 1).checked_mul(lost).and_then(|lost| lost.checked_add(weight.into()));
            if needs.is_none_or(|needs| self.on(place) < needs) {
                return Err(Rejected::at(CertificateRule::Enabled, net, t));
            }
        }
        for &(place, weight) in net.preset(t).iter().chain(net.postset(t)) {
            // Counts end at 63 bits; a certificate that gets there is refused.
            let most = run.times.checked_mul(weight.into()).and_then(|all| all.checked_add(self.on(place)));
            require(most.is_some_and(|most| most <= i64::MAX as u64), CertificateRule::Size)?;
        }
        for &(place, weight) in net.preset(t) {
            let lost = u64::from(weight).saturating_sub(gives(place));
            self.0[place.index()] -= run.times * lost;
        }
        for &(place, weight) in net.postset(t) {
            let takes = net.preset(t).iter().find(|&&(other, _)| other == place).map_or(0, |&(_, weight)| weight);
            self.0[place.index()] += run.times * u64::from(weight.saturating_sub(takes));
        }
        Ok(())
    }
}
