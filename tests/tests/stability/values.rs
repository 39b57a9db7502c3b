//! Values: not finite, out of range, on top of a light.
