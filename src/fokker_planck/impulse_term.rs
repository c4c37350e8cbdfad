use super::Impulse;
use crate::polynomial::{Arena, Polynomial, Symbol};
use crate::system::Jumps;
use num_dual::HyperDual64;

/// λ E\[ψ(x + H(x) Y) − ψ(x)\], or its derivative by one parameter or by two.
///
/// λ, H and the law of Y are a + b ε₁ + c ε₂ + d ε₁ε₂ where parameters are θ + ε, and the derivative is the coefficient of powers of ε₁
/// and ε₂. With fixed nodes z of a standard law, Y = location + scale z moves along, and with H Y = m₀ + m₁ ε₁ + m₂ ε₂ + m₁₂ ε₁ε₂
///
/// - by one, λ′ E\[ψ(x₊) − ψ(x)\] + λ E\[m₁·∇ψ(x₊)\] at x₊ = x + m₀,
/// - by two, λ₁₂ E\[ψ(x₊) − ψ(x)\] + E\[(λ m₁₂ + λ₁ m₂ + λ₂ m₁)·∇ψ(x₊)\] + λ E\[m₁·∇∇ψ(x₊) m₂\].
#[derive(Clone, Debug)]
pub(crate) struct ImpulseTerm {
    jumps: Jumps<HyperDual64>,
    /// The coefficients of 1, ε₁, ε₂ and ε₁ε₂ in H, each by states.
    field: [Vec<Polynomial>; 4],
    /// Those of ε₁ and ε₂, at most one.
    powers: [u32; 2],
}

/// What a term does by impulses of one size at a state x: m \[ψ(x₊) − ψ(x)\] + b·∇ψ(x₊) + ½ B:∇∇ψ(x₊).
pub(crate) struct Landing {
    /// x₊.
    pub(crate) after: Vec<f64>,
    /// m.
    pub(crate) mass: f64,
    /// b, and nothing of impulses themselves.
    pub(crate) drift: Vec<f64>,
    /// B, by rows; nothing as well.
    pub(crate) diffusion: Vec<f64>,
}

/// The coefficients of 1, ε₁, ε₂ and ε₁ε₂.
fn parts(number: HyperDual64) -> [f64; 4] {
    [number.re, number.eps1, number.eps2, number.eps1eps2]
}

/// The coefficient of powers of ε₁ and ε₂.
fn part(number: HyperDual64, [first, second]: [u32; 2]) -> f64 {
    parts(number)[(first + 2 * second) as usize]
}

impl ImpulseTerm {
    /// The generator of impulses itself.
    pub(crate) fn of(impulse: &Impulse) -> Self {
        let zero = || impulse.field().iter().map(|h| Polynomial::zero(h.dimension())).collect();
        let jumps = impulse.jumps().each(HyperDual64::from);
        ImpulseTerm { jumps, field: [impulse.field().to_vec(), zero(), zero(), zero()], powers: [0; 2] }
    }

    /// Its derivative, where ε₁ and ε₂ are the last two variables of H. None where it vanishes, since nothing depends on them.
    pub(super) fn derivative(impulse: &Impulse<HyperDual64>, powers: [u32; 2]) -> Option<Self> {
        let field = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|powers| {
            let states = impulse.field().len() - 2;
            impulse.field()[..states].iter().map(|h| h.coefficient_of_last(powers)).collect::<Vec<_>>()
        });
        let term = ImpulseTerm { jumps: *impulse.jumps(), field, powers };
        let depends =
            |k: usize| term.numbers().iter().any(|parts| parts[k] != 0.0) || term.field[k].iter().any(|h| !h.is_zero());
        let moves = match powers {
            [1, 1] => depends(3) || depends(1) && depends(2),
            [first, second] => depends((first + 2 * second) as usize),
        };
        moves.then_some(term)
    }

    /// All numbers of rate and law, each as its coefficients.
    fn numbers(&self) -> Vec<[f64; 4]> {
        let mut all = Vec::new();
        self.jumps.each(|number| all.push(parts(number)));
        all
    }

    /// The coefficients of H, each with its state.
    pub(crate) fn fields(&self) -> impl Iterator<Item = (usize, &Polynomial)> {
        self.field.iter().flat_map(|field| field.iter().enumerate())
    }

    /// Rate and law.
    pub(crate) fn jumps(&self) -> &Jumps<HyperDual64> {
        &self.jumps
    }

    /// Whether it acts on values of functions alone, and not on their derivatives.
    pub(crate) fn is_plain(&self) -> bool {
        self.powers == [0; 2]
    }

    /// Whether −Y has the same law, at other values of the parameters too.
    pub(crate) fn is_symmetric(&self) -> bool {
        (0..4).all(|k| self.jumps.amplitude().each(|number| parts(number)[k]).is_symmetric())
    }

    /// The same, `rate` times as often, with other coefficients of H.
    pub(crate) fn with(&self, rate: f64, field: impl Fn(&[Polynomial]) -> Vec<Polynomial>) -> Self {
        ImpulseTerm { jumps: self.jumps.times(rate), field: self.field.each_ref().map(|h| field(h)), ..*self }
    }

    /// The impulses that it is the derivative of.
    pub(super) fn impulse(&self) -> Impulse {
        Impulse::new(self.jumps.each(|number| number.re), self.field[0].clone())
    }

    /// How many parameters it is the derivative by.
    pub(super) fn order(&self) -> u32 {
        self.powers.iter().sum()
    }

    /// The image of a polynomial, exactly.
    pub(crate) fn generator(&self, statistic: &Polynomial) -> Polynomial {
        let n = self.field[0].len();
        // Three more variables, which stand for ε₁, ε₂ and Y.
        let arena = Arena::new(n + 3);
        let [first, second, size] = [0, 1, 2].map(|k| Polynomial::variable(n + 3, n + k));
        let factors = [size.clone(), &first * &size, &second * &size, &first * &second * &size];
        let raised = |p: &Polynomial| {
            let mut raised = Polynomial::zero(n + 3);
            p.terms().for_each(|(alpha, c)| raised.add_term(&[alpha, &[0; 3]].concat(), c));
            raised
        };
        let moved = |i: usize| {
            let terms = self.field.iter().zip(&factors).filter(|(h, _)| !h[i].is_zero());
            let state = Polynomial::variable(n + 3, i);
            arena.symbol(terms.fold(state, |sum, (h, factor)| sum + raised(&h[i]) * factor))
        };
        let moved: Vec<Symbol<'_>> = (0..n).map(moved).collect();
        let rate = self.jumps.rate();
        let mut image = statistic * -part(rate, self.powers);
        for (alpha, c) in statistic.evaluate(&moved).polynomial(n + 3).terms() {
            let [Some(first), Some(second)] = [0, 1].map(|k| self.powers[k].checked_sub(alpha[n + k])) else {
                continue;
            };
            let mean = rate * self.jumps.amplitude().moment(alpha[n + 2]);
            image.add_term(&alpha[..n], c * part(mean, [first, second]));
        }
        image
    }

    /// H at a state.
    pub(crate) fn field_at(&self, x: &[f64]) -> Vec<HyperDual64> {
        let at = |i: usize| {
            let [re, eps1, eps2, eps1eps2] = self.field.each_ref().map(|field| field[i].evaluate(x));
            HyperDual64::new(re, eps1, eps2, eps1eps2)
        };
        (0..x.len()).map(at).collect()
    }

    /// What impulses of the size `y` do at a state, given H there.
    pub(crate) fn landing(&self, x: &[f64], field: &[HyperDual64], y: HyperDual64) -> Landing {
        let (rate, moves) = (self.jumps.rate(), || field.iter().map(|h| *h * y));
        let after = x.iter().zip(moves()).map(|(x, by)| x + by.re).collect();
        let mass = part(rate, self.powers);
        if self.is_plain() {
            return Landing { after, mass, drift: Vec::new(), diffusion: Vec::new() };
        }
        // The part of λ H Y that is the change of H Y.
        let drift = moves().map(|by| part(rate * (by - by.re), self.powers)).collect();
        let twice = self.powers == [1, 1];
        let mixed = |a: HyperDual64, b: HyperDual64| rate.re * (a.eps1 * b.eps2 + a.eps2 * b.eps1);
        let entry = |a: HyperDual64, b: HyperDual64| if twice { mixed(a, b) } else { 0.0 };
        let diffusion = moves().flat_map(|a| moves().map(move |b| entry(a, b))).collect();
        Landing { after, mass, drift, diffusion }
    }
}

/// Numbers with all their parts, which dual numbers themselves do not compare.
impl PartialEq for ImpulseTerm {
    fn eq(&self, other: &Self) -> bool {
        let law = |term: &Self| std::mem::discriminant(&term.jumps.amplitude());
        (self.powers, &self.field, law(self), self.numbers())
            == (other.powers, &other.field, law(other), other.numbers())
    }
}
