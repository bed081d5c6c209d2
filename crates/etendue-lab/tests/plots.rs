//! Every model's plots are drawn, both as SVG and as PNG.

use etendue_bxdf::model::Model;
use etendue_lab::bench::plots;

/// Set `ETENDUE_PLOTS` to a folder to look at them.
#[test]
fn every_model_is_drawn() {
    let folder = std::env::var_os("ETENDUE_PLOTS");
    let only = std::env::var("ETENDUE_MODEL").ok();
    for name in Model::NAMES
        .iter()
        .filter(|n| only.as_deref().map_or(folder.is_some() || **n == "dielectric", |o| o == **n))
    {
        let model = Model::by_name(name).expect("listed");
        for plot in plots(&model, &format!("etendue lab bxdf {name}")) {
            let (svg, png) = (plot.drawing.to_svg(), plot.drawing.to_png().expect("has pixels"));
            assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"), "{name} {}", plot.name);
            assert!(
                svg.contains(name) && !svg.contains("NaN") && !svg.contains("inf,"),
                "{name} {}",
                plot.name
            );
            assert!(png.len() > 4_000, "{name} {}: nothing drawn", plot.name);
            if let Some(folder) = &folder {
                let file = std::path::Path::new(folder).join(format!("{name}-{}", plot.name));
                std::fs::write(file.with_extension("png"), png).expect("a folder that can be written");
                std::fs::write(file.with_extension("svg"), svg).expect("a folder that can be written");
            }
        }
    }
}
