//! All texts of the plant in one list. A new variant without a text, or without a place in the list, does not compile.

use linewright_plant::{CLEAR_WORD, InputFault, MotionFault, NestPosition, PartByHand, PartRefusal};
use linewright_testkit::samples::{listed, samples};

const TEXT: &str = include_str!("../../model/line/tests/descriptions/task_driven.toml");

#[test]
fn all_texts_of_the_plant() {
    let inputs = samples!(InputFault {
        InputFault::StuckOn => InputFault::StuckOn;
        InputFault::StuckOff => InputFault::StuckOff;
    });
    let motions = samples!(MotionFault {
        MotionFault::Stick => MotionFault::Stick;
        MotionFault::Slip => MotionFault::Slip;
        MotionFault::Break => MotionFault::Break;
        MotionFault::SlipBack => MotionFault::SlipBack;
        MotionFault::Miss => MotionFault::Miss;
        MotionFault::Drop => MotionFault::Drop;
    });
    let line = linewright_line::parse("task_driven.toml", TEXT).expect("it is sound").line;
    let place =
        |name: &str, position| NestPosition { nest: line.handling.holder_named(name).expect("it is there"), position };
    let (slot, clamp, hand) = (place("ST", 3), place("m1.clamp", 1), place("robot.hand", 1));
    let by_hand = samples!(PartByHand {
        PartByHand::Take => PartByHand::Take;
        PartByHand::Put => PartByHand::Put;
    });
    let refusals = samples!((PartRefusal, NestPosition) {
        (PartRefusal::NoSuchSpot, _) => (PartRefusal::NoSuchSpot, place("ST", 7)), (PartRefusal::NoSuchSpot, place("m1.clamp", 2)),
            (PartRefusal::NoSuchSpot, hand);
        (PartRefusal::Occupied, _) => (PartRefusal::Occupied, slot);
        (PartRefusal::Held, _) => (PartRefusal::Held, slot), (PartRefusal::Held, clamp);
        (PartRefusal::Known, _) => (PartRefusal::Known, slot);
        (PartRefusal::Unknown, _) => (PartRefusal::Unknown, slot);
        (PartRefusal::Empty, _) => (PartRefusal::Empty, slot), (PartRefusal::Empty, hand);
    });
    let lists = [
        listed("faults of an input", &inputs, |fault| format!("`{}`: {}", fault.name(), fault.about())),
        listed("faults of a motion", &motions, |fault| format!("`{}`: {}", fault.name(), fault.about().join(" "))),
        listed("faults of a drive's motion", &motions, |fault| fault.about_drive().unwrap_or("-").to_owned()),
        listed("parts by hand", &by_hand, |what| {
            format!("`{}`: {} {}", what.name(), what.about(), what.done(&line, slot))
        }),
        listed("parts that are not taken or put", &refusals, |(why, at)| why.text(&line, *at)),
        listed("the end of a fault", &[CLEAR_WORD], |word| format!("`{word}`")),
    ];
    insta::assert_snapshot!(lists.join("\n"));
}
