//! Studies in parts: the table of a single run for any number of them, in any order, at once, interrupted, in one file or several.

use crate::common::*;
use expoly::models::Solved;
use expoly::study::{Case, OrderStudy, Sweep, SweepTable};
use expoly::{Closure, Error, Problem, Result};
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A file that is not there yet.
fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("parts");
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    let _ = fs::remove_file(&path);
    path
}

/// Ten numbers that cost nothing, in segments of 3, 3, 3 and 1.
const VALUES: [f64; 10] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

fn cheap<'a>(table: &Path) -> Sweep<'a> {
    Sweep::new("x", &VALUES, &["root", "from"]).segment(3).file(table)
}

fn root(x: f64, near: Option<&f64>) -> Result<(Vec<f64>, f64)> {
    Ok((vec![x.sqrt(), near.copied().unwrap_or(x)], x))
}

/// The table of a file that has all rows.
fn read(table: &Path) -> SweepTable {
    cheap(table).run(|x, _: Option<&()>| panic!("{x} is not there")).unwrap()
}

fn refused<T>(outcome: &Result<T>, path: &Path) -> bool {
    matches!(outcome, Err(Error::NotThisRun { path: named, .. }) if *named == path.display().to_string())
}

/// One behind another and at once, into one file; of eleven parts seven have nothing to do.
#[test]
fn any_number_of_parts_makes_the_rows_of_a_single_run() {
    let table = scratch("numbers.csv");
    let whole = cheap(&table).run(root).unwrap();
    for count in [2, 3, 11] {
        for at_once in [false, true] {
            fs::remove_file(&table).unwrap();
            let part = |k| cheap(&table).part(k, count).run(root).unwrap();
            if at_once {
                std::thread::scope(|scope| (1..=count).for_each(|k| drop(scope.spawn(move || part(k)))));
            } else {
                let missing: Vec<usize> = (1..=count).rev().map(|k| part(k).missing()).collect();
                assert!(missing.is_sorted_by(|a, b| a >= b) && missing.last() == Some(&0), "{missing:?}");
            }
            assert_eq!(read(&table), whole, "{count} parts");
        }
    }
    for (k, n) in [(0, 3), (4, 3), (1, 0)] {
        let outcome = cheap(&table).part(k, n).run(root);
        assert!(matches!(outcome, Err(Error::OutOfRange { name: "number of the part", .. })), "part {k} of {n}");
    }
}

/// Files one behind another are a file, and another number of parts computes only what is in none of them.
#[test]
fn parts_of_several_machines_are_merged_and_gone_on_with() {
    let (whole, solved) = (scratch("whole.csv"), AtomicUsize::new(0));
    let expected = cheap(&whole).run(root).unwrap();
    let of = |k: usize| scratch(&format!("machine-{k}.csv"));
    let (first, second, third) = (of(1), of(2), of(3));
    let stop = |_, _: &str| ControlFlow::Break(());
    let stopped = cheap(&first).part(1, 4).progress(stop).run(root).unwrap_err();
    assert!(matches!(stopped, Error::Cancelled { unit: "rows", .. }), "{stopped}");
    cheap(&second).part(2, 4).run(root).unwrap();
    cheap(&third).part(4, 4).run(root).unwrap();
    // Once more what two of them have, and a line that was cut off in the middle of a file.
    let [one, two, three] = [&first, &second, &third].map(|path| fs::read_to_string(path).unwrap());
    let merged = [one.as_str(), &two[..two.len() - 20], &three, &one].concat();
    fs::write(&whole, merged).unwrap();
    let counted = |x: f64, near: Option<&f64>| {
        solved.fetch_add(1, Ordering::Relaxed);
        root(x, near)
    };
    let missing = cheap(&whole).part(2, 3).run(root).unwrap().missing();
    assert_eq!(cheap(&whole).run(counted).unwrap(), expected);
    // The middles of segments that are not whole are made again as starts.
    assert!((missing..missing + 3).contains(&solved.load(Ordering::Relaxed)), "{missing}");
    assert_eq!(read(&whole), expected);
}

/// Wherever a file ends, the whole lines before count, and the rest is computed.
#[test]
fn a_file_that_was_cut_off_is_completed() {
    let table = scratch("cut.csv");
    let whole = cheap(&table).run(root).unwrap();
    let content = fs::read_to_string(&table).unwrap();
    for end in 0..content.len() {
        fs::write(&table, &content[..end]).unwrap();
        // A line is whole without the end that begins the next.
        let rows = content[..=end].matches('\n').count().saturating_sub(1);
        assert_eq!(cheap(&table).part(10, 10).run(root).unwrap().missing(), 10 - rows, "cut at {end}");
        assert_eq!(cheap(&table).run(root).unwrap(), whole, "cut at {end}");
        assert_eq!(read(&table), whole, "cut at {end}");
    }
}

/// What other settings have made, and what is no table, is refused and left as it is.
#[test]
fn files_that_do_not_belong_are_refused() {
    let (table, other) = (scratch("refused.csv"), "1 + 1 = 2\n");
    cheap(&table).run(root).unwrap();
    let content = fs::read_to_string(&table).unwrap();
    assert!(refused(&cheap(&table).settings("another wall").run(root), &table));
    // Other columns, another start of the same values, and another version's rows.
    assert!(refused(&Sweep::new("x", &VALUES, &["root", "by"]).segment(3).file(&table).run(root), &table));
    assert!(refused(&cheap(&table).segment(4).run(root), &table));
    let fingerprint = content.lines().last().and_then(|line| line.rsplit(',').next()).unwrap();
    let versions = [content.replacen(",settings", ",setting", 1), content.replace(fingerprint, "0123456789abcdef")];
    for content in [other, &versions[0], &versions[1]] {
        fs::write(&table, content).unwrap();
        assert!(refused(&cheap(&table).part(2, 3).run(root), &table), "{content}");
        assert_eq!(fs::read_to_string(&table).unwrap(), content);
    }
    // More values behind the last whole segment are those of the same sweep.
    fs::remove_file(&table).unwrap();
    Sweep::new("x", &VALUES[..6], &["root", "from"]).segment(3).file(&table).run(root).unwrap();
    assert_eq!(cheap(&table).part(1, 4).run(root).unwrap().missing(), 4);
}

#[test]
fn parts_of_a_study_of_orders_make_its_table() {
    let (table, truths, rows) = (scratch("orders.csv"), AtomicUsize::new(0), AtomicUsize::new(0));
    let case = |name: &str| {
        let truth = |_: &Problem| {
            truths.fetch_add(1, Ordering::Relaxed);
            duffing().exact()
        };
        Case::new(name, problem(duffing()), truth).method("classical", Closure::classical)
    };
    let study = |orders: &[u32]| {
        ["a, b", "c"].map(case).into_iter().fold(OrderStudy::new(orders), OrderStudy::case).file(&table)
    };
    for k in [3, 1, 2] {
        let mine = AtomicUsize::new(0);
        let count = |progress: expoly::Progress, row: &str| {
            let mine = mine.fetch_add(1, Ordering::Relaxed) as u64 + 1;
            assert!(row.starts_with(['"', 'c']) && rows.fetch_add(1, Ordering::Relaxed) < 6);
            // Two of six rows are those of a part, and those of others do not count.
            assert_eq!((progress.done, progress.total), (mine, 2));
            ControlFlow::Continue(())
        };
        study(&[2, 4, 6]).part(k, 3).progress(count).run().unwrap();
        // Rows of the highest order come first: those of both cases fall to two parts.
        assert!(truths.swap(0, Ordering::Relaxed) <= 2);
    }
    let found = study(&[2, 4, 6]).run().unwrap();
    let keys: Vec<(&str, u32)> = found.rows().iter().map(|row| (row.system.as_str(), row.order)).collect();
    assert_eq!(keys, [("a, b", 2), ("a, b", 4), ("a, b", 6), ("c", 2), ("c", 4), ("c", 6)]);
    assert_eq!((rows.into_inner(), truths.swap(0, Ordering::Relaxed)), (6, 0));
    // Another order is added to what is there.
    assert_eq!(study(&[4, 5]).part(1, 2).run().unwrap().rows().len(), 3);
    // A row of the same name, but of another problem.
    let other = Case::new("c", problem(van_der_pol()), |_: &Problem| duffing().exact());
    let other = other.method("classical", Closure::classical);
    assert!(refused(&OrderStudy::new(&[2]).case(other).file(&table).run(), &table));
}
