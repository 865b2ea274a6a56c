#!/usr/bin/env python3
"""Adapts one case with both executions, all balancing policies and many numbers of threads, each as often as asked for in
turns: the least seconds of `lumesh adapt` without reading and writing, the least CPU seconds of the whole call, quality, what
contended, what was handed over. CPU seconds also tell something where others use the machine.

Usage: threads.py [--program LUMESH] [--case polar-2@20000] [--threads 2,4,16,128,256] [--rounds 3] [--topology DESCRIPTION]
Prints a table; the last column is the time over that with the first number of threads and the same policy.
--topology: balance as on a machine that hwloc describes so, such as "pack:2 numa:4 core:8 pu:1" (eight nodes).
"""
import argparse
import json
import pathlib
import resource
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import run  # noqa: E402  (ROOT)
from adapt import write_cube  # noqa: E402

EXECUTIONS = ("ordered", "speculative")
POLICIES = ("none", "first-idle", "hierarchical", "node-first", "stealing")


def cpu_seconds():
    """Of all children that ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def adapt(arguments, folder, execution, policy, threads):
    metric, _, complexity = arguments.case.partition("@")
    report = folder / "adapt.json"
    before = cpu_seconds()
    subprocess.run([arguments.program, "adapt", folder / "cube.meshb", "-o", folder / "adapted.vtu", "-q", "--analytic", metric,
                    *(["--complexity", complexity] if complexity else []), "--execution", execution, "--balance", policy,
                    "--threads", str(threads), "--json", report,
                    *(["--topology", arguments.topology] if arguments.topology else [])], check=True)
    told = json.loads(report.read_text())
    told["cpu_seconds"] = cpu_seconds() - before
    told["seconds"] = sum(value for step, value in told["seconds_by_step"].items() if step not in ("read", "build", "write"))
    return told


def quality(arguments, folder):
    numbers = folder / "numbers.json"
    subprocess.run([arguments.program, "evaluate", folder / "adapted.vtu", "-q", "--json", numbers], check=True)
    found = json.loads(numbers.read_text())
    return found["metric_edge_length"]["fraction_in_band"], found["metric_mean_ratio"]["mean"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(run.ROOT / "build/release/bin/lumesh"))
    parser.add_argument("--case", default="polar-2@20000")
    parser.add_argument("--threads", default="2,4,16,128,256")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--topology", default="")
    arguments = parser.parse_args()
    threads = [int(number) for number in arguments.threads.split(",")]
    cases = [(execution, policy, number) for execution in EXECUTIONS for policy in POLICIES for number in threads]
    seconds, cpu, rows = {}, {}, {}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_cube(folder / "cube.meshb", 3)
        for _ in range(arguments.rounds):
            for case in cases:
                told = adapt(arguments, folder, *case)
                contended = sum(count["contended"] for count in told["operators"].values())
                tried = sum(sum(count.values()) for count in told["operators"].values())
                seconds[case] = min(told["seconds"], seconds.get(case, told["seconds"]))
                cpu[case] = min(told["cpu_seconds"], cpu.get(case, told["cpu_seconds"]))
                rows[case] = (*quality(arguments, folder), contended / tried, told["hand_overs"])
    print("| execution | policy | threads | s | CPU s | in band | mean ratio | contended | local | remote | s / first |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for case in cases:
        execution, policy, number = case
        in_band, ratio, contended, hand_overs = rows[case]
        print(f"| {execution} | {policy} | {number} | {seconds[case]:.2f} | {cpu[case]:.2f} | {in_band:.4f} | {ratio:.4f} | "
              f"{contended:.4f} | {hand_overs['local']} | {hand_overs['remote']} | {seconds[case] / seconds[execution, policy, threads[0]]:.2f} |")


if __name__ == "__main__":
    main()
