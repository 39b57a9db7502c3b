//! The report: error against run time, every point measured on this machine in this run.
//!
//! Work-precision diagrams in the sense of numerical analysis: what a setting costs along x, how wrong it is along y,
//! both logarithmic, one line a method. And where the error comes from: one switch at a time, from what the player
//! shows to a path tracer that shares nothing with it but the triangles.

pub mod experiments;
pub mod model;

pub use model::Report;
