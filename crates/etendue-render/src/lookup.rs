//! Textures at one point of a surface.

use crate::mesh_data::MeshData;
use crate::texels::Texels;
use crate::world::World;
use etendue_scene::{Footprint, Sampler, TextureRef};
use glam::{Affine2, Vec4};

/// Looks textures up at one point. Most materials' textures have one size and are looked up alike: then wrapping and
/// filtering are worked out once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lookup {
    corners: [u32; 3],
    weights: [f32; 3],
    last: Option<(Key, Footprint)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    uv_set: u32,
    transform: Affine2,
    sampler: Sampler,
    size: [u32; 2],
}

impl Lookup {
    /// At barycentric `weights` between the vertices `corners`.
    #[inline(always)]
    pub fn new(corners: [u32; 3], weights: [f32; 3]) -> Self {
        Self { corners, weights, last: None }
    }

    /// RGBA with colour decoded from sRGB.
    #[inline(always)]
    pub fn srgb(&mut self, world: &World, mesh: &MeshData, t: &TextureRef) -> Vec4 {
        let (image, footprint) = self.find(world, mesh, t);
        image.srgb(&footprint)
    }

    /// RGBA as stored.
    #[inline(always)]
    pub fn linear(&mut self, world: &World, mesh: &MeshData, t: &TextureRef) -> Vec4 {
        let (image, footprint) = self.find(world, mesh, t);
        image.linear(&footprint)
    }

    /// Vertex colour, or white.
    #[inline(always)]
    pub fn vertex_color(&self, mesh: &MeshData) -> Vec4 {
        if mesh.colors.is_empty() {
            return Vec4::ONE;
        }
        let [a, b, c] = self.corners.map(|k| mesh.colors[k as usize]);
        a * self.weights[0] + b * self.weights[1] + c * self.weights[2]
    }

    #[inline(always)]
    fn find<'a>(&mut self, world: &'a World, mesh: &MeshData, t: &TextureRef) -> (&'a Texels, Footprint) {
        let texture = &world.scene.textures[t.texture as usize];
        let image = &world.images[texture.image as usize];
        let key =
            Key { uv_set: t.uv_set, transform: t.transform, sampler: texture.sampler, size: image.size() };
        if let Some((last, footprint)) = self.last
            && last == key
        {
            return (image, footprint);
        }
        let uv = t.transform.transform_point2(mesh.uv(t.uv_set, self.corners, self.weights));
        let footprint = Footprint::new(&texture.sampler, key.size[0], key.size[1], uv);
        self.last = Some((key, footprint));
        (image, footprint)
    }
}
