//! Taking samples until the goal is reached, and keeping them safe meanwhile.

use super::args::RenderArgs;
use super::goal::Goal;
use super::output::{write_film, write_film_picture};
use super::progress::Progress;
use super::shot::Shot;
use super::{CliError, note_line};
use crate::render::{Counters, Film, FilmInfo};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// `--watch` rewrites the picture after the first samples, then after this time, then ever more rarely.
const WATCH: Duration = Duration::from_secs(1);

/// Times that the user asked to stop.
static INTERRUPTS: AtomicU32 = AtomicU32::new(0);

/// Lets Ctrl-C end the run after the samples at hand; a second one does not wait for anything.
pub(crate) fn listen_for_interrupts() {
    let _ = ctrlc::set_handler(|| {
        if INTERRUPTS.fetch_add(1, Ordering::SeqCst) > 0 {
            std::process::exit(130);
        }
    });
}

/// One run of `etendue render`.
pub(crate) struct Job<'a> {
    pub args: RenderArgs,
    pub shot: Shot<'a>,
    /// Which picture of several, for the progress bar.
    pub label: String,
    pub info: FilmInfo,
    pub output: PathBuf,
    /// Where the user wants the film.
    pub explicit_film: Option<PathBuf>,
    /// Where it is kept during the run.
    pub film_path: PathBuf,
    /// Whether a film has been written there.
    pub checkpointed: bool,
    pub counters: Arc<Counters>,
}

/// Something that is done now and then.
struct Every {
    last: Instant,
    interval: Duration,
    next: Duration,
    growth: f32,
}

impl Every {
    /// After `first`, then after `next`, which grows by `growth` each time up to half a minute.
    fn new(first: Duration, next: Duration, growth: f32) -> Self {
        Self { last: Instant::now(), interval: first, next, growth }
    }

    /// Does `work` if it is time.
    fn run(&mut self, work: impl FnOnce()) {
        if self.last.elapsed() < self.interval {
            return;
        }
        let begun = Instant::now();
        work();
        self.last = Instant::now();
        // Never more than a twentieth of the time.
        self.interval = self.next.max(begun.elapsed() * 20);
        if self.growth > 1.0 {
            self.next = self.next.mul_f32(self.growth).min(Duration::from_secs(30));
        }
    }
}

impl Job<'_> {
    /// Takes samples until the goal is reached (true) or the user stops it (false).
    ///
    /// # Errors
    /// A moment of a moving scene that cannot be made.
    pub fn sample(&mut self, film: &mut Film, goal: &Goal) -> Result<bool, CliError> {
        let start = Instant::now();
        let total = if goal.open { 0 } else { goal.missing };
        let visible = !self.args.quiet && !self.args.json;
        let progress = Progress::new(
            self.counters.clone(),
            film.pixels() as u64,
            total,
            film.samples(),
            goal.time,
            visible,
        );
        progress.label(&self.label);
        let finished = self.batches(film, goal, start, &progress);
        progress.finish();
        finished
    }

    fn batches(
        &mut self,
        film: &mut Film,
        goal: &Goal,
        start: Instant,
        progress: &Progress,
    ) -> Result<bool, CliError> {
        let mut checkpoint = Every::new(self.args.checkpoint, self.args.checkpoint, 1.0);
        let mut watch = Every::new(Duration::ZERO, WATCH, 1.25);
        let interval = Duration::from_millis(300);
        let mut estimate = Every::new(interval, interval, 1.0);
        let mut troubles = Vec::new();
        let mut batch = self.first_batch(film);
        if goal.is_quiet(film.samples(), || film.relative_error()) {
            return Ok(true);
        }
        for (from, to) in film.ranges.missing(goal.from, goal.to) {
            let mut at = from;
            while at < to {
                if INTERRUPTS.load(Ordering::SeqCst) > 0 && film.samples() > 0 {
                    return Ok(false);
                }
                let mut n = batch.min(to - at);
                if goal.noise.is_some() {
                    n = u64::from(n).min(Goal::next_check(film.samples()) - film.samples()) as u32;
                }
                let before = self.shot.moments();
                if let Some((block, _)) = before {
                    // Two parts of two blocks would need the moments of both.
                    n = n.min(block - at % block);
                }
                let begun = Instant::now();
                self.shot.render(film, at, at + n, &self.counters)?;
                at += n;
                let rate = f64::from(n) / begun.elapsed().as_secs_f64().max(1e-6);
                // Batches of a second: short enough to stop at, long enough for a pixel's samples to share the caches.
                batch = (rate as u32).clamp(1, 4096);
                if let Some(((_, before), (block, after))) = before.zip(self.shot.moments())
                    && (after - before) * 8 > begun.elapsed()
                {
                    // More samples at the same moments.
                    batch = batch.max((2 * n).min(block));
                }
                if let Some(budget) = goal.time {
                    let left = budget.saturating_sub(start.elapsed()).as_secs_f64();
                    if left * rate < 1.0 {
                        return Ok(true);
                    }
                    batch = batch.min((left * rate) as u32).max(1);
                }
                if progress.is_visible() {
                    estimate.run(|| progress.set_error(film.relative_error()));
                }
                if goal.is_quiet(film.samples(), || film.relative_error()) {
                    return Ok(true);
                }
                if at == to {
                    continue;
                }
                // A full disk now may be free again at the end: the work goes on.
                checkpoint.run(|| match write_film(&self.film_path, film, &self.info) {
                    Ok(()) => self.checkpointed = true,
                    Err(e) => trouble(&mut troubles, progress, e),
                });
                if self.args.watch {
                    let (develop, transparent) = (&self.args.develop, self.args.transparent);
                    watch.run(|| {
                        if let Err(e) =
                            write_film_picture(&self.output, film, &self.info, develop, transparent)
                        {
                            trouble(&mut troubles, progress, e);
                        }
                    });
                }
            }
        }
        Ok(true)
    }

    /// Samples to take at first: one, if they need but one world; if they need many, as many as take about a second.
    fn first_batch(&self, film: &Film) -> u32 {
        const SECOND: usize = 1 << 21;
        match self.shot.moments() {
            Some((block, _)) => ((SECOND / film.pixels().max(1)) as u32).clamp(1, block),
            None => 1,
        }
    }

    /// The message for a run that the user stopped.
    pub fn interrupted(&self, film: &Film, goal: &Goal) -> CliError {
        let wanted = if goal.open { String::new() } else { format!(" of {}", goal.to - goal.from) };
        CliError::Interrupted {
            done: format!("{}{wanted} samples", film.samples()),
            picture: self.output.clone(),
            film: self.film_path.clone(),
        }
    }
}

/// Says once what could not be written during the run.
fn trouble(told: &mut Vec<String>, progress: &Progress, e: CliError) {
    let text = format!("warning: {e}; going on");
    if !told.contains(&text) {
        progress.suspend(|| note_line(&text));
        told.push(text);
    }
}
