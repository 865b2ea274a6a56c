#!/usr/bin/env python3
"""Compares two builds of lumesh command by command: CPU time, peak memory, and how many tetrahedra come out.

Usage: compare.py [--program NEW]                        NEW against benchmarks/baselines.json
       compare.py --program NEW --with OLD               both, in turns, on this machine: what counts before a commit
       compare.py BEFORE.json AFTER.json                 what was measured before
       compare.py --program NEW --record FILE.json       measures alone
Options: --repeats N (5), --rows NAME,… (all), --json FILE.

Every row is one command on one thread, run N times, all rows in turns, so that what else the machine does falls on all of them. Its
CPU seconds (user and system) are printed as the ratio of medians, after over before, and its noise as the least and the greatest ratio
that the middle halves of both series allow. A row is WORSE if its ratio is above 1.03 and no less than 1 within the noise, and
unclear if it is above 1.03 but not so certain: repeat these with --rows and more --repeats. Memory is the greatest of the runs;
it and the number of tetrahedra hardly have noise: more than 3 % is WORSE, another number is said.
Times of different machines differ: there, each ratio is divided by the median ratio of all rows, and only what a row differs
from the others by counts. The exit status is 1 if a row is WORSE, 2 if nothing could be compared.
"""
import argparse
import json
import pathlib
import platform
import re
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "cases"))
import run  # noqa: E402  (timed() and ROOT)

BOUND = 1.03
BASELINES = HERE / "baselines.json"
# What the rows work on; not timed.
SETUP = [
    "phantom carotid -o carotid.nrrd --size 128 128 127 --spacing 4 --centerline carotid.vtp",
    "phantom bifurcation -o vessel.nrrd --centerline vessel.vtp --velocity flow.vtp",
    "lattice vessel.nrrd -o lattice.vtu",
    "delaunay vessel.nrrd -o vessel.vtu --edge-length 0.4",
    "delaunay carotid.nrrd -o carotid.vtu --edge-length 8",
    "convert vessel.vtu vessel.msh --surface vessel.stl",
    "metric vessel.vtu --velocity flow.vtp --complexity 2000 -o metric.vtu",
    "layers vessel.vtu --first-height 0.1 --count 4 -o layered.vtu",
    "convert layered.vtu wall.vtu --only-labels vessel_wall",
    "convert layered.vtu lumen.vtu --only-labels 1",
]
ROWS = {
    "phantom": "phantom carotid -o out.nrrd --size 256 256 254 --spacing 2",
    "check-image": "check carotid.nrrd",
    "check-surface": "check vessel.stl",
    "centerline": "centerline vessel.nrrd -o out.vtp",
    "lattice": "lattice vessel.nrrd -o out.vtu",
    "lattice-carotid": "lattice carotid.nrrd -o out.vtu",
    "delaunay": "delaunay vessel.nrrd -o out.vtu --edge-length 0.3",
    "delaunay-surface": "delaunay vessel.stl -o out.vtu --edge-length 0.4",
    "metric-points": "metric carotid.vtu --points carotid.vtp -o out.vtu",
    "metric-velocity": "metric vessel.vtu --velocity flow.vtp --complexity 20000 -o out.vtu",
    "adapt": "adapt metric.vtu -o out.vtu",
    "improve": "improve lattice.vtu -o out.vtu",
    "layers": "layers vessel.vtu --first-height 0.1 --count 4 -o out.vtu",
    "layers-inward": "layers vessel.vtu --side inward --first-height 0.05 --count 3 --cells prisms -o out.vtu",
    "merge": "merge lumen.vtu wall.vtu -o out.vtu",
    "evaluate": "evaluate vessel.vtu --image vessel.nrrd --json out.json",
    "convert": "convert layered.vtu out.msh",
}


def command_of(name):
    words = ROWS[name].split()
    return words if words[0] == "convert" else [*words, "--threads", "1"]  # It has one thread alone.


def machine():
    name = platform.machine()
    cpuinfo = pathlib.Path("/proc/cpuinfo")
    if cpuinfo.exists():
        found = re.search(r"model name\s*:\s*(.*)", cpuinfo.read_text())
        name = found.group(1) if found else name
    return f"{name}, {platform.system()}"


def commit():
    """Of this tree, whose build is recorded; with "changed" behind it where files differ from it."""
    def git(*words):
        return subprocess.run(["git", "-C", str(run.ROOT), *words], capture_output=True, text=True, check=True).stdout.strip()
    return git("rev-parse", "HEAD") + (", changed" if git("status", "--porcelain", "--untracked-files=no") else "")


def measured(programs, names, repeats):
    """A record of each program, all in turns."""
    records = []
    with tempfile.TemporaryDirectory() as temporary:
        folders = [pathlib.Path(temporary) / str(i) for i in range(len(programs))]
        for program, folder in zip(programs, folders):
            folder.mkdir()
            for command in SETUP:
                subprocess.run([program, *command.split(), "--quiet"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
            version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.strip()
            records.append({"version": version, "machine": machine(), "threads": 1, "repeats": repeats,
                            "note": "Times are of this machine, with whatever else it did; only ratios count.",
                            "rows": {name: {"command": ROWS[name], "cpu_seconds": [], "peak_mib": 0, "tetrahedra": None} for name in names}})
        for turn in range(repeats):
            for name in names:
                for program, folder, record in zip(programs, folders, records):
                    result = run.timed(["env", "-C", str(folder), program, *command_of(name)])
                    if result.exit != 0:
                        raise SystemExit(f"{ROWS[name]}: exit {result.exit}")
                    row = record["rows"][name]
                    row["cpu_seconds"].append(round(result.cpu_seconds, 4))
                    row["peak_mib"] = round(max(row["peak_mib"], result.peak_mib), 1)
                    found = re.search(r": (\d+) tetrahedra", result.output)
                    row["tetrahedra"] = int(found.group(1)) if found else None
            print(f"turn {turn + 1} of {repeats}", file=sys.stderr)
    return records


def ratio_with_noise(before, after):
    """Of the medians, and the least and the greatest of the middle halves."""
    def quartiles(series):
        if len(series) < 2: return series[0], series[0]
        low, _, high = statistics.quantiles(series, n=4, method="inclusive")
        return low, high
    (low_before, high_before), (low_after, high_after) = quartiles(before), quartiles(after)
    return statistics.median(after) / statistics.median(before), low_after / high_before, high_after / low_before


def compared(before, after):
    """Rows with verdicts; ratios are relative to the median of all where the machines differ."""
    rows = []
    for name, old in before["rows"].items():
        new = after["rows"].get(name)
        if new is None or new["command"] != old["command"]: continue
        rows.append({"name": name, "seconds": [statistics.median(old["cpu_seconds"]), statistics.median(new["cpu_seconds"])],
                     "time": ratio_with_noise(old["cpu_seconds"], new["cpu_seconds"]),
                     "memory": new["peak_mib"] / old["peak_mib"], "tetrahedra": [old["tetrahedra"], new["tetrahedra"]]})
    shift = 1.0
    if rows and before["machine"] != after["machine"]:
        shift = statistics.median(row["time"][0] for row in rows)
    for row in rows:
        row["time"] = [value / shift for value in row["time"]]
        ratio, low, _ = row["time"]
        row["verdict"] = "WORSE" if (ratio > BOUND and low >= 1) or row["memory"] > BOUND else "unclear" if ratio > BOUND else ""
    return rows, shift


def print_table(rows, shift):
    if shift != 1:
        print(f"other machine: times are {shift:.2f} times those before in the median, by which ratios are divided")
    print(f"{'row':<18}{'before s':>9}{'after s':>9}{'ratio':>8}   {'noise':<14}{'memory':>7}  tetrahedra")
    for row in rows:
        ratio, low, high = row["time"]
        old, new = row["tetrahedra"]
        cells = "" if old is None and new is None else str(new) if old == new else f"{old} -> {new}"
        print(f"{row['name']:<18}{row['seconds'][0]:>9.3f}{row['seconds'][1]:>9.3f}{ratio:>8.3f}   {low:.3f}–{high:<7.3f} "
              f"{row['memory']:>7.3f}  {cells:<18}{row['verdict']}".rstrip())
    worse = [row["name"] for row in rows if row["verdict"] == "WORSE"]
    unclear = [row["name"] for row in rows if row["verdict"] == "unclear"]
    print(f"{len(rows)} rows, {len(worse)} worse than 3 %{': ' + ', '.join(worse) if worse else ''}"
          f"{'; within the noise: ' + ', '.join(unclear) if unclear else ''}")
    return 1 if worse else 0 if rows else 2


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=pathlib.Path)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--with", dest="other", help="the program to compare with")
    parser.add_argument("--record", type=pathlib.Path)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--rows", default=",".join(ROWS))
    parser.add_argument("--json", type=pathlib.Path, help="the rows of the table")
    arguments = parser.parse_args()
    names = arguments.rows.split(",")
    for name in names:
        if name not in ROWS: parser.error(f"no row '{name}'; there are {', '.join(ROWS)}")
    if len(arguments.files) not in (0, 2): parser.error("two files, or none")
    if arguments.files:
        before, after = (json.loads(path.read_text()) for path in arguments.files)
    else:
        programs = [str(pathlib.Path(path).resolve()) for path in (arguments.other, arguments.program) if path]
        records = measured(programs, names, arguments.repeats)
        if arguments.record:
            arguments.record.write_text(as_text(records[-1] | {"commit": commit()}))
            if not arguments.other: return 0
        before, after = records if arguments.other else (json.loads(BASELINES.read_text()), records[0])
    if "commit" in before: print(f"before: {before['version']}, commit {before['commit'][:12]}")
    rows, shift = compared(before, after)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n")
    return print_table(rows, shift)


def as_text(record):
    """JSON with a line per row."""
    head = {key: record[key] for key in ("version", "commit", *record) if key != "rows"}
    rows = ",\n".join(f"  {json.dumps(name)}: {json.dumps(row)}" for name, row in record["rows"].items())
    return json.dumps(head, indent=1)[:-2] + ',\n "rows": {\n' + rows + "\n }\n}\n"


if __name__ == "__main__":
    sys.exit(main())
