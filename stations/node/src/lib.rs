//! One station's ROS 2 node: a thin shell around its logic
