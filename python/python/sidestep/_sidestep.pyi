from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Batch",
    "distances",
    "Objective",
    "Plan",
    "certify",
    "plan",
    "plan_batch",
    "planners",
    "shortest_path",
    "Policy",
    "Robot",
    "Scene",
    "Task",
    "read",
    "read_problems",
    "suite",
    "write",
    "VERSION",
    "main",
]

VERSION: Final[str]

_Path = str | PathLike[str]
_Point = Sequence[float]
_Array = NDArray[np.float32]
_Step = Callable[[_Array, float, _Array], NDArray[np.floating[Any]]]
_Planner = str | Policy | Callable[[int, int], _Step]
_Cost = Callable[[_Array], tuple[float, NDArray[np.floating[Any]]]]

@final
class Task:
    def __new__(
        cls,
        bounds: Sequence[_Point],
        start: _Point,
        goal: _Point,
        *,
        rects: Sequence[Sequence[float]] = ...,
        circles: Sequence[Sequence[float]] = ...,
        polygons: Sequence[Sequence[_Point]] = ...,
        grid: NDArray[np.bool_] | None = None,
        resolution: float = 1.0,
        origin: _Point = ...,
        robot_radius: float = 0.0,
        name: str = ...,
    ) -> Task: ...
    @property
    def name(self) -> str: ...
    @property
    def dof(self) -> int: ...
    @property
    def start(self) -> NDArray[np.float64]: ...
    @property
    def goal(self) -> NDArray[np.float64]: ...
    @property
    def coordinates(self) -> list[str]: ...
    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]] | None: ...
    @property
    def obstacles(self) -> list[tuple[str, list[tuple[float, float]]]]: ...
    @property
    def robot_radius(self) -> float | None: ...
    def between(self, start: _Point | None = None, goal: _Point | None = None) -> Task: ...
    def to_json(self) -> str: ...
    @staticmethod
    def from_json(text: str) -> Task: ...
    def __reduce__(self) -> tuple[object, tuple[str]]: ...

@final
class Robot:
    @staticmethod
    def from_urdf(
        urdf: _Path,
        *,
        srdf: _Path | None = None,
        joints: Sequence[str] | None = None,
        held: Mapping[str, float] = ...,
        overhang: float = 0.01,
    ) -> Robot: ...
    @staticmethod
    def load(path: _Path) -> Robot: ...
    @staticmethod
    def from_json(text: str) -> Robot: ...
    def to_json(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def dof(self) -> int: ...
    @property
    def joints(self) -> list[str]: ...
    @property
    def limits(self) -> NDArray[np.float64]: ...
    def task(self, scene: Scene, start: Sequence[float], goal: Sequence[float], *, name: str = ...) -> Task: ...
    def __reduce__(self) -> tuple[object, tuple[str]]: ...

@final
class Scene:
    def __new__(cls, objects: Sequence[Mapping[str, Any]] | None = None) -> Scene: ...
    @staticmethod
    def load(path: _Path, *, point_radius: float = 0.01) -> Scene: ...
    @property
    def names(self) -> list[str]: ...
    def with_objects(self, objects: Sequence[Mapping[str, Any]]) -> Scene: ...
    def without(self, names: Sequence[str]) -> Scene: ...

@final
class Plan:
    @property
    def status(self) -> str: ...
    @property
    def solved(self) -> bool: ...
    @property
    def reason(self) -> str: ...
    @property
    def waypoints(self) -> NDArray[np.float64] | None: ...
    @property
    def length(self) -> float | None: ...
    @property
    def clearance(self) -> float | None: ...
    @property
    def iterations(self) -> int: ...
    @property
    def origin(self) -> str: ...
    @property
    def time_us(self) -> float: ...
    @property
    def task(self) -> Task: ...
    @property
    def trace(self) -> NDArray[np.float64] | None: ...

@final
class Policy:
    def __new__(cls, card: Mapping[str, Any], tensors: Mapping[str, NDArray[np.float32]]) -> Policy: ...
    @staticmethod
    def load(path: _Path) -> Policy: ...
    @staticmethod
    def from_bytes(bytes: bytes) -> Policy: ...
    def to_bytes(self) -> bytes: ...
    def save(self, path: _Path) -> None: ...
    @property
    def card(self) -> dict[str, Any]: ...
    @property
    def layout(self) -> dict[str, Any]: ...
    def tensors(self) -> dict[str, NDArray[np.float32]]: ...
    def look(
        self, tasks: Sequence[Task], x: NDArray[np.float32], *, profile: str | None = None
    ) -> tuple[dict[str, NDArray[np.float32]], NDArray[np.float32]]: ...
    def __reduce__(self) -> tuple[object, tuple[bytes]]: ...

@final
class Objective:
    def __new__(
        cls, tasks: Sequence[Task], *, waypoints: int = 10, profile: str = "default", cost: _Cost | None = None
    ) -> Objective: ...
    @property
    def shape(self) -> tuple[int, int, int]: ...
    def straight_lines(self) -> NDArray[np.float32]: ...
    def cost(self, x: NDArray[np.float32]) -> NDArray[np.float32]: ...
    def cost_and_gradient(self, x: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]: ...
    def certified(self, x: NDArray[np.float32]) -> NDArray[np.bool_]: ...
    def to_task(self, x: NDArray[np.float32]) -> NDArray[np.float64]: ...
    def to_normalised(self, points: NDArray[np.float64]) -> NDArray[np.float32]: ...

@final
class Batch:
    def __new__(
        cls,
        tasks: Sequence[Task],
        count: int,
        *,
        seed: int = 0,
        waypoints: int = 10,
        profile: str = "paper",
        parts: Sequence[str] | None = None,
        mu: float = 0.1,
        bonus: float = 0.0,
        limit: int | None = None,
        reset: str = "same-step",
    ) -> Batch: ...
    @property
    def count(self) -> int: ...
    @property
    def observation_size(self) -> int: ...
    @property
    def action_size(self) -> int: ...
    def waypoints(self) -> NDArray[np.float32]: ...
    def reset(self, mask: Sequence[bool] | None = None) -> NDArray[np.float32]: ...
    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.float32],
        NDArray[np.bool_],
        NDArray[np.bool_],
        NDArray[np.float32],
        NDArray[np.int64],
        NDArray[np.float32],
    ]: ...

def read(
    path: _Path,
    *,
    start: _Point | None = None,
    goal: _Point | None = None,
    robot_radius: float | None = None,
    seed: int = 0,
) -> list[Task]: ...
def read_problems(
    path: _Path, *, urdf: _Path, srdf: _Path | None = None, overhang: float = 0.01
) -> list[Task]: ...
def suite(name: str, count: int, *, seed: int = 0) -> list[Task]: ...
def write(path: _Path, tasks: Sequence[Task]) -> None: ...
def plan(
    task: Task,
    planner: _Planner | None = None,
    *,
    seed: int = 0,
    steps: int = 200,
    starts: int = 1,
    start_strategy: str = "via-point",
    waypoints: int | None = None,
    profile: str | None = None,
    margin: float = 0.0,
    budget_ms: float | None = None,
    best: bool = False,
    trace: bool = False,
    cost: _Cost | None = None,
) -> Plan: ...
def plan_batch(
    tasks: Sequence[Task],
    planner: _Planner | None = None,
    *,
    seed: int = 0,
    steps: int = 200,
    starts: int = 1,
    start_strategy: str = "via-point",
    waypoints: int | None = None,
    profile: str | None = None,
    margin: float = 0.0,
    budget_ms: float | None = None,
    best: bool = False,
    cost: _Cost | None = None,
) -> list[Plan]: ...
def certify(task: Task, path: NDArray[np.float64]) -> str | None: ...
def distances(
    task: Task, points: NDArray[np.float64]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]: ...
def shortest_path(task: Task) -> tuple[float, NDArray[np.float64]] | None: ...
def planners() -> list[str]: ...
def main(arguments: Sequence[str]) -> int: ...
