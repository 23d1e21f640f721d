//! Times the networks: inference alone and in a batch, and a training step (forward, backward, Adam of policy and value) at minibatch 64.
//! Best of 20 rounds on one thread: `cargo bench -p sidestep --bench network_timing -- [HIDDEN..]`.
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a measurement's output")]

use std::hint::black_box;
use std::time::Instant;

use sidestep::kernels::AdamStep;
use sidestep::network::{Mlp, Scratch};

const ROWS: usize = 64;
const ROUNDS: usize = 20;

fn numbers(count: usize) -> Vec<f32> {
    (0..count).map(|i| ((i * 7919) % 1000) as f32 / 5000.0 - 0.1).collect()
}

/// Least time of one call, in microseconds, of `calls` calls per round.
fn best(calls: usize, mut call: impl FnMut(usize)) -> f64 {
    let round = |_| {
        let begin = Instant::now();
        (0..calls).for_each(&mut call);
        begin.elapsed().as_secs_f64() * 1e6 / calls as f64
    };
    (0..ROUNDS).map(round).fold(f64::INFINITY, f64::min)
}

/// A network with all that a training step needs.
struct Trained {
    mlp: Mlp,
    scratch: Scratch,
    gradient: Vec<f32>,
    moments: [Vec<f32>; 2],
    output_gradient: Vec<f32>,
}

impl Trained {
    fn new(sizes: &[usize]) -> Self {
        let count = Mlp::parameter_count(sizes).unwrap();
        Self {
            mlp: Mlp::new(sizes, numbers(count)).unwrap(),
            scratch: Scratch::default(),
            gradient: vec![0.0; count],
            moments: [vec![0.0; count], vec![0.0; count]],
            output_gradient: numbers(ROWS * sizes[sizes.len() - 1]),
        }
    }

    fn step(&mut self, inputs: &[f32], t: u64) {
        let Self { mlp, scratch, gradient, moments: [first, second], output_gradient } = self;
        mlp.forward_batch(inputs, scratch);
        gradient.fill(0.0);
        mlp.backward(output_gradient, scratch, gradient);
        let adam = AdamStep::new(t, 1e-5, [0.9, 0.999], 1e-5, 1.0);
        mlp.update(|parameters| adam.apply(parameters, gradient, first, second));
    }
}

fn main() {
    let given: Vec<usize> = std::env::args().skip(1).filter_map(|arg| arg.parse().ok()).collect();
    for hidden in if given.is_empty() { vec![64, 128, 256] } else { given } {
        let mut policy = Trained::new(&[20, hidden, hidden, 20]);
        let mut value = Trained::new(&[20, hidden, hidden, 1]);
        let inputs = numbers(ROWS * 20);
        let mut output = [0.0; 20];
        let mut scratch = Scratch::default();
        let alone = best(2000, |i| {
            let input = &inputs[i % ROWS * 20..][..20];
            policy.mlp.forward(black_box(input), &mut scratch, &mut output);
        });
        let batch = best(50, |_| policy.mlp.forward_batch(black_box(&inputs), &mut scratch));
        let mut t = 0;
        let step = best(50, |_| {
            t += 1;
            policy.step(black_box(&inputs), t);
            value.step(black_box(&inputs), t);
        });
        let per_row = ROWS as f64;
        println!(
            "20-{hidden}-{hidden}-20: alone {alone:.3} us, in a batch of {ROWS} {:.3} us a row, training step {:.2} M rows/s",
            batch / per_row,
            per_row / step
        );
    }
}
