//! `linewright analyse`: what is true of any place/transition net, read from PNML.
