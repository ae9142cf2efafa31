//! Tests of whole lines as real processes: the command as a user starts it, one process per node, signals, sockets and
//! files, DDS on the loopback interface and the virtual bus.
//!
//! Decisions of stations and coordinator are tested in virtual time, in `tests` and `simulation`. Here each behaviour
//! occurs once, so that a mistake between the parts is found. Every assertion is made from outside: on frames of the
//! bus and on topics of ROS 2.
//!
//! No test asserts a speed: the machine may be busy with other things.

mod auto_cycles;
mod beside;
mod cell_thread;
mod cells;
mod console;
mod console_of_cell;
mod described;
mod devices;
mod full_disk;
mod interrupts;
mod kept_machine;
mod kills;
mod lifecycle;
mod modbus;
mod operated;
mod other_devices;
mod parameters;
mod programs;
mod recovered;
mod remaps;
mod rubbish;
mod slow_disk;
mod two_coordinators;
