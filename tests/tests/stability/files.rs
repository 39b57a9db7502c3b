//! Files and threads.
