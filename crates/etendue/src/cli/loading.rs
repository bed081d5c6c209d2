//! The bar that shows how far a large model is loaded.

use crate::import::ImportProgress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

/// A bar on standard error, drawn from another thread while it lives. Invisible where standard error is no terminal, on
/// request, and for models that are loaded in a moment.
pub(crate) struct Loading {
    progress: Arc<ImportProgress>,
    over: Arc<AtomicBool>,
    ticker: Option<JoinHandle<()>>,
}

/// Models that take less show no bar.
const PATIENCE: Duration = Duration::from_millis(500);

impl Loading {
    /// Starts the bar.
    pub fn new(visible: bool) -> Self {
        let (progress, over) = (Arc::new(ImportProgress::default()), Arc::new(AtomicBool::new(false)));
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(None, target);
        let ticker = (!bar.is_hidden()).then(|| {
            let (progress, over) = (progress.clone(), over.clone());
            std::thread::spawn(move || {
                std::thread::park_timeout(PATIENCE);
                while !over.load(Ordering::Relaxed) {
                    draw(&bar, &progress);
                    std::thread::park_timeout(Duration::from_millis(100));
                }
                bar.finish_and_clear();
            })
        });
        Self { progress, over, ticker }
    }

    /// What the import is to tell its progress.
    pub fn progress(&self) -> Arc<ImportProgress> {
        self.progress.clone()
    }
}

fn draw(bar: &ProgressBar, progress: &ImportProgress) {
    if bar.length().is_none() && progress.total() > 0 {
        bar.set_length(progress.total());
        if let Ok(style) = ProgressStyle::with_template("{percent:>3}%  loading  {wide_bar}") {
            bar.set_style(style.progress_chars("━╸ "));
        }
    }
    match progress.total() {
        0 => bar.set_message("loading"),
        total => {
            bar.set_length(total);
            bar.set_position(progress.done());
        }
    }
    bar.tick();
}

impl Drop for Loading {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(t) = self.ticker.take() {
            t.thread().unpark();
            let _ = t.join();
        }
    }
}
