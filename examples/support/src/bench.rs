//! Timings beside each other.

use std::hint::black_box;
use std::time::Instant;

/// Tasks that take turns, so that a slower machine slows them alike. The others are compared with the first.
pub struct Group<'a> {
    name: String,
    tasks: Vec<(String, Task<'a>)>,
    rounds: usize,
    elements: Option<u64>,
}

type Task<'a> = Box<dyn FnMut() -> expoly::Result<()> + 'a>;

impl std::fmt::Debug for Group<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Group").field("name", &self.name).finish_non_exhaustive()
    }
}

impl<'a> Group<'a> {
    /// A group whose tasks take so many turns.
    pub fn new(name: &str, rounds: usize) -> Self {
        Group { name: name.to_owned(), tasks: Vec::new(), rounds, elements: None }
    }

    /// Sets the number of elements that each task goes through, so that they are counted per second.
    pub fn elements(self, elements: u64) -> Self {
        Group { elements: Some(elements), ..self }
    }

    /// Adds a task.
    pub fn task<R>(mut self, name: &str, mut task: impl FnMut() -> expoly::Result<R> + 'a) -> Self {
        self.tasks.push((name.to_owned(), Box::new(move || task().map(|result| drop(black_box(result))))));
        self
    }

    /// Runs all tasks in turns and prints of each the median time, and the median of its ratios to the first task in the same
    /// round with the quartiles. On the command line `--test` stands for one round, `--rounds 3` for three, `--seconds` for
    /// the median times alone, and a word for the groups whose names contain it.
    ///
    /// # Errors
    /// The first that a task returns.
    #[allow(clippy::print_stdout, reason = "a bench prints its times")]
    pub fn run(mut self) -> expoly::Result<()> {
        let Asked { rounds, seconds_alone, words } = Asked::of(std::env::args().skip(1), self.rounds);
        if !words.is_empty() && !words.iter().any(|word| self.name.contains(word.as_str())) {
            return Ok(());
        }
        let mut seconds = vec![Vec::with_capacity(rounds); self.tasks.len()];
        // The first turn fills caches, and is not counted.
        let uncounted = usize::from(rounds > 1);
        for round in 0..rounds + uncounted {
            for ((_, task), seconds) in self.tasks.iter_mut().zip(&mut seconds) {
                let begin = Instant::now();
                task()?;
                if round >= uncounted {
                    seconds.push(begin.elapsed().as_secs_f64());
                }
            }
        }
        if !seconds_alone {
            println!("\n{:<34} {:>12} {:>9} {:>17}", self.name, "median, s", "ratio", "quartiles");
        }
        for ((name, _), times) in self.tasks.iter().zip(&seconds) {
            let median = quantile(times, 0.5);
            if seconds_alone {
                println!("{}: {name}\t{median}", self.name);
                continue;
            }
            let ratios: Vec<f64> = times.iter().zip(&seconds[0]).map(|(time, first)| time / first).collect();
            let [low, ratio, high] = [0.25, 0.5, 0.75].map(|share| quantile(&ratios, share));
            let rate = self.elements.map_or_else(String::new, |count| format!("{:10.3e} /s", count as f64 / median));
            println!("{name:<34} {median:>12.6} {ratio:>9.3} {low:>8.3} {high:>8.3} {rate}");
        }
        Ok(())
    }
}

/// The options of the command line.
struct Asked {
    rounds: usize,
    seconds_alone: bool,
    words: Vec<String>,
}

impl Asked {
    fn of(mut arguments: impl Iterator<Item = String>, rounds: usize) -> Self {
        let mut asked = Asked { rounds, seconds_alone: false, words: Vec::new() };
        while let Some(argument) = arguments.next() {
            match argument.as_str() {
                "--test" => asked.rounds = 1,
                "--rounds" => {
                    let rounds = arguments.next().and_then(|rounds| rounds.parse().ok());
                    asked.rounds = rounds.filter(|rounds| *rounds > 0).unwrap_or(asked.rounds);
                }
                "--seconds" => asked.seconds_alone = true,
                // The argument that `cargo bench` itself adds.
                "--bench" => {}
                _ => asked.words.push(argument),
            }
        }
        asked
    }
}

/// The value below which a share of all values is.
fn quantile(values: &[f64], share: f64) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[(share * (values.len() - 1) as f64).round() as usize]
}
