//! Whatever comes in from outside, the controller does not panic, and what does not fit is not taken.

use std::time::Duration;

use linewright_line::net::ControlMode;
use linewright_line::{Line, OpId, StationId, Tick};
use linewright_station_logic::{
    AgreementAnswer, AgreementRequest, Controller, Handled, Ignored, ModeOrder, PanelCommand, Restore, StationInput,
    StationOutbox, StationReport,
};
use proptest::prelude::*;

use super::rig::{Rig, peer_says};
use linewright_testkit::built::{arrow, i, line, r, station};

fn pair() -> Line {
    let stations = vec![station("a", 2, &[r(1), i(1, &[0]), r(2)], 0, false), station("b", 1, &[r(6), r(6)], 8, false)];
    line(stations, vec![arrow((0, 0), (1, 0), 0), arrow((1, 1), (0, 0), 1)])
}

#[test]
fn a_report_that_does_not_fit_the_description_is_not_taken() {
    let mut rig = Rig::new(pair());
    let good = peer_says(&[0, 0]);
    let answer = |op| AgreementAnswer { to: StationId(0), boot_id: 1, number: 1, in_the_way: Some(OpId(op)) };
    let bad = [
        StationReport { done: vec![0; 3], ..good.clone() },
        StationReport { done: vec![], ..good.clone() },
        StationReport { request: Some(AgreementRequest { number: 1, ops: 0b100 }), ..good.clone() },
        StationReport { answers: vec![answer(2)], ..good.clone() },
    ];
    for report in &bad {
        assert_eq!(
            rig.controller.handle(rig.now, StationInput::View(StationId(1), report)),
            Handled::Ignored(Ignored::Misfit)
        );
    }
    let ignored = Handled::Ignored(Ignored::NotAPeer);
    assert_eq!(rig.controller.handle(rig.now, StationInput::View(StationId(0), &good)), ignored, "its own");
    assert_eq!(rig.controller.handle(rig.now, StationInput::View(StationId(9), &good)), ignored, "not described");
    assert!(rig.controller.handle(rig.now, StationInput::View(StationId(1), &good)).is_taken());
}

#[derive(Clone, Debug)]
enum Act {
    Image(u128, bool, u64),
    Order(u8, bool, u32, Option<i32>, u64),
    Panel(PanelCommand),
    View(u16, Box<StationReport>),
}

fn act() -> impl Strategy<Value = Act> {
    let count = prop_oneof![-2i32..3, Just(i32::MIN), Just(i32::MAX)];
    let number = prop_oneof![0u64..3, Just(u64::MAX)];
    let request =
        proptest::option::of((number.clone(), any::<u64>()).prop_map(|(number, ops)| AgreementRequest { number, ops }));
    let op = proptest::option::of((0u16..70).prop_map(OpId));
    let answer = (0u16..3, 0u64..3, number, op).prop_map(|(to, boot_id, number, in_the_way)| AgreementAnswer {
        to: StationId(to),
        boot_id,
        number,
        in_the_way,
    });
    let report =
        (any::<u64>(), prop::collection::vec(count.clone(), 1..4), request, prop::collection::vec(answer, 0..3))
            .prop_map(|(boot_id, done, request, answers)| StationReport {
                boot_id,
                started: done.clone(),
                done,
                request,
                answers,
                ..StationReport::default()
            });
    prop_oneof![
        4 => (any::<u128>(), prop::bool::weighted(0.9), any::<u64>()).prop_map(|(b, v, u)| Act::Image(b, v, u)),
        2 => (0u8..6, prop::bool::weighted(0.9), any::<u32>(), proptest::option::of(count), 0u64..u64::MAX)
            .prop_map(|(m, e, b, s, l)| Act::Order(m, e, b, s, l)),
        2 => (0u8..3, any::<bool>()).prop_map(|(key, on)| Act::Panel(match key {
            0 => PanelCommand::Advance(on),
            1 => PanelCommand::Retract(on),
            _ => PanelCommand::Selector(on),
        })),
        3 => (0u16..3, report).prop_map(|(s, r)| Act::View(s, Box::new(r))),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn nothing_that_comes_in_panics_and_outputs_follow_the_marking(
        acts in prop::collection::vec((act(), 0u64..400), 1..120), station in 0u16..2,
    ) {
        let line = pair();
        let mut controller = Controller::new(&line, StationId(station), 1, Restore::Fresh).expect("compiles");
        let (mut out, mut now) = (StationOutbox::default(), Tick::ZERO);
        for (epoch, (act, ms)) in acts.into_iter().enumerate() {
            now = now + Duration::from_millis(ms);
            match act {
                Act::Image(bits, valid, until) => {
                    controller.handle(now, StationInput::Inputs { bits, valid, until: Tick::from_micros(until), under: linewright_station_logic::NO_DELAY })
                }
                Act::Order(mode, enabled, buttons, master_stop, lease) => controller.handle(now, StationInput::Order(ModeOrder {
                    boot_id: u64::from(buttons % 2), epoch: epoch as u64, mode: ControlMode::ALL[usize::from(mode)],
                    enabled, master_stop, manual_all: buttons % 3 == 0, buttons, resume: buttons % 5 != 0, lease: Duration::from_micros(lease), found: None, station_life: 1, single: buttons % 7 == 0,
                })),
                Act::Panel(command) => controller.handle(now, StationInput::Panel(command)),
                Act::View(from, report) => controller.handle(now, StationInput::View(StationId(from), &report)),
            };
            controller.step(now, &mut out);
            let moving: u128 = controller.marking().filter(|p| p.is_operating())
                .map(|p| linewright_testkit::built::actuator_bit(p.op, p.block == linewright_line::net::Block::Recovery)).sum();
            prop_assert_eq!(out.outputs & !moving, 0, "only an operating place drives");
            let report = controller.report();
            for op in 0..report.done.len() {
                prop_assert!(report.done[op] <= report.started[op] && report.started[op] <= report.cycle + i32::from(report.recovering_home));
            }
            controller.blocked_by(&line, now);
            controller.operation_text(&line);
            for event in out.events.drain(..) {
                event.text(&line, StationId(station));
            }
        }
    }
}
