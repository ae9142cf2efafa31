//! Tests of many nodes together
