//! All tests of this crate as one program: programs of their own would each be linked with all that they share.

mod auto_cycles;
mod crashes;
mod devices;
mod estop;
mod fault_matrix;
mod faults_in_auto;
mod hand_mode;
mod lost_memory;
mod panels;
mod random_actions;
mod self_check;
mod simulation_agrees;
mod simulation_keeps_the_plan;
mod stuck;
