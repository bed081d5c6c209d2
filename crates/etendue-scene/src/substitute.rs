//! Surfaces that are not described by glTF's factors.

use etendue_bxdf::measured::{Measured, MeasuredError};
use etendue_bxdf::model::Model;
use std::fmt;
use std::sync::Arc;

/// What scatters in place of a material's own factors. Normal map, alpha and emission stay the material's.
#[derive(Clone, Debug, PartialEq)]
pub enum Substitute {
    /// A model with constant parameters.
    Model(Box<Model>),
    /// A table from a measurement.
    Measured(MeasuredMaterial),
}

/// A measured material, shared by the surfaces that have it.
#[derive(Clone)]
pub struct MeasuredMaterial {
    table: Arc<Measured>,
    checksum: u64,
}

impl MeasuredMaterial {
    /// Reads the bytes of a tensor file (`.bsdf`, `.pbsdf`); see [`Measured::from_bytes`].
    ///
    /// # Errors
    /// As there.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, MeasuredError> {
        // FNV-1a (Fowler, Noll, Vo 1991): names the content in a film's fingerprint.
        let mix = |h: u64, b: &u8| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3);
        let checksum = bytes.iter().fold(0xcbf2_9ce4_8422_2325, mix);
        Ok(Self { table: Arc::new(Measured::from_bytes(bytes)?), checksum })
    }

    /// The table.
    pub fn table(&self) -> &Measured {
        &self.table
    }
}

/// By its content's checksum.
impl fmt::Debug for MeasuredMaterial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MeasuredMaterial({:016x})", self.checksum)
    }
}

/// By its content's checksum.
impl PartialEq for MeasuredMaterial {
    fn eq(&self, other: &Self) -> bool {
        self.checksum == other.checksum
    }
}
