use super::formula::{CornerFormula, Domain, Formula};
use super::language::{Language, tuples};

/// Python 3, a float at a time.
const PYTHON: Language = Language {
    comment: "#",
    times: "*",
    over: "/",
    and: " and ",
    end: "    return q\n",
    legendre: LEGENDRE,
    score: SCORE,
    walls: WALLS,
    line: "    return abs(z1) <= reach[z1 > 0]\n",
    star: STAR,
    rows: ["[[", "], [", "]]"],
    number: |value| if value.is_finite() { format!("{value:?}") } else { format!("float(\"{value}\")") },
    power: |z, n| format!("{z}**{n}"),
    element: |p, n| format!("{p}[{n}]"),
    polynomials: |t, degree| format!("legendre({t}, {degree})"),
    name: |name, value| format!("    {name} = {value}\n"),
    begin: |value, _| format!("    q = {value:?}\n"),
    add: |value| format!("    q += {value}\n"),
    function: |name, names, _, body| format!("def {name}({}):\n{body}\n\n", names.join(", ")),
    within: |name, [low, high]| format!("{low} <= {name} <= {high}"),
    holds: |condition| format!("    return {condition}\n"),
    necessary: |condition| format!("    if not {condition}:\n        return False\n"),
    everywhere: |_| String::from("    return True\n"),
    ellipsoid: |names, spacing, farthest| {
        format!(
            "    scores = [score(k, x, {spacing:?}) for k, x in zip(knots, [{}])]\n    distances = [sum(a*z for a, z in \
             zip(row, scores)) for row in inverse]\n    return sum(d*d for d in distances) <= {farthest:?}\n",
            names.join(", ")
        )
    },
    boxes: |count| {
        let within = |i: usize| format!("b[{}] <= state[{i}] <= b[{}]", 2 * i, 2 * i + 1);
        let all = (0..count).map(within).collect::<Vec<_>>().join(" and ");
        format!("    return any({all} for b in boxes)\n")
    },
    together: |names| format!("[{}]", names.join(", ")),
    wall,
    of_wall: |k, _, arguments| format!("    q += wall(*WALL_{k}, {arguments})\n"),
};

/// A module with `log_p`, `polynomial` and `inside`.
pub(super) fn text(formula: &Formula<'_>) -> String {
    let arguments = formula.names.join(", ");
    let turned = matches!(formula.domain, Domain::Star(_)) && formula.names.len() == 2;
    let import = if turned || !formula.corners.is_empty() { "import math\n" } else { "" };
    let log_p = format!(
        "    if not inside({arguments}):\n        return float(\"-inf\")\n    return polynomial({arguments})\n"
    );
    PYTHON.facts(formula) + import + "\n\n" + &PYTHON.module(formula, &log_p)
}

fn wall(k: usize, corner: &CornerFormula<'_>) -> String {
    let grazing = corner.grazing.map_or_else(
        || String::from("None"),
        |grazing| {
            let (exponent, scale) = (grazing.exponent, grazing.scale);
            let [limits, expansion] = [&grazing.limits[..], &grazing.expansion[..]].map(|list| PYTHON.list(list));
            format!("({exponent:?}, {scale:?}, {limits}, {expansion}, {})", PYTHON.matrix(&grazing.table))
        },
    );
    let &CornerFormula { offset, side, reach, kappa, .. } = corner;
    let (reach, kinks) = (PYTHON.list(&reach), tuples(corner));
    format!("WALL_{k} = ({offset:?}, {side:?}, {reach}, {kappa:?}, [{kinks}], {grazing})\n\n\n")
}

const LEGENDRE: &str = r"def legendre(t, degree):
    p = [1.0, t]
    for k in range(1, degree):
        p.append(((2*k + 1)*t*p[k] - k*p[k - 1])/(k + 1))
    return p


";

const STAR: &str = r"    turn = math.atan2(z2, z1)/(2*math.pi) % 1.0*48
    k = min(int(turn), 47)
    past = turn - k - 0.5
    other = (k + (1 if past > 0 else -1)) % 48
    return math.sqrt(z1*z1 + z2*z2) <= reach[k]*(1 - abs(past)) + reach[other]*abs(past)
";

const SCORE: &str = r"def score(knots, x, spacing):
    piece = sum(1 for knot in knots[1:-1] if knot <= x)
    slope = (knots[piece + 1] - knots[piece])/spacing
    return (piece - (len(knots) - 1)/2)*spacing + (x - knots[piece])/slope


";

const WALLS: &str = r"# u^g k(z), z = -w/(scale u)^(1/3): the similarity solution of grazing impacts, k'' = 3 z^2 k' - 9 g z k.
def grazing(u, w, g, scale, limits, expansion, table):
    u = max(u, 2.2250738585072014e-308 if abs(w) < CLOSEST else 0.0)
    length = (scale*u)**(1/3)
    if abs(w) > STEPS/PER_UNIT*length:
        unit = scale/abs(w)**3
        t = math.copysign(unit*u, w)
        total = 0.0
        for c in reversed(expansion):
            total = total*t + c
        return -g*math.log(unit) + limits[w < 0] + math.log(total)
    z = -w/length
    near = min(max(int((z + STEPS/PER_UNIT)*PER_UNIT + 0.5), 0), 2*STEPS)
    log, slope = table[near]
    at = (near - STEPS)/PER_UNIT
    c = [1.0, slope]
    for n in range(TERMS - 2):
        before = (3*(n - 1) - 9*g)*c[n - 1] if n > 0 else 0.0
        c.append((3*at*at*(n + 1)*c[n + 1] + (6*n - 9*g)*at*c[n] + before)/((n + 1)*(n + 2)))
    total = 0.0
    for term in reversed(c):
        total = total*(z - at) + term
    return g*math.log(u) + log + math.log(total)


# What a wall adds: kinks A^p u^i w^j, A = (w^6 + (kappa u)^2)^(1/6), and the grazing impacts.
def wall(offset, side, reach, kappa, kinks, impacts, y, v):
    u, w = side*(y - offset), side*v
    s, t = max(u, 0.0)/reach[0], w/reach[1]
    a = (t**6 + (kappa*s)**2 + TINY)**(1/6)
    total = sum(c*a**p*s**i*t**j for p, i, j, c in kinks)
    return total if impacts is None else total + grazing(u, w, *impacts)


";
