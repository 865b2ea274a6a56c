#!/usr/bin/env python3
"""Grows layers on random phantoms, outwards and inwards, of tetrahedra and of prisms, with heights up to absurd ones; every mesh must
be valid, every run must report its coverage. With --checkmesh also prisms of moderate heights, 2 to 15 % of an edge and together less
than one, of which OpenFOAM's checkMesh must say "Mesh OK.". Lines on stderr, JSON on stdout; exit status 1 if any run failed.

Usage: layers.py [--program PATH] [--count N] [--seed N] [--only N] [--threads N] [--checkmesh]
"""
import argparse
import json
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)

sys.path.insert(0, str(run.ROOT / "tests/clients"))
import foam_case  # noqa: E402


def random_phantom(chance):
    """Arguments of `lumesh phantom`, voxels of 1 mm."""
    kind = chance.choice(["carotid", "bifurcation", "sphere", "torus"])
    size = chance.choice([48, 64, 96])
    arguments = [kind, "--size", size, size, size, "--spacing", 1, "--noise", round(chance.choice([0, chance.uniform(0, 1.5)]), 2),
                 "--seed", chance.randrange(1000)]
    if kind == "bifurcation":
        arguments += ["--radius", round(chance.uniform(2, 5) * size / 64, 2), "--sac-radius", round(chance.uniform(3, 9) * size / 64, 2)]
    elif kind == "carotid":  # It has no room for thicker vessels.
        radius = round(chance.uniform(1.5, 2.4) * size / 64, 2)
        arguments += ["--radius", radius, "--end-radius", max(0.75, round(0.7 * radius, 2)), "--sac-radius",
                      round(chance.uniform(2.5, 7) * size / 64, 2)]
    return arguments


def heights_up_to_absurd(chance):
    height = round(10 ** chance.uniform(-2.5, 1.2), 4)
    return ["--first-height", height, "--growth", round(chance.uniform(1, 1.6), 2), "--count", chance.randint(1, 8)]


def moderate_heights(chance):
    return ["--first-height", round(chance.uniform(0.02, 0.15), 3), "--growth", round(chance.uniform(1, 1.3), 2), "--count",
            chance.randint(2, 5), "--relative-to", "edge"]


class Runs:
    """Layers on one mesh after the other, and what is wrong with them."""

    def __init__(self, program, threads, folder):
        self.program, self.threads, self.folder = program, threads, folder
        self.mesh, self.image = folder / "a.vtu", folder / "a.nrrd"
        self.layered, self.numbers = folder / "layers.vtu", folder / "layers.json"

    def lumesh(self, *arguments):
        return subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True, timeout=600, check=False)

    def make_mesh(self, phantom):
        """What went wrong, or None; some mixtures are no phantom and pass without a word."""
        if self.lumesh("phantom", *phantom, "-o", self.image).returncode != 0:
            return ""
        meshed = self.lumesh("lattice", self.image, "-o", self.mesh, "--threads", self.threads)
        return None if meshed.returncode == 0 else f"no mesh: {meshed.stderr.strip()[-100:]}"

    def grow(self, options):
        """What one run made; "fault" says what is wrong with it."""
        self.numbers.unlink(missing_ok=True)
        made = self.lumesh("layers", self.mesh, "-o", self.layered, "--json", self.numbers, *options, "--threads", self.threads)
        result = {"options": options, "exit": made.returncode, "complete": None, "fault": None}
        if made.returncode == 2 and "more than the surface is wide" in made.stderr:
            return result | {"refused": True}
        if made.returncode != 0:
            return result | {"fault": made.stderr[-300:]}
        result["complete"] = json.loads(self.numbers.read_text())["complete"]
        return result | {"fault": self.fault_of_mesh(result)}

    def fault_of_mesh(self, result):
        checked = self.lumesh("evaluate", self.layered, "--json", self.numbers)
        if checked.returncode != 0:
            return checked.stderr[-300:]
        jacobian = json.loads(self.numbers.read_text()).get("scaled_jacobian")
        result["scaled_jacobian"] = jacobian["min"] if jacobian else None
        if jacobian and jacobian["min"] <= 0:
            return f"scaled Jacobian {jacobian['min']:.3f}"
        return None

    def check(self, result):
        """Asks checkMesh for the mesh that grow() made."""
        if result["fault"] or result["complete"] is None:
            return
        shutil.rmtree(self.folder / "case", ignore_errors=True)
        case = foam_case.Case(self.folder / "case")
        converted = self.lumesh("convert", self.layered, case.folder / "a.foam")
        if converted.returncode != 0:
            result["fault"] = converted.stderr[-300:]
            return
        found = foam_case.check_mesh(case)
        result["checkmesh"] = {key: value for key, value in found.items() if key not in ("said", "patches", "zones")}
        if not found["ok"]:
            result["fault"] = f"checkMesh: {found['failed']} {foam_case.where_bad(case.folder)}"


def run_phantom(number, seed, runs, with_checkmesh):
    """All runs on one random phantom, which depends on nothing but its number and the seed."""
    chance, results = random.Random(1000 * seed + number), []
    phantom = random_phantom(chance)
    wrong = runs.make_mesh(phantom)
    if wrong:
        print(f"{number}: {phantom}: {wrong}", file=sys.stderr)
    if wrong is not None:
        return []
    for side in ("outward", "inward"):
        heights, moderate = heights_up_to_absurd(chance), moderate_heights(chance)
        for cells in ("tetrahedra", "prisms"):
            results.append(runs.grow(["--side", side, *heights, "--cells", cells]))
        if with_checkmesh:
            results.append(runs.grow(["--side", side, *moderate, "--cells", "prisms"]))
            runs.check(results[-1])
    results = [{"number": number, "phantom": phantom} | result for result in results]
    for result in results:
        if result["fault"]:
            print(f"{number}: {phantom} {result['options']}: {result['fault']}", file=sys.stderr, flush=True)
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="only the phantom of this number")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--checkmesh", action="store_true", help="moderate heights, too, and what OpenFOAM's checkMesh says")
    arguments = parser.parse_args()
    if arguments.checkmesh and foam_case.missing("checkMesh"):
        raise SystemExit("OpenFOAM's checkMesh is missing; the Debian package openfoam has it")
    results = []
    with tempfile.TemporaryDirectory() as name:
        runs = Runs(arguments.program, arguments.threads, pathlib.Path(name))
        for number in range(arguments.count) if arguments.only is None else [arguments.only]:
            results += run_phantom(number, arguments.seed, runs, arguments.checkmesh)
    faults = sum(1 for result in results if result["fault"])
    grown = [result for result in results if result["complete"] is not None]
    checked = [result["checkmesh"] for result in grown if "checkmesh" in result]
    print(f"{len({result['number'] for result in results})} phantoms, {len(results)} runs, {len(grown)} grown, "
          f"{sum(1 for r in results if r.get('refused'))} refused as too thick, {len(checked)} seen by checkMesh, "
          f"{sum(1 for found in checked if found['ok'])} of them \"Mesh OK.\", {faults} faults", file=sys.stderr)
    print(json.dumps(results, indent=1))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
