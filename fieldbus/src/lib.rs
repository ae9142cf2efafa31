//! Process image to CANopen over SocketCAN, or over a virtual bus between processes
