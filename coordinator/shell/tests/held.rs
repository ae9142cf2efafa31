//! Hand-mode buttons of two consoles.

use linewright_coordinator_shell::{CoordinatorArrival, CoordinatorEffect, CoordinatorRecord};

use crate::rig::Rig;

const A: u64 = 1;
const B: u64 = 2;

/// The buttons of the order after a console has sent these, and the refusals meanwhile.
fn sends(rig: &mut Rig, console: u64, held: u32) -> (u32, Vec<String>) {
    rig.shell.handle(rig.now, CoordinatorArrival::Buttons { console, held });
    let done = rig.refresh();
    let refusal = |effect: &CoordinatorEffect| match effect {
        CoordinatorEffect::Refused(refusal) => Some(refusal.text(&rig.line)),
        _ => None,
    };
    (rig.shell.order().buttons, done.iter().filter_map(refusal).collect())
}

#[test]
fn a_second_console_ends_what_is_held_and_both_have_to_let_go() {
    for second in [0b00, 0b10] {
        let mut rig = Rig::new(CoordinatorRecord::default());
        rig.refresh();
        assert_eq!(sends(&mut rig, A, 0b01), (0b01, vec![]));
        let (buttons, refused) = sends(&mut rig, B, second);
        assert_eq!(buttons, 0, "neither");
        let text =
            "buttons refused in home: two consoles send it, nothing goes on; release it at both, then hold it at one";
        assert_eq!(refused, [text]);
        for _ in 0..10 {
            assert_eq!(sends(&mut rig, A, 0b01), (0, vec![]), "held on, and reported once");
            if second != 0 {
                assert_eq!(sends(&mut rig, B, second).0, 0);
            }
        }
        if second != 0 {
            sends(&mut rig, B, 0);
        }
        assert_eq!(sends(&mut rig, A, 0).0, 0);
        assert_eq!(sends(&mut rig, A, 0b01), (0b01, vec![]), "alone, and pressed anew");
    }
}

/// The finger of the one never left its button while its messages did not come.
#[test]
fn resume_at_one_console_is_not_released_by_another_one() {
    let mut rig = Rig::new(CoordinatorRecord::default());
    rig.refresh();
    let sends = |rig: &mut Rig, console, held| {
        rig.shell.handle(rig.now, CoordinatorArrival::Resume { console, held });
        rig.refresh();
        rig.shell.order().resume
    };
    assert!(!sends(&mut rig, A, true), "it acts in manual alone");
    sends(&mut rig, A, false);
    (0..40).for_each(|_| drop(rig.refresh()));
    rig.command(linewright_coordinator_logic::ModeCommand::Manual);
    (0..3).for_each(|_| drop(rig.refresh()));
    assert!(sends(&mut rig, A, true), "in manual, held");
    (0..40).for_each(|_| drop(rig.refresh()));
    assert!(!sends(&mut rig, B, false), "its messages have not come for two seconds");
    (0..40).for_each(|_| drop(rig.refresh()));
    for _ in 0..10 {
        assert!(!sends(&mut rig, A, true), "another console's release is none of it");
    }
    sends(&mut rig, A, false);
    assert!(sends(&mut rig, A, true));
}
