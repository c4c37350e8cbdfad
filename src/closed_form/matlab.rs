use super::formula::{Coordinates, CornerFormula, Domain, Formula};
use super::notation::{Notation, with_numbers};

const NOTATION: Notation = Notation {
    times: ".*",
    over: "/",
    number: |value| if value.is_finite() { format!("{value:?}") } else { value.to_string().replace("inf", "Inf") },
    power: |z, n| format!("{z}.^{n}"),
    element: |p, n| format!("{p}{{{}}}", n + 1),
    legendre: |t, degree| format!("legendre_values({t}, {degree})"),
    name: |name, value| format!("    {name} = {value};\n"),
    begin: |value, state| format!("    q = {value:?} + zeros(size({state}));\n"),
    add: |value| format!("    q = q + {value};\n"),
};

/// A matrix.
fn rows<R: AsRef<[f64]>>(rows: &[R]) -> String {
    format!("[{}]", NOTATION.lists(rows).replace("], [", "; ").trim_matches(['[', ']']))
}

/// A function file with `log_p` and its local functions, element by element.
pub(super) fn text(formula: &Formula) -> String {
    let arguments = formula.names.join(", ");
    let mut text = format!("function q = log_p({arguments})\n");
    formula.facts.iter().for_each(|fact| text += &format!("% {fact}\n"));
    text += &format!("    q = polynomial({arguments});\n    q(~inside({arguments})) = -Inf;\nend\n\n");
    text += &format!("function q = polynomial({arguments})\n");
    text += &NOTATION.polynomial(formula);
    formula.corners.iter().for_each(|corner| text += &wall(corner, &arguments));
    text += "end\n\n";
    text += &inside(formula);
    if matches!(formula.coordinates, Coordinates::Legendre { .. }) {
        text += LEGENDRE;
    }
    if matches!(formula.domain, Domain::Copula(_)) {
        text += SCORE;
    }
    if !formula.corners.is_empty() {
        text += &with_numbers(WALLS);
    }
    text
}

fn wall(corner: &CornerFormula, arguments: &str) -> String {
    let kinks: Vec<[f64; 4]> =
        corner.kinks.iter().map(|([p, i, j], c)| [f64::from(*p), f64::from(*i), f64::from(*j), *c]).collect();
    let mut text = (NOTATION.add)(&format!(
        "kinks({:?}, {:?}, {}, {:?}, {}, {arguments})",
        corner.offset,
        corner.side,
        NOTATION.list(&corner.reach),
        corner.kappa,
        rows(&kinks)
    ));
    if let Some(grazing) = &corner.grazing {
        text += &(NOTATION.name)("table", &rows(&grazing.table));
        text += &(NOTATION.name)("expansion", &NOTATION.list(&grazing.expansion));
        text += &(NOTATION.add)(&format!(
            "arrayfun(@(y, v) grazing({:?}*(y - {:?}), {:?}*v, {:?}, {:?}, {}, expansion, table), {arguments})",
            corner.side,
            corner.offset,
            corner.side,
            grazing.exponent,
            grazing.scale,
            NOTATION.list(&grazing.limits)
        ));
    }
    text
}

fn inside(formula: &Formula) -> String {
    let (names, count) = (&formula.names, formula.names.len());
    let head = format!("function yes = inside({})\n", names.join(", "));
    let within = |name: &str, limits: [f64; 2]| {
        let [low, high] = limits.map(NOTATION.number);
        format!("{name} >= {low} & {name} <= {high}")
    };
    let body = match &formula.domain {
        Domain::Everywhere => format!("    yes = true(size({}));\n", names[0]),
        Domain::Box(limits) => {
            let sides: Vec<String> = names.iter().zip(limits).map(|(name, side)| within(name, *side)).collect();
            format!("    yes = {};\n", sides.join(" & "))
        }
        Domain::Star { centre, scale, reach, walls } => {
            // The states come first, so that they may have the names of what is found later.
            let mut body = (NOTATION.name)("yes", &within(&names[0], *walls));
            body += &NOTATION.scaled(names, centre, scale);
            body += &(NOTATION.name)("reach", &NOTATION.list(reach));
            body + if count == 1 {
                "    yes = yes & abs(z1) <= reshape(reach(1 + (z1 > 0)), size(z1));\n"
            } else {
                STAR
            }
        }
        Domain::Copula(copula) => {
            let mut body = format!("    knots = {};\n    inverse = {};\n", rows(&copula.knots), rows(&copula.inverse));
            for (i, name) in names.iter().enumerate() {
                body += &format!("    z{0} = score(knots({0}, :), {name}, {1:?});\n", i + 1, copula.spacing);
            }
            let distance = |i: usize| {
                let parts: Vec<String> = (0..=i).map(|j| format!("inverse({}, {})*z{}", i + 1, j + 1, j + 1)).collect();
                format!("({}).^2", parts.join(" + "))
            };
            let distances: Vec<String> = (0..count).map(distance).collect();
            body + &format!("    yes = {} <= {:?};\n", distances.join(" + "), copula.farthest)
        }
    };
    format!("{head}{body}end\n\n")
}

const LEGENDRE: &str = r"function p = legendre_values(t, degree)
    p = {ones(size(t)), t};
    for k = 1:degree - 1
        p{k + 2} = ((2*k + 1)*t.*p{k + 1} - k*p{k})/(k + 1);
    end
end

";

const STAR: &str = r"    turn = mod(atan2(z2, z1)/(2*pi), 1)*48;
    k = min(floor(turn), 47);
    past = turn - k - 0.5;
    other = mod(k + 2*(past > 0) - 1, 48);
    reached = reshape(reach(k + 1), size(k)).*(1 - abs(past)) + reshape(reach(other + 1), size(k)).*abs(past);
    yes = yes & sqrt(z1.^2 + z2.^2) <= reached;
";

const SCORE: &str = r"function z = score(knots, x, spacing)
    count = numel(knots);
    piece = ones(size(x));
    for k = 2:count - 1
        piece = piece + (x >= knots(k));
    end
    low = reshape(knots(piece), size(x));
    slope = (reshape(knots(piece + 1), size(x)) - low)/spacing;
    z = (piece - 1 - (count - 1)/2)*spacing + (x - low)./slope;
end

";

const WALLS: &str = r"% What a wall adds: kinks A^p u^i w^j, A = (w^6 + (kappa u)^2)^(1/6); rows of terms: p, i, j, coefficient.
function q = kinks(offset, side, reach, kappa, terms, y, v)
    s = max(side*(y - offset), 0)/reach(1);
    t = side*v/reach(2);
    a = (t.^6 + (kappa*s).^2 + TINY).^(1/6);
    q = zeros(size(y));
    for k = 1:size(terms, 1)
        q = q + terms(k, 4)*a.^terms(k, 1).*s.^terms(k, 2).*t.^terms(k, 3);
    end
end

% u^g k(z), z = -w/(scale u)^(1/3): the similarity solution of grazing impacts, k'' = 3 z^2 k' - 9 g z k.
function q = grazing(u, w, g, scale, limits, expansion, table)
    if abs(w) < CLOSEST
        u = max(u, realmin);
    else
        u = max(u, 0);
    end
    edge = STEPS/PER_UNIT;
    len = nthroot(scale*u, 3);
    if abs(w) > edge*len
        unit = scale/abs(w)^3;
        q = -g*log(unit) + limits(1 + (w < 0)) + log(polyval(fliplr(expansion), sign(w)*unit*u));
        return
    end
    z = -w/len;
    near = min(max(round((z + edge)*PER_UNIT), 0), 2*STEPS);
    at = (near - STEPS)/PER_UNIT;
    c = [1, table(near + 1, 2), zeros(1, TERMS - 2)];
    for n = 0:TERMS - 3
        before = 0;
        if n > 0
            before = (3*(n - 1) - 9*g)*c(n);
        end
        c(n + 3) = (3*at^2*(n + 1)*c(n + 2) + (6*n - 9*g)*at*c(n + 1) + before)/((n + 1)*(n + 2));
    end
    q = g*log(u) + table(near + 1, 1) + log(polyval(fliplr(c), z - at));
end
";
