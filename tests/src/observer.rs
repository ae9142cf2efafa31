//! An independent observer of a transfer line: uses positions alone, no controller's report.
//!
//! Written by hand from the states that must never occur on this machine, not from the description: if the
//! description's arrows or conflicts were wrong, this would still complain.
//!
//! * The bar is off its rest height while some clamp is not fully open.
//! * A tool is out of its home position while its clamp is not fully closed.
//! * The bar carries parts on although a mill has not machined the part in front of it.
//!
//! Positions move on straight lines between two looks, so it compares the *larger* distance of both looks: two things
//! that are away from their safe places at different moments of one interval count as away together. That errs on the
//! safe side, and a correct line never comes near it, because what follows a movement waits for its switch.

use linewright_line::{AxisId, Line, StationId};
use linewright_plant::Plant;

/// Within this many millimetres a mechanism is where it should be: the switches' own reach.
const TOLERANCE: f64 = 1.0;
const OPEN: f64 = 0.0;
const CLOSED: f64 = 60.0;
const PLACE_NEXT: f64 = 500.0;
const FED_THROUGH: f64 = 60.0;
const AT_THE_PART: f64 = 100.0;
/// Above this the bar has the parts off their rests.
const CARRYING: f64 = 25.0;

#[derive(Clone, Debug)]
struct ObservedMachine {
    clamp: (StationId, AxisId),
    slide: (StationId, AxisId),
    feed: (StationId, AxisId),
    /// Largest distance since the look before: from open, from closed, of the tool from home.
    not_open: f64,
    not_closed: f64,
    tool: f64,
    fed: bool,
    /// Number of times the part in front of it has been machined, by number of the part.
    machined: Vec<u32>,
}

/// The observer.
#[derive(Clone, Debug)]
pub struct IndependentObserver {
    vertical: (StationId, AxisId),
    horizontal: (StationId, AxisId),
    machines: Vec<ObservedMachine>,
    off_rest: f64,
    across: f64,
    /// Number of places the parts have been carried on.
    places: usize,
    looks: u64,
    violations: Vec<String>,
    /// People have led parts on by hand: from then on these are responsible that each is machined.
    parts_are_lost: bool,
}

impl IndependentObserver {
    /// An observer of this transfer line, at home.
    ///
    /// # Panics
    /// If the line is no transfer line.
    pub fn new(line: &Line) -> Self {
        let axis = |station: &str, axis: &str| {
            let id = line.station_named(station).unwrap_or_else(|| panic!("a transfer line has a {station}"));
            let at = line.station(id).axes.iter().position(|a| a.name == axis);
            (id, AxisId::at(at.unwrap_or_else(|| panic!("{station} has a {axis}"))))
        };
        let machine = |number: usize| ObservedMachine {
            clamp: axis(&format!("clamp_{number}"), "stroke"),
            slide: axis(&format!("mill_{number}"), "positioning_slide"),
            feed: axis(&format!("mill_{number}"), "main_slide"),
            not_open: 0.0,
            not_closed: CLOSED,
            tool: 0.0,
            fed: false,
            machined: vec![0],
        };
        IndependentObserver {
            vertical: axis("transfer", "vertical"),
            horizontal: axis("transfer", "horizontal"),
            machines: (1..=(line.stations.len() - 1) / 2).map(machine).collect(),
            off_rest: 0.0,
            across: 0.0,
            places: 0,
            looks: 0,
            violations: Vec::new(),
            parts_are_lost: false,
        }
    }

    pub fn look(&mut self, plant: &Plant) {
        self.looks += 1;
        let at = |(station, axis): (StationId, AxisId)| plant.position(station, axis);
        let off_rest = at(self.vertical).abs();
        let worst_off_rest = self.off_rest.max(off_rest);
        self.off_rest = off_rest;
        for (number, machine) in self.machines.iter_mut().enumerate() {
            let number = number + 1;
            let clamp = at(machine.clamp);
            let (not_open, not_closed, tool) = ((clamp - OPEN).abs(), (clamp - CLOSED).abs(), at(machine.slide).abs());
            if worst_off_rest > TOLERANCE && machine.not_open.max(not_open) > TOLERANCE {
                self.violations.push(format!(
                    "the bar is {worst_off_rest:.1} mm off its rest and clamp {number} {:.1} mm from open",
                    machine.not_open.max(not_open)
                ));
            }
            if machine.tool.max(tool) > TOLERANCE && machine.not_closed.max(not_closed) > TOLERANCE {
                self.violations.push(format!(
                    "tool {number} is {:.1} mm from home and its clamp {:.1} mm from closed",
                    machine.tool.max(tool),
                    machine.not_closed.max(not_closed)
                ));
            }
            (machine.not_open, machine.not_closed, machine.tool) = (not_open, not_closed, tool);
            let fed = (at(machine.feed) - FED_THROUGH).abs() <= TOLERANCE;
            if fed && !machine.fed && (tool - AT_THE_PART).abs() <= TOLERANCE {
                machine.machined[self.places] += 1;
            }
            machine.fed = fed;
        }
        let across = at(self.horizontal);
        let middle = PLACE_NEXT / 2.0;
        if off_rest > CARRYING && (across > middle) != (self.across > middle) {
            self.carried(across > middle);
        }
        self.across = across;
    }

    /// The bar has carried the parts past the middle, on or back.
    fn carried(&mut self, on: bool) {
        if on {
            for (number, machine) in self.machines.iter_mut().enumerate() {
                if !self.parts_are_lost && self.places > 0 && machine.machined[self.places] == 0 {
                    self.violations.push(format!(
                        "part {} is carried away from mill {} without having been machined",
                        self.places,
                        number + 1
                    ));
                }
                if machine.machined.len() == self.places + 1 {
                    machine.machined.push(0);
                }
            }
            self.places += 1;
        } else {
            self.places = self.places.saturating_sub(1);
        }
    }

    /// From now on only mechanisms are judged, not what becomes of parts.
    pub(crate) fn lose_parts(&mut self) {
        self.parts_are_lost = true;
    }

    /// Violations seen.
    pub fn violations(&self) -> &[String] {
        &self.violations
    }

    /// Number of places the parts have been carried on: the number of the part in front of the first mill.
    pub fn places(&self) -> usize {
        self.places
    }

    /// Number of times that mill `machine` (from 1) has machined part `part` (from 1).
    pub fn machined(&self, machine: usize, part: usize) -> u32 {
        self.machines[machine - 1].machined.get(part).copied().unwrap_or(0)
    }

    /// Number of looks.
    pub fn looks(&self) -> u64 {
        self.looks
    }
}
