//! The coordinator's decisions: control mode, leases and refusals
