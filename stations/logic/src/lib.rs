//! One station's controller: process image in, outputs and events out
