//! Shapes: tiny, huge, touching, thin, twice.
