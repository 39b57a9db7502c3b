//! The stability catalogue: stiff and extreme cases, each through the real pipeline, each a sentence.

mod absurd;
mod cubemaps;
mod files;
mod frames;
mod hostile;
mod light;
mod probes;
mod random;
mod rooms;
mod rows;
mod shapes;
mod values;
