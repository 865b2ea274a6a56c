"""Debian's own Python, where the packages python3-vtk9 and python3-meshio are; another Python may come first in PATH."""
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
DEBIAN_PYTHON = "/usr/bin/python3"
PACKAGES = {"vtkmodules": "python3-vtk9", "meshio": "python3-meshio", "h5py": "python3-h5py", "numpy": "python3-numpy"}


def missing_packages(packages):
    missing = [package for module, package in packages.items() if importlib.util.find_spec(module) is None]
    return missing + ([] if shutil.which("gmsh") else ["gmsh"])


def run_here_or_under_debian(more=None):
    """Returns if everything is here; else starts the script again under Debian's Python, or skips it.

    more: modules of the solvers' packages, with these."""
    missing = missing_packages(PACKAGES | (more or {}))
    if not missing:
        return
    if os.path.realpath(sys.executable) != os.path.realpath(DEBIAN_PYTHON) and os.access(DEBIAN_PYTHON, os.X_OK):
        os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])
    group = "test" if set(missing) & set([*PACKAGES.values(), "gmsh"]) else "solvers"
    print(f"SKIP: the Debian packages {', '.join(missing)} are missing; scripts/packages.sh {group} installs them")
    sys.exit(SKIPPED)


def skip_unless_runs(name, code):
    """Skips the test where a client itself does not run, as MPI in some containers: no fault of our files."""
    with tempfile.TemporaryDirectory() as cache:
        tried = subprocess.run([sys.executable, "-c", code], env=os.environ | {"XDG_CACHE_HOME": cache}, capture_output=True,
                               text=True, check=False)
    if tried.returncode != 0:
        print(f"SKIP: {name} does not run here: {(tried.stderr.strip() or str(tried.returncode)).splitlines()[-1]}")
        sys.exit(SKIPPED)


def skip_unless_fenics_runs():
    skip_unless_runs("FEniCS", "from mpi4py import MPI; import dolfinx.fem, dolfinx.mesh; "
                     "dolfinx.fem.FunctionSpace(dolfinx.mesh.create_unit_square(MPI.COMM_WORLD, 1, 1), ('CG', 1))")
