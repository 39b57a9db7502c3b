//! From the mouse to the camera, and from the mouse to edits.

pub mod drop;
pub mod hit;
pub mod navigate;
pub mod probes;
pub mod slice;
pub mod surface;
pub mod transform;
pub mod web;
