//! A bad line to one device: frames that are lost on the way, and frames that come twice.
//!
//! A CAN controller repeats a frame until all nodes have it, so a real bus loses frames elsewhere: in a receiver that
//! has no room, behind a bridge, in an interface that is restarted. A frame comes twice if only its sender missed the
//! acknowledgement (CiA 301 builds on no frame coming once). Both are drawn from a seed, so a sequence can be repeated.

use linewright_random::mix;

use crate::fault::{ObjectWrites, TROUBLE_INDEX};

/// Faults of the line of one device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameFaults {
    /// Of a thousand frames to the device, number lost.
    pub lost_to: u16,
    /// Of a thousand frames from the device, number lost.
    pub lost_from: u16,
    /// Of a thousand in either direction, number doubled.
    pub doubled: u16,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl FrameFaults {
    /// Writes to a device for these faults. Of the seed the device takes the lower 32 bits.
    pub fn orders(self) -> ObjectWrites {
        let shares = [(7, self.lost_to), (8, self.lost_from), (9, self.doubled)];
        let shares = shares.into_iter().map(|(sub, share)| ((TROUBLE_INDEX, sub), share.into()));
        shares.chain([((TROUBLE_INDEX, 10), self.seed as u32)]).collect()
    }
}

/// The line of one device.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FaultyWire {
    faults: FrameFaults,
    drawn: u64,
}

impl FaultyWire {
    pub(crate) fn new(faults: FrameFaults) -> Self {
        FaultyWire { faults, drawn: 0 }
    }

    /// Number of times a frame reaches the device.
    pub(crate) fn towards(&mut self) -> usize {
        self.times(self.faults.lost_to)
    }

    /// Number of times a frame of the device reaches the others.
    pub(crate) fn away(&mut self) -> usize {
        self.times(self.faults.lost_from)
    }

    fn times(&mut self, lost: u16) -> usize {
        if lost == 0 && self.faults.doubled == 0 {
            return 1;
        }
        self.drawn += 1;
        let chance = mix(self.faults.seed ^ mix(self.drawn)) % 1000;
        let (lost, doubled) = (u64::from(lost), u64::from(self.faults.doubled));
        match chance {
            chance if chance < lost => 0,
            chance if chance < lost + doubled => 2,
            _ => 1,
        }
    }
}
