//! Numbers in the named columns of a CSV file; what is wrong is told by file, line and column.

use std::path::Path;

use anyhow::{Context, Result, bail};

/// A row's numbers, and the line that it stands on (from 1).
#[derive(Debug, PartialEq)]
pub struct Row<const N: usize> {
    pub line: usize,
    pub numbers: [f64; N],
}

/// Columns are found by name; others are ignored, as are blank lines.
pub fn read<const N: usize>(file: &Path, names: [&str; N]) -> Result<Vec<Row<N>>> {
    let bytes = std::fs::read(file).with_context(|| file.display().to_string())?;
    rows(&bytes, names).with_context(|| file.display().to_string())
}

fn rows<const N: usize>(bytes: &[u8], names: [&str; N]) -> Result<Vec<Row<N>>> {
    let mut reader = csv::ReaderBuilder::new().flexible(true).trim(csv::Trim::All).from_reader(bytes);
    let header = reader.headers()?.clone();
    let mut columns = [0; N];
    for (column, name) in columns.iter_mut().zip(names) {
        let found = header.iter().position(|title| title == name);
        *column = found.with_context(|| format!("line 1: there is no column `{name}`"))?;
    }
    let row = |record: csv::StringRecord| {
        let line = line_at(bytes, record.position().map_or(0, csv::Position::byte) as usize);
        let mut numbers = [0.0; N];
        for ((number, column), name) in numbers.iter_mut().zip(columns).zip(names) {
            let text = record.get(column).unwrap_or("");
            *number = parsed(text).with_context(|| format!("line {line}, column {name}"))?;
        }
        Ok(Row { line, numbers })
    };
    reader.records().map(|record| row(record?)).collect()
}

/// The reader says where it stood before it skipped blank lines.
fn line_at(bytes: &[u8], mut at: usize) -> usize {
    while bytes.get(at).is_some_and(|byte| b"\r\n".contains(byte)) {
        at += 1;
    }
    1 + bytes.iter().take(at).filter(|byte| **byte == b'\n').count()
}

fn parsed(text: &str) -> Result<f64> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => bail!("`{text}` is no finite number"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name_whatever_else_is_there() {
        let text = "\u{feff}y, name ,x\r\n\r\n 2 ,\"a, b\",1e0\r\n4,,3,more\r\n";
        let read = rows(text.as_bytes(), ["x", "y"]).unwrap();
        assert_eq!(read, [Row { line: 3, numbers: [1.0, 2.0] }, Row { line: 4, numbers: [3.0, 4.0] }]);
    }
}
