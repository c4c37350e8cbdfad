use super::formula::{CornerFormula, Formula};
use super::language::Language;

/// MATLAB, arrays element by element.
const MATLAB: Language = Language {
    comment: "%",
    times: ".*",
    over: "/",
    and: " & ",
    end: "",
    legendre: LEGENDRE,
    score: SCORE,
    walls: WALLS,
    line: "    yes = yes & abs(z1) <= reshape(reach(1 + (z1 > 0)), size(z1));\n",
    star: STAR,
    rows: ["[", "; ", "]"],
    number: |value| if value.is_finite() { format!("{value:?}") } else { value.to_string().replace("inf", "Inf") },
    power: |z, n| format!("{z}.^{n}"),
    element: |p, n| format!("{p}{{{}}}", n + 1),
    polynomials: |t, degree| format!("legendre_values({t}, {degree})"),
    name: |name, value| format!("    {name} = {value};\n"),
    begin: |value, state| format!("    q = {value:?} + zeros(size({state}));\n"),
    add: |value| format!("    q = q + {value};\n"),
    function: |name, names, holds, body| {
        let value = if holds { "yes" } else { "q" };
        format!("function {value} = {name}({})\n{body}end\n\n", names.join(", "))
    },
    within: |name, [low, high]| format!("{name} >= {low} & {name} <= {high}"),
    holds: |condition| format!("    yes = {condition};\n"),
    necessary: |condition| format!("    yes = {condition};\n"),
    everywhere: |names| format!("    yes = true(size({}));\n", names[0]),
    ellipsoid,
    boxes: |count| {
        let within =
            |i: usize| format!("state{{{}}} >= b({}) & state{{{}}} <= b({})", i + 1, 2 * i + 1, i + 1, 2 * i + 2);
        let all = (0..count).map(within).collect::<Vec<_>>().join(" & ");
        format!("    yes = false(size(state{{1}}));\n    for b = boxes'\n        yes = yes | ({all});\n    end\n")
    },
    together: |names| format!("{{{}}}", names.join(", ")),
    wall: |_, _| String::new(),
    of_wall,
};

/// A function file with `log_p`, which comes first, and its local functions.
pub(super) fn text(formula: &Formula<'_>) -> String {
    let arguments = formula.names.join(", ");
    let log_p = format!("    q = polynomial({arguments});\n    q(~inside({arguments})) = -Inf;\n");
    let mut text = (MATLAB.function)("log_p", formula.names, false, &(MATLAB.facts(formula) + &log_p));
    text += &MATLAB.polynomial(formula);
    text += &MATLAB.inside(formula);
    text + &MATLAB.helpers(formula)
}

fn ellipsoid(names: &[String], spacing: f64, farthest: f64) -> String {
    let score = |(i, name): (usize, &String)| format!("    z{i} = score(knots({i}, :), {name}, {spacing:?});\n");
    let scores: String = (1..).zip(names).map(score).collect();
    let distance = |i: usize| {
        let parts: Vec<String> = (1..=i).map(|j| format!("inverse({i}, {j})*z{j}")).collect();
        format!("({}).^2", parts.join(" + "))
    };
    let distances: Vec<String> = (1..=names.len()).map(distance).collect();
    format!("{scores}    yes = {} <= {farthest:?};\n", distances.join(" + "))
}

fn of_wall(_: usize, corner: &CornerFormula<'_>, arguments: &str) -> String {
    let numbers = |([p, i, j], c): &([i32; 3], f64)| [f64::from(*p), f64::from(*i), f64::from(*j), *c];
    let kinks = MATLAB.matrix(&corner.kinks.iter().map(numbers).collect::<Vec<_>>());
    let &CornerFormula { offset, side, reach, kappa, .. } = corner;
    let reach = MATLAB.list(&reach);
    let mut text = (MATLAB.add)(&format!("kinks({offset:?}, {side:?}, {reach}, {kappa:?}, {kinks}, {arguments})"));
    if let Some(grazing) = corner.grazing {
        let (exponent, scale, limits) = (grazing.exponent, grazing.scale, MATLAB.list(&grazing.limits));
        text += &(MATLAB.name)("table", &MATLAB.matrix(&grazing.table));
        text += &(MATLAB.name)("expansion", &MATLAB.list(&grazing.expansion));
        text += &(MATLAB.add)(&format!(
            "arrayfun(@(y, v) grazing({side:?}*(y - {offset:?}), {side:?}*v, {exponent:?}, {scale:?}, {limits}, expansion, \
             table), {arguments})"
        ));
    }
    text
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
