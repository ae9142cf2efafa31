//! A drive among the devices of a line: the axis it moves is the plant's.

use std::time::Duration;

use linewright_canopen::{Frame, NodeId};
use linewright_line::{AxisId, DeviceBus, Line, StationId, Tick, parse};
use linewright_plant::{PlantOptions, Rack};

const LINE: &str = include_str!("../../model/line/tests/descriptions/drives.toml");

struct Bench {
    rack: Rack,
    now: Tick,
    out: Vec<Frame>,
}

impl Bench {
    fn new(line: &Line) -> Self {
        let now = Tick::from_millis(1000);
        Bench { rack: Rack::new(now, line, &DeviceBus::Line, PlantOptions::default()), now, out: Vec::new() }
    }

    fn pass(&mut self, millis: u64) {
        let until = self.now + Duration::from_millis(millis);
        while let Some(due) = self.rack.next_deadline().filter(|due| *due <= until) {
            self.now = due;
            self.rack.poll(due, &mut self.out);
        }
        self.now = until;
        self.rack.poll(until, &mut self.out);
    }

    fn hear(&mut self, frames: &[&str]) {
        for frame in frames {
            self.rack.handle(self.now, &frame.parse().expect("a frame"), &mut self.out);
        }
    }

    fn place(&self, axis: u16) -> f64 {
        self.rack.plant().position(StationId(0), AxisId(axis))
    }
}

#[test]
fn its_axis_follows_it_and_the_others_follow_their_valves() {
    let line = parse("drives.toml", LINE).unwrap_or_else(|problems| panic!("{problems:#}")).line;
    let mut bench = Bench::new(&line);
    bench.pass(30);
    bench.hear(&["000#0100"]);
    assert_eq!((bench.place(0), bench.place(1)), (0.0, 0.0));
    // The clamp closes by its valve; node 3 is told 40 mm at 100 mm/s, as with cansend.
    bench.hear(&["202#02"]);
    bench.hear(&["603#2381600000A08601", "603#23836000C0C62D00", "603#23846000C0C62D00", "603#237A6000409C0000"]);
    bench.hear(&["203#0600", "203#0700", "203#0F00", "203#3F00"]);
    bench.pass(150);
    assert!((1.0..39.0).contains(&bench.place(0)), "{}", bench.place(0));
    assert!((1.0..4.9).contains(&bench.place(1)), "{}", bench.place(1));
    bench.pass(1000);
    assert_eq!((bench.place(0), bench.place(1)), (40.0, 5.0));
    let drive = bench.rack.drive(NodeId::new(3).expect("a node id")).expect("it is a drive");
    assert_eq!(drive.place(bench.now), 40_000.0);
    assert!(bench.rack.device(NodeId::new(3).expect("a node id")).is_none());
    // The clamp's switch is on where it is; nothing of the slide is among the I/O device's inputs.
    assert_eq!(bench.out.iter().rev().find(|f| f.cob_id() == Some(0x182)).map(|f| f.data().to_vec()), Some(vec![2]));
}
