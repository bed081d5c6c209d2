//! The models of a scene file, and where they stand.

use super::key::{Key, Kind, Value};
use glam::{Affine3A, Mat3A, Quat, Vec3};
use std::ops::Range;
use std::path::PathBuf;

/// A key, and what it does to a `T`.
pub(crate) struct Field<T> {
    pub key: Key,
    pub set: fn(&mut T, &Value),
}

/// Makes a [`Field`].
pub(crate) fn field<T>(name: &str, kind: Kind, about: &str, set: fn(&mut T, &Value)) -> Field<T> {
    Field { key: Key::new(name, kind, about), set }
}

impl<T> Field<T> {
    /// With a default, as TOML.
    pub fn or(mut self, default: &str) -> Self {
        self.key.default = Some(default.into());
        self
    }
}

/// A model that a scene file places.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// The file; empty for a built-in model.
    pub file: PathBuf,
    /// Name of a built-in model, if it is one.
    pub builtin: Option<String>,
    /// For people; empty for the file's name.
    pub name: String,
    /// Metres.
    pub translation: Vec3,
    /// Turn.
    pub rotation: Quat,
    /// Along the model's axes.
    pub scale: Vec3,
    /// In place of the three above.
    pub matrix: Option<Affine3A>,
    /// One of its sets of materials.
    pub variant: Option<String>,
    /// Seconds into its animation.
    pub at: Option<f32>,
    /// Which of its animations.
    pub animation: crate::AnimationChoice,
    /// Where the scene file names it.
    pub(crate) span: Range<usize>,
}

impl Placed {
    /// A model that stands where it was made.
    pub(crate) fn new(span: Range<usize>) -> Self {
        Self {
            file: PathBuf::new(),
            builtin: None,
            name: String::new(),
            translation: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            scale: Vec3::ONE,
            matrix: None,
            variant: None,
            at: None,
            animation: crate::AnimationChoice::First,
            span,
        }
    }

    /// Model space to world space.
    pub fn transform(&self) -> Affine3A {
        self.matrix.unwrap_or_else(|| {
            Affine3A::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
        })
    }

    /// Its name for people.
    pub fn label(&self) -> String {
        match (&self.name[..], &self.builtin) {
            ("", Some(builtin)) => builtin.clone(),
            ("", None) => self.file.display().to_string(),
            (name, _) => name.to_owned(),
        }
    }
}

/// What a `[[model]]` may say, beside `override`.
pub(crate) fn keys(builtins: &[&str]) -> Vec<Field<Placed>> {
    let field = field::<Placed>;
    vec![
        field("file", Kind::Path, "The model: .glb, .gltf, .obj, .ply or .stl", |m, v| {
            if let Value::Path(p) = v {
                m.file.clone_from(p);
            }
        }),
        field("builtin", Kind::choice(builtins), "A model that is part of the program, instead of a file", |m, v| {
            m.builtin = Some(v.text().into());
        }),
        field("name", Kind::Text, "A name for messages", |m, v| m.name = v.text().into()),
        field("translation", Kind::Vector, "Where its origin stands, metres", |m, v| {
            m.translation = v.numbers().into();
        })
        .or("[0, 0, 0]"),
        field(
            "rotation",
            Kind::Numbers(vec![3, 4]),
            "Degrees about the world's x, then y, then z axis, counter-clockwise seen from its tip; or four numbers, a quaternion x, y, z, w as in glTF",
            |m, v| m.rotation = rotation(v),
        )
        .or("[0, 0, 0]"),
        field("scale", Kind::Numbers(vec![1, 3]), "How many times as large, in all directions or along x, y and z", |m, v| {
            m.scale = match v {
                Value::Numbers(n) if n.len() == 1 => Vec3::splat(v.numbers::<1>()[0]),
                v => v.numbers().into(),
            };
        })
        .or("1"),
        field(
            "matrix",
            Kind::Numbers(vec![16]),
            "In place of translation, rotation and scale: a 4 × 4 matrix, column after column as in glTF",
            |m, v| m.matrix = Some(matrix(v)),
        ),
        field("variant", Kind::Text, "One of its sets of materials, by name", |m, v| {
            m.variant = Some(v.text().into());
        }),
        field("at", Kind::ANY, "Evaluate its animation at this time instead of at rest, seconds", |m, v| m.at = Some(v.f32())),
        field("animation", Kind::Name, "Which of its animations, by name or number", |m, v| {
            m.animation = match v {
                Value::Integer(n) => crate::AnimationChoice::Index(u32::try_from(*n).unwrap_or(u32::MAX)),
                v => crate::AnimationChoice::Name(v.text().into()),
            };
        })
        .or("0"),
    ]
}

fn rotation(v: &Value) -> Quat {
    match v {
        Value::Numbers(n) if n.len() == 4 => {
            let q = Quat::from_array(v.numbers());
            if q.length_squared() > 0.0 && q.length_squared().is_finite() {
                q.normalize()
            } else {
                Quat::IDENTITY
            }
        }
        v => {
            // Whole turns taken away first, while the digits are there: sines are only good near the origin.
            let [x, y, z] = [0, 1, 2].map(|i| match v {
                Value::Numbers(n) => n.get(i).map_or(0.0, |d| (d % 360.0).to_radians() as f32),
                _ => 0.0,
            });
            Quat::from_rotation_z(z) * Quat::from_rotation_y(y) * Quat::from_rotation_x(x)
        }
    }
}

/// The last row of an affine matrix is 0, 0, 0, 1 whatever stands there.
fn matrix(v: &Value) -> Affine3A {
    let m = v.numbers::<16>();
    let column = |i: usize| Vec3::new(m[i], m[i + 1], m[i + 2]);
    Affine3A {
        matrix3: Mat3A::from_cols(column(0).into(), column(4).into(), column(8).into()),
        translation: column(12).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_go_about_x_then_y_then_z() {
        let turn = |v: &[f64]| rotation(&Value::Numbers(v.to_vec()));
        let near = |a: Vec3, b: Vec3| assert!((a - b).length() < 1e-5, "{a} {b}");
        near(turn(&[0.0, 90.0, 0.0]) * Vec3::Z, Vec3::X);
        // y to z by x, z to x by y, x to y by z.
        near(turn(&[90.0, 90.0, 90.0]) * Vec3::Y, Vec3::Y);
        near(turn(&[90.0, 90.0, 0.0]) * Vec3::Y, Vec3::X);
        near(turn(&[0.0, 36_000_090.0, 0.0]) * Vec3::Z, Vec3::X);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        near(turn(&[0.0, half, 0.0, half]) * Vec3::Z, Vec3::X);
        assert_eq!(turn(&[0.0; 4]), Quat::IDENTITY);
    }

    #[test]
    fn a_matrix_is_written_column_after_column() {
        let m = [2.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 5.0, 6.0, 7.0, 1.0];
        let m = matrix(&Value::Numbers(m.to_vec()));
        assert_eq!(m.transform_point3(Vec3::ONE), Vec3::new(7.0, 9.0, 11.0));
    }
}
