//! A file is read in a process of its own, which is watched.

use etendue::image::{DecodeLimits, ImageError, Ktx2, decode, decode_environment, read_exr_layers};
use etendue::import::{ImportError, ImportOptions, import};
use std::fmt;
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Most time for a file.
const MOST_TIME: Duration = Duration::from_secs(10);

/// What became of a file.
#[derive(Debug)]
pub enum Outcome {
    /// It was read.
    Loaded {
        /// Kinds of warnings, and of breaches of the specification that no picture depends on.
        warnings: usize,
        /// The breaches alone.
        breaches: usize,
    },
    /// An error was given.
    Refused {
        /// Whether it names a feature that is not supported.
        unsupported: bool,
        /// Whether it names a file that is not there: the suite was copied without it.
        missing: bool,
        message: String,
    },
    /// The process ended in another way.
    Panicked(String),
    /// It took longer than [`MOST_TIME`].
    Hung,
    /// It took more memory than it may: so many bytes.
    Greedy(u64),
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Loaded { warnings, .. } => write!(f, "loaded with {warnings} warnings"),
            Self::Refused { message, .. } | Self::Panicked(message) => f.write_str(message),
            Self::Hung => write!(f, "longer than {} s", MOST_TIME.as_secs()),
            Self::Greedy(bytes) => write!(f, "{:.1} MB of memory", *bytes as f64 / 1e6),
        }
    }
}

/// How a file's process went.
pub struct Run {
    pub outcome: Outcome,
    /// Peak memory over what it may be.
    pub share_of_memory: f64,
    pub seconds: f64,
}

/// Reads `path` with the reader for what it is, and prints the outcome and the peak of this process' memory.
pub fn read_one(path: &Path) {
    let line = match read(path) {
        Ok((warnings, breaches)) => format!("loaded\t{warnings} {breaches}"),
        Err((kind, message)) => format!("{kind}\t{}", message.replace(['\n', '\t'], " ")),
    };
    println!("{}\t{line}", memory("self", "VmHWM:").unwrap_or(0));
}

/// Kinds of remarks and how many of them are breaches, or the kind of the error and what it says.
fn read(path: &Path) -> Result<(usize, usize), (&'static str, String)> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    if extension == "gltf" || extension == "glb" {
        return match import(path, &ImportOptions { conformance: true, ..ImportOptions::default() }) {
            Ok(model) => {
                let breaches = model.info.breaches.len();
                Ok((model.warnings.len() + breaches, breaches))
            }
            Err(e) => {
                let kind = match e {
                    ImportError::Unsupported { .. } => "unsupported",
                    ImportError::Missing { .. } => "missing",
                    _ => "refused",
                };
                Err((kind, e.to_string()))
            }
        };
    }
    let bytes = std::fs::read(path).map_err(|e| ("refused", e.to_string()))?;
    let limits = DecodeLimits::default();
    let result = match bytes.as_slice() {
        [0xab, b'K', b'T', b'X', b' ', b'2', b'0', ..] => {
            Ktx2::new(&bytes, &limits).and_then(|k| {
                (0..k.mips()).try_for_each(|i| k.mip(i).map(drop))?;
                // The suite has files that are good but for glTF's rules.
                let of_gltf = path.to_string_lossy().contains("GLTFBU");
                let for_gltf = if of_gltf { k.remarks_for_gltf().len() } else { 0 };
                let n = k.remarks().len() + for_gltf;
                Ok((n, n))
            })
        }
        [0x76, 0x2f, 0x31, 0x01, ..] => {
            // Both readers see it; as a picture it counts.
            drop(decode_environment(&bytes, &limits));
            read_exr_layers(&bytes, &limits).map(|_| (0, 0))
        }
        [b'#', b'?', ..] => decode_environment(&bytes, &limits).map(|_| (0, 0)),
        _ => decode(&bytes, &limits).map(|_| (0, 0)),
    };
    let kind =
        |e: &ImageError| if matches!(e, ImageError::Unsupported { .. }) { "unsupported" } else { "refused" };
    result.map_err(|e| (kind(&e), e.to_string()))
}

/// A figure of a process' memory, bytes, where the system tells.
fn memory(process: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|k| k * 1024)
}

/// Starts a process for `path` and sees it through.
pub fn watch(path: &Path) -> Result<Run, std::io::Error> {
    let size = std::fs::metadata(path)?.len();
    let most = 64 * size + (64 << 20);
    let started = Instant::now();
    let mut child = Command::new(std::env::current_exe()?)
        .arg("--one")
        .arg(path)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    let stopped = wait(&mut child, started, most)?;
    let seconds = started.elapsed().as_secs_f64();
    let (mut out, mut err) = (String::new(), String::new());
    if let (Some(o), Some(e)) = (&mut child.stdout, &mut child.stderr) {
        o.read_to_string(&mut out)?;
        e.read_to_string(&mut err)?;
    }
    let mut parts = out.trim_end().splitn(3, '\t');
    let peak: u64 = parts.next().and_then(|p| p.parse().ok()).unwrap_or(0);
    let outcome = match (stopped, parts.next(), parts.next().unwrap_or_default()) {
        (Some(outcome), _, _) => outcome,
        (None, Some(_), _) if peak > most => Outcome::Greedy(peak),
        (None, Some("loaded"), n) => {
            let mut n = n.split(' ').map(|n| n.parse().unwrap_or(0));
            Outcome::Loaded { warnings: n.next().unwrap_or(0), breaches: n.next().unwrap_or(0) }
        }
        (None, Some(kind), message) => Outcome::Refused {
            unsupported: kind == "unsupported",
            missing: kind == "missing",
            message: message.into(),
        },
        (None, None, _) => Outcome::Panicked(err.lines().take(3).collect::<Vec<_>>().join(" ")),
    };
    Ok(Run { outcome, share_of_memory: peak as f64 / most as f64, seconds })
}

/// Waits for the end, or makes one; `None` if it came by itself. The little that a child prints fits into its pipes.
fn wait(child: &mut Child, started: Instant, most: u64) -> Result<Option<Outcome>, std::io::Error> {
    let id = child.id().to_string();
    loop {
        if child.try_wait()?.is_some() {
            return Ok(None);
        }
        let now = memory(&id, "VmRSS:").unwrap_or(0);
        let outcome = match started.elapsed() > MOST_TIME {
            true => Outcome::Hung,
            // Somewhat more, so that what ends by itself is judged by its own count.
            false if now > most + most / 4 => Outcome::Greedy(now),
            false => {
                std::thread::sleep(Duration::from_millis(2));
                continue;
            }
        };
        child.kill()?;
        child.wait()?;
        return Ok(Some(outcome));
    }
}
