#!/usr/bin/env python3
"""Compares two runs of `lumesh_boundary field` or `mesh` case by case, from their files of --json.

Roots of mean squares over the seeds, before -> after; the volume is a mean. Cases that only one run has are left out.

Usage: compare.py BEFORE.jsonl AFTER.jsonl
"""
import collections
import json
import math
import sys

FIGURES = ["roughness_voxels", "aligned_roughness_voxels", "normal_deg", "radius_percent", "section_radius_percent",
           "border_roughness_voxels", "border_normal_deg", "volume_percent"]
MEANS = {"volume_percent", "section_radius_percent"}


def read(path):
    """Lists of figures by (case and mesher, figure)."""
    figures = collections.defaultdict(list)
    for line in open(path):
        record = json.loads(line)
        name = record["case"] + (" " + record["mesher"] if "mesher" in record else "")
        for figure in FIGURES:
            if record.get(figure) is not None:
                figures[name, figure].append(record[figure])
        if "euler" in record:
            same = all(voxels == samples for voxels, samples in (record["euler"], record["components"]))
            figures[name, "other topology"].append(0 if same else 1)
    return figures


def summary(figure, values):
    if figure == "other topology":
        return sum(values)
    if figure in MEANS:
        return sum(values) / len(values)
    return math.sqrt(sum(value * value for value in values) / len(values))


def main():
    before, after = read(sys.argv[1]), read(sys.argv[2])
    names = list(dict.fromkeys(name for name, _ in before))
    for name in names:
        parts = []
        for figure in FIGURES + ["other topology"]:
            if before.get((name, figure)) and after.get((name, figure)):
                parts.append("{} {:.3g} -> {:.3g}".format(figure.rsplit("_", 1)[0], summary(figure, before[name, figure]),
                                                          summary(figure, after[name, figure])))
        if parts:
            print(f"{name:<38}" + "; ".join(parts))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main()
