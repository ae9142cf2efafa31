//! Slips of the hand in tables end with problems that can be drawn.

use linewright_cases::slips::{draw, slipped, slips};
use proptest::prelude::*;

use crate::files::{FIXTURE, read, split};

const WORDS: [&str; 12] =
    ["\n=== ", ";", "\t", "(", ")", " or ", "b(2", "initial", "initially ", "alternative", "all", "*"];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(u32::try_from(crate::cases::cases(400)).unwrap_or(400)))]

    #[test]
    fn whatever_tables_contain_their_problems_can_be_drawn(slips in slips(&WORDS)) {
        let text = slipped(FIXTURE, slips);
        if let Err(all) = read(&text) {
            for problems in all {
                let headline = problems.to_string();
                let name = headline.split(':').next().unwrap_or_default();
                let source = split(&text).into_iter().find(|(_, source)| source.name == name);
                draw(source.map_or("", |(_, source)| source.text), &problems);
            }
        }
    }
}
