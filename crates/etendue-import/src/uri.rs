//! What a URI in a model refers to: bytes that it holds itself, or a file beside the model.

use base64::Engine as _;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;
use std::path::{Component, Path, PathBuf};

/// Base64 as files have it: padded or not, stray low bits at the end or not.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// The bytes of a `data:` URI (RFC 2397); `None` if `uri` is not one.
pub(crate) fn data(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let scheme = uri.get(..5)?;
    if !scheme.eq_ignore_ascii_case("data:") {
        return None;
    }
    let Some((head, body)) = uri[5..].split_once(',') else {
        return Some(Err("the data URI has no comma".into()));
    };
    Some(if head.to_ascii_lowercase().ends_with(";base64") {
        BASE64.decode(body).map_err(|e| format!("the data URI is not base64: {e}"))
    } else {
        Ok(percent_decode_str(body).collect())
    })
}

/// A `data:` URI of bytes of no particular kind.
pub(crate) fn of(bytes: &[u8]) -> String {
    let mut out = String::from("data:application/octet-stream;base64,");
    base64::engine::general_purpose::STANDARD.encode_string(bytes, &mut out);
    out
}

/// The address in messages: long ones (data URIs) cut short.
pub(crate) fn shorten(uri: &str) -> String {
    if uri.chars().nth(120).is_some() {
        uri.chars().take(117).chain("...".chars()).collect()
    } else {
        uri.into()
    }
}

/// Where a relative URI points to, seen from the model's folder.
///
/// # Errors
/// Why the place may not be read: it is remote, or outside the folder and `outside` is false.
pub(crate) fn resolve(uri: &str, folder: &Path, outside: bool) -> Result<PathBuf, (PathBuf, String)> {
    let refuse = |path: PathBuf, why: &str| Err((path, why.to_owned()));
    if let Some(scheme) = scheme(uri) {
        return refuse(
            PathBuf::from(uri),
            &format!("`{scheme}:` addresses are not read, only files beside the model"),
        );
    }
    let decoded = percent_decode_str(uri).decode_utf8_lossy().into_owned();
    let relative = Path::new(&decoded);
    let path = folder.join(relative);
    if decoded.contains('\0') {
        return refuse(path, "the name holds a zero byte");
    }
    let mut depth = 0i32;
    for c in relative.components() {
        match c {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir => depth -= 1,
            Component::RootDir | Component::Prefix(_) => depth = i32::MIN / 2,
        }
        if depth < 0 && !outside {
            return refuse(path, "it lies outside the model's folder; allow `outside_folder` to read it");
        }
    }
    Ok(path)
}

/// The scheme of an absolute URI. A single letter is taken for a drive, not a scheme.
fn scheme(uri: &str) -> Option<&str> {
    let (s, _) = uri.split_once(':')?;
    let mut c = s.chars();
    let valid = c.next()?.is_ascii_alphabetic()
        && c.all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'));
    (valid && s.len() > 1).then_some(s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris() {
        let ok = |u: &str| data(u).unwrap().unwrap();
        assert_eq!(ok("data:application/octet-stream;base64,AAEC"), [0, 1, 2]);
        assert_eq!(ok("DATA:;charset=x;BASE64,AAE="), [0, 1]);
        assert_eq!(ok("data:;base64,AAE"), [0, 1]);
        assert_eq!(ok("data:text/plain,a%20b"), b"a b");
        assert!(data("data:;base64,*").unwrap().is_err());
        assert!(data("data:nothing").unwrap().is_err());
        assert!(data("a.bin").is_none() && data("é").is_none());
    }

    #[test]
    fn only_files_below_the_folder() {
        let at = |u: &str| resolve(u, Path::new("/m"), false);
        assert_eq!(at("a%20b/c.png").unwrap(), Path::new("/m/a b/c.png"));
        assert_eq!(at("a/../b.bin").unwrap(), Path::new("/m/a/../b.bin"));
        for bad in [
            "../a",
            "a/../../b",
            "/etc/passwd",
            "%2e%2e/a",
            "%2Fetc/passwd",
            "http://x/y",
            "file:///a",
            "a%00b",
        ] {
            assert!(at(bad).is_err(), "{bad}");
        }
        assert!(resolve("../a", Path::new("/m"), true).is_ok());
    }
}
