//! Densities outside the program: texts that other languages run, and JSON that loads to the same bits.

use crate::common::*;
use expoly::models::Solved;
use expoly::{ClosedForm, Closure, ClosureDensity, Crossing, Density, Drift, Error, Estimate, Scalar};
use serde_json::Value;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// x″ + 0.2 x′ + 0.1 x′³ + x + 0.3 x³ − 3 = ξ: far from the origin, so that powers of the states cancel.
struct Loaded;

impl Drift<2, 1> for Loaded {
    fn drift<S: Scalar>(&self, [x, v]: [S; 2]) -> [S; 2] {
        [v, -(x.powi(3) * 0.3 + x - 3.0) - v * 0.2 - v.powi(3) * 0.1]
    }
    fn noise<S: Scalar>(&self, _: [S; 2]) -> [[S; 1]; 2] {
        [[S::from(0.0)], [S::from(0.6)]]
    }
}

/// The densities that are written out: polynomials of a low and of a high order, an exact density, one above a wall, and four
/// states. The texts use `k` and `reach` themselves, for other things.
fn forms() -> &'static [(&'static str, ClosedForm)] {
    static FORMS: OnceLock<Vec<(&'static str, ClosedForm)>> = OnceLock::new();
    FORMS.get_or_init(solved)
}

fn solved() -> Vec<(&'static str, ClosedForm)> {
    let names = ["x", "v"];
    let low = ClosureDensity::clone(&closed("van der Pol", &problem(van_der_pol()), 8, 0));
    let wall = ClosureDensity::clone(&closed_above(4, -0.5, 0.9));
    let chain = ClosureDensity::clone(&closed_chain());
    let forms = [
        ("low", ClosedForm::new(low, &names)),
        ("high", ClosedForm::new(Closure::new(14).solve(&problem(Loaded)).unwrap(), &names)),
        ("exact", ClosedForm::new(three_wells().exact_above(-1.2).unwrap(), &names)),
        ("wall", ClosedForm::new(wall, &["k", "reach"])),
        ("four", ClosedForm::new(chain, &["x1", "x2", "v1", "v2"])),
    ];
    forms.map(|(name, form)| (name, form.unwrap())).into()
}

/// A thousand states in the box around the domain.
fn points(form: &ClosedForm) -> Vec<Vec<f64>> {
    let bounds = if form.closure().is_some() { form.bounds() } else { vec![[-2.0, 2.0]; form.dimension()] };
    let mut source = Points::new(7);
    let mut place = |[low, high]: &[f64; 2]| low + (high - low) * (source.next() + 1.0) / 2.0;
    (0..1000).map(|_| bounds.iter().map(&mut place).collect()).collect()
}

/// One state a line, in digits that keep every bit.
fn lines(points: &[Vec<f64>]) -> String {
    let line = |x: &Vec<f64>| x.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ") + "\n";
    points.iter().map(line).collect()
}

/// Compares the numbers printed with ln p at the points, or at the first hundred. The sums are of up to 150 terms, of a
/// size that the form has been chosen by to lose 1e-13 at most, relative to ln p or 1; logarithms and powers of another
/// library's making lose some 1e-15 each.
fn agree(form: &ClosedForm, printed: &[&str], what: &str) {
    let values: Vec<f64> = printed.iter().map(|line| line.trim().parse().unwrap()).collect();
    assert!([100, 1000].contains(&values.len()), "{what}: {printed:?}");
    let mut worst = 0.0_f64;
    let mut inside = 0;
    for (x, value) in points(form).iter().zip(&values) {
        let truth = form.log_pdf(x).unwrap();
        if truth == f64::NEG_INFINITY {
            assert_eq!(*value, truth, "{what} at {x:?}");
            continue;
        }
        inside += 1;
        worst = worst.max((value - truth).abs() / truth.abs().max(1.0));
    }
    println!("{what}: {inside} states inside, largest difference {worst:.1e}");
    let some = inside > values.len() / 6 && (inside < values.len() || form.dimension() > 2);
    assert!(worst < 1e-12 && some, "{what}: {worst:e}, {inside} of {}", values.len());
}

fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("closed_form").join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn succeeded(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Runs a program in a folder, if there is such a program.
fn run(program: &str, arguments: &[&str], folder: &Path) -> Option<String> {
    match Command::new(program).args(arguments).current_dir(folder).output() {
        Ok(output) => Some(succeeded(&output)),
        Err(error) => {
            // Past the test's own output, which is shown of failures alone.
            let _ = writeln!(std::io::stderr(), "SKIPPED: {program} does not run here, {error}");
            None
        }
    }
}

fn check_python(folder: &Path, name: &str, form: &ClosedForm) {
    const DRIVER: &str = "import sys\nimport importlib\nlog_p = importlib.import_module(sys.argv[1]).log_p\n\
        for line in open(sys.argv[2]):\n    print(repr(log_p(*map(float, line.split()))))\n";
    std::fs::write(folder.join("driver.py"), DRIVER).unwrap();
    std::fs::write(folder.join(format!("{name}.py")), form.python().unwrap()).unwrap();
    if let Some(printed) = run("python3", &["driver.py", name, &format!("{name}.txt")], folder) {
        agree(form, &printed.lines().collect::<Vec<_>>(), &format!("{name}, Python"));
    }
}

/// MATLAB's text in Octave, which reads the same language: all points in one column, in a matrix, and some one by one.
fn check_octave(folder: &Path, name: &str, form: &ClosedForm) {
    const DRIVER: &str = "x = num2cell(load('points.txt'), 1);\n\
        column = log_p(x{:});\n\
        square = cellfun(@(x) reshape(x, 20, 50), x, 'UniformOutput', false);\n\
        matrix = log_p(square{:});\n\
        assert(size(column), [1000, 1]);\n\
        assert(size(matrix), [20, 50]);\n\
        few = cellfun(@(x) x(1:100), x, 'UniformOutput', false);\n\
        single = arrayfun(@(varargin) log_p(varargin{:}), few{:});\n\
        printf('%.17g\\n', column, matrix, single);\n";
    // A function is found by the name of its file.
    let folder = folder.join(name);
    std::fs::create_dir_all(&folder).unwrap();
    for (file, text) in [("log_p.m", form.matlab().unwrap()), ("points.txt", lines(&points(form)))] {
        std::fs::write(folder.join(file), text).unwrap();
    }
    let arguments = ["--norc", "--quiet", "--eval", DRIVER];
    if let Some(printed) = run("octave-cli", &arguments, &folder).or_else(|| run("octave", &arguments, &folder)) {
        let values: Vec<&str> = printed.lines().collect();
        assert_eq!(values.len(), 2100, "{printed}");
        for (values, shape) in values.chunks(1000).zip(["a column", "a matrix", "one by one"]) {
            agree(form, values, &format!("{name}, Octave, {shape}"));
        }
    }
}

/// Every language computes ln p as this library does, in two states and in four, above a wall and without.
#[test]
fn other_languages_have_the_same_logarithm() {
    let folder = scratch("languages");
    let forms = forms();
    for (name, form) in forms {
        std::fs::write(folder.join(format!("{name}.txt")), lines(&points(form))).unwrap();
        check_python(&folder, name, form);
        check_octave(&folder, name, form);
    }
    // The high order far from the origin is not in powers of the states, which would lose nine digits there.
    let (low, high) = (&forms[0].1, &forms[1].1);
    assert!(low.python().unwrap().contains("*(x**2*v**2)") && high.python().unwrap().contains("legendre("));
    let words = ["Trust domain", "order 14", "Trust domain: x >= -1.2", "Trust domain"];
    for ((_, form), word) in forms.iter().zip(words) {
        for text in [form.python(), form.matlab()] {
            let text = text.unwrap();
            assert!(text.contains(word) && text.is_ascii() && !text.contains("NaN"), "{word}");
        }
    }
    let latex = low.latex(&["x", r"\dot x"]).unwrap();
    assert!(latex.contains(r"\ln p(x, \dot x) = - ") && latex.contains(r"\le \dot x \le"), "{latex}");
    assert!(matches!(forms[3].1.latex(&["y", r"\dot y"]), Err(Error::NotKnown { .. })));
}

fn bits(estimate: Estimate) -> [u64; 2] {
    [estimate.value, estimate.error].map(f64::to_bits)
}

/// The values of a loaded density, bit for bit.
fn same_bits(form: &ClosedForm) {
    let text = form.to_json().unwrap();
    let again = ClosedForm::from_json(&text).unwrap();
    assert_eq!(again.names(), form.names());
    let both = [form, &again];
    for x in points(form).iter().take(100) {
        let [p, q] = both.map(|form| (bits(form.pdf(x).unwrap()), form.log_pdf(x).unwrap().to_bits()));
        assert_eq!(p, q, "{x:?}");
    }
    let states = form.dimension();
    let unit = |i: usize, power: u32| (0..states).map(|j| if i == j { power } else { 0 }).collect::<Vec<_>>();
    for powers in [unit(0, 1), unit(states - 1, 4), vec![1; states]] {
        let [p, q] = both.map(|form| bits(form.moment(&powers).unwrap()));
        assert_eq!(p, q, "{powers:?}");
    }
    let [p, q] = both.map(|form| bits(form.variance(0).unwrap()));
    assert_eq!(p, q);
    let [p, q] = both.map(|form| bits(form.marginal(0, 0.7).unwrap()));
    assert_eq!(p, q);
    let crossing = Crossing { velocity: states / 2, ..Crossing::upward(0.3) };
    let [p, q] = both.map(|form| bits(form.flux(crossing, 1).unwrap()));
    assert_eq!(p, q);
    match (form.closure(), again.closure()) {
        (Some(p), Some(q)) => {
            let [a, b] = [p, q].map(|d| d.coefficients().iter().map(|c| c.to_bits()).collect::<Vec<_>>());
            assert_eq!(a, b);
            assert_eq!((p.provenance(), p.bounds()), (q.provenance(), q.bounds()));
            assert_eq!((p.l1_estimate(), p.warning()), (q.l1_estimate(), q.warning()));
            assert_eq!(format!("{:?}", p.candidates()), format!("{:?}", q.candidates()));
            assert_eq!(
                (p.log_polynomial(), p.truncated_mass().to_bits()),
                (q.log_polynomial(), q.truncated_mass().to_bits())
            );
        }
        kinds => {
            assert!(kinds.0.is_none() && kinds.1.is_none());
            let [p, q] = both.map(|form| form.exp_polynomial().unwrap());
            assert_eq!((p.log_polynomial(), bits(p.log_mass())), (q.log_polynomial(), bits(q.log_mass())));
        }
    }
    assert_eq!(again.to_json().unwrap(), text);
}

#[test]
fn json_comes_back_to_the_same_bits() {
    forms().iter().for_each(|(_, form)| same_bits(form));
    let form = ClosedForm::new(Closure::new(4).solve(&problem(OrnsteinUhlenbeck)).unwrap(), &["x"]).unwrap();
    let path = scratch("files").join("density.json");
    form.save(&path).unwrap();
    assert_eq!(ClosedForm::load(&path).unwrap().to_json().unwrap(), form.to_json().unwrap());
    // Threads that save to one path: the file is whole, whichever thread was last.
    std::thread::scope(|scope| {
        let save = || (0..20).for_each(|_| form.save(&path).unwrap());
        let threads = [0, 1, 2].map(|_| scope.spawn(save));
        threads.into_iter().for_each(|thread| thread.join().unwrap());
    });
    assert_eq!(ClosedForm::load(&path).unwrap().to_json().unwrap(), form.to_json().unwrap());
    let missing = ClosedForm::load(path.with_file_name("none.json")).unwrap_err();
    assert!(matches!(missing, Error::File { action: "read", .. }), "{missing}");
}

/// The text with a checksum that fits it, as after a deliberate change.
fn signed(text: &str) -> String {
    // A text that is no JSON has no checksum that fits.
    let Ok(mut document) = serde_json::from_str::<Value>(text) else { return text.to_owned() };
    let bytes = serde_json::to_vec(&(&document["states"], &document["density"])).unwrap();
    let sum = bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325_u64, |sum, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
    document["checksum"] = format!("{sum:016x}").into();
    document.to_string()
}

#[test]
fn a_corrupt_document_is_refused_by_name() {
    let problem = |text: &str| match ClosedForm::from_json(text) {
        Err(Error::NotAClosedForm { problem }) => problem,
        other => panic!("{other:?} from {}", &text[..text.len().min(300)]),
    };
    let closure = Closure::new(2).solve(&duffing_above(0.0, 0.9)).unwrap();
    let closure = ClosedForm::new(closure, &["x", "v"]).unwrap();
    let exact = ClosedForm::new(linear().exact().unwrap(), &["x", "v"]).unwrap();
    let (text, exact) = (closure.to_json().unwrap(), exact.to_json().unwrap());
    let [again, same] = [signed(&text), text.clone()].map(|text| serde_json::from_str::<Value>(&text).unwrap());
    assert_eq!(again, same);

    for end in (0..text.len()).step_by(text.len() / 60) {
        problem(&text[..end]);
    }
    // A changed digit is found by the checksum, in every entry.
    let digits: Vec<usize> = text.match_indices("0.1").map(|(at, _)| at + 2).filter(|at| *at > 100).collect();
    assert!(digits.len() > 40);
    for at in digits.iter().step_by(digits.len() / 40) {
        let altered = format!("{}7{}", &text[..*at], &text[at + 1..]);
        assert!(problem(&altered).contains("altered"), "{}", problem(&altered));
    }
    for (from, to, said) in [
        ("expoly closed form", "something else", "format"),
        ("\"version\":3", "\"version\":4", "version 4"),
        ("\"states\":[\"x\",\"v\"]", "\"states\":[\"x\"]", "1 states"),
        ("\"states\":[\"x\",\"v\"]", "\"states\":[\"x\",\"x\"]", "another state"),
        ("\"states\":[\"x\",\"v\"]", "\"states\":[\"x\",\"1\"]", "letter"),
        ("\"accepted\":true", "\"accepted\":true,\"extra\":1", "extra"),
        ("\"accepted\":true", "\"accepted\":7", "boolean"),
        ("\"walls\":[0.0,null]", "\"walls\":[0.0]", "invalid length 1"),
        ("\"restitution\":0.9", "\"restitution\":9.0", "restitution"),
        ("\"restitution\":0.9", "\"restitution\":-0.9", "restitution"),
        ("\"reach\":[", "\"reach\":[1.0,", "trust domain reaches"),
        ("\"coefficients\":[", "\"coefficients\":[1.0,", "coefficients for"),
        ("\"exponents\":[[1,0]", "\"exponents\":[[1,99]", "99"),
        ("\"exponents\":[[1,0]", "\"exponents\":[[1]", "exponents [1]"),
        ("\"kinks\":[0,[[1,", "\"kinks\":[0,[[-2147483648,", "none of a kink"),
        ("\"kinks\":[0,", "\"kinks\":[7,", "no wall 7"),
        ("\"constant\":", "\"constant\":1e999,\"was\":", "number out of range"),
        ("\"half_width\":[", "\"half_width\":[-1.0,", "half width"),
        ("\"nodes\":[", "\"nodes\":[0.5,", "no rule"),
        ("{\"panels\":", "{\"draws\":", "unknown field"),
        ("\"candidates\":[{", "\"candidates\":[],\"unknown\":[{", "unknown"),
    ] {
        assert!(text.contains(from), "{from}");
        let found = problem(&signed(&text.replacen(from, to, 1)));
        assert!(found.contains(said), "{to}: {found}");
    }
    for (from, to, said) in [
        ("\"origin\":[", "\"origin\":[0.0,", "3 rows"),
        ("\"scale\":[[", "\"scale\":[[-", "triangle"),
        ("\"terms\":[[[", "\"terms\":[[[3,0],1.0],[[", "normalised"),
        ("\"support\":\"whole_space\"", "\"support\":{\"region\":[[1.0,0.0],[0.0,1.0]]}", "side of a region"),
        ("\"support\":\"whole_space\"", "\"support\":{\"region\":[[0.0,1.0]]}", "limits of a region"),
        ("\"support\":\"whole_space\"", "\"support\":\"elsewhere\"", "elsewhere"),
    ] {
        assert!(exact.contains(from), "{from}: {exact}");
        let found = problem(&signed(&exact.replacen(from, to, 1)));
        assert!(found.contains(said), "{to}: {found}");
    }
    assert!(problem("[1, 2, 3]").contains("invalid type"));
    problem(&"[".repeat(100_000));
    let one = ClosedForm::from_json(&signed(&text.replacen("[\"x\",\"v\"]", "[\"x\"]", 1))).unwrap_err().to_string();
    assert!(one.contains("1 states") && one.contains("restore"), "{one}");
    // Names are as many as states.
    let few = ClosedForm::new(linear().exact().unwrap(), &["x"]);
    assert!(matches!(few, Err(Error::Dimension { expected: 2, found: 1, .. })), "{few:?}");
    for name in ["", "2x", "x y", "lambda", "None", "otherwise", "size", "z1", "WALL_0", "ẋ"] {
        let refused = ClosedForm::new(linear().exact().unwrap(), &[name, "v"]);
        assert!(matches!(refused, Err(Error::NotAName { .. })), "{name}");
    }
}
