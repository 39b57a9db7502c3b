//! Direct light from punctual lights, at points.
