//! Tests of the lift module as a whole: spectra against closed forms, lifts against invariances.

mod carry;
mod invariance;
mod iteration;
mod references;
mod shapes;
mod surface;
