//! Every valid and damaged picture of other projects' test suites: a picture or an error, never a crash, a hang or an allocation
//! out of proportion. Skips when the files are not there. `-- --nocapture` prints the table of outcomes.

use std::alloc::{GlobalAlloc, Layout, System};
use std::collections::BTreeMap;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

use etendue_image::{DecodeLimits, ImageError, Pixels, decode, decode_environment, read_exr_layers};

/// Counts the bytes that are allocated now, and the most there ever were.
struct Counting;
static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn grow(n: usize) {
    let now = NOW.fetch_add(n, Relaxed) + n;
    PEAK.fetch_max(now, Relaxed);
}

// SAFETY: every call goes to the system's allocator unchanged; the counters do not allocate.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, l: Layout) -> *mut u8 {
        grow(l.size());
        unsafe { System.alloc(l) }
    }
    unsafe fn alloc_zeroed(&self, l: Layout) -> *mut u8 {
        grow(l.size());
        unsafe { System.alloc_zeroed(l) }
    }
    unsafe fn dealloc(&self, p: *mut u8, l: Layout) {
        NOW.fetch_sub(l.size(), Relaxed);
        unsafe { System.dealloc(p, l) }
    }
    unsafe fn realloc(&self, p: *mut u8, l: Layout, size: usize) -> *mut u8 {
        // Both blocks live while the content moves.
        grow(size);
        let q = unsafe { System.realloc(p, l, size) };
        NOW.fetch_sub(l.size(), Relaxed);
        q
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets")
}

fn files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let p = entry.path();
        if p.is_dir() { files(&p, out) } else { out.push(p) }
    }
}

/// What a reader made of a file, or the panic it died of.
struct Outcome {
    result: Result<Result<Vec<f32>, ImageError>, String>,
    time: Duration,
    peak: usize,
}

fn outcome(read: impl FnOnce() -> Result<Vec<f32>, ImageError> + std::panic::UnwindSafe) -> Outcome {
    let before = NOW.load(Relaxed);
    PEAK.store(before, Relaxed);
    let start = Instant::now();
    let result = catch_unwind(read).map_err(|p| {
        p.downcast_ref::<String>()
            .cloned()
            .or(p.downcast_ref::<&str>().map(|s| s.to_string()))
            .unwrap_or_default()
    });
    Outcome { result, time: start.elapsed(), peak: PEAK.load(Relaxed).saturating_sub(before) }
}

/// Runs all readers over one file: textures, skies and layers each see every file.
fn run(bytes: &[u8]) -> [(&'static str, Outcome); 3] {
    let limits = DecodeLimits::default();
    // Results are dropped inside, so that only the peak of the reader itself counts; skies hand back a few samples.
    [
        ("decode", outcome(|| decode(bytes, &limits).map(|_| Vec::new()))),
        (
            "sky",
            outcome(|| {
                decode_environment(bytes, &limits).map(|e| match e.image.pixels {
                    Pixels::F32(p) => vec![
                        p.iter().copied().fold(f32::INFINITY, f32::min),
                        p.iter().copied().fold(0.0, f32::max),
                        p.iter().sum(),
                    ],
                    _ => vec![f32::NAN],
                })
            }),
        ),
        ("layers", outcome(|| read_exr_layers(bytes, &limits).map(|_| Vec::new()))),
    ]
}

fn kind(e: &ImageError) -> &'static str {
    match e {
        ImageError::UnknownFormat { .. } => "unknown format",
        ImageError::Damaged { .. } => "damaged",
        ImageError::Unsupported { .. } => "unsupported",
        ImageError::TooLarge { .. } => "too large",
        _ => "other error",
    }
}

#[test]
fn whole_corpora() {
    let assets = assets();
    if !assets.is_dir() {
        println!("skipped: no test assets beside the workspace");
        return;
    }
    std::panic::set_hook(Box::new(|_| {}));
    let mut folders: Vec<PathBuf> = [
        "pngsuite",
        "jpeg-reftest",
        "image-rs-hdr",
        "openexr-images",
        "exrs-compression",
        "hdrify",
        "ktx2-cts",
    ]
    .iter()
    .map(|d| assets.join("images-valid").join(d))
    .collect();
    for entry in std::fs::read_dir(assets.join("malformed")).into_iter().flatten().flatten() {
        let name = entry.file_name().into_string().unwrap_or_default();
        if ["exr-", "png-", "jpg-", "image-", "ktx2-"].iter().any(|p| name.starts_with(p)) {
            folders.push(entry.path());
        }
    }
    folders.sort();

    let mut complaints = Vec::new();
    let (mut total, mut pictures) = (0, 0);
    for folder in folders {
        let mut list = Vec::new();
        files(&folder, &mut list);
        list.sort();
        let mut table: BTreeMap<String, usize> = BTreeMap::new();
        let (mut slowest, mut hungriest) = (Duration::ZERO, 0);
        for path in &list {
            let bytes = std::fs::read(path).unwrap();
            let name = path.strip_prefix(&assets).unwrap().display().to_string();
            let start = bytes.first_chunk::<4>().copied().unwrap_or_default();
            for (reader, o) in run(&bytes) {
                let main = match start {
                    [0x76, 0x2f, 0x31, 0x01] => reader != "decode",
                    [b'#', b'?', ..] => reader == "sky",
                    _ => reader == "decode",
                };
                slowest = slowest.max(o.time);
                hungriest = hungriest.max(o.peak);
                if o.time > Duration::from_secs(10) {
                    complaints.push(format!("{name}: {reader} took {:?}", o.time));
                }
                if o.peak > 64 * bytes.len() + (64 << 20) {
                    complaints.push(format!(
                        "{name}: {reader} allocated {} of {} bytes",
                        o.peak,
                        bytes.len()
                    ));
                }
                let column = match &o.result {
                    Err(panic) => {
                        complaints.push(format!("{name}: {reader} panicked: {panic}"));
                        "panic"
                    }
                    Ok(Err(e)) => {
                        if folder.starts_with(assets.join("images-valid")) && main {
                            println!("  {name}: {reader}: {e}");
                        }
                        kind(e)
                    }
                    Ok(Ok(range)) => {
                        if reader == "sky" && !(range[0] >= 0.0 && range[1].is_finite()) {
                            complaints.push(format!("{name}: the sky has samples of {range:?}"));
                        }
                        pictures += usize::from(main);
                        "picture"
                    }
                };
                if main {
                    *table.entry(format!("{reader}: {column}")).or_default() += 1;
                }
                // PngSuite: names that start with x are broken on purpose.
                let file = path.file_name().unwrap().to_str().unwrap();
                let broken = folder.ends_with("png-pngsuite-corrupt") && file.starts_with('x');
                if broken && matches!(o.result, Ok(Ok(_))) {
                    complaints.push(format!("{name}: {reader} accepted it"));
                }
                let png = folder.ends_with("pngsuite") && file.ends_with(".png");
                if png && reader == "decode" && !matches!(o.result, Ok(Ok(_))) {
                    complaints.push(format!("{name}: rejected"));
                }
            }
        }
        total += list.len();
        println!(
            "{}: {} files, slowest {slowest:.2?}, peak {:.1} MB, {table:?}",
            folder.strip_prefix(&assets).unwrap().display(),
            list.len(),
            hungriest as f64 / 1e6
        );
    }
    let _ = std::panic::take_hook();
    println!("{total} files, {pictures} pictures");
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    assert!(total > 1000 && pictures > 500, "the corpora have shrunk: {total} files, {pictures} pictures");
}
