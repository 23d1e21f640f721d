"""Environment steps per second of PPO training on the paper's task: Stable-Baselines3 twice, and `sidestep train`.

Settings are the paper's: 100 environments, 40 steps each per update, discount 1, lambda 0.95, minibatch 64, 10 epochs, separate
20-64-64 tanh networks. Three rows:

    sb3-original   Stable-Baselines3 with `PaperEnv`, one environment object per task, as the original was run
    sb3-batched    Stable-Baselines3 with `BatchedPaperEnv`, so that the comparison is not with a slow environment
    sidestep       `SIDESTEP train CONFIG --out DIR`, read from DIR/summary.json (environment_steps, training_seconds)

The two environments are first held against each other. Stable-Baselines3 gets one update of warm-up that does not count; tasks are
drawn and images built before the clock starts. For sidestep the clock is its own `training_seconds`. `--threads` sets PyTorch's
threads and RAYON_NUM_THREADS.
"""

import argparse
import json
import os
import platform
import shlex
import subprocess
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

import gymnasium
import numpy
import scipy
import stable_baselines3
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import DummyVecEnv

from paper_envs import BatchedPaperEnv, PaperEnv, assert_same, draw_tasks

STEPS_PER_UPDATE = 40


class Stopwatch(BaseCallback):
    """Time spent collecting transitions; the rest of `learn` is spent on updates."""

    def _on_training_start(self):
        self.collecting = 0.0

    def _on_rollout_start(self):
        self.since = time.perf_counter()

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        self.collecting += time.perf_counter() - self.since


def time_sb3(name, envs, steps, seed):
    """A row for Stable-Baselines3 on vectorised environments."""
    model = PPO(
        "MlpPolicy",
        envs,
        n_steps=STEPS_PER_UPDATE,
        batch_size=64,
        n_epochs=10,
        gamma=1.0,
        gae_lambda=0.95,
        learning_rate=3e-4,
        policy_kwargs={"net_arch": {"pi": [64, 64], "vf": [64, 64]}, "activation_fn": torch.nn.Tanh, "ortho_init": False},
        seed=seed,
        device="cpu",
    )
    model.learn(STEPS_PER_UPDATE * envs.num_envs)
    before, watch, begin = model.num_timesteps, Stopwatch(), time.perf_counter()
    model.learn(steps, callback=watch, reset_num_timesteps=False)
    seconds, done = time.perf_counter() - begin, model.num_timesteps - before
    return {**row(name, done, seconds), "collecting_seconds": watch.collecting, "updating_seconds": seconds - watch.collecting}


def time_sidestep(program, config, flags, threads):
    """A row for `sidestep train`, from the summary it leaves."""
    with tempfile.TemporaryDirectory() as out:
        command = [program, "train", config, "--out", out, *shlex.split(flags)]
        environment = {**os.environ, "RAYON_NUM_THREADS": str(threads)}
        finished = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if finished.returncode != 0:
            raise SystemExit(f"{shlex.join(command)} ended with {finished.returncode}:\n{finished.stderr}")
        summary = json.loads((Path(out) / "summary.json").read_text())
    missing = {"environment_steps", "training_seconds"} - summary.keys()
    if missing:
        raise SystemExit(f"summary.json lacks {sorted(missing)}")
    return row("sidestep", summary["environment_steps"], summary["training_seconds"])


def row(name, steps, seconds):
    return {"name": name, "environment_steps": steps, "training_seconds": seconds, "steps_per_second": steps / seconds}


def machine(threads):
    """Processor, cores and versions; no host name."""
    processor = platform.processor()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        models = [line.split(":", 1)[1].strip() for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        processor = models[0] if models else processor
    libraries = {library.__name__: library.__version__ for library in (numpy, scipy, torch, gymnasium, stable_baselines3)}
    versions = {"python": platform.python_version(), **libraries}
    return {
        "processor": processor,
        "cores": os.cpu_count(),
        "system": platform.system(),
        "threads": threads,
        "versions": versions,
    }


def report(rows):
    """The table: steps per second and how many times the first row's and the second row's."""
    base = {r["name"]: r["steps_per_second"] for r in rows}
    for r in rows:
        r["ratio"] = {name: r["steps_per_second"] / speed for name, speed in base.items() if name.startswith("sb3")}
    print(f"{'':14}{'steps/s':>12}" + "".join(f"{'/ ' + name:>16}" for name in base if name.startswith("sb3")))
    for r in rows:
        print(f"{r['name']:14}{r['steps_per_second']:12,.0f}" + "".join(f"{x:16.2f}" for x in r["ratio"].values()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=20_000, help="environment steps per Stable-Baselines3 run")
    parser.add_argument("--envs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--skip-original", action="store_true", help="leave out the slow environment")
    parser.add_argument("--sidestep", help="path of the sidestep program")
    parser.add_argument("--config", help="training configuration for sidestep")
    parser.add_argument("--sidestep-flags", default="", help="more arguments for `sidestep train`")
    parser.add_argument("--json", type=Path, help="where to write the report")
    args = parser.parse_args()
    if args.sidestep and not args.config:
        parser.error("--sidestep needs --config")

    torch.set_num_threads(args.threads)
    tasks = draw_tasks(args.envs, args.seed)
    batched = BatchedPaperEnv(tasks)
    original = DummyVecEnv([lambda task=task: PaperEnv(task) for task in tasks])
    assert_same(original, batched, steps=3)

    rows = []
    if not args.skip_original:
        rows.append(time_sb3("sb3-original", original, args.steps, args.seed))
    rows.append(time_sb3("sb3-batched", batched, args.steps, args.seed))
    if args.sidestep:
        rows.append(time_sidestep(args.sidestep, args.config, args.sidestep_flags, args.threads))
    else:
        print("sidestep: left out, no --sidestep given", file=sys.stderr)
    report(rows)
    if args.json:
        settings = {"steps": args.steps, "environments": args.envs, "seed": args.seed}
        document = {
            "format": "sidestep.oracle.compare/1",
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
            "machine": machine(args.threads),
            "settings": settings,
            "rows": rows,
        }
        args.json.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
