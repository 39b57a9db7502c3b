//! The editor as a person uses it, in a window that nobody sees: mouse, keyboard, and what screen readers are told.

mod inspector;
mod objects;
mod panels;
mod window;
