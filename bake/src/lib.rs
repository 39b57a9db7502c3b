//! The bake.
