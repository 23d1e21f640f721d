"""An experiment's cells on a Ray cluster (`pip install sidestep[ray]`).

    python -m sidestep.sweep experiments/table-1.toml --out runs/table-1      # RAY_ADDRESS joins a cluster, else this machine

Each cell is what `sidestep experiment --cell I` works on: a training with its measurements, or a baseline. All machines see the
folder. A cell whose worker is lost is begun again elsewhere and its training goes on from its last checkpoint; cells that
are finished are skipped by a second start; the report is the one of `sidestep experiment`, times aside.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from os import PathLike
from pathlib import Path
from typing import Any

import ray

from . import _sidestep

Progress = Callable[[int, int, str], None]


def cells(experiment: str | PathLike[str], out: str | PathLike[str]) -> list[dict[str, Any]]:
    """The cells of an experiment with `index`, `row`, `column`, `seed` and `state`, as `sidestep experiment --list` has them."""
    return json.loads(_program(experiment, out, "--list", "--json"))


def run(
    experiment: str | PathLike[str],
    out: str | PathLike[str],
    *,
    checkpoint_every: float = 30.0,
    retries: int = 3,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Works on all cells that are not finished, on the cluster of `ray.init` or `RAY_ADDRESS`, and returns the report, which is
    `out/report.json` too. `progress(done, of, what)` hears of each cell. A cell that fails ends the sweep; what is finished stays."""
    experiment, out = Path(experiment).resolve(), Path(out).resolve()
    listed = cells(experiment, out)
    if not ray.is_initialized():
        ray.init(include_dashboard=False, log_to_driver=False)
    # A worker's death is no fault of the cell; what a cell says of bad input is, and would be said again.
    work = ray.remote(num_cpus=1, max_retries=retries, retry_exceptions=False)(_cell)
    left = {
        work.remote(str(experiment), str(out), cell["index"], checkpoint_every): cell
        for cell in listed
        if cell["state"] != "finished"
    }
    done = len(listed) - len(left)
    try:
        while left:
            ready, _ = ray.wait(list(left), num_returns=1, timeout=5.0)
            for reference in ready:
                cell = left[reference]
                ray.get(reference)
                del left[reference]
                done += 1
                if progress is not None:
                    seed = "" if cell["seed"] is None else f", seed {cell['seed']}"
                    progress(done, len(listed), f"{cell['row']} {cell['column']}{seed}")
    finally:
        for reference in left:
            ray.cancel(reference, force=True)
    return json.loads(_program(experiment, out, "--merge", "--json"))


def _cell(experiment: str, out: str, index: int, checkpoint_every: float) -> None:
    """In a worker, so that it dies with it. One thread: Ray counts cores."""
    words = [experiment, "--out", out, "--cell", str(index), "--threads", "1", "--quiet"]
    with _errors() as told:
        code = _sidestep.main(["sidestep", "experiment", *words, "--checkpoint-every", str(checkpoint_every)])
    if code != 0:
        raise RuntimeError(f"cell {index} of {experiment}: {told() or f'exit code {code}'}")


@contextlib.contextmanager
def _errors() -> Iterator[Callable[[], str]]:
    """What the program writes to standard error meanwhile."""
    sys.stderr.flush()
    kept = os.dup(2)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 2)

        def told() -> str:
            return text

        text = ""
        try:
            yield told
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            file.seek(0)
            text = file.read().decode(errors="replace").strip()


def _program(experiment: str | PathLike[str], out: str | PathLike[str], *flags: str) -> str:
    words = [sys.executable, "-m", "sidestep", "experiment", os.fspath(experiment), "--out", os.fspath(out), *flags]
    answer = subprocess.run(words, capture_output=True, text=True)
    if answer.returncode != 0:
        raise ValueError(answer.stderr.strip())
    return answer.stdout


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m sidestep.sweep", description=__doc__.split("\n")[0])
    parser.add_argument("experiment")
    parser.add_argument("--out", required=True, help="a folder that all machines see")
    parser.add_argument("--checkpoint-every", type=float, default=30.0, help="seconds between checkpoints of a training")
    args = parser.parse_args()

    def progress(done: int, of: int, what: str) -> None:
        print(f"{done}/{of} {what}", file=sys.stderr, flush=True)

    try:
        run(args.experiment, args.out, checkpoint_every=args.checkpoint_every, progress=progress)
    except (ValueError, ray.exceptions.RayError) as error:
        sys.exit(f"error: {error}")
    print(Path(args.out) / "report.json")


if __name__ == "__main__":
    main()
