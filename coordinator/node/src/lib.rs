//! The coordinator's ROS 2 node: mode, console and CAN gateway
