//! `milkglass gallery`: meshes in materials, as one page of pictures with the commands that make them.

use std::path::{Path, PathBuf};

use clap::Args;

use super::device::DeviceArgument;
use super::memory::MemoryArgument;
use super::render::parse_size;
use super::run_args::quoted;
use super::{check_messages, open_session, print, run_frame, validation};
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::measure::folder::{Folder, GALLERY};
use milkglass::measure::report::{escape, png};
use milkglass::scene::{Preset, Studio, Wishes};

/// Built-in shapes that are shown if no file is given.
const SHAPES: [&str; 4] = ["bust", "lotus", "torus", "gecko"];

/// Arguments of `gallery`.
#[derive(Args)]
#[command(after_help = "Example: milkglass gallery bunny.obj -o gallery --materials marble,skin1")]
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
    /// Width and height of each picture, in pixels.
    #[arg(long, value_name = "WxH", default_value = "256x256")]
    size: String,
    /// Samples per pixel, 1 to 64.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=64))]
    samples: u32,
    #[command(flatten)]
    device: DeviceArgument,
    #[command(flatten)]
    memory: MemoryArgument,
}

/// A picture of the page: its file, what it shows, and the command that makes it.
struct Shown {
    file: String,
    material: String,
    command: String,
}

/// Renders the pictures and writes the page.
pub fn run(arguments: &Arguments) -> Result<()> {
    let size = parse_size(&arguments.size)?;
    let folder = Folder::open(&arguments.output, &GALLERY, "-o")?;
    let device = arguments.device.open(validation())?;
    let given = !arguments.files.is_empty();
    let meshes: Vec<String> = if given { arguments.files.clone() } else { SHAPES.map(str::to_owned).to_vec() };
    let count = meshes.len() * arguments.materials.len();
    let (mut files, mut rows) = (Vec::new(), Vec::new());
    for (number, mesh) in meshes.iter().enumerate() {
        let mut row = Vec::new();
        for material in &arguments.materials {
            let wishes = Wishes {
                preset: Some(material.clone()),
                samples: Some(arguments.samples),
                pixels: Some(size),
                ..Wishes::default()
            };
            let memory = || arguments.memory.files();
            let studio = match given {
                true => Studio::around(mesh, &[], 0.0, &memory(), wishes)?.ok_or_else(|| {
                    Input::new("not a mesh alone").key("FILE").found(mesh).expected("a mesh: OBJ, PLY, STL or glTF")
                })?,
                false => Studio::around_shape(mesh, &memory(), wishes)?,
            };
            let first = row.is_empty();
            studio.told.iter().skip(usize::from(!first)).for_each(|line| tell!("{line}"));
            let scene = studio.scene(0.0, &[], 0.0, &memory())?;
            let material = Preset::named(material).map_or(material.clone(), |preset| preset.name.to_lowercase());
            let stem = format!(
                "{}{}-{material}",
                plain(&scene.name),
                if given { format!("-{number}") } else { String::new() }
            );
            files.push((format!("{stem}.png"), picture(&scene, device.as_ref())?));
            let command = if given {
                let [width, height] = size;
                let (mesh, samples) = (quoted(mesh), arguments.samples);
                format!(
                    "milkglass render {mesh} --preset {material} --size {width}x{height} --samples {samples} -o {stem}.png"
                )
            } else {
                files.push((format!("{stem}.toml"), studio.toml().into_bytes()));
                format!("milkglass render {stem}.toml -o {stem}.png")
            };
            row.push(Shown { file: format!("{stem}.png"), material, command });
            tell!("{}/{count} {stem}", rows.len() * arguments.materials.len() + row.len());
        }
        rows.push((mesh.clone(), row));
    }
    folder.fill(&page(&rows, size), &files)?;
    print(&format!("{}\n", arguments.output.join(GALLERY.page).display()))
}

/// The scene's picture, as a PNG file's bytes.
fn picture(scene: &milkglass::Scene, device: Option<&Device>) -> Result<Vec<u8>> {
    let mut session = open_session(scene, device, Options::default())?;
    run_frame(&mut session, Change::EVERYTHING)?;
    session.sample()?;
    let bytes = session.shown()?;
    check_messages(device)?;
    png(scene.camera.size, &bytes)
}

/// A name in which `-` replaces everything but letters, digits, `-` and `_`.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || c == '-' || c == '_' { c } else { '-' }).collect()
}

/// The page.
fn page(rows: &[(String, Vec<Shown>)], [width, height]: [u32; 2]) -> String {
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"generator\" {}>\n\
         <title>milkglass gallery</title>\n<style>body{{background:#222;color:#ddd;font:15px sans-serif;margin:2em}}\
         div{{display:flex;flex-wrap:wrap;gap:1em}}figure{{margin:0;max-width:{width}px}}img{{max-width:100%;display:block}}\
         code{{font-size:11px;color:#aaa;overflow-wrap:anywhere}}</style></head><body>\n<h1>milkglass gallery</h1>\n",
        GALLERY.mark
    );
    for (mesh, row) in rows {
        let name = Path::new(mesh).file_name().unwrap_or_default().to_string_lossy();
        text += &format!("<h2>{}</h2>\n<div>\n", escape(&name));
        for Shown { file, material, command } in row {
            let [file, material, command] = [file, material, command].map(|words| escape(words));
            text += &format!(
                "<figure><img src=\"{file}\" alt=\"{material}\" width=\"{width}\" height=\"{height}\">\
                 <figcaption>{material}<br><code>{command}</code></figcaption></figure>\n"
            );
        }
        text += "</div>\n";
    }
    text + "</body></html>\n"
}
