use super::Impulse;
use crate::polynomial::{Arena, Polynomial, Symbol};
use crate::system::PoissonImpulses;
use num_dual::Dual64;

/// λ E\[ψ(x + H(x) Y) − ψ(x)\], or its derivative by a parameter.
///
/// λ, H and the law of Y are a + b ε where the parameter is θ + ε, and the derivative is the coefficient of ε. With fixed nodes z of a
/// standard law, Y = location + scale z moves along, and with H Y = m₀ + m₁ ε it is λ′ E\[ψ(x₊) − ψ(x)\] + λ E\[m₁·∇ψ(x₊)\] at
/// x₊ = x + m₀.
#[derive(Clone, Debug)]
pub(crate) struct ImpulseTerm {
    process: PoissonImpulses<Dual64>,
    /// The coefficients of 1 and ε in H, each by states.
    field: [Vec<Polynomial>; 2],
    /// The power of ε, at most one.
    power: u32,
}

/// What a term does by impulses of one size at a state x: m \[ψ(x₊) − ψ(x)\] + b·∇ψ(x₊).
pub(crate) struct ImpulseAt {
    /// x₊.
    pub(crate) after: Vec<f64>,
    /// m.
    pub(crate) mass: f64,
    /// b, and nothing of impulses themselves.
    pub(crate) drift: Vec<f64>,
}

/// The coefficients of 1 and ε.
fn parts(number: Dual64) -> [f64; 2] {
    [number.re, number.eps]
}

/// The coefficient of a power of ε.
fn part(number: Dual64, power: u32) -> f64 {
    parts(number)[power as usize]
}

impl ImpulseTerm {
    /// The generator of impulses itself.
    pub(crate) fn of(impulse: &Impulse) -> Self {
        let zero = impulse.field().iter().map(|h| Polynomial::zero(h.dimension())).collect();
        let process = impulse.process().each(Dual64::from);
        ImpulseTerm { process, field: [impulse.field().to_vec(), zero], power: 0 }
    }

    /// Its derivative, where ε is the last variable of H. None where it vanishes, since nothing depends on it.
    pub(super) fn derivative(impulse: &Impulse<Dual64>) -> Option<Self> {
        let states = impulse.field().len() - 1;
        let field =
            [0, 1].map(|power| impulse.field()[..states].iter().map(|h| h.coefficient_of_last(power)).collect());
        let term = ImpulseTerm { process: *impulse.process(), field, power: 1 };
        let moves = term.numbers().iter().any(|parts| parts[1] != 0.0) || term.field[1].iter().any(|h| !h.is_zero());
        moves.then_some(term)
    }

    /// All numbers of rate and law, each as its coefficients.
    fn numbers(&self) -> Vec<[f64; 2]> {
        let mut all = Vec::new();
        self.process.each(|number| all.push(parts(number)));
        all
    }

    /// The coefficients of H, each with its state.
    pub(crate) fn fields(&self) -> impl Iterator<Item = (usize, &Polynomial)> {
        self.field.iter().flat_map(|field| field.iter().enumerate())
    }

    /// Rate and law.
    pub(crate) fn process(&self) -> &PoissonImpulses<Dual64> {
        &self.process
    }

    /// Whether it acts on values of functions alone, and not on their derivatives.
    pub(crate) fn is_plain(&self) -> bool {
        self.power == 0
    }

    /// Whether −Y has the same law, at other values of the parameters too.
    pub(crate) fn is_symmetric(&self) -> bool {
        (0..2).all(|k| self.process.amplitude().each(|number| parts(number)[k]).is_symmetric())
    }

    /// The same, `rate` times as often, with other coefficients of H.
    pub(crate) fn with(&self, rate: f64, field: impl Fn(&[Polynomial]) -> Vec<Polynomial>) -> Self {
        ImpulseTerm { process: self.process.times(rate), field: self.field.each_ref().map(|h| field(h)), ..*self }
    }

    /// The impulses that it is the derivative of.
    pub(super) fn impulse(&self) -> Impulse {
        Impulse::new(self.process.each(|number| number.re), self.field[0].clone())
    }

    /// The image of a polynomial, exactly. Not a number where it has functions of the states, whose image has none.
    pub(crate) fn generator(&self, statistic: &Polynomial) -> Polynomial {
        let n = self.field[0].len();
        if !statistic.is_plain() {
            return Polynomial::constant(n, f64::NAN);
        }
        // Two more variables, which stand for ε and Y.
        let arena = Arena::new(n + 2);
        let [epsilon, size] = [0, 1].map(|k| Polynomial::variable(n + 2, n + k));
        let factors = [size.clone(), &epsilon * &size];
        let raised = |p: &Polynomial| {
            let mut raised = Polynomial::zero(n + 2);
            p.terms().for_each(|(alpha, c)| raised.add_term(&[alpha, &[0; 2]].concat(), c));
            raised
        };
        let moved = |i: usize| {
            let terms = self.field.iter().zip(&factors).filter(|(h, _)| !h[i].is_zero());
            let state = Polynomial::variable(n + 2, i);
            arena.symbol(terms.fold(state, |sum, (h, factor)| sum + raised(&h[i]) * factor))
        };
        let moved: Vec<Symbol<'_>> = (0..n).map(moved).collect();
        let rate = self.process.rate();
        let mut image = statistic * -part(rate, self.power);
        for (alpha, c) in statistic.evaluate(&moved).polynomial(n + 2).terms() {
            let Some(power) = self.power.checked_sub(alpha[n]) else { continue };
            let mean = rate * self.process.amplitude().moment(alpha[n + 1]);
            image.add_term(&alpha[..n], c * part(mean, power));
        }
        image
    }

    /// H at a state.
    pub(crate) fn field_at(&self, x: &[f64]) -> Vec<Dual64> {
        let at = |i: usize| {
            let [re, eps] = self.field.each_ref().map(|field| field[i].evaluate(x));
            Dual64::new(re, eps)
        };
        (0..x.len()).map(at).collect()
    }

    /// What impulses of the size `y` do at a state, given H there.
    pub(crate) fn at(&self, x: &[f64], field: &[Dual64], y: Dual64) -> ImpulseAt {
        let (rate, moves) = (self.process.rate(), || field.iter().map(|h| *h * y));
        let after = x.iter().zip(moves()).map(|(x, by)| x + by.re).collect();
        let mass = part(rate, self.power);
        if self.is_plain() {
            return ImpulseAt { after, mass, drift: Vec::new() };
        }
        // The part of λ H Y that is the change of H Y.
        let drift = moves().map(|by| part(rate * (by - by.re), self.power)).collect();
        ImpulseAt { after, mass, drift }
    }
}

/// Numbers with all their parts, which dual numbers themselves do not compare.
impl PartialEq for ImpulseTerm {
    fn eq(&self, other: &Self) -> bool {
        let law = |term: &Self| std::mem::discriminant(&term.process.amplitude());
        (self.power, &self.field, law(self), self.numbers()) == (other.power, &other.field, law(other), other.numbers())
    }
}
