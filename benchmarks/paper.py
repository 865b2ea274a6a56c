#!/usr/bin/env python3
"""Remakes the paper's tables: every method as its command of lumesh, on case 1 (the carotid phantom) and case 2 (the bifurcation
phantom, as an STL surface), with the paper's figures beside. Markdown on stdout and in OUTPUT/tables.md, all numbers in
OUTPUT/results.json after each method, curves in OUTPUT/*.svg; meshes go at the end.

Usage: paper.py [--program PATH] [--output DIR] [--threads 1,10] [--rounds N] [--keep]        counts, times, angles
       paper.py --literal                                    the paper's parameters to the letter beside lumesh's defaults
       paper.py --large podm podm-sizes case1 case2          50 million tetrahedra, and 100 million of case 2 (12 GiB)
       paper.py --from A/results.json B/results.json         tables and curves of what was measured before

Times are those of whole commands with reading, checking and writing: on one thread CPU seconds, so that other work on the machine
counts little, on more threads wall seconds. A mesher stops by itself after --limit seconds and leaves its best mesh.
"""
import argparse
import functools
import json
import math
import os
import pathlib
import platform
import re
import shlex
import shutil
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "cases")]
import curves  # noqa: E402
import paper_methods  # noqa: E402
import run  # noqa: E402  (timed() and ROOT)

STOPS = ("delaunay", "adapt")
BESIDE = {"literal": "small"}  # Whose curves stand in the same picture.
LENGTH_BAND = "in [0.71, 1.41]"


class Failed(Exception):
    pass


class Bench:
    """Runs methods in the folder that is the current one, and keeps what they were."""

    def __init__(self, arguments):
        self.program = str(pathlib.Path(arguments.program).resolve())
        self.output = arguments.output.resolve()
        self.threads, self.rounds, self.limit = arguments.threads, arguments.rounds, arguments.limit
        self.part = arguments.part
        self.methods = paper_methods.all_methods(self.part)
        self.results = {}
        self.output.mkdir(parents=True, exist_ok=True)

    @functools.cache
    def help_of(self, stage):
        return subprocess.run([self.program, stage, "--help"], capture_output=True, text=True, check=True).stdout

    def has(self, stage, flag):
        """Whether a command of this program has an option."""
        return re.search(rf"(?<![\w-]){flag}(?![\w-])", self.help_of(stage)) is not None

    def timed(self, command, threads):
        words = shlex.split(command)
        limit = ["--time-limit", str(self.limit)] if words[0] in STOPS else []
        count = ["--threads", str(threads)] if self.has(words[0], "--threads,--nthreads") else []
        found = run.timed([self.program, *words, "-q", *count, *limit])
        if found.exit not in (0, 3, 4):
            raise Failed(f"{command}: exit {found.exit}")
        return found

    def needed(self, chosen):
        """The chosen methods and, before them, those that write the files which their commands name."""
        by_file = {word: m for m in self.methods for word in outputs_of(m)}
        keys = set()

        def add(method):
            keys.add(method.key)
            for command in (*method.before, *method.commands, *method.after):
                for word in shlex.split(command):
                    if word in by_file and by_file[word].key not in keys:
                        add(by_file[word])

        for method in chosen:
            add(method)
        return [m for m in self.methods if m.key in keys]

    def measure(self, method):
        most = max(self.threads)
        for command in method.before:
            self.timed(command, most)
        commands, notes = [c.format(delta=self.delta_for(method)) if "{delta}" in c else c for c in method.commands], {}
        times = {}
        for threads in self.threads:
            rounds = []
            for _ in range(self.rounds):
                runs = [self.timed(command, threads) for command in commands]
                rounds.append({"wall": sum(r.seconds for r in runs), "cpu": sum(r.cpu_seconds for r in runs),
                               "mib": max(r.peak_mib for r in runs), "exit": max(r.exit for r in runs)})
            times[threads] = rounds
        for command in method.after:
            self.timed(command, most)
        if any(r["exit"] == 4 for rounds in times.values() for r in rounds):
            notes["stopped"] = self.limit
        return {"name": method.name, "case": method.case, "group": method.group, "commands": commands, "before": method.before,
                "after": method.after, "machine": machine(), "times": times, **notes, **self.evaluated(method)}

    def evaluated(self, method):
        if not method.mesh:
            return {}
        numbers = pathlib.Path(f"{method.key}.json")
        image = f" --image {method.image} --centerline none" if method.image else ""
        self.timed(f"evaluate {method.mesh} --json {numbers}{image}", max(self.threads))
        told = json.loads(numbers.read_text())
        keep = ("valid", "vertices", "tetrahedra", "pyramids", "prisms", "dihedral_deg", "metric_edge_length", "metric_mean_ratio",
                "complexity", "hausdorff_mm", "volume_mm3", "warnings")
        return {"evaluation": {k: told[k] for k in keep if k in told}}

    def delta_for(self, method):
        """The delta of about so many tetrahedra, by the power law through the last two of trials that come near."""
        near, wanted, trials = 0.15, self.part * paper_methods.LARGE_TETRAHEDRA, []
        delta = 1.2 * self.part**-0.2
        while len(trials) < 2 or (trials[-1][1] < near * wanted and len(trials) < 5):
            told = pathlib.Path("trial.json")
            command = method.commands[0].format(delta=delta).replace(method.mesh, "trial.meshb")
            self.timed(f"{command} --json {told}", max(self.threads))
            trials.append((delta, json.loads(told.read_text())["tetrahedra"]))
            if len(trials) == 1:
                delta /= 2
                continue
            (d1, n1), (d2, n2) = trials[-2:]
            delta = round(d2 * (n2 / wanted) ** (math.log(d1 / d2) / math.log(n2 / n1)), 4)
        return delta

    def run(self, chosen):
        failed = []
        for method in self.needed(chosen):
            try:
                result = self.results[method.key] = self.measure(method)
                print(f"{method.key}: {seconds_of(result):.2f} s, {cells_of(result):,} cells", file=sys.stderr, flush=True)
            except Failed as error:
                failed.append(str(error))
                print(error, file=sys.stderr, flush=True)
            self.write(failed)
        return failed

    def read(self, path):
        """Results of an earlier call."""
        told = json.loads(path.read_text())
        for key, result in told["results"].items():
            self.results[key] = result | {"times": {int(n): rounds for n, rounds in result["times"].items()}}
        return told["failed"]

    def write(self, failed):
        told = {"version": subprocess.run([self.program, "--version"], capture_output=True, text=True, check=True).stdout.strip(),
                "threads": self.threads, "rounds": self.rounds, "failed": failed, "results": self.results}
        (self.output / "results.json").write_text(json.dumps(told, indent=1) + "\n")


def outputs_of(method):
    """Names of the files that a method's commands write."""
    for command in (*method.before, *method.commands, *method.after):
        words = shlex.split(command)
        yield from (b for a, b in zip(words, words[1:]) if a in ("-o", "--surface") or (words[0], a) == ("phantom", "--velocity"))
        if words[0] == "convert":
            yield words[-1]


def machine():
    file = pathlib.Path("/proc/cpuinfo")
    model = re.search(r"model name\s*:\s*(.*)", file.read_text() if file.is_file() else "")
    return f"{model.group(1) if model else platform.machine()}, {len(os.sched_getaffinity(0))} cores"


def seconds_of(result, threads=0):
    """CPU seconds on one thread, wall seconds on more; without a number, on the most."""
    threads = threads or max(result["times"])
    return statistics.median(r["cpu" if threads == 1 else "wall"] for r in result["times"][threads])


def cells_of(result):
    found = result.get("evaluation", {})
    return sum(found.get(k, 0) for k in ("tetrahedra", "pyramids", "prisms"))


def short(number):
    """As the paper writes it: 272K, 1.59M."""
    for unit, word in ((1e6, "M"), (1e3, "K")):
        if number >= unit:
            return f"{number / unit:.3g}{word}"
    return f"{number:.3g}" if number else "–"


def table(head, rows):
    if not rows:
        return ""
    return "\n".join([f"| {' | '.join(head)} |", "|---" * len(head) + "|", *(f"| {' | '.join(row)} |" for row in rows), ""])


def performance(bench, methods):
    """Counts, times and rates: the paper's tables 2 to 4, 8, 9, 11 and 12."""
    head = ["the paper's method", "lumesh", "cells", "paper", "points", "paper"]
    threads = sorted({n for m in methods for n in bench.results[m.key]["times"]})
    for n in threads:
        head += [f"s on {n}", "paper", "cells/s", "paper"]
    rows = []
    for m in methods:
        result, paper = bench.results[m.key], m.paper
        points = result.get("evaluation", {}).get("vertices", 0)
        row = [m.name + (" (stopped)" if "stopped" in result else ""), ", ".join(f"`{c.split()[0]}`" for c in m.commands),
               f"{cells_of(result):,}" if m.mesh else "–", short(paper.tetrahedra), f"{points:,}" if points else "–", short(paper.points)]
        of = bench.results.get(m.points_of, {}).get("evaluation", {}).get("vertices", 0)
        cells, papers = (of, 63e3 if of else 0) if not m.mesh else (cells_of(result), paper.tetrahedra)
        for n in threads:
            if n not in result["times"]:
                row += ["–"] * 4
                continue
            seconds, theirs = seconds_of(result, n), paper.seconds.get(n, 0)
            row += [f"{seconds:.2f}", f"{theirs:g}" if theirs else "–", short(cells / seconds), short(papers / theirs if theirs else 0)]
        rows.append(row)
    return table(head, rows)


def angles(bench, methods):
    """Smallest and largest dihedral angles: the paper's tables 5 and 10."""
    rows = []
    for m in (m for m in methods if m.figure == "angles"):
        found = bench.results[m.key]["evaluation"]["dihedral_deg"]
        theirs = [f"{a:g}" for a in m.paper.angles] or ["–", "–"]
        rows.append([m.name, str(m.case), f"{found['min']:.2f}", theirs[0], f"{found['max']:.2f}", theirs[1]])
    return table(["the paper's method", "case", "smallest, degrees", "paper", "largest", "paper"], rows)


def conformity(bench, methods):
    """What the paper's figures of mean ratios and lengths show, in numbers."""
    rows = []
    for m in (m for m in methods if m.figure == "metric"):
        found = bench.results[m.key]["evaluation"]
        lengths, ratios = found["metric_edge_length"], found["metric_mean_ratio"]
        rows.append([m.name, str(m.case), f"{found['tetrahedra']:,}", f"{100 * lengths['fraction_in_band']:.2f} %", f"{lengths['min']:.2f}–"
                     f"{lengths['max']:.2f}", f"{ratios['mean']:.3f}", f"{ratios['min']:.3f}", f"{ratios['below']['0.1']:,}",
                     f"{found['complexity']:,.0f}", f"{seconds_of(bench.results[m.key]):.1f}"])
    return table(["mesh", "case", "tetrahedra", f"edges {LENGTH_BAND}", "lengths", "mean ratio", "least", "below 0.1", "complexity",
                  "seconds"], rows)


def fidelity(bench, methods):
    rows = [[m.name, f"{bench.results[m.key]['evaluation']['hausdorff_mm']['vertex_to_voxel_two_sided']:.2f}", f"{m.paper.hausdorff:g}"]
            for m in methods if m.image]
    return table(["the paper's method", "Hausdorff distance, mm", "paper"], rows)


def commands(bench, methods):
    lines = [f"    {c}" for m in methods for part in ("before", "commands", "after") for c in bench.results[m.key][part]]
    return "\n".join(dict.fromkeys(lines)) + "\n"


def draw(bench, methods):
    evaluations = {m.key: bench.results[m.key]["evaluation"] for m in methods if m.mesh}
    for group, case in {("small" if m.group == "small" else "large", m.case) for m in methods if m.group != "literal"}:
        of = [m for m in methods if m.case == case and (m.group == "small") == (group == "small")]
        shown = {m.name: evaluations[m.key]["dihedral_deg"]["histogram"] for m in of if m.figure == "angles"}
        if shown:
            (bench.output / f"paper_{group}{case}_angles.svg").write_text(curves.angle_figure(shown))
    metric = [m for m in methods if m.figure == "metric"]
    for group in {m.group for m in metric}:
        named = {f"case {m.case}: {m.name}": evaluations[m.key] for m in metric if m.group in (group, BESIDE.get(group))}
        ratios, lengths = ({k: v[field]["histogram"] for k, v in named.items()} for field in ("metric_mean_ratio", "metric_edge_length"))
        (bench.output / f"paper_{group}_conformity.svg").write_text(curves.conformity_figure(ratios, lengths))


def report(bench, chosen):
    methods = [m for m in chosen if m.key in bench.results]
    parts = []
    for group, case in dict.fromkeys((m.group, m.case) for m in methods):
        of = [m for m in methods if (m.group, m.case) == (group, case)]
        machines = "; ".join(sorted({bench.results[m.key]["machine"] for m in of}))
        parts += [f"Case {case}, {group}; {machines}\n", performance(bench, of)]
    for part in (angles, conformity, fidelity, commands):
        parts.append(part(bench, methods))
    draw(bench, methods)
    text = "\n".join(part for part in parts if part)
    (bench.output / "tables.md").write_text(text)
    print(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--output", "-o", type=pathlib.Path, default=pathlib.Path("paper"))
    parser.add_argument("--threads", type=lambda s: [int(n) for n in s.split(",")], default=[1], metavar="N,...")
    parser.add_argument("--rounds", type=int, default=1, help="runs of each command; medians count")
    parser.add_argument("--case", type=int, choices=(1, 2), help="only this one")
    parser.add_argument("--literal", action="store_true")
    parser.add_argument("--large", nargs="+", choices=("podm", "podm-sizes", "case1", "case2"), default=[])
    parser.add_argument("--part", type=float, default=1, help="of the large meshes' tetrahedra, such as 0.01 to try the script")
    parser.add_argument("--limit", type=float, default=3600, help="seconds for each mesher")
    parser.add_argument("--meshes", type=pathlib.Path, help="where their folder goes; default: OUTPUT")
    parser.add_argument("--keep", action="store_true", help="keep the meshes")
    parser.add_argument("--from", dest="earlier", nargs="+", type=lambda s: pathlib.Path(s).resolve(), metavar="FILE")
    arguments = parser.parse_args()
    bench = Bench(arguments)
    if arguments.earlier:
        failed = [line for path in arguments.earlier for line in bench.read(path)]
        report(bench, bench.methods)
        sys.exit("\n".join(["failed:", *failed]) if failed else 0)
    groups = set(arguments.large) | ({"literal"} if arguments.literal else set()) or {"small"}
    beside = ("case1_cdt3d_aniso", "case2_cdt3d_aniso", "case2_cdt3d_surface") if arguments.literal else ()
    chosen = [m for m in bench.methods if (m.group in groups or m.key in beside) and arguments.case in (None, m.case)]
    folder = tempfile.mkdtemp(prefix="meshes-", dir=arguments.meshes or bench.output)
    os.chdir(folder)
    failed = bench.run(chosen)
    report(bench, chosen)
    if not arguments.keep:
        shutil.rmtree(folder)
    sys.exit("\n".join(["failed:", *failed]) if failed else 0)


if __name__ == "__main__":
    main()
