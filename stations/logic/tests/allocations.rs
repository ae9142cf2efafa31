//! A step allocates nothing once the controller has warmed up.

mod transfer_bar;
use linewright_line::StationId;
use linewright_station_logic::{StationInput, StationReport};
use transfer_bar::{NOW, TransferBar};

#[test]
fn a_hundred_rounds_after_the_first_allocate_nothing() {
    let mut bar = TransferBar::lifting();
    bar.round();
    let counted = allocation_counter::measure(|| {
        for _ in 0..100 {
            bar.round();
        }
    });
    assert_eq!(counted.count_total, 0);
}

#[test]
fn hearing_a_peer_and_reporting_into_a_used_report_allocate_nothing() {
    let mut bar = TransferBar::lifting();
    let peer = StationReport { boot_id: 1, done: vec![9; 2], started: vec![9; 2], ..StationReport::default() };
    let mut report = bar.controller.report();
    let counted = allocation_counter::measure(|| {
        for _ in 0..100 {
            bar.controller.handle(NOW, StationInput::View(StationId(1), &peer));
            bar.step();
            bar.controller.report_into(&mut report);
        }
    });
    assert_eq!(counted.count_total, 0);
}
