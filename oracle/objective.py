"""Writes golden/objective.json: distance, objective, gradient, feasibility and descent for both profiles.

`paper` cases come from `paper_profile` (the original's quirks included), `exact` cases from `exact_profile` (the corrected
default). Before a case is written it is checked: exact distances against shapely (circles as polygons of 16384 edges), exact
gradients against central differences, clearances against a dense walk along the path, feasibility verdicts against a shift of
every box by 1e-6 pixels. A draw whose verdict or gradient hangs on a tie is drawn again.

A tolerance t in the file means |found - golden| <= t max(1, |golden|), for float64 code.
"""

import numpy as np

import cross_checks
import exact_profile
import golden
import paper_profile as paper
from union_boundary import outline

DESCENT_STEPS = 200
RECORDED_STEPS = (1, 10, 50, 200)

TOLERANCES = {
    "paper.distance": 1e-9,
    "paper.values": 1e-9,
    "paper.gradients": 1e-9,
    "paper.descent.waypoints": 1e-8,
    "exact.distance": 1e-8,
    "exact.values": 1e-8,
    "exact.gradients": 1e-8,
    "exact.clearance": 1e-8,
}


# --- paper profile ---


# How many tasks of each sort are kept: the straight line is feasible; found within 10 steps; found later; found and lost again by
# the last step; never found.
QUOTAS = {"line": 3, "early": 3, "late": 3, "lost": 1, "never": 2}


def paper_cases(seed=20220):
    """Tasks of the paper's generator, drawn until every sort has its quota."""
    rng = np.random.default_rng(seed)
    cases = {sort: [] for sort in QUOTAS}
    while any(len(cases[sort]) < quota for sort, quota in QUOTAS.items()):
        case = paper_case(paper.draw_task(rng), rng)
        if case is None:
            continue
        sort = sort_of(case["descent"])
        if len(cases[sort]) < QUOTAS[sort]:
            cases[sort].append({"name": f"{sort}-{len(cases[sort])}", **case})
    return [case for group in cases.values() for case in group]


def sort_of(descent):
    """Which of `QUOTAS` a descent falls under."""
    first = descent["first_feasible_step"]
    if first is None:
        return "never"
    if not descent["end_feasible"]:
        return "lost"
    return "line" if first == 0 else "early" if first <= 10 else "late"


def paper_case(task, rng):
    """One task's golden values, or None where a feasibility verdict hangs on rounding."""
    objective = paper.Objective(task)
    line = paper.straight_line(objective.start, objective.goal)
    waypoints = {
        "straight": golden.decimals(line, 6),
        "noisy": golden.decimals(line + rng.normal(0, 0.3, line.shape), 6),
        "random": golden.decimals(rng.uniform(0, 6.4, line.shape), 6),
    }
    descent = list(objective.descent(line, DESCENT_STEPS))
    verdicts = [robust_verdict(objective, w) for w in (*waypoints.values(), *descent)]
    if None in verdicts:
        return None
    feasible = verdicts[len(waypoints) :]
    points = paper_points(rng)
    return {
        "obstacles": [{"rect": [low.tolist(), high.tolist()]} for low, high in zip(task.lower, task.upper)],
        "start": task.start,
        "goal": task.goal,
        "points_world": points,
        "distance": objective.signed_distance(points),
        "sobel_gradient": objective.distance_gradient(points),
        "trajectories": [paper_trajectory(objective, kind, w) for kind, w in waypoints.items()],
        "descent": {
            "trajectories": [{"steps": k, "waypoints_world": descent[k]} for k in RECORDED_STEPS],
            "first_feasible_step": feasible.index(True) if any(feasible) else None,
            "end_feasible": feasible[-1],
        },
    }


def paper_points(rng):
    """26 points in the field, 8 around it, 6 on pixel centres: [40, 2] world units."""
    field = rng.uniform(0, 6.4, (26, 2))
    around = rng.uniform(-1, 7.4, (64, 2))
    around = around[np.any((around < 0) | (around > 6.4), axis=1)][:8]
    centres = paper.to_world(np.vstack([[[0, 0], [63, 63]], rng.integers(0, 64, (4, 2))]))
    return golden.decimals(np.vstack([field, around, centres]), 4)


def paper_trajectory(objective, kind, waypoints):
    """Objective, gradients and verdict of one trajectory."""
    return {
        "kind": kind,
        "waypoints_world": waypoints,
        "objective": objective.value(waypoints),
        "obstacle_cost": objective.obstacle_cost(waypoints),
        "length_cost": objective.length_cost(waypoints),
        "gradient_paper": objective.gradient(waypoints),
        "gradient_true": objective.gradient(waypoints, sobel_divisor=8.0),
        "feasible": objective.feasible(waypoints),
    }


def robust_verdict(objective, waypoints, slack=1e-6):
    """`feasible`, or None if moving every side by a millionth of a pixel changes it."""
    verdicts = {objective.feasible(waypoints, shift) for shift in (-slack, 0.0, slack)}
    return verdicts.pop() if len(verdicts) == 1 else None


# --- exact profile ---

FIELD = [[0, 0], [64, 64]]
OFFSET_FIELD = [[-20, 10], [108, 74]]


def rect(rng, bounds, sides=(6, 20)):
    low = rng.uniform(bounds[0], np.array(bounds[1]) - 4)
    return {"rect": golden.decimals([low, low + rng.uniform(*sides, 2)], 3).tolist()}


def circle(rng, bounds, radii=(3, 10)):
    return {
        "circle": {
            "center": golden.decimals(rng.uniform(*bounds), 3).tolist(),
            "radius": float(golden.decimals(rng.uniform(*radii), 3)),
        }
    }


def polygon(rng, bounds):
    """Three to seven vertices on an ellipse, counter-clockwise, so convex."""
    count = rng.integers(3, 8)
    angles = (np.arange(count) + rng.uniform(0, 0.6, count)) * 2 * np.pi / count
    radii = rng.uniform(4, 11, 2)
    vertices = rng.uniform(*bounds) + radii * np.column_stack([np.cos(angles), np.sin(angles)])
    return {"polygon": golden.decimals(vertices, 3).tolist()}


def box(x0, y0, x1, y1):
    return {"rect": [[x0, y0], [x1, y1]]}


def ball(x, y, radius):
    return {"circle": {"center": [x, y], "radius": radius}}


def drawn(rng, bounds, rects=0, circles=0, polygons=0):
    makers = [rect] * rects + [circle] * circles + [polygon] * polygons
    return [make(rng, bounds) for make in makers]


def exact_worlds(rng):
    """(name, bounds, obstacles, robot radius) of every exact case."""
    return [
        ("empty", FIELD, [], 0.0),
        ("one-rect", FIELD, [box(20, 24, 40, 36)], 0.0),
        ("crossing-rects", FIELD, [box(12, 28, 52, 36), box(28, 10, 36, 54)], 0.0),
        ("abutting-rects", FIELD, [box(16, 20, 30, 40), box(30, 20, 44, 40), box(30, 40, 50, 48), box(30, 20, 40, 40)], 0.0),
        ("nested", FIELD, [box(10, 10, 34, 34), ball(22, 22, 6), ball(46, 44, 12), box(42, 40, 50, 47)], 0.0),
        ("poking-out", FIELD, [box(-8, 20, 14, 70), ball(64, 10, 9), box(80, 80, 90, 90), ball(30, 66, 7)], 0.0),
        ("rects", FIELD, drawn(rng, FIELD, rects=10), 0.0),
        ("circles", FIELD, drawn(rng, FIELD, circles=9), 0.0),
        ("polygons", FIELD, drawn(rng, FIELD, polygons=8), 0.0),
        ("mixed", FIELD, drawn(rng, FIELD, rects=4, circles=3, polygons=3), 0.0),
        ("mixed-sparse", FIELD, drawn(rng, FIELD, rects=1, circles=2, polygons=2), 0.0),
        ("mixed-disc", FIELD, drawn(rng, FIELD, rects=3, circles=3, polygons=2), 1.5),
        ("rects-disc", FIELD, drawn(rng, FIELD, rects=6), 1.5),
        ("gap-disc", FIELD, [box(0, 28, 30, 36), box(34, 28, 64, 36), ball(32, 50, 4)], 1.5),
        ("offset-bounds", OFFSET_FIELD, drawn(rng, OFFSET_FIELD, rects=4, circles=4, polygons=4), 0.0),
        ("offset-bounds-disc", OFFSET_FIELD, drawn(rng, OFFSET_FIELD, rects=3, circles=3, polygons=3), 1.5),
    ]


# (waypoints, substeps, epsilon, lambda) of a case's four trajectories, taken in turn.
SETTINGS = [
    (1, 1, 1.0, 0.1), (5, 5, 1.0, 0.1), (10, 5, 1.0, 0.1), (24, 8, 0.5, 0.0125),
    (10, 8, 0.3, 1.0), (24, 5, 1.0, 0.1), (5, 1, 2.0, 0.02), (1, 8, 1.0, 0.5),
    (10, 1, 0.5, 0.05), (5, 8, 1.0, 0.0125), (24, 1, 2.0, 0.1),
]  # fmt: skip
KINDS = ("straight", "noisy", "random", "descended")


def exact_cases(seed=20221):
    """Every exact world with distances and trajectories."""
    rng = np.random.default_rng(seed)
    cases = []
    for name, bounds, obstacles, radius in exact_worlds(rng):
        space = exact_profile.Space(bounds, obstacles, radius)
        points = exact_points(rng, space)
        distance, gradient, smooth = space.distance(points)
        cross_checks.check_distance(space, points, distance, gradient, smooth)
        start, goal = free_pair(rng, space)
        trajectories = []
        for k, kind in enumerate(KINDS):
            settings = SETTINGS[(len(cases) * len(KINDS) + k) % len(SETTINGS)]
            trajectories.append(exact_trajectory(rng, space, start, goal, kind, *settings))
        cases.append(
            {
                "name": name,
                "bounds": bounds,
                "obstacles": obstacles,
                "robot_radius": radius,
                "start": start,
                "goal": goal,
                "scale": space.scale,
                "points": points,
                "distance": distance,
                "gradient": [g if ok else None for g, ok in zip(gradient, smooth)],
                "trajectories": trajectories,
            }
        )
    return cases


def exact_points(rng, space):
    """28 points anywhere in or a little around the bounds and 12 near the obstacles' edges (those inside the union too): [40, 2] task units."""
    anywhere = rng.uniform(space.lower - 4, space.upper + 4, (28, 2))
    edges = [edge for obstacle in space.obstacles for edge in outline(obstacle)]
    near = [edges[k].at(rng.uniform()) + rng.normal(0, 0.5, 2) for k in rng.integers(0, len(edges), 12 if edges else 0)]
    return golden.decimals(np.vstack([anywhere, *near]), 4)


def free_pair(rng, space):
    """Start and goal at least half a unit clear and well apart, task units."""
    while True:
        pair = golden.decimals(rng.uniform(space.lower, space.upper, (2, 2)), 3)
        if space.distance(pair)[0].min() > 0.5 and np.linalg.norm(pair[1] - pair[0]) > 25:
            return pair


def exact_trajectory(rng, space, start, goal, kind, waypoints, substeps, epsilon, weight):
    """Values and checked gradient of one trajectory whose cost points are all off the distance's kinks."""
    objective = exact_profile.Objective(space, start, goal, substeps, epsilon, weight)
    line = paper.straight_line(objective.start, objective.goal, waypoints)
    for attempt in range(200):
        jitter = rng.normal(0, 0.01 if attempt and kind == "straight" else 0.0, line.shape)
        path = line + jitter
        if kind in ("noisy", "descended"):
            path = line + rng.normal(0, 0.25, line.shape)
        if kind == "random":
            path = space.to_normalised(rng.uniform(space.lower, space.upper, line.shape))
        if kind == "descended":
            for _ in range(60):
                path = path - 0.3 / (1 + weight * 8) * objective.gradient(path)[0]
        path = golden.decimals(path, 6)
        gradient, smooth = objective.gradient(path)
        if smooth:
            break
    else:
        raise RuntimeError(f"no smooth {kind} trajectory found")
    cross_checks.check_gradient(objective, path, gradient)
    vertices = space.to_task(objective.vertices(path))
    clearance = space.clearance(vertices)
    cross_checks.check_clearance(space, vertices, clearance)
    obstacle, length = objective.parts(path)
    return {
        "kind": kind,
        "substeps": substeps,
        "epsilon": epsilon,
        "lambda": weight,
        "waypoints_normalised": path,
        "objective": objective.value(path),
        "obstacle_cost": obstacle,
        "length_cost": length,
        "gradient": gradient,
        "clearance": clearance,
    }


def main():
    golden.write(
        "objective.json",
        {
            "format": "sidestep.oracle.objective/1",
            "command": "python objective.py",
            "tolerances": TOLERANCES,
            "paper": paper_cases(),
            "exact": exact_cases(),
        },
    )
    print("largest differences to the second computation:", {k: f"{v:.1e}" for k, v in cross_checks.worst.items()})


if __name__ == "__main__":
    main()
