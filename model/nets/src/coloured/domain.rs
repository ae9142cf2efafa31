//! Colours: basic domains as rings, and products of them.
//!
//! A basic domain has the tones 1 to s; counting on from s leads to 1 again (seed 000, definition 18). A colour is a
//! tuple of tones, one for each component of its domain. The uncoloured token <•> is the empty tuple: the source writes
//! it as a last component that every domain has, and a component with one value distinguishes nothing.
//!
//! Outside, tones count from 1 as in the source. Inside, a colour is one number, its position among the colours of its
//! domain in lexical order, so that markings are compared as plain numbers.

use std::borrow::Cow;
use std::sync::Arc;

/// A basic domain of a net, numbered in the order of declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BasicId(pub u32);

impl BasicId {
    /// The position in tables that have one entry per basic domain.
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// A basic domain Ω_j: the tones 1 to s, a ring modulo s (seed 000, definition 18).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BasicDomain {
    pub(super) name: Arc<str>,
    pub(super) size: u32,
    /// The names of the tones, in order; empty if they go by their numbers.
    pub(super) tones: Vec<Arc<str>>,
}

impl BasicDomain {
    pub fn name(&self) -> &str {
        &self.name
    }

    /// s: how many tones there are; at least one.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// Name of a tone (from 1): its name, or its number.
    pub fn tone_name(&self, tone: u32) -> Cow<'_, str> {
        let at = (tone as usize).wrapping_sub(1);
        self.tones.get(at).map_or_else(|| tone.to_string().into(), |name| Cow::Borrowed(&**name))
    }

    /// The tone of that name or number.
    pub fn tone_named(&self, name: &str) -> Option<u32> {
        if self.tones.is_empty() {
            return name.parse().ok().filter(|tone| (1..=self.size).contains(tone));
        }
        self.tones.iter().zip(1..).find(|(known, _)| &***known == name).map(|(_, tone)| tone)
    }
}

/// The domain of a place or of a transition, as it is declared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Domain {
    /// {<•>}: tokens are all alike.
    Uncoloured,
    /// A basic domain, or the product of several (seed 000, definition 19). A basic domain may occur more than once.
    Product(Vec<BasicId>),
    /// Ω*: the product of all basic domains of the net, in the order of declaration (seed 000, definition 20). A
    /// transition gets those components of it that its arcs and its guard use; the others would only multiply its modes.
    Universal,
}

impl From<BasicId> for Domain {
    fn from(basic: BasicId) -> Domain {
        Domain::Product(vec![basic])
    }
}

impl<const N: usize> From<[BasicId; N]> for Domain {
    fn from(basics: [BasicId; N]) -> Domain {
        Domain::Product(basics.to_vec())
    }
}

impl From<Vec<BasicId>> for Domain {
    fn from(basics: Vec<BasicId>) -> Domain {
        Domain::Product(basics)
    }
}

/// A domain with its sizes: what turns tuples of tones (from 0 here) into positions and back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct DomainShape {
    pub(super) basics: Box<[BasicId]>,
    pub(super) sizes: Box<[u32]>,
    /// Number of colours.
    pub(super) count: u32,
}

impl DomainShape {
    /// None if there are more colours than 32 bits can number.
    pub(super) fn new(basics: &[BasicId], all: &[BasicDomain]) -> Option<DomainShape> {
        let sizes: Box<[u32]> = basics.iter().map(|basic| all[basic.index()].size).collect();
        let count = sizes.iter().try_fold(1_u32, |count, &size| count.checked_mul(size))?;
        Some(DomainShape { basics: basics.into(), sizes, count })
    }

    /// The position of a tuple.
    pub(super) fn encode(&self, tones: &[u32]) -> u32 {
        tones.iter().zip(&self.sizes).fold(0, |position, (&tone, &size)| position * size + tone)
    }

    /// The tuple at a position.
    pub(super) fn decode(&self, mut position: u32, tones: &mut [u32]) {
        for (tone, &size) in tones.iter_mut().zip(&self.sizes).rev() {
            *tone = position % size;
            position /= size;
        }
    }

    /// The tuple at a position, with tones from 1.
    pub(super) fn tones(&self, position: u32) -> Vec<u32> {
        let mut tones = vec![0; self.sizes.len()];
        self.decode(position, &mut tones);
        tones.iter_mut().for_each(|tone| *tone += 1);
        tones
    }

    /// The position of a tuple with tones from 1, if it is one of this domain.
    pub(super) fn position(&self, tones: &[u32]) -> Option<u32> {
        let fits = tones.len() == self.sizes.len()
            && tones.iter().zip(&self.sizes).all(|(&tone, &size)| (1..=size).contains(&tone));
        fits.then(|| tones.iter().zip(&self.sizes).fold(0, |position, (&tone, &size)| position * size + (tone - 1)))
    }

    /// A colour in words: "<m2,p3>", or nothing for the uncoloured.
    pub(super) fn show(&self, position: u32, all: &[BasicDomain]) -> String {
        if self.basics.is_empty() {
            return String::new();
        }
        let tones = self.tones(position);
        let names = self.basics.iter().zip(&tones).map(|(basic, &tone)| all[basic.index()].tone_name(tone));
        format!("<{}>", names.collect::<Vec<_>>().join(","))
    }
}

/// A domain in words: "M*P", or "<•>".
pub(super) fn show_domain(basics: &[BasicId], all: &[BasicDomain]) -> String {
    if basics.is_empty() {
        return "<•>".to_owned();
    }
    let name = |basic: &BasicId| all.get(basic.index()).map_or("?", |basic| basic.name());
    basics.iter().map(name).collect::<Vec<_>>().join("*")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_in_lexical_order_and_lead_back() {
        let basic = |name: &str, size| BasicDomain { name: name.into(), size, tones: Vec::new() };
        let all = [basic("A", 2), basic("B", 3)];
        let shape = DomainShape::new(&[BasicId(1), BasicId(0), BasicId(1)], &all).unwrap();
        let mut tuples: Vec<Vec<u32>> = (0..shape.count).map(|position| shape.tones(position)).collect();
        assert_eq!(tuples.len(), 18);
        assert!(tuples.iter().zip(0..).all(|(tuple, position)| shape.position(tuple) == Some(position)));
        assert!(tuples.is_sorted());
        tuples.dedup();
        assert_eq!(tuples.len(), 18);
        assert_eq!(shape.position(&[4, 1, 1]), None);
        assert_eq!(shape.position(&[0, 1, 1]), None);
        assert_eq!(shape.position(&[1, 1]), None);
        assert_eq!(shape.show(17, &all), "<3,2,3>");
    }

    #[test]
    fn a_domain_that_cannot_be_numbered_has_no_shape() {
        let all = [BasicDomain { name: "A".into(), size: 1 << 16, tones: Vec::new() }];
        assert!(DomainShape::new(&[BasicId(0)], &all).is_some());
        assert!(DomainShape::new(&[BasicId(0), BasicId(0)], &all).is_none());
    }

    #[test]
    fn tones_go_by_name_or_by_number() {
        let named = BasicDomain { name: "M".into(), size: 2, tones: vec!["robot".into(), "human".into()] };
        assert_eq!((named.tone_named("human"), named.tone_named("2"), &*named.tone_name(1)), (Some(2), None, "robot"));
        let plain = BasicDomain { name: "P".into(), size: 3, tones: Vec::new() };
        assert_eq!((plain.tone_named("3"), plain.tone_named("4"), plain.tone_named("0")), (Some(3), None, None));
    }
}
