"""Writing golden files: ten significant digits, one case per line, so that a diff shows which case moved.

Every input that a golden file holds is rounded *before* anything is computed from it. The file therefore holds the exact
inputs of its outputs, and an output is off by its own rounding only (5e-11 relative).
"""

import json
import math
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parent / "golden"
SIGNIFICANT_DIGITS = 10


def rounded(value):
    """`value` as plain lists, dicts and numbers, each float cut to ten significant digits."""
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return rounded(value.tolist())
    if hasattr(value, "detach"):  # a torch tensor
        return rounded(value.detach().numpy())
    if isinstance(value, (list, tuple)):
        return [rounded(item) for item in value]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        if not math.isfinite(value):
            raise ValueError(f"a golden value is {value}")
        return float(f"{value:.{SIGNIFICANT_DIGITS}g}") + 0.0  # + 0.0 turns -0.0 into 0.0
    return value


def decimals(array, digits):
    """Inputs on a decimal grid, so that the file holds them exactly as they were used."""
    return np.round(np.asarray(array, dtype=float), digits) + 0.0


def write(name, document):
    """Writes `golden/<name>`; lists of cases get a line per case, everything else stays on its own line."""
    path = FOLDER / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(_render(rounded(document), depth=0) + "\n")
    print(f"wrote {path.name}: {path.stat().st_size / 1000:.0f} kB")


def _render(value, depth):
    pad = " " * (depth + 1)
    if isinstance(value, dict) and depth < 2:
        rows = [f"{pad}{json.dumps(key)}: {_render(item, depth + 1)}" for key, item in value.items()]
        return "{\n" + ",\n".join(rows) + "\n" + " " * depth + "}"
    if isinstance(value, list) and value and isinstance(value[0], dict) and depth <= 2:
        rows = [pad + json.dumps(item, separators=(",", ":")) for item in value]
        return "[\n" + ",\n".join(rows) + "\n" + " " * depth + "]"
    return json.dumps(value, separators=(",", ":"))
