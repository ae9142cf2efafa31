//! Fingerprint of a description: equal where every node of the line does the same by it.
//!
//! It is taken of the checked model and not of the text. Comments, the order of keys, defaults that are written out and station
//! types that are written out change nothing; every number, name and reference of the model does, also those that only the
//! simulated plant uses, and what the devices' own files add. Titles, and the reasons given for conflicts, are for people and
//! are left out.
//!
//! The derived form of the model's types is summed, so no field can be forgotten. Another version of the program may have other
//! fields, and then another fingerprint: all nodes of a line are of one version.

use std::fmt::{self, Write as _};

use crate::Line;

/// FNV-1a of 64 bits, which is short, and the same everywhere and for ever.
#[derive(Clone, Debug)]
pub struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Fnv(0xCBF2_9CE4_8422_2325)
    }
}

impl Fnv {
    pub fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3);
        }
    }

    pub fn number(&mut self, number: u64) {
        self.bytes(&number.to_le_bytes());
    }

    /// With its length, so that two texts never look like two others.
    pub fn text(&mut self, text: &str) {
        self.number(text.len() as u64);
        self.bytes(text.as_bytes());
    }

    /// The derived form of a value.
    pub fn debug(&mut self, value: &impl fmt::Debug) {
        // Writing into a sum does not fail, nor does a derived form.
        let _ = write!(self, "{value:?}");
    }

    pub fn sum(&self) -> u64 {
        self.0
    }
}

impl fmt::Write for Fnv {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.bytes(text.as_bytes());
        Ok(())
    }
}

impl Line {
    /// Equal for descriptions by which the nodes do the same; otherwise different, except in one case in 2⁶⁴.
    pub fn fingerprint(&self) -> u64 {
        let mut line = self.clone();
        line.title.clear();
        line.stations.iter_mut().for_each(|station| station.title.clear());
        line.conflicts.iter_mut().for_each(|conflict| conflict.why.clear());
        let mut sum = Fnv::default();
        sum.debug(&line);
        sum.sum()
    }
}
