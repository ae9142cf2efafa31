//! Random lines: well formed, and the same for the same seed.
//!
//! Generated lines are accepted by [`linewright_line::parse`], and [`text`] writes them in the form it reads: motions
//! chain along their axes and lead home, hand-mode types form sequences, recovery paths take back what has been done
//! since home, neighbours in one another's way have the arrows that keep them apart. [`break_it`] then spoils a line in
//! one known way. A check is credible if it accepts all of the first and finds the second.
//!
//! No way of judging a line is used here: tests show that the generated lines are sound.

mod arrows;
mod breakage;
mod cell;
mod station;
mod task_driven;
mod text;

use std::ops::RangeInclusive;

use linewright_line::{
    Axis, Console, Device, DeviceBus, DeviceKind, InputId, Line, MaterialFlow, OpId, Owner, Panel, Rest, Station,
    StationId, TaskOrderSource, Timing,
};

pub use breakage::{Breakage, break_it, breakages, without_literal};
pub use cell::{CellShape, cell};
pub use linewright_random::Random;
pub use task_driven::task_driven;
pub use text::text;

/// The kind of lines to generate. Chances are in percent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineShape {
    /// Number of stations.
    pub stations: RangeInclusive<usize>,
    /// Number of operations of a station, from 2 to 24.
    pub operations: RangeInclusive<usize>,
    /// That an operation which may be irreversible is.
    pub irreversible: u32,
    /// That a step which may be a concurrent group is.
    pub groups: u32,
    /// That hand mode runs several operations with one button, where it may.
    pub sequences: u32,
    /// That a motion has a sensor for its fault, and that it has a lamp.
    pub sensors: u32,
    /// That an arrow is written as two, one for each mode, where it holds in both.
    pub divided: u32,
    /// Number of attempts to add another arrow, between any two stations, with any lag up to 2 and in any modes. It
    /// stays if the line stays live and its home consistent.
    pub more_arrows: usize,
    /// Number of attempts to add another conflict, between any two stations, with its pair of arrows.
    pub more_conflicts: usize,
}

impl Default for LineShape {
    /// Two or three stations of two to five operations, with something of everything.
    fn default() -> Self {
        LineShape {
            stations: 2..=3,
            operations: 2..=5,
            irreversible: 25,
            groups: 25,
            sequences: 50,
            sensors: 50,
            divided: 10,
            more_arrows: 2,
            more_conflicts: 1,
        }
    }
}

impl LineShape {
    /// Two stations of two or three operations: few enough states to look at each, with every freedom.
    pub fn small() -> Self {
        LineShape { stations: 2..=2, operations: 2..=3, more_arrows: 1, more_conflicts: 0, ..LineShape::default() }
    }

    /// A row of so many stations of about ten operations, as a transfer line has them: each shares its room with the
    /// next.
    pub fn row(stations: usize) -> Self {
        LineShape {
            stations: stations..=stations,
            operations: 8..=12,
            more_arrows: stations / 4,
            more_conflicts: stations / 8,
            ..LineShape::default()
        }
    }
}

/// A line of this shape; the same for the same seed.
///
/// # Panics
/// When the shape has no station, or operations out of their bounds.
pub fn line(shape: &LineShape, seed: u64) -> Line {
    let mut random = Random::new(seed);
    let count = random.within(&shape.stations);
    assert!(count > 0, "a line has at least one station");
    let mut buttons = Vec::new();
    let stations: Vec<Station> =
        (0..count).map(|number| station::random(shape, number, &mut buttons, &mut random)).collect();
    let mut line = unjoined(format!("Generated line {seed}"), stations, buttons);
    arrows::draw(&mut line, shape, &mut random);
    line
}

/// A line of these stations with nothing between them.
fn unjoined(title: String, stations: Vec<Station>, buttons: Vec<String>) -> Line {
    Line {
        name: "generated".to_owned(),
        title,
        arrows: Vec::new(),
        conflicts: Vec::new(),
        devices: stations.iter().enumerate().flat_map(|(number, station)| devices(number, station)).collect(),
        stations,
        console: Console { buttons: vec![None; buttons.len()], ..Console::default() },
        buttons,
        timing: Timing::default(),
        handling: MaterialFlow::default(),
    }
}

/// A station with the usual panel and nothing else.
fn empty_station(number: usize, axes: Vec<Axis>, rests: Vec<Rest>) -> Station {
    Station {
        name: format!("s{number}"),
        title: format!("Station {number}"),
        operations: Vec::new(),
        home: OpId(0),
        steps: Vec::new(),
        rests,
        tasks: Vec::new(),
        order_source: TaskOrderSource::Coordinator,
        axes,
        inputs: ["manual", "advance", "return"].map(|key| format!("P_{key}")).to_vec(),
        outputs: Vec::new(),
        panel: Panel { manual: Some(InputId(0)), advance: Some(InputId(1)), retract: Some(InputId(2)) },
        bus: bus(number),
    }
}

/// Bits of one device, each way.
const DEVICE_BITS: usize = 64;

/// As many devices on the station's own bus as its signals need.
fn devices(number: usize, station: &Station) -> impl Iterator<Item = Device> + use<> {
    let (inputs, outputs) = (station.inputs.len(), station.outputs.len());
    let (name, bus) = (station.name.clone(), station.bus.clone());
    let count = inputs.max(outputs).div_ceil(DEVICE_BITS);
    (0..count).map(move |nth| Device {
        name: format!("{name} io {nth}"),
        owner: Owner::Station(StationId::at(number)),
        bus: bus.clone(),
        kind: DeviceKind::io(
            nth as u8 + 1,
            bits(nth, inputs).map(|bit| Some(InputId::at(bit))).collect(),
            bits(nth, outputs).map(|bit| Some(linewright_line::OutputId::at(bit))).collect(),
        ),
    })
}

fn bits(device: usize, count: usize) -> std::ops::Range<usize> {
    (device * DEVICE_BITS).min(count)..((device + 1) * DEVICE_BITS).min(count)
}

/// A bus of the station's own: node ids are few, and a line may have hundreds of stations.
fn bus(number: usize) -> DeviceBus {
    DeviceBus::Own(format!("can{number}"))
}
