//! The stability catalogue: stiff and extreme cases, each through the real pipeline, each a sentence.

mod absurd;
mod cubemaps;
mod files;
mod frames;
mod hostile;
mod light;
mod near;
mod overlap;
mod probes;
mod random;
mod refused;
mod rooms;
mod rows;
mod scale;
mod shapes;
mod values;
