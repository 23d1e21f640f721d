"""Policies as ONNX networks, for other runtimes (`pip install sidestep[onnx]`).

    sidestep.onnx.export("policy.safetensors", "policy.onnx")
    inputs, update = sidestep.Policy.load("policy.safetensors").look(tasks, x)
    session = onnxruntime.InferenceSession("policy.onnx")
    session.run(["update"], inputs)                    # the same update

A network goes from what a policy sees to the update of the waypoints, scaled and clipped; what is seen is computed by
`Policy.look`, and keeping waypoints inside the field is left to whoever applies the update. All inputs are float32:

| input    | shape                                    | of |
| -------- | ---------------------------------------- | -- |
| `rows`   | `[batch, observation]`                   | a policy of a whole trajectory |
| `rows`   | `[batch, waypoints, row]`                | a policy of waypoints |
| `map`    | `[batch, cells, cells, 15]`              | one with a map of the task |
| `places` | `[batch, waypoints, 5, 2]`               | the same: where waypoints read it, column and row |
| `base`   | `[batch, waypoints, dof]`                | one of robots with joints: the step it adds to |

Batch and waypoints are free. The file carries the policy's card as the property `sidestep`.
"""

from __future__ import annotations

import json
from os import PathLike, fspath, replace
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from ._sidestep import Policy

# What every onnxruntime since 1.13 reads.
OPSET, IR = 17, 8
_BATCH, _WAYPOINTS = "batch", "waypoints"


class _Graph:
    """Nodes and constants under way; a node is called as its output."""

    def __init__(self, tensors: dict[str, NDArray[np.float32]]):
        self.tensors = tensors
        self.nodes: list[Any] = []
        self.constants: list[Any] = []
        self.inputs: list[Any] = []

    def input(self, name: str, *shape: int | str) -> str:
        self.inputs.append(helper.make_tensor_value_info(name, TensorProto.FLOAT, shape))
        return name

    def constant(self, value: Any, dtype: Any = np.float32) -> str:
        name = f"c{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.ascontiguousarray(value, dtype), name))
        return name

    def add(self, op: str, *inputs: str, output: str = "", **attributes: Any) -> str:
        name = output or f"{op.lower()}{len(self.nodes)}"
        self.nodes.append(helper.make_node(op, inputs, [name], name=name, **attributes))
        return name

    def layer(self, name: str) -> tuple[NDArray[np.float32], str]:
        return self.tensors[f"{name}.weight"], self.constant(self.tensors[f"{name}.bias"])

    def dense(self, x: str, name: str) -> str:
        weight, bias = self.layer(name)
        return self.add("Gemm", x, self.constant(weight), bias, transB=1)

    def convolve(self, x: str, name: str, shape: tuple[int, ...], to: tuple[int, ...], **attributes: Any) -> str:
        """A layer as a convolution: its weights as `shape`, their axes then in the order `to`, channels second."""
        weight, bias = self.layer(name)
        return self.add("Conv", x, self.constant(weight.reshape(shape).transpose(to)), bias, **attributes)


def _perceptron(g: _Graph, x: str, count: int) -> str:
    for index in range(count):
        x = g.dense(x, f"layers.{index}")
        if index + 1 < count:
            x = g.add("Tanh", x)
    return x


def _image(g: _Graph, x: str, sizes: list[int], at: int) -> str:
    pixels, side = 64 * 64, 64
    others = sizes[0] - pixels
    cut = g.constant([at, pixels, others - at], np.int64)
    before, image, after = f"before{len(g.nodes)}", "image", "after"
    g.nodes.append(helper.make_node("Split", [x, cut], [before, image, after], name="split", axis=1))
    y = g.add("Reshape", image, g.constant([0, 1, side, side], np.int64))
    for index, (stride, padding) in enumerate([(4, 2), (2, 1)]):
        name = f"convolutions.{index}"
        shape = g.tensors[f"{name}.weight"].shape
        strides, pads = [stride] * 2, [padding] * 4
        y = g.add("Relu", g.convolve(y, name, shape, (0, 3, 1, 2), strides=strides, pads=pads))
    # Ours are row by row with the channels last.
    y = g.add("Flatten", g.add("Transpose", y, perm=[0, 2, 3, 1]))
    y = _perceptron(g, y, len(sizes) - 2)
    if others:
        y = g.add("Add", y, g.dense(g.add("Concat", before, after, axis=1), "skip.0"))
    return y


def _map_features(g: _Graph, first: int, cells: int, channels: int, dilations: list[int]) -> str:
    """What waypoints read of the map, `[batch, waypoints, 5 channels]`, by convolutions and bilinear."""
    h = g.add("Transpose", g.input("map", _BATCH, cells, cells, 15), perm=[0, 3, 1, 2])
    h = g.add("Relu", g.convolve(h, f"layers.{first}", (channels, 1, 1, 15), (0, 3, 1, 2)))
    for index, d in enumerate(dilations):
        near = g.convolve(
            h, f"layers.{first + 1 + index}", (channels, 3, 3, channels), (0, 3, 1, 2), dilations=[d, d], pads=[d] * 4
        )
        h = g.add("Relu", g.add("Add", h, near))
    places = g.input("places", _BATCH, _WAYPOINTS, 5, 2)
    grid = g.add("Sub", g.add("Mul", places, g.constant(2 / (cells - 1))), g.constant(1.0))
    read = g.add("GridSample", h, grid, align_corners=1, mode="bilinear", padding_mode="border")
    read = g.add("Transpose", read, perm=[0, 2, 3, 1])
    return g.add("Reshape", read, g.constant([0, 0, -1], np.int64))


def _waypoint(g: _Graph, rows: str, card: dict[str, Any], layout: dict[str, Any]) -> str:
    inputs, width, *dilations = card["sizes"]
    weight, bias = g.layer("layers.0")
    head = 2 * len(dilations) + 1
    if layout["map"]:
        cells, channels, spread, (at, end) = (layout["map"][k] for k in ("cells", "channels", "dilations", "features"))
        features = _map_features(g, head + 1, cells, channels, spread)
        seen = weight[:, at:end]
        extra = g.add("MatMul", features, g.constant(seen.T))
        weight = np.concatenate([weight[:, :at], 0 * seen, weight[:, end:]], axis=1)
        h = g.add("Add", g.add("MatMul", rows, g.constant(weight.T)), extra)
        h = g.add("Transpose", g.add("Relu", g.add("Add", h, bias)), perm=[0, 2, 1])
    else:
        h = g.add("Transpose", rows, perm=[0, 2, 1])
        h = g.add("Relu", g.convolve(h, "layers.0", (width, 1, inputs), (0, 2, 1)))
    for block, d in enumerate(dilations):
        # The neighbours i - d, i and i + d beside each other.
        near = g.convolve(h, f"layers.{2 * block + 1}", (width, 3, width), (0, 2, 1), dilations=[d], pads=[d, d])
        out = g.convolve(g.add("Relu", near), f"layers.{2 * block + 2}", (width, 1, width), (0, 2, 1))
        h = g.add("Add", h, out)
    out = g.convolve(h, f"layers.{head}", (card["dof"], 1, width), (0, 2, 1))
    return g.add("Transpose", out, perm=[0, 2, 1])


def to_model(policy: Policy | str | PathLike[str]) -> onnx.ModelProto:
    """The network of a policy, or of a policy file or name."""
    policy = policy if isinstance(policy, Policy) else Policy.load(fspath(policy))
    card, layout = {"dof": 2} | policy.card, policy.layout
    g = _Graph(policy.tensors())
    if card["architecture"] == "waypoint":
        raw = _waypoint(g, g.input("rows", _BATCH, _WAYPOINTS, card["sizes"][0]), card, layout)
        waypoints: int | str = _WAYPOINTS
    else:
        rows, waypoints = g.input("rows", _BATCH, card["sizes"][0]), card["waypoints"]
        sizes, at = card["sizes"], layout["image_at"]
        read = _perceptron(g, rows, len(sizes) - 1) if at is None else _image(g, rows, sizes, at)
        raw = g.add("Reshape", read, g.constant([0, waypoints, card["dof"]], np.int64))
    rule = card["action"]
    update = g.add("Mul", raw, g.constant(rule["scale"]))
    if card["observation"][0].startswith("joints:"):
        update = g.add("Add", update, g.input("base", _BATCH, _WAYPOINTS, card["dof"]))
    g.add("Clip", update, g.constant(-rule["limit"]), g.constant(rule["limit"]), output="update")
    answer = helper.make_tensor_value_info("update", TensorProto.FLOAT, [_BATCH, waypoints, card["dof"]])
    graph = helper.make_graph(g.nodes, "sidestep", g.inputs, [answer], g.constants)
    opset = helper.make_opsetid("", OPSET)
    model = helper.make_model(graph, opset_imports=[opset], ir_version=IR, producer_name="sidestep")
    helper.set_model_props(model, {"sidestep": json.dumps(policy.card)})
    onnx.checker.check_model(model, full_check=True)
    return model


def export(policy: Policy | str | PathLike[str], path: str | PathLike[str]) -> None:
    """Writes the network of a policy, a policy file or a name to a file, which is there whole or not at all."""
    part = f"{fspath(path)}.part"
    onnx.save(to_model(policy), part)
    replace(part, path)
