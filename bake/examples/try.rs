use bake::report::{ReportSettings, report};
struct Say(std::time::Instant);
impl bake::Watcher for Say {
    fn stage(&self, name: &str, steps: u64) {
        eprintln!("{:7.2} {name} {steps}", self.0.elapsed().as_secs_f64());
    }
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let settings = ReportSettings {
        quality: None,
        threads: None,
        budget: args[2].parse().unwrap(),
        out: "/tmp/exp-out".into(),
    };
    let r = report(std::path::Path::new(&args[1]), None, &settings, &Say(std::time::Instant::now())).unwrap();
    println!("seconds {:.1} of {}", r.seconds, r.budget);
    for d in &r.diagrams {
        println!("\n## {} {}  [{:?}]", d.id, d.title, d.norm);
        for f in &d.floors {
            println!("   floor {:40} {:.3e}", f.name, f.y);
        }
        for s in &d.series {
            println!("  {}", s.name);
            for p in &s.points {
                println!(
                    "    {:44} x {:10.4} [{:.4} {:.4}] n {} rms {:.3e} bias {:+.2e} p99 {:.2e} max {:.2e} {}",
                    p.setting,
                    p.x,
                    p.x_range[0],
                    p.x_range[1],
                    p.runs,
                    p.error.rms,
                    p.error.bias,
                    p.error.p99,
                    p.error.max,
                    p.preset.as_deref().unwrap_or("")
                );
            }
        }
    }
    println!("\n## split  {}", r.split.about);
    for p in &r.split.parts {
        println!(
            "  {:24} rms {:.3e} bias {:+.2e} p99 {:.2e} max {:.2e}  {} {}",
            p.name,
            p.error.rms,
            p.error.bias,
            p.error.p99,
            p.error.max,
            p.compared,
            p.left_out.as_deref().unwrap_or("")
        );
    }
    println!(
        "  total rms {:.3e} bias {:+.2e} p99 {:.2e} max {:.2e} unexplained {:.4} reference {:.3e}",
        r.split.total.rms,
        r.split.total.bias,
        r.split.total.p99,
        r.split.total.max,
        r.split.unexplained,
        r.split.reference_error
    );
    println!("\n## advice");
    for a in &r.advice {
        println!("  {:40} {:60} cost {:.2} error {:.2}", a.goal, a.change, a.cost, a.error);
    }
    println!("\n## notes");
    for n in &r.notes {
        println!("  {n}");
    }
}
