//! From frame to frame: switches, flicker, millions of frames.
