//! What is written out again and read is the same.

use crate::cases::cases;
use linewright_relations::{Relations, SourceText, parse, write};
use proptest::prelude::*;

use crate::files::{FIXTURE, read};

/// The shipped cell, all files in one text.
pub fn two_robot_cell() -> String {
    let files = [
        ("relations.toml", include_str!("../../../launch-config/lines/two-robot-cell/relations.toml")),
        ("operations.csv", include_str!("../../../launch-config/lines/two-robot-cell/operations.csv")),
        ("relations.csv", include_str!("../../../launch-config/lines/two-robot-cell/relations.csv")),
    ];
    files.iter().map(|(name, text)| format!("=== {name}\n{text}")).collect()
}

fn again(relations: &Relations) -> Relations {
    let written = write(relations);
    let sources: Vec<_> = written.iter().map(|file| SourceText { name: file.name, text: &file.text }).collect();
    let parsed = parse(&sources).unwrap_or_else(|problems| panic!("{:#}\n{}", problems[0], written[2].text));
    parsed.relations
}

#[test]
fn tables_written_out_again_say_the_same() {
    for text in [FIXTURE.to_owned(), two_robot_cell()] {
        let relations = read(&text).expect("it is sound").relations;
        let again = again(&relations);
        assert_eq!(again.without_rows(), relations.without_rows());
    }
}

#[test]
fn semicolons_and_decimal_commas_are_read_as_well() {
    let table = |text: &str| text.replace("0.5", "\"0,5\"");
    let text = table(FIXTURE);
    let (plain, other) = (read(FIXTURE).expect("it is sound"), read(&text).expect("it is sound"));
    assert_eq!(plain.relations.without_rows(), other.relations.without_rows());
    let semicolons = "=== relations.toml\nname = \"c\"\n[[machine]]\nname = \"R\"\n[[condition]]\nname = \"A\"\n\
                      === operations.csv\nid;machine;conditions;duration_s\n1;R;A;2,5\n=== relations.csv\nmachine;operation;after\nR;1;\n";
    let read = read(semicolons).expect("it is sound");
    assert_eq!(read.relations.operations[0].duration, Some(std::time::Duration::from_millis(2500)));
}

/// Titles and comments with every sign that tables and TOML give a meaning.
fn any_text() -> impl Strategy<Value = String> {
    prop::collection::vec(
        prop::sample::select(vec!['a', '"', ',', ';', '\'', '\\', ' ', 'é', '=', '#', '\n', '\t', '-']),
        0..12,
    )
    .prop_map(|signs| signs.into_iter().collect::<String>().trim().to_owned())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(u32::try_from(cases(200)).unwrap_or(200)))]

    #[test]
    fn any_numbers_and_texts_survive(
        texts in prop::collection::vec(any_text(), 6),
        every in 1u32..1000,
        millis in prop::option::of(0u64..86_400_000),
        alarm in prop::option::of(1u32..99),
        cycle in 1u32..100,
        swaps in prop::collection::vec((0usize..20, 0usize..20), 4),
    ) {
        let mut relations = read(FIXTURE).expect("it is sound").relations;
        relations.title = texts[0].clone();
        relations.machines[0].title = texts[1].clone();
        relations.machines[0].components[0].block = Some(texts[2].clone());
        relations.conditions[0].cycle = cycle;
        relations.operations[3].comment = texts[3].clone();
        relations.operations[19].every = every;
        relations.operations[5].duration = millis.map(std::time::Duration::from_millis);
        relations.sequences[0].elements[1].alternatives[0].comment = texts[4].clone();
        relations.executions[1].initial.alarm = alarm;
        relations.executions[1].actions[0].comment = texts[5].clone();
        relations.executions[1].initial.delay = millis.map(std::time::Duration::from_millis);
        relations.interlocks[0].terms[0].comment = texts[1].clone();
        // Comments of other rows change places.
        for (one, other) in swaps {
            let comment = relations.operations[one].comment.clone();
            relations.operations[other].comment = comment;
        }
        let again = again(&relations);
        prop_assert_eq!(again.without_rows(), relations.without_rows());
    }
}
