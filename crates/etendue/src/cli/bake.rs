//! `etendue bake`: a sky, or the light at places of a scene, into what real-time shading looks up.

use super::bake_args::{BakeArgs, CubeFormat};
use super::bake_files::{self, File, cube_files, picture};
use super::bake_probe::{light_probes, reflection_probe};
use super::{CliError, load, note_line, say, target};
use crate::ibl::manifest::{
    CubeEntry, DfgEntry, FACES_AS_OPENEXR, FACES_AS_TEXTURES, FRAME, GENERATOR, Manifest, ProbeEntry, ShEntry,
};
use crate::ibl::{
    BakeOptions, Baked, DfgLayout, DfgMethod, DfgTable, MipMapping, PrefilterOptions, SkyMap, bake, bake_cube,
};
use crate::image::{Image, PictureFormat, Pixels};
use crate::scene::Environment;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::path::Path;
use std::time::Instant;

/// Where the results go.
enum Goal {
    /// Everything, into a folder.
    Folder(CubeFormat),
    /// The prefiltered cube, into a file (or one for each mip).
    Cube(CubeFormat),
    /// The table, into a picture.
    Table(PictureFormat),
    /// Light probes, into a JSON file.
    Probes,
}

pub(crate) fn run(args: &BakeArgs) -> Result<(), CliError> {
    let goal = goal(args)?;
    let folder = matches!(goal, Goal::Folder(_));
    if folder && args.output.is_dir() {
        target::check_writable(&args.output.join(MANIFEST))?;
    } else {
        target::check_writable(&args.output)?;
    }
    if let Some(n) = args.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(n as usize)
            .build_global()
            .map_err(|e| CliError::Other(format!("cannot start {n} threads: {e}")))?;
    }
    let start = Instant::now();
    let (files, report) = match goal {
        Goal::Table(format) => {
            let table = table(args);
            let file = picture(&args.output, format, &table_image(args, &table))?;
            (vec![file], serde_json::json!({ "dfg": { "size": table.size() } }))
        }
        Goal::Probes => light_probes(args)?,
        Goal::Folder(format) | Goal::Cube(format) => cubes(args, format, folder)?,
    };
    let seconds = start.elapsed().as_secs_f64();
    let names: Vec<String> = files.iter().map(|f| f.path.to_string_lossy().into_owned()).collect();
    let bytes: usize = files.iter().map(|f| f.bytes.len()).sum();
    bake_files::write(files, folder.then_some(args.output.as_path()))?;
    if args.json {
        let mut report = report;
        report["files"] = serde_json::json!(names);
        report["seconds"] = serde_json::json!(seconds);
        say(&report.to_string());
    } else if !args.quiet {
        for name in &names {
            say(name);
        }
        say(&format!("{} KiB, baked in {}", bytes.div_ceil(1024), super::progress::clock(seconds)));
    }
    Ok(())
}

/// The file that says what the others are.
const MANIFEST: &str = "bake.json";

/// What to make, by the output's name and the options.
fn goal(args: &BakeArgs) -> Result<Goal, CliError> {
    let path = &args.output;
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let by_name = match extension.as_deref() {
        Some("ktx2") => Some(CubeFormat::Ktx2),
        Some("dds") => Some(CubeFormat::Dds),
        Some("exr") => Some(CubeFormat::Exr),
        Some("hdr") => Some(CubeFormat::Hdr),
        _ => None,
    };
    if args.dfg {
        return match by_name {
            Some(CubeFormat::Exr) => Ok(Goal::Table(PictureFormat::Exr)),
            Some(CubeFormat::Hdr) => Ok(Goal::Table(PictureFormat::Hdr)),
            _ => Err(CliError::Usage(format!(
                "the table is written as .exr or .hdr; {} is neither",
                path.display()
            ))),
        };
    }
    if args.probes.is_some() {
        return match extension.as_deref() {
            Some("json") => Ok(Goal::Probes),
            _ => Err(CliError::Usage(format!(
                "light probes are written as .json; {} is something else",
                path.display()
            ))),
        };
    }
    let slash = path.to_string_lossy().ends_with(['/', '\\']);
    if path.is_dir() || slash || extension.is_none() {
        return Ok(Goal::Folder(args.format.unwrap_or(CubeFormat::Ktx2)));
    }
    match args.format.or(by_name) {
        Some(format) => Ok(Goal::Cube(format)),
        None => Err(CliError::Usage(format!(
            "cannot tell what {} is to be: end it with .ktx2, .dds, .exr or .hdr, or with / for a folder, or give --format",
            path.display()
        ))),
    }
}

/// What was baked: its sky's name, what was noted, and where it was taken if it is a probe.
struct Source {
    sky: String,
    notes: Vec<String>,
    probe: Option<ProbeEntry>,
}

/// Bakes the sky or the probe; the files, and the report.
fn cubes(
    args: &BakeArgs,
    format: CubeFormat,
    folder: bool,
) -> Result<(Vec<File>, serde_json::Value), CliError> {
    let options = options(args);
    let (source, baked) = match &args.probe {
        Some(model) => {
            let (entry, cube, sky, notes) = reflection_probe(args, model)?;
            let bar = bar(!args.quiet);
            let baked = bake_cube(&cube, &options, &|f| bar.set_position((f * 1000.0) as u64));
            bar.finish_and_clear();
            (Source { sky, notes, probe: Some(entry) }, baked)
        }
        None => sky(args, &options)?,
    };
    let metadata = bake_files::metadata(&source.sky, source.probe.as_ref(), &baked, args);
    if !folder {
        let files = cube_files(&args.output, format, args.encoding, &baked.specular, &metadata)?;
        let report = serde_json::json!({
            "sky": source.sky, "notes": source.notes, "probe": source.probe, "roughness": baked.roughness
        });
        return Ok((files, report));
    }
    let extension = format.extension();
    let in_folder = |stem: &str, extension: &str| args.output.join(format!("{stem}.{extension}"));
    let specular =
        cube_files(&in_folder("specular", extension), format, args.encoding, &baked.specular, &metadata)?;
    let irradiance =
        cube_files(&in_folder("irradiance", extension), format, args.encoding, &baked.irradiance, &metadata)?;
    let table = table(args);
    let dfg = picture(&in_folder("dfg", "exr"), PictureFormat::Exr, &table_image(args, &table))?;
    let manifest =
        manifest(args, format, source, &baked, [&specular, &irradiance, std::slice::from_ref(&dfg)]);
    let json = serde_json::to_string_pretty(&manifest).map_err(|e| CliError::Other(e.to_string()))?;
    let report = serde_json::to_value(&manifest).map_err(|e| CliError::Other(e.to_string()))?;
    let mut files = specular;
    files.extend(irradiance);
    files.push(dfg);
    // Last, so that whoever sees it sees the others.
    files.push(File { path: args.output.join(MANIFEST), bytes: (json + "\n").into_bytes() });
    Ok((files, report))
}

/// Reads and bakes the sky.
fn sky(args: &BakeArgs, options: &BakeOptions) -> Result<(Source, Baked), CliError> {
    let name = args.sky.as_deref().unwrap_or("studio");
    let (environment, mut notes) =
        load::sky_as(name, args.env_layout, args.env_rotation, args.env_intensity)?;
    let map = SkyMap::new(&environment).map_err(|e| CliError::Other(format!("{name}: {e}")))?;
    notes.extend(remarks(name, &environment, &map));
    if !args.quiet {
        notes.iter().for_each(|n| note_line(&format!("warning: {n}")));
    }
    let bar = bar(!args.quiet);
    let baked = bake(&map, options, &|f| bar.set_position((f * 1000.0) as u64));
    bar.finish_and_clear();
    Ok((Source { sky: name.into(), notes, probe: None }, baked))
}

/// What about a sky is worth knowing.
fn remarks(name: &str, environment: &Environment, map: &SkyMap) -> Vec<String> {
    let mut out = Vec::new();
    if let Environment::LatLong { image, .. } = environment {
        let (w, h) = (image.width, image.height);
        if (w, h) == (1, 1) {
            out.push(format!("{name}: one pixel is the same light from everywhere"));
        } else if u64::from(w) != 2 * u64::from(h) {
            out.push(format!("{name}: {w} × {h} is not 2:1; it is stretched over the whole sphere"));
        }
    }
    if map.is_black() {
        out.push(format!("{name}: the sky is black, and so is all that is baked from it"));
    }
    out
}

fn options(args: &BakeArgs) -> BakeOptions {
    let steps = args.steps.unwrap_or_else(|| match args.mapping {
        MipMapping::Linear => PrefilterOptions::steps_for(args.size),
        MipMapping::Notes => MipMapping::NOTES_STEPS,
    });
    BakeOptions {
        prefilter: PrefilterOptions {
            size: args.size,
            steps,
            samples: args.samples,
            mapping: args.mapping,
            kernel: args.kernel,
            ..Default::default()
        },
        irradiance_size: args.irradiance_size,
        window: args.window,
    }
}

pub(crate) fn bar(visible: bool) -> ProgressBar {
    let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(1000), target);
    if let Ok(style) = ProgressStyle::with_template("{percent:>3}%  {elapsed}  {wide_bar}") {
        bar.set_style(style.progress_chars("━╸ "));
    }
    bar
}

fn table(args: &BakeArgs) -> DfgTable {
    let method = if args.dfg_samples == 0 { DfgMethod::Exact } else { DfgMethod::Sampled(args.dfg_samples) };
    DfgTable::new(args.dfg_size, method)
}

fn table_image(args: &BakeArgs, table: &DfgTable) -> Image {
    let pixels = table.pixels(args.dfg_layout).into_iter().flatten().collect();
    Image { width: table.size(), height: table.size(), channels: 3, pixels: Pixels::F32(pixels) }
}

fn manifest(
    args: &BakeArgs,
    format: CubeFormat,
    source: Source,
    baked: &Baked,
    files: [&[File]; 3],
) -> Manifest {
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let [specular, irradiance, dfg] = files.map(|f| f.iter().map(|f| name(&f.path)).collect::<Vec<_>>());
    let encoding = match format {
        CubeFormat::Ktx2 | CubeFormat::Dds => args.encoding.to_string(),
        CubeFormat::Exr => "rgb16f".into(),
        CubeFormat::Hdr => "rgbe".into(),
    };
    let orientation = if format == CubeFormat::Exr { FACES_AS_OPENEXR } else { FACES_AS_TEXTURES };
    Manifest {
        generator: GENERATOR,
        sky: source.sky,
        probe: source.probe,
        frame: FRAME,
        notes: source.notes,
        sh9: ShEntry::new(baked, args.window.to_string()),
        irradiance: CubeEntry {
            files: irradiance,
            encoding: encoding.clone(),
            size: baked.irradiance.size(),
            quantity: "irradiance: pi under a sky of radiance 1",
            orientation,
            roughness: Vec::new(),
            mapping: None,
        },
        specular: CubeEntry {
            files: specular,
            encoding,
            size: baked.specular.size(),
            quantity: "radiance seen by a GGX lobe, N = V = R",
            orientation,
            roughness: baked.roughness.clone(),
            mapping: Some(match args.mapping {
                MipMapping::Linear => "lod = roughness * (mips - 1)".into(),
                MipMapping::Notes => "lod = roughness * (1.7 - 0.7 * roughness) * (mips - 1)".into(),
            }),
        },
        dfg: DfgEntry {
            file: dfg.concat(),
            size: args.dfg_size,
            layout: match args.dfg_layout {
                DfgLayout::ScaleBias => {
                    "x: N.V, y (down): roughness, texel middles; albedo = F0 * r + F90 * g"
                }
                DfgLayout::Multiscatter => {
                    "x: N.V, y (down): roughness, texel middles; albedo = mix(r, g, F0), g the energy E; b: sheen's E"
                }
            },
        },
    }
}
