//! Petri nets: structure, marking, token game and structural analysis
