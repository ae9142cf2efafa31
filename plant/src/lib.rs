//! The simulated plant: mechanisms and the CAN devices they hang on
