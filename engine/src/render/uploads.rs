//! How much is brought to the GPU in one frame, where no frame may take long: the rest waits for the next ones.

/// Bytes of a frame. Without a limit nothing waits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Uploads {
    most: Option<u64>,
    spent: u64,
    waiting: u32,
}

impl Uploads {
    pub fn at_most(most: Option<u64>) -> Self {
        Self { most, ..Self::default() }
    }

    /// Another frame.
    pub fn begin(&mut self) {
        (self.spent, self.waiting) = (0, 0);
    }

    /// Whether it is brought now. The first of a frame is, however large it is.
    pub fn take(&mut self, bytes: u64) -> bool {
        let fits = self.most.is_none_or(|most| self.spent == 0 || self.spent + bytes <= most);
        if fits {
            self.spent += bytes.max(1);
        } else {
            self.waiting += 1;
        }
        fits
    }

    /// What had to wait in this frame.
    pub fn waiting(&self) -> u32 {
        self.waiting
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_takes_something_and_no_more_than_fits() {
        let mut uploads = Uploads::at_most(Some(100));
        let mut waiting = vec![250, 40, 40, 40, 90];
        let mut frames = 0;
        while !waiting.is_empty() {
            uploads.begin();
            let before = waiting.len();
            waiting.retain(|&bytes| !uploads.take(bytes));
            assert_eq!(uploads.waiting() as usize, waiting.len());
            assert!(waiting.len() < before);
            frames += 1;
        }
        assert_eq!(frames, 4);
        let mut all = Uploads::default();
        assert!((0..10).all(|_| all.take(u64::MAX / 20)) && all.waiting() == 0);
    }
}
