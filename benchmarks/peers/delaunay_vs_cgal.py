#!/usr/bin/env python3
"""Compares `lumesh delaunay` with CGAL's Mesh_3 at equal numbers of tetrahedra: speed, quality, distances to the image, memory.

Usage: delaunay_vs_cgal.py IMAGE.nrrd [--targets 500000,2000000] [--threads 1,2] [--rounds 5] [--results FOLDER] ...

First it finds the sizes (--facet-size = --cell-size of CGAL, --delta of lumesh) that give each target within 1 %; they
are kept in FOLDER/sizes.json, and looked for again only if they no longer hold. Then all variants run in turn, as often
as --rounds says. Seconds are those of meshing, without reading and writing; lumesh's include the domain made from the image,
CGAL's have none. Memory is the peak of the process, CGAL's before it writes, lumesh's with writing.
A markdown table goes to stdout, all numbers to FOLDER/IMAGE-TARGET.json, what is going on to stderr.
"""
import argparse
import dataclasses
import hashlib
import json
import math
import pathlib
import re
import shlex
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cases"))
import run  # noqa: E402  (measure() and ROOT)

FIT, HOLDS = 0.01, 0.02  # Shares of the target: what a search ends with, and what is still taken as equal.
OUTSIDE_MESHING = ("read", "write", "check", "pass")  # Phases of lumesh; a pass is part of another phase.


@dataclasses.dataclass(frozen=True)
class Variant:
    program: str  # "lumesh", "improved", "cgal-par" or "cgal-seq"
    threads: int

    def name(self):
        return {"lumesh": "lumesh, not improved", "improved": "lumesh, with improvement", "cgal-par": "CGAL, parallel",
                "cgal-seq": "CGAL, sequential"}[self.program]


@dataclasses.dataclass
class Result:
    tetrahedra: int
    seconds: float
    peak_mib: float


def voxel_mm(image):
    """The mean spacing of a .nrrd."""
    header = image.read_bytes()[:4096].split(b"\n\n")[0].decode("latin-1")
    found = re.search(r"^space directions:(.*)$", header, re.MULTILINE)
    if not found:
        return 1.0
    axes = [[float(x) for x in axis.split(",")] for axis in re.findall(r"\(([^)]*)\)", found.group(1))]
    return math.prod(math.hypot(*axis) for axis in axes) ** (1 / len(axes))


def run_cgal(arguments, variant, size, mesh):
    binary = arguments.cgal_folder / f"cgal_mesh3_{variant.program.removeprefix('cgal-')}"
    command = [binary, "--image", arguments.image, "--output", mesh, "--facet-size", size, "--cell-size", size,
               "--facet-distance", arguments.facet_distance, "--radius-edge", arguments.radius_edge,
               "--threads", variant.threads, *shlex.split(arguments.cgal_options)]
    output, _, _ = run.measure([str(word) for word in command])
    told = json.loads(output.splitlines()[-1])
    return Result(told["tetrahedra"], told["seconds"] + told["perturb_seconds"] + told["exude_seconds"], told["peak_mib"])


def lumesh_told(report):
    """Tetrahedra and seconds of meshing, from what `lumesh delaunay --json` writes."""
    told = json.loads(report.read_text())
    return told["tetrahedra"], sum(seconds for phase, seconds in told["seconds"].items() if phase not in OUTSIDE_MESHING)


def run_lumesh(arguments, variant, size, mesh):
    report = mesh.with_suffix(".report.json")
    command = [arguments.program, "delaunay", arguments.image, "-o", mesh, "--delta", size, "-q", "--threads", variant.threads,
               "--json", report, *(["--no-improve"] if variant.program == "lumesh" else []), *shlex.split(arguments.lumesh_options)]
    _, _, mib = run.measure([str(word) for word in command])
    return Result(*lumesh_told(report), mib)


def mesh_of(arguments, variant):
    suffix = ".mesh" if variant.program.startswith("cgal") else ".meshb"
    return arguments.results / f"{arguments.image.stem}-{variant.program}-{variant.threads}{suffix}"


def run_variant(arguments, variant, size):
    runner = run_cgal if variant.program.startswith("cgal") else run_lumesh
    return runner(arguments, variant, f"{size:.6g}", mesh_of(arguments, variant))


class Sizes:
    """What gave which target, in a file."""

    def __init__(self, arguments):
        self.arguments = arguments
        self.path = arguments.results / "sizes.json"
        self.known = json.loads(self.path.read_text()) if self.path.is_file() else {}
        self.digest = hashlib.sha256(arguments.image.read_bytes()).hexdigest()[:16]

    def key(self, program, target):
        a = self.arguments
        options = f"{a.facet_distance} {a.radius_edge} {a.cgal_options}" if program.startswith("cgal") else a.lumesh_options
        return f"{a.image.name} {self.digest} | {program} {options.strip()} | {target}"

    def get(self, program, target):
        return self.known.get(self.key(program, target))

    def keep(self, program, target, size):
        self.known[self.key(program, target)] = size
        self.path.write_text(json.dumps(self.known, indent=2, sort_keys=True) + "\n")

    def fit(self, program, target, threads):
        """Secants in the logarithms of size and number, between a size that is too large and one that is too small."""
        size, tries, slope = self.get(program, target) or 3 * voxel_mm(self.arguments.image), [], -3.0
        for _ in range(12):
            found = run_variant(self.arguments, Variant(program, threads), size).tetrahedra
            print(f"{program}, target {target}: size {size:.4g} mm gives {found} tetrahedra", file=sys.stderr, flush=True)
            if abs(found - target) <= FIT * target:
                self.keep(program, target, size)
                return size
            tries.append((math.log(size), math.log(max(found, 1) / target)))
            if len(tries) > 1 and tries[-1][0] != tries[-2][0]:
                slope = min(-1.0, (tries[-1][1] - tries[-2][1]) / (tries[-1][0] - tries[-2][0]))
            size = math.exp(self.next_size(tries, slope))
        raise SystemExit(f"{program}: no size gives {target} tetrahedra within {FIT:.0%} in {len(tries)} runs")

    @staticmethod
    def next_size(tries, slope):
        step = tries[-1][0] - tries[-1][1] / slope
        too_small = max((t[0] for t in tries if t[1] > 0), default=-math.inf)
        too_large = min((t[0] for t in tries if t[1] < 0), default=math.inf)
        if too_small < step < too_large or math.isinf(too_small) or math.isinf(too_large):
            return step
        return (too_small + too_large) / 2


def evaluate(arguments, variant):
    numbers = mesh_of(arguments, variant).with_suffix(".numbers.json")
    command = [arguments.program, "evaluate", mesh_of(arguments, variant), "--image", arguments.image, "--json", numbers, "-q",
               *(["--reference", arguments.reference] if arguments.reference else [])]
    run.measure([str(word) for word in command], allowed=(0, 3))  # 3: the mesh is not valid; the table says so.
    found = json.loads(numbers.read_text())
    distances, labels = found["hausdorff_mm"], found["labels"]
    image_volume = sum(label["voxel_volume_mm3"] for label in labels)
    truths = [label["reference"]["surface_distance_mm"] for label in labels if "reference" in label]
    patches = found["boundary"].get("patches", [])
    return {"truth": [max(t[k] for t in truths) for k in ("mean", "max")] if truths else None,
            "facet": min((p["smallest_angle_deg"] for p in patches), default=None),
            "valid": found["valid"], "dihedral": [found["dihedral_deg"]["min"], found["dihedral_deg"]["max"]],
            "below_5": found["dihedral_deg"]["below"]["5"],
            "mesh_to_image": [distances["mesh_to_image"][k] for k in ("mean", "max")],
            "image_to_mesh": [distances["image_to_mesh"][k] for k in ("mean", "max")],
            "volume_error_percent": 100 * (sum(label["volume_mm3"] for label in labels) / image_volume - 1),
            "closed": found["boundary"]["closed"], "manifold": found["boundary"]["manifold"]}


def measure(arguments, sizes, target):
    """All variants in turn; what lies outside of the target is looked for again, once."""
    variants = [Variant(program, threads) for threads in arguments.threads for program in arguments.programs
                if program != "cgal-seq" or threads == arguments.threads[0]]
    variants = [Variant(v.program, 1) if v.program == "cgal-seq" else v for v in variants]
    for program in arguments.programs:
        if sizes.get(program, target) is None:
            sizes.fit(program, target, 1 if program == "cgal-seq" else max(arguments.threads))
    results = {variant: [] for variant in variants}
    for turn in range(arguments.rounds):
        for variant in variants:
            result = run_variant(arguments, variant, sizes.get(variant.program, target))
            if turn == 0 and abs(result.tetrahedra - target) > HOLDS * target:
                sizes.fit(variant.program, target, variant.threads)
                result = run_variant(arguments, variant, sizes.get(variant.program, target))
            results[variant].append(result)
            print(f"round {turn + 1}: {variant.name()}, {variant.threads} threads, {result.tetrahedra} tetrahedra, "
                  f"{result.seconds:.2f} s", file=sys.stderr, flush=True)
    return {variant: (runs, evaluate(arguments, variant)) for variant, runs in results.items()}


def rate(result):
    return result.tetrahedra / result.seconds


def ratio_of(measured, variant):
    """To CGAL's parallel program on as many threads, round by round: the machine's speed drifts, a round's hardly."""
    reference = next((v for v in measured if v.program == "cgal-par" and v.threads == variant.threads), None)
    if reference is None:
        return "–"
    pairs = zip(measured[variant][0], measured[reference][0])
    return f"{statistics.median(rate(mine) / rate(theirs) for mine, theirs in pairs):.2f}"


def table(measured):
    lines = ["| program | threads | tetrahedra | seconds | tetrahedra/s | / CGAL parallel | dihedral, degrees | below 5° | "
             "least facet angle | mesh to truth, mean / max mm | mesh to image, mean / max mm | image to mesh, mean / max mm | "
             "volume | peak MiB | boundary |", "|" + "---|" * 15]
    for variant, (runs, quality) in measured.items():
        boundary = ", ".join(word for word, good in (("closed", quality["closed"]), ("manifold", quality["manifold"]),
                                                     ("valid", quality["valid"])) if good) or "faulty"
        lines.append("| " + " | ".join([
            variant.name(), str(variant.threads), f"{statistics.median(r.tetrahedra for r in runs):,.0f}",
            f"{statistics.median(r.seconds for r in runs):.2f}", f"{statistics.median(map(rate, runs)):,.0f}",
            ratio_of(measured, variant), "{:.2f}–{:.2f}".format(*quality["dihedral"]), f"{quality['below_5']:,}",
            "–" if quality["facet"] is None else f"{quality['facet']:.1f}",
            "–" if quality["truth"] is None else "{:.3f} / {:.2f}".format(*quality["truth"]),
            "{:.3f} / {:.2f}".format(*quality["mesh_to_image"]), "{:.3f} / {:.2f}".format(*quality["image_to_mesh"]),
            f"{quality['volume_error_percent']:+.2f} %", f"{max(r.peak_mib for r in runs):.0f}", boundary]) + " |")
    return "\n".join(lines)


def parsed():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("image", type=pathlib.Path, metavar="IMAGE.nrrd")
    parser.add_argument("--targets", default="500000,2000000", help="numbers of tetrahedra")
    parser.add_argument("--threads", default="1,2")
    parser.add_argument("--programs", default="cgal-seq,cgal-par,lumesh,improved",
                        help="which to run; improved: lumesh with improvement")
    parser.add_argument("--reference", type=pathlib.Path, help="a phantom's .phantom.json: distances to its true surface")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--results", type=pathlib.Path, default=run.ROOT / "out/peers", help="folder to write to")
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"), help="lumesh")
    parser.add_argument("--cgal-folder", type=pathlib.Path, default=run.ROOT / "build/peers", help="with cgal_mesh3_*")
    parser.add_argument("--facet-distance", type=float, help="CGAL's, mm; default half a voxel")
    parser.add_argument("--radius-edge", type=float, default=3, help="CGAL's")
    parser.add_argument("--cgal-options", default="", help='passed on, such as "--perturb 1 --exude 1"')
    parser.add_argument("--lumesh-options", default="", help="passed on")
    arguments = parser.parse_args()
    arguments.threads = [int(number) for number in arguments.threads.split(",")]
    arguments.programs = arguments.programs.split(",")
    if arguments.facet_distance is None:
        arguments.facet_distance = 0.5 * voxel_mm(arguments.image)
    arguments.results.mkdir(parents=True, exist_ok=True)
    return arguments


def main():
    arguments = parsed()
    sizes = Sizes(arguments)
    for target in map(int, arguments.targets.split(",")):
        measured = measure(arguments, sizes, target)
        rows = [{**dataclasses.asdict(variant), "size_mm": sizes.get(variant.program, target),
                 "runs": [dataclasses.asdict(r) for r in runs], **quality} for variant, (runs, quality) in measured.items()]
        (arguments.results / f"{arguments.image.stem}-{target}.json").write_text(json.dumps(rows, indent=2) + "\n")
        print(f"\n{arguments.image.name}, {target:,} tetrahedra, {arguments.rounds} rounds\n\n{table(measured)}", flush=True)


if __name__ == "__main__":
    main()
