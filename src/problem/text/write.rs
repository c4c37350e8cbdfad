//! To text.

use super::impulse::law;
use crate::elementary::Elementary;
use crate::error::{Error, Result};
use crate::polynomial::{FunctionOf, Polynomial};
use crate::problem::Problem;
use crate::problem::expression::is_name;
use crate::system::Interpretation;
use std::fmt::Write;

impl Problem {
    /// The problem as a TOML document that [`Problem::from_toml`] reads back to the same bits.
    ///
    /// Drift and noise are written with their coefficients, parameters beside them with their values.
    ///
    /// # Errors
    /// [`Error::NotAName`] where a state's name or a parameter's can be none in an expression.
    pub fn to_toml(&self) -> Result<String> {
        let names = self.states().iter().chain(self.equations.parameters.iter().map(|(name, _)| name));
        if let Some(name) = names.into_iter().find(|name| !is_name(name)) {
            let problem = "in an expression a name is a letter, then letters, digits and _";
            return Err(Error::not_a_name(name, problem));
        }
        let quoted: Vec<String> = self.states().iter().map(|name| format!("{name:?}")).collect();
        let mut text = format!("states = [{}]\n", quoted.join(", "));
        if self.interpretation() == Interpretation::Stratonovich {
            text += "interpretation = \"stratonovich\"\n";
        }
        if !self.equations.parameters.is_empty() {
            text += "\n[parameters]\n";
            self.equations.parameters.iter().for_each(|(name, value)| line(&mut text, name, &format!("{value:?}")));
        }
        text += "\n[drift]\n";
        for (name, f) in self.states().iter().zip(self.drift()) {
            line(&mut text, name, &self.expression(f));
        }
        for (k, column) in self.columns().iter().enumerate() {
            text += &format!("\n[noise.w{}]\n", k + 1);
            let driven = self.states().iter().zip(column).filter(|(_, g)| !g.is_zero());
            driven.for_each(|(name, g)| line(&mut text, name, &self.expression(g)));
        }
        for (j, impulse) in self.impulses().iter().enumerate() {
            let impulses = impulse.process();
            text += &format!(
                "\n[impulse.j{}]\nrate = {:?}\namplitude = {}\n",
                j + 1,
                impulses.rate(),
                law(impulses.amplitude())
            );
            let struck = self.states().iter().zip(impulse.field()).filter(|(_, h)| !h.is_zero());
            struck.for_each(|(name, h)| line(&mut text, name, &self.expression(h)));
        }
        for wall in self.walls().iter().chain(self.ends()) {
            let side = if wall.is_above() { "above" } else { "below" };
            let first = &self.states()[wall.state()];
            text += "\n[[wall]]\n";
            text += &match (wall.other(), wall.masses()) {
                (Some(other), Some(masses)) => {
                    format!("between = [{first:?}, {:?}]\nmasses = {masses:?}\n", self.states()[other])
                }
                _ => format!("state = {first:?}\n"),
            };
            text += &format!("{side} = {:?}\nrestitution = {:?}\n", wall.offset(), wall.restitution());
        }
        Ok(text)
    }

    /// A polynomial as an expression in quotes, every coefficient with all its digits.
    fn expression(&self, p: &Polynomial) -> String {
        format!("\"{}\"", self.unquoted(p))
    }

    fn unquoted(&self, p: &Polynomial) -> String {
        let functions: Vec<String> = p.functions().iter().map(|of| self.function(of)).collect();
        let names: Vec<&String> = self.states().iter().chain(&functions).collect();
        let mut text = String::new();
        for (alpha, c) in p.terms() {
            match (text.is_empty(), c < 0.0) {
                (true, false) => {}
                (true, true) => text.push('-'),
                (false, false) => text += " + ",
                (false, true) => text += " - ",
            }
            text += &format!("{:?}", c.abs());
            for (name, power) in names.iter().zip(alpha).filter(|(_, power)| **power > 0) {
                text += &match power {
                    1 => format!("*{name}"),
                    _ if name.contains('^') => format!("*({name})^{power}"),
                    _ => format!("*{name}^{power}"),
                };
            }
        }
        if text.is_empty() { String::from("0") } else { text }
    }

    /// A function of a polynomial.
    fn function(&self, FunctionOf { function, argument }: &FunctionOf) -> String {
        let argument = self.unquoted(argument);
        match (*function, function.name()) {
            (Elementary::PositivePower(power), Some(name)) if power != 0.0 && power != 1.0 => {
                format!("{name}({argument})^({power:?})")
            }
            (_, Some(name)) => format!("{name}({argument})"),
            (Elementary::Power(power), None) => format!("({argument})^({power:?})"),
            (_, None) => argument,
        }
    }
}

fn line(text: &mut String, name: &str, value: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{name} = {value}");
}
