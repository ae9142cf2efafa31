//! ROS 2 interfaces of a line: message types held to their .msg files
