"""The notebook, from top to bottom, and the examples that need large packages."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
heavy = pytest.mark.skipif(not os.environ.get("SIDESTEP_CHECK_CLIENTS"), reason="SIDESTEP_CHECK_CLIENTS is not set")


def test_the_notebook_runs(tmp_path):
    for module in ("matplotlib", "onnx", "onnxruntime", "gymnasium"):
        pytest.importorskip(module)
    cells = json.loads((EXAMPLES / "tutorial.ipynb").read_text())["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert len(code) > 8 and all(not cell.get("outputs") for cell in cells)
    script = tmp_path / "tutorial.py"
    script.write_text("import matplotlib\nmatplotlib.use('agg')\n" + "\n".join(code))
    answer = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert "solved after" in answer.stdout and "largest difference" in answer.stdout


def run(name, *words, folder):
    answer = subprocess.run([sys.executable, EXAMPLES / name, *words], cwd=folder, capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr
    return answer.stdout


@heavy
def test_a_page_of_ppo(tmp_path):
    pytest.importorskip("torch")
    import sidestep

    out = run("ppo.py", "--steps", "8000", "--out", "mine.safetensors", folder=tmp_path)
    assert "tasks certified" in out
    policy = sidestep.Policy.load(tmp_path / "mine.safetensors")
    assert policy.card["architecture"] == "mlp" and policy.card["training"]["steps"] == 8000


@heavy
def test_rllib_by_registration(tmp_path):
    pytest.importorskip("ray.rllib.algorithms.ppo")
    out = run("rllib.py", "--iterations", "1", "--envs", "16", folder=tmp_path)
    assert out.startswith("iteration 0: 640 steps"), out


@heavy
def test_a_search_with_tune(tmp_path):
    for module in ("ray", "pandas", "pyarrow"):
        pytest.importorskip(module)
    out = run("tune.py", "--trials", "2", "--steps", "800", "--tasks", "20", folder=tmp_path)
    assert "best:" in out and "of 20 tasks" in out
