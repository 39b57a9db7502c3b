//! The editor as a person uses it, in a window that nobody sees: mouse, keyboard, and what screen readers are told.

mod assets;
mod inspector;
#[path = "../models/mod.rs"]
mod models;
mod objects;
mod panels;
mod window;
