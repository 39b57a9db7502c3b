//! Pictures of what was measured, as SVG and as PNG: each is laid out on a sheet once, and the sheet becomes both.

mod diagram;
mod labels;
mod scale;
mod sheet;
mod split;
#[cfg(test)]
mod tests;

use super::model::{Diagram, Split};
use crate::BakeError;

/// A picture in both forms.
pub struct Plot {
    pub id: String,
    pub svg: String,
    /// Without its title, for a page that has it as a heading.
    pub untitled_svg: String,
    pub png: Vec<u8>,
}

pub fn of_diagram(diagram: &Diagram) -> Result<Plot, BakeError> {
    let titled = diagram::sheet(diagram, true);
    let untitled = diagram::sheet(diagram, false);
    plot(&diagram.id, &diagram.title, &titled, &untitled)
}

pub fn of_split(split: &Split) -> Result<Plot, BakeError> {
    plot("split", "Where the error comes from", &split::sheet(split, true), &split::sheet(split, false))
}

fn plot(id: &str, title: &str, titled: &sheet::Sheet, untitled: &sheet::Sheet) -> Result<Plot, BakeError> {
    Ok(Plot {
        id: id.to_owned(),
        svg: titled.svg(title)?,
        untitled_svg: untitled.svg(title)?,
        png: titled.png()?,
    })
}
