//! How light moves.
