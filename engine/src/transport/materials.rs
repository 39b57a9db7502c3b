//! Albedo and emission of patches, from the scene's materials and pictures.
