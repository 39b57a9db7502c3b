//! What the commands say: aligned text for people, one JSON object for programs.

use std::io::Write;
use std::process::ExitCode;

use bake::Plan;
use engine::transport::Certificate;
use engine::transport::needs::{Needs, Verdict, bytes};

/// The one object on stdout.
pub fn json(value: &impl serde::Serialize) {
    match serde_json::to_string_pretty(value) {
        Ok(object) => text(&(object + "\n")),
        Err(error) => eprintln!("error: {error}"),
    }
}

/// On stdout. A reader that has gone away is no failure of ours.
pub fn text(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// 1 where a statement does not hold, and stderr says which.
pub fn verdict(certificate: &Certificate) -> ExitCode {
    for broken in certificate.statements().iter().filter(|statement| !statement.holds) {
        eprintln!("does not hold: {} {:.3e}, the limit is {:.3e}", broken.what, broken.value, broken.limit);
    }
    if certificate.holds() { ExitCode::SUCCESS } else { ExitCode::from(1) }
}

pub fn plan(plan: &Plan) -> String {
    let mut text = table(&[
        ("scene", plan.scene.clone()),
        ("quality", plan.quality.clone()),
        ("patch length", format!("{:.4} m", plan.patch_length)),
        ("triangles", plan.triangles.to_string()),
        ("patches", plan.patches.to_string()),
        ("receivers", plan.receivers.to_string()),
        ("light probes", plan.probes.to_string()),
        ("sky patches", plan.sky_patches.to_string()),
        ("rays", format!("{}, of which {} are kept from before", plan.rays, plan.rays_kept)),
        ("time", format!("about {:.1} s", plan.seconds)),
        ("size", format!("about {}", bytes(plan.bytes))),
    ]);
    let known = if plan.exact { "counted in the last bake" } else { "about; exact after the bake" };
    text += &format!("needs ({known})\n");
    text += &verdicts(&plan.needs);
    text
}

/// A line a feature: whether it is there, its name, who needs it or why nobody does, and what that costs or saves.
fn verdicts(needs: &Needs) -> String {
    let widest = needs.verdicts.iter().map(|verdict| verdict.feature.name().len()).max().unwrap_or(0);
    let line = |verdict: &Verdict| {
        let (mark, name, price) = (verdict.mark(), verdict.feature.name(), verdict.price());
        let price = if price.is_empty() { price } else { format!(" ({price})") };
        format!("  {mark:<10}  {name:<widest$}  {}{price}\n", verdict.why)
    };
    needs.verdicts.iter().map(line).collect()
}

pub fn certificate(certificate: &Certificate) -> String {
    let c = certificate;
    let mut text = table(&[
        ("transport hash", c.transport_hash.clone()),
        ("quality", format!("{}, patch length {:.4} m", c.quality, c.base_length)),
        ("triangles", format!("{}, {} dropped", c.triangles, c.dropped_triangles)),
        ("patches", format!("{}, {} entries", c.patches, c.entries[0])),
        ("receivers", format!("{}, {} entries", c.receivers, c.entries[1])),
        ("light probes", format!("{}, {} entries", c.probes, c.entries[2])),
        ("sky patches", c.sky_patches.to_string()),
        ("rays", format!("{}, {} of them now", c.rays, c.rays_traced)),
        ("time", format!("{:.2} s on {} threads", c.seconds, c.threads)),
        ("size", bytes(c.bytes)),
        (
            "noise",
            format!("{:.2} % median, {:.2} % at worst of 95 %", 100.0 * c.noise[0], 100.0 * c.noise[1]),
        ),
        ("cavity gain", format!("{:.2} at `{}`", c.cavity_gain, c.cavity_gain_entity)),
    ]);
    text += "statements\n";
    for statement in c.statements() {
        let mark = if statement.holds { "holds" } else { "BROKEN" };
        let (what, value, limit) = (statement.what, statement.value, statement.limit);
        text += &format!("  {mark:<6}  {what:<38}  {value:>10.2e}  at most {limit:.2e}\n");
    }
    text += &list("left out", &c.left_out);
    text += &list("warnings", &c.warnings);
    text
}

fn table(rows: &[(&str, String)]) -> String {
    rows.iter().map(|(name, value)| format!("{name:<16}{value}\n")).collect()
}

fn list(title: &str, lines: &[String]) -> String {
    if lines.is_empty() {
        return String::new();
    }
    lines.iter().fold(format!("{title}\n"), |text, line| text + &format!("  {line}\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_broken_statement_is_marked() {
        let broken = Certificate { asymmetry: f64::NAN, ..Certificate::default() };
        let text = certificate(&broken);
        assert_eq!(text.matches("BROKEN").count(), 1, "{text}");
        assert_eq!(verdict(&broken), ExitCode::from(1));
    }

    #[test]
    fn each_feature_has_a_line_and_what_is_forced_is_marked() {
        use engine::scene::{Feature, Forced};
        let mut needs = Needs::all();
        needs.verdicts[Feature::Sky as usize].is_in = false;
        needs.verdicts[Feature::Holes as usize].forced = Some(Forced::In);
        needs.verdicts[Feature::Holes as usize].saving.file_bytes = 1500;
        let text = verdicts(&needs);
        assert_eq!(text.lines().count(), Feature::ALL.len());
        let line = |name: &str| text.lines().find(|line| line.contains(&format!("  {name}  "))).unwrap();
        assert!(line("sky").starts_with("  out "), "{text}");
        assert!(line("test for holes").starts_with("  forced in") && text.contains("(takes 1.5 kB of file)"));
    }

    #[test]
    fn sizes_read_well() {
        assert_eq!([0, 999, 1500, 2_500_000].map(bytes), ["0 B", "999 B", "1.5 kB", "2.5 MB"]);
    }
}
