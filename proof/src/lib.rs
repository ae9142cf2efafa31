//! Decides whether a line is right: its real controllers composed and explored.
