//! Cubemaps: near walls, inside solids, between mirrors.
