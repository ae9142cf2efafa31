//! Parts: a hand-written script picks and places; whatever outputs do, no part is lost and none is made.

use linewright_line::{DeviceBus, HolderId, Line, OutputId, Owner, StationId, Tick, parse};
use linewright_plant::{
    FallCause, MotionFault, NestPosition, PartByHand, PartFault, PartLocation, PartNo, PartRefusal, Plant, PlantOptions,
};
use proptest::prelude::*;

const TEXT: &str = include_str!("../../model/line/tests/descriptions/task_driven.toml");
const M1: StationId = StationId(0);
const ROBOT: StationId = StationId(1);
const PART: PartNo = PartNo(101);

/// The machine and the robot, by the names of their signals. Each motion takes a second.
struct Shop {
    line: Line,
    plant: Plant,
    now: Tick,
}

impl Shop {
    fn new() -> Self {
        let line = parse("task_driven.toml", TEXT).unwrap_or_else(|problems| panic!("{problems:#}")).line;
        Shop { plant: Plant::new(&line, PlantOptions::default()), line, now: Tick::ZERO }
    }

    fn holder(&self, name: &str) -> HolderId {
        self.line.handling.holder_named(name).unwrap_or_else(|| panic!("no {name}"))
    }

    fn slot(&self, position: u16) -> NestPosition {
        NestPosition { nest: self.holder("ST"), position }
    }

    fn clamp(&self) -> NestPosition {
        NestPosition { nest: self.holder("m1.clamp"), position: 1 }
    }

    fn output(&self, station: StationId, name: &str) -> OutputId {
        let names = &self.line.station(station).outputs;
        OutputId::at(names.iter().position(|output| output == name).unwrap_or_else(|| panic!("no {name}")))
    }

    /// These outputs are on, and no others, for so many milliseconds.
    fn drive(&mut self, station: StationId, names: &[&str], millis: u64) {
        let image = names.iter().fold(0, |image, name| image | self.output(station, name).bit());
        self.plant.set_outputs(self.now, Owner::Station(station), image);
        self.now = self.now + std::time::Duration::from_millis(millis);
        self.plant.advance(self.now);
    }

    fn robot(&mut self, names: &[&str]) {
        self.drive(ROBOT, names, 1000);
    }

    /// The whole way from home: a part of slot 3 into the hand, over the open clamp.
    fn pick(&mut self) {
        self.robot(&["Y_50", "slot_1", "slot_2"]);
        self.robot(&["Y_grip", "slot_1", "slot_2"]);
    }

    fn sees(&self, station: StationId, input: &str) -> bool {
        let names = &self.line.station(station).inputs;
        let bit = names.iter().position(|name| name == input).unwrap_or_else(|| panic!("no {input}"));
        self.plant.inputs(Owner::Station(station)) >> bit & 1 == 1
    }

    fn put(&mut self, part: PartNo, spot: NestPosition) {
        assert_eq!(self.plant.put(self.now, part, spot), Ok(()));
    }

    fn of(&self, part: PartNo) -> (Option<NestPosition>, Option<HolderId>) {
        let (_, at) = self.plant.parts().find(|(no, _)| *no == part).expect("no part is lost");
        (at.spot, at.hand)
    }

    fn mishaps(&self) -> Vec<PartFault> {
        self.plant.mishaps().0.iter().map(|(_, mishap)| *mishap).collect()
    }

    /// The mishaps as operators read them.
    fn told(&self) -> Vec<String> {
        self.mishaps().iter().map(|mishap| mishap.text(&self.line, &self.plant)).collect()
    }
}

#[test]
fn a_robot_picks_a_part_from_a_slot_and_places_it_in_a_clamp() {
    let mut shop = Shop::new();
    let (slot, clamp, hand) = (shop.slot(3), shop.clamp(), shop.holder("robot.hand"));
    shop.put(PART, slot);
    shop.pick();
    assert_eq!(shop.of(PART), (Some(slot), Some(hand)), "closed around it, and still over its slot");
    shop.robot(&["Y_100"]);
    assert_eq!(shop.of(PART), (Some(clamp), Some(hand)), "located in the clamp (seed 001, L214-222)");
    assert!(shop.sees(M1, "part_present") && !shop.sees(ROBOT, "m1_closed"));
    shop.drive(M1, &["Y_close"], 1000);
    assert!(shop.sees(ROBOT, "m1_closed"), "the one station's sensor sees the other's axis");
    shop.robot(&["Y_open"]);
    shop.robot(&["Y_0"]);
    assert_eq!((shop.of(PART), shop.plant.part_in(hand)), ((Some(clamp), None), None));
    assert_eq!((shop.plant.part_at(slot), shop.plant.part_at(clamp)), (None, Some(PART)));

    // And back, into another slot.
    shop.robot(&["Y_100"]);
    shop.robot(&["Y_grip"]);
    shop.drive(M1, &["Y_open"], 1000);
    shop.robot(&["Y_50", "slot_4"]);
    assert!(!shop.sees(M1, "part_present"));
    shop.robot(&["Y_open", "slot_4"]);
    shop.robot(&["Y_0"]);
    assert_eq!(shop.of(PART), (Some(shop.slot(4)), None));
    assert_eq!(shop.mishaps(), []);
}

#[test]
fn a_hand_that_misses_arrives_with_nothing_and_no_switch_says_so() {
    let mut shop = Shop::new();
    let slot = shop.slot(3);
    shop.put(PART, slot);
    let grip = shop.output(ROBOT, "Y_grip");
    shop.plant.inject_output(shop.now, Owner::Station(ROBOT), grip, Some(MotionFault::Miss));
    shop.pick();
    assert!(shop.sees(ROBOT, "G_1"), "it has closed");
    shop.robot(&["Y_100"]);
    assert_eq!(shop.of(PART), (Some(slot), None), "seed 001, L224: the grasp fails, the approach is made with no part");
    assert!(!shop.sees(M1, "part_present"));
    shop.plant.inject_output(shop.now, Owner::Station(ROBOT), grip, None);
    shop.robot(&["Y_open"]);
    shop.pick();
    assert_eq!(shop.of(PART).1, Some(shop.holder("robot.hand")), "the next time it takes it");
}

#[test]
fn a_hand_that_holds_nothing_fast_drops_what_it_carries() {
    for early in [true, false] {
        let mut shop = Shop::new();
        let hand = shop.holder("robot.hand");
        let slot = shop.slot(3);
        shop.put(PART, slot);
        let grip = shop.output(ROBOT, "Y_grip");
        let owner = Owner::Station(ROBOT);
        if early {
            shop.plant.inject_output(shop.now, owner, grip, Some(MotionFault::Drop));
        }
        shop.pick();
        assert_eq!(shop.of(PART), (Some(slot), Some(hand)), "it lies in its slot: nothing to fall");
        shop.drive(ROBOT, &["Y_100"], 500);
        if !early {
            assert_eq!(shop.of(PART), (None, Some(hand)));
            shop.plant.inject_output(shop.now, owner, grip, Some(MotionFault::Drop));
        }
        assert_eq!(
            (shop.of(PART), shop.mishaps()),
            ((None, None), vec![PartFault::Fell { part: PART, hand, cause: FallCause::NotHeld }]),
            "{early}"
        );
        shop.drive(ROBOT, &["Y_100"], 500);
        assert!(!shop.sees(M1, "part_present"));
        // A person picks it up and puts it where it was.
        shop.put(PART, slot);
        assert_eq!(shop.of(PART), (Some(slot), None));
    }
}

#[test]
fn what_a_hand_lets_go_of_on_the_way_falls() {
    let mut shop = Shop::new();
    let (slot, hand) = (shop.slot(3), shop.holder("robot.hand"));
    shop.put(PART, slot);
    shop.pick();
    shop.drive(ROBOT, &["Y_100"], 500);
    shop.drive(ROBOT, &["Y_open"], 1);
    let cause = FallCause::OverNothing;
    assert_eq!((shop.of(PART), shop.mishaps()), ((None, None), vec![PartFault::Fell { part: PART, hand, cause }]));
    assert_eq!(
        shop.told(),
        ["a part has fallen down and is gone: gripper `robot.hand` opened over no place for parts (arm at 75.0)"]
    );
}

/// Without the outputs with its position a store has no place for a part, and a place that has one has none for another.
#[test]
fn what_is_put_down_in_no_position_or_in_a_taken_one_falls() {
    let mut shop = Shop::new();
    let (slot, hand) = (shop.slot(3), shop.holder("robot.hand"));
    shop.put(PART, slot);
    shop.pick();
    shop.robot(&["Y_100"]);
    shop.robot(&["Y_50"]);
    shop.robot(&["Y_open"]);
    let cause = FallCause::NoPosition { nest: slot.nest, number: 0 };
    assert_eq!((shop.of(PART), shop.mishaps()), ((None, None), vec![PartFault::Fell { part: PART, hand, cause }]));
    shop.put(PART, slot);
    shop.robot(&["Y_0"]);
    shop.pick();
    shop.robot(&["Y_100"]);
    let (other, taken) = (PartNo(102), shop.slot(4));
    shop.put(other, taken);
    shop.robot(&["Y_50", "slot_4"]);
    shop.robot(&["Y_open", "slot_4"]);
    assert_eq!((shop.of(PART), shop.of(other)), ((None, None), (Some(taken), None)));
    assert_eq!(
        shop.told(),
        [
            "a part has fallen down and is gone: gripper `robot.hand` opened over `ST`, and the outputs with the position give 0; \
             positions are 1 to 6",
            "gripper `robot.hand` has brought a part to position 4 of `ST`, which is closed or has another part",
            "a part has fallen down and is gone: gripper `robot.hand` opened over position 4 of `ST`, where another part lies",
        ]
    );
}

#[test]
fn a_closed_clamp_keeps_its_part_and_lets_no_other_in() {
    let mut shop = Shop::new();
    let (hand, clamp) = (shop.holder("robot.hand"), shop.clamp());
    let slot = shop.slot(3);
    shop.put(PART, slot);
    shop.pick();
    shop.robot(&["Y_100"]);
    shop.drive(M1, &["Y_close"], 1000);
    shop.drive(ROBOT, &["Y_0"], 10);
    assert_eq!(shop.of(PART), (Some(clamp), None));
    assert_eq!(shop.mishaps(), [PartFault::Torn { part: PART, hand }]);
    shop.robot(&["Y_0", "Y_open"]);
    let other = PartNo(102);
    shop.put(other, slot);
    shop.pick();
    shop.robot(&["Y_100"]);
    assert_eq!(shop.of(other), (None, Some(hand)));
    assert_eq!(shop.mishaps()[1..], [PartFault::Blocked { part: other, hand, spot: clamp }]);
    shop.robot(&["Y_open"]);
    let cause = FallCause::Shut(clamp);
    assert_eq!((shop.of(other).0, shop.mishaps()[2]), (None, PartFault::Fell { part: other, hand, cause }));
    assert_eq!(shop.told()[0], "gripper `robot.hand` has left without its part, which a closed clamp holds");
    let shut = "a part has fallen down and is gone: gripper `robot.hand` opened over `m1.clamp`, which is closed";
    assert_eq!(shop.told()[2], shut);
    // What was brought to the clamp may only have passed it. The clamp of a station on another bus is not simulated here.
    let certain = |line: &Line| shop.mishaps().iter().map(|mishap| mishap.is_certain(line)).collect::<Vec<_>>();
    assert_eq!(certain(&shop.line), [true, false, true]);
    let mut apart = shop.line.clone();
    apart.stations[M1.index()].bus = DeviceBus::Own("m1".to_owned());
    assert_eq!(certain(&apart), [true, false, false]);
}

#[test]
fn the_position_that_was_said_on_arrival_counts_until_the_hand_leaves() {
    let mut shop = Shop::new();
    let hand = shop.holder("robot.hand");
    let (third, fourth) = (shop.slot(3), shop.slot(4));
    shop.put(PART, third);
    shop.put(PartNo(102), fourth);
    shop.robot(&["Y_50", "slot_1", "slot_2"]);
    shop.robot(&["slot_4"]);
    shop.robot(&["Y_grip"]);
    assert_eq!(shop.plant.part_in(hand), Some(PART), "the arm stands where it was sent to");
    shop.robot(&["Y_100"]);
    shop.robot(&["Y_50", "slot_1", "slot_2", "slot_4"]);
    assert_eq!(shop.of(PART), (None, Some(hand)), "there is no position 7");
}

#[test]
fn a_hand_that_only_passes_takes_nothing_along() {
    let mut shop = Shop::new();
    let slot = shop.slot(3);
    shop.put(PART, slot);
    // Closing on the way: at 50 the gripper is just closed.
    shop.drive(ROBOT, &["Y_100", "slot_1", "slot_2"], 500);
    shop.drive(ROBOT, &["Y_100", "Y_grip", "slot_1", "slot_2"], 1000);
    assert_eq!(shop.of(PART), (Some(slot), None));
}

#[test]
fn people_put_parts_where_there_is_room_and_take_those_that_nothing_holds() {
    let mut shop = Shop::new();
    let (slot, clamp, hand) = (shop.slot(3), shop.clamp(), shop.holder("robot.hand"));
    let now = shop.now;
    shop.put(PART, slot);
    assert_eq!(shop.plant.put(now, PART, clamp), Err(PartRefusal::Known));
    assert_eq!(shop.plant.put(now, PartNo(102), slot), Err(PartRefusal::Occupied));
    for nowhere in [
        NestPosition { position: 0, ..slot },
        NestPosition { position: 7, ..slot },
        NestPosition { nest: hand, position: 1 },
    ] {
        assert_eq!(shop.plant.put(now, PartNo(102), nowhere), Err(PartRefusal::NoSuchSpot));
    }
    assert_eq!(shop.plant.take(now, PartNo(102)), Err(PartRefusal::Unknown));
    shop.drive(M1, &["Y_close"], 1000);
    assert_eq!(shop.plant.put(shop.now, PartNo(102), clamp), Err(PartRefusal::Held));
    shop.pick();
    assert_eq!(shop.plant.take(shop.now, PART), Err(PartRefusal::Held));
    shop.robot(&["Y_open"]);
    assert_eq!(shop.plant.take(shop.now, PART), Ok(PartLocation { spot: Some(slot), hand: None }));
    assert_eq!(shop.plant.parts().count(), 0);
}

/// By its place alone, as a person does: out of a store, out of a closed hand, not out of a closed clamp.
#[test]
fn a_part_is_taken_out_and_put_in_by_its_place() {
    use PartByHand::{Put, Take};
    let mut shop = Shop::new();
    let (slot, clamp) = (shop.slot(3), shop.clamp());
    let hand = NestPosition { nest: shop.holder("robot.hand"), position: 1 };
    let by_hand = |shop: &mut Shop, what, at| {
        let objection = shop.plant.objection(what, at);
        let done = shop.plant.by_hand(shop.now, what, at);
        assert_eq!(objection, done.err());
        done.err()
    };
    assert_eq!(by_hand(&mut shop, Take, slot), Some(PartRefusal::Empty));
    assert_eq!(by_hand(&mut shop, Put, NestPosition { position: 7, ..slot }), Some(PartRefusal::NoSuchSpot));
    assert_eq!(by_hand(&mut shop, Put, hand), Some(PartRefusal::NoSuchSpot));
    assert_eq!((by_hand(&mut shop, Put, slot), by_hand(&mut shop, Put, slot)), (None, Some(PartRefusal::Occupied)));
    shop.pick();
    assert_eq!(by_hand(&mut shop, Take, slot), Some(PartRefusal::Held), "the hand has it");
    assert_eq!((by_hand(&mut shop, Take, hand), by_hand(&mut shop, Take, hand)), (None, Some(PartRefusal::Empty)));
    assert_eq!(by_hand(&mut shop, Put, clamp), None);
    shop.drive(M1, &["Y_close"], 1000);
    assert_eq!(by_hand(&mut shop, Take, clamp), Some(PartRefusal::Held));
    shop.drive(M1, &["Y_open"], 1000);
    assert_eq!(by_hand(&mut shop, Take, clamp), None);
    assert_eq!(shop.plant.parts().count(), 0);
}

/// Changes of outputs, and the time after each.
fn deeds() -> impl Strategy<Value = Vec<(bool, u8, u64)>> {
    proptest::collection::vec((any::<bool>(), any::<u8>(), 0u64..1500), 1..60)
}

/// Plays deeds; `looks` are extra queries.
fn play(deeds: &[(bool, u8, u64)], looks: u64) -> Shop {
    let mut shop = Shop::new();
    for position in [1, 3, 6] {
        let slot = shop.slot(position);
        shop.put(PartNo(position.into()), slot);
    }
    let clamp = shop.clamp();
    shop.put(PartNo(9), clamp);
    for &(robot, image, millis) in deeds {
        let station = if robot { ROBOT } else { M1 };
        let fault = [None, Some(MotionFault::Miss), Some(MotionFault::Drop)][usize::from(image) % 3];
        let grip = shop.output(ROBOT, "Y_grip");
        shop.plant.inject_output(shop.now, Owner::Station(ROBOT), grip, fault.filter(|_| millis % 4 == 0));
        shop.plant.set_outputs(shop.now, Owner::Station(station), image.into());
        for look in 1..=looks {
            shop.plant.advance(shop.now + std::time::Duration::from_micros(millis * 1000 * look / (looks + 1)));
        }
        shop.now = shop.now + std::time::Duration::from_millis(millis);
        shop.plant.advance(shop.now);
        is_sound(&shop);
    }
    shop
}

/// Every part is there, and in one place; no place has two.
fn is_sound(shop: &Shop) {
    let numbers: Vec<u64> = shop.plant.parts().map(|(part, _)| part.0).collect();
    assert_eq!(numbers, [1, 3, 6, 9], "none lost, none made");
    let all: Vec<_> = shop.plant.parts().map(|(_, at)| at).collect();
    for (nth, at) in all.iter().enumerate() {
        let taken = |other: &PartLocation| {
            (at.spot.is_some() && at.spot == other.spot) || (at.hand.is_some() && at.hand == other.hand)
        };
        assert!(!all[nth + 1..].iter().any(taken), "{all:?}");
        assert!(at.hand.is_none_or(|hand| hand == shop.holder("robot.hand")));
    }
    // A hand has a part only while its switch shows it closed.
    assert!(shop.plant.part_in(shop.holder("robot.hand")).is_none() || shop.sees(ROBOT, "G_1"));
    assert_eq!(shop.sees(M1, "part_present"), shop.plant.part_at(shop.clamp()).is_some());
    assert!(!shop.sees(ROBOT, "m1_closed") || shop.sees(M1, "C_60"));
}

proptest! {
    #[test]
    fn whatever_outputs_do_no_part_is_lost_and_none_is_made(deeds in deeds()) {
        play(&deeds, 0);
    }

    #[test]
    fn it_does_not_matter_how_often_somebody_looks(deeds in deeds(), looks in 1u64..5) {
        let (once, often) = (play(&deeds, 0), play(&deeds, looks));
        prop_assert!(once.plant.parts().eq(often.plant.parts()));
        prop_assert_eq!(once.plant.mishaps(), often.plant.mishaps());
    }
}

#[test]
fn random_outputs_do_move_parts() {
    let mut moved = 0;
    for seed in 0..200u64 {
        let mix = |n: u64| (seed * 7919 + n * 104_729).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32;
        let deeds: Vec<_> =
            (0..60).map(|n| (mix(n) % 4 != 0, (mix(n + 1000) >> 3) as u8, 900 + mix(n) % 600)).collect();
        let shop = play(&deeds, 0);
        moved += u32::from(shop.mishaps().iter().any(|mishap| matches!(mishap, PartFault::Fell { .. })));
    }
    assert!(moved > 0, "the property would hold for a plant in which nothing happens");
}

/// Where people serve the stores, a hand finds a part at an empty place, and a place that is taken is cleared when
/// another is brought. A missed grasp is missed all the same.
#[test]
fn people_bring_parts_and_take_them_away() {
    let mut shop = Shop::new();
    shop.plant = Plant::new(&shop.line, PlantOptions { people: true, ..PlantOptions::default() });
    shop.pick();
    let parts: Vec<_> = shop.plant.parts().collect();
    let hand = Some(shop.holder("robot.hand"));
    assert!(matches!(parts[..], [(_, at)] if at.hand == hand), "{parts:?}");
    // Without them there is none.
    let mut alone = Shop::new();
    alone.pick();
    assert_eq!(alone.plant.parts().count(), 0);
}
