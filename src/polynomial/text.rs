use super::{FunctionOf, Polynomial};
use crate::elementary::Elementary;
use std::fmt;

/// A polynomial as text with chosen names for its variables.
struct PolynomialText<'a, A> {
    polynomial: &'a Polynomial,
    names: &'a [A],
    latex: bool,
}

impl Polynomial {
    /// The polynomial in plain text: `x - 0.3 x^3 v`. A precision, as in `{:.3}`, shortens the coefficients. A variable
    /// without a name is a question mark.
    ///
    /// ```
    /// let [x, v] = [0, 1].map(|i| expoly::Polynomial::variable(2, i));
    /// let p = &(&x * &x) * &v * -0.125 + x;
    /// assert_eq!(format!("{:.2}", p.text(&["x", "v"])), "x - 0.12 x^2 v");
    /// ```
    pub fn text<'a, A: AsRef<str>>(&'a self, names: &'a [A]) -> impl fmt::Display + 'a {
        PolynomialText { polynomial: self, names, latex: false }
    }

    /// The polynomial in LaTeX: `x - 0.3\,x^{3} v`.
    ///
    /// ```
    /// let [x, v] = [0, 1].map(|i| expoly::Polynomial::variable(2, i));
    /// let p = &(&x * &x) * &v * -1.5e-7;
    /// assert_eq!(p.latex(&["x", r"\dot x"]).to_string(), r"- 1.5 \times 10^{-7}\,x^{2} \dot x");
    /// ```
    pub fn latex<'a, A: AsRef<str>>(&'a self, names: &'a [A]) -> impl fmt::Display + 'a {
        PolynomialText { polynomial: self, names, latex: true }
    }
}

impl fmt::Display for Polynomial {
    /// Plain text with the variables named x1, x2, …
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<String> = (1..=self.dimension()).map(|i| format!("x{i}")).collect();
        fmt::Display::fmt(&self.text(&names), f)
    }
}

impl<A: AsRef<str>> fmt::Display for PolynomialText<'_, A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.polynomial.is_zero() {
            return f.write_str("0");
        }
        for (k, (alpha, coefficient)) in self.polynomial.terms().enumerate() {
            f.write_str(match (k, coefficient < 0.0) {
                (0, false) => "",
                (0, true) => "- ",
                (_, false) => " + ",
                (_, true) => " - ",
            })?;
            let size = coefficient.abs();
            let factors = alpha.iter().enumerate().filter(|(_, power)| **power > 0);
            let powers: Vec<String> = factors.map(|(i, power)| self.power(i, *power)).collect();
            if powers.is_empty() || size != 1.0 {
                self.number(f, size)?;
                if !powers.is_empty() {
                    f.write_str(if self.latex { r"\," } else { " " })?;
                }
            }
            f.write_str(&powers.join(" "))?;
        }
        Ok(())
    }
}

impl<A: AsRef<str>> PolynomialText<'_, A> {
    fn power(&self, i: usize, exponent: u32) -> String {
        let function =
            i.checked_sub(self.polynomial.dimension()).map(|k| self.function(&self.polynomial.functions()[k]));
        let name = match &function {
            Some(function) => function.as_str(),
            None => self.names.get(i).map_or("?", AsRef::as_ref),
        };
        match (exponent, self.latex) {
            (1, _) => name.to_owned(),
            (n, false) => format!("{name}^{n}"),
            (n, true) if name.contains(['\\', '^', '|']) => format!("{{{name}}}^{{{n}}}"),
            (n, true) => format!("{name}^{{{n}}}"),
        }
    }

    /// A function of a polynomial.
    fn function(&self, FunctionOf { function, argument }: &FunctionOf) -> String {
        if !self.latex {
            let inner = argument.text(self.names);
            return match (*function, function.name()) {
                (Elementary::PositivePower(p), Some(name)) if p != 0.0 && p != 1.0 => format!("{name}({inner})^{p}"),
                (_, Some(name)) => format!("{name}({inner})"),
                (Elementary::Power(p), None) if p < 0.0 => format!("({inner})^({p})"),
                (Elementary::Power(p), None) => format!("({inner})^{p}"),
                (_, None) => format!("({inner})"),
            };
        }
        let inner = argument.latex(self.names);
        let named = |name: &str| format!(r"{name}\left({inner}\right)");
        match *function {
            Elementary::Sin => named(r"\sin"),
            Elementary::Cos => named(r"\cos"),
            Elementary::Tanh => named(r"\tanh"),
            Elementary::Atan => named(r"\arctan"),
            Elementary::Exp => named(r"\exp"),
            Elementary::Ln => named(r"\ln"),
            Elementary::Sign => named(r"\operatorname{sgn}"),
            Elementary::Power(0.5) => format!(r"\sqrt{{{inner}}}"),
            Elementary::Power(p) => format!(r"\left({inner}\right)^{{{p}}}"),
            Elementary::Abs => format!(r"\left|{inner}\right|"),
            Elementary::PositivePower(1.0) => format!(r"\left({inner}\right)_+"),
            Elementary::PositivePower(p) => format!(r"\left({inner}\right)_+^{{{p}}}"),
        }
    }

    /// A coefficient, to twelve digits unless the formatter has a precision: decimal where it is of ordinary size, with a
    /// power of ten where it is not.
    fn number(&self, f: &mut fmt::Formatter<'_>, size: f64) -> fmt::Result {
        let ordinary = !size.is_finite() || size == 0.0 || (1e-4..1e7).contains(&size);
        let size = if f.precision().is_none() { twelve_digits(size) } else { size };
        let text = match (ordinary, f.precision()) {
            (true, Some(digits)) => format!("{size:.digits$}"),
            (true, None) => format!("{size}"),
            (false, Some(digits)) => format!("{size:.digits$e}"),
            (false, None) => format!("{size:e}"),
        };
        match text.split_once('e') {
            Some((mantissa, exponent)) if self.latex => write!(f, r"{mantissa} \times 10^{{{exponent}}}"),
            _ => f.write_str(&text),
        }
    }
}

/// The number rounded to twelve significant digits, so that 0.1 + 0.2 prints as 0.3.
pub(crate) fn twelve_digits(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}
