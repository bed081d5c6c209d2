//! Textures whose picture glTF does not know by itself. Beside the model only the name of a file told what it was, and readers took
//! it; in the file its media type is said, and then an extension has to allow it.

use super::tree::Tree;
use super::views::Views;
use crate::extensions as ext;
use crate::texture::format_of;
use etendue_image::{DecodeLimits, Ktx2};

/// Makes textures name the extension for WebP or Basis Universal where they refer to such a picture without it. Returns how many
/// did.
pub(super) fn mend<'t>(tree: &mut Tree<'t>, views: &Views<'_, 't>, limits: &DecodeLimits) -> u64 {
    let images = tree.list("images").iter().map(|i| {
        let content = views.content(i.get("bufferView")?.index()?);
        match format_of(content) {
            "WebP" => Some(ext::TEXTURE_WEBP),
            "KTX2" => {
                let coding = Ktx2::new(content, limits).ok()?.coding();
                matches!(coding, "ETC1S" | "UASTC").then_some(ext::TEXTURE_BASISU)
            }
            _ => None,
        }
    });
    let images: Vec<_> = images.collect();
    let mut names: Vec<&str> = Vec::new();
    let mut mended = 0;
    for t in tree.list_mut("textures") {
        let Some(source) = t.get("source").and_then(Tree::index) else { continue };
        let Some(name) = images.get(source as usize).copied().flatten() else { continue };
        if t.within(&["extensions", ext::TEXTURE_WEBP]).is_some()
            || t.within(&["extensions", ext::TEXTURE_BASISU]).is_some()
        {
            continue;
        }
        t.remove("source");
        if t.get("extensions").is_none() {
            t.set("extensions", Tree::Object(Vec::new()));
        }
        if let Some(e) = t.get_mut("extensions") {
            e.set(name, Tree::object([("source", Tree::number(source.into()))]));
        }
        mended += 1;
        if !names.contains(&name) {
            names.push(name);
        }
    }
    for list in ["extensionsUsed", "extensionsRequired"] {
        for name in &names {
            if !tree.list(list).iter().any(|n| n.text().as_deref() == Some(name)) {
                tree.push(list, Tree::string(name));
            }
        }
    }
    mended
}
