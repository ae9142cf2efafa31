//! Position of an axis: ramps, worked out once when a motion begins.
//!
//! A position is computed from the moment its motion began, never from the last query. Lengths are increments, speeds
//! increments per second; between two changes the axis moves on at most five pieces of constant acceleration.

use std::time::Duration;

use linewright_line::Tick;

/// A piece of constant acceleration, from `start` seconds after the motion began.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ConstantAcceleration {
    start: f64,
    position: f64,
    velocity: f64,
    acceleration: f64,
}

/// Velocity and accelerations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ramp {
    pub velocity: f64,
    pub acceleration: f64,
    pub deceleration: f64,
}

/// An axis: since when it does what.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DriveMotion {
    since: Tick,
    /// Never empty; the last one has no acceleration and goes on for ever.
    pieces: Vec<ConstantAcceleration>,
}

impl DriveMotion {
    pub fn standing(now: Tick, position: f64) -> Self {
        DriveMotion {
            since: now,
            pieces: vec![ConstantAcceleration { start: 0.0, position, velocity: 0.0, acceleration: 0.0 }],
        }
    }

    pub fn position(&self, now: Tick) -> f64 {
        let (piece, t) = self.piece(now);
        piece.position + piece.velocity * t + piece.acceleration * t * t / 2.0
    }

    pub fn velocity(&self, now: Tick) -> f64 {
        let (piece, t) = self.piece(now);
        piece.velocity + piece.acceleration * t
    }

    /// When it stands, for good; `None` if it never does.
    pub fn stands_at(&self) -> Option<Tick> {
        let last = self.last();
        (last.velocity == 0.0).then(|| self.since + Duration::from_micros((last.start * 1e6).ceil() as u64))
    }

    pub fn stands(&self, now: Tick) -> bool {
        self.stands_at().is_some_and(|at| at <= now)
    }

    /// From what it does now to standing at `target`.
    pub fn go_to(&mut self, now: Tick, target: f64, ramp: Ramp) {
        let mut plan = MotionProfile::from(self, now);
        let way = target - plan.position;
        let braking = plan.velocity * plan.velocity / (2.0 * ramp.deceleration);
        if plan.velocity * way < 0.0 || braking > way.abs() {
            plan.change_to(0.0, ramp.deceleration);
        }
        plan.approach(target, ramp);
        *self = plan.finish(now, target);
    }

    /// From what it does now to this velocity.
    pub fn run(&mut self, now: Tick, velocity: f64, ramp: Ramp) {
        let mut plan = MotionProfile::from(self, now);
        if plan.velocity * velocity < 0.0 {
            plan.change_to(0.0, ramp.deceleration);
        }
        let slower = velocity.abs() < plan.velocity.abs();
        plan.change_to(velocity, if slower { ramp.deceleration } else { ramp.acceleration });
        let position = plan.position;
        *self = plan.finish(now, position);
    }

    pub fn stop(&mut self, now: Tick, deceleration: f64) {
        self.run(now, 0.0, Ramp { velocity: 0.0, acceleration: deceleration, deceleration });
    }

    fn last(&self) -> ConstantAcceleration {
        self.pieces[self.pieces.len() - 1]
    }

    fn piece(&self, now: Tick) -> (ConstantAcceleration, f64) {
        let t = now.since(self.since).as_secs_f64();
        let at = self.pieces.partition_point(|piece| piece.start <= t).max(1) - 1;
        let piece = self.pieces[at];
        (piece, (t - piece.start).max(0.0))
    }
}

struct MotionProfile {
    pieces: Vec<ConstantAcceleration>,
    time: f64,
    position: f64,
    velocity: f64,
}

impl MotionProfile {
    fn from(motion: &DriveMotion, now: Tick) -> Self {
        MotionProfile { pieces: Vec::new(), time: 0.0, position: motion.position(now), velocity: motion.velocity(now) }
    }

    fn push(&mut self, acceleration: f64, time: f64) {
        let (start, position, velocity) = (self.time, self.position, self.velocity);
        if time > 0.0 {
            self.pieces.push(ConstantAcceleration { start, position, velocity, acceleration });
            self.time += time;
            self.position += velocity * time + acceleration * time * time / 2.0;
            self.velocity += acceleration * time;
        }
    }

    fn change_to(&mut self, velocity: f64, rate: f64) {
        let change = velocity - self.velocity;
        self.push(rate.copysign(change), change.abs() / rate);
        // A rounding remainder is not a velocity.
        self.velocity = velocity;
    }

    /// To standing at `target`, which is ahead no nearer than it can stop.
    fn approach(&mut self, target: f64, ramp: Ramp) {
        let way = (target - self.position).abs();
        let sign = (target - self.position).signum();
        let (a, d, v) = (ramp.acceleration, ramp.deceleration, self.velocity.abs());
        let peak = ((2.0 * a * d * way + d * v * v) / (a + d)).sqrt().min(ramp.velocity);
        self.change_to(sign * peak, if peak < v { d } else { a });
        let left = (target - self.position).abs() - peak * peak / (2.0 * d);
        if peak > 0.0 {
            self.push(0.0, left / peak);
        }
        self.change_to(0.0, d);
    }

    fn finish(mut self, now: Tick, position: f64) -> DriveMotion {
        let last = ConstantAcceleration { start: self.time, position, velocity: self.velocity, acceleration: 0.0 };
        self.pieces.push(last);
        DriveMotion { since: now, pieces: self.pieces }
    }
}
