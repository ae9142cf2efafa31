//! All texts of the plant in one list. A new variant without a text, or without a place in the list, does not compile.

use linewright_plant::{CLEAR_WORD, InputFault, MotionFault};
use linewright_testkit::samples::{listed, samples};

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
    let lists = [
        listed("faults of an input", &inputs, |fault| format!("`{}`: {}", fault.name(), fault.about())),
        listed("faults of a motion", &motions, |fault| format!("`{}`: {}", fault.name(), fault.about().join(" "))),
        listed("faults of a drive's motion", &motions, |fault| fault.about_drive().unwrap_or("-").to_owned()),
        listed("the end of a fault", &[CLEAR_WORD], |word| format!("`{word}`")),
    ];
    insta::assert_snapshot!(lists.join("\n"));
}
