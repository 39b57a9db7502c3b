//! The editor as a person uses it, in a window that nobody sees: mouse, keyboard, and what screen readers are told.

mod access;
mod assets;
mod components;
mod files;
#[cfg(unix)]
mod full_disk;
mod inspector;
mod keyboard;
mod light;
mod main_path;
#[path = "../models/mod.rs"]
mod models;
mod objects;
mod panels;
mod preferences;
mod probes;
mod recovery;
mod scene;
mod waits;
mod window;
