//! Positions of a rack's mechanisms and parts, to be kept and to begin from.

use std::collections::{BTreeMap, BTreeSet};

use linewright_canopen::NodeId;
use linewright_line::{AxisId, DeviceBus, DeviceKind, DriveMode, Line, Owner, StationId, Tick};

use super::{Rack, RackNode};
use crate::device::DriveNode;
use crate::plant::PlantOptions;
use crate::positions::{AxisPosition, PositionsMisfit, RackPositions, misfit};

impl Rack {
    /// As [`Rack::new`], with its mechanisms and parts where they were kept.
    ///
    /// # Errors
    /// When these are positions of another plant, or such as this one cannot have.
    pub fn resumed(
        now: Tick,
        line: &Line,
        bus: &DeviceBus,
        options: PlantOptions,
        kept: &RackPositions,
    ) -> Result<Self, PositionsMisfit> {
        let mut rack = Rack::new(now, line, bus, options);
        let stations = rack.stations();
        let is_its = |name: &String| stations.iter().any(|id| line.station(*id).name == *name);
        if let Some(name) = kept.axes.keys().find(|name| !is_its(name)) {
            return misfit(format!("there is no station `{name}` on {bus}"));
        }
        for &id in &stations {
            let station = line.station(id);
            let none = BTreeMap::new();
            let axes = kept.axes.get(&station.name).unwrap_or(&none);
            if !station.axes.iter().map(|axis| &axis.name).collect::<BTreeSet<_>>().into_iter().eq(axes.keys()) {
                return misfit(format!("{} has other axes", station.name));
            }
            for (index, axis) in station.axes.iter().enumerate() {
                let (id, at) = ((id, AxisId::at(index)), axes[&axis.name]);
                let placed = rack.resume_axis(now, line, id, at);
                placed.map_err(|why| PositionsMisfit(format!("{} of {}: {why}", axis.name, station.name)))?;
            }
        }
        rack.carry_axes(now);
        rack.plant.resume_parts(&kept.parts, &kept.reached)?;
        rack.carry_inputs(now, &mut Vec::new());
        Ok(rack)
    }

    fn resume_axis(
        &mut self,
        now: Tick,
        line: &Line,
        (station, axis): (StationId, AxisId),
        at: AxisPosition,
    ) -> Result<(), PositionsMisfit> {
        let mut has_drive = false;
        for slot in &mut self.slots {
            let (RackNode::Drive(node, of), DeviceKind::Drive(canopen, drive)) = (&mut slot.node, &slot.device.kind)
            else {
                continue;
            };
            if (*of, drive.axis) == (station, axis)
                && let Some(id) = NodeId::new(canopen.node_id)
            {
                **node = DriveNode::new(now, id, drive, at.at, &line.timing);
                has_drive = true;
            }
        }
        self.plant.resume_axis((station, axis), at, has_drive)
    }

    /// The stations whose devices are on this bus.
    fn stations(&self) -> Vec<StationId> {
        let station = |owner: &Owner| match owner {
            Owner::Station(id) => Some(*id),
            Owner::Console => None,
        };
        self.owners.iter().filter_map(station).collect()
    }

    /// Positions of its mechanisms and parts now.
    pub fn positions(&mut self, now: Tick, line: &Line) -> RackPositions {
        self.plant.advance(now);
        self.carry_axes(now);
        let mut axes = BTreeMap::<String, BTreeMap<String, AxisPosition>>::new();
        for id in self.stations() {
            let own = axes.entry(line.station(id).name.clone()).or_default();
            for (index, axis) in line.station(id).axes.iter().enumerate() {
                own.insert(axis.name.clone(), self.kept_axis(now, (id, AxisId::at(index))));
            }
        }
        let (parts, reached) = self.plant.kept_parts();
        RackPositions { axes, parts, reached }
    }

    /// Where a drive moves an axis its own position counts on over all turns.
    fn kept_axis(&self, now: Tick, (station, axis): (StationId, AxisId)) -> AxisPosition {
        let drives = self.slots.iter().filter_map(|slot| match (&slot.node, slot.device.drive()) {
            (RackNode::Drive(node, of), Some(drive)) if *of == station => Some((node, drive)),
            _ => None,
        });
        let mut its = drives.filter(|(_, drive)| drive.axis == axis && drive.mode == DriveMode::Position);
        match its.next() {
            Some((node, drive)) => AxisPosition { at: drive.units(node.place(now)), left: 0 },
            None => self.plant.kept_axis(station, axis),
        }
    }
}
