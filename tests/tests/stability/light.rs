//! Energy: what is known exactly of any room.
