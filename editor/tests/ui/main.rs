//! The editor as a person uses it, in a window that nobody sees: mouse, keyboard, and what screen readers are told.

mod inspector;
mod light;
mod objects;
mod panels;
mod probes;
mod scene;
mod window;
