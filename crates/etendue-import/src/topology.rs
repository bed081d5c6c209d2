//! Which vertices make which triangles.

use crate::accessor::Elements;
use crate::document::Mode;
use crate::error::Fault;
use crate::geometry::Job;
use crate::warning::Warnings;

/// The triangles of a primitive: a list, a strip or a fan (glTF 2.0, 3.7.2.1), indexed or not; points as `[a, a, a]` and lines as
/// `[a, b, b]` for [`crate::strokes`].
pub(crate) fn triangles(
    job: &Job,
    positions: &Elements<'_>,
    indices: Option<Elements<'_>>,
    warnings: &mut Warnings,
) -> Result<Vec<[u32; 3]>, Fault> {
    let count = positions.len() as u32;
    let Some(e) = indices else { return Ok(join(job, count as usize, |i| i as u32, warnings)) };
    let pointer = || format!("{}/indices", job.pointer);
    let Some(list) = e.integers::<1>(None) else {
        return Err(Fault::invalid(pointer(), "indices are unsigned integers (5121, 5123, 5125)"));
    };
    if let Some(at) = list.iter().position(|&[i]| i >= count) {
        return Err(Fault::invalid(
            e.pointer(),
            format!("entry {at} is vertex {}, but {} has {count} vertices", list[at][0], job.pointer),
        ));
    }
    Ok(join(job, list.len(), |i| list[i][0], warnings))
}

fn join(job: &Job, n: usize, v: impl Fn(usize) -> u32, warnings: &mut Warnings) -> Vec<[u32; 3]> {
    let line = |a: u32, b: u32| [a, b, b];
    let proper = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    match job.key.mode {
        Mode::Triangles => {
            if !n.is_multiple_of(3) {
                warnings.add(
                    &job.pointer,
                    "the number of indices or vertices is not a multiple of three; the rest is ignored",
                );
            }
            (0..n / 3).map(|i| [v(3 * i), v(3 * i + 1), v(3 * i + 2)]).collect()
        }
        // Every other triangle is turned over to keep the winding. Strips are stitched together by triangles that
        // use a vertex twice: those have no area and are left out.
        Mode::Strip => (0..n.saturating_sub(2))
            .map(|i| [v(i), v(i + 1 + i % 2), v(i + 2 - i % 2)])
            .filter(proper)
            .collect(),
        Mode::Fan => (0..n.saturating_sub(2)).map(|i| [v(i + 1), v(i + 2), v(0)]).filter(proper).collect(),
        // Points and lines are triangles without area, until they are given a thickness.
        Mode::Points => (0..n).map(|i| [v(i); 3]).collect(),
        Mode::Lines => {
            if !n.is_multiple_of(2) {
                warnings.add(&job.pointer, "a line without an end; left out");
            }
            (0..n / 2).map(|i| line(v(2 * i), v(2 * i + 1))).collect()
        }
        Mode::LineStrip => (1..n).map(|i| line(v(i - 1), v(i))).collect(),
        // Of two vertices the way back is the same line.
        Mode::LineLoop if n > 2 => (0..n).map(|i| line(v(i), v((i + 1) % n))).collect(),
        Mode::LineLoop => (1..n).map(|i| line(v(i - 1), v(i))).collect(),
    }
}

/// Numbers the vertices that triangles use from 0 on and returns which ones they are, in order; `None` if all of the
/// `count` are used. Exporters often keep the vertices of many primitives in one array.
pub(crate) fn compact(triangles: &mut [[u32; 3]], count: usize) -> Option<Vec<u32>> {
    let corners = 3 * triangles.len();
    if count > 4 * corners {
        // Work in proportion to the triangles, not to the array.
        let mut used: Vec<u32> = triangles.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        for i in triangles.as_flattened_mut() {
            *i = used.partition_point(|u| u < i) as u32;
        }
        return Some(used);
    }
    let mut is_used = vec![false; count];
    for &i in triangles.as_flattened() {
        is_used[i as usize] = true;
    }
    if is_used.iter().all(|&u| u) {
        return None;
    }
    let mut used = Vec::new();
    let mut number = vec![0u32; count];
    for i in (0..count).filter(|&i| is_used[i]) {
        number[i] = used.len() as u32;
        used.push(i as u32);
    }
    for i in triangles.as_flattened_mut() {
        *i = number[*i as usize];
    }
    Some(used)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compacting_keeps_the_triangles() {
        for count in [5usize, 6, 100] {
            let original = [[4, 2, 0], [0, 2, 3], [3, 2, 4]];
            let mut t = original;
            let used = compact(&mut t, count).unwrap();
            assert_eq!(used, [0, 2, 3, 4]);
            assert_eq!(t.map(|t| t.map(|i| used[i as usize])), original);
        }
        let mut all = [[0, 1, 2], [2, 1, 0]];
        assert_eq!(compact(&mut all, 3), None);
    }
}
