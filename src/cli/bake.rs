//! `milkglass bake-layers`: a depth map of nested surfaces.

use std::path::PathBuf;

use clap::Args;
use exr::prelude::{Image, SpecificChannels, Vec2, WritableImage};

use super::{MemoryArgument, print};
use milkglass::error::{Input, Result};
use milkglass::internals::session::bake::bake;
use milkglass::internals::view::atomic_file::{encode_atomically, ready};
use milkglass::scene::{Depth, Scene, text_of_path};

/// Arguments of `bake-layers`.
#[derive(Args)]
#[command(after_help = "Example: milkglass bake-layers skin.obj flesh.obj bone.obj -o depths.png --size 1024x1024\n\n\
    Rays go down from the outer surface along its normals; channel k of the map is how deep the k-th inner surface lies. \
    It prints what to write into a scene.")]
pub struct Arguments {
    /// The outer surface, with texture coordinates (OBJ).
    outer: PathBuf,
    /// One to four surfaces inside it, from the outside inwards (OBJ): the layers' lower interfaces.
    #[arg(required = true, num_args = 1..=4)]
    inner: Vec<PathBuf>,
    /// The map: .png (16 bits) or .exr.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Width and height, in texels.
    #[arg(long, value_name = "WxH", default_value = "512x512")]
    size: String,
    #[command(flatten)]
    memory: MemoryArgument,
    /// What the largest value of the map stands for: the greatest depth, or none.
    #[arg(long, value_enum, default_value_t)]
    depth: Depth,
}

/// Bakes and writes the map.
pub fn run(arguments: &Arguments) -> Result<()> {
    let end = arguments.output.extension().and_then(|end| end.to_str()).unwrap_or_default().to_ascii_lowercase();
    if !["png", "exr"].contains(&end.as_str()) {
        let fault = Input::new("a map's name says its format").key("-o").found(arguments.output.display());
        return Err(fault.expected(".png or .exr").into());
    }
    ready([("-o", Some(&arguments.output))])?;
    let size = texels(&arguments.size)?;
    let files = arguments.memory.files();
    let scene = |path: &PathBuf, texture: &str| {
        let path = text_of_path(path.clone().into()).replace('\\', "\\\\").replace('"', "\\\"");
        let text = format!("[[object]]\nmesh = \"{path}\"\nmaterial = {{ preset = 'marble'{texture} }}\n");
        Scene::parse_from("bake-layers", &text, &[], &files)
    };
    let outer = scene(&arguments.outer, ", texture = 'builtin:checker'")?;
    let inner = arguments.inner.iter().map(|path| scene(path, "")).collect::<Result<Vec<_>>>()?;
    let baked = bake(&outer, &inner, size, files.memory())?;
    for (path, count) in arguments.inner.iter().zip(&baked.behind).filter(|(_, count)| **count > 0) {
        let (path, covered) = (path.display(), baked.covered);
        tell!(
            "{path}: {count} of {covered} rays meet it from behind: there it lies outside the outer surface, or faces inwards"
        );
    }

    let share = |depth: f64| match arguments.depth {
        Depth::Bright => depth / baked.deepest,
        Depth::Dark => 1.0 - depth / baked.deepest,
    };
    let texel = |depths: &[f64; 4]| depths.map(share);
    encode_atomically(&arguments.output, |file| match end.as_str() {
        "png" => {
            let round = |x: f64| (x * 65535.0 + 0.5) as u16;
            let values: Vec<u16> = baked.depths.iter().flat_map(|depths| texel(depths).map(round)).collect();
            let buffer = image::ImageBuffer::<image::Rgba<u16>, _>::from_raw(size[0], size[1], values);
            let buffer = buffer.ok_or("the map has another size")?;
            buffer.write_to(file, image::ImageFormat::Png).map_err(|error| error.to_string())
        }
        _ => {
            let (width, height) = (size[0] as usize, size[1] as usize);
            let pixel = |at: Vec2<usize>| -> (f32, f32, f32, f32) {
                texel(&baked.depths[at.y() * width + at.x()]).map(|x| x as f32).into()
            };
            let image = Image::from_channels((width, height), SpecificChannels::rgba(pixel));
            image.write().to_buffered(file).map_err(|error| error.to_string())
        }
    })?;

    let word = if arguments.depth == Depth::Dark { "dark" } else { "bright" };
    print(&format!(
        "maps = [\"{}\"]\ndepth = \"{word}\"\nscale = {}\n# {} of {} texels are covered by triangles, {} rays met nothing\n",
        arguments.output.display(),
        baked.deepest,
        baked.covered,
        baked.depths.len(),
        baked.missed
    ))
}

fn texels(text: &str) -> Result<[u32; 2]> {
    let side = |part: &str| part.parse::<u32>().ok().filter(|n| (1..=8192).contains(n));
    let sides = text.split_once('x').and_then(|(width, height)| Some([side(width)?, side(height)?]));
    let fits = sides.filter(|[width, height]| width * height <= 1 << 22);
    fits.ok_or_else(|| {
        let fault = Input::new("not the size of a map").key("--size").found(text);
        fault.expected("WIDTHxHEIGHT, each 1 to 8192, together at most 2^22 texels").into()
    })
}
