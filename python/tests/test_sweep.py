"""An experiment on a local Ray cluster of two workers, one of them killed."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ray = pytest.importorskip("ray")
pytestmark = pytest.mark.skipif(not os.environ.get("SIDESTEP_CHECK_CLIENTS"), reason="SIDESTEP_CHECK_CLIENTS is not set")

from sidestep import sweep  # noqa: E402

EXPERIMENT = """
name = "small"
title = "Small"
training_seeds = [0, 5]
[[measure]]
name = "easy"
suite = "easy"
count = 20
seeds = [7]
steps = 10
[[policies]]
row = "paper's"
column = "tiny"
[policies.train]
environment_steps = {steps}
network.hidden = 8
training.count = 4
cloning.samples_per_task = 4
ppo = { environments = 5, steps = 40 }
validation = { count = 4, steps = 10 }
[[baselines]]
planner = "gd"
"""


@pytest.fixture(scope="module")
def cluster():
    os.environ["RAY_AUTH_MODE"] = "disabled"
    for attempt in range(3):
        try:
            ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
            break
        except Exception:
            if attempt == 2:
                raise
    yield
    ray.shutdown()


def without_times(report):
    report.pop("provenance")
    for cell in report["cells"]:
        cell.pop("us_per_iteration")
        cell.pop("training_seconds")
    return report


def workers():
    """Processes of ours that work on a cell."""
    found = []
    for folder in Path("/proc").iterdir():
        try:
            if folder.name.isdigit() and b"ray::_cell" in (folder / "cmdline").read_bytes():
                found.append(int(folder.name))
        except OSError:
            pass
    return found


def test_a_sweep_is_the_experiment(cluster, tmp_path):
    file = tmp_path / "small.toml"
    file.write_text(EXPERIMENT.replace("{steps}", "30000"))
    words = [sys.executable, "-m", "sidestep", "experiment", str(file), "--out", str(tmp_path / "one"), "--quiet"]
    subprocess.run(words, check=True, capture_output=True)
    wanted = without_times(json.loads((tmp_path / "one/report.json").read_text()))

    killed, heard = [], []

    def kill():
        # The training of a cell that has stored a checkpoint.
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            if list((tmp_path / "ray").rglob("*checkpoint*")) and (found := workers()):
                os.kill(found[0], signal.SIGKILL)
                killed.append(found[0])
                return
            time.sleep(0.01)

    import threading

    thread = threading.Thread(target=kill)
    thread.start()
    report = sweep.run(file, tmp_path / "ray", checkpoint_every=0.05, progress=lambda *told: heard.append(told))
    thread.join()
    assert killed, "no worker was killed"
    assert [(done, of) for done, of, _ in heard] == [(1, 3), (2, 3), (3, 3)]
    assert without_times(report) == wanted
    assert without_times(json.loads((tmp_path / "ray/report.json").read_text())) == wanted
    # A second start finds everything finished, and works on nothing.
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "ray/cells").rglob("cell.json")}
    heard.clear()
    assert without_times(sweep.run(file, tmp_path / "ray", progress=lambda *told: heard.append(told))) == wanted
    assert heard == [] and len(before) == 3
    assert all(path.stat().st_mtime_ns == time for path, time in before.items())


def test_bad_experiments_are_told(cluster, tmp_path):
    with pytest.raises(ValueError, match="nothing.toml"):
        sweep.run(tmp_path / "nothing.toml", tmp_path / "out")
    file = tmp_path / "small.toml"
    file.write_text(EXPERIMENT.replace("{steps}", "200").replace('planner = "gd"', 'planner = "gdx"'))
    with pytest.raises(ValueError, match=r"baselines\[0\].*gdx"):
        sweep.run(file, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    file.write_text(EXPERIMENT.replace("{steps}", "200"))
    (tmp_path / "out/cells/0002").mkdir(parents=True)
    (tmp_path / "out/cells/0002/cell.json").mkdir()
    with pytest.raises(ValueError, match="cell.json"):
        sweep.run(file, tmp_path / "out")
