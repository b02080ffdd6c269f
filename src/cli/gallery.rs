//! `milkglass gallery`: meshes in materials, as one page of pictures with the commands that make them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};

use super::device::DeviceArgument;
use super::memory::MemoryArgument;
use super::render::parse_size;
use super::run_args::{OptionArguments, quoted};
use super::{check_messages, open_session, print, run_first_sample, validation};
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::{Change, Mode, Options, ShadingMethod};
use milkglass::measure::folder::{Folder, GALLERY};
use milkglass::measure::report::{escape, png};
use milkglass::scene::{Preset, Studio, Wishes};

/// Built-in shapes that are shown if no file is given.
const SHAPES: [&str; 4] = ["bust", "lotus", "torus", "gecko"];

/// The environment that is the studio's own.
const STUDIO: &str = "studio";

/// Arguments of `gallery`.
#[derive(Args)]
#[command(
    after_help = "Example: milkglass gallery bunny.obj -o gallery --materials marble,skin1 --environments studio,builtin:sky"
)]
pub struct Arguments {
    /// Meshes [default: four built-in shapes].
    #[arg(value_parser = super::paths::any_path())]
    files: Vec<String>,
    /// The folder of the page and its pictures: new, empty, or one with an earlier gallery.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Materials, as `milkglass materials` lists them.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_value = "marble,skin1,potato,ketchup")]
    materials: Vec<String>,
    /// Surroundings: `studio`, `builtin:sky`, or image files (.exr, .hdr).
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_value = STUDIO)]
    environments: Vec<String>,
    /// Width and height of each picture, in pixels.
    #[arg(long, value_name = "WxH", default_value = "256x256")]
    size: String,
    /// Samples per pixel, 1 to 64.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=64))]
    samples: u32,
    /// How light is transported through the material, as for `render`.
    #[arg(long, value_enum, default_value_t)]
    transport: ShadingMethod,
    #[command(flatten)]
    device: DeviceArgument,
    #[command(flatten)]
    memory: MemoryArgument,
}

/// A picture of the page: its file, what it shows, the command that makes it, and how long that took.
struct Shown {
    stem: String,
    material: String,
    command: String,
    seconds: f64,
    /// Its bytes, r g b row by row.
    pixels: Vec<u8>,
    /// Its scene file, where there is no mesh file.
    scene: Option<String>,
}

/// A mesh in an environment: its pictures, one per material.
struct Row {
    name: String,
    shown: Vec<Shown>,
}

/// Renders the pictures and writes the page.
pub fn run(arguments: &Arguments) -> Result<()> {
    let size = parse_size(&arguments.size)?;
    let folder = Folder::open(&arguments.output, &GALLERY, "-o")?;
    let given = !arguments.files.is_empty();
    let meshes: Vec<String> = if given { arguments.files.clone() } else { SHAPES.map(str::to_owned).to_vec() };
    arguments.check()?;
    let device = arguments.device.open(validation())?;
    let count = meshes.len() * arguments.environments.len() * arguments.materials.len();
    let mut rows: Vec<Row> = Vec::new();
    for (number, mesh) in meshes.iter().enumerate() {
        for (around, environment) in arguments.environments.iter().enumerate() {
            let name = Path::new(mesh).file_name().unwrap_or_default().to_string_lossy();
            let mut row = Row { name: format!("{name}, {environment}"), shown: Vec::new() };
            for material in &arguments.materials {
                let number = given.then_some(number);
                let first = row.shown.is_empty();
                let shown =
                    arguments.shown((number, mesh), (around, environment), material, size, device.as_ref(), first)?;
                let done = rows.len() * arguments.materials.len() + row.shown.len() + 1;
                tell!("{done}/{count} {}: {:.1} s", shown.stem, shown.seconds);
                row.shown.push(shown);
            }
            rows.push(row);
        }
    }
    let mut files = vec![("sheet.png".to_owned(), sheet(&rows, size)?)];
    for shown in rows.iter().flat_map(|row| &row.shown) {
        files.push((format!("{}.png", shown.stem), png(size, &shown.pixels)?));
        files.extend(shown.scene.iter().map(|toml| (format!("{}.toml", shown.stem), toml.clone().into_bytes())));
    }
    folder.fill(&page(&rows, size), &files)?;
    print(&format!("{}\n", arguments.output.join(GALLERY.page).display()))
}

impl Arguments {
    /// Refuses, before the first picture, meshes that can't be read, materials and environments that don't exist, and
    /// those that are named twice.
    fn check(&self) -> Result<()> {
        let fault = |what: &str, key: &str, found: &str| Input::new(what).key(key).found(format!("`{found}`"));
        let mut materials = BTreeSet::new();
        for name in &self.materials {
            let preset = Preset::find(name, "--materials")?;
            if !materials.insert(preset.name) {
                return Err(fault("is there twice", "--materials", name).expected("each material once").into());
            }
        }
        let mut environments = BTreeSet::new();
        for name in &self.environments {
            let image = [".exr", ".hdr"].iter().any(|end| name.to_ascii_lowercase().ends_with(end));
            if !([STUDIO, "builtin:sky", "builtin:studio"].contains(&name.as_str())
                || image && Path::new(name).is_file())
            {
                let expected = "`studio`, `builtin:sky`, or an image, a .exr or .hdr file";
                return Err(fault("not an environment", "--environments", name).expected(expected).into());
            }
            if !environments.insert(name) {
                return Err(fault("is there twice", "--environments", name).expected("each environment once").into());
            }
        }
        self.files.iter().try_for_each(|mesh| self.around(mesh, Wishes::default()).map(drop))
    }

    /// The studio around a mesh file.
    fn around(&self, mesh: &str, wishes: Wishes) -> Result<Studio> {
        Studio::around(mesh, &[], 0.0, &self.memory.files(), wishes)?.ok_or_else(|| {
            let fault = Input::new("not a mesh alone").key("FILE").found(mesh);
            fault.expected("a mesh: OBJ, PLY, STL or glTF").into()
        })
    }

    /// Renders a picture of a mesh file, by its number, or of a built-in shape, in an environment. The `first` of a row
    /// says what the studio assumed.
    fn shown(
        &self,
        (number, mesh): (Option<usize>, &str),
        (around, environment): (usize, &str),
        material: &str,
        size: [u32; 2],
        device: Option<&Device>,
        first: bool,
    ) -> Result<Shown> {
        let start = Instant::now();
        // A shape's scene file lies in another folder than the image.
        let moves = number.is_none() && Path::new(environment).is_file();
        let image = if moves { absolute(environment) } else { environment.to_owned() };
        let image = (environment != STUDIO).then_some(image);
        let (samples, pixels) = (Some(self.samples), Some(size));
        let preset = Some(material.to_owned());
        let wishes = Wishes { preset, samples, pixels, environment: image.clone(), ..Wishes::default() };
        let memory = || self.memory.files();
        let studio = match number {
            Some(_) => self.around(mesh, wishes)?,
            None => Studio::around_shape(mesh, &memory(), wishes)?,
        };
        studio.told.iter().skip(usize::from(!first)).for_each(|line| tell!("{line}"));
        let run = OptionArguments { mode: Mode::default(), transport: self.transport };
        let scene = studio.scene(0.0, &run.of(&[]), 0.0, &memory())?;
        let material = Preset::named(material).map_or(material.to_owned(), |preset| preset.name.to_lowercase());
        let number = number.map_or_else(String::new, |number| format!("-{number}"));
        let around = image.as_ref().map_or_else(String::new, |_| format!("-in-{around}"));
        let stem = format!("{}{number}-{}{around}", plain(&scene.name), plain(&material));
        let pixels = pixels_of(&scene, device, run.options())?;
        let value = self.transport.to_possible_value().filter(|_| self.transport != ShadingMethod::default());
        let method = value.map_or_else(String::new, |value| format!(" --transport {}", value.get_name()));
        let (command, scene) = if number.is_empty() {
            (format!("milkglass render {stem}.toml{method} -o {stem}.png"), Some(studio.toml()))
        } else {
            let ([width, height], samples, mesh) = (size, self.samples, quoted(mesh));
            let around = image.map_or_else(String::new, |image| format!(" --environment {}", quoted(&image)));
            let command = format!(
                "milkglass render {mesh} --preset {}{around} --size {width}x{height} --samples {samples}{method} -o {stem}.png",
                quoted(&material)
            );
            (command, None)
        };
        Ok(Shown { stem, material, command, seconds: start.elapsed().as_secs_f64(), pixels, scene })
    }
}

/// A path that holds in any folder.
fn absolute(path: &str) -> String {
    std::path::absolute(path).map_or_else(|_| path.to_owned(), |path| path.to_string_lossy().into_owned())
}

/// The scene's picture: its bytes, r g b row by row.
fn pixels_of(scene: &milkglass::Scene, device: Option<&Device>, options: Options) -> Result<Vec<u8>> {
    let mut session = open_session(scene, device, options)?;
    run_first_sample(&mut session, Change::EVERYTHING)?;
    session.sample()?;
    let bytes = session.shown()?;
    check_messages(device)?;
    Ok(bytes)
}

/// All pictures beside each other, as a PNG file: a row for each mesh and environment, a column for each material.
fn sheet(rows: &[Row], [width, height]: [u32; 2]) -> Result<Vec<u8>> {
    let (line, mut bytes) = (3 * width as usize, Vec::new());
    for row in rows {
        for y in 0..height as usize {
            row.shown.iter().for_each(|shown| bytes.extend_from_slice(&shown.pixels[y * line..][..line]));
        }
    }
    let columns = rows.first().map_or(0, |row| row.shown.len()) as u32;
    png([columns * width, rows.len() as u32 * height], &bytes)
}

/// A name in which `-` replaces everything but letters, digits, `-` and `_`.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || c == '-' || c == '_' { c } else { '-' }).collect()
}

/// The page.
fn page(rows: &[Row], [width, height]: [u32; 2]) -> String {
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"generator\" {}>\n\
         <title>milkglass gallery</title>\n<style>body{{background:#222;color:#ddd;font:15px sans-serif;margin:2em}}\
         div{{display:flex;flex-wrap:wrap;gap:1em}}figure{{margin:0;max-width:{width}px}}img{{max-width:100%;display:block}}\
         code{{font-size:11px;color:#aaa;overflow-wrap:anywhere}}</style></head><body>\n<h1>milkglass gallery</h1>\n",
        GALLERY.mark
    );
    for Row { name, shown } in rows {
        text += &format!("<h2>{}</h2>\n<div>\n", escape(name));
        for Shown { stem, material, command, seconds, .. } in shown {
            let [material, command] = [material, command].map(|words| escape(words));
            text += &format!(
                "<figure><img src=\"{stem}.png\" alt=\"{material}\" width=\"{width}\" height=\"{height}\">\
                 <figcaption>{material}, {seconds:.1} s<br><code>{command}</code></figcaption></figure>\n"
            );
        }
        text += "</div>\n";
    }
    text + "</body></html>\n"
}
