//! A station behind the gateway: inputs sent to it, and outputs put on the bus for it.
//!
//! Only what was sent last is kept here, so that nothing is sent twice. [`Gateway`] decides which outputs may be in
//! force.

use linewright_coordinator_logic::{AppliedImage, Gateway};
use linewright_line::{Line, NumberedOrder, StationId, Tick};
use linewright_station_shell::NewestBySequence;

use crate::effect::{CoordinatorEffect, InputsImage};

/// The emergency stop, as the gateway sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum GatewayStop {
    /// Nothing is put out.
    InForce,
    /// The epoch of the last one: only images decided in it or later are put out.
    Since(u64),
}

/// A station behind the gateway.
#[derive(Clone, Debug)]
pub(crate) struct GatewayStation {
    pub station: StationId,
    /// Outputs of which several are one order.
    orders_by_number: Vec<NumberedOrder>,
    /// Its newest output image by sequence.
    pub newest: NewestBySequence,
    /// Input bits, whether they are valid, and how often its devices have been lost.
    pub devices: (u128, bool, u64),
    /// Outputs last given to the bus, and in which life of the devices.
    put: Option<(u128, u64)>,
    /// Outputs on the bus if those were not put out.
    on_bus: u128,
    /// Inputs last sent to the station.
    sent: Option<InputsImage>,
}

impl GatewayStation {
    pub(crate) fn new(line: &Line, station: StationId) -> Self {
        GatewayStation {
            station,
            orders_by_number: line.numbered_orders(station),
            newest: NewestBySequence::new(line.timing.stale),
            devices: (0, false, 0),
            put: None,
            on_bus: 0,
            sent: None,
        }
    }

    /// Gives everything again.
    pub(crate) fn forget(&mut self) {
        (self.put, self.sent) = (None, None);
    }

    /// Takes outputs off the bus that are not to be on any more, before a record that may take long. `life` is the
    /// coordinator's.
    pub(crate) fn take_off(
        &mut self,
        now: Tick,
        gateway: &Gateway,
        (life, stop): (u64, GatewayStop),
        effects: &mut Vec<CoordinatorEffect>,
    ) {
        self.performed();
        let staying = self.staying(self.in_force(now, gateway, self.lives(life), stop).bits);
        if staying != self.on_bus {
            self.on_bus = staying;
            if let Some((put, _)) = &mut self.put {
                *put = staying;
            }
            effects.push(CoordinatorEffect::Energise(self.station, staying));
        }
    }

    /// The outputs on the bus that stay on in another image.
    fn staying(&self, next: u128) -> u128 {
        NumberedOrder::staying(&self.orders_by_number, self.on_bus, next)
    }

    /// Leaves only these bits on the bus; nothing if those are all that is on it. The next step gives outputs anew.
    pub(crate) fn keep_only(&mut self, bits: u128) -> Option<u128> {
        let staying = self.staying(bits);
        if staying == self.on_bus {
            return None;
        }
        self.on_bus = staying;
        self.put = None;
        Some(staying)
    }

    /// Outputs given in an earlier step are on the bus: had they not been put out, [`GatewayStation::forget`] would have cleared them.
    fn performed(&mut self) {
        if let Some((put, _)) = self.put {
            self.on_bus = put;
        }
    }

    fn in_force(&self, now: Tick, gateway: &Gateway, lives: u64, stop: GatewayStop) -> AppliedImage {
        match stop {
            GatewayStop::InForce => AppliedImage::default(),
            GatewayStop::Since(epoch) => gateway.in_force(now, self.station, lives, epoch),
        }
    }

    /// Losses that a predecessor counted, which a station may still have in its last image, are other ones.
    fn lives(&self, life: u64) -> u64 {
        life.rotate_left(32).wrapping_add(self.devices.2)
    }

    /// Brings outputs and inputs up to `now`. `life` is the coordinator's.
    pub(crate) fn act(
        &mut self,
        now: Tick,
        gateway: &Gateway,
        (life, sequence): (u64, &mut u64),
        (stop, is_due): (GatewayStop, bool),
        effects: &mut Vec<CoordinatorEffect>,
    ) {
        self.performed();
        let (bits, valid, _) = self.devices;
        let lives = self.lives(life);
        let in_force = self.in_force(now, gateway, lives, stop);
        // After a loss the bus has no outputs any more, so they are given again.
        if self.put.replace((in_force.bits, lives)) != Some((in_force.bits, lives)) {
            effects.push(CoordinatorEffect::Energise(self.station, in_force.bits));
        }
        let image = InputsImage { bits, valid, lives, under: in_force.image };
        if self.sent.replace(image) != Some(image) || is_due {
            *sequence += 1;
            effects.push(CoordinatorEffect::Inputs { station: self.station, sequence: *sequence, image });
        }
    }
}
