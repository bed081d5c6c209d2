//! Which of the names that there are was probably meant.

/// The name nearest to `word`, if one is near enough to have been meant.
///
/// ```
/// use etendue_import::scene_file::nearest;
/// assert_eq!(nearest("rougness", ["metallic", "roughness"]), Some("roughness"));
/// assert_eq!(nearest("shine", ["metallic", "roughness"]), None);
/// ```
pub fn nearest<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let plain = |s: &str| s.to_lowercase().replace(['-', ' '], "_");
    // Beyond this no one looks for a slip of the pen, and the table below would grow.
    if word.len() > 64 {
        return None;
    }
    let word = plain(word);
    let allowed = (word.chars().count() / 3).clamp(1, 3);
    let far = |n: &str| distance(&word, &plain(n));
    let names = names.into_iter().filter(|n| n.len() <= 128);
    let best = names.map(|n| (far(n), n)).min_by_key(|&(d, _)| d);
    best.filter(|&(d, _)| d <= allowed).map(|(_, n)| n)
}

/// How many letters have to be put in, left out, changed or exchanged with their neighbour to make `b` of `a` (optimal string
/// alignment distance: Damerau 1964, as computed by Wagner and Fischer 1974 with neighbours exchanged at most once).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows: Vec<Vec<usize>> = vec![(0..=b.len()).collect()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let change = usize::from(a[i - 1] != b[j - 1]);
            let mut least = (rows[i - 1][j] + 1).min(row[j - 1] + 1).min(rows[i - 1][j - 1] + change);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances() {
        let d = |a, b, n| assert_eq!(distance(a, b), n, "{a} {b}");
        d("", "", 0);
        d("", "abc", 3);
        d("abc", "abd", 1);
        d("acb", "abc", 1);
        d("kitten", "sitting", 3);
    }

    #[test]
    fn what_was_meant() {
        let names = ["translation", "rotation", "scale", "at"];
        assert_eq!(nearest("translaiton", names), Some("translation"));
        assert_eq!(nearest("Rotation", names), Some("rotation"));
        assert_eq!(nearest("xyz", names), None);
        assert_eq!(nearest(&"a".repeat(1 << 20), names), None);
        assert_eq!(nearest("", names), None);
    }
}
