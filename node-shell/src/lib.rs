//! What both nodes share of ROS 2: arguments, environment, participant and topics
