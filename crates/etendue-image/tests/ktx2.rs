//! KTX2: Basis Universal's codes against the reference transcoder, plain formats against a list of them, cut and bent files.
//!
//! `data/*.ktx2` were written by the reference encoder (basis_universal 2.1) from `data/source.png`, except that the blocks of
//! `uastc_modes.ktx2` are random ones of every mode; `data/NAME.MIP.png` is what the reference transcoder makes of each.
use etendue_image::{DecodeLimits, Image, ImageError, Ktx2, Pixels, decode};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

fn data(name: &str) -> Vec<u8> {
    let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data")).join(name);
    std::fs::read(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()))
}

const BASIS: [(&str, &str, bool, u32); 5] = [
    ("etc1s_rgba", "ETC1S", true, 1),
    ("etc1s_rgb_mips", "ETC1S", true, 6),
    ("uastc_rgba", "UASTC", true, 1),
    ("uastc_rgb_zstd_mips", "UASTC", false, 6),
    ("uastc_modes", "UASTC", true, 1),
];

/// Red, green, blue and alpha of every pixel.
fn rgba(i: &Image) -> Vec<[u8; 4]> {
    let Pixels::U8(p) = &i.pixels else { panic!("not bytes") };
    let n = usize::from(i.channels);
    p.chunks_exact(n)
        .map(|t| match n {
            1 => [t[0], t[0], t[0], 255],
            2 => [t[0], t[0], t[0], t[1]],
            3 => [t[0], t[1], t[2], 255],
            _ => [t[0], t[1], t[2], t[3]],
        })
        .collect()
}

fn psnr(a: &[[u8; 4]], b: &[[u8; 4]], channels: usize) -> f64 {
    let pairs = a.iter().zip(b).flat_map(|(a, b)| a[..channels].iter().zip(&b[..channels]));
    let (sum, n) =
        pairs.fold((0.0, 0.0), |(s, n), (&a, &b)| (s + (f64::from(a) - f64::from(b)).powi(2), n + 1.0));
    10.0 * (255.0f64.powi(2) * n / sum).log10()
}

#[test]
fn basis_universal_decodes_as_the_reference_does() {
    for (name, coding, srgb, mips) in BASIS {
        let bytes = data(&format!("{name}.ktx2"));
        let k = Ktx2::new(&bytes, &DecodeLimits::default()).unwrap();
        assert_eq!((k.coding(), k.is_srgb(), k.mips(), k.faces(), k.layers()), (coding, srgb, mips, 1, 1));
        for mip in 0..mips {
            let i = k.mip(mip).unwrap().pop().unwrap();
            assert_eq!((i.width, i.height), ((k.size().0 >> mip).max(1), (k.size().1 >> mip).max(1)));
            let file = format!("{name}.{mip}.png");
            if mip < 3 {
                let want = decode(&data(&file), &DecodeLimits::default()).unwrap();
                assert_eq!((want.width, want.height), (i.width, i.height));
                for (n, (a, b)) in rgba(&i).iter().zip(rgba(&want)).enumerate() {
                    let (x, y) = (n as u32 % i.width, n as u32 / i.width);
                    assert_eq!(*a, b, "{name} mip {mip} at {x}, {y}");
                }
            }
        }
        let Ok(first) = decode(&bytes, &DecodeLimits::default()) else { panic!("{name}") };
        assert_eq!(first, k.first().unwrap());
    }
}

/// What the compression loses of the picture that it was made from.
#[test]
fn compressed_textures_are_near_their_source() {
    let source = rgba(&decode(&data("source.png"), &DecodeLimits::default()).unwrap());
    for (name, channels, least) in [
        ("etc1s_rgba", 4, 24.0),
        ("etc1s_rgb_mips", 3, 24.0),
        ("uastc_rgba", 4, 36.0),
        ("uastc_rgb_zstd_mips", 3, 36.0),
    ] {
        let i = decode(&data(&format!("{name}.ktx2")), &DecodeLimits::default()).unwrap();
        assert_eq!(usize::from(i.channels), channels);
        let p = psnr(&rgba(&i), &source, channels);
        println!("{name}: {p:.1} dB");
        assert!(p > least, "{name}: {p}");
    }
}

/// A file of one level with the given samples: bit, bits, channel with its flags, lower, upper.
fn plain(
    width: u32,
    height: u32,
    size: u8,
    srgb: bool,
    samples: &[(u16, u8, u8, u32, u32)],
    texels: &[u8],
) -> Vec<u8> {
    let mut dfd = Vec::new();
    let block = 24 + 16 * samples.len() as u32;
    for w in [block + 4, 0, 2 | block << 16, if srgb { 0x0002_0101 } else { 0x0001_0101 }, 0, size.into(), 0]
    {
        dfd.extend(w.to_le_bytes());
    }
    for &(bit, bits, kind, lower, upper) in samples {
        dfd.extend(bit.to_le_bytes());
        dfd.extend([bits - 1, kind, 0, 0, 0, 0]);
        dfd.extend(lower.to_le_bytes());
        dfd.extend(upper.to_le_bytes());
    }
    let mut out = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    for w in [0, 1, width, height, 0, 0, 1, 1, 0, 104, dfd.len() as u32, 0, 0, 0, 0, 0, 0] {
        out.extend(w.to_le_bytes());
    }
    // A multiple of every size of a texel.
    let start = (104 + dfd.len()).next_multiple_of(48);
    for n in [start, texels.len(), texels.len()] {
        out.extend((n as u64).to_le_bytes());
    }
    out.extend(dfd);
    out.resize(start, 0);
    out.extend(texels);
    out
}

fn pixels(file: &[u8]) -> (u8, Pixels) {
    let i = Ktx2::new(file, &DecodeLimits::default()).unwrap().first().unwrap();
    (i.channels, i.pixels)
}

const HALF: u32 = 0xbf80_0000;
const ONE: u32 = 0x3f80_0000;

#[test]
fn plain_formats() {
    // R5G6B5: red in the highest bits.
    let r5g6b5 = [(0, 5, 2, 0, 31), (5, 6, 1, 0, 63), (11, 5, 0, 0, 31)];
    let file = plain(2, 1, 2, true, &r5g6b5, &[0b0010_0001, 0b1000_0100, 0xff, 0xff]);
    assert_eq!(pixels(&file), (3, Pixels::U8(vec![132, 134, 8, 255, 255, 255])));
    // B8G8R8A8.
    let bgra = [(0, 8, 2, 0, 255), (8, 8, 1, 0, 255), (16, 8, 0, 0, 255), (24, 8, 15, 0, 255)];
    assert_eq!(pixels(&plain(1, 1, 4, true, &bgra, &[1, 2, 3, 4])), (4, Pixels::U8(vec![3, 2, 1, 4])));
    // R8: only red. R8G8: no blue.
    assert_eq!(pixels(&plain(1, 1, 1, false, &[(0, 8, 0, 0, 255)], &[7])), (3, Pixels::U8(vec![7, 0, 0])));
    let rg = [(0, 8, 0, 0, 255), (8, 8, 1, 0, 255)];
    assert_eq!(pixels(&plain(1, 1, 2, false, &rg, &[7, 9])), (3, Pixels::U8(vec![7, 9, 0])));
    // A2R10G10B10: 16 bits hold them.
    let a2 = [(0, 10, 2, 0, 1023), (10, 10, 1, 0, 1023), (20, 10, 0, 0, 1023), (30, 2, 15, 0, 3)];
    let texel = (2u32 << 30 | 1023 << 20 | 512 << 10).to_le_bytes();
    assert_eq!(pixels(&plain(1, 1, 4, false, &a2, &texel)), (4, Pixels::U16(vec![65535, 32800, 0, 43690])));
    // R16 half: floats, one of them not a number: as they stand.
    let half = [(0, 16, 0xc0, HALF, ONE), (16, 16, 0xc1, HALF, ONE), (32, 16, 0xc2, HALF, ONE)];
    let texel = [0x3c00u16, 0xc000, 0x7bff].map(u16::to_le_bytes).concat();
    let file = plain(1, 1, 6, false, &half, &texel);
    assert_eq!(pixels(&file), (3, Pixels::F32(vec![1.0, -2.0, 65504.0])));
    assert!(decode(&file, &DecodeLimits::default()).unwrap_err().to_string().contains("floats as a texture"));
    // B10G11R11: floats without signs.
    let b10 = [(0, 11, 0x80, 0, ONE), (11, 11, 0x81, 0, ONE), (22, 10, 0x82, 0, ONE)];
    let texel = (0x3c0u32 | 0x3e0 << 11 | 0x1c0 << 22).to_le_bytes();
    assert_eq!(pixels(&plain(1, 1, 4, false, &b10, &texel)), (3, Pixels::F32(vec![1.0, 1.5, 0.5])));
    // Signed bytes and single floats.
    let signed = [(0, 8, 0x40, -127i32 as u32, 127)];
    assert_eq!(
        pixels(&plain(2, 1, 1, false, &signed, &[127, 0x80])),
        (3, Pixels::F32(vec![1., 0., 0., -1., 0., 0.]))
    );
    let float = [(0, 32, 0xc0, HALF, ONE)];
    assert_eq!(
        pixels(&plain(1, 1, 4, false, &float, &0.3f32.to_le_bytes())),
        (3, Pixels::F32(vec![0.3, 0., 0.]))
    );
    let double = [(0, 64, 0xc0, HALF, ONE)];
    assert_eq!(
        pixels(&plain(1, 1, 8, false, &double, &0.3f64.to_le_bytes())),
        (3, Pixels::F32(vec![0.3, 0., 0.]))
    );
}

#[test]
fn what_is_no_picture_is_named() {
    let message = |samples: &[(u16, u8, u8, u32, u32)], size: u8| {
        let file = plain(1, 1, size, false, samples, &vec![0; size.into()]);
        Ktx2::new(&file, &DecodeLimits::default()).err().unwrap().to_string()
    };
    assert!(message(&[(0, 8, 0, 0, 1)], 1).contains("integers"));
    assert!(message(&[(0, 32, 14, 0, u32::MAX)], 4).contains("depth or stencil"));
    assert!(message(&[(0, 9, 0, 0, 511), (27, 5, 0x20, 15, 31)], 4).contains("exponents"));
    assert!(message(&[(0, 8, 0, 0, 255), (8, 8, 0, 0, 255)], 2).contains("several samples"));
    assert!(message(&[(0, 16, 0, 0, 65535)], 1).contains("outside of the texel"));
    let mut bc7 = plain(1, 1, 1, false, &[(0, 8, 0, 0, 255)], &[0]);
    bc7[104 + 12] = 134;
    let e = decode(&bc7, &DecodeLimits::default()).unwrap_err().to_string();
    assert!(e.contains("BC7 (compressed for graphics hardware)"), "{e}");
}

/// The file with key-value data.
fn with_value(mut file: Vec<u8>, key: &str, value: &str) -> Vec<u8> {
    let word = |f: &[u8], at: usize| u32::from_le_bytes(f[at..at + 4].try_into().unwrap());
    let texels = file.split_off(word(&file, 80) as usize);
    file.truncate((word(&file, 48) + word(&file, 52)) as usize);
    let entry = format!("{key}\0{value}\0");
    let at = file.len() as u32;
    file.extend((entry.len() as u32).to_le_bytes());
    file.extend(entry.as_bytes());
    file.resize(file.len().next_multiple_of(4), 0);
    let length = file.len() as u32 - at;
    file[56..60].copy_from_slice(&at.to_le_bytes());
    file[60..64].copy_from_slice(&length.to_le_bytes());
    file.resize(file.len().next_multiple_of(48), 0);
    let start = file.len() as u32;
    file[80..84].copy_from_slice(&start.to_le_bytes());
    file.extend(texels);
    file
}

/// Khronos' conformance suite of its validator: what it calls an error is refused or remarked upon, for glTF's rules by the
/// remarks for glTF; what is valid is read without a remark, or named as unsupported.
#[test]
fn what_the_validator_calls_an_error_is_refused_or_remarked_upon() {
    let root =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets/malformed/ktx2-khronos-cts-validate");
    let Ok(folders) = std::fs::read_dir(root) else {
        println!("skipped: {root} is not there");
        return;
    };
    let (mut refused, mut remarked, mut wrong) = (0, 0, Vec::new());
    for folder in folders {
        let folder = folder.unwrap();
        for file in std::fs::read_dir(folder.path()).unwrap() {
            let path = file.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let Some((verdict, _)) = name.split_once('_') else { continue };
            let bytes = std::fs::read(&path).unwrap();
            let read = Ktx2::new(&bytes, &DecodeLimits::default()).and_then(|k| {
                (0..k.mips()).try_for_each(|mip| k.mip(mip).map(|_| ()))?;
                let for_gltf = if name.contains("GLTFBU") { k.remarks_for_gltf() } else { Vec::new() };
                Ok(k.remarks().into_iter().chain(for_gltf).collect::<Vec<_>>())
            });
            match (read, verdict) {
                (Err(_), "error" | "fatal") => refused += 1,
                (Ok(r), "error" | "fatal") if !r.is_empty() => remarked += 1,
                (Ok(_), "error" | "fatal") => wrong.push(format!("{name}: nothing is said")),
                (Ok(r), "valid") if !r.is_empty() => wrong.push(format!("{name}: {r:?}")),
                (Err(ImageError::Damaged { cause, .. }), "valid" | "warning") => {
                    wrong.push(format!("{name}: {cause}"));
                }
                _ => {}
            }
        }
    }
    println!("{refused} errors refused, {remarked} remarked upon");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn remarks_are_about_what_does_not_touch_the_picture() {
    let rgba = [(0, 8, 0, 0, 255), (8, 8, 1, 0, 255), (16, 8, 2, 0, 255), (24, 8, 15, 0, 255)];
    let file = || plain(4, 4, 4, false, &rgba, &[7; 64]);
    let remarks = |f: &[u8]| Ktx2::new(f, &DecodeLimits::default()).unwrap().remarks();
    assert_eq!(remarks(&file()), [] as [&str; 0]);
    assert_eq!(remarks(&with_value(file(), "KTXwriter", "somebody")), [] as [&str; 0]);
    assert_eq!(
        remarks(&with_value(file(), "KTXcubemapIncomplete", "\u{1}")),
        ["KTXcubemapIncomplete has not one byte"]
    );
    assert_eq!(remarks(&with_value(file(), "KTXnew", "x")), ["the key KTXnew is reserved and not known"]);
    assert_eq!(
        remarks(&with_value(file(), "KTXwriterScParams", "x")),
        ["KTXwriterScParams without KTXwriter"]
    );
    let mut unsized_texels = file();
    unsized_texels[104 + 20] = 0;
    assert_eq!(remarks(&unsized_texels), ["the descriptor does not give the bytes of a texel's block"]);
    let k = file();
    let of_gltf = Ktx2::new(&k, &DecodeLimits::default()).unwrap().remarks_for_gltf();
    assert!(of_gltf.iter().any(|r| r.contains("neither ETC1S nor UASTC")), "{of_gltf:?}");
}

#[test]
fn swizzles_and_orientations() {
    let rg = [(0, 8, 0, 0, 255), (8, 8, 1, 0, 255)];
    let file = || plain(2, 2, 2, false, &rg, &[1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(
        pixels(&with_value(file(), "KTXswizzle", "rrrg")),
        (2, Pixels::U8(vec![1, 2, 3, 4, 5, 6, 7, 8]))
    );
    assert_eq!(pixels(&with_value(file(), "KTXswizzle", "rrr1")), (1, Pixels::U8(vec![1, 3, 5, 7])));
    assert_eq!(
        pixels(&with_value(file(), "KTXswizzle", "g1r0")),
        (4, Pixels::U8(vec![2, 255, 1, 0, 4, 255, 3, 0, 6, 255, 5, 0, 8, 255, 7, 0]))
    );
    let turned = with_value(with_value(file(), "x", "y"), "KTXorientation", "ru");
    assert_eq!(pixels(&turned).1, Pixels::U8(vec![5, 6, 0, 7, 8, 0, 1, 2, 0, 3, 4, 0]));
    let e = Ktx2::new(&with_value(file(), "KTXswizzle", "rg"), &DecodeLimits::default()).err().unwrap();
    assert!(e.to_string().contains("four letters"), "{e}");
}

/// Every file cut anywhere and with bits turned over: a picture of the right size, or an error, soon.
#[test]
fn cut_and_bent_files() {
    let limits = DecodeLimits { max_pixels: 1 << 16, max_bytes: 1 << 20 };
    let read = |bytes: &[u8]| -> Result<usize, ImageError> {
        let k = Ktx2::new(bytes, &limits)?;
        let mut n = 0;
        for mip in 0..k.mips() {
            for i in k.mip(mip)? {
                let have = match &i.pixels {
                    Pixels::U8(p) => p.len(),
                    Pixels::U16(p) => p.len(),
                    Pixels::F32(p) => p.len(),
                };
                assert_eq!(have, i.len());
                n += 1;
            }
        }
        Ok(n)
    };
    let start = Instant::now();
    let (mut good, mut bad, mut slowest) = (0, 0, Duration::ZERO);
    let half = [(0, 16, 0xc0, HALF, ONE), (16, 16, 0xc1, HALF, ONE)];
    let mut files: Vec<Vec<u8>> = BASIS.iter().map(|b| data(&format!("{}.ktx2", b.0))).collect();
    files.push(with_value(plain(3, 2, 4, false, &half, &[7; 24]), "KTXorientation", "lu"));
    let mut seed = 1u64;
    for file in files {
        assert!(read(&file).is_ok());
        let mut one = |bytes: &[u8]| {
            let start = Instant::now();
            if read(bytes).is_ok() {
                good += 1
            } else {
                bad += 1
            }
            slowest = slowest.max(start.elapsed());
        };
        for n in (0..file.len()).step_by(1 + file.len() / 500) {
            one(&file[..n]);
        }
        for bit in (0..8 * file.len()).step_by(1 + file.len() / 400) {
            let mut bent = file.clone();
            bent[bit / 8] ^= 1 << (bit % 8);
            // Often a second one.
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            bent[(seed >> 33) as usize % file.len()] ^= (seed >> 60) as u8;
            one(&bent);
        }
    }
    println!("{good} pictures, {bad} errors, slowest {slowest:?}");
    assert!(bad > 1000 && start.elapsed() < Duration::from_secs(20));
}

fn suite(sub: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets").join(sub);
    let mut out = Vec::new();
    let mut stack = vec![root];
    while let Some(folder) = stack.pop() {
        for e in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let p = e.path();
            if p.is_dir() { stack.push(p) } else { out.push(p) }
        }
    }
    out.retain(|p| p.extension().is_some_and(|e| e == "ktx2"));
    out.sort();
    if out.is_empty() {
        println!("skipped: no files in {sub}");
    }
    out
}

/// Khronos' suite of valid files: a picture, or a format that is named as not read. Nothing in it is damaged.
#[test]
fn the_conformance_suite_is_read() {
    let (mut read, mut named, mut damaged) =
        (0, std::collections::BTreeMap::<String, u32>::new(), Vec::new());
    for file in suite("images-valid/ktx2-cts") {
        let bytes = std::fs::read(&file).unwrap();
        let result = Ktx2::new(&bytes, &DecodeLimits::default())
            .and_then(|k| (0..k.mips()).map(|m| k.mip(m)).collect::<Result<Vec<_>, _>>());
        match result {
            Ok(mips) => {
                assert!(mips.iter().all(|m| !m.is_empty()));
                read += 1;
            }
            Err(ImageError::Unsupported { feature, .. }) => *named.entry(feature).or_default() += 1,
            Err(e) => damaged.push(format!("{}: {e}", file.file_name().unwrap().to_string_lossy())),
        }
    }
    println!("{read} read, not read: {named:?}");
    assert!(damaged.is_empty(), "{}", damaged.join("\n"));
}

/// The suite's invalid files, and another project's: no panic, no hang; how many of the damaged are told as such is printed.
#[test]
fn damaged_suites_end_in_a_picture_or_an_error() {
    let mut table = std::collections::BTreeMap::<(String, &str), u32>::new();
    let mut slowest = Duration::ZERO;
    for file in suite("malformed") {
        let bytes = std::fs::read(&file).unwrap();
        let name = file.file_name().unwrap().to_string_lossy();
        let expected = name.split('_').next().unwrap();
        let expected =
            if matches!(expected, "error" | "fatal" | "warning" | "valid") { expected } else { "other" };
        let start = Instant::now();
        let result = Ktx2::new(&bytes, &DecodeLimits::default()).and_then(|k| {
            for m in 0..k.mips() {
                k.mip(m)?;
            }
            Ok(())
        });
        slowest = slowest.max(start.elapsed());
        let got = match result {
            Ok(()) => "read",
            Err(ImageError::Unsupported { .. }) => "not supported",
            Err(ImageError::TooLarge { .. }) => "too large",
            Err(_) => "damaged",
        };
        *table.entry((expected.into(), got)).or_default() += 1;
    }
    for ((expected, got), n) in &table {
        println!("{expected:8} {got:14} {n:5}");
    }
    println!("slowest {slowest:?}");
    assert!(slowest < Duration::from_secs(5));
}
