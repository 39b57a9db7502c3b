//! The command line of `hohlraum-bake`. What is out of range is refused here, as wrong usage.

use std::path::PathBuf;

use bake::report::ReportSettings;
use bake::{Method, Settings};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use engine::scene::file::Quality;
use glam::Vec3;

/// Bakes how light moves through the scenes of a project
#[derive(Debug, Parser)]
#[command(
    name = "hohlraum-bake",
    version,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    disable_help_subcommand = true,
    override_usage = "hohlraum-bake [OPTIONS] PROJECT\n       hohlraum-bake new PROJECT --from FILE...\n       \
                      hohlraum-bake plan|check PROJECT\n       hohlraum-bake query PROJECT --points|--probes IN.csv --out OUT.csv\n       \
                      hohlraum-bake report PROJECT --out DIR",
    after_help = "A project folder with the name of a command is reached as ./NAME.\n\
                  Exit codes: 0 done, 1 a check or the job failed, 2 wrong usage."
)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Absent where a command is given.
    #[command(flatten)]
    pub scene: Option<SceneArgs>,
    #[command(flatten)]
    pub bake: BakeArgs,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Make a project from glTF, GLB and OBJ files
    New(NewArgs),
    /// Tell what would be baked, how long it takes and what is left out; bakes nothing
    Plan(PlanArgs),
    /// Check the certificate of the bake on disk
    Check(CheckArgs),
    /// Light at points of one's own
    Query(QueryArgs),
    /// Measure error against run time: tables, plots and a page
    Report(ReportArgs),
}

#[derive(Debug, Args)]
pub struct BakeArgs {
    #[command(flatten)]
    pub rays: RayArgs,
    /// Bake everything anew, whatever is there
    #[arg(long)]
    pub force: bool,
    /// Print one JSON object on stdout
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct PlanArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub rays: RayArgs,
    /// Print one JSON object on stdout
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Print one JSON object on stdout
    #[arg(long)]
    pub json: bool,
}

/// Which bake of which project.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// The project's folder
    #[arg(value_name = "PROJECT")]
    pub project: PathBuf,
    /// A scene of the project, instead of its default one
    #[arg(long, value_name = "NAME")]
    pub scene: Option<String>,
    /// draft, standard or fine, instead of what the project says
    #[arg(long, value_parser = quality(), hide_possible_values = true)]
    pub quality: Option<Quality>,
}

#[derive(Debug, Args)]
pub struct RayArgs {
    /// Rays a row
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub rays: Option<u32>,
    /// Length of a patch
    #[arg(long, value_name = "METRES", value_parser = length, allow_negative_numbers = true)]
    pub patch_length: Option<f64>,
    /// As many as the machine has where nothing is said
    #[arg(long, value_name = "N", value_parser = threads())]
    pub threads: Option<usize>,
}

#[derive(Debug, Args)]
pub struct NewArgs {
    /// The folder to make
    #[arg(value_name = "PROJECT")]
    pub project: PathBuf,
    /// Each becomes a scene; the first is the default one
    #[arg(long, value_name = "FILE", required = true, num_args = 1..)]
    pub from: Vec<PathBuf>,
    /// A sky of this radiance all around [W/m2/sr]
    #[arg(long, value_name = "R,G,B", value_parser = radiance, allow_hyphen_values = true)]
    pub sky: Option<Vec3>,
    /// Print one JSON object on stdout
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("input").required(true).args(["points", "probes"]))]
pub struct QueryArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Points on surfaces (columns x,y,z,nx,ny,nz): irradiance there [W/m2]
    #[arg(long, value_name = "IN.csv")]
    pub points: Option<PathBuf>,
    /// Points in space (columns x,y,z): nine spherical harmonics of the radiance that arrives there
    #[arg(long, value_name = "IN.csv")]
    pub probes: Option<PathBuf>,
    /// The answers, row for row
    #[arg(long, value_name = "OUT.csv")]
    pub out: PathBuf,
    /// receivers: what the runtime shows there; gather: a fresh final gather
    #[arg(long, value_parser = method(), hide_possible_values = true, conflicts_with = "probes")]
    pub method: Option<Method>,
    /// Ask a bake whose certificate does not hold, too
    #[arg(long)]
    pub force: bool,
    /// Print one JSON object on stdout
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct ReportArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The folder of the report; it is made where it is not there
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// What the whole report may take, baking included; what does not fit is left out and named
    #[arg(long, value_name = "SECONDS", default_value = "300", value_parser = budget, allow_negative_numbers = true)]
    pub budget: f64,
    /// As many as the machine has where nothing is said
    #[arg(long, value_name = "N", value_parser = threads())]
    pub threads: Option<usize>,
    /// Print one JSON object on stdout
    #[arg(long)]
    pub json: bool,
}

impl SceneArgs {
    pub fn name(&self) -> Option<&str> {
        self.scene.as_deref()
    }

    pub fn settings(&self) -> Settings {
        Settings { quality: self.quality, ..Settings::default() }
    }
}

impl QueryArgs {
    pub fn settings(&self) -> Settings {
        Settings { force: self.force, ..self.scene.settings() }
    }
}

impl ReportArgs {
    pub fn settings(&self) -> ReportSettings {
        let (quality, out) = (self.scene.quality, self.out.clone());
        ReportSettings { quality, threads: self.threads, budget: self.budget, out }
    }
}

impl RayArgs {
    pub fn settings(&self, scene: &SceneArgs, force: bool) -> Settings {
        Settings {
            rays: self.rays,
            patch_length: self.patch_length,
            threads: self.threads,
            force,
            ..scene.settings()
        }
    }
}

fn quality() -> impl TypedValueParser<Value = Quality> {
    PossibleValuesParser::new(["draft", "standard", "fine"]).map(|name| match name.as_str() {
        "draft" => Quality::Draft,
        "fine" => Quality::Fine,
        _ => Quality::Standard,
    })
}

fn method() -> impl TypedValueParser<Value = Method> {
    PossibleValuesParser::new(["receivers", "gather"]).map(|name| match name.as_str() {
        "gather" => Method::Gather,
        _ => Method::Receivers,
    })
}

/// More threads than any machine has are a slip of the finger, and would end in the operating system's refusal.
fn threads() -> impl TypedValueParser<Value = usize> {
    clap::value_parser!(u16).range(1..=1024).map(usize::from)
}

fn length(text: &str) -> Result<f64, String> {
    let metres: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if metres.is_finite() && metres > 0.0 { Ok(metres) } else { Err("must be above 0".to_owned()) }
}

fn budget(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if seconds.is_finite() && seconds >= 1.0 {
        Ok(seconds)
    } else {
        Err("must be at least 1 second".to_owned())
    }
}

fn radiance(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> = text
        .split(',')
        .map(|number| number.trim().parse().map_err(|_| format!("`{number}` is not a number")))
        .collect::<Result<_, _>>()?;
    let [r, g, b] = numbers[..] else { return Err(format!("{} numbers where three belong", numbers.len())) };
    let radiance = Vec3::new(r, g, b);
    let proper = radiance.is_finite() && radiance.min_element() >= 0.0;
    if proper { Ok(radiance) } else { Err("radiance is finite and at least 0".to_owned()) }
}
