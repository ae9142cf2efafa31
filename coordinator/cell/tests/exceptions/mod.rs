//! Failures and their handling: in a cell in virtual time, with sensors that see where the parts really are, and a simulated
//! operator.

mod alarms;
mod bench;
mod crash;
mod emergency;
mod ends;
mod missed;
mod moves;
mod other_rest;
mod rehearsed;
mod rows;
mod rows_of_parts;
mod stands;
mod story;
