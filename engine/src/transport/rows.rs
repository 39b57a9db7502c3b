//! One sparse row type for all transport: compressed rows of (column, weight).

/// Row i holds `columns[starts[i] .. starts[i + 1]]`, ascending, with their weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    pub starts: Vec<u64>,
    pub columns: Vec<u32>,
    pub weights: Vec<f32>,
}

impl Default for Rows {
    fn default() -> Self {
        Self { starts: vec![0], columns: Vec::new(), weights: Vec::new() }
    }
}

impl Rows {
    /// How many rows.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many entries in all rows.
    pub fn entries(&self) -> usize {
        self.columns.len()
    }

    pub fn push(&mut self, row: impl IntoIterator<Item = (u32, f32)>) {
        for (column, weight) in row {
            self.columns.push(column);
            self.weights.push(weight);
        }
        self.starts.push(self.columns.len() as u64);
    }

    pub fn range(&self, row: usize) -> std::ops::Range<usize> {
        self.starts[row] as usize..self.starts[row + 1] as usize
    }

    pub fn row(&self, row: usize) -> impl ExactSizeIterator<Item = (u32, f32)> + Clone + '_ {
        let range = self.range(row);
        self.columns[range.clone()].iter().copied().zip(self.weights[range].iter().copied())
    }

    /// The f64 sum of what is stored.
    pub fn sum(&self, row: usize) -> f64 {
        self.weights[self.range(row)].iter().map(|&weight| f64::from(weight)).sum()
    }

    pub fn bytes(&self) -> usize {
        self.starts.len() * 8 + self.columns.len() * 8
    }

    /// `shares`: weights are shares of the light that arrives, >= 0 and at most 1 a row (within 1e-6).
    pub fn validate(&self, rows: usize, columns: usize, shares: bool) -> Result<(), String> {
        if self.starts.len() != rows + 1 || self.starts[0] != 0 {
            return Err(format!("{} starts for {rows} rows", self.starts.len()));
        }
        if self.columns.len() != self.weights.len()
            || *self.starts.last().unwrap_or(&0) != self.columns.len() as u64
        {
            return Err("starts, columns and weights disagree".to_owned());
        }
        if self.starts.windows(2).any(|pair| pair[0] > pair[1]) {
            return Err("starts descend".to_owned());
        }
        for row in 0..rows {
            let range = self.range(row);
            if self.columns[range.clone()].windows(2).any(|pair| pair[0] >= pair[1])
                || self.columns[range.clone()].last().is_some_and(|&column| column as usize >= columns)
            {
                return Err(format!("row {row} names columns out of order or out of range"));
            }
            if self.weights[range].iter().any(|weight| !weight.is_finite() || (shares && *weight < 0.0)) {
                return Err(format!("row {row} has a weight that is no share"));
            }
            if shares && self.sum(row) > 1.0 + 1e-6 {
                return Err(format!("row {row} sums to {}", self.sum(row)));
            }
        }
        Ok(())
    }
}
