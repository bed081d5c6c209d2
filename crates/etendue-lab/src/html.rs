//! The frame of a self-contained HTML page.

pub(crate) use crate::draw::svg::escape;

/// Colours for light and dark, type, tables. Charts stand on white in both.
const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#222;--dim:#666;--paper:#fff;--well:#f2f2f2;--line:#ddd;--accent:#0072b2;--focus:#e69f00;\
--bad:#b00;--good:#00704f}
@media(prefers-color-scheme:dark){:root{--ink:#ddd;--dim:#999;--paper:#181818;--well:#0c0c0c;--line:#444;--accent:#2288c8;\
--bad:#ff7a6b;--good:#4fd0a5}a{color:#7cc4f0}}
body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:80rem;padding:0 1rem;color:var(--ink);background:var(--paper)}
h1{font-size:1.6rem}h2{font-size:1.25rem;margin-top:2.2rem;border-bottom:1px solid var(--line)}
code,pre,td.n{font-family:ui-monospace,Menlo,Consolas,monospace;font-size:.88em}
td.n,td code{white-space:nowrap}
pre{overflow-x:auto}svg{max-width:100%;height:auto;border-radius:4px}code{overflow-wrap:anywhere}
table{border-collapse:collapse}td,th{padding:.15rem .5rem;text-align:left;vertical-align:top}
.bad{color:var(--bad);font-weight:bold}.dim{color:var(--dim)}
[hidden]{display:none!important}
";

/// A page with a heading and a style, no scripts and nothing from elsewhere.
pub(crate) fn page(title: &str, style: &str, body: &str) -> String {
    page_with_script(title, style, body, "")
}

/// The same with a script of its own, which runs when the page is there.
pub(crate) fn page_with_script(title: &str, style: &str, body: &str, script: &str) -> String {
    let script = if script.is_empty() { String::new() } else { format!("<script>\n{script}</script>\n") };
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{0}</title>\n<style>\n{STYLE}{style}\n</style>\n\
         </head>\n<body>\n<h1>{0}</h1>\n{body}\n{script}</body>\n</html>\n",
        escape(title)
    )
}
