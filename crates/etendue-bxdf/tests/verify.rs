//! Every model before every law, by the code that the command line's `lab verify` runs.
//!
//! By default every fifth of the quick cases, with 2·10⁴ samples; with `ETENDUE_MODEL=name` all quick cases of one model;
//! with `ETENDUE_FULL=1` all cases with 10⁶. `etendue lab verify` runs the quick cases of all models in a minute or two.

use etendue_bxdf::{
    laws::{
        cases::{Settings, cases},
        verify::{CaseReport, Law, Report, Verdict, judge, measure},
    },
    model::Model,
};
use std::sync::Mutex;

/// All models at once, the cases spread over the processors, so that one level holds for all.
fn run(models: &[Model], settings: &Settings, every: usize) -> Report {
    let of = |m| cases(m, settings).into_iter().step_by(every);
    let work: Vec<_> = models.iter().flat_map(of).enumerate().collect();
    let queue = Mutex::new(work.into_iter());
    let done = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, |n| n.get()) {
            scope.spawn(|| {
                loop {
                    let next = queue.lock().expect("no thread panics here").next();
                    let Some((i, case)) = next else { break };
                    let cells = measure(&case, settings);
                    done.lock().expect("no thread panics here").push((i, CaseReport { case, cells }));
                }
            });
        }
    });
    let mut done = done.into_inner().expect("no thread panics here");
    done.sort_by_key(|d| d.0);
    judge(done.into_iter().map(|d| d.1).collect(), settings.significance)
}

#[test]
fn every_model_keeps_what_it_claims() {
    let full = std::env::var_os("ETENDUE_FULL").is_some_and(|v| v == "1");
    let settings = if full { Settings::full() } else { Settings::quick() };
    let only = std::env::var("ETENDUE_MODEL").ok();
    let models: Vec<_> = Model::NAMES
        .iter()
        .filter(|name| only.as_deref().is_none_or(|o| o == **name))
        .map(|name| Model::by_name(name).expect("listed"))
        .collect();
    assert!(!models.is_empty(), "no model {only:?}");
    let report = run(&models, &settings, if full || only.is_some() { 1 } else { 5 });
    println!(
        "{} models, {} cases, {} cells, {} of them at level {:.1e}",
        models.len(),
        report.cases.len(),
        report.cells().count(),
        report.statistical,
        report.level
    );
    for law in Law::ALL {
        println!("  {:20} {} cells", law.name(), report.cells().filter(|(_, c)| c.law == law).count());
    }
    let failures: Vec<_> = report
        .failures()
        .map(|(case, c)| {
            let angle = c.angle.map_or(String::new(), |a| format!(" {a}°"));
            format!(
                "{}{angle}: {} {:.3e}, bound {:.3e}; {}\n    {}",
                case.label(),
                c.law.name(),
                c.value,
                c.bound,
                c.note,
                case.parameters()
            )
        })
        .collect();
    assert!(failures.is_empty(), "{} cells fail:\n{}", failures.len(), failures.join("\n"));
}

/// The judge sees a value beyond its bound, a p-value below the level, and a law that is not claimed.
#[test]
fn the_judge_is_not_blind() {
    let model = Model::by_name("metal-rough").expect("listed");
    let settings = Settings { samples: 2_000, random: 0, ..Settings::quick() };
    let case = cases(&model, &settings).swap_remove(0);
    let sound = judge(vec![CaseReport { cells: measure(&case, &settings), case: case.clone() }], 0.01);
    assert_eq!(sound.failures().count(), 0);
    let spoiled = |law: Law, value: f64, verdict: Verdict| {
        let mut cells = measure(&case, &settings);
        let cell = cells.iter_mut().find(|c| c.law == law).expect("every law is there");
        (cell.value, cell.verdict) = (value, verdict);
        let report = judge(vec![CaseReport { case: case.clone(), cells }], 0.01);
        report.failures().map(|(_, c)| c.law).collect::<Vec<_>>()
    };
    assert_eq!(spoiled(Law::Furnace, 1.01, Verdict::Holds), [Law::Furnace]);
    assert_eq!(spoiled(Law::Furnace, 1.01, Verdict::Waived("says so")), []);
    assert_eq!(spoiled(Law::Chi2, 1e-9, Verdict::Holds), [Law::Chi2]);
    assert_eq!(spoiled(Law::Chi2, f64::NAN, Verdict::Holds), [Law::Chi2]);
    assert_eq!(spoiled(Law::Reciprocity, f64::NAN, Verdict::Holds), [Law::Reciprocity]);
}
