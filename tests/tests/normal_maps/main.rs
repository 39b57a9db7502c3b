//! Normal maps in indirect light: directional rows against gathers of their own, and what is drawn of them.

mod pictures;
mod rows;
