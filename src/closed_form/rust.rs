use super::formula::{CornerFormula, Formula};
use super::language::{Language, tuples};

/// Rust without dependencies, an f64 at a time.
const RUST: Language = Language {
    comment: "//",
    times: " * ",
    over: " / ",
    and: " && ",
    end: "    q\n",
    legendre: LEGENDRE,
    score: SCORE,
    walls: WALLS,
    line: "    z1.abs() <= reach[usize::from(z1 > 0.0)]\n",
    star: STAR,
    rows: ["[[", "], [", "]]"],
    number: |value| match value {
        f64::INFINITY => String::from("f64::INFINITY"),
        f64::NEG_INFINITY => String::from("f64::NEG_INFINITY"),
        _ => format!("{value:?}"),
    },
    power: |z, n| format!("{z}.powi({n})"),
    element: |p, n| format!("{p}[{n}]"),
    polynomials: |t, degree| format!("legendre::<{}>({t})", degree + 1),
    name: |name, value| format!("    let {name} = {value};\n"),
    begin: |value, _| format!("    let mut q = {value:?};\n"),
    add: |value| format!("    q += {value};\n"),
    function: |name, names, holds, body| {
        let parameters: Vec<String> = names.iter().map(|name| format!("{name}: f64")).collect();
        let kind = if holds { "bool" } else { "f64" };
        format!("pub fn {name}({}) -> {kind} {{\n{body}}}\n\n", parameters.join(", "))
    },
    within: |name, [low, high]| format!("({low}..={high}).contains(&{name})"),
    holds: |condition| format!("    {condition}\n"),
    necessary: |condition| format!("    if !{condition} {{\n        return false;\n    }}\n"),
    everywhere: |names| format!("    let _ = ({},);\n    true\n", names.join(", ")),
    ellipsoid: |names, spacing, farthest| {
        format!(
            "    let states = [{}];\n    let scores: Vec<f64> = knots.iter().zip(states).map(|(knots, x)| score(knots, x, \
             {spacing:?})).collect();\n    let distance = |row: &[f64; {}]| row.iter().zip(&scores).map(|(a, z)| a * \
             z).sum::<f64>().powi(2);\n    inverse.iter().map(distance).sum::<f64>() <= {farthest:?}\n",
            names.join(", "),
            names.len()
        )
    },
    boxes: |count| {
        let within = |i: usize| format!("(b[{}]..=b[{}]).contains(&state[{i}])", 2 * i, 2 * i + 1);
        let all = (0..count).map(within).collect::<Vec<_>>().join(" && ");
        format!("    boxes.iter().any(|b| {all})\n")
    },
    together: |names| format!("[{}]", names.join(", ")),
    wall,
    of_wall: |k, _, arguments| format!("    q += wall(&WALL_{k}, {arguments});\n"),
};

/// A module with `log_p`, `polynomial` and `inside`.
pub(super) fn text(formula: &Formula<'_>) -> String {
    let arguments = formula.names.join(", ");
    let log_p = format!("    if inside({arguments}) {{ polynomial({arguments}) }} else {{ f64::NEG_INFINITY }}\n");
    RUST.facts(formula) + "\n" + &RUST.module(formula, &log_p)
}

fn wall(k: usize, corner: &CornerFormula<'_>) -> String {
    let grazing = corner.grazing.map_or_else(
        || String::from("None"),
        |grazing| {
            let (exponent, scale) = (grazing.exponent, grazing.scale);
            let [limits, expansion] = [&grazing.limits[..], &grazing.expansion[..]].map(|list| RUST.list(list));
            let table = RUST.matrix(&grazing.table);
            format!(
                "Some(Grazing {{ exponent: {exponent:?}, scale: {scale:?}, limits: {limits}, expansion: &{expansion}, \
                 table: &{table} }})"
            )
        },
    );
    let &CornerFormula { offset, side, reach, kappa, .. } = corner;
    let (reach, kinks) = (RUST.list(&reach), tuples(corner));
    format!(
        "static WALL_{k}: Wall = Wall {{ offset: {offset:?}, side: {side:?}, reach: {reach}, kappa: {kappa:?}, kinks: \
         &[{kinks}], grazing: {grazing} }};\n\n"
    )
}

const LEGENDRE: &str = r"fn legendre<const K: usize>(t: f64) -> [f64; K] {
    let mut p = [1.0; K];
    p[1] = t;
    for k in 1..K - 1 {
        let n = k as f64;
        p[k + 1] = ((2.0 * n + 1.0) * t * p[k] - n * p[k - 1]) / (n + 1.0);
    }
    p
}

";

const STAR: &str = r"    let turn = (z2.atan2(z1) / std::f64::consts::TAU).rem_euclid(1.0) * 48.0;
    let k = (turn as usize).min(47);
    let past = turn - k as f64 - 0.5;
    let other = if past > 0.0 { k + 1 } else { k + 47 } % 48;
    (z1 * z1 + z2 * z2).sqrt() <= reach[k] * (1.0 - past.abs()) + reach[other] * past.abs()
";

const SCORE: &str = r"fn score(knots: &[f64], x: f64, spacing: f64) -> f64 {
    let piece = knots[1..knots.len() - 1].iter().filter(|knot| **knot <= x).count();
    let slope = (knots[piece + 1] - knots[piece]) / spacing;
    (piece as f64 - (knots.len() - 1) as f64 / 2.0) * spacing + (x - knots[piece]) / slope
}

";

const WALLS: &str = r"struct Wall {
    offset: f64,
    side: f64,
    reach: [f64; 2],
    kappa: f64,
    kinks: &'static [(i32, i32, i32, f64)],
    grazing: Option<Grazing>,
}

struct Grazing {
    exponent: f64,
    scale: f64,
    limits: [f64; 2],
    expansion: &'static [f64],
    table: &'static [[f64; 2]],
}

// u^g k(z), z = -w/(scale u)^(1/3): the similarity solution of grazing impacts, k'' = 3 z^2 k' - 9 g z k.
fn grazing(u: f64, w: f64, of: &Grazing) -> f64 {
    let g = of.exponent;
    let series = |c: &[f64], t: f64| c.iter().rev().fold(0.0, |sum, c| sum * t + c).ln();
    let u = u.max(if w.abs() < CLOSEST { f64::MIN_POSITIVE } else { 0.0 });
    let length = (of.scale * u).cbrt();
    let edge = STEPS as f64 / PER_UNIT as f64;
    if w.abs() > edge * length {
        let unit = of.scale / w.abs().powi(3);
        return -g * unit.ln() + of.limits[usize::from(w < 0.0)] + series(of.expansion, (unit * u).copysign(w));
    }
    let z = -w / length;
    let near = ((z + edge) * PER_UNIT as f64).round().clamp(0.0, 2.0 * STEPS as f64) as usize;
    let [log, slope] = of.table[near];
    let at = (near as f64 - STEPS as f64) / PER_UNIT as f64;
    let mut c = [1.0; TERMS];
    c[1] = slope;
    for k in 0..TERMS - 2 {
        let n = k as f64;
        let before = if k > 0 { (3.0 * (n - 1.0) - 9.0 * g) * c[k - 1] } else { 0.0 };
        let sum = 3.0 * at * at * (n + 1.0) * c[k + 1] + (6.0 * n - 9.0 * g) * at * c[k] + before;
        c[k + 2] = sum / ((n + 1.0) * (n + 2.0));
    }
    g * u.ln() + log + series(&c, z - at)
}

// What a wall adds: kinks A^p u^i w^j, A = (w^6 + (kappa u)^2)^(1/6), and the grazing impacts.
fn wall(of: &Wall, y: f64, v: f64) -> f64 {
    let (u, w) = (of.side * (y - of.offset), of.side * v);
    let (s, t) = (u.max(0.0) / of.reach[0], w / of.reach[1]);
    let a = (t.powi(6) + (of.kappa * s).powi(2) + TINY).powf(1.0 / 6.0);
    let kinks: f64 = of.kinks.iter().map(|(p, i, j, c)| c * a.powi(*p) * s.powi(*i) * t.powi(*j)).sum();
    kinks + of.grazing.as_ref().map_or(0.0, |of| grazing(u, w, of))
}

";
