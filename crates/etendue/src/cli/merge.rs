//! `etendue merge`: parts into a whole.

use super::args::MergeArgs;
use super::output::{read_film, write_film, write_film_picture};
use super::{CliError, say};
use crate::render::MergeError;

pub(crate) fn run(args: &MergeArgs) -> Result<(), CliError> {
    let mut films = args.films.iter();
    let first = films.next().ok_or_else(|| CliError::Usage("give at least one film".into()))?;
    let (mut film, info) = read_film(first)?;
    for path in films {
        let (other, theirs) = read_film(path)?;
        let fail = |source| CliError::Merge { path: path.clone(), source };
        if theirs.picture != info.picture {
            return Err(fail(MergeError::Picture(info.picture.clone(), theirs.picture)));
        }
        film.merge(&other).map_err(fail)?;
    }
    if args.output.extension().is_some_and(|e| e == "film") {
        write_film(&args.output, &film, &info)?;
    } else {
        write_film_picture(&args.output, &film, &info, &args.develop, args.transparent)?;
    }
    let error = film.relative_error();
    say(&if args.json {
        serde_json::json!({
            "output": args.output, "films": args.films.len(), "samples": film.samples(),
            "width": film.width, "height": film.height, "relative_error": error.is_finite().then_some(error),
        })
        .to_string()
    } else {
        format!("{}: {} films, {} samples per pixel", args.output.display(), args.films.len(), film.samples())
    });
    Ok(())
}
