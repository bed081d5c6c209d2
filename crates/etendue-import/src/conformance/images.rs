//! Pictures: those that no texture uses, and what is said of the others.

use super::{Case, list};
use crate::document::Image;
use crate::extensions as ext;
use crate::texture::{self, format_of};
use etendue_image::Ktx2;
use std::collections::HashSet;

impl Case<'_> {
    pub(super) fn images(&mut self) {
        let doc = self.accessors.doc;
        let used: HashSet<u32> = doc.textures.iter().filter_map(|t| t.source).collect();
        let webp = doc.extensions_used.contains(&ext::TEXTURE_WEBP);
        for (i, image) in doc.images.iter().enumerate() {
            let at = format!("/images/{i}");
            let json = &list(self.root, "images")[i];
            let mime = json.get("mimeType").and_then(serde_json::Value::as_str);
            if image.uri.is_some() == image.buffer_view.is_some() {
                self.out.add(at.clone(), "needs either `uri` or `bufferView`, and one of them only");
                continue;
            }
            if image.buffer_view.is_some() && mime.is_none() {
                self.out.add(at.clone(), "a picture in a buffer view needs a `mimeType`");
            }
            if mime == Some("image/webp") && !webp {
                self.out.add(format!("{at}/mimeType"), "WebP pictures need EXT_texture_webp");
            }
            let strided = image.buffer_view.and_then(|v| doc.buffer_views.get(v as usize));
            if strided.is_some_and(|v| v.byte_stride.is_some()) {
                self.out.add(format!("{at}/bufferView"), "a picture in a view with a stride");
            }
            self.content(i, image, mime, used.contains(&(i as u32)));
        }
    }

    fn content(&mut self, i: usize, image: &Image<'_>, mime: Option<&str>, used: bool) {
        let at = format!("/images/{i}");
        let (doc, buffers) = (self.accessors.doc, self.accessors.buffers);
        if image.uri.is_some_and(|u| u.contains("://")) {
            return;
        }
        let bytes = match texture::bytes(doc, i as u32, buffers, self.source) {
            Ok(bytes) => bytes,
            Err(e) => {
                self.out.add(at, e.message());
                return;
            }
        };
        let is = match format_of(&bytes) {
            "PNG" => "image/png",
            "JPEG" => "image/jpeg",
            "WebP" => "image/webp",
            "KTX2" => "image/ktx2",
            // It is not looked into; whoever uses it is told.
            "unknown" => return,
            other => {
                self.out.add(at, format!("{other} is no picture format of glTF"));
                return;
            }
        };
        // A data URI says the type, too.
        let in_uri = image.uri.and_then(|u| u.strip_prefix("data:")?.split([';', ',']).next());
        for said in [mime, in_uri].into_iter().flatten() {
            if said.starts_with("image/") && said != is {
                self.out.add(at.clone(), format!("is {is}, but said to be {said}"));
            }
        }
        // Pictures that are used have been decoded.
        if !used && let Err(e) = self.source.decode(&bytes, self.source.limits.image_bytes) {
            self.out.add(at.clone(), e);
        }
        let limits = etendue_image::DecodeLimits::default();
        if is == "image/ktx2"
            && let Ok(k) = Ktx2::new(&bytes, &limits)
        {
            for r in k.remarks().into_iter().chain(k.remarks_for_gltf()) {
                self.out.add(at.clone(), format!("KTX2: {r}"));
            }
        }
    }
}
