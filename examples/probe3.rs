use expoly::{models::*, *};
fn main() {
    let duff = Duffing::new(0.2, 1.0, 0.3, 0.2).unwrap();
    for b in [0.2, -0.5] {
        for basis in [Basis::Classical, Basis::Folded] {
            eprintln!("== {b} {basis}");
            let _ = Closure::classical(2).with_basis(basis).solve_with_wall(&duff, Barrier::new(b, 0.95).unwrap());
        }
    }
}
