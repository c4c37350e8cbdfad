//! From text to a tree.

use super::functions::{FUNCTIONS, NamedFunction, outside};
use super::{Fault, Parsed};

/// The longest expression, in characters, and its deepest parentheses.
const LONGEST: usize = 10_000;
const DEEPEST: usize = 100;

/// An expression; places are those of its text's bytes, for errors.
#[derive(Clone, Debug)]
pub(in crate::problem) enum Expression {
    Number(f64),
    Name {
        at: usize,
        name: String,
    },
    /// A function with its arguments.
    Function {
        function: &'static NamedFunction,
        of: Vec<Expression>,
    },
    /// Terms, with whether each is taken away.
    Sum(Vec<(bool, Expression)>),
    /// Factors after the first, each with its operator's place and whether it divides.
    Product(Box<Expression>, Vec<(usize, bool, Expression)>),
    /// The operator's place, the base and the exponent.
    Power(usize, Box<[Expression; 2]>),
}

/// A text that is read from its beginning.
struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
}

impl Expression {
    /// sum = [+ or −] product {+ or − product}, product = power {* or / power}, power = operand [^ operand], and an operand is a number,
    /// a name, a function of a sum in parentheses, or such a sum: −x² is −(x²), as on paper.
    pub(in crate::problem) fn parsed(text: &str) -> Parsed<Self> {
        if text.len() > LONGEST {
            return Err(Fault::new(0, format!("an expression of {} characters is too long", text.len())));
        }
        let mut parser = Parser { text, at: 0, depth: 0 };
        if parser.next().is_none() {
            return parser.fault("it is empty");
        }
        let sum = parser.sum()?;
        match parser.next() {
            None => Ok(sum),
            Some(')') => parser.fault("this ) has no ("),
            Some(c) if c.is_ascii_alphanumeric() || "_.(".contains(c) => {
                parser.fault("an operator is missing: write * for a product")
            }
            Some(c) => parser.fault(format!("the character {c:?} has no meaning here")),
        }
    }
}

impl Parser<'_> {
    fn fault<T>(&self, problem: impl Into<String>) -> Parsed<T> {
        Err(Fault::new(self.at, problem))
    }

    /// The next character that is no space, at which the parser then stands.
    fn next(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    /// Goes past an operator, after which an operand must stand.
    fn operator(&mut self, which: &str) -> Parsed<Option<char>> {
        let Some(first) = self.next().filter(|c| which.contains(*c)) else { return Ok(None) };
        let place = self.at;
        self.at += 1;
        match self.next() {
            Some('*') if first == '*' => Err(Fault::new(place, "**: write ^ for a power")),
            Some(second) if "+-*/^".contains(second) => {
                Err(Fault::new(place, format!("{first}{second}: put a signed number or product in parentheses")))
            }
            _ => Ok(Some(first)),
        }
    }

    fn sum(&mut self) -> Parsed<Expression> {
        let mut taken_away = self.operator("+-")? == Some('-');
        let mut terms = Vec::new();
        loop {
            terms.push((taken_away, self.product()?));
            match self.operator("+-")? {
                Some(sign) => taken_away = sign == '-',
                None => return Ok(Expression::Sum(terms)),
            }
        }
    }

    fn product(&mut self) -> Parsed<Expression> {
        let first = self.power()?;
        let mut more = Vec::new();
        loop {
            self.next();
            let at = self.at;
            let Some(operator) = self.operator("*/")? else { break };
            more.push((at, operator == '/', self.power()?));
        }
        Ok(if more.is_empty() { first } else { Expression::Product(Box::new(first), more) })
    }

    fn power(&mut self) -> Parsed<Expression> {
        let base = self.operand()?;
        self.next();
        let at = self.at;
        if self.operator("^")?.is_none() {
            return Ok(base);
        }
        let exponent = self.operand()?;
        if self.next() == Some('^') {
            return self.fault("a power of a power: put one of them in parentheses");
        }
        Ok(Expression::Power(at, Box::new([base, exponent])))
    }

    fn operand(&mut self) -> Parsed<Expression> {
        match self.next() {
            Some('(') => {
                let at = self.at;
                let mut all = self.in_parentheses()?;
                match (all.pop(), all.is_empty()) {
                    (Some(sum), true) => Ok(sum),
                    _ => Err(Fault::new(at, "a comma has no meaning here: it parts the arguments of max and min")),
                }
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() || c == '_' => self.name(),
            Some(c) if ")+-*/^".contains(c) => self.fault(format!("a number or a name is missing before {c}")),
            Some(c) => self.fault(format!("the character {c:?} has no meaning here")),
            None => self.fault("it ends where a number or a name is missing"),
        }
    }

    /// Sums in parentheses, with commas between them.
    fn in_parentheses(&mut self) -> Parsed<Vec<Expression>> {
        let place = self.at;
        self.depth += 1;
        if self.depth > DEEPEST {
            return self.fault(format!("parentheses deeper than {DEEPEST}"));
        }
        let mut all = Vec::new();
        loop {
            self.at += 1;
            all.push(self.sum()?);
            match self.next() {
                Some(',') => {}
                Some(')') => break,
                _ => return Err(Fault::new(place, "this ( is not closed before the next operand or the end")),
            }
        }
        (self.at, self.depth) = (self.at + 1, self.depth - 1);
        Ok(all)
    }

    /// The text from here on as far as its characters are of a kind.
    fn run(&mut self, kind: impl Fn(char) -> bool) -> &str {
        let rest = &self.text[self.at..];
        let length = rest.find(|c| !kind(c)).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    /// Digits, perhaps with a point among them and an exponent.
    fn number(&mut self) -> Parsed<Expression> {
        let start = self.at;
        let digits = |c: char| c.is_ascii_digit();
        self.run(digits);
        if self.text[self.at..].starts_with('.') {
            self.at += 1;
            self.run(digits);
        }
        let mantissa = self.at;
        if self.text[self.at..].starts_with(['e', 'E']) {
            self.at += 1;
            self.at += usize::from(self.text[self.at..].starts_with(['+', '-']));
            if self.run(digits).is_empty() {
                self.at = mantissa;
            }
        }
        let number = self.text[start..self.at].parse();
        number.map(Expression::Number).map_err(|_| Fault::new(start, "a point alone is no number"))
    }

    /// A name, or a function of what follows in parentheses.
    fn name(&mut self) -> Parsed<Expression> {
        let at = self.at;
        let name = self.run(|c| c == '_' || c.is_ascii_alphanumeric()).to_owned();
        let function = FUNCTIONS.iter().find(|function| function.name == name);
        let called = self.next() == Some('(');
        match function {
            Some(function) if called => {
                let of = self.in_parentheses()?;
                if of.len() != function.arguments {
                    let arguments = if function.arguments == 1 { "one argument" } else { "two arguments" };
                    return Err(Fault::new(at, format!("{name} has {arguments}, and here {}", of.len())));
                }
                Ok(Expression::Function { function, of })
            }
            Some(_) => Err(Fault::new(at, format!("{name} is a function: write {name}(…)"))),
            None if called => Err(Fault::new(at, outside(&name))),
            None => Ok(Expression::Name { at, name }),
        }
    }
}
