"""Time and length of plans: OMPL's RRT-Connect with simplification (C++, exact checks) beside sidestep's planners.

Both plan the same solvable tasks of a suite in the same run, one task after the other on one thread. OMPL's times are those of
`solve` and `simplifySolution` alone; sidestep's hold everything from the task to the answer, the scene's preparation included.
Needs g++, OMPL's headers (Debian: libompl-dev) and the program `sidestep`.

    python3 oracle/compare_ompl.py --sidestep target/release/sidestep --json reports/speed/ompl.json
"""

import argparse
import json
import platform
import statistics
import subprocess
import tempfile
from datetime import UTC, datetime
from pathlib import Path

SOURCE = Path(__file__).with_name("ompl_planners.cpp")
PLANNERS = ["sidestep-1-small", "sidestep-1", "auto", "rrt-connect", "shortest-path"]


def run(*command, **more):
    return subprocess.run(command, check=True, capture_output=True, text=True, **more).stdout


def build(folder):
    """The program of ompl_planners.cpp."""
    program = folder / "ompl_planners"
    includes = run("pkg-config", "--cflags-only-I", "ompl").split()
    run("g++", "-O3", "-march=native", "-DNDEBUG", "-std=c++17", *includes, str(SOURCE), "-o", str(program), "-lompl")
    return program


def line(task):
    """A task as ompl_planners.cpp reads it."""
    (low, high), rects = task["bounds"], [o["rect"] for o in task["obstacles"]]
    numbers = [*low, *high, *task["start"], *task["goal"], len(rects)]
    numbers += [value for a, b in rects for value in (*a, *b)]
    return " ".join(map(str, numbers))


def quantile(values, q):
    values = sorted(values)
    return values[min(int(q * len(values)), len(values) - 1)]


def row(planner, solved, micros, ratios):
    return {
        "planner": planner,
        "solved_of_solvable": solved,
        "us_per_plan_median": quantile(micros, 0.5),
        "us_per_plan_p95": quantile(micros, 0.95),
        "length_ratio_median": statistics.median(ratios),
    }


def ompl_rows(program, tasks, optimal):
    answers = [a.split() for a in run(str(program), input="\n".join(map(line, tasks))).splitlines()]
    solved = [a[0] == "1" for a in answers]
    share = sum(solved) / len(solved)
    plain = [float(a[1]) for a in answers]
    both = [float(a[1]) + float(a[2]) for a in answers]
    ratio = [[float(a[k]) / best for a, best, ok in zip(answers, optimal, solved, strict=True) if ok] for k in (3, 4)]
    return [
        row("ompl rrt-connect", share, plain, ratio[0]),
        row("ompl rrt-connect, simplified", share, both, ratio[1]),
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sidestep", default="target/release/sidestep", help="path of the sidestep program")
    parser.add_argument("--count", type=int, default=1000, help="tasks of each suite")
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--json", type=Path, help="where to write the report")
    args = parser.parse_args()
    suites = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        program = build(folder)
        for suite in ("easy", "hard"):
            path = folder / f"{suite}.jsonl"
            common = ["--suite", suite, "--count", str(args.count), "--seed", str(args.seed)]
            run(args.sidestep, "generate", *common, "--out", str(path))
            # Exit code 1 says that some have no answer.
            oracle = subprocess.run([args.sidestep, "oracle", str(path), "--json"], capture_output=True, text=True)
            answers = json.loads(oracle.stdout)
            lines = path.read_text().splitlines()
            keep = [i for i, answer in enumerate(answers) if answer["answer"] == "solvable"]
            solvable = folder / f"{suite}-solvable.jsonl"
            solvable.write_text("\n".join(lines[i] for i in keep) + "\n")
            tasks = [json.loads(lines[i]) for i in keep]
            rows = ompl_rows(program, tasks, [answers[i]["length"] for i in keep])
            report = folder / "report.json"
            flags = [f for planner in PLANNERS for f in ("--planner", planner)]
            run(args.sidestep, "bench", "--tasks", str(solvable), "--steps", "40", "--timed", str(len(keep)), *flags,
                "--quiet", "--out", str(report))
            for own in json.loads(report.read_text())["rows"]:
                names = ("us_per_plan_median", "us_per_plan_p95", "length_ratio_median")
                rows.append({"planner": own["planner"], "solved_of_solvable": own["success_of_solvable"]}
                            | {name: own[name] for name in names})
            suites[suite] = rows
            print(f"{suite}: {len(keep)} solvable tasks")
            for r in rows:
                print(f"  {r['planner']:30}{100 * r['solved_of_solvable']:7.1f} %{r['us_per_plan_median']:9.1f} us"
                      f"{r['us_per_plan_p95']:10.1f} us{r['length_ratio_median']:8.3f}")
    if args.json:
        version = run("pkg-config", "--modversion", "ompl").strip()
        processor = next((one.split(":")[1].strip() for one in Path("/proc/cpuinfo").read_text().splitlines()
                          if one.startswith("model name")), platform.processor())
        document = {
            "format": "sidestep.oracle.compare/1",
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
            "machine": {"processor": processor, "system": platform.system(), "versions": {"ompl": version}},
            "settings": {"count": args.count, "seed": args.seed, "threads": 1},
            "suites": suites,
        }
        args.json.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
