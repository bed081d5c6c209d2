//! The progress bar: what has been done, how fast, how well, how long it still takes.

use crate::render::Counters;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A bar on standard error that draws itself from another thread while rendering goes on. Invisible where standard error is no
/// terminal, or on request.
pub(crate) struct Progress {
    bar: ProgressBar,
    state: Arc<State>,
    ticker: Option<std::thread::JoinHandle<()>>,
}

struct State {
    counters: Arc<Counters>,
    start: Instant,
    /// Bits of the error estimate, an f64.
    error: AtomicU64,
    /// Samples to take over all pixels; 0 if only time or noise ends the run.
    total: u64,
    time: Option<Duration>,
    pixels: u64,
    done_before: u64,
    stop: AtomicBool,
}

impl Progress {
    /// Starts the bar. `total`: samples per pixel that this run is to take at most; `before`: those the film already had.
    pub fn new(
        counters: Arc<Counters>,
        pixels: u64,
        total: u64,
        before: u64,
        time: Option<Duration>,
        visible: bool,
    ) -> Self {
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(1000), target);
        if let Ok(style) = ProgressStyle::with_template("{prefix}{percent:>3}%  {msg}  {wide_bar}") {
            bar.set_style(style.progress_chars("━╸ "));
        }
        let state = Arc::new(State {
            counters,
            start: Instant::now(),
            error: AtomicU64::new(f64::INFINITY.to_bits()),
            total: total.saturating_mul(pixels),
            time,
            pixels,
            done_before: before,
            stop: AtomicBool::new(false),
        });
        let ticker = (!bar.is_hidden()).then(|| {
            let (bar, state) = (bar.clone(), state.clone());
            std::thread::spawn(move || {
                while !state.stop.load(Ordering::Relaxed) {
                    state.draw(&bar);
                    std::thread::park_timeout(Duration::from_millis(100));
                }
            })
        });
        Self { bar, state, ticker }
    }

    /// Says what the bar is about, if there are several.
    pub fn label(&self, text: &str) {
        if !text.is_empty() {
            self.bar.set_prefix(format!("{text}  "));
        }
    }

    /// Tells the bar the newest estimate of the relative error.
    pub fn set_error(&self, error: f64) {
        self.state.error.store(error.to_bits(), Ordering::Relaxed);
    }

    /// True if somebody sees it.
    pub fn is_visible(&self) -> bool {
        self.ticker.is_some()
    }

    /// Prints something without the bar in the way.
    pub fn suspend(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
    }

    /// Removes the bar.
    pub fn finish(mut self) {
        self.state.stop.store(true, Ordering::Relaxed);
        if let Some(t) = self.ticker.take() {
            t.thread().unpark();
            let _ = t.join();
        }
        self.bar.finish_and_clear();
    }
}

impl State {
    fn draw(&self, bar: &ProgressBar) {
        let elapsed = self.start.elapsed().as_secs_f64().max(1e-3);
        let samples = self.counters.samples.load(Ordering::Relaxed);
        let by_samples = samples as f64 / self.total.max(1) as f64;
        let by_time = self.time.map_or(0.0, |t| elapsed / t.as_secs_f64().max(1e-3));
        let done = by_samples.max(by_time).clamp(0.0, 1.0);
        bar.set_position((done * 1000.0) as u64);
        let left = if done > 0.001 { elapsed * (1.0 / done - 1.0) } else { f64::INFINITY };
        let error = f64::from_bits(self.error.load(Ordering::Relaxed));
        let mut text = format!(
            "{:.1} spp  {}rays/s",
            self.done_before as f64 + samples as f64 / self.pixels.max(1) as f64,
            super::output::count(self.counters.rays() as f64 / elapsed)
        );
        if error.is_finite() {
            text += &format!("  error {:.2} %", error * 100.0);
        }
        if left.is_finite() {
            text += &format!("  {} left", clock(left));
        }
        bar.set_message(text);
    }
}

/// A line that shows that something is being done which has no measure; nothing unless `visible`.
pub(crate) fn spinner(text: &'static str, visible: bool) -> ProgressBar {
    let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(None, target).with_message(text);
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// Seconds for people.
pub(crate) fn clock(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 100.0 => format!("{s:.0} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
