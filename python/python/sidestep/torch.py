"""Policies as PyTorch modules and back (`pip install sidestep[torch]`).

    module = sidestep.torch.module("sidestep-1-small")
    update = module(**{name: torch.from_numpy(a) for name, a in policy.look(tasks, x)[0].items()})
    ...                                                # train it as you like
    sidestep.torch.policy(module).save("mine.safetensors")      # `plan` and `bench` run it

A module's parameters have the names and shapes of the policy file's tensors, its inputs those of `sidestep.onnx`, and it
answers the update of the waypoints, scaled and clipped (`scaled=False`: what the network says, before that).
"""

from __future__ import annotations

from os import PathLike, fspath
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional as F

from ._sidestep import Policy


class Module(nn.Module):
    """The network of a policy, with its card."""

    def __init__(self, policy: Policy):
        super().__init__()
        self.card = {"dof": 2} | policy.card
        self.layout = policy.layout
        for name, values in policy.tensors().items():
            *path, last = name.split(".")
            place: nn.Module = self
            for step in path:
                if not hasattr(place, step):
                    place.add_module(step, nn.Module())
                place = getattr(place, step)
            place.register_parameter(last, nn.Parameter(torch.from_numpy(values.copy())))

    def forward(
        self,
        rows: Tensor,
        map: Tensor | None = None,
        places: Tensor | None = None,
        base: Tensor | None = None,
        *,
        scaled: bool = True,
    ) -> Tensor:
        if self.card["architecture"] == "waypoint":
            raw = self._waypoint(rows, map, places)
        else:
            raw = self._whole(rows).reshape(len(rows), self.card["waypoints"], self.card["dof"])
        if not scaled:
            return raw
        rule = self.card["action"]
        update = rule["scale"] * raw if base is None else rule["scale"] * raw + base
        return update.clamp(-rule["limit"], rule["limit"])

    def _layer(self, name: str) -> tuple[Tensor, Tensor]:
        return self.get_parameter(f"{name}.weight"), self.get_parameter(f"{name}.bias")

    def _dense(self, name: str, x: Tensor) -> Tensor:
        return F.linear(x, *self._layer(name))

    def _whole(self, x: Tensor) -> Tensor:
        sizes, at = self.card["sizes"], self.layout["image_at"]
        if at is None:
            return self._perceptron(x, len(sizes) - 1)
        image, others = x[:, at : at + 64 * 64], torch.cat([x[:, :at], x[:, at + 64 * 64 :]], 1)
        y = image.reshape(len(x), 1, 64, 64)
        for index, (stride, padding) in enumerate([(4, 2), (2, 1)]):
            weight, bias = self._layer(f"convolutions.{index}")
            y = F.relu(F.conv2d(y, weight.permute(0, 3, 1, 2), bias, stride, padding))
        # Ours are row by row with the channels last.
        y = self._perceptron(y.permute(0, 2, 3, 1).flatten(1), len(sizes) - 2)
        return y + self._dense("skip.0", others) if others.shape[1] else y

    def _perceptron(self, x: Tensor, count: int) -> Tensor:
        for index in range(count):
            x = self._dense(f"layers.{index}", x)
            x = torch.tanh(x) if index + 1 < count else x
        return x

    def _waypoint(self, rows: Tensor, map: Tensor | None, places: Tensor | None) -> Tensor:
        _, width, *dilations = self.card["sizes"]
        head = 2 * len(dilations) + 1
        own = self.layout["map"]
        if own is not None:
            if map is None or places is None:
                raise ValueError("map, places: missing; this policy has a map of the task")
            first, last = own["features"]
            features = self._features(map, places, head + 1, own)
            rows = torch.cat([rows[..., :first], features, rows[..., last:]], -1)
        h = F.relu(self._dense("layers.0", rows)).transpose(1, 2)
        for block, d in enumerate(dilations):
            weight, bias = self._layer(f"layers.{2 * block + 1}")
            # The neighbours i - d, i and i + d beside each other.
            taps = weight.reshape(width, 3, width).transpose(1, 2)
            near = F.relu(F.conv1d(h, taps, bias, dilation=d, padding=d))
            weight, bias = self._layer(f"layers.{2 * block + 2}")
            h = h + F.conv1d(near, weight[..., None], bias)
        return self._dense(f"layers.{head}", h.transpose(1, 2))

    def _features(self, map: Tensor, places: Tensor, first: int, own: dict[str, Any]) -> Tensor:
        channels = own["channels"]
        h = F.relu(self._dense(f"layers.{first}", map)).permute(0, 3, 1, 2)
        for index, d in enumerate(own["dilations"]):
            weight, bias = self._layer(f"layers.{first + 1 + index}")
            taps = weight.reshape(channels, 3, 3, channels).permute(0, 3, 1, 2)
            h = F.relu(h + F.conv2d(h, taps, bias, dilation=d, padding=d))
        grid = places * (2 / (own["cells"] - 1)) - 1
        read = F.grid_sample(h, grid, mode="bilinear", padding_mode="border", align_corners=True)
        return read.permute(0, 2, 3, 1).flatten(2)


def module(policy: Policy | str | PathLike[str]) -> Module:
    """The network of a policy, or of a policy file or name."""
    return Module(policy if isinstance(policy, Policy) else Policy.load(fspath(policy)))


def policy(module: Module, *, training: Any = None, licence: str | None = None) -> Policy:
    """The policy of a module, with its card; `training` and `licence` say where its numbers come from now."""
    card = dict(module.card)
    if training is not None:
        card["training"] = training
    if licence is not None:
        card["licence"] = licence
    state = module.state_dict()
    return Policy(card, {name: _array(values) for name, values in state.items()})


def _array(values: Tensor) -> NDArray[np.float32]:
    return values.detach().cpu().numpy().astype(np.float32)


def perceptron(
    layers: list[nn.Linear],
    *,
    observation: list[str],
    waypoints: int = 10,
    dof: int = 2,
    profile: str = "paper",
    training: Any = None,
    licence: str = "MIT OR Apache-2.0",
) -> Policy:
    """The policy of dense layers with tanh between them, from the observation of an environment to its action."""
    tensors = {}
    for index, layer in enumerate(layers):
        tensors[f"layers.{index}.weight"] = _array(layer.weight)
        bias = torch.zeros(layer.out_features) if layer.bias is None else layer.bias
        tensors[f"layers.{index}.bias"] = _array(bias)
    card = {
        "format": "sidestep.policy/1",
        "architecture": "mlp",
        "sizes": [layers[0].in_features, *(layer.out_features for layer in layers)],
        "waypoints": waypoints,
        "dof": dof,
        "observation": observation,
        "profile": profile,
        # As the environments apply actions.
        "action": {"scale": 1.0, "limit": 1.0, "keep_inside": True},
        "training": training if training is not None else {"by": "another program"},
        "licence": licence,
    }
    return Policy(card, tensors)
