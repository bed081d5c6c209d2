//! `etendue info`: what a file holds.

use super::loading::Loading;
use super::model_args::InfoArgs;
use super::output::{self, bytes};
use super::{CliError, load, say};
use crate::import::{ExtensionInfo, ImportOptions, Imported, Support};
use std::fmt::Write;

pub(crate) fn run(args: &InfoArgs) -> Result<(), CliError> {
    let loading = Loading::new(!args.json);
    let options =
        ImportOptions { conformance: true, progress: Some(loading.progress()), ..args.limits.options() };
    let imported = load::read(args.model.as_deref(), &options, None)?;
    drop(loading);
    if args.json {
        let report = serde_json::json!({ "info": imported.info, "warnings": imported.warnings });
        say(&serde_json::to_string_pretty(&report).map_err(|e| CliError::Other(e.to_string()))?);
    } else {
        say(text(&imported).trim_end());
    }
    Ok(())
}

/// Rows of a table with its columns aligned.
pub(crate) fn table(out: &mut String, title: &str, rows: &[Vec<String>]) {
    if rows.is_empty() {
        return;
    }
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let _ = writeln!(out, "\n{title}");
    for row in rows {
        let mut line = String::from(" ");
        for (cell, w) in row.iter().zip(&widths) {
            let _ = write!(line, " {cell:w$} ");
        }
        let _ = writeln!(out, "{}", line.trim_end());
    }
}

/// A packet of metadata: its number, what it is about, and its properties.
fn xmp_row(i: usize, packet: &serde_json::Value, of_asset: Option<u32>) -> Vec<String> {
    let about = if of_asset == Some(i as u32) { "the file" } else { "a part" };
    let said = packet.as_object().into_iter().flatten().filter(|(k, _)| !k.starts_with('@'));
    let said: Vec<_> = said.map(|(k, v)| format!("{k} {}", xmp_value(v))).collect();
    vec![i.to_string(), about.into(), said.join("; ")]
}

/// A value of JSON-LD without its scaffolding.
fn xmp_value(v: &serde_json::Value) -> String {
    use serde_json::Value;
    match v {
        Value::String(s) => s.clone(),
        Value::Array(a) => a.iter().map(xmp_value).collect::<Vec<_>>().join(", "),
        Value::Object(o) => {
            let inner = ["@value", "@list", "@set", "rdf:_1"].iter().find_map(|k| o.get(*k));
            inner.map_or_else(|| v.to_string(), xmp_value)
        }
        other => other.to_string(),
    }
}

fn text(imported: &Imported) -> String {
    let (info, c) = (&imported.info, &imported.info.counts);
    let mut out = String::new();
    let n = |v: u64| output::count(v as f64);
    let _ = writeln!(
        out,
        "{}: {}, {}{}",
        info.file,
        format!("{} {}", info.format, info.version).trim_end(),
        bytes(info.bytes),
        if info.external_bytes > 0 {
            format!(" and {} beside it", bytes(info.external_bytes))
        } else {
            String::new()
        }
    );
    if let Some(assumed) = info.assumed {
        let _ = writeln!(out, "  {assumed}");
    }
    for (what, value) in [("by", &info.generator), ("copyright", &info.copyright), ("scene", &info.scene)] {
        if let Some(v) = value {
            let _ = writeln!(out, "  {what} {v}");
        }
    }
    let bounds = imported.scene.bounds();
    if !bounds.is_empty() {
        let (a, b) = (bounds.min, bounds.max);
        let _ = writeln!(
            out,
            "  from ({:.3}, {:.3}, {:.3}) to ({:.3}, {:.3}, {:.3}) m",
            a.x, a.y, a.z, b.x, b.y, b.z
        );
    }
    let row = |cells: &[&dyn std::fmt::Display]| cells.iter().map(|c| c.to_string()).collect::<Vec<_>>();
    table(
        &mut out,
        "counts",
        &[
            row(&[&"nodes", &n(c.nodes), &format!("{} shown", n(c.visible_nodes))]),
            row(&[
                &"meshes",
                &n(c.meshes),
                &format!("{} primitives, {} vertices", n(c.primitives), n(c.vertices)),
            ]),
            row(&[
                &"triangles",
                &n(c.triangles),
                &format!("{} shown in {} instances", n(c.shown_triangles), n(c.instances)),
            ]),
            row(&[
                &"images",
                &n(c.images),
                &format!("{} textures, {} decoded", n(c.textures), bytes(c.image_bytes)),
            ]),
            row(&[&"materials", &n(c.materials)]),
            row(&[&"skins", &n(c.skins)]),
        ],
    );
    let p = &info.sizes;
    let parts = [
        ("JSON", p.json),
        ("geometry", p.geometry),
        ("images", p.images),
        ("animation", p.animation),
        ("other data", p.other),
        ("not referred to", p.unused),
    ];
    let total: u64 = parts.iter().map(|(_, n)| n).sum::<u64>().max(1);
    let rows: Vec<_> = parts
        .iter()
        .filter(|(_, n)| *n > 0)
        .map(|(what, n)| row(&[what, &bytes(*n), &format!("{:.1} %", *n as f64 * 100.0 / total as f64)]))
        .collect();
    table(&mut out, "sizes", &rows);
    let support = |e: &ExtensionInfo| match e.support {
        Some(Support::Draft) => "a draft: read, may still change",
        _ if e.draft => "a draft: ignored without --drafts",
        Some(Support::Full) => "supported",
        Some(Support::Partly) => "supported in part",
        Some(Support::Ignored) => "says nothing of how it looks: ignored",
        Some(Support::Refused) => "not supported yet: refused if required",
        None => "unknown: ignored",
    };
    let required = |r: bool| if r { "required" } else { "used" };
    let rows: Vec<_> =
        info.extensions.iter().map(|e| row(&[&e.name, &required(e.required), &support(e)])).collect();
    table(&mut out, "extensions", &rows);
    let rows: Vec<_> = info
        .meshes
        .iter()
        .enumerate()
        .flat_map(|(i, m)| {
            m.primitives.iter().map(move |p| {
                vec![
                    i.to_string(),
                    m.name.clone(),
                    p.mode.to_string(),
                    format!("{} triangles", p.triangles),
                    p.attributes.join(" "),
                    p.material.map_or_else(|| "default material".into(), |m| format!("material {m}")),
                ]
            })
        })
        .collect();
    table(&mut out, "meshes", &rows);
    let rows: Vec<_> = info
        .materials
        .iter()
        .enumerate()
        .map(|(i, m)| {
            let mut notes = Vec::new();
            notes.extend((m.alpha_mode != "OPAQUE").then(|| m.alpha_mode.to_lowercase()));
            notes.extend(m.double_sided.then(|| "double-sided".to_string()));
            notes.extend(m.unlit.then(|| "unlit".to_string()));
            notes.extend(m.factors.iter().map(|(name, v)| {
                let v: Vec<_> = v.iter().map(|x| format!("{}", (x * 1e4).round() / 1e4)).collect();
                format!("{name} {}", v.join(","))
            }));
            notes.extend(m.textures.iter().map(|(name, t)| format!("{name} → texture {t}")));
            vec![i.to_string(), m.name.clone(), notes.join("; ")]
        })
        .collect();
    table(&mut out, "materials", &rows);
    let rows: Vec<_> = info
        .images
        .iter()
        .enumerate()
        .map(|(i, m)| {
            let size = if m.used {
                let mips = if m.mips > 1 { format!(", {} mips", m.mips) } else { String::new() };
                format!(
                    "{} {} × {} × {}, {} bit{mips}, {} → {}",
                    m.format,
                    m.width,
                    m.height,
                    m.channels,
                    m.bits,
                    bytes(m.bytes),
                    bytes(m.decoded_bytes)
                )
            } else {
                "not used".into()
            };
            vec![i.to_string(), m.uri.clone().unwrap_or_else(|| m.name.clone()), size]
        })
        .collect();
    table(&mut out, "images", &rows);
    let rows: Vec<_> = imported
        .scene
        .variants
        .iter()
        .enumerate()
        .map(|(i, v)| {
            let count = v.materials.len();
            let objects = if count == 1 { "instance" } else { "instances" };
            vec![i.to_string(), v.name.clone(), format!("other materials on {count} {objects}")]
        })
        .collect();
    table(&mut out, "variants", &rows);
    let rows: Vec<_> =
        info.xmp.iter().enumerate().map(|(i, packet)| xmp_row(i, packet, info.xmp_of_asset)).collect();
    table(&mut out, "metadata (XMP)", &rows);
    let rows: Vec<_> = info
        .cameras
        .iter()
        .enumerate()
        .map(|(i, k)| {
            let size = if k.kind == "perspective" {
                format!("{:.1}° high", k.size.to_degrees())
            } else {
                format!("{} m half height", k.size)
            };
            vec![i.to_string(), k.name.clone(), k.kind.to_string(), size]
        })
        .collect();
    table(&mut out, "cameras", &rows);
    let rows: Vec<_> = info
        .lights
        .iter()
        .enumerate()
        .map(|(i, l)| {
            vec![
                i.to_string(),
                l.name.clone(),
                l.kind.to_string(),
                format!("{} {}", l.intensity, if l.kind == "directional" { "lx" } else { "cd" }),
            ]
        })
        .collect();
    table(&mut out, "lights", &rows);
    let rows: Vec<_> = info
        .animations
        .iter()
        .enumerate()
        .map(|(i, a)| vec![i.to_string(), a.name.clone(), format!("{} channels", a.channels)])
        .collect();
    table(&mut out, "animations", &rows);
    let rows: Vec<_> = imported.warnings.iter().map(|w| vec![w.to_string()]).collect();
    table(&mut out, "warnings", &rows);
    let rows: Vec<_> = info.breaches.iter().map(|w| vec![w.to_string()]).collect();
    table(&mut out, "against the specification", &rows);
    let rows: Vec<_> = info.unusual.iter().map(|w| vec![w.to_string()]).collect();
    table(&mut out, "unusual", &rows);
    out
}
