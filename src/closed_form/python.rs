use super::formula::{Coordinates, CornerFormula, Domain, Formula};
use super::notation::{Notation, tuples, with_numbers};

const NOTATION: Notation = Notation {
    times: "*",
    over: "/",
    number: |value| if value.is_finite() { format!("{value:?}") } else { format!("float(\"{value}\")") },
    power: |z, n| format!("{z}**{n}"),
    element: |p, n| format!("{p}[{n}]"),
    legendre: |t, degree| format!("legendre({t}, {degree})"),
    name: |name, value| format!("    {name} = {value}\n"),
    begin: |value, _| format!("    q = {value:?}\n"),
    add: |value| format!("    q += {value}\n"),
};

/// A module with `log_p`, `polynomial` and `inside`.
pub(super) fn text(formula: &Formula) -> String {
    let arguments = formula.names.join(", ");
    let mut text: String = formula.facts.iter().map(|fact| format!("# {fact}\n")).collect();
    let legendre = matches!(formula.coordinates, Coordinates::Legendre { .. });
    let walled = !formula.corners.is_empty();
    let star = matches!(formula.domain, Domain::Star { .. });
    if walled || (star && formula.names.len() == 2) {
        text += "import math\n";
    }
    text += "\n\n";
    if legendre {
        text += LEGENDRE;
    }
    if walled {
        text += &with_numbers(WALLS);
        formula.corners.iter().enumerate().for_each(|(k, corner)| text += &wall(k, corner));
    }
    text += &format!("def polynomial({arguments}):\n");
    text += &NOTATION.polynomial(formula);
    for k in 0..formula.corners.len() {
        text += &(NOTATION.add)(&format!("wall(*WALL_{k}, {arguments})"));
    }
    text += "    return q\n\n\n";
    text += &inside(formula);
    text += &format!(
        "def log_p({arguments}):\n    if not inside({arguments}):\n        return float(\"-inf\")\n    return \
         polynomial({arguments})\n"
    );
    text
}

fn wall(k: usize, corner: &CornerFormula) -> String {
    let grazing = corner.grazing.as_ref().map_or_else(
        || String::from("None"),
        |grazing| {
            format!(
                "({:?}, {:?}, {}, {}, [{}])",
                grazing.exponent,
                grazing.scale,
                NOTATION.list(&grazing.limits),
                NOTATION.list(&grazing.expansion),
                NOTATION.lists(&grazing.table)
            )
        },
    );
    format!(
        "WALL_{k} = ({:?}, {:?}, {}, {:?}, [{}], {grazing})\n\n\n",
        corner.offset,
        corner.side,
        NOTATION.list(&corner.reach),
        corner.kappa,
        tuples(corner)
    )
}

fn inside(formula: &Formula) -> String {
    let names = &formula.names;
    let head = format!("def inside({}):\n", names.join(", "));
    let within = |name: &str, limits: [f64; 2]| {
        let [low, high] = limits.map(NOTATION.number);
        format!("{low} <= {name} <= {high}")
    };
    let body = match &formula.domain {
        Domain::Everywhere => String::from("    return True\n"),
        Domain::Box(limits) => {
            let sides: Vec<String> = names.iter().zip(limits).map(|(name, side)| within(name, *side)).collect();
            format!("    return {}\n", sides.join(" and "))
        }
        Domain::Star { centre, scale, reach, walls } => {
            // The states come first, so that they may have the names of what is found later.
            let mut body = format!("    if not {}:\n        return False\n", within(&names[0], *walls));
            body += &NOTATION.scaled(names, centre, scale);
            body += &format!("    reach = {}\n", NOTATION.list(reach));
            body + if names.len() == 1 { "    return abs(z1) <= reach[z1 > 0]\n" } else { STAR }
        }
        Domain::Copula(copula) => format!(
            "    knots = [{}]\n    inverse = [{}]\n    scores = [score(k, x, {:?}) for k, x in zip(knots, [{}])]\n    \
             distances = [sum(a*z for a, z in zip(row, scores)) for row in inverse]\n    return sum(d*d for d in \
             distances) <= {:?}\n",
            NOTATION.lists(&copula.knots),
            NOTATION.lists(&copula.inverse),
            copula.spacing,
            names.join(", "),
            copula.farthest
        ),
    };
    let before = if matches!(formula.domain, Domain::Copula(_)) { SCORE } else { "" };
    format!("{before}{head}{body}\n\n")
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
