//! A folder to run the program in, and what comes of it.

use etendue::image::{ChannelData, DecodeLimits, ExrImage, Image, Pixels, decode, read_exr_layers};
use etendue::render::{Film, FilmInfo};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A temporary folder.
pub struct Lab(tempfile::TempDir);

/// How a run ended.
#[derive(Debug)]
pub struct Run {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Run {
    /// Asserts the exit code and returns the messages.
    #[track_caller]
    pub fn ends_with(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{self:#?}");
        self
    }

    /// Asserts that the error message contains all of these.
    #[track_caller]
    pub fn says(self, parts: &[&str]) -> Self {
        for p in parts {
            assert!(self.err.contains(p), "{p:?} is not in: {}", self.err);
        }
        assert!(!self.err.contains("panicked"), "{}", self.err);
        self
    }
}

impl Lab {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn folder(&self) -> &Path {
        self.0.path()
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        std::fs::write(self.path(name), bytes).unwrap();
        self.path(name)
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Names of the files, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn command(&self, line: &str) -> Command {
        let mut c = Command::new(env!("CARGO_BIN_EXE_etendue"));
        c.current_dir(self.folder()).args(line.split_whitespace()).stdin(Stdio::null());
        c
    }

    /// Runs `etendue` with the words of `line` to its end.
    pub fn run(&self, line: &str) -> Run {
        let o = self.command(line).output().unwrap();
        let text = |b: Vec<u8>| String::from_utf8(b).expect("messages are UTF-8");
        Run { code: o.status.code(), out: text(o.stdout), err: text(o.stderr) }
    }

    /// Runs it, which must go well.
    #[track_caller]
    pub fn ok(&self, line: &str) -> Run {
        self.run(line).ends_with(0)
    }

    /// Starts it; see [`Lab::finish`].
    pub fn start(&self, line: &str) -> Child {
        self.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Waits for a run that was started.
    pub fn finish(&self, child: Child) -> Run {
        let o = child.wait_with_output().unwrap();
        let text = |b: Vec<u8>| String::from_utf8_lossy(&b).into_owned();
        Run { code: o.status.code(), out: text(o.stdout), err: text(o.stderr) }
    }

    pub fn image(&self, name: &str) -> Image {
        decode(&self.bytes(name), &DecodeLimits::default()).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn exr(&self, name: &str) -> ExrImage {
        read_exr_layers(&self.bytes(name), &DecodeLimits::default()).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn film(&self, name: &str) -> (Film, FilmInfo) {
        Film::from_bytes(&self.bytes(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }
}

/// A channel as floats.
pub fn plane(exr: &ExrImage, layer: &str, channel: &str) -> Vec<f32> {
    let l = exr.layer(layer).unwrap_or_else(|| panic!("layer {layer:?}"));
    match l.channel(channel).unwrap_or_else(|| panic!("channel {layer}.{channel}")) {
        ChannelData::Color(v) | ChannelData::F32(v) => v.clone(),
        ChannelData::U32(v) => v.iter().map(|x| *x as f32).collect(),
    }
}

/// Samples as floats.
pub fn samples(image: &Image) -> Vec<f32> {
    match &image.pixels {
        Pixels::U8(p) => p.iter().map(|v| f32::from(*v)).collect(),
        Pixels::U16(p) => p.iter().map(|v| f32::from(*v)).collect(),
        Pixels::F32(p) => p.clone(),
    }
}

/// Waits until `ready`, at most half a minute.
#[track_caller]
pub fn wait_for(what: &str, mut ready: impl FnMut() -> bool) {
    let start = Instant::now();
    while !ready() {
        assert!(start.elapsed() < Duration::from_secs(30), "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A red triangle in the plane z = 0, and a camera 3 m before it; extra members go into the document.
pub fn triangle(extra: &str) -> String {
    let mut bytes = Vec::new();
    for v in [-1.0f32, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(v.to_le_bytes());
    }
    let hex: String = bytes.iter().map(|b| format!("%{b:02x}")).collect();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],
        "nodes":[{{"name":"sign","mesh":0}},{{"camera":0,"translation":[0,0,3]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}}],
        "materials":[{{"name":"red","doubleSided":true,"pbrMetallicRoughness":{{"baseColorFactor":[1,0,0,1],"metallicFactor":0}}}}],
        "cameras":[{{"name":"front","type":"perspective","perspective":{{"yfov":0.5,"znear":0.1}}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[-1,-1,0],"max":[1,1,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "buffers":[{{"byteLength":36,"uri":"data:application/octet-stream,{hex}"}}]{extra}}}"#
    )
}
