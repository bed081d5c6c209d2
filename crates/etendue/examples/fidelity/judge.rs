//! How far our pictures are from the others, and whether that is as far as those are from each other.

use crate::draw::Ours;
use crate::suite::Golden;
use etendue::image::{Image, rmse};
use std::error::Error;

/// Scenes of which a picture of ours is beyond its peers, and why.
const REASONS: [(&str, &str); 5] = [
    (
        "AnimatedTriangle",
        "of its two path tracers one turned the triangle to another time of its animation, the other lights it half as much",
    ),
    (
        "OrientationTest",
        "the crate is metal of roughness 0.5, which loses a tenth of the light that meets several microfacets: two path tracers \
         leave it out, Cycles gives part of it back; with --compensation none ours is at 0.0185, with turquin at 0.0236",
    ),
    (
        "SimpleMorph",
        "two path tracers leave out the weights that the mesh itself has; those that shade in real time do not",
    ),
    (
        "SpecularTest",
        "by 0.0001: the letters' outlines in dspbr-pt's picture are unlike all others' (0.0355); to the other two it is 0.026",
    ),
    (
        "TextureEncodingTest",
        "letters on bright labels: ours are sharper, the spheres are as near as the others' to each other",
    ),
];

/// A picture of ours among its peers.
pub struct Place {
    /// Mean distance of ours to them.
    pub ours: f64,
    /// Largest distance between two of them.
    pub largest: f64,
    /// The one among them whose mean distance to the others is largest, and that distance.
    pub outermost: (String, f64),
}

impl Place {
    /// Whether ours is as near to them as they are to each other.
    pub fn is_within(&self) -> bool {
        self.ours <= self.largest
    }

    fn text(place: &Option<Self>) -> String {
        match place {
            None => format!("{:>28}", "no peers"),
            Some(p) => {
                let verdict = if p.is_within() { "within" } else { "BEYOND" };
                format!("{:>8.4} of {:>6.4}  {verdict:>8}", p.ours, p.largest)
            }
        }
    }
}

/// What is found of a scene.
pub struct Judgement {
    pub name: String,
    /// Our traced paths among the path tracers, or among all where fewer than two of those are.
    pub path: Option<Place>,
    /// Our real-time picture among those that shade in real time.
    pub realtime: Option<Place>,
}

impl Judgement {
    /// Whether each picture is within its peers' spread or known why not.
    pub fn is_good(&self) -> bool {
        let within = [&self.path, &self.realtime].into_iter().flatten().all(Place::is_within);
        within || self.reason().is_some()
    }

    fn reason(&self) -> Option<&'static str> {
        REASONS.iter().find(|r| r.0 == self.name).map(|r| r.1)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The root of the mean squared difference, less what our noise adds to its square.
fn distance(theirs: &Image, ours: &Image, noise: f64) -> Result<f64, Box<dyn Error>> {
    let d = rmse(theirs, ours)?;
    Ok((d * d - noise * noise).max(0.0).sqrt())
}

/// Where `ours` is among `peers`; `None` if they are fewer than two.
fn place(ours: &Image, noise: f64, peers: &[&Golden]) -> Result<Option<Place>, Box<dyn Error>> {
    if peers.len() < 2 {
        return Ok(None);
    }
    let (mut largest, mut outermost) = (0.0f64, (String::new(), 0.0f64));
    let mut distances = Vec::new();
    for a in peers {
        distances.push(distance(&a.picture, ours, noise)?);
        let mut others = Vec::new();
        for b in peers.iter().filter(|b| b.name != a.name) {
            others.push(rmse(&a.picture, &b.picture)?);
        }
        largest = others.iter().copied().fold(largest, f64::max);
        if mean(&others) > outermost.1 {
            outermost = (a.name.clone(), mean(&others));
        }
    }
    Ok(Some(Place { ours: mean(&distances), largest, outermost }))
}

/// Prints a scene's distances and judges both pictures.
pub fn judge(name: &str, ours: &Ours, goldens: &[Golden]) -> Result<Judgement, Box<dyn Error>> {
    println!("  {:<24}{:>12}{:>12}", "renderer", "paths", "real time");
    for g in goldens {
        let p = distance(&g.picture, &ours.path, ours.noise)?;
        let r = distance(&g.picture, &ours.realtime, 0.0)?;
        println!("  {:<24}{p:>12.4}{r:>12.4}", g.name);
    }
    println!(
        "  {:<24}{:>12}{:>12.4}",
        "our traced paths",
        "",
        distance(&ours.realtime, &ours.path, ours.noise)?
    );
    println!("  noise of our paths {:.4}, taken out of their distances", ours.noise);
    let (mut traced, shaded): (Vec<&Golden>, Vec<&Golden>) = goldens.iter().partition(|g| g.path_traced);
    if traced.len() < 2 {
        traced = goldens.iter().collect();
    }
    let judgement = Judgement {
        name: name.into(),
        path: place(&ours.path, ours.noise, &traced)?,
        realtime: place(&ours.realtime, 0.0, &shaded)?,
    };
    for (what, place) in [("paths", &judgement.path), ("real time", &judgement.realtime)] {
        let Some(p) = place else { continue };
        println!(
            "  {what}: mean distance to peers {:.4}; between two of them at most {:.4}; the outermost, {}, {:.4}",
            p.ours, p.largest, p.outermost.0, p.outermost.1
        );
    }
    Ok(judgement)
}

/// All scenes in one table.
pub fn table(judgements: &[Judgement]) {
    println!();
    println!("{:<30}{:>28}{:>28}", "scene", "paths", "real time");
    for j in judgements {
        println!("{:<30}{}{}", j.name, Place::text(&j.path), Place::text(&j.realtime));
        if let Some(reason) = j.reason() {
            println!("    {reason}");
        }
    }
    let count = |of: fn(&Judgement) -> &Option<Place>| {
        let places: Vec<&Place> = judgements.iter().filter_map(|j| of(j).as_ref()).collect();
        (places.iter().filter(|p| p.is_within()).count(), places.len())
    };
    let ((a, b), (c, d)) = (count(|j| &j.path), count(|j| &j.realtime));
    println!(
        "{} scenes; paths within the spread of their peers in {a} of {b}, real time in {c} of {d}",
        judgements.len()
    );
}
