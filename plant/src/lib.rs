//! The simulated plant: a line's mechanisms, and the devices they hang on.
//!
//! - [`Plant`]: the mechanisms of a line in pure, event-driven time: outputs in, limit switches out; and where parts are;
//! - [`DeviceNode`]: one generic CANopen I/O device, pure: frames in, frames out;
//! - [`DriveNode`]: one CANopen drive, pure as well; it moves its axis itself;
//! - [`DbcDeviceNode`]: one device without CANopen, with the frames of a DBC file, pure;
//! - [`ModbusNode`]: one device in Modbus, pure: requests in, answers out;
//! - [`Rack`]: the devices of one bus wired to the mechanisms, pure.
//!
//! `linewright_racks` puts racks on the buses of a machine.
//!
//! The plant has the description and the laws of motion, and no modes, cycles or controllers: an energised output moves
//! an axis, whatever energised it. That makes it a fair opponent in a test. It can be made to fail, in process or over
//! CAN.

mod axis;
mod by_hand;
mod device;
mod fault;
mod mechanism;
mod parts;
mod plant;
mod positions;
mod rack;
mod texts;
mod wire;

pub use by_hand::{PartByHand, PartRefusal, station_of};
pub use device::{
    CanDevice, DbcDeviceNode, DeviceNode, DeviceOutbox, DriveNode, ModbusNode, ModbusRequest, ModbusResponse,
    PlantEffect,
};
pub use fault::{
    CLEAR, DeviceFault, FAULT_INDEX, FAULTS_INDEX, FaultWrite, HOLD_INDEX, InputFault, MotionFault, ObjectWrites,
    PART_OF_INDEX, PRESS_INDEX, PUT_INDEX, SIMULATED, SIMULATED_INDEX, STUCK_INDEX, TAKE_INDEX, TROUBLE_INDEX,
};
pub use parts::{FallCause, NestPosition, PartFault, PartLocation, PartNo};
pub use plant::{Plant, PlantOptions};
pub use positions::{AxisPosition, PartPosition, PositionsMisfit, PositionsWatch, RackPositions};
pub use rack::Rack;
pub use texts::CLEAR_WORD;
pub use wire::FrameFaults;
