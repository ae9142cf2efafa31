//! Whether a net is bounded, by the coverability graph.
