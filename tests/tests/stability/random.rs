//! Properties of random scenes.
