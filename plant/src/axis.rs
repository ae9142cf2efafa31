//! Position of an axis: a straight line in time from its last change.
//!
//! A position is computed from the moment its motion began, never from the last query. Frequent and rare queries give
//! the same positions to the last bit, and nothing drifts.

use std::time::Duration;

use linewright_line::Tick;

/// A motion towards a target at constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Travel {
    /// End of the motion. It is never overshot.
    pub(crate) target: f64,
    /// Speed in units of the axis per microsecond, above zero.
    pub(crate) speed: f64,
}

/// An axis: since when it does what, and from where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisState {
    since: Tick,
    from: f64,
    travel: Option<Travel>,
}

impl AxisState {
    pub(crate) fn standing(at: f64) -> Self {
        AxisState { since: Tick::ZERO, from: at, travel: None }
    }

    /// Puts it somewhere, standing: it is moved by something else.
    pub(crate) fn place(&mut self, now: Tick, at: f64) {
        *self = AxisState { since: now, from: at, travel: None };
    }

    /// Position at `now`; a moment before its last change counts as that change.
    pub(crate) fn position(&self, now: Tick) -> f64 {
        let Some(Travel { target, speed }) = self.travel else { return self.from };
        let whole = target - self.from;
        let gone = speed * now.since(self.since).as_micros() as f64;
        // A remainder below a billionth of the way is rounding, not distance.
        if gone >= whole.abs() * (1.0 - 1e-9) { target } else { self.from + gone.copysign(whole) }
    }

    /// Whether it stands within `reach` of `at`, or is about to come to stand there.
    pub(crate) fn stands_at(&self, now: Tick, at: f64, reach: f64) -> bool {
        let near = |position: f64| (position - at).abs() <= reach;
        near(self.position(now)) && self.travel.is_none_or(|travel| near(travel.target))
    }

    /// Changes what it does, from where it is at `now`.
    pub(crate) fn change(&mut self, now: Tick, travel: Option<Travel>) {
        *self = AxisState { since: now, from: self.position(now), travel };
    }

    /// When it reaches its target; `None` if it stands.
    pub(crate) fn arrival(&self) -> Option<Tick> {
        self.travel.map(|travel| self.first_tick(travel.target))
    }

    /// The moments at which it may pass into or out of reach of `at`: `reach` before and after it.
    ///
    /// Each is given with its two neighbours, because the exact crossing falls between two ticks; the caller checks all
    /// of them.
    pub(crate) fn crossings(&self, at: f64, reach: f64) -> impl Iterator<Item = Tick> {
        let travel = self.travel;
        let edges = [at - reach, at + reach].into_iter().filter(move |edge| {
            travel.is_some_and(|t| (self.from.min(t.target)..=self.from.max(t.target)).contains(edge))
        });
        edges.flat_map(|edge| {
            let tick = self.first_tick(edge);
            let step = Duration::from_micros(1);
            [tick - step, tick, tick + step]
        })
    }

    /// The first tick at which it has covered the way to `position`; at least one after it set off.
    fn first_tick(&self, position: f64) -> Tick {
        let speed = self.travel.map_or(1.0, |t| t.speed);
        let micros = ((position - self.from).abs() / speed * (1.0 - 1e-9)).ceil();
        // A float cast saturates: a motion that takes longer than time itself arrives never.
        self.since + Duration::from_micros((micros as u64).max(1))
    }
}
