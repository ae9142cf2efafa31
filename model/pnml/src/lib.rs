//! Petri nets as PNML, the exchange format of ISO/IEC 15909-2: read, with errors that have a position, and written.
