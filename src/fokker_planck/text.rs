use super::FokkerPlanck;
use std::fmt;

/// What of the operator is written.
#[derive(Clone, Copy, Debug)]
enum Form {
    /// 0 = L p.
    Equation,
    /// r = L exp(Q) / exp(Q).
    Residual,
}

/// The Fokker-Planck equation, or the residual of exp(Q), as text or LaTeX with chosen names for the states.
#[derive(Clone, Copy, Debug)]
pub struct OperatorText<'a, const N: usize> {
    operator: &'a FokkerPlanck<N>,
    names: [&'a str; N],
    form: Form,
    latex: bool,
}

impl<const N: usize> FokkerPlanck<N> {
    /// The stationary equation in plain text.
    pub fn text<'a>(&'a self, names: [&'a str; N]) -> OperatorText<'a, N> {
        OperatorText { operator: self, names, form: Form::Equation, latex: false }
    }

    /// The stationary equation in LaTeX.
    pub fn latex<'a>(&'a self, names: [&'a str; N]) -> OperatorText<'a, N> {
        OperatorText { operator: self, names, form: Form::Equation, latex: true }
    }

    /// The residual of exp(Q) in plain text, in derivatives of Q.
    ///
    /// ```
    /// use expoly::{FokkerPlanck, models::Linear};
    /// let operator = FokkerPlanck::new(&Linear::new(0.5, 1.0, 0.5)?)?;
    /// assert_eq!(
    ///     operator.residual_text(["x", "v"]).to_string(),
    ///     "r = 0.5 + (- v) Q_x + (x + 0.5 v) Q_v + (0.5) (Q_vv + Q_v Q_v)"
    /// );
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn residual_text<'a>(&'a self, names: [&'a str; N]) -> OperatorText<'a, N> {
        OperatorText { operator: self, names, form: Form::Residual, latex: false }
    }

    /// The residual of exp(Q) in LaTeX.
    pub fn residual_latex<'a>(&'a self, names: [&'a str; N]) -> OperatorText<'a, N> {
        OperatorText { operator: self, names, form: Form::Residual, latex: true }
    }
}

impl<const N: usize> fmt::Display for OperatorText<'_, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.form {
            Form::Equation => self.equation(f),
            Form::Residual => self.residual(f),
        }
    }
}

impl<const N: usize> OperatorText<'_, N> {
    /// A polynomial with the precision that the whole was asked for.
    fn polynomial(&self, f: &fmt::Formatter<'_>, p: &crate::Polynomial<N>) -> String {
        let text = if self.latex { p.latex(self.names) } else { p.text(self.names) };
        f.precision().map_or_else(|| text.to_string(), |digits| format!("{text:.digits$}"))
    }

    fn equation(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("0 =")?;
        for i in 0..N {
            let (name, drift) = (self.names[i], self.polynomial(f, &self.operator.drift[i]));
            if self.latex {
                write!(f, r" - \frac{{\partial}}{{\partial {name}}}\left[\left({drift}\right) p\right]")?;
            } else {
                write!(f, " - d/d{name}[({drift}) p]")?;
            }
        }
        for i in 0..N {
            for j in i..N {
                // The two equal mixed terms are written once; the ½ of the diagonal ones is multiplied out.
                let b = &self.operator.diffusion[i][j] * if i == j { 0.5 } else { 1.0 };
                if b.is_zero() {
                    continue;
                }
                let (x, y, b) = (self.names[i], self.names[j], self.polynomial(f, &b));
                match (self.latex, i == j) {
                    (false, true) => write!(f, " + d2/d{x}2[({b}) p]")?,
                    (false, false) => write!(f, " + d2/d{x}d{y}[({b}) p]")?,
                    (true, true) => {
                        write!(f, r" + \frac{{\partial^2}}{{\partial {x}^2}}\left[\left({b}\right) p\right]")?;
                    }
                    (true, false) => write!(
                        f,
                        r" + \frac{{\partial^2}}{{\partial {x}\,\partial {y}}}\left[\left({b}\right) p\right]"
                    )?,
                }
            }
        }
        Ok(())
    }

    fn residual(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let spread = self.operator.diffusion_divergence();
        let constant = (0..N).fold(&self.operator.divergence() * -1.0, |sum, i| sum + spread[i].derivative(i) * 0.5);
        let (open, close) = if self.latex { (r"\left(", r"\right)") } else { ("(", ")") };
        write!(f, "r = {}", self.polynomial(f, &constant))?;
        for i in 0..N {
            let factor = &spread[i] - &self.operator.drift[i];
            if !factor.is_zero() {
                write!(f, " + {open}{}{close} {}", self.polynomial(f, &factor), self.derivative(&[i]))?;
            }
        }
        for i in 0..N {
            for j in i..N {
                let b = &self.operator.diffusion[i][j] * if i == j { 0.5 } else { 1.0 };
                if !b.is_zero() {
                    let (qi, qj, qij) = (self.derivative(&[i]), self.derivative(&[j]), self.derivative(&[i, j]));
                    write!(f, " + {open}{}{close} {open}{qij} + {qi} {qj}{close}", self.polynomial(f, &b))?;
                }
            }
        }
        Ok(())
    }

    fn derivative(&self, states: &[usize]) -> String {
        let names: Vec<&str> = states.iter().map(|&i| self.names[i]).collect();
        if self.latex { format!("Q_{{{}}}", names.join(" ")) } else { format!("Q_{}", names.concat()) }
    }
}
