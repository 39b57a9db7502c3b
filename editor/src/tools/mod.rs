//! From the mouse to the camera, and from the mouse to edits.

pub mod drop;
pub mod navigate;
pub mod surface;
pub mod transform;
