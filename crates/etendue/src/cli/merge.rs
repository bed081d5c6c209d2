//! `etendue merge`: parts into a whole.

use super::args::{MergeArgs, RenderArgs};
use super::output::{ARGUMENTS, read_film, write_film, write_film_picture};
use super::{CliError, resume, say, target};
use crate::render::{Film, FilmInfo, MergeError};
use std::path::Path;

pub(crate) fn run(args: &MergeArgs) -> Result<(), CliError> {
    let to_film = args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("film"));
    if !to_film {
        target::format(&args.output)?;
    }
    target::check_writable(&args.output)?;
    let (film, mut info, from) = add(args)?;
    // How the parts were developed, unless this command says otherwise.
    let mut then = resume::stored(&from, &info)?;
    if to_film {
        whole(&mut then, &film);
        info.notes.insert(ARGUMENTS.into(), serde_json::to_string(&then).unwrap_or_default());
        write_film(&args.output, &film, &info)?;
    } else {
        let develop = args.develop.over(&then.develop, &args.given);
        write_film_picture(&args.output, &film, &info, &develop, then.transparent)?;
    }
    if args.quiet && !args.json {
        return Ok(());
    }
    let error = film.relative_error();
    say(&if args.json {
        serde_json::json!({
            "output": args.output.to_string_lossy(), "films": args.films.len(), "samples": film.samples(),
            "width": film.width, "height": film.height, "picture": info.picture,
            "relative_error": error.is_finite().then_some(error), "rejected_samples": film.rejected,
        })
        .to_string()
    } else {
        let films =
            if args.films.len() == 1 { "1 film".into() } else { format!("{} films", args.films.len()) };
        format!("{}: {films}, {} samples per pixel", args.output.display(), film.samples())
    });
    Ok(())
}

/// The sum of all films; with what the one with the first samples says of itself, so that their order does not matter, and
/// the path of that one.
fn add(args: &MergeArgs) -> Result<(Film, FilmInfo, std::path::PathBuf), CliError> {
    let first_sample = |f: &Film| f.ranges.as_slice().first().map_or(u32::MAX, |r| r.0);
    let mut sum: Option<(Film, FilmInfo, &Path, u32)> = None;
    for path in &args.films {
        let (film, info) = read_film(path)?;
        let first = first_sample(&film);
        let Some((whole, whole_info, from, lowest)) = &mut sum else {
            sum = Some((film, info, path, first));
            continue;
        };
        let fail = |source| CliError::Merge { path: path.clone(), source };
        if info.picture != whole_info.picture {
            return Err(fail(MergeError::Picture(whole_info.picture.clone(), info.picture)));
        }
        whole.merge(&film).map_err(fail)?;
        if first < *lowest {
            (*whole_info, *from, *lowest) = (info, path, first);
        }
    }
    let (film, info, from, _) = sum.ok_or_else(|| CliError::Usage("give at least one film".into()))?;
    Ok((film, info, from.to_path_buf()))
}

/// Makes the arguments of a part those of the sum, so that `--resume` goes on with what is missing in it.
fn whole(args: &mut RenderArgs, film: &Film) {
    let ranges = film.ranges.as_slice();
    (args.noise, args.time, args.film) = (None, None, None);
    (args.spp, args.samples) = match (ranges.first(), ranges.last()) {
        (Some((0, _)), Some((_, to))) => (Some(*to), None),
        (Some((from, _)), Some((_, to))) => (None, Some((*from, *to))),
        _ => (args.spp, args.samples),
    };
}
