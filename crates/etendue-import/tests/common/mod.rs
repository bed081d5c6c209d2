//! Makes small glTF files in memory.
#![allow(dead_code, reason = "each test file uses its own part")]

pub mod scenes;
pub mod surfaces;

use etendue_import::{ImportError, ImportOptions, Imported, import_bytes};
use serde_json::{Value, json};

pub const I8: u32 = 5120;
pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// A model under construction: a JSON document and the bytes of its one buffer.
pub struct Model {
    pub json: Value,
    pub bytes: Vec<u8>,
}

/// Little-endian bytes of a list of numbers.
pub trait Bytes {
    fn bytes(&self) -> Vec<u8>;
}
macro_rules! bytes {
    ($($t:ty)*) => { $(
        impl Bytes for [$t] {
            fn bytes(&self) -> Vec<u8> { self.iter().flat_map(|v| v.to_le_bytes()).collect() }
        }
        impl<const N: usize> Bytes for [$t; N] {
            fn bytes(&self) -> Vec<u8> { self[..].bytes() }
        }
    )* };
}
bytes!(i8 u8 i16 u16 u32 f32);

impl Default for Model {
    fn default() -> Self {
        Self::new()
    }
}

impl Model {
    /// An empty document.
    pub fn new() -> Self {
        Self { json: json!({"asset": {"version": "2.0"}}), bytes: Vec::new() }
    }

    /// Appends `entry` to the document's array `key` and returns its number.
    pub fn push(&mut self, key: &str, entry: Value) -> u32 {
        let list = self.json[key].as_array().cloned().unwrap_or_default();
        let n = list.len();
        self.json[key] = Value::Array(list.into_iter().chain([entry]).collect());
        n as u32
    }

    /// Appends bytes to the buffer, aligned, and returns the number of their view.
    pub fn view(&mut self, bytes: &[u8]) -> u32 {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// Appends an accessor over its own view.
    pub fn accessor(
        &mut self,
        data: &(impl Bytes + ?Sized),
        component: u32,
        shape: &str,
        count: usize,
    ) -> u32 {
        let view = self.view(&data.bytes());
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "count": count, "type": shape}),
        )
    }

    /// An accessor of floats.
    pub fn floats(&mut self, data: &[f32], shape: &str) -> u32 {
        let n = match shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            other => panic!("{other}"),
        };
        self.accessor(data, F32, shape, data.len() / n)
    }

    /// A mesh of one primitive with `attributes`.
    pub fn mesh(&mut self, primitive: Value) -> u32 {
        self.push("meshes", json!({"primitives": [primitive]}))
    }

    /// A node, shown by the scene.
    pub fn node(&mut self, node: Value) -> u32 {
        let n = self.push("nodes", node);
        if self.json["scenes"].is_null() {
            self.json["scenes"] = json!([{"nodes": []}]);
            self.json["scene"] = json!(0);
        }
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(n));
        n
    }

    /// A triangle (0,0,0), (1,0,0), (0,1,0) with `more` attributes, on a node of its own; returns the primitive's path
    /// for further changes.
    pub fn triangle(&mut self, more: Value) -> u32 {
        let p = self.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], "VEC3");
        let mut attributes = json!({"POSITION": p});
        for (k, v) in more.as_object().into_iter().flatten() {
            attributes[k] = v.clone();
        }
        let mesh = self.mesh(json!({"attributes": attributes}));
        self.node(json!({"mesh": mesh}));
        mesh
    }

    /// The document with the buffer's length filled in.
    fn finished(&self) -> Value {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() && json["buffers"].is_null() {
            json["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        }
        json
    }

    /// As a binary glTF file.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = serde_json::to_vec(&self.finished()).unwrap();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut bin = self.bytes.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut out = b"glTF".to_vec();
        let length = 12 + 8 + json.len() + if bin.is_empty() { 0 } else { 8 + bin.len() };
        out.extend([2, length as u32].bytes());
        out.extend((json.len() as u32).to_le_bytes());
        out.extend(b"JSON");
        out.extend(json);
        if !bin.is_empty() {
            out.extend((bin.len() as u32).to_le_bytes());
            out.extend(b"BIN\0");
            out.extend(bin);
        }
        out
    }

    pub fn import_with(&self, options: &ImportOptions) -> Result<Imported, ImportError> {
        import_bytes(&self.glb(), "test.glb", options)
    }

    /// Imports with default options; must succeed.
    pub fn import(&self) -> Imported {
        self.import_with(&ImportOptions::default()).unwrap_or_else(|e| panic!("{e}"))
    }

    /// Imports and must fail; returns the message.
    pub fn error(&self) -> String {
        match self.import_with(&ImportOptions::default()) {
            Ok(_) => panic!("was imported"),
            Err(e) => e.to_string(),
        }
    }
}

/// True if one of the warnings holds `text`.
pub fn warned(i: &Imported, text: &str) -> bool {
    i.warnings.iter().any(|w| w.to_string().contains(text))
}

/// A `data:` URI.
pub fn data_uri(bytes: &[u8]) -> String {
    use base64::Engine as _;
    format!(
        "data:application/octet-stream;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(bytes)
    )
}

/// Two by one pixels, red and blue.
pub fn png() -> Vec<u8> {
    let (rgb, mut out) = ([0u8, 255, 0, 0, 0, 0, 255], b"\x89PNG\r\n\x1a\n".to_vec());
    let mut chunk = |kind: &[u8; 4], data: &[u8]| {
        out.extend((data.len() as u32).to_be_bytes());
        let body = [&kind[..], data].concat();
        out.extend(&body);
        out.extend(crc(&body).to_be_bytes());
    };
    chunk(b"IHDR", &[0, 0, 0, 2, 0, 0, 0, 1, 8, 2, 0, 0, 0]);
    // Zlib with one stored block and its Adler-32 sum.
    let (mut a, mut b) = (1u32, 0u32);
    for byte in rgb {
        a = (a + u32::from(byte)) % 65521;
        b = (b + a) % 65521;
    }
    let n = rgb.len() as u16;
    let stored =
        [&[0x78, 1, 1][..], &n.to_le_bytes(), &(!n).to_le_bytes(), &rgb, &(b << 16 | a).to_be_bytes()];
    chunk(b"IDAT", &stored.concat());
    chunk(b"IEND", &[]);
    out
}

fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |c, &b| {
        (0..8).fold(c ^ u32::from(b), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
    })
}

/// A triangle with `material`, textures 0 and 1 of the same image.
pub fn with(material: Value) -> Model {
    let mut m = Model::new();
    let uv = m.floats(&[0., 0., 1., 0., 0., 1.], "VEC2");
    m.triangle(json!({"TEXCOORD_0": uv, "TEXCOORD_1": uv}));
    m.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    m.push("images", json!({"uri": data_uri(&png())}));
    m.push("samplers", json!({"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9987}));
    m.push("textures", json!({"source": 0}));
    m.push("textures", json!({"source": 0, "sampler": 0}));
    m.push("materials", material);
    m
}
