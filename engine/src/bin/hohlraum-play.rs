//! The runtime: plays a scene of a project in a window, or frame by frame into files.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use engine::play::{self, Options};
use engine::render::View;

#[derive(Parser, Debug)]
#[command(
    name = "hohlraum-play",
    version,
    about = "Plays a scene of a project with live global illumination"
)]
struct Args {
    /// The project's folder.
    project: PathBuf,
    /// The scene; the project's default scene where none is named.
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Opens no window and draws as fast as it can.
    #[arg(long)]
    headless: bool,
    /// Ends after so many frames (headless: 1 where nothing is said).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Of the picture, in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    size: [u32; 2],
    /// Seconds from frame to frame, whatever the clock says.
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    fixed_dt: Option<f64>,
    /// Where pictures go: frame_00000.png and so on.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Of the frames, every K-th is written, and the last.
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// Writes what the run cost.
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,
    /// After the last frame, writes the light that the GPU solved: space,index,r,g,b.
    #[arg(long, value_name = "FILE.csv")]
    light: Option<PathBuf>,
    /// Passes light on so often in every frame, to measure what that brings, instead of by the bound of its error.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    products: Option<u32>,
    /// composite, direct, indirect, reflection, albedo, normal, patches, density, probes or tetrahedra.
    #[arg(long, value_name = "VIEW", default_value = "composite", value_parser = view)]
    view: View,
    /// Display = 2^EV * radiance, instead of the camera's.
    #[arg(long, value_name = "EV", value_parser = exposure, allow_negative_numbers = true)]
    exposure: Option<f32>,
    /// Pictures wait for the display.
    #[arg(long, value_name = "on|off", default_value = "on", value_parser = on_or_off, action = clap::ArgAction::Set)]
    vsync: bool,
    /// Writes times and counts over the picture.
    #[arg(long)]
    overlay: bool,
    /// Plays a bake whose certificate does not hold.
    #[arg(long)]
    force: bool,
    /// Without all that moves: static surfaces under lights that stay.
    #[arg(long)]
    still: bool,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let options = Options {
        project: args.project,
        scene: args.scene,
        headless: args.headless,
        frames: args.frames,
        size: args.size,
        fixed_dt: args.fixed_dt,
        out: args.out,
        every: args.every,
        stats: args.stats,
        light: args.light,
        products: args.products,
        view: args.view,
        exposure: args.exposure,
        vsync: args.vsync,
        overlay: args.overlay,
        force: args.force,
        still: args.still,
    };
    match play::run(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides =
        text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    let sides = sides.filter(|sides: &[u32; 2]| sides.iter().all(|side| (1..=32768).contains(side)));
    sides.ok_or_else(|| "give width and height in pixels, as 1280x720".to_owned())
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|seconds: &f64| seconds.is_finite() && *seconds >= 0.0);
    seconds.ok_or_else(|| "give seconds, 0 or more".to_owned())
}

fn exposure(text: &str) -> Result<f32, String> {
    let stops = text.parse().ok().filter(|stops: &f32| stops.abs() <= 64.0);
    stops.ok_or_else(|| "give stops between -64 and 64".to_owned())
}

fn on_or_off(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("give on or off".to_owned()),
    }
}

fn view(text: &str) -> Result<View, String> {
    let names = View::ALL.map(View::name).join(", ");
    let found = View::ALL.into_iter().find(|view| view.name() == text);
    found.ok_or_else(|| format!("there are: {names}"))
}
