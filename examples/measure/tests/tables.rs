//! The tables of the campaigns that are kept give the numbers that the guide prints.

#![allow(clippy::unwrap_used, reason = "a value that is missing should fail the test")]

use std::path::Path;
use std::process::Command;

/// What a campaign prints of a table that is complete, so that nothing is solved.
fn summary(arguments: &[&str]) -> String {
    let tables = Path::new(env!("CARGO_MANIFEST_DIR")).join("tables");
    let mut program = Command::new(env!("CARGO_BIN_EXE_expoly-measure"));
    let output = program.arg("campaign").args(arguments).arg("--out").arg(tables).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The text that follows a phrase in each line that has it.
fn after<'a>(text: &'a str, phrase: &'a str) -> impl Iterator<Item = &'a str> {
    text.lines().filter_map(move |line| Some(line.split_once(phrase)?.1.trim()))
}

/// The first whole numbers of a text.
fn numbers<const N: usize>(text: &str) -> [usize; N] {
    let found: Vec<usize> = text.split_whitespace().filter_map(|word| word.parse().ok()).take(N).collect();
    found.try_into().unwrap()
}

/// Densities without a warning that kept what they promised, and those that did or could not be judged.
fn kept(summary: &str) -> [usize; 2] {
    let mut sums = [0; 2];
    for line in after(summary, "within 3 estimates or 1e-4:") {
        let ([kept, judged], [unjudged]) = (numbers(line), numbers(line.split_once("not judged").unwrap().1));
        sums = [sums[0] + kept, sums[1] + judged + unjudged];
    }
    sums
}

#[test]
fn the_guide_prints_what_the_tables_hold() {
    let page =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../src/guide/accuracy.md")).unwrap();
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let says = |phrase: String| assert!(page.contains(&phrase), "the page should have: {phrase}");

    let plane = summary(&[]);
    let [unknown] = numbers(after(&plane, "truth unknown:").next().unwrap());
    says(format!("Of 500 ({unknown} of them the grid did not resolve when the tables were made)"));
    let wrong: usize = after(&plane, "off by 10 % without a warning:").map(|line| numbers::<1>(line)[0]).sum();
    assert_eq!(wrong, 0, "none off by a tenth is what the page says");
    let [sound, plain] = kept(&plane);
    says(format!("of {plain} densities without a warning {sound} were within three times their estimate"));

    let mut estimated = [0; 2];
    for line in after(&plane, "or the estimate below 1e-4:") {
        let [right, all] = numbers(line);
        estimated = [estimated[0] + right, estimated[1] + all];
    }
    says(format!("or below 1e-4, for {} of {}", estimated[0], estimated[1]));

    let [sound, plain] = kept(&summary(&["--walls"]));
    says(format!("{sound} of {plain} at n = 8 above random walls"));

    let grid = summary(&["--grid"]);
    let [reached, answered] = numbers(after(&grid, "estimate at most 1e-6:").next().unwrap());
    let [right] = numbers(after(&grid, "estimate over distance from 1 to 12:").next().unwrap());
    assert_eq!(answered, 500, "none refused is what the page says");
    says(format!(
        "reaches 1e-6 for {reached}, and its estimate is 1 to 12 times the distance from a finer solution for {right}"
    ));

    let few = summary(&["--exact", "--few", "--orders", "4"]);
    let [densities, warned] = numbers(&after(&few, "n = 4:").last().unwrap().replace(',', " "));
    says(format!("{warned} of {densities} a warning"));
    let [right, plain] = numbers(after(&few, "within a factor 1.5:").next().unwrap().split_once("3:").unwrap().1);
    says(format!("within a factor 3 of the distance for {right} of {plain}"));

    let known = summary(&["--known"]);
    let first = |phrase| numbers::<1>(after(&known, phrase).next().unwrap())[0];
    assert_eq!([first("n = 4:"), first("without a density:")], [300, 0], "all have a density is what the page says");
    let [warned, exact] = ["with a warning:", "estimate at most 1e-4:"].map(first);
    says(format!("{warned} with a warning, {exact} exact"));
    says(format!("within three of their errors for {}", first("mean squares within 3 errors:")));
}
