//! What goes wrong on the command line, and the way out.

use crate::image::ImageError;
use crate::import::ImportError;
use crate::import::scene_file::{Mistake, SceneFileError};
use crate::render::{FilmError, MergeError};
use std::path::PathBuf;

/// An error as the user sees it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum CliError {
    /// The arguments contradict each other or the scene.
    #[error("{0}")]
    #[diagnostic(help("`etendue help` lists the commands, `etendue help render` the options"))]
    Usage(String),
    /// The model does not load.
    #[error(transparent)]
    #[diagnostic(help("{}", import_help(_0)))]
    Import(#[from] Box<ImportError>),
    /// A scene file is wrong somewhere.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Mistake(#[from] Box<MistakeReport>),
    /// A scene file cannot be read, or a model that it names does not load.
    #[error(transparent)]
    #[diagnostic(help("{}", scene_help(_0)))]
    SceneFile(SceneFileError),
    /// An environment or picture does not load or cannot be written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file is not there or cannot be read.
    #[error("cannot read {path}: {source}", path = path.display())]
    #[diagnostic(help("looked for it at {}", absolute(path)))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The sky is not there or cannot be read.
    #[error("cannot read the sky {}: {source}", path.display())]
    #[diagnostic(help(
        "looked for it at {}; a sky is a .hdr or .exr file, `studio`, `none` or a colour such as 0.5,0.7,1",
        absolute(path)
    ))]
    Sky {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file cannot be written.
    #[error("cannot write {}: {}", path.display(), cause(path, source))]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A film file is damaged or something else.
    #[error("{}: {source}", path.display())]
    #[diagnostic(help("film files are written by `etendue render --film FILE`"))]
    Film {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: FilmError,
    },
    /// Films that do not add.
    #[error("cannot add {path}: {source}", path = path.display())]
    #[diagnostic(help(
        "films add if they were rendered from the same scene, camera and settings, with disjoint --samples"
    ))]
    Merge {
        /// The second film.
        path: PathBuf,
        /// Why not.
        source: MergeError,
    },
    /// A film cannot be continued with these arguments.
    #[error("cannot go on from {}: {why}", path.display())]
    #[diagnostic(help("leave out what changes the picture, or render anew without --resume"))]
    Resume {
        /// The film.
        path: PathBuf,
        /// What would make it another picture.
        why: String,
    },
    /// The work is done but the picture cannot be written; the samples are kept.
    #[error("{cause}")]
    #[diagnostic(help("the samples are kept: etendue merge {} -o PICTURE", shell_word(&film.to_string_lossy())))]
    Unwritten {
        /// What went wrong.
        cause: Box<CliError>,
        /// Where the samples are.
        film: PathBuf,
    },
    /// The user stopped the run; what was done is kept.
    #[error("interrupted after {done}; {} and {} are written", picture.display(), film.display())]
    #[diagnostic(help("go on with: etendue render --resume {}", shell_word(&film.to_string_lossy())))]
    Interrupted {
        /// How far it got.
        done: String,
        /// The picture so far.
        picture: PathBuf,
        /// The film so far.
        film: PathBuf,
    },
    /// The user stopped a run over frames.
    #[error("interrupted at frame {frame} after {done}; {} is written", film.display())]
    #[diagnostic(help("the same command goes on where it stopped"))]
    InterruptedFrames {
        /// The frame's number.
        frame: u32,
        /// How far it got.
        done: String,
        /// The film so far.
        film: PathBuf,
    },
    /// The scene contradicts itself: a defect of the importer.
    #[error("the scene is inconsistent: {0}")]
    Scene(#[from] crate::scene::InvalidScene),
    /// A model or parameter that there is not, or a value that does not fit.
    #[error(transparent)]
    #[diagnostic(help("`etendue lab list` lists the models, `etendue lab list MODEL` its parameters"))]
    Parameter(#[from] crate::bxdf::model::ParameterError),
    /// Models that were checked do not load, or not without warnings.
    #[error("{wanting} of {files} files are found wanting")]
    #[diagnostic(help("`etendue info FILE` tells more of one that loads"))]
    Wanting {
        /// How many.
        wanting: usize,
        /// Of how many.
        files: usize,
    },
    /// A claimed law is broken.
    #[error("{count} of {cells} cells fail; see {}", report.display())]
    #[diagnostic(help("the seed and the parameters of each are in the report"))]
    Laws {
        /// How many.
        count: usize,
        /// Of how many.
        cells: usize,
        /// Where they are listed.
        report: PathBuf,
    },
    /// Two pictures that have nothing to be compared by.
    #[error("cannot compare: {0}")]
    #[diagnostic(help("{}", incomparable_help(_0)))]
    Incomparable(crate::lab::compare::CompareError),
    /// A picture is further from its reference than it may be.
    #[error("the mean FLIP is {flip:.5}, and at most {limit} was asked for{}", see(report))]
    Differs {
        /// Mean FLIP.
        flip: f64,
        /// What it may be.
        limit: f64,
        /// The page that shows it, if one was asked for.
        report: Option<PathBuf>,
    },
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

/// A mistake in a scene file with the text around it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("{mistake}")]
pub struct MistakeReport {
    mistake: Mistake,
    #[source_code]
    text: miette::NamedSource<String>,
    #[label("here")]
    at: miette::SourceSpan,
    #[help]
    help: Option<String>,
}

/// How a limit is raised.
fn raise(limit: &str) -> String {
    match limit {
        "memory_bytes" => "--max-memory SIZE raises the limit, as in --max-memory 64GiB".into(),
        "file_bytes" | "image_bytes" | "geometry_bytes" => {
            format!("--max-memory SIZE or --limit {limit}=SIZE raises the limit, as in --max-memory 64GiB")
        }
        limit => format!("--limit {limit}=NUMBER raises the limit; `etendue help render` lists the limits"),
    }
}

fn scene_help(e: &SceneFileError) -> String {
    match e {
        SceneFileError::Read { file, .. } => {
            format!("looked for it at {}; `etendue new` writes one", absolute(file.as_ref()))
        }
        SceneFileError::Model { source, .. } => import_help(source),
        SceneFileError::TooLarge { limit, .. } => raise(limit),
        _ => "a scene file is text of a few lines: `etendue new` writes one".into(),
    }
}

impl From<SceneFileError> for CliError {
    fn from(e: SceneFileError) -> Self {
        match e {
            SceneFileError::Wrong(mistake) => Self::Mistake(Box::new(MistakeReport {
                text: miette::NamedSource::new(&mistake.file, mistake.text.to_string()),
                at: mistake.span.clone().into(),
                help: mistake.help.clone(),
                mistake: *mistake,
            })),
            e => Self::SceneFile(e),
        }
    }
}

fn absolute(path: &std::path::Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf()).display().to_string()
}

/// What the system says, without the path that some messages begin with.
fn cause(path: &std::path::Path, source: &std::io::Error) -> String {
    let (text, prefix) = (source.to_string(), format!("{}: ", path.display()));
    text.strip_prefix(&prefix).unwrap_or(&text).to_string()
}

fn see(report: &Option<PathBuf>) -> String {
    report.as_ref().map_or(String::new(), |r| format!("; see {}", r.display()))
}

fn incomparable_help(e: &crate::lab::compare::CompareError) -> &'static str {
    match e {
        crate::lab::compare::CompareError::Kind { .. } => {
            "`etendue tonemap LIGHT -o PICTURE.png` develops light; then compare the pictures"
        }
        _ => "pictures are compared pixel by pixel: bring both to one size",
    }
}

fn import_help(e: &ImportError) -> String {
    match e {
        ImportError::Read { file, .. } => format!("looked for it at {}", absolute(file.as_ref())),
        ImportError::Missing { reason, .. } if reason.contains("outside") => {
            "--allow-outside lets the model read files outside its own folder".into()
        }
        ImportError::Missing { .. } => "a .gltf file needs its buffers and images beside it".into(),
        ImportError::Unsupported { .. } => "export the model without it".into(),
        ImportError::TooLarge { limit, .. } => raise(limit),
        _ => "https://github.khronos.org/glTF-Validator examines a file in detail".into(),
    }
}

/// `text` so that a shell takes it as one word.
pub(crate) fn shell_word(text: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%^".contains(c) || !c.is_ascii();
    if !text.is_empty() && text.chars().all(plain) {
        return text.to_string();
    }
    format!("'{}'", text.replace('\'', "'\\''"))
}

impl CliError {
    /// 2 for wrong usage, 3 for pictures that differ by more than is allowed, 1 for anything else.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) | Self::Parameter(_) => 2,
            Self::Differs { .. } | Self::Wanting { .. } => 3,
            _ => 1,
        }
    }
}

impl From<ImportError> for CliError {
    fn from(e: ImportError) -> Self {
        Self::Import(Box::new(e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_survive_a_shell() {
        assert_eq!(shell_word("a/b-c.film"), "a/b-c.film");
        assert_eq!(shell_word("my film.film"), "'my film.film'");
        assert_eq!(shell_word("it's"), r"'it'\''s'");
        assert_eq!(shell_word(""), "''");
    }

    #[test]
    fn a_path_is_named_once() {
        let e = CliError::Write { path: "a.png".into(), source: std::io::Error::other("a.png: no space") };
        assert_eq!(e.to_string(), "cannot write a.png: no space");
    }
}
