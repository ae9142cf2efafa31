//! Unmarked nets in short, for the unit tests of the classes, and the results for a class.

use crate::{Net, NetBuilder};

/// Places `a b c d`; each transition is named by the places it takes from and gives to, as in "ab>c".
pub(super) fn net(transitions: &[&str]) -> Net {
    let mut b = NetBuilder::new("n");
    let places = ["a", "b", "c", "d"].map(|name| b.place(name, 0));
    let place = |c: char| places[c as usize - 'a' as usize];
    for &name in transitions {
        let t = b.transition(name);
        let (takes, gives) = name.split_once('>').unwrap();
        takes.chars().for_each(|c| _ = b.input(t, place(c), 1));
        gives.chars().for_each(|c| _ = b.output(t, place(c), 1));
    }
    b.build().unwrap()
}

/// The counterexample in words, or "yes".
pub(super) fn why<E: ToString>(answer: Result<(), E>) -> String {
    answer.err().map_or("yes".into(), |e| e.to_string())
}
