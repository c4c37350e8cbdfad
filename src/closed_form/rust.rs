use super::formula::{Coordinates, CornerFormula, Domain, Formula};
use super::notation::{Notation, tuples, with_numbers};

const NOTATION: Notation = Notation {
    times: " * ",
    over: " / ",
    number: |value| match value {
        f64::INFINITY => String::from("f64::INFINITY"),
        f64::NEG_INFINITY => String::from("f64::NEG_INFINITY"),
        _ => format!("{value:?}"),
    },
    power: |z, n| format!("{z}.powi({n})"),
    element: |p, n| format!("{p}[{n}]"),
    legendre: |t, degree| format!("legendre::<{}>({t})", degree + 1),
    name: |name, value| format!("    let {name} = {value};\n"),
    begin: |value, _| format!("    let mut q = {value:?};\n"),
    add: |value| format!("    q += {value};\n"),
};

/// A module with `log_p`, `polynomial` and `inside`.
pub(super) fn text(formula: &Formula) -> String {
    let parameters: Vec<String> = formula.names.iter().map(|name| format!("{name}: f64")).collect();
    let (arguments, parameters) = (formula.names.join(", "), parameters.join(", "));
    let mut text: String = formula.facts.iter().map(|fact| format!("// {fact}\n")).collect();
    text += "\n";
    if matches!(formula.coordinates, Coordinates::Legendre { .. }) {
        text += LEGENDRE;
    }
    if !formula.corners.is_empty() {
        text += &with_numbers(WALLS);
        formula.corners.iter().enumerate().for_each(|(k, corner)| text += &wall(k, corner));
    }
    text += &format!("pub fn polynomial({parameters}) -> f64 {{\n");
    text += &NOTATION.polynomial(formula);
    for k in 0..formula.corners.len() {
        text += &(NOTATION.add)(&format!("wall(&WALL_{k}, {arguments})"));
    }
    text += "    q\n}\n\n";
    text += &inside(formula, &parameters);
    text += &format!(
        "pub fn log_p({parameters}) -> f64 {{\n    if inside({arguments}) {{ polynomial({arguments}) }} else {{ \
         f64::NEG_INFINITY }}\n}}\n"
    );
    text
}

fn wall(k: usize, corner: &CornerFormula) -> String {
    let grazing = corner.grazing.as_ref().map_or_else(
        || String::from("None"),
        |grazing| {
            format!(
                "Some(Grazing {{ exponent: {:?}, scale: {:?}, limits: {}, expansion: &{}, table: &[{}] }})",
                grazing.exponent,
                grazing.scale,
                NOTATION.list(&grazing.limits),
                NOTATION.list(&grazing.expansion),
                NOTATION.lists(&grazing.table)
            )
        },
    );
    format!(
        "static WALL_{k}: Wall = Wall {{ offset: {:?}, side: {:?}, reach: {}, kappa: {:?}, kinks: &[{}], grazing: \
         {grazing} }};\n\n",
        corner.offset,
        corner.side,
        NOTATION.list(&corner.reach),
        corner.kappa,
        tuples(corner)
    )
}

fn inside(formula: &Formula, parameters: &str) -> String {
    let (names, count) = (&formula.names, formula.names.len());
    let head = format!("pub fn inside({parameters}) -> bool {{\n");
    let within = |name: &str, limits: [f64; 2]| {
        let [low, high] = limits.map(NOTATION.number);
        format!("({low}..={high}).contains(&{name})")
    };
    let body = match &formula.domain {
        Domain::Everywhere => format!("    let _ = ({},);\n    true\n", names.join(", ")),
        Domain::Box(limits) => {
            let sides: Vec<String> = names.iter().zip(limits).map(|(name, side)| within(name, *side)).collect();
            format!("    {}\n", sides.join(" && "))
        }
        Domain::Star { centre, scale, reach, walls } => {
            let mut body = format!("    const REACH: [f64; {}] = {};\n", reach.len(), NOTATION.list(reach));
            body += &format!("    if !{} {{\n        return false;\n    }}\n", within(&names[0], *walls));
            body += &NOTATION.scaled(names, centre, scale);
            body + if count == 1 { "    z1.abs() <= REACH[usize::from(z1 > 0.0)]\n" } else { STAR }
        }
        Domain::Copula(copula) => format!(
            "    let knots = [{}];\n    let inverse = [{}];\n    let states = [{}];\n    let scores: Vec<f64> = \
             knots.iter().zip(states).map(|(knots, x)| score(knots, x, {:?})).collect();\n    let distance = |row: \
             &[f64; {count}]| row.iter().zip(&scores).map(|(a, z)| a * z).sum::<f64>().powi(2);\n    \
             inverse.iter().map(distance).sum::<f64>() <= {:?}\n",
            NOTATION.lists(&copula.knots),
            NOTATION.lists(&copula.inverse),
            names.join(", "),
            copula.spacing,
            copula.farthest
        ),
    };
    let before = if matches!(formula.domain, Domain::Copula(_)) { SCORE } else { "" };
    format!("{before}{head}{body}}}\n\n")
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
    (z1 * z1 + z2 * z2).sqrt() <= REACH[k] * (1.0 - past.abs()) + REACH[other] * past.abs()
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
