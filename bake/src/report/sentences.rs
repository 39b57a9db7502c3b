//! What the numbers say, in words: sentences whose every figure was measured.

use super::front::{Front, Verdict, is_measured, place};
use super::model::{ADDS_UP, Diagram, Part, Report, Series, Split};
use super::numbers::{factor, milliseconds, seconds, share, signed_share};
use super::trend::{Trend, trend};

/// A method that errs so many times more is hardly a choice.
const FAR: f64 = 1e4;

/// What was found, in three or four sentences.
pub fn summary(report: &Report) -> Vec<String> {
    [total(report), parts(report), Some(bake(report)), frame(report)].into_iter().flatten().collect()
}

fn total(report: &Report) -> Option<String> {
    let (total, reference) = (&report.split.total, report.split.reference_error);
    (total.rms > 0.0).then(|| {
        let known = if reference > 0.0 {
            format!(" The reference is known to {}.", share(reference))
        } else {
            String::new()
        };
        format!(
            "What the player shows is {} off (rms over the mean), with a signed mean of {}; the worst hundredth of \
             all points is off by {} and more.{known}",
            share(total.rms),
            signed_share(total.bias),
            share(total.p99),
        )
    })
}

fn parts(report: &Report) -> Option<String> {
    let in_sum = |part: &&Part| part.left_out.is_none() && !part.is_apart;
    let mut parts: Vec<&Part> = report.split.parts.iter().filter(in_sum).collect();
    parts.sort_by(|a, b| b.error.rms.total_cmp(&a.error.rms));
    let named: Vec<String> =
        parts.iter().take(3).map(|part| format!("{} ({})", part.name, share(part.error.rms))).collect();
    let [first, rest @ ..] = &named[..] else { return None };
    let then = if rest.is_empty() { String::new() } else { format!(", then {}", rest.join(" and ")) };
    Some(format!(
        "Most of it is {first}{then}; field by field the parts {} the total ({} of its norm is missing).",
        if report.split.adds_up() { "add up to" } else { "do not add up to" },
        share(report.split.unexplained)
    ))
}

/// Whether the parts add up to the total.
pub fn of_sum(split: &Split) -> Vec<String> {
    if split.total.rms == 0.0 {
        return Vec::new();
    }
    let (seeds, verdict) = (&split.seeds, if split.adds_up() { "They add up" } else { "They do not add up" });
    let noise = 0.5 * seeds.noise;
    let of_seeds = if seeds.is_noise() {
        "noise explains it".to_owned()
    } else {
        format!("noise leaves {} unexplained", share(seeds.beyond_noise()))
    };
    vec![
        format!(
            "{verdict}: the parts' fields, added point by point, miss the total's field by {} of its rms (at most {}). Both \
             end at the same path-traced field, which is known to {} of the mean: {} of the total is its noise.",
            share(split.unexplained),
            share(ADDS_UP),
            share(split.reference_error),
            share(noise),
        ),
        format!(
            "Where the parts end at one path-traced field and the total at another, of other seeds, they miss it by {}; \
             their noise alone, by the replicates of both, would make that {}: {of_seeds}.",
            share(seeds.missed),
            share(seeds.noise),
        ),
    ]
}

/// Where the error is.
pub fn of_worst(split: &Split) -> String {
    let of_all = split.worst.iter().map(|place| place.share).sum();
    format!(
        "{} of the squares of the total lie at these places, each of them one point of many. Where it is discretisation or \
         reconstruction, the density brush of the editor makes patches and receivers finer there alone.",
        share(of_all)
    )
}

/// How many curves reach their floors, and which do not.
pub fn of_curves(trends: &[Trend]) -> String {
    let (good, bad): (Vec<&Trend>, Vec<&Trend>) =
        trends.iter().filter(|trend| trend.is_curve()).partition(|trend| trend.holds());
    let count = good.len() + bad.len();
    let mut cut: Vec<&str> =
        good.iter().filter(|trend| !trend.reaches).filter_map(|trend| trend.ends.as_deref()).collect();
    let number = cut.len();
    cut.dedup();
    let or =
        if number > 0 { format!(", or ({number} of them) {}", cut.join(", or ")) } else { String::new() };
    if bad.is_empty() {
        return format!("All {count} curves fall until within twice their floors{or}.");
    }
    let named: Vec<String> = bad
        .iter()
        .map(|trend| {
            let how = match trend.reaches {
                true => "rises on the way".to_owned(),
                false => format!("ends at {} times its floor", factor(trend.least / trend.floor)),
            };
            format!("{} ({}) {how}", trend.series, trend.diagram)
        })
        .collect();
    let named = named.join("; ");
    format!("{} of {count} curves fall until within twice their floors{or}. {named}.", good.len())
}

/// How many shipped settings lie on the front.
pub fn of_presets(presets: &[Verdict]) -> String {
    let off: Vec<String> = presets
        .iter()
        .filter(|preset| !preset.on_front)
        .map(|preset| {
            let times = preset.error_factor.min(preset.x_factor);
            format!("{} in {} by {}", preset.preset, preset.diagram, factor(times))
        })
        .collect();
    match off.is_empty() {
        true => format!("All {} lie within 15 % of the front.", presets.len()),
        false => {
            let on = presets.len() - off.len();
            format!("{on} of {} lie within 15 % of the front; off it: {}.", presets.len(), off.join("; "))
        }
    }
}

fn bake(report: &Report) -> String {
    let certificate = &report.certificate;
    let threads = if certificate.threads == 1 { "thread" } else { "threads" };
    let took = if certificate.rays_traced > 0 {
        format!("took {} on {} {threads}", seconds(certificate.seconds), certificate.threads)
    } else {
        "was there already".to_owned()
    };
    format!(
        "The bake ({}, {} patches, {} receivers) {took} and is {} on disk.",
        report.quality,
        certificate.patches,
        certificate.receivers,
        super::numbers::bytes(certificate.bytes as f64),
    )
}

/// Passes that carry light, of all.
const LIGHT: [&str; 5] = ["direct", "bounce", "gather", "dering", "objects"];

fn frame(report: &Report) -> Option<String> {
    let frame = report.frame.as_ref().filter(|frame| !frame.passes.is_empty())?;
    let sum = |names: Option<&[&str]>| -> f64 {
        let counted =
            frame.passes.iter().filter(|pass| names.is_none_or(|names| names.contains(&&*pass.name)));
        counted.map(|pass| pass.median).sum()
    };
    let by = match report.machine.timing.as_deref() {
        Some("gpu") => "the GPU",
        _ => "the CPU, to record them,",
    };
    let whole = frame.whole.as_ref();
    let whole = whole.map_or(String::new(), |whole| {
        format!(" From picture to picture pass {}.", milliseconds(whole.median))
    });
    Some(format!(
        "A picture of the moving scene takes {by} {} in all passes, of which light on its way takes {}.{whole}",
        milliseconds(sum(None)),
        milliseconds(sum(Some(&LIGHT))),
    ))
}

/// What a diagram says: of its leading method, of the others, of the presets.
pub fn of_diagram(diagram: &Diagram, presets: &[Verdict]) -> Vec<String> {
    let front = Front::of(diagram);
    let on_front =
        |series: &Series| series.points.iter().filter(|point| front.contains(place(diagram, point))).count();
    let Some(leading) = diagram.series.iter().max_by_key(|series| on_front(series)) else {
        return vec!["Nothing was measured.".to_owned()];
    };
    let mut sentences = vec![of_leading(diagram, leading)];
    sentences.extend(of_others(diagram, leading, &front));
    sentences.extend(presets.iter().filter(|preset| preset.diagram == diagram.id).map(of_preset));
    sentences
}

fn of_leading(diagram: &Diagram, series: &Series) -> String {
    let trend = trend(diagram, series);
    let name = &series.name;
    let ends: Vec<[f64; 2]> =
        series.points.iter().map(|point| place(diagram, point)).filter(is_measured).collect();
    let (Some(first), Some(last)) = (ends.first(), ends.last()) else {
        return format!("Of {name} nothing was measured.");
    };
    let range = format!("from {} to {}", share(first[1]), share(last[1]));
    let slope = match trend.per_doubling {
        Some(per_doubling) => {
            format!("{name}: twice the cost gives {} times the error, {range}.", factor(per_doubling))
        }
        None => format!("{name}: the error goes {range}."),
    };
    let rises = if trend.falls { "" } else { " It rises on the way, above twice its floor." };
    let ends = match &trend.ends {
        Some(ends) => format!(" It goes {ends}."),
        None if trend.is_curve() && !trend.reaches => {
            format!(" It ends at {} times its floor.", factor(trend.least / trend.floor))
        }
        None => String::new(),
    };
    slope + rises + &ends
}

/// How many times more the others err at the same cost, in the middle of their points.
fn of_others(diagram: &Diagram, leading: &Series, front: &Front) -> Option<String> {
    let middle = |series: &Series| {
        let mut factors: Vec<f64> = series
            .points
            .iter()
            .map(|point| place(diagram, point))
            .filter(is_measured)
            .map(|[x, error]| error / front.error_at(x))
            .filter(|factor| factor.is_finite())
            .collect();
        factors.sort_by(f64::total_cmp);
        factors.get(factors.len() / 2).copied()
    };
    let told: Vec<String> = diagram
        .series
        .iter()
        .filter(|series| series.name != leading.name)
        .filter_map(|series| Some((&series.name, middle(series)?)))
        .map(|(name, times)| match times {
            ..1.02 => format!("{name} is as good"),
            FAR.. => format!("{name} has more than {FAR} times the error"),
            _ => format!("{name} has {} times the error", factor(times)),
        })
        .collect();
    (!told.is_empty()).then(|| format!("At the same cost as the best, {}.", told.join("; ")))
}

fn of_preset(preset: &Verdict) -> String {
    let Verdict { preset: name, setting, error_factor, x_factor, .. } = preset;
    if preset.on_front {
        return format!("\u{201c}{name}\u{201d} ({setting}) is on the front.");
    }
    format!(
        "\u{201c}{name}\u{201d} ({setting}) is off the front: the same error is to be had for {} of its cost, or {} of \
         its error for the same.",
        factor(1.0 / x_factor),
        factor(1.0 / error_factor)
    )
}

#[cfg(test)]
mod tests {
    use super::super::front::verdicts;
    use super::super::model::{Error, Point};
    use super::*;

    fn series(name: &str, points: &[[f64; 2]], preset: Option<&str>) -> Series {
        let point = |[x, rms]: [f64; 2]| Point {
            x,
            error: Error { rms, ..Error::default() },
            preset: preset.map(str::to_owned),
            ..Point::default()
        };
        Series::new(name, points.iter().copied().map(point).collect())
    }

    #[test]
    fn a_diagram_says_what_twice_the_cost_brings_and_what_the_others_miss() {
        let good = series("good", &[[1.0, 0.1], [4.0, 0.05]], Some("runtime"));
        let bad = series("bad", &[[1.0, 0.4], [4.0, 0.2]], None);
        let diagram = Diagram { id: "d".to_owned(), series: vec![bad, good], ..Diagram::default() };
        let said = of_diagram(&diagram, &verdicts(std::slice::from_ref(&diagram)));
        assert_eq!(said[0], "good: twice the cost gives 0.71 times the error, from 10 % to 5.0 %.");
        assert_eq!(said[1], "At the same cost as the best, bad has 4.00 times the error.");
        assert!(said[2].contains("runtime") && said[2].contains("is on the front"), "{said:?}");
    }

    #[test]
    fn nothing_measured_is_said() {
        assert_eq!(of_diagram(&Diagram::default(), &[]), ["Nothing was measured."]);
        let empty = Diagram { series: vec![series("none", &[], None)], ..Diagram::default() };
        assert_eq!(of_diagram(&empty, &[]), ["Of none nothing was measured."]);
        assert_eq!(summary(&Report::default()).len(), 1);
    }
}
