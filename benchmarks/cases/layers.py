#!/usr/bin/env python3
"""Grows layers on random phantoms, outwards and inwards, with heights up to absurd ones; every mesh must be valid, every run must
report its coverage. Lines on stderr, JSON on stdout; exit status 1 if any run failed.

Usage: layers.py [--program PATH] [--count N] [--seed N] [--threads N]
"""
import argparse
import json
import pathlib
import random
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)


def random_phantom(chance):
    """Arguments of `lumesh phantom`, voxels of 1 mm."""
    kind = chance.choice(["carotid", "bifurcation", "sphere", "torus"])
    size = chance.choice([48, 64, 96])
    arguments = [kind, "--size", size, size, size, "--spacing", 1, "--noise", round(chance.choice([0, chance.uniform(0, 1.5)]), 2),
                 "--seed", chance.randrange(1000)]
    if kind in ("carotid", "bifurcation"):
        arguments += ["--radius", round(chance.uniform(2, 5) * size / 64, 2), "--sac-radius", round(chance.uniform(3, 9) * size / 64, 2)]
    return arguments


def grow(program, mesh, side, chance, threads, folder):
    """What one run made; "fault" says what is wrong with it."""
    height = round(10 ** chance.uniform(-2.5, 1.2), 4)
    options = ["--side", side, "--first-height", height, "--growth", round(chance.uniform(1, 1.6), 2), "--count", chance.randint(1, 8),
               "--cells", "tetrahedra", "--threads", threads]
    out, numbers = folder / "layers.vtu", folder / "layers.json"
    numbers.unlink(missing_ok=True)
    made = subprocess.run([program, "layers", mesh, "-o", out, "--json", numbers, *map(str, options)], capture_output=True, text=True,
                          timeout=600, check=False)
    result = {"options": options, "exit": made.returncode, "complete": None, "fault": None}
    if made.returncode == 2 and "more than the surface is wide" in made.stderr:
        return result | {"refused": True}
    if made.returncode != 0:
        return result | {"fault": made.stderr[-300:]}
    result["complete"] = json.loads(numbers.read_text())["complete"]
    checked = subprocess.run([program, "evaluate", out], capture_output=True, text=True, timeout=600, check=False)
    if checked.returncode != 0:
        result["fault"] = checked.stderr[-300:]
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    arguments = parser.parse_args()
    chance, results = random.Random(arguments.seed), []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for i in range(arguments.count):
            phantom = random_phantom(chance)
            image, mesh = folder / "a.nrrd", folder / "a.vtu"
            made = subprocess.run([arguments.program, "phantom", *map(str, phantom), "-o", image], check=False, capture_output=True)
            if made.returncode != 0:
                continue  # Some mixtures are no phantom.
            meshed = subprocess.run([arguments.program, "lattice", image, "-o", mesh], check=False, capture_output=True, text=True)
            if meshed.returncode != 0:
                print(f"{i}: {phantom}: no mesh: {meshed.stderr.strip()[-100:]}", file=sys.stderr)
                continue
            for side in ("outward", "inward"):
                result = {"phantom": phantom, "side": side} | grow(arguments.program, mesh, side, chance, arguments.threads, folder)
                results.append(result)
                if result["fault"]:
                    print(f"{i}, {side}: {phantom} {result['options']}: {result['fault']}", file=sys.stderr, flush=True)
    faults = sum(1 for result in results if result["fault"])
    grown = [result for result in results if result["complete"] is not None]
    print(f"{len(results)} runs, {len(grown)} grown, {sum(1 for r in results if r.get('refused'))} refused as too thick, "
          f"{faults} faults", file=sys.stderr)
    print(json.dumps(results, indent=1))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
