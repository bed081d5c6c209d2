//! Where each metal's spectrum is, and those that are short enough to stand here: rows of wavelength in micrometres, n and
//! k, the visible part of tables in the public-domain (CC0) database refractiveindex.info.

/// A spectrum of complex indices.
pub enum Rows {
    /// A file of the database.
    File(&'static str),
    /// The rows themselves.
    Here(&'static [[f64; 3]]),
}

/// A metal.
pub struct Source {
    pub name: &'static str,
    pub symbol: &'static str,
    pub citation: &'static str,
    pub rows: Rows,
}

const JOHNSON_1972: &str = "Johnson, Christy 1972, Optical constants of the noble metals";
const JOHNSON_1974: &str = "Johnson, Christy 1974, Optical constants of transition metals";

/// The metals of the table.
pub const SPECTRA: &[Source] = &[
    Source {
        name: "aluminium",
        symbol: "Al",
        citation: "Rakić 1995, Algorithm for the determination of intrinsic optical constants of metal films",
        rows: Rows::File("Al/nk/Rakic.yml"),
    },
    Source { name: "chromium", symbol: "Cr", citation: JOHNSON_1974, rows: Rows::Here(CHROMIUM) },
    Source { name: "copper", symbol: "Cu", citation: JOHNSON_1972, rows: Rows::File("Cu/nk/Johnson.yml") },
    Source { name: "gold", symbol: "Au", citation: JOHNSON_1972, rows: Rows::File("Au/nk/Johnson.yml") },
    Source { name: "iron", symbol: "Fe", citation: JOHNSON_1974, rows: Rows::File("Fe/nk/Johnson.yml") },
    Source { name: "nickel", symbol: "Ni", citation: JOHNSON_1974, rows: Rows::Here(NICKEL) },
    Source {
        name: "platinum",
        symbol: "Pt",
        citation: "Rakić, Djurišić, Elazar, Majewski 1998, Optical properties of metallic films (Lorentz-Drude fit)",
        rows: Rows::Here(PLATINUM),
    },
    Source { name: "silver", symbol: "Ag", citation: JOHNSON_1972, rows: Rows::File("Ag/nk/Johnson.yml") },
    Source { name: "titanium", symbol: "Ti", citation: JOHNSON_1974, rows: Rows::File("Ti/nk/Johnson.yml") },
    Source {
        name: "tungsten",
        symbol: "W",
        citation: "Weaver, Olson, Lynch 1975, Optical properties of crystalline tungsten",
        rows: Rows::Here(TUNGSTEN),
    },
];

/// Sellmeier's formula n² = 1 + c + Σ B λ² / (λ² − C), λ in micrometres: name, c, and pairs B, C.
pub const SELLMEIER: &[(&str, f64, &[[f64; 2]])] = &[
    // Malitson 1965; the second numbers are resonances in micrometres, squared here.
    (
        "fused-silica",
        0.0,
        &[
            [0.6961663, 0.0684043 * 0.0684043],
            [0.4079426, 0.1162414 * 0.1162414],
            [0.8974794, 9.896161 * 9.896161],
        ],
    ),
    // Schott's data sheet of N-BK7.
    ("glass", 0.0, &[[1.03961212, 0.00600069867], [0.231792344, 0.0200179144], [1.01046945, 103.560653]]),
    // Peter 1923.
    ("diamond", 0.0, &[[0.3306, 0.1750 * 0.1750], [4.3356, 0.1060 * 0.1060]]),
    // Malitson, Dodge 1972, ordinary ray.
    (
        "sapphire",
        0.0,
        &[
            [1.4313493, 0.0726631 * 0.0726631],
            [0.65054713, 0.1193242 * 0.1193242],
            [5.3414021, 18.028251 * 18.028251],
        ],
    ),
    // Ghosh 1999, ordinary ray.
    ("quartz", 0.28604141, &[[1.07044083, 1.00585997e-2], [1.10202242, 100.0]]),
];

/// The index at a wavelength in micrometres.
pub fn sellmeier(constant: f64, terms: &[[f64; 2]], um: f64) -> f64 {
    let l2 = um * um;
    (1.0 + constant + terms.iter().map(|[b, c]| b * l2 / (l2 - c)).sum::<f64>()).sqrt()
}

// A measured k of 3.14 is not π.
#[allow(clippy::approx_constant)]
const CHROMIUM: &[[f64; 3]] = &[
    [0.381, 1.92, 2.74],
    [0.397, 2.00, 2.83],
    [0.413, 2.08, 2.93],
    [0.431, 2.19, 3.04],
    [0.451, 2.33, 3.14],
    [0.471, 2.51, 3.24],
    [0.496, 2.75, 3.30],
    [0.521, 2.94, 3.33],
    [0.549, 3.18, 3.33],
    [0.582, 3.22, 3.30],
    [0.617, 3.17, 3.30],
    [0.659, 3.09, 3.34],
    [0.704, 3.05, 3.39],
    [0.756, 3.08, 3.42],
    [0.821, 3.20, 3.48],
];

const NICKEL: &[[f64; 3]] = &[
    [0.368, 1.70, 2.40],
    [0.381, 1.72, 2.48],
    [0.397, 1.72, 2.57],
    [0.413, 1.70, 2.69],
    [0.431, 1.71, 2.82],
    [0.451, 1.73, 2.95],
    [0.471, 1.78, 3.09],
    [0.496, 1.82, 3.25],
    [0.521, 1.85, 3.42],
    [0.549, 1.92, 3.61],
    [0.582, 1.96, 3.80],
    [0.617, 1.99, 4.02],
    [0.659, 1.99, 4.26],
    [0.704, 2.06, 4.50],
    [0.756, 2.13, 4.73],
    [0.821, 2.26, 4.97],
];

const PLATINUM: &[[f64; 3]] = &[
    [0.37999, 1.6698, 2.7309],
    [0.39983, 1.7237, 2.8515],
    [0.41907, 1.7741, 2.9639],
    [0.43923, 1.8249, 3.0790],
    [0.46036, 1.8760, 3.1981],
    [0.48063, 1.9238, 3.3120],
    [0.49982, 1.9690, 3.4201],
    [0.51978, 2.0164, 3.5328],
    [0.54054, 2.0671, 3.6502],
    [0.55993, 2.1161, 3.7597],
    [0.58002, 2.1690, 3.8725],
    [0.60082, 2.2261, 3.9881],
    [0.61995, 2.2806, 4.0928],
    [0.63967, 2.3388, 4.1989],
    [0.66003, 2.4007, 4.3061],
    [0.68103, 2.4661, 4.4139],
    [0.69996, 2.5263, 4.5083],
    [0.71941, 2.5889, 4.6028],
    [0.73941, 2.6538, 4.6970],
    [0.75996, 2.7207, 4.7909],
    [0.78108, 2.7893, 4.8844],
];

const TUNGSTEN: &[[f64; 3]] = &[
    [0.3790, 3.459, 2.556],
    [0.3866, 3.458, 2.490],
    [0.3912, 3.445, 2.460],
    [0.3930, 3.438, 2.449],
    [0.4002, 3.406, 2.415],
    [0.4115, 3.379, 2.416],
    [0.4253, 3.346, 2.439],
    [0.4298, 3.336, 2.450],
    [0.4426, 3.317, 2.489],
    [0.4487, 3.314, 2.511],
    [0.4650, 3.325, 2.574],
    [0.4694, 3.332, 2.591],
    [0.4921, 3.380, 2.664],
    [0.5111, 3.433, 2.700],
    [0.5298, 3.490, 2.716],
    [0.5489, 3.522, 2.739],
    [0.5705, 3.524, 2.787],
    [0.5997, 3.557, 2.860],
    [0.6260, 3.607, 2.906],
    [0.6460, 3.657, 2.925],
    [0.6572, 3.697, 2.943],
    [0.6712, 3.746, 2.937],
    [0.6849, 3.818, 2.904],
    [0.7008, 3.871, 2.879],
    [0.7173, 3.896, 2.850],
    [0.7314, 3.891, 2.828],
    [0.7528, 3.862, 2.788],
    [0.7778, 3.789, 2.737],
    [0.7938, 3.705, 2.733],
];
