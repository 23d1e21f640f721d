"""How often plain gradient descent solves the paper's easy tasks: a sanity check of `paper_profile`.

The paper says 79.7 % (Table I). Any-step counts a task as soon as one of the 200 trajectories is feasible, end-state only looks
at the last one; the straight line itself counts for any-step, and the figure without it is printed too.
"""

import argparse

import numpy as np

from paper_profile import Objective, draw_task, straight_line


def rates(tasks, seed, steps, step, sobel_divisor):
    """Shares of tasks solved at any step, at any step but the start, and at the end; and the share of feasible lines."""
    rng = np.random.default_rng(seed)
    found = np.zeros((tasks, 4), dtype=bool)
    for row in found:
        objective = Objective(draw_task(rng))
        line = straight_line(objective.start, objective.goal)
        feasible = [objective.feasible(w) for w in objective.descent(line, steps, step, sobel_divisor)]
        row[:] = any(feasible), any(feasible[1:]), feasible[-1], feasible[0]
    return found.mean(axis=0)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tasks", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--step", type=float, default=0.1)
    parser.add_argument("--sobel-divisor", type=float, default=1.0, help="8 gives the distance gradient its true size")
    args = parser.parse_args()
    any_step, after_start, end_state, line = 100 * rates(**vars(args))
    print(f"any step {any_step:.1f} %, without the start {after_start:.1f} %, end state {end_state:.1f} %, line {line:.1f} %")


if __name__ == "__main__":
    main()
