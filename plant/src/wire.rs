//! A bad line to one device: frames that are lost on the way, and frames that come twice.
//!
//! A CAN controller repeats a frame until everybody has it, so a real bus loses frames elsewhere: in a receiver that
//! has no room, behind a bridge, in an interface that is restarted. A frame comes twice if only its sender missed the
//! acknowledgement (CiA 301 builds on no frame coming once). Both are drawn from a seed, so what happened once happens
//! again.

use linewright_random::mix;

use crate::fault::{ObjectWrites, TROUBLE_INDEX};

/// How bad the line of one device is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameFaults {
    /// Of a thousand frames, how many do not come to the device.
    pub lost_to: u16,
    /// Of a thousand that it sends, how many come to nobody.
    pub lost_from: u16,
    /// Of a thousand in either direction, how many come twice.
    pub doubled: u16,
    /// What is drawn follows from it.
    pub seed: u64,
}

impl FrameFaults {
    /// What is written to a device to make its line this bad. Of the seed the device takes the lower 32 bits.
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

    /// How often a frame comes to the device.
    pub(crate) fn towards(&mut self) -> usize {
        self.times(self.faults.lost_to)
    }

    /// How often a frame of the device comes to the others.
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
