//! Random coloured nets as plain data, and a slow twin that plays them on tuples.
//!
//! The twin shares neither the crate's numbering nor its normal form of functions nor its search for modes. It walks
//! over every colour of the declared domain, evaluates functions step by step on tuples, and keeps bags in maps.

use std::collections::BTreeMap;

use linewright_nets::coloured::{
    BasicId, Clause, ColouredBuilder, ColouredNet, Comparison, Domain, Function, Guard, abs, compare, component, id,
    pred, proj, ring, succ,
};
use linewright_random::Random;

pub type Tuple = Vec<u32>;
pub type Bag = BTreeMap<Tuple, i64>;
/// Tokens by place and colour.
pub type Marked = BTreeMap<(usize, Tuple), i64>;

/// A function, as a tree.
#[derive(Clone, Debug)]
pub enum Fun {
    Id,
    Abs,
    Proj(Vec<u32>),
    Succ(u32, u32),
    Pred(u32, u32),
    Ring(u32),
    /// The second one first.
    After(Box<Fun>, Box<Fun>),
    Times(i64, Box<Fun>),
    Sum(Vec<Fun>),
}

impl Fun {
    /// The same for the crate.
    pub fn real(&self) -> Function {
        match self {
            Fun::Id => id(),
            Fun::Abs => abs(),
            Fun::Proj(components) => proj(components.iter().copied()),
            Fun::Succ(k, x) => succ(*k, *x),
            Fun::Pred(k, x) => pred(*k, *x),
            Fun::Ring(k) => ring(*k),
            Fun::After(last, first) => last.real().of(first.real()),
            Fun::Times(n, f) => *n * f.real(),
            Fun::Sum(all) => all.iter().map(Fun::real).reduce(|a, b| a + b).expect("sums are not empty"),
        }
    }

    /// The bag for one tuple; `sizes` are those of its components, and come back as those of the result.
    pub fn apply(&self, tuple: &[u32], sizes: &[u32]) -> (Bag, Vec<u32>) {
        let one = |tuple: Tuple, sizes: Vec<u32>| (BTreeMap::from([(tuple, 1)]), sizes);
        let moved = |k: u32, by: i64| {
            let (mut tuple, k) = (tuple.to_vec(), k as usize - 1);
            tuple[k] = ((i64::from(tuple[k]) - 1 + by).rem_euclid(sizes[k].into()) + 1) as u32;
            tuple
        };
        match self {
            Fun::Id => one(tuple.to_vec(), sizes.to_vec()),
            Fun::Abs => one(vec![], vec![]),
            Fun::Proj(ks) => {
                let of = |from: &[u32]| ks.iter().map(|&k| from[k as usize - 1]).collect();
                one(of(tuple), of(sizes))
            }
            Fun::Succ(k, x) => one(moved(*k, (*x).into()), sizes.to_vec()),
            Fun::Pred(k, x) => one(moved(*k, -i64::from(*x)), sizes.to_vec()),
            Fun::Ring(k) => {
                let all = (0..sizes[*k as usize - 1]).map(|x| (moved(*k, x.into()), 1));
                (all.collect(), sizes.to_vec())
            }
            Fun::After(last, first) => {
                let (inner, between) = first.apply(tuple, sizes);
                let (mut bag, mut ends) = (Bag::new(), last.apply(&vec![1; between.len()], &between).1);
                for (tuple, n) in inner {
                    let (outer, end) = last.apply(&tuple, &between);
                    ends = end;
                    outer.into_iter().for_each(|(tuple, m)| *bag.entry(tuple).or_default() += n * m);
                }
                (bag, ends)
            }
            Fun::Times(n, f) => {
                let (bag, ends) = f.apply(tuple, sizes);
                (bag.into_iter().map(|(tuple, m)| (tuple, n * m)).collect(), ends)
            }
            Fun::Sum(all) => {
                let mut bag = Bag::new();
                let mut ends = vec![];
                for f in all {
                    let (more, end) = f.apply(tuple, sizes);
                    ends = end;
                    more.into_iter().for_each(|(tuple, m)| *bag.entry(tuple).or_default() += m);
                }
                (bag, ends)
            }
        }
    }
}

/// A side of a comparison: a component with a shift, or a number.
#[derive(Clone, Debug)]
pub enum Side {
    Component(u32, i64),
    Number(i64),
}

type Comparisons = Vec<(Side, Comparison, Side)>;

/// A coloured net as plain data.
#[derive(Clone, Debug)]
pub struct Raw {
    pub sizes: Vec<u32>,
    pub places: Vec<Vec<usize>>,
    pub transitions: Vec<RawTransition>,
    pub tokens: Vec<(usize, Tuple, u32)>,
}

#[derive(Clone, Debug)]
pub struct RawTransition {
    /// None: universal.
    pub domain: Option<Vec<usize>>,
    pub inputs: BTreeMap<usize, Fun>,
    pub outputs: BTreeMap<usize, Fun>,
    pub guard: Option<Vec<Comparisons>>,
}

impl Raw {
    pub fn random(random: &mut Random) -> Raw {
        let sizes: Vec<u32> = (0..1 + random.below(3)).map(|_| 1 + random.below(3) as u32).collect();
        let places: Vec<Vec<usize>> = (0..1 + random.below(4)).map(|_| domain(random, sizes.len())).collect();
        let transitions = (0..1 + random.below(4)).map(|_| transition(random, &sizes, &places)).collect();
        let token = |random: &mut Random| {
            let place = random.below(places.len());
            let tones = places[place].iter().map(|&basic| 1 + random.below(sizes[basic] as usize) as u32).collect();
            (place, tones, 1 + random.below(2) as u32)
        };
        let tokens = (0..random.below(5)).map(|_| token(random)).collect();
        Raw { sizes, places, transitions, tokens }
    }

    pub fn build(&self) -> ColouredNet {
        let mut b = ColouredBuilder::new("random");
        let basics: Vec<BasicId> = (0..).zip(&self.sizes).map(|(i, &size)| b.basic(format!("B{i}"), size)).collect();
        let product = |domain: &[usize]| Domain::Product(domain.iter().map(|&basic| basics[basic]).collect());
        let places: Vec<_> = (0..).zip(&self.places).map(|(i, d)| b.place(format!("p{i}"), product(d))).collect();
        for (i, raw) in self.transitions.iter().enumerate() {
            let domain = raw.domain.as_ref().map_or(Domain::Universal, |domain| product(domain));
            let t = b.transition(format!("t{i}"), domain);
            raw.inputs.iter().for_each(|(&place, fun)| _ = b.input(t, places[place], fun.real()));
            raw.outputs.iter().for_each(|(&place, fun)| _ = b.output(t, places[place], fun.real()));
            if let Some(clauses) = &raw.guard {
                let side = |side: &Side| match *side {
                    Side::Component(k, by) if by < 0 => component(k).pred(by.unsigned_abs() as u32),
                    Side::Component(k, by) => component(k).succ(by as u32),
                    Side::Number(n) => linewright_nets::coloured::Operand::Number(n),
                };
                let atom = |(a, is, c): &(Side, Comparison, Side)| compare(side(a), *is, side(c));
                b.guard(t, Guard::any(clauses.iter().map(|clause| Clause::all(clause.iter().map(atom)))));
            }
        }
        self.tokens.iter().for_each(|(place, tones, n)| _ = b.tokens(places[*place], tones, *n));
        b.build().unwrap_or_else(|problems| panic!("{self:?} is refused: {problems:?}"))
    }

    /// The basic domains of a transition as declared.
    pub fn domain(&self, transition: usize) -> Vec<usize> {
        self.transitions[transition].domain.clone().unwrap_or_else(|| (0..self.sizes.len()).collect())
    }

    fn sizes_of(&self, domain: &[usize]) -> Vec<u32> {
        domain.iter().map(|&basic| self.sizes[basic]).collect()
    }

    /// M₀.
    pub fn start(&self) -> Marked {
        let mut marking = BTreeMap::new();
        for (place, tones, n) in &self.tokens {
            *marking.entry((*place, tones.clone())).or_default() += i64::from(*n);
        }
        marking
    }

    /// Successors of a marking: for each transition the markings after each of its modes, over all colours of the
    /// domain as declared, each different outcome once for every effect that a mode has.
    pub fn successors(&self, marking: &Marked, transition: usize) -> Vec<(Effect, Marked)> {
        let raw = &self.transitions[transition];
        let domain = self.domain(transition);
        let sizes = self.sizes_of(&domain);
        let mut found = Vec::new();
        for mode in tuples(&sizes) {
            if !raw.allows(&mode, &sizes) {
                continue;
            }
            let bag = |arcs: &BTreeMap<usize, Fun>| {
                let mut all = BTreeMap::new();
                for (&place, fun) in arcs {
                    for (tuple, n) in fun.apply(&mode, &sizes).0 {
                        *all.entry((place, tuple)).or_default() += n;
                    }
                }
                all
            };
            let (takes, gives): (Marked, _) = (bag(&raw.inputs), bag(&raw.outputs));
            if takes.iter().all(|(cell, n)| marking.get(cell).copied().unwrap_or(0) >= *n) {
                let mut after = marking.clone();
                takes.iter().for_each(|(cell, n)| *after.entry(cell.clone()).or_default() -= n);
                gives.iter().for_each(|(cell, n)| *after.entry(cell.clone()).or_default() += n);
                after.retain(|_, n| *n != 0);
                found.push(((mode, takes, gives), after));
            }
        }
        found
    }
}

/// A mode as declared, what it takes and what it gives.
pub type Effect = (Tuple, Marked, Marked);

impl RawTransition {
    fn allows(&self, mode: &[u32], sizes: &[u32]) -> bool {
        let value = |side: &Side| match *side {
            Side::Number(n) => n,
            Side::Component(k, by) => {
                let k = k as usize - 1;
                (i64::from(mode[k]) - 1 + by).rem_euclid(sizes[k].into()) + 1
            }
        };
        let holds = |(a, is, b): &(Side, Comparison, Side)| {
            let (a, b) = (value(a), value(b));
            match is {
                Comparison::Equal => a == b,
                Comparison::NotEqual => a != b,
                Comparison::Less => a < b,
                Comparison::LessOrEqual => a <= b,
                Comparison::Greater => a > b,
                Comparison::GreaterOrEqual => a >= b,
            }
        };
        self.guard.as_ref().is_none_or(|clauses| clauses.iter().any(|clause| clause.iter().all(holds)))
    }
}

/// All tuples of tones from 1.
pub fn tuples(sizes: &[u32]) -> Vec<Tuple> {
    let mut all = vec![vec![]];
    for &size in sizes {
        all = all.iter().flat_map(|t| (1..=size).map(move |tone| [t.as_slice(), &[tone]].concat())).collect();
    }
    all
}

fn domain(random: &mut Random, basics: usize) -> Vec<usize> {
    (0..random.below(3)).map(|_| random.below(basics)).collect()
}

fn transition(random: &mut Random, sizes: &[u32], places: &[Vec<usize>]) -> RawTransition {
    let declared = (!random.one_in(3)).then(|| domain(random, sizes.len()));
    let domain = declared.clone().unwrap_or_else(|| (0..sizes.len()).collect());
    let arcs = |random: &mut Random, most: usize| {
        let mut arcs = BTreeMap::new();
        for _ in 0..random.below(most + 1) {
            let place = random.below(places.len());
            if let Some(fun) = function(random, &domain, &places[place], sizes) {
                arcs.insert(place, fun);
            }
        }
        arcs
    };
    // Some input nearly always, or the net has no end.
    let mut inputs = arcs(random, 2);
    if inputs.is_empty() && !random.one_in(20) {
        inputs = arcs(random, 3);
    }
    let outputs = arcs(random, 2);
    let guard = (!domain.is_empty() && random.one_in(2)).then(|| clauses(random, &domain, sizes));
    RawTransition { domain: declared, inputs, outputs, guard }
}

/// A function from one domain to another, if they have the components for it.
pub fn function(random: &mut Random, from: &[usize], to: &[usize], sizes: &[u32]) -> Option<Fun> {
    let mut terms = Vec::new();
    for _ in 0..if random.one_in(4) { 2 } else { 1 } {
        let mut ks = Vec::new();
        for basic in to {
            let same: Vec<u32> = (1..).zip(from).filter(|(_, of)| *of == basic).map(|(k, _)| k).collect();
            ks.push(*same.get(random.below(same.len().max(1)))?);
        }
        let identity = from == to && random.one_in(2);
        let base = if identity {
            Fun::Id
        } else if to.is_empty() && random.one_in(2) {
            Fun::Abs
        } else {
            Fun::Proj(ks)
        };
        let base = turned(random, from, base, true, sizes);
        let base = turned(random, to, base, false, sizes);
        terms.push(if random.one_in(4) { Fun::Times(2, Box::new(base)) } else { base });
    }
    Some(if terms.len() == 1 { terms.remove(0) } else { Fun::Sum(terms) })
}

/// Sometimes with a successor, predecessor or ring before it (on `domain`, its argument) or after it (its result).
fn turned(random: &mut Random, domain: &[usize], fun: Fun, before: bool, sizes: &[u32]) -> Fun {
    if domain.is_empty() || !random.one_in(3) {
        return fun;
    }
    let k = 1 + random.below(domain.len()) as u32;
    let by = random.below(2 * sizes[domain[k as usize - 1]] as usize + 1) as u32;
    let turn = match random.below(8) {
        0 => Fun::Ring(k),
        1..=4 => Fun::Succ(k, by),
        _ => Fun::Pred(k, by),
    };
    if before { Fun::After(Box::new(fun), Box::new(turn)) } else { Fun::After(Box::new(turn), Box::new(fun)) }
}

fn clauses(random: &mut Random, domain: &[usize], sizes: &[u32]) -> Vec<Comparisons> {
    let comparisons = [
        Comparison::Equal,
        Comparison::NotEqual,
        Comparison::Less,
        Comparison::LessOrEqual,
        Comparison::Greater,
        Comparison::GreaterOrEqual,
    ];
    let atom = |random: &mut Random| {
        let k = random.below(domain.len());
        let left = Side::Component(k as u32 + 1, random.below(5) as i64 - 2);
        let right = if random.one_in(2) {
            Side::Component(1 + random.below(domain.len()) as u32, random.below(3) as i64 - 1)
        } else {
            Side::Number(1 + random.below(sizes[domain[k]] as usize) as i64)
        };
        (left, *random.pick(&comparisons), right)
    };
    (0..1 + random.below(2)).map(|_| (0..1 + random.below(2)).map(|_| atom(random)).collect()).collect()
}
