//! Studies: interrupted and gone on with, they end in the same table; and warm starts come to the same densities.

use crate::common::*;
use expoly::models::{DuffingVanDerPol, Solved};
use expoly::study::{Case, OrderRow, OrderStudy, OrderTable, Sweep};
use expoly::{Closure, ClosureDensity, Density, Error, ExpPolynomial, Gaussian, Polynomial, Problem, Support, Wall};
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("study");
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    let _ = std::fs::remove_file(&path);
    path
}

/// Systems of one state and of two, two methods for the latter, and a count of what was solved.
fn study<'a>(solved: &'a AtomicUsize, orders: &[u32]) -> OrderStudy<'a> {
    let count = move || {
        solved.fetch_add(1, Ordering::Relaxed);
    };
    let plane = Case::new("Duffing", problem(duffing()), |_: &Problem| duffing().exact())
        .method("robust", move |n| {
            count();
            Closure::new(n)
        })
        .method("classical", move |n| {
            count();
            Closure::classical(n)
        });
    let line = Case::new("Ornstein-Uhlenbeck", problem(OrnsteinUhlenbeck), |_: &Problem| {
        let q = Polynomial::from_terms(1, [([2], -0.5)])?;
        let scale = Gaussian { mean: DVector::zeros(1), covariance: DMatrix::identity(1, 1) };
        ExpPolynomial::from_states(&q, &scale, Support::WholeSpace)
    })
    .method("robust", move |n| {
        count();
        Closure::new(n)
    });
    OrderStudy::new(orders).case(plane).case(line)
}

/// The rows without the time that they took.
fn timeless(table: &OrderTable) -> Vec<OrderRow> {
    let timeless = |mut row: OrderRow| {
        row.seconds = 0.0;
        row
    };
    table.rows().iter().cloned().map(timeless).collect()
}

fn cancelled(study: OrderStudy<'_>, after: u64) {
    let error = study
        .progress(
            move |progress, _| if progress.done >= after { ControlFlow::Break(()) } else { ControlFlow::Continue(()) },
        )
        .run()
        .unwrap_err();
    assert!(matches!(error, Error::Cancelled { unit: "rows", .. }), "{error}");
}

fn lines(path: &Path) -> usize {
    std::fs::read_to_string(path).unwrap().lines().count()
}

#[test]
fn an_interrupted_study_goes_on_to_the_same_table() {
    let (orders, solved) = ([2, 4, 6], AtomicUsize::new(0));
    let whole = study(&solved, &orders).run().unwrap();
    assert_eq!((whole.rows().len(), solved.swap(0, Ordering::Relaxed)), (9, 9));
    // The study's own order: systems, then methods, then orders.
    let keys: Vec<_> = whole.rows().iter().map(|row| (&row.system[..1], &row.method[..1], row.order)).collect();
    assert_eq!(keys[..4], [("D", "r", 2), ("D", "r", 4), ("D", "r", 6), ("D", "c", 2)]);
    assert_eq!(keys[8], ("O", "r", 6));
    // Duffing's density is a quartic: from n = 4 on all errors are rounding, those of quadratures included.
    for row in whole.rows() {
        let exact = row.order >= 4 || row.system.starts_with('O');
        assert_eq!(row.l1.unwrap() < 1e-6, exact, "{row:?}");
        assert_eq!(row.mean_square_x.unwrap().abs() < 1e-6, exact, "{row:?}");
        assert!(row.tail.is_some());
        assert_eq!(row.rate.is_some(), row.system == "Duffing");
        assert_eq!(row.indicator.is_some(), row.method == "robust");
    }
    let enough: Vec<_> = whole.convergence().iter().map(|found| found.enough).collect();
    assert_eq!(enough, [Some(4), None, Some(2)]);
    assert!(whole.to_string().contains("stops paying at n = 4"), "{whole}");

    let path = scratch("orders.csv");
    cancelled(study(&solved, &orders).file(&path), 2);
    let kept = lines(&path) - 1;
    // Each thread may finish what it has begun.
    assert!((2..9).contains(&kept) && solved.swap(0, Ordering::Relaxed) == kept, "{kept}");
    cancelled(study(&solved, &orders).file(&path), kept as u64 + 1);
    // A run that was killed in the middle of a line: the row is computed again.
    let content = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, &content[..content.len() - 9]).unwrap();
    let kept = lines(&path) - 2;
    solved.store(0, Ordering::Relaxed);
    let resumed = study(&solved, &orders).file(&path).run().unwrap();
    assert_eq!(solved.swap(0, Ordering::Relaxed), 9 - kept);
    assert_eq!(timeless(&resumed), timeless(&whole));
    // A finished study is read, and nothing is solved, neither for all of its rows nor for some.
    assert_eq!(study(&solved, &orders).file(&path).run().unwrap(), resumed);
    assert_eq!(study(&solved, &[2, 4]).file(&path).run().unwrap().rows().len(), 6);
    assert_eq!(solved.load(Ordering::Relaxed), 0);
    assert!(matches!(study(&solved, &[]).run(), Err(Error::OutOfRange { .. })));
    // An error other than a missing density ends the study, and is returned rather than the cancellation of the rows that
    // were not begun.
    let bad = study(&solved, &[2, 17, 4]).run().unwrap_err();
    assert!(matches!(bad, Error::OutOfRange { name: "order of the closure", .. }), "{bad}");
    let nowhere = study(&solved, &orders).file(path.join("below/a/file")).run().unwrap_err();
    assert!(matches!(nowhere, Error::File { .. }), "{nowhere}");
}

#[test]
fn a_sweep_starts_near_and_goes_on_to_the_same_table() {
    let values = [1.0, 0.9, 0.8, 0.7, 0.6];
    let (cold, warm) = (AtomicUsize::new(0), AtomicUsize::new(0));
    // The start that is handed over is the value itself, so that the table shows which one it was.
    let solve = |r: f64, near: Option<&f64>| {
        if near.is_some() { &warm } else { &cold }.fetch_add(1, Ordering::Relaxed);
        Ok((vec![r * r, near.copied().unwrap_or(r)], r))
    };
    let sweep = || Sweep::new("r", &values, &["square", "from"]).segment(3);
    let whole = sweep().run(solve).unwrap();
    assert_eq!(whole.column("from").unwrap(), [0.9, 0.9, 0.9, 0.7, 0.7]);
    assert_eq!(whole.column("square").unwrap(), values.map(|r| r * r));
    assert_eq!((cold.swap(0, Ordering::Relaxed), warm.swap(0, Ordering::Relaxed)), (2, 3));
    let path = scratch("sweep.csv");
    let stop = sweep().file(&path).progress(|_, _| ControlFlow::Break(())).run(solve).unwrap_err();
    assert!(matches!(stop, Error::Cancelled { unit: "rows", .. }), "{stop}");
    assert_eq!(sweep().file(&path).run(solve).unwrap(), whole);
    assert_eq!(sweep().file(&path).run(solve).unwrap(), whole);
    assert!(matches!(whole.column("none"), Err(Error::NotAName { .. })));
    for values in [&[][..], &[f64::NAN], &[0.5, 0.5]] {
        assert!(matches!(Sweep::new("r", values, &["a"]).run(solve), Err(Error::OutOfRange { .. })), "{values:?}");
    }
    assert!(matches!(sweep().segment(0).run(solve), Err(Error::OutOfRange { .. })));
    let short = Sweep::new("r", &[1.0], &["one"]).run(solve).unwrap_err();
    assert!(matches!(short, Error::Dimension { expected: 1, found: 2, .. }), "{short}");
}

/// A start from a similar system takes fewer linear systems, and comes to the same density within the estimated errors.
#[test]
fn a_warm_start_comes_to_the_same_density() {
    let agree = |what: &str, cold: &ClosureDensity, warm: &ClosureDensity| {
        let (l1, estimates) = (
            cold.expectation(&|x| (1.0 - (warm.log_pdf(x).unwrap() - cold.log_pdf(x).unwrap()).exp()).abs()).unwrap(),
            [cold.l1_estimate(), warm.l1_estimate()],
        );
        let iterations = [cold, warm].map(|density| density.provenance().iterations.unwrap());
        println!("{what}: L1 between {:.1e}, estimates {estimates:?}, iterations {iterations:?}", l1.value);
        assert!(l1.value < estimates[0] + estimates[1] && iterations[1] < iterations[0], "{what}");
        // The warm start is no worse, by its own estimate, within a tenth.
        assert!(estimates[1] < 1.1 * estimates[0], "{what}");
    };
    // A problem with its closure, and the closure of one that is similar to it.
    let check = |what: &str, order: u32, (problem, cold): (&Problem, &ClosureDensity), near: &ClosureDensity| {
        agree(what, cold, &Closure::new(order).starting_from(near).solve(problem).unwrap());
    };
    let solve = |order: u32, problem: &Problem| Closure::new(order).solve(problem).unwrap();
    let wall = |r: f64| duffing_above(-0.5, r);
    check("wall", 4, (&wall(0.9), &closed_above(4, -0.5, 0.9)), &solve(4, &wall(0.95)));
    let [walls, near] = [0.8, 0.85].map(|r| wall(r).with_wall(Wall::below(1.0, 0.8).unwrap()).unwrap());
    check("two walls", 4, (&walls, &solve(4, &walls)), &solve(4, &near));
    let (cycle, weaker) = (problem(van_der_pol()), DuffingVanDerPol::van_der_pol(0.45, 0.3).unwrap());
    check("van der Pol", 8, (&cycle, &closed("van der Pol", &cycle, 8, 0)), &solve(8, &problem(weaker)));
}
