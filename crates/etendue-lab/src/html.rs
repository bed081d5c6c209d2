//! The frame of a self-contained HTML page.

pub(crate) use crate::draw::svg::escape;

/// A page with a heading and a style, no scripts and nothing from elsewhere.
pub(crate) fn page(title: &str, style: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{0}</title>\n<style>\n\
         body{{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:80rem;padding:0 1rem;color:#222}}\n\
         h1{{font-size:1.6rem}}h2{{font-size:1.25rem;margin-top:2.2rem;border-bottom:1px solid #ddd}}\n\
         code,pre,td.n{{font-family:ui-monospace,Menlo,Consolas,monospace;font-size:.88em}}\n\
         table{{border-collapse:collapse}}td,th{{padding:.15rem .5rem;text-align:left;vertical-align:top}}\n\
         {style}\n</style>\n</head>\n<body>\n<h1>{0}</h1>\n{body}\n</body>\n</html>\n",
        escape(title)
    )
}
