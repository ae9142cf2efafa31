//! Behaviour of the drive: transitions and their ramps, set-points, velocities, homing, and the statusword that shows
//! them.

use linewright_canopen::profile::drive::DriveState;
use linewright_canopen::profile::drive::word::{
    CHANGE_IMMEDIATELY, HALT, HOMING, NEW_SET_POINT, PROFILE_POSITION, PROFILE_VELOCITY, RELATIVE, ROTARY_NEGATIVE,
    ROTARY_POSITIVE, ROTARY_SHORTEST,
};
use linewright_line::Tick;

use super::machine::{leads_to, ordered};
use super::motion::{DriveMotion, Ramp};
use super::{DriveNode, MotionGoal, PROFILE_ERROR};
use crate::device::DeviceOutbox;

/// Progress of a homing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HomingPhase {
    /// Never begun, or interrupted.
    Idle,
    /// Fast, to the switch and past it.
    Seeking,
    /// Slowly, back to its edge.
    Returning,
    Attained,
    Failed,
}

impl DriveNode {
    /// Obeys the controlword: its transitions, then what its mode makes of it.
    pub(super) fn obey(&mut self, now: Tick, out: &mut DeviceOutbox) {
        let word = self.objects.u32(0x6040, 0) as u16;
        let before = std::mem::replace(&mut self.word, word);
        // "Switch on" and "enable operation" may come in one word.
        for _ in 0..2 {
            let stays = matches!(self.objects.i16(0x605A), 5..=8);
            match ordered(self.state, word, before, stays) {
                // A fault that lasts is not reset.
                Some(15) if self.broken => {}
                Some(transition) if self.pending != Some(transition) => self.order(now, transition, out),
                None if self.state == DriveState::OperationEnabled => self.pending = None,
                _ => {}
            }
        }
        self.change_mode(now);
        if self.state != DriveState::OperationEnabled || self.pending.is_some() {
            return;
        }
        match self.mode {
            PROFILE_POSITION => self.position(now, word, before),
            PROFILE_VELOCITY => self.velocity(now, word),
            HOMING => self.home(now, word, before),
            _ => {}
        }
    }

    /// Makes a transition, or begins the ramp that has to end first.
    fn order(&mut self, now: Tick, transition: u8, out: &mut DeviceOutbox) {
        let slow = self.objects.rate(0x6084, 0);
        let ramp_first = match transition {
            5 => self.objects.i16(0x605C) == 1,
            8 => self.objects.i16(0x605B) == 1,
            _ => false,
        };
        if ramp_first && !self.motion.stands(now) && self.blocked.is_none() {
            self.motion.stop(now, slow);
            self.pending = Some(transition);
            return;
        }
        self.pending = None;
        self.enter(now, transition, out);
        if transition == 11 {
            match self.objects.i16(0x605A) {
                1 | 5 => self.brake(now, slow),
                2 | 3 | 4 | 6 | 7 | 8 => self.brake(now, self.objects.rate(0x6085, 0)),
                _ => self.power_off(now),
            }
            if !matches!(self.objects.i16(0x605A), 5..=8) {
                self.pending = Some(12);
            }
        }
    }

    /// Enters the state a transition leads to.
    pub(super) fn enter(&mut self, now: Tick, transition: u8, out: &mut DeviceOutbox) {
        self.state = leads_to(transition);
        match transition {
            4 | 16 => {
                self.halted = false;
                self.running = 0;
            }
            5 | 8 | 9 | 12 => self.power_off(now),
            15 => {
                self.objects.set(0x603F, 0, 0);
                self.comm.report(0, 0, out);
            }
            _ => {}
        }
        if self.state != DriveState::OperationEnabled {
            self.forget();
        }
    }

    /// A fault: transition 13, its reaction, and 14 when it stands.
    pub(super) fn trip(&mut self, now: Tick, code: u16, out: &mut DeviceOutbox) {
        if matches!(self.state, DriveState::FaultReactionActive | DriveState::Fault) {
            return;
        }
        self.objects.set(0x603F, 0, code.into());
        self.comm.report(code, PROFILE_ERROR, out);
        self.enter(now, 13, out);
        match self.objects.i16(0x605E) {
            1 => self.brake(now, self.objects.rate(0x6084, 0)),
            2 => self.brake(now, self.objects.rate(0x6085, 0)),
            _ => self.power_off(now),
        }
        self.pending = Some(14);
        if code == super::SENSOR_1 {
            self.homing = HomingPhase::Idle;
        }
    }

    /// Without power a brake falls in, as hard as the quick stop.
    pub(super) fn power_off(&mut self, now: Tick) {
        self.brake(now, self.objects.rate(0x6085, 0));
    }

    fn brake(&mut self, now: Tick, deceleration: f64) {
        match self.blocked {
            Some(place) => self.motion = DriveMotion::standing(now, place),
            None if !self.motion.stands(now) => self.motion.stop(now, deceleration),
            None => {}
        }
    }

    /// Commands do not outlast the state in which they are obeyed.
    fn forget(&mut self) {
        self.set_point = None;
        self.next_set_point = None;
        self.acknowledged = false;
        self.running = 0;
        if matches!(self.homing, HomingPhase::Seeking | HomingPhase::Returning) {
            self.homing = HomingPhase::Idle;
        }
    }

    /// Object 6060h, once the axis stands.
    fn change_mode(&mut self, now: Tick) {
        let wanted = self.objects.i8(0x6060);
        if wanted == self.mode {
            return;
        }
        if self.state == DriveState::OperationEnabled && !self.motion.stands(now) {
            return self.brake(now, self.objects.rate(0x6084, 0));
        }
        self.mode = wanted;
        self.forget();
    }

    fn ramp(&self) -> Ramp {
        Ramp {
            velocity: self.objects.rate(0x6081, 0),
            acceleration: self.objects.rate(0x6083, 0),
            deceleration: self.objects.rate(0x6084, 0),
        }
    }

    /// Option 605Dh.
    fn halt_ramp(&self) -> f64 {
        self.objects.rate(if self.objects.i16(0x605D) == 2 { 0x6085 } else { 0x6084 }, 0)
    }

    fn position(&mut self, now: Tick, word: u16, before: u16) {
        let mut go = false;
        if word & NEW_SET_POINT == 0 {
            self.acknowledged = self.next_set_point.is_some();
        } else if before & NEW_SET_POINT == 0 && !self.acknowledged {
            let target = self.objects.i32(0x607A);
            let base = self.next_set_point.or(self.set_point).unwrap_or_else(|| self.actual(now));
            let target = if word & RELATIVE != 0 { base.saturating_add(target) } else { target };
            let later = word & CHANGE_IMMEDIATELY == 0 && self.set_point.is_some() && !self.motion.stands(now);
            if later {
                self.next_set_point = Some(target);
            } else {
                self.set_point = Some(target);
                self.next_set_point = None;
                go = true;
            }
            self.acknowledged = true;
        }
        let halt = word & HALT != 0;
        if halt && !self.halted {
            self.brake(now, self.halt_ramp());
        }
        go |= self.halted && !halt;
        self.halted = halt;
        if let Some(target) = self.set_point.filter(|_| go && !halt) {
            let ramp = self.ramp();
            self.aim(now, MotionGoal::Value(target));
            self.motion.go_to(now, self.place_of(now, target), ramp);
        }
    }

    /// Where a target lies. On an axis that turns endlessly it lies everywhere, a turn apart: object 60F2h says which is meant.
    fn place_of(&self, now: Tick, target: i32) -> f64 {
        let Some((_, turn)) = self.objects.range() else { return self.origin + f64::from(target) };
        let (here, actual) = (self.place(now), f64::from(self.actual(now)));
        let up = (f64::from(target) - actual).rem_euclid(turn);
        let down = if up > 0.0 { up - turn } else { 0.0 };
        let way = match self.objects.u32(0x60F2, 0) as u16 & ROTARY_SHORTEST {
            ROTARY_POSITIVE => up,
            ROTARY_NEGATIVE => down,
            ROTARY_SHORTEST => {
                if up <= -down {
                    up
                } else {
                    down
                }
            }
            // Like an axis with ends.
            _ => f64::from(target) - actual,
        };
        // Not the rounded position that it reports: it ends where the target is.
        let end = here + way;
        let off = (end - self.origin - f64::from(target)).rem_euclid(turn);
        end - if off > turn / 2.0 { off - turn } else { off }
    }

    fn velocity(&mut self, now: Tick, word: u16) {
        self.halted = word & HALT != 0;
        let wanted = if self.halted { 0 } else { self.objects.i32(0x60FF) };
        if wanted != self.running {
            self.running = wanted;
            let mut ramp = self.ramp();
            if self.halted {
                ramp.deceleration = self.halt_ramp();
            }
            self.aim(now, MotionGoal::Value(wanted));
            self.motion.run(now, wanted.into(), ramp);
        }
    }

    fn home(&mut self, now: Tick, word: u16, before: u16) {
        let start = word & NEW_SET_POINT != 0 && word & HALT == 0;
        let under_way = matches!(self.homing, HomingPhase::Seeking | HomingPhase::Returning);
        if under_way && !start {
            self.brake(now, self.halt_ramp());
            self.homing = HomingPhase::Idle;
        } else if start && before & NEW_SET_POINT == 0 {
            // The sign of the way to the switch at the mechanical zero.
            let sign = match self.objects.i8(0x6098) {
                1 | 17 => -1.0,
                2 | 18 => 1.0,
                35 | 37 => return self.found_zero(now),
                _ => return self.homing = HomingPhase::Failed,
            };
            let ramp = self.homing_ramp(1);
            self.aim(now, MotionGoal::Home);
            let past = sign * ramp.velocity * ramp.velocity / (2.0 * ramp.deceleration);
            self.reference = match self.objects.range() {
                // The next time it comes by.
                Some((_, turn)) if sign < 0.0 => (self.place(now) / turn).floor() * turn,
                Some((_, turn)) => (self.place(now) / turn).ceil() * turn,
                None => 0.0,
            };
            self.motion.go_to(now, self.reference + past, ramp);
            self.homing = HomingPhase::Seeking;
        }
    }

    fn homing_ramp(&self, sub: u8) -> Ramp {
        let acceleration = self.objects.rate(0x609A, 0);
        Ramp { velocity: self.objects.rate(0x6099, sub), acceleration, deceleration: acceleration }
    }

    fn found_zero(&mut self, now: Tick) {
        self.origin = self.place(now) - f64::from(self.objects.i32(0x607C));
        self.homing = HomingPhase::Attained;
    }

    /// Next step after the end of a motion.
    pub(super) fn move_on(&mut self, now: Tick) {
        if !self.motion.stands(now) || self.blocked.is_some() {
            return;
        }
        match self.homing {
            HomingPhase::Seeking => {
                let ramp = self.homing_ramp(2);
                self.motion.go_to(now, self.reference, ramp);
                self.homing = HomingPhase::Returning;
            }
            HomingPhase::Returning => self.found_zero(now),
            HomingPhase::Idle | HomingPhase::Attained | HomingPhase::Failed => {}
        }
        if let Some(target) = self.next_set_point.take() {
            self.set_point = Some(target);
            self.acknowledged = self.word & NEW_SET_POINT != 0;
            let ramp = self.ramp();
            self.aim(now, MotionGoal::Value(target));
            self.motion.go_to(now, self.place_of(now, target), ramp);
        }
        self.change_mode(now);
    }

    /// Its position by its own zero. A float cast saturates.
    pub(super) fn actual(&self, now: Tick) -> i32 {
        let actual = (self.place(now) - self.origin).round();
        match self.objects.range() {
            Some((least, turn)) => ((actual - least).rem_euclid(turn) + least) as i32,
            None => actual as i32,
        }
    }

    /// How far a target is away, whichever way.
    fn distance_to(&self, now: Tick, target: i32) -> u32 {
        let way = target.abs_diff(self.actual(now));
        self.objects.range().map_or(way, |(_, turn)| way.min((turn as u32).saturating_sub(way)))
    }

    pub(super) fn window_time(&self) -> std::time::Duration {
        std::time::Duration::from_millis(self.objects.u32(0x6068, 0).into())
    }

    /// Puts its feedback into its objects.
    pub(super) fn send(&mut self, now: Tick) {
        let word = self.statusword(now);
        self.objects.set(0x6041, 0, word.into());
        self.objects.set(0x6061, 0, u32::from(self.mode as u8));
        self.objects.set(0x6064, 0, self.actual(now) as u32);
        self.objects.set(0x606C, 0, self.speed(now).round() as i32 as u32);
    }

    fn statusword(&self, now: Tick) -> u16 {
        // Voltage enabled, remote.
        let mut word = self.state.bits() | 0x0210;
        let stands = self.motion.stands(now);
        let (reached, special, trouble) = match self.mode {
            PROFILE_POSITION => (
                self.reached(now),
                self.acknowledged,
                self.lagging.is_some() && self.state == DriveState::OperationEnabled,
            ),
            PROFILE_VELOCITY => {
                let off = (self.speed(now) - f64::from(self.running)).abs();
                (off <= f64::from(self.objects.u32(0x606D, 0)), self.speed(now) == 0.0, false)
            }
            HOMING => {
                let under_way = matches!(self.homing, HomingPhase::Seeking | HomingPhase::Returning);
                (!under_way && stands, self.homing == HomingPhase::Attained, self.homing == HomingPhase::Failed)
            }
            _ => (false, false, false),
        };
        for (is_on, bit) in [(reached, 10), (special, 12), (trouble, 13)] {
            word |= u16::from(is_on) << bit;
        }
        word
    }

    /// It stands, for long enough, at its target; halted: it stands.
    fn reached(&self, now: Tick) -> bool {
        if self.halted {
            return self.motion.stands(now);
        }
        let settled = self.motion.stands_at().is_some_and(|at| at + self.window_time() <= now);
        let window = self.objects.u32(0x6067, 0);
        settled && self.set_point.is_none_or(|target| self.distance_to(now, target) <= window)
    }
}
