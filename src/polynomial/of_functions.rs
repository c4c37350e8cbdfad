//! Polynomials in functions of their variables.

use super::Polynomial;
use crate::elementary::{Elementary, Parity};
use crate::scalar::Scalar;
use serde::{Deserialize, Serialize};

/// An elementary function of a polynomial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FunctionOf {
    pub(crate) function: Elementary,
    pub(crate) argument: Polynomial,
}

impl FunctionOf {
    /// The derivative by its argument.
    fn slope(&self) -> Polynomial {
        let of = |function: Elementary| self.argument.applied(function);
        match self.function {
            Elementary::Sin => of(Elementary::Cos),
            Elementary::Cos => of(Elementary::Sin) * -1.0,
            Elementary::Tanh => of(Elementary::Tanh).squared() * -1.0 + 1.0,
            Elementary::Atan => (self.argument.squared() + 1.0).applied(Elementary::Power(-1.0)),
            Elementary::Exp => of(Elementary::Exp),
            Elementary::Ln => of(Elementary::Power(-1.0)),
            Elementary::Power(exponent) => of(Elementary::Power(exponent - 1.0)) * exponent,
            Elementary::Abs => of(Elementary::Sign),
            Elementary::PositivePower(exponent) if exponent != 0.0 => {
                of(Elementary::PositivePower(exponent - 1.0)) * exponent
            }
            Elementary::Sign | Elementary::PositivePower(_) => Polynomial::zero(self.argument.dimension),
        }
    }

    /// The plain square of its value, where it has one but on its kinks.
    fn square(&self) -> Option<Polynomial> {
        match self.function {
            Elementary::Power(0.5) => Some(self.argument.clone()),
            Elementary::Abs => Some(self.argument.squared()),
            Elementary::Sign => Some(Polynomial::constant(self.argument.dimension, 1.0)),
            _ => None,
        }
    }

    fn parity(&self, flip: &[bool]) -> Parity {
        match (self.argument.parity(flip), self.function.parity()) {
            (Parity::Even, _) => Parity::Even,
            (Parity::Odd, of_function) => of_function,
            (Parity::Neither, _) => Parity::Neither,
        }
    }
}

impl Polynomial {
    /// Whether it is a polynomial in its variables alone, without functions of them.
    ///
    /// ```
    /// use expoly::Problem;
    /// let pendulum = "states = ['x', 'v']\ndrift = { x = 'v', v = '-0.2*v - sin(x)' }\nnoise.w.v = '0.3'";
    /// let problem = Problem::from_toml(pendulum)?;
    /// assert!(problem.drift()[0].is_plain() && !problem.drift()[1].is_plain());
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn is_plain(&self) -> bool {
        self.functions.is_empty()
    }

    /// The terms without functions, and those with.
    pub(super) fn parts(&self) -> [Self; 2] {
        if self.is_plain() {
            return [self.clone(), Polynomial::zero(self.dimension)];
        }
        let plain = |alpha: &[u32]| alpha[self.dimension..].iter().all(|power| *power == 0);
        [true, false].map(|kept| self.filtered(|alpha, _| plain(alpha) == kept))
    }

    /// Its functions, in the order of their exponents.
    pub(crate) fn functions(&self) -> &[FunctionOf] {
        &self.functions
    }

    /// All functions in it, those of others before them.
    pub(crate) fn all_functions(&self) -> Vec<&FunctionOf> {
        let own = self.functions.iter().flat_map(|of| of.argument.all_functions().into_iter().chain([of]));
        own.collect()
    }

    /// An elementary function of it.
    pub(crate) fn applied(&self, function: Elementary) -> Self {
        if self.is_plain() && self.degree() == 0 {
            return Polynomial::constant(self.dimension, function.of(self.constant_term()));
        }
        if let Elementary::Power(exponent) = function
            && (0.0..=60.0).contains(&exponent)
            && exponent.fract() == 0.0
        {
            let one = Polynomial::constant(self.dimension, 1.0);
            return (0..exponent as u32).fold(one, |power, _| &power * self);
        }
        // max(a, 0)ᵖ has derivatives where a root of max(a, 0) has none.
        if let (Elementary::Power(outer), [FunctionOf { function: Elementary::PositivePower(inner), argument }]) =
            (function, &self.functions[..])
            && *inner > 0.0
            && outer > 0.0
            && self.terms().map(|(alpha, c)| (alpha.iter().sum::<u32>(), c)).eq([(1, 1.0)])
        {
            return argument.applied(Elementary::PositivePower(inner * outer));
        }
        let mut exponents = vec![0; self.dimension];
        exponents.push(1);
        let functions = vec![FunctionOf { function, argument: self.clone() }];
        Polynomial { dimension: self.dimension, exponents, coefficients: vec![1.0], functions }
    }

    fn squared(&self) -> Self {
        self * self
    }

    /// The variables, and the functions after them, at `x`.
    pub(super) fn factors<S: Scalar>(&self, x: &[S]) -> Vec<S> {
        let mut all = x.to_vec();
        all.resize(self.dimension, S::zero());
        all.extend(self.functions.iter().map(|of| of.argument.evaluate(x).elementary(of.function)));
        all
    }

    /// ∂p/∂x_i, given that with all functions kept as they are.
    pub(super) fn along_functions(&self, i: usize, own: Self) -> Self {
        let each = self.functions.iter().enumerate().map(|(k, of)| {
            let inner = of.argument.derivative(i);
            if inner.is_zero() { inner } else { self.lowered(self.dimension + k) * of.slope() * inner }
        });
        each.fold(own, |sum, part| sum + part)
    }

    /// The same without functions that no term has.
    pub(super) fn without_unused(mut self) -> Self {
        let (n, width) = (self.dimension, self.width());
        let used = |k: usize| self.exponents.iter().skip(n + k).step_by(width).any(|power| *power > 0);
        let kept: Vec<usize> = (0..self.functions.len()).filter(|&k| used(k)).collect();
        if kept.len() < self.functions.len() {
            let row = |alpha: &[u32]| alpha[..n].iter().copied().chain(kept.iter().map(|k| alpha[n + k])).collect();
            self.exponents = self.exponents.chunks_exact(width).flat_map(|alpha| -> Vec<u32> { row(alpha) }).collect();
            self.functions = kept.iter().map(|&k| self.functions[k].clone()).collect();
        }
        self
    }

    /// The same with the functions of a list that has all of its own, in at least `states` variables.
    pub(super) fn with_functions(&self, states: usize, functions: &[FunctionOf]) -> Self {
        let n = self.dimension.max(states);
        let place = |of: &FunctionOf| functions.iter().position(|other| other == of).unwrap_or(0);
        let places: Vec<usize> = self.functions.iter().map(place).collect();
        let mut exponents = Vec::with_capacity((n + functions.len()) * self.coefficients.len());
        for (alpha, _) in self.terms() {
            let first = exponents.len();
            exponents.resize(first + n + functions.len(), 0);
            exponents[first..first + self.dimension].copy_from_slice(&alpha[..self.dimension]);
            for (place, power) in places.iter().zip(&alpha[self.dimension..]) {
                exponents[first + n + place] = *power;
            }
        }
        Polynomial { dimension: n, exponents, coefficients: self.coefficients.clone(), functions: functions.to_vec() }
    }

    /// The same with the squares of functions that have a plain one in their place: √x √x = x.
    pub(super) fn reduced(self) -> Self {
        let n = self.dimension;
        let reducible = |alpha: &[u32]| {
            (0..self.functions.len()).find(|&k| alpha[n + k] > 1 && self.functions[k].square().is_some())
        };
        let Some((alpha, k)) = self.terms().find_map(|(alpha, _)| Some((alpha.to_vec(), reducible(alpha)?))) else {
            return self;
        };
        let rest = self.filtered(|other, _| other != alpha);
        let mut lower = alpha.clone();
        lower[n + k] -= 2;
        let mut factor = Polynomial { functions: self.functions.clone(), ..Polynomial::zero(n) };
        factor.add_term(&lower, self.coefficient(&alpha));
        let square = self.functions[k].square().unwrap_or_else(|| Polynomial::zero(n));
        (rest + factor.without_unused() * square).reduced()
    }

    /// The same with a function of it, and of the arguments of others, as it is above its kink or jump, or below.
    pub(crate) fn beside(&self, bent: &FunctionOf, above: bool) -> Self {
        let n = self.dimension;
        let side = if above { 1.0 } else { -1.0 };
        let replaced = |of: &FunctionOf| {
            let argument = of.argument.beside(bent, above);
            if of != bent {
                return argument.applied(of.function);
            }
            match of.function {
                Elementary::Abs => argument * side,
                Elementary::PositivePower(power) if above => argument.applied(Elementary::Power(power)),
                Elementary::PositivePower(_) => Polynomial::zero(n),
                _ => Polynomial::constant(n, side),
            }
        };
        let factors: Vec<Polynomial> = self.functions.iter().map(replaced).collect();
        let of_term = |(alpha, c): (&[u32], f64)| {
            let mut plain = Polynomial::zero(n);
            plain.add_term(&alpha[..n], c);
            let powers = factors.iter().zip(&alpha[n..]);
            powers.fold(plain, |product, (factor, &power)| (0..power).fold(product, |product, _| product * factor))
        };
        self.terms().map(of_term).fold(Polynomial::zero(n), |sum, term| sum + term)
    }

    /// What it becomes where these states change their signs.
    pub(crate) fn parity(&self, flip: &[bool]) -> Parity {
        let of_term = |(alpha, _): (&[u32], f64)| {
            let own = if super::exponents::odd(flip, &alpha[..self.dimension]) { Parity::Odd } else { Parity::Even };
            let functions = self.functions.iter().zip(&alpha[self.dimension..]).filter(|(_, power)| **power > 0);
            functions.fold(own, |parity, (of, power)| match of.parity(flip) {
                Parity::Odd if power % 2 == 0 => parity,
                factor => parity.times(factor),
            })
        };
        let mut parities = self.terms().map(of_term);
        let first = parities.next().unwrap_or(Parity::Even);
        if parities.all(|other| other == first) { first } else { Parity::Neither }
    }

    /// Whether it depends on a variable.
    pub(crate) fn contains(&self, i: usize) -> bool {
        let in_functions = |of: &FunctionOf| of.argument.contains(i);
        self.functions.iter().any(in_functions) || self.terms().any(|(alpha, _)| alpha.get(i).is_some_and(|a| *a > 0))
    }

    /// Whether all coefficients are finite, and those of its functions' arguments; one that is not.
    pub(crate) fn not_finite(&self) -> Option<(Vec<u32>, f64)> {
        let own = self.terms().find(|(_, c)| !c.is_finite()).map(|(alpha, c)| (alpha.to_vec(), c));
        own.or_else(|| self.functions.iter().find_map(|of| of.argument.not_finite()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;

    fn variables() -> [Polynomial; 2] {
        [0, 1].map(|i| Polynomial::variable(2, i))
    }

    /// A polynomial in every function, and in functions of functions.
    fn all() -> Polynomial {
        let [x, v] = variables();
        let root = (&x * &x + 0.3).applied(Elementary::Power(0.5));
        let functions = [
            (Elementary::Sin, &x * 2.0 + 0.1),
            (Elementary::Cos, &x * &v),
            (Elementary::Tanh, v.clone()),
            (Elementary::Atan, &x - &v),
            (Elementary::Exp, &x * -0.5),
            (Elementary::Ln, root.clone()),
            (Elementary::Power(-1.0), &root + 1.0),
            (Elementary::Power(1.5), &v * &v + 0.2),
            (Elementary::Abs, v.clone()),
            (Elementary::Abs, root.applied(Elementary::Sin) + -0.4),
            (Elementary::PositivePower(1.5), &x + -0.2),
        ];
        functions.into_iter().fold(&x * &v, |sum, (function, argument)| sum * 0.7 + argument.applied(function) * &x)
    }

    /// Derivatives of the terms and those of dual numbers through their values are two routes: sums of a dozen products.
    #[test]
    fn derivatives_are_those_of_dual_numbers() {
        let p = all();
        for x in [[0.4, -0.8], [-1.3, 0.5], [0.9, 1.7], [0.1, 0.2]] {
            for i in 0..2 {
                let seeded: [Dual64; 2] = std::array::from_fn(|j| Dual64::new(x[j], f64::from(u8::from(i == j))));
                let Dual64 { re, eps, .. } = p.evaluate(&seeded);
                let (value, slope) = (p.evaluate(&x), p.derivative(i).evaluate(&x));
                assert!((value - re).abs() < 1e-14 * (1.0 + re.abs()), "{x:?}: {value} and {re}");
                assert!((slope - eps).abs() < 1e-13 * (1.0 + eps.abs()), "{x:?}, {i}: {slope} and {eps}");
                let seeded = [Dual64::new(x[0], 1.0), Dual64::new(x[1], 0.0)];
                let bend = p.derivative(i).derivative(0).evaluate(&x);
                let exact = p.derivative(i).evaluate(&seeded).eps;
                assert!((bend - exact).abs() < 1e-12 * (1.0 + exact.abs()), "{x:?}, {i}: {bend} and {exact}");
            }
        }
    }

    /// Composition is evaluation at the inner values.
    #[test]
    fn compositions_are_evaluations() {
        let ([x, v], p) = (variables(), all());
        let inner = [&x * 0.5 + &v + -0.3, v.applied(Elementary::Sin)];
        let at = [0.7, -0.4];
        let direct = p.evaluate(&inner.each_ref().map(|q| q.evaluate(&at)));
        assert!((p.compose(&inner).evaluate(&at) - direct).abs() < 1e-14);
    }

    #[test]
    fn documents_hold_functions() {
        let text = serde_json::to_string(&all()).unwrap_or_default();
        assert_eq!(serde_json::from_str::<Polynomial>(&text).ok(), Some(all()));
        let [x, _] = variables();
        assert!(!serde_json::to_string(&x).unwrap_or_default().contains("functions"));
        assert!(serde_json::from_str::<Polynomial>(&text.replacen("\"dimension\":2", "\"dimension\":1", 1)).is_err());
    }

    #[test]
    fn functions_that_cancel_are_gone_and_squares_are_plain() {
        let [x, v] = variables();
        let (root, modulus) = (x.applied(Elementary::Power(0.5)), v.applied(Elementary::Abs));
        assert!((&root * &root - &x).is_zero() && (&root - &root).is_plain());
        assert_eq!(&modulus * &modulus, &v * &v);
        assert_eq!((&modulus * &v.applied(Elementary::Sign)).functions().len(), 2);
        let hertz = x.applied(Elementary::PositivePower(1.0)).applied(Elementary::Power(1.5));
        assert_eq!(hertz.functions()[0].function, Elementary::PositivePower(1.5));
    }

    #[test]
    fn parities_are_those_of_signs() {
        let [x, v] = variables();
        let (both, one) = ([true, true], [true, false]);
        let restoring = &v.applied(Elementary::Sign) + &(&x * 2.0).applied(Elementary::Sin);
        assert_eq!((restoring.parity(&both), restoring.parity(&one)), (Parity::Odd, Parity::Neither));
        let gap = (x.applied(Elementary::Abs) + -1.0).applied(Elementary::PositivePower(1.0));
        assert_eq!((gap.parity(&one), (gap * x.applied(Elementary::Sign)).parity(&one)), (Parity::Even, Parity::Odd));
        assert_eq!(x.applied(Elementary::Exp).parity(&one), Parity::Neither);
        assert_eq!(x.applied(Elementary::Exp).parity(&[false, true]), Parity::Even);
    }
}
