//! Tables for programs: one a diagram, one of the split, one of the advice. Columns are told in the README.

use super::front::{Front, place};
use super::model::{Advice, Diagram, Error, Split};
use crate::BakeError;

pub fn diagram(diagram: &Diagram) -> Result<Vec<u8>, BakeError> {
    let front = Front::of(diagram);
    let header = "method,setting,x,x_least,x_largest,runs,rms,bias,p99,max,preset,on_front,rms_error";
    let rows = diagram.series.iter().flat_map(|series| {
        let front = &front;
        series.points.iter().map(move |point| {
            let mut row = vec![series.name.clone(), point.setting.clone(), point.x.to_string()];
            row.extend(point.x_range.map(|x| x.to_string()));
            row.push(point.runs.to_string());
            row.extend(numbers(&point.error));
            row.push(point.preset.clone().unwrap_or_default());
            row.push(front.contains(place(diagram, point)).to_string());
            row.push(point.spread.to_string());
            row
        })
    });
    table(header, rows)
}

pub fn split(split: &Split) -> Result<Vec<u8>, BakeError> {
    let row = |part: &str, compared: &str, error: &Error, left_out: &str| {
        let numbers = numbers(error);
        [&[part.to_owned(), compared.to_owned()], &numbers[..], &[left_out.to_owned()]].concat()
    };
    let of = |part: &super::model::Part| {
        row(&part.name, &part.compared, &part.error, part.left_out.as_deref().unwrap_or_default())
    };
    let parts = |apart: bool| split.parts.iter().filter(move |part| part.is_apart == apart).map(of);
    let total = row("total", "what the player shows against the reference", &split.total, "");
    table("part,compared,rms,bias,p99,max,left_out", parts(false).chain([total]).chain(parts(true)))
}

pub fn advice(advice: &[Advice]) -> Result<Vec<u8>, BakeError> {
    let rows = advice.iter().map(|advice| {
        vec![advice.goal.clone(), advice.change.clone(), advice.cost.to_string(), advice.error.to_string()]
    });
    table("goal,change,cost,error", rows)
}

fn numbers(error: &Error) -> [String; 4] {
    [error.rms, error.bias, error.p99, error.max].map(|number| number.to_string())
}

fn table(header: &str, rows: impl Iterator<Item = Vec<String>>) -> Result<Vec<u8>, BakeError> {
    let failed = |error: csv::Error| BakeError::Other(format!("a table was not written: {error}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header.split(',')).map_err(failed)?;
    for row in rows {
        writer.write_record(row).map_err(failed)?;
    }
    writer.into_inner().map_err(|error| failed(error.into_error().into()))
}

#[cfg(test)]
mod tests {
    use super::super::model::{Part, Point, Series};
    use super::*;

    fn text(table: Result<Vec<u8>, BakeError>) -> String {
        String::from_utf8(table.unwrap()).unwrap()
    }

    #[test]
    fn points_say_what_they_cost_how_wrong_they_are_and_whether_something_beats_them() {
        let error = |rms| Error { rms, bias: -0.5 * rms, p99: 2.0 * rms, max: 0.1 + 0.2 };
        let point = |setting: &str, x, rms| Point {
            setting: setting.to_owned(),
            x,
            x_range: [x, x],
            runs: 3,
            error: error(rms),
            spread: 0.25,
            preset: None,
        };
        let mut points = vec![point("1 ray", 1.0, 0.5), point("2, or more", 2.0, 0.75)];
        points[0].preset = Some("draft".to_owned());
        let series = vec![Series::new("rays", points)];
        let text = text(diagram(&Diagram { series, ..Diagram::default() }));
        let lines: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(lines[0], "rays,1 ray,1,1,1,3,0.5,-0.25,1,0.30000000000000004,draft,true,0.25");
        assert_eq!(lines[1], "rays,\"2, or more\",2,2,2,3,0.75,-0.375,1.5,0.30000000000000004,,false,0.25");
    }

    #[test]
    fn the_split_ends_with_its_total() {
        let part =
            Part { name: "lag".to_owned(), left_out: Some("nothing moves".to_owned()), ..Part::default() };
        let text = text(split(&Split { parts: vec![part], ..Split::default() }));
        let rows: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(rows[0], "lag,,0,0,0,0,nothing moves");
        assert!(rows[1].starts_with("total,"), "{rows:?}");
    }
}
