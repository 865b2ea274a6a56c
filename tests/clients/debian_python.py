"""Debian's own Python, where the packages python3-vtk9 and python3-meshio are; another Python may come first in PATH."""
import importlib.util
import os
import shutil
import sys

SKIPPED = 77
DEBIAN_PYTHON = "/usr/bin/python3"
PACKAGES = {"vtkmodules": "python3-vtk9", "meshio": "python3-meshio", "numpy": "python3-numpy"}


def missing_packages():
    missing = [package for module, package in PACKAGES.items() if importlib.util.find_spec(module) is None]
    return missing + ([] if shutil.which("gmsh") else ["gmsh"])


def run_here_or_under_debian():
    """Returns if everything is here; else starts the script again under Debian's Python, or skips it."""
    missing = missing_packages()
    if not missing:
        return
    if os.path.realpath(sys.executable) != os.path.realpath(DEBIAN_PYTHON) and os.access(DEBIAN_PYTHON, os.X_OK):
        os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])
    print(f"SKIP: the Debian packages {', '.join(missing)} are missing; scripts/packages.sh test installs them")
    sys.exit(SKIPPED)
