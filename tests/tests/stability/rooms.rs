//! Rooms and what joins them.
