use super::FokkerPlanck;
use crate::polynomial::Polynomial;
use std::fmt;

/// The Fokker-Planck equation as text or LaTeX with chosen names for the states.
struct OperatorText<'a, A> {
    operator: &'a FokkerPlanck,
    names: &'a [A],
    latex: bool,
}

impl FokkerPlanck {
    /// The stationary equation in plain text. A state without a name is a question mark.
    ///
    /// ```
    /// use expoly::models::{Duffing, Solved};
    /// let problem = Duffing::new(0.2, 1.0, 0.3, 0.2)?.problem()?;
    /// assert_eq!(
    ///     problem.operator().text(problem.states()).to_string(),
    ///     "0 = - d/dx[(v) p] - d/dv[(- x - 0.2 v - 0.3 x^3) p] + d2/dv2[(0.2) p]"
    /// );
    /// # Ok::<(), expoly::Error>(())
    /// ```
    pub fn text<'a, A: AsRef<str>>(&'a self, names: &'a [A]) -> impl fmt::Display + 'a {
        OperatorText { operator: self, names, latex: false }
    }

    /// The stationary equation in LaTeX.
    pub fn latex<'a, A: AsRef<str>>(&'a self, names: &'a [A]) -> impl fmt::Display + 'a {
        OperatorText { operator: self, names, latex: true }
    }
}

impl<A: AsRef<str>> fmt::Display for OperatorText<'_, A> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = f.precision();
        let (open, close) = if self.latex { (r"\left[\left(", r"\right) p\right]") } else { ("[(", ") p]") };
        f.write_str("0 =")?;
        for i in 0..self.dimension() {
            let (name, drift) = (self.name(i), self.polynomial(digits, &self.operator.drift[i]));
            let slope =
                if self.latex { format!(r"\frac{{\partial}}{{\partial {name}}}") } else { format!("d/d{name}") };
            write!(f, " - {slope}{open}{drift}{close}")?;
        }
        for i in 0..self.dimension() {
            for j in i..self.dimension() {
                // The two equal mixed terms are written once; the ½ of the diagonal ones is multiplied out.
                let b = &self.operator.diffusion[i][j] * if i == j { 0.5 } else { 1.0 };
                if b.is_zero() {
                    continue;
                }
                let (x, y) = (self.name(i), self.name(j));
                let curvature = match (self.latex, i == j) {
                    (false, true) => format!("d2/d{x}2"),
                    (false, false) => format!("d2/d{x}d{y}"),
                    (true, true) => format!(r"\frac{{\partial^2}}{{\partial {x}^2}}"),
                    (true, false) => format!(r"\frac{{\partial^2}}{{\partial {x}\,\partial {y}}}"),
                };
                write!(f, " + {curvature}{open}{}{close}", self.polynomial(digits, &b))?;
            }
        }
        self.impulses(f)
    }
}

impl<A: AsRef<str>> OperatorText<'_, A> {
    fn dimension(&self) -> usize {
        self.operator.dimension()
    }

    fn name(&self, i: usize) -> &str {
        self.names.get(i).map_or("?", AsRef::as_ref)
    }

    /// A polynomial with so many digits, or all.
    fn polynomial(&self, precision: Option<usize>, p: &Polynomial) -> String {
        let written = |text: &dyn fmt::Display| match precision {
            None => text.to_string(),
            Some(digits) => format!("{text:.digits$}"),
        };
        if self.latex { written(&p.latex(self.names)) } else { written(&p.text(self.names)) }
    }

    /// λ (E[p before an impulse] − p) of each source. Where H depends on the state the transition is written. A derivative has the values of the parameters within its brackets.
    fn impulses(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = f.precision();
        let (open, close, mean, to) =
            if self.latex { (r"\left(", r"\right)", r"\mathrm{E}", r"\to") } else { ("(", ")", "E", "->") };
        let whole = self.operator.impulses().iter().map(|impulse| (impulse.clone(), false));
        let all = whole.chain(self.operator.moved.iter().map(|term| (term.impulse(), true))).collect::<Vec<_>>();
        for (j, (impulse, differentiated)) in all.iter().enumerate() {
            let size = if all.len() > 1 { format!("Y{}", j + 1) } else { "Y".to_owned() };
            let moved = |sign: char| {
                let state = move |(i, h): (usize, &Polynomial)| match (h.is_zero(), h.degree(), h.constant_term()) {
                    (true, ..) => self.name(i).to_owned(),
                    (_, 0, 1.0) => format!("{} {sign} {size}", self.name(i)),
                    _ => format!("{} {sign} {open}{}{close} {size}", self.name(i), self.polynomial(digits, h)),
                };
                impulse.field().iter().enumerate().map(state).collect::<Vec<String>>().join(", ")
            };
            let rate = self.polynomial(digits, &Polynomial::constant(self.dimension(), impulse.process().rate()));
            // Of a derivative what is to be differentiated.
            let by = match (differentiated, self.latex) {
                (false, _) => ["", ""],
                (true, false) => ["d/dtheta [", "]"],
                (true, true) => [r"\frac{\partial}{\partial \theta}\left[", r"\right]"],
            };
            write!(f, " + {}{rate} {open}{mean}[p(", by[0])?;
            if impulse.direction().is_some() {
                f.write_str(&moved('-'))?;
            } else {
                let names: Vec<&str> = (0..self.dimension()).map(|i| self.name(i)).collect();
                write!(f, "before {} {to} {}", names.join(", "), moved('+'))?;
            }
            write!(f, ")] - p{close}{}", by[1])?;
        }
        Ok(())
    }
}
