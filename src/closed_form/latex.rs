use super::{ClosedDensity, ClosedForm};
use crate::density::{Density, Support};
use crate::error::{Error, Result};

/// The equation on one line, after a comment on its origin.
pub(super) fn text(form: &ClosedForm, symbols: &[&str]) -> Result<String> {
    let reason = "above a wall ln p has a singular part and kinks beside its polynomial; take Python or MATLAB, \
        which have them, or JSON";
    let polynomial =
        form.log_polynomial().ok_or(Error::NotKnown { what: "its text in LaTeX".into(), remedy: reason })?;
    let names = form.names();
    let side = |(symbol, [low, high]): (&&str, &[f64; 2])| format!(r"{low:.6} \le {symbol} \le {high:.6}");
    let sides = |bounds: &[[f64; 2]]| symbols.iter().zip(bounds).map(side).collect::<Vec<_>>().join(r",\ ");
    let (fact, domain) = match &form.density {
        ClosedDensity::Closure(density) => {
            let (order, error) = (density.provenance().order.unwrap_or_default(), density.l1_estimate());
            let fact = format!("closure of order {order}, estimated L1 error {error:.1e}; p is taken for zero outside");
            (format!("{fact} its trust domain, which lies in the box given"), sides(&density.bounds()))
        }
        ClosedDensity::ExpPolynomial(density) => {
            let domain = match density.support() {
                Support::WholeSpace => String::new(),
                Support::Above(bound) => format!(r"{} \ge {bound}", symbols[0]),
                Support::Region(limits) => sides(limits),
            };
            (format!("exponential polynomial of order {}", polynomial.degree()), domain)
        }
    };
    let domain = if domain.is_empty() { domain } else { format!(r", \qquad {domain}") };
    let arguments = symbols.join(", ");
    let (states, polynomial) = (names.join(", "), polynomial.latex(symbols));
    Ok(format!("% ln p of the states {states}: {fact}\n\\ln p({arguments}) = {polynomial}{domain}\n"))
}
