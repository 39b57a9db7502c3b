//! Work on a thread of its own, asked for its result with every picture: nobody waits for it.

use std::thread::JoinHandle;

pub struct Job<T> {
    thread: Option<JoinHandle<T>>,
}

impl<T: Send + 'static> Job<T> {
    pub fn start(name: &str, work: impl FnOnce() -> T + Send + 'static) -> std::io::Result<Self> {
        let thread = std::thread::Builder::new().name(name.to_owned()).spawn(work)?;
        Ok(Self { thread: Some(thread) })
    }

    /// `None`: it goes on. An error: it panicked.
    pub fn poll(&mut self) -> Option<Result<T, String>> {
        let thread = self.thread.take_if(|thread| thread.is_finished())?;
        Some(thread.join().map_err(|_| "a thread of the editor failed: see the terminal".to_owned()))
    }
}
