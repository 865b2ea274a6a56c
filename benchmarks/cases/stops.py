#!/usr/bin/env python3
"""Stops commands at random times of their work, by Ctrl-C and by --time-limit, and measures how long they take to end. Every
command that works longer than half a second is tried on the carotid phantom and, with --data, on real inputs. Of each
it is asked: seconds from the signal (or the limit) to the first line about it and to the end of the process, the exit code (4, or 0
if it was done), and what is on the disk: no unfinished file, and what was there before as it was. To the end counts as well what a
stage with a result to keep (adapt, delaunay, improve, run) takes to put it in order and to write it.

Usage: stops.py [--program PATH] [--data FOLDER] [--tries N] [--seed N] [--only WORD,...] [--work FOLDER] [--json FILE]
"""
import argparse
import hashlib
import json
import pathlib
import random
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)

INTERRUPTED = 4
BOUND_S = 0.3
CASE = """
[input]
image = "c.nrrd"
[metric]
points = "centerline"
k = 20
[output]
report = "report.html"
"""

# Name, arguments; "OUT" is the folder for results. Each reads what those before it left in the working folder.
INPUTS = [
    ("phantom", "phantom carotid -o c.nrrd"),
    ("lattice", "lattice c.nrrd -o c.vtu"),
    ("delaunay", "delaunay c.nrrd -o d.vtu"),
    ("surface", "convert d.vtu --surface d.stl -o d2.vtu"),
    ("metric", "metric d.vtu --curvature --max-size 8 -o s.vtu"),
    ("layers", "layers d.vtu --first-height 0.1 --count 3 -o l.vtu --cells prisms"),
    ("centerline", "centerline c.nrrd -o c.vtp"),
    ("large lattice", "lattice c.nrrd --edge-length 1.5 --max-tetrahedra 4000000 -o b.vtu --surface b.stl"),
    ("wall", "convert l.vtu --only-labels 2 -o w.vtu"),
]
COMMANDS = [
    ("phantom", "phantom carotid -o OUT/c.nrrd"),
    ("info image", "info c.nrrd"),
    ("info mesh", "info b.stl"),
    ("check image", "check c.nrrd --json OUT/k.json"),
    ("check surface", "check b.stl"),
    ("check mesh", "check b.vtu --json OUT/k.json"),
    ("lattice", "lattice c.nrrd -o OUT/m.vtu --surface OUT/m.stl"),
    ("delaunay image", "delaunay c.nrrd -o OUT/m.vtu"),
    ("delaunay surface", "delaunay d.stl -o OUT/m.msh"),
    ("repair", "repair b.stl -o OUT/m.stl"),
    ("repair rebuild", "repair b.stl --method rebuild -o OUT/m.stl"),
    ("metric", "metric d.vtu --curvature --max-size 8 --gradation 1.3 -o OUT/m.vtu"),
    ("adapt", "adapt s.vtu -o OUT/m.vtu"),
    ("adapt image", "adapt s.vtu --image c.nrrd -o OUT/m.mesh"),
    ("improve", "improve b.vtu -o OUT/m.vtk"),
    ("layers outward", "layers d.vtu --first-height 0.1 --count 3 -o OUT/m.vtu"),
    ("layers inward", "layers d.vtu --side inward --first-height 0.05 --count 3 --cells prisms -o OUT/m.foam"),
    ("centerline image", "centerline c.nrrd -o OUT/m.vtp"),
    ("centerline mesh", "centerline d.vtu -o OUT/m.vtp"),
    ("evaluate", "evaluate d.vtu --image c.nrrd --json OUT/e.json --report OUT/e.html"),
    ("convert", "convert b.vtu OUT/m.msh"),
    ("convert foam", "convert b.vtu OUT/m.foam"),
    ("rename", "rename b.vtu --name wall=vessel -o OUT/m.vtu"),
    ("merge", "merge d.vtu w.vtu -o OUT/m.vtu"),
    ("run", "run case.toml -o OUT/case"),
]
# On real inputs; DATA is the folder of --data.
DATA_COMMANDS = [
    ("info aneurism", "info DATA/aneurism/aneurism_label_t37.nrrd"),
    ("lattice aneurism", "lattice DATA/aneurism/aneurism_label_t37.nrrd -o OUT/m.vtu"),
    ("delaunay aneurism", "delaunay DATA/aneurism/aneurism_label_t37.nrrd -o OUT/m.vtu"),
    ("delaunay atlas", "delaunay DATA/multi-label/hncma-atlas.nrrd --edge-length 4 -o OUT/m.vtu"),
    ("lattice atlas", "lattice DATA/multi-label/hncma-atlas.nrrd --spacing 4 -o OUT/m.vtu"),
    ("delaunay aorta", "delaunay DATA/unseen/aorta-surface-open-ends.stl -o OUT/m.vtu"),
    ("repair aorta", "repair DATA/unseen/aorta-surface-open-ends.stl --method rebuild -o OUT/m.stl"),
]


def take_signals():
    """What this script was told to ignore, as in the background of a shell, commands are not."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def files_of(folder):
    return {str(path.relative_to(folder)): digest(path) for path in sorted(folder.rglob("*")) if path.is_file()}


class Bench:
    def __init__(self, program, work, data):
        self.program, self.work, self.data = program, work, data
        self.out = work / "out"

    def command(self, text, *more):
        words = [word.replace("OUT", str(self.out)).replace("DATA", str(self.data)) for word in text.split()]
        return [self.program, *words, *more]

    def fresh(self):
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir()

    def start(self, text, *more):
        return subprocess.Popen(self.command(text, *more), cwd=self.work, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                text=True, start_new_session=True, preexec_fn=take_signals)

    def whole(self, text):
        """Seconds, exit code, and the files of a run that nobody stops."""
        self.fresh()
        began = time.monotonic()
        with self.start(text) as process:
            errors = process.communicate()[1]
        return time.monotonic() - began, process.returncode, files_of(self.out), errors

    def faults(self, before, after):
        """What is on the disk and should not be."""
        found = [f"{name} is left" for name in after if ".part-" in name]
        found += [f"{name} is gone" for name in before if name not in after]
        found += [f"{name} was replaced" for name in before if name in after and after[name] != before[name]]
        return found

    def stopped(self, text, at_s, by_limit):
        """Stops a run whose results are there already, of an earlier run."""
        more = ["--time-limit", f"{at_s:.3f}"] if by_limit else []
        with self.start(text, *more) as process:
            asked = time.monotonic() + at_s
            try:
                process.wait(at_s)
                if not by_limit:
                    return None  # It was done before.
            except subprocess.TimeoutExpired:
                if not by_limit:
                    process.send_signal(signal.SIGINT)
            errors, answered = "", None
            for line in process.stderr:
                errors += line
                if answered is None and ("interrupted" in line or "time limit" in line):
                    answered = time.monotonic()
            process.wait(300)
        ended = time.monotonic()
        return max(ended - asked, 0), max((answered or ended) - asked, 0), process.returncode, errors


def measure(bench, name, text, tries, chance):
    seconds, code, files, errors = bench.whole(text)
    print(f"{name:<20} {seconds:7.2f} s, exit code {code}", file=sys.stderr)
    result = {"command": text, "seconds": seconds, "late_s": {}, "codes": {}, "faults": []}
    if code not in (0, 3):
        result["faults"].append(errors.strip())
        return result
    for by_limit in (False, True):
        late = []
        for _ in range(tries):
            for path in [*bench.out.rglob("*")]:  # What the stopped run before has left.
                if (".part" in path.name or path.name == "partial") and path.exists():
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
            end = bench.stopped(text, chance.uniform(0.02, 1) * seconds, by_limit)
            if end is None:  # Done before: times of day in its files are new.
                files = files_of(bench.out)
                continue
            late.append(end[:2])
            _, _, last_code, errors = end
            if last_code == code:
                files = files_of(bench.out)
            result["codes"][last_code] = result["codes"].get(last_code, 0) + 1
            if last_code not in (INTERRUPTED, code, -signal.SIGINT):  # The last: before main() began.
                result["faults"].append(f"exit code {last_code}: {errors.strip()[-200:]}")
                if by_limit and "time-limit" in errors:  # A program that has no such option.
                    late.clear()
                    break
            result["faults"] += bench.faults(files, files_of(bench.out))
        result["late_s"]["limit" if by_limit else "signal"] = late
    return result


def line_of(name, result):
    texts = []
    for kind in ("signal", "limit"):
        late = sorted(ended for ended, _ in result["late_s"].get(kind, []))
        if not late:
            texts.append(f"{kind}: none")
            continue
        p95 = late[min(len(late) - 1, int(0.95 * len(late)))]
        in_time = [sum(one[which] <= BOUND_S for one in result["late_s"][kind]) / len(late) for which in (1, 0)]
        texts.append(f"{kind}: {len(late)}, end median {statistics.median(late):.2f}, 95 % {p95:.2f}, max {late[-1]:.2f} s; within "
                     f"{BOUND_S} s {100 * in_time[0]:.0f} % answered, {100 * in_time[1]:.0f} % ended")
    return f"{name:<20} {result['seconds']:6.1f} s {'; '.join(texts)}; codes {result['codes']}; {len(result['faults'])} faults"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--data", type=pathlib.Path)
    parser.add_argument("--tries", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--work", type=pathlib.Path, help="keep inputs here, and take those that are there")
    parser.add_argument("--json", type=pathlib.Path)
    options = parser.parse_args()
    chance = random.Random(options.seed)
    work = options.work or pathlib.Path(tempfile.mkdtemp(prefix="lumesh_stops_"))
    work.mkdir(exist_ok=True)
    bench = Bench(str(pathlib.Path(options.program).resolve()), work, options.data)
    (work / "case.toml").write_text(CASE)
    for _, text in INPUTS:
        if not (work / text.split("-o ")[1].split()[0]).exists():
            subprocess.run(bench.command(text), cwd=work, check=True, stdout=subprocess.DEVNULL)
    wanted = [word for word in options.only.split(",") if word]
    results = {}
    for name, text in COMMANDS + (DATA_COMMANDS if options.data else []):
        if wanted and not any(name.startswith(word) for word in wanted):
            continue
        results[name] = measure(bench, name, text, options.tries, chance)
        print(line_of(name, results[name]), flush=True)
        for fault in sorted(set(results[name]["faults"])):
            print(f"    {fault}")
    if options.json:
        options.json.write_text(json.dumps(results, indent=1))
    if not options.work:
        shutil.rmtree(work)
    return 1 if any(result["faults"] for result in results.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
