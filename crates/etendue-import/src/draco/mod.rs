//! Meshes of `KHR_draco_mesh_compression`.
//!
//! The bitstream is decoded by the crate `draco-core`; here stand the limits on what it may decode, the checks of what it
//! decoded, and the way from its attributes to glTF's accessors (`expand`).

mod expand;

pub(crate) use expand::expand;

use crate::document::Component;
use draco_core::{
    DataType, DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointAttribute, PointIndex,
};

/// What a stream may decode to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DracoLimits {
    /// Most triangles.
    pub triangles: u64,
    /// Most bytes of attribute values.
    pub bytes: u64,
}

/// Why a stream was not decoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DracoError {
    /// The bytes are not a mesh that can be decoded.
    #[error("damaged Draco data: {0}")]
    Damaged(String),
    /// It decodes to more than the limits allow.
    #[error("the Draco data decode to more than is announced: {0}")]
    TooLarge(String),
}

/// A decoded mesh: points with attributes, and triangles between them.
pub struct DracoMesh(Mesh);

/// Decodes a whole stream.
///
/// # Errors
/// [`DracoError`].
pub fn decode(bytes: &[u8], limits: &DracoLimits) -> Result<DracoMesh, DracoError> {
    let allowed = DecodeLimits::default()
        .with_max_points(limits.triangles.saturating_mul(3))
        .with_max_faces(limits.triangles)
        .with_max_decoded_bytes(limits.bytes);
    let mut buffer = DecoderBuffer::new(bytes).with_limits(allowed);
    let mut mesh = Mesh::new();
    MeshDecoder::new().decode(&mut buffer, &mut mesh).map_err(|e| match e.kind() {
        ErrorKind::LimitExceeded => DracoError::TooLarge(e.message().to_owned()),
        _ => DracoError::Damaged(e.to_string()),
    })?;
    let points = mesh.num_points();
    if mesh.faces().iter().flatten().any(|p| p.0 as usize >= points) {
        return Err(DracoError::Damaged("a triangle of points that there are not".into()));
    }
    Ok(DracoMesh(mesh))
}

impl DracoMesh {
    /// Number of points.
    pub fn points(&self) -> usize {
        self.0.num_points()
    }

    /// The triangles, each below [`DracoMesh::points`].
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.0.faces().iter().map(|f| f.map(|p| p.0))
    }

    /// The unique identifiers of the attributes.
    pub fn attributes(&self) -> impl Iterator<Item = u32> {
        (0..self.0.num_attributes()).filter_map(|i| Some(self.0.try_attribute(i).ok()?.unique_id()))
    }

    /// The values of attribute `id` as floats, one after another for each point, and how many a point has; integers that are
    /// marked as normalised become 0..1 or −1..1.
    ///
    /// # Errors
    /// [`DracoError::Damaged`]: no such attribute, or a point without a value.
    pub fn floats(&self, id: u32) -> Result<(Vec<f32>, usize), DracoError> {
        let components = self.attribute(id)?.num_components().into();
        let bytes = self.values(id, Component::F32, components, false)?;
        Ok((bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect(), components))
    }

    fn attribute(&self, id: u32) -> Result<&PointAttribute, DracoError> {
        let found = self.0.attribute_by_unique_id(id);
        found.ok_or_else(|| DracoError::Damaged(format!("there is no attribute {id}")))
    }

    /// The values of attribute `id` for each point as bytes of `component`s.
    fn values(
        &self,
        id: u32,
        component: Component,
        components: usize,
        normalized: bool,
    ) -> Result<Vec<u8>, DracoError> {
        let a = self.attribute(id)?;
        let have = usize::from(a.num_components());
        if have != components {
            let what = format!("attribute {id} has {have} components, its accessor {components}");
            return Err(DracoError::Damaged(what));
        }
        let kind = a.data_type();
        let same = same_layout(kind, component);
        let Some(width) = width(kind) else {
            return Err(DracoError::Damaged(format!("attribute {id} has values of no usable type")));
        };
        let size = width * components;
        let stride = usize::try_from(a.byte_stride()).unwrap_or(0).max(size);
        let data = a.buffer().data();
        let scale = (a.normalized() || normalized) && component == Component::F32;
        let mut out =
            Vec::with_capacity(self.points().saturating_mul(components * component.size() as usize));
        for point in 0..self.points() as u32 {
            let index = a.mapped_index(PointIndex(point)).0 as usize;
            let value = index.checked_mul(stride).and_then(|at| data.get(at..at.checked_add(size)?));
            let value =
                value.ok_or_else(|| DracoError::Damaged(format!("a point without attribute {id}")))?;
            if same {
                out.extend_from_slice(value);
            } else {
                value.chunks_exact(width).for_each(|b| write(&mut out, component, read(kind, b, scale)));
            }
        }
        Ok(out)
    }
}

/// Bytes of a value.
fn width(kind: DataType) -> Option<usize> {
    Some(match kind {
        DataType::Int8 | DataType::Uint8 | DataType::Bool => 1,
        DataType::Int16 | DataType::Uint16 => 2,
        DataType::Int32 | DataType::Uint32 | DataType::Float32 => 4,
        DataType::Int64 | DataType::Uint64 | DataType::Float64 => 8,
        _ => return None,
    })
}

/// Whether the bytes can be taken over as they are.
fn same_layout(kind: DataType, component: Component) -> bool {
    matches!(
        (kind, component),
        (DataType::Int8, Component::I8)
            | (DataType::Uint8, Component::U8)
            | (DataType::Int16, Component::I16)
            | (DataType::Uint16, Component::U16)
            | (DataType::Uint32, Component::U32)
            | (DataType::Float32, Component::F32)
    )
}

/// A value of [`width`] bytes; `scale` makes integers 0..1 or −1..1.
fn read(kind: DataType, b: &[u8], scale: bool) -> f64 {
    let mut eight = [0; 8];
    eight[..b.len()].copy_from_slice(b);
    let bits = u64::from_le_bytes(eight);
    let unused = 64 - 8 * b.len() as u32;
    let signed = (bits << unused) as i64 >> unused;
    match kind {
        DataType::Float32 => f32::from_bits(bits as u32).into(),
        DataType::Float64 => f64::from_bits(bits),
        DataType::Int8 | DataType::Int16 | DataType::Int32 | DataType::Int64 => {
            let most = (i64::MAX >> unused) as f64;
            if scale { (signed as f64 / most).max(-1.0) } else { signed as f64 }
        }
        _ => {
            let most = (u64::MAX >> unused) as f64;
            if scale { bits as f64 / most } else { bits as f64 }
        }
    }
}

fn write(out: &mut Vec<u8>, component: Component, v: f64) {
    match component {
        Component::I8 => out.extend((v as i8).to_le_bytes()),
        Component::U8 => out.extend((v as u8).to_le_bytes()),
        Component::I16 => out.extend((v as i16).to_le_bytes()),
        Component::U16 => out.extend((v as u16).to_le_bytes()),
        Component::U32 => out.extend((v as u32).to_le_bytes()),
        Component::F32 => out.extend((v as f32).to_le_bytes()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_become_fractions_only_if_they_are_meant_as_such() {
        // glTF 2.0, section 3.11: signed c / 127 but no less than −1, unsigned c / 255.
        assert_eq!(read(DataType::Int8, &[127], true), 1.0);
        assert_eq!(read(DataType::Int8, &[0x80], true), -1.0);
        assert_eq!(read(DataType::Int8, &[0x80], false), -128.0);
        assert_eq!(read(DataType::Uint8, &[255], true), 1.0);
        assert_eq!(read(DataType::Uint8, &[51], true), 0.2);
        assert_eq!(read(DataType::Uint16, &[0xff, 0xff], true), 1.0);
        assert_eq!(read(DataType::Int16, &[0xfe, 0xff], false), -2.0);
        assert_eq!(read(DataType::Float32, &0.25f32.to_le_bytes(), true), 0.25);
        let mut out = Vec::new();
        write(&mut out, Component::F32, read(DataType::Uint16, &[0xff, 0x7f], false));
        assert_eq!(out, 32767.0f32.to_le_bytes());
    }
}
