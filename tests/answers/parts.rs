//! Studies in parts: the table of a single run for any number of them, in any order, at once, interrupted, and with files that are
//! damaged.

use crate::common::*;
use expoly::models::{DuffingVanDerPol, Solved};
use expoly::study::{Case, OrderStudy, Part, Sweep, SweepTable, merge};
use expoly::{Closure, ClosureDensity, Density, Error, Problem, Result};
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The file of a table in a folder of its own.
fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("parts").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder.join("table.csv")
}

/// The names and contents of all files beside a table.
fn files(table: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let paths = fs::read_dir(table.parent().unwrap()).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = paths.map(|path| (path.clone(), fs::read(path).unwrap())).collect();
    files.sort();
    files
}

/// Ten numbers that cost nothing, in segments of 3, 3, 3 and 1.
const VALUES: [f64; 10] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];

fn cheap<'a>(table: &Path) -> Sweep<'a> {
    Sweep::new("x", &VALUES, &["root", "from"]).segment(3).file(table)
}

fn root(x: f64, near: Option<&f64>) -> Result<(Vec<f64>, f64)> {
    Ok((vec![x.sqrt(), near.copied().unwrap_or(x)], x))
}

/// The bytes of the table of a single run, which is removed.
fn single(table: &Path) -> (SweepTable, Vec<u8>) {
    let whole = cheap(table).run(root).unwrap();
    let bytes = fs::read(table).unwrap();
    fs::remove_file(table).unwrap();
    (whole, bytes)
}

/// Every unit falls to one part, and where costs fall no part has more work than another by the costliest unit or more.
#[test]
fn parts_share_the_work() {
    let costs: Vec<f64> = (0..37).map(|k| 40.0 / f64::from(k + 3)).collect();
    for count in [1, 2, 3, 7, 36, 37, 50] {
        let parts: Vec<Part> = (1..=count).map(|k| Part::new(k, count).unwrap()).collect();
        for unit in 0..costs.len() {
            assert_eq!(parts.iter().filter(|part| part.holds(unit)).count(), 1);
        }
        let work = |part: &Part| (0..costs.len()).filter(|&unit| part.holds(unit)).map(|unit| costs[unit]).sum::<f64>();
        let [least, most] = [f64::min, f64::max].map(|pick| parts.iter().map(work).reduce(pick).unwrap());
        // Equal where a part has one unit and another none.
        assert!(most - least <= costs[0] && (count > 36 || most - least < costs[0]), "{count}: {least} to {most}");
    }
    for (k, n) in [(0, 3), (4, 3), (1, 0), (0, 0)] {
        assert_eq!(Part::new(k, n), Err(Error::NoSuchPart { part: k, parts: n }));
        let table = scratch("none");
        assert_eq!(cheap(&table).part(k, n).run(root), Err(Error::NoSuchPart { part: k, parts: n }));
        let study = OrderStudy::new(&[2]).case(duffings().remove(0)).part(k, n);
        assert!(matches!(study.run(), Err(Error::NoSuchPart { .. })));
        assert!(files(&table).is_empty());
    }
}

/// In any order and at once; of eleven parts seven have nothing to do, and leave no file.
#[test]
fn any_number_of_parts_makes_the_bytes_of_a_single_run() {
    let table = scratch("numbers");
    let (whole, bytes) = single(&table);
    for count in [1, 2, 3, 4, 11] {
        let part = |k| cheap(&table).part(k, count).run(root).unwrap();
        let merged = |how: &str| {
            assert_eq!(merge(&table), Ok(10), "{count} {how}");
            assert_eq!(files(&table), [(table.clone(), bytes.clone())], "{count} {how}");
            assert_eq!(cheap(&table).run(|_, _: Option<&()>| panic!("all is there")).unwrap(), whole);
            fs::remove_file(&table).unwrap();
        };
        // The last part begins when the rows of all others are there.
        let tables: Vec<SweepTable> = (1..=count).rev().map(part).collect();
        assert_eq!(tables.last(), Some(&whole));
        assert!(tables.windows(2).all(|pair| pair[1].missing() <= pair[0].missing()));
        assert!(tables.iter().all(|table| table.rows().len() + table.missing() == VALUES.len()));
        assert_eq!(files(&table).len(), count.min(4));
        merged("backwards");
        std::thread::scope(|scope| (1..=count).for_each(|k| drop(scope.spawn(move || part(k)))));
        merged("at once");
    }
    // A run without parts is the merging as well, and a merged table is merged again to itself.
    cheap(&table).part(2, 3).run(root).unwrap();
    assert_eq!(cheap(&table).run(root).unwrap(), whole);
    assert_eq!((merge(&table), files(&table)), (Ok(10), vec![(table.clone(), bytes)]));
}

/// Closures that start from one another have the same bits in parts: a segment is never cut.
#[test]
fn closures_in_parts_have_the_bits_of_a_single_run() {
    let table = scratch("closures");
    let square = |alpha: f64, near: Option<&ClosureDensity>| {
        let problem = Problem::of(DuffingVanDerPol::new([alpha, 1.0], 1.0, 0.0, 0.2)?)?;
        let density = Closure::new(4).starting_from(near).solve(&problem)?;
        Ok((vec![density.moment(&[2, 0])?.value, density.l1_estimate()], density))
    };
    let sweep = || Sweep::new("alpha", &[0.2, 0.15, 0.1, 0.05, 0.0], &["E x^2", "L1"]).segment(2).file(&table);
    let whole = sweep().run(square).unwrap();
    let bytes = fs::read(&table).unwrap();
    fs::remove_file(&table).unwrap();
    for k in [2, 3, 1] {
        sweep().part(k, 3).run(square).unwrap();
    }
    assert_eq!(merge(&table), Ok(5));
    assert_eq!(fs::read(&table).unwrap(), bytes);
    assert_eq!(sweep().run(square).unwrap(), whole);
}

/// A solved oscillator by two methods, and another by one.
fn duffings<'a>() -> Vec<Case<'a>> {
    let robust = Case::new("Duffing", problem(duffing()), |_| duffing().exact())
        .method("robust", |problem, n| Closure::new(n).solve(problem));
    let both = robust.method("classical", |problem, n| Closure::classical(n).solve(problem));
    let line = Case::new("Duffing, again", problem(duffing()), |_| duffing().exact())
        .method("classical", |problem, n| Closure::classical(n).solve(problem));
    vec![both, line]
}

/// A table of orders without what depends on the clock: the seconds, and the checksum, which covers them.
fn timeless(table: &Path) -> String {
    let content = fs::read_to_string(table).unwrap();
    let (heading, rows) = content.split_at(content.match_indices('\n').nth(1).unwrap().0);
    let timeless = |row: &str| row.rsplitn(3, ',').last().map(str::to_owned);
    heading.to_owned() + &rows.lines().filter_map(timeless).collect::<Vec<_>>().join("\n")
}

#[test]
fn parts_of_a_study_of_orders_make_its_table() {
    let (table, truths) = (scratch("orders"), AtomicUsize::new(0));
    let study = || duffings().into_iter().fold(OrderStudy::new(&[2, 4]), OrderStudy::case).file(&table);
    let whole = study().run().unwrap();
    let expected = timeless(&table);
    assert_eq!((whole.rows().len(), whole.missing(), expected.lines().count()), (6, 0, 8));
    let rows = AtomicUsize::new(0);
    for at_once in [false, true] {
        fs::remove_file(&table).unwrap();
        rows.store(0, Ordering::Relaxed);
        let part = |k: usize| {
            let mine = AtomicUsize::new(0);
            let count = |progress: expoly::Progress, _: &str| {
                rows.fetch_add(1, Ordering::Relaxed);
                let mine = mine.fetch_add(1, Ordering::Relaxed) as u64 + 1;
                // Two of six rows are those of a part, and those of others do not count.
                assert_eq!((progress.done, progress.total), (mine, 2));
                ControlFlow::Continue(())
            };
            study().part(k, 3).progress(count).run().unwrap();
        };
        if at_once {
            std::thread::scope(|scope| (1..=3).for_each(|k| drop(scope.spawn(move || part(k)))));
        } else {
            [3, 1, 2].into_iter().for_each(part);
        }
        assert_eq!(files(&table).len(), 3);
        assert_eq!((merge(&table), rows.load(Ordering::Relaxed)), (Ok(6), 6));
        assert_eq!(timeless(&table), expected);
    }
    // A part makes no truth of a problem of which it has no row to compute.
    fs::remove_file(&table).unwrap();
    let counted = |name: &str| {
        let truth = |_: &Problem| {
            truths.fetch_add(1, Ordering::Relaxed);
            duffing().exact()
        };
        Case::new(name, problem(duffing()), truth)
            .method("classical", |problem, n| Closure::classical(n).solve(problem))
    };
    let two = || ["a", "b"].map(counted).into_iter().fold(OrderStudy::new(&[2]), OrderStudy::case).file(&table);
    for expected in [1, 1] {
        assert_eq!(two().part(2, 2).run().unwrap().rows()[0].system, "b");
        assert_eq!(truths.load(Ordering::Relaxed), expected);
    }
}

/// A study that was interrupted in some parts goes on in another number of them, and no row is computed twice.
#[test]
fn another_number_of_parts_computes_only_what_is_missing() {
    let (table, solved) = (scratch("resumed"), AtomicUsize::new(0));
    let (whole, bytes) = single(&table);
    let counted = |x: f64, near: Option<&f64>| {
        if near.is_some() || (x * 10.0).round() as usize % 3 != 1 {
            solved.fetch_add(1, Ordering::Relaxed);
        }
        root(x, near)
    };
    // A part that is stopped after a row, one that has ended, and one of another number of parts.
    let stop = |_, _: &str| ControlFlow::Break(());
    let stopped = cheap(&table).part(1, 4).progress(stop).run(root).unwrap_err();
    assert!(matches!(stopped, Error::StudyCancelled { rows: 3, .. }), "{stopped}");
    cheap(&table).part(2, 4).run(root).unwrap();
    let left = cheap(&table).part(2, 2).run(root).unwrap().missing();
    assert_eq!(left, 3, "rows 0 and 2, of the first segment, and the last");
    assert_eq!(merge(&table), Err(Error::MissingRows { path: table.display().to_string(), missing: left, rows: 10 }));
    for k in 1..=3 {
        cheap(&table).part(k, 3).run(counted).unwrap();
    }
    // The segment's middle, which was there, has been made again as a start, and is not counted.
    assert_eq!(solved.load(Ordering::Relaxed), left);
    assert_eq!((merge(&table), fs::read(&table).unwrap()), (Ok(10), bytes));
    assert_eq!(cheap(&table).run(root).unwrap(), whole);
}

/// Wherever the file of a part ends, what is before its last whole line counts, and the part goes on from there.
#[test]
fn a_part_that_was_cut_off_is_completed() {
    let table = scratch("cut");
    let (_, bytes) = single(&table);
    let run = |k| cheap(&table).part(k, 2).run(root).unwrap();
    let of = |k| Part::new(k, 2).unwrap().file(&table);
    run(1);
    run(2);
    let [first, second] = [1, 2].map(|k| fs::read(of(k)).unwrap());
    let lines = |content: &[u8]| content.iter().filter(|byte| **byte == b'\n').count();
    for end in 0..second.len() {
        fs::write(of(1), &first).unwrap();
        fs::write(of(2), &second[..end]).unwrap();
        let missing = lines(&second) - lines(&second[..end]).max(2);
        let path = table.display().to_string();
        assert_eq!(merge(&table), Err(Error::MissingRows { path, missing, rows: 10 }), "cut at {end}");
        assert_eq!(files(&table), [(of(1), first.clone()), (of(2), second[..end].to_vec())], "cut at {end}");
        if end % 7 == 0 {
            run(2);
            assert_eq!(merge(&table), Ok(10), "cut at {end}");
            assert_eq!(files(&table), [(table.clone(), bytes.clone())]);
            fs::remove_file(&table).unwrap();
        }
    }
}

/// What belongs to another study, or was altered, is refused by runs and by the merging, and nothing is changed.
#[test]
fn files_that_do_not_belong_are_refused() {
    let table = scratch("refused");
    let none = |path: &Path| Err(Error::NotAStudy { path: path.display().to_string() });
    assert_eq!(merge(&table), none(&table));
    assert_eq!(merge(table.join("below")), none(&table.join("below")));
    assert_eq!(
        merge(table.with_file_name("no").join("table.csv")),
        none(&table.with_file_name("no").join("table.csv"))
    );
    cheap(&table).part(1, 2).run(root).unwrap();
    let of = |k| Part::new(k, 2).unwrap().file(&table);
    let sound = fs::read_to_string(of(1)).unwrap();
    let refused = |what: &str, expected: &Error| {
        let before = files(&table);
        assert_eq!(merge(&table).as_ref(), Err(expected), "{what}");
        for (k, n) in [(1, 2), (2, 2), (1, 3), (1, 1)] {
            assert_eq!(cheap(&table).part(k, n).run(root).as_ref(), Err(expected), "{what}: {k}/{n}");
        }
        assert_eq!(files(&table), before, "{what}");
    };
    // The rows of other settings: the same table of another number of rows, and of other columns.
    for other in [
        Sweep::new("x", &VALUES, &["root", "from"]).segment(3).settings("another wall"),
        Sweep::new("x", &VALUES[1..], &["root", "from"]).segment(3),
        Sweep::new("x", &VALUES, &["root", "by"]).segment(3),
    ] {
        let elsewhere = scratch("elsewhere");
        other.file(&elsewhere).part(2, 2).run(root).unwrap();
        fs::copy(Part::new(2, 2).unwrap().file(&elsewhere), of(2)).unwrap();
        refused("other settings", &Error::OtherStudy { path: of(2).display().to_string() });
    }
    fs::write(of(2), "something else\n").unwrap();
    refused("another file", &Error::OtherStudy { path: of(2).display().to_string() });
    // A row that is in one file twice is spoiled; in two files, where two runs computed it at once, it is not.
    fs::write(of(2), sound.clone() + sound.lines().last().unwrap() + "\n").unwrap();
    let spoiled = |row, problem| Error::SpoiledStudy { path: of(2).display().to_string(), row, problem };
    refused("twice", &spoiled(sound.lines().count() - 2, "it is there twice"));
    let last = sound.lines().last().unwrap();
    fs::write(of(2), sound.replace(last, &last.replacen('.', ".1", 1))).unwrap();
    refused("altered", &spoiled(sound.lines().count() - 3, "it does not agree with its checksum, so it was altered"));
    fs::write(of(2), &sound).unwrap();
    assert!(matches!(merge(&table), Err(Error::MissingRows { .. })));
    cheap(&table).part(2, 2).run(root).unwrap();
    assert_eq!(merge(&table), Ok(10));
    // Names that look like a part's, and a heading that promises more rows than there can be.
    for end in ["part-0-of-2", "part-3-of-2", "part-01-of-2", "part-1-of-1", "part-1-of-2.csv", "part-x-of-y", "part-1"]
    {
        fs::write(table.with_file_name(format!("table.csv.{end}")), "no part").unwrap();
    }
    assert_eq!(merge(&table), Ok(10));
    let heading = |rows: &str| sound.replacen("of 10 rows", &format!("of {rows} rows"), 1);
    fs::write(&table, heading("18446744073709551615")).unwrap();
    let missing = usize::MAX - sound.lines().count() + 2;
    let path = table.display().to_string();
    assert_eq!(merge(&table), Err(Error::MissingRows { path, missing, rows: usize::MAX }));
    for text in ["", "# expoly 1 study 0 of 1 rows\n", "# expoly 1 study 0 of 1 rows\nrow\n", &heading("-1"), "\n\n\n"]
    {
        fs::write(&table, text).unwrap();
        assert_eq!(merge(&table), none(&table), "{text:?}");
    }
}
