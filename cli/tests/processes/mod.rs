//! The fourth ring: whole lines of real processes, over loopback DDS and the virtual bus.
//!
//! The inner rings prove the decisions, in virtual time and by the million. Here a few scenarios are played once each,
//! with everything real that can be: the command as a user starts it, one process per node, signals, sockets, files.
//! What they look for is what only the joints can get wrong: each behaviour is met once, however much there is to it further in. Every assertion is made from outside, from the frames on
//! the bus and the topics of ROS 2.
//!
//! No test asserts a speed: the machine may be busy with other things.

mod auto_cycles;
mod beside;
mod cells;
mod device_faults;
mod devices;
mod estop;
mod faults;
mod hand_mode;
mod interrupts;
mod kills;
mod lost_memory;
mod modbus;
mod other_devices;
mod outputs;
mod remaps;
mod rubbish;
mod rubbish_senders;
mod slow_disk;
mod two_coordinators;
