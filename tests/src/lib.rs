//! The house that tests share.
