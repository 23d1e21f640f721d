"""A search over settings of a training with Ray Tune (`pip install "ray[tune]" sidestep`).

    python tune.py --trials 8 --steps 20000

Each trial is `sidestep train` with settings of its own. What a trial is judged by is its policy's success on validation tasks
(seed 7): test seeds are for measuring what was chosen.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import ray
from ray import tune

parser = argparse.ArgumentParser()
parser.add_argument("--trials", type=int, default=8)
parser.add_argument("--steps", type=int, default=20_000)
parser.add_argument("--tasks", type=int, default=200, help="validation tasks")
parser.add_argument("--out", default="runs/tune")
args = parser.parse_args()


def program(*words: object) -> None:
    command = [sys.executable, "-m", "sidestep", *map(str, words), "--threads", "1", "--quiet"]
    answer = subprocess.run(command, capture_output=True, text=True)
    if answer.returncode != 0:
        raise RuntimeError(answer.stderr.strip())


def trial(config: dict) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file, run, report = (Path(folder) / name for name in ("train.toml", "run", "report.json"))
        ppo = f"ppo.learning_rate = {config['learning_rate']}\nppo.gamma = {config['gamma']}\n"
        file.write_text(f"environment_steps = {args.steps}\nnetwork.hidden = {config['hidden']}\n{ppo}")
        program("train", file, "--out", run)
        planner = f"learned:{run / 'policy.safetensors'}"
        program("bench", "--suite", "easy", "--count", args.tasks, "--seeds", 7, "--planner", planner, "--profile", "paper", "--timed", 2, "--out", report)
        tune.report({"certified": json.loads(report.read_text())["rows"][0]["certified"]})


ray.init(include_dashboard=False, log_to_driver=False)
space = {
    "learning_rate": tune.loguniform(1e-4, 3e-3),
    "gamma": tune.choice([0.85, 0.95, 1.0]),
    "hidden": tune.choice([32, 64]),
}
settings = tune.TuneConfig(metric="certified", mode="max", num_samples=args.trials)
where = tune.RunConfig(storage_path=str(Path(args.out).resolve()), name="search", verbose=0)
best = tune.Tuner(tune.with_resources(trial, {"cpu": 1}), param_space=space, tune_config=settings, run_config=where).fit().get_best_result()
print(f"best: {best.config} certifies {best.metrics['certified']:.1%} of {args.tasks} tasks")
