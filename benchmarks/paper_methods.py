"""The paper's methods as commands of lumesh, with the paper's figures; times in seconds by number of cores, small cases on its
machine Wahab, large ones on Anvil. A method needs what others write if its commands name those files."""
import dataclasses

CASE1_COMPLEXITY, CASE2_COMPLEXITY = 180_000, 20_000
LARGE_COMPLEXITY = 4_600_000, 8_900_000  # Of cases 1 and 2: about the paper's numbers of tetrahedra, 50 and 100 million.
LARGE_TETRAHEDRA = 50_000_000
CDT3D = "--sref {sref} --cdff 1.2 --cdfn {cdfn} --nqual {nqual} --nsmth {nsmth} --mpp 5"


@dataclasses.dataclass(frozen=True)
class Paper:
    """What the paper tells; 0 or empty where it tells nothing."""
    tetrahedra: float = 0
    points: float = 0
    seconds: dict = dataclasses.field(default_factory=dict)
    angles: tuple = ()
    hausdorff: float = 0


@dataclasses.dataclass(frozen=True)
class Method:
    key: str
    name: str             # The paper's.
    case: int
    commands: tuple       # Measured together.
    mesh: str = ""        # Counted and evaluated; none: rates are those of the points of `points_of`.
    paper: Paper = Paper()
    group: str = "small"
    before: tuple = ()    # Not measured.
    after: tuple = ()     # Not measured: makes `mesh` out of what the commands leave.
    points_of: str = ""
    image: str = ""       # Whose distance counts.
    figure: str = ""      # Where its curves stand: angles or metric.


def minutes(**cores):
    return {int(n[1:]): 60 * t for n, t in cores.items()}


def literal(**numbers):
    """Table 1's line of CDT3D (aniso)."""
    return CDT3D.format(**numbers) + " --met 1 --meval 1 --reconstruct 1"


def layers_of(mesh, height, key):
    """Table 1's line of AFLR, and the layers by themselves."""
    return {"commands": (f"layers {mesh} --mbl 1 --blds {height} --fints 0 --open -o {key}_all.vtu",), "mesh": f"{key}.vtu",
            "after": (f"convert {key}_all.vtu --only-labels vessel_wall {key}.vtu",)}


def surface_sizes(mesh, out):
    """Isotropic sizes that grow inwards from the edges of the surface."""
    return f"metric {mesh} --curvature --edges-per-radius 0.1 --max-size 10 --max-aspect 1 --frozen-sizes on --gradation 1.2 -o {out}"


def case1():
    aniso = f"--points line.vtp --k 40 --complexity {CASE1_COMPLEXITY}"
    frozen = "--boundary frozen"
    return [
        Method("case1_cbc3d", "CBC3D", 1, ("lattice case1.nrrd -o case1.vtu --surface case1.stl",), "case1.vtu",
               Paper(272e3, 63e3, {1: 61.59}, hausdorff=4.51), before=("phantom carotid -o case1.nrrd",), image="case1.nrrd",
               figure="angles"),
        Method("case1_vmtk", "VMTK", 1, ("centerline case1.vtu -o line.vtp",)),
        Method("case1_metric", "Build_Sizing/Metric, k = 40", 1,
               (f"metric case1.vtu {aniso} --max-aspect 10 --frozen-sizes on -o case1_metric.vtu",),
               paper=Paper(seconds=minutes(n1=191, n10=19, n20=9)), points_of="case1_cbc3d"),
        Method("case1_sizes", "Build_Sizing/Metric, isotropic, k = 30", 1,
               ("metric case1.vtu --points line.vtp --k 30 --isotropic -o case1_sizes.vtu",), points_of="case1_cbc3d"),
        Method("case1_tetgen_sizes", "TetGen (w/ adaptivity)", 1,
               ("delaunay case1.stl --size-points line.vtp --size-k 30 -o tetgen_sizes.vtu",),
               "tetgen_sizes.vtu", Paper(120e3, 37e3, minutes(n1=0.1), (3.99, 171.66)), figure="angles"),
        Method("case1_tetgen", "TetGen (no adaptivity)", 1, ("delaunay case1.stl -o tetgen.vtu",), "tetgen.vtu",
               Paper(118e3, 36e3, minutes(n1=0.06), (1.67, 176.73)), figure="angles"),
        Method("case1_podm", "PODM (no vol. adaptivity)", 1, ("delaunay case1.nrrd --delta 1.2 --size 1000 -o podm.vtu",), "podm.vtu",
               Paper(599e3, 131e3, minutes(n1=0.35, n10=0.05, n20=0.04), (4.71, 170.15), 2.42), image="case1.nrrd", figure="angles"),
        Method("case1_podm_sizes", "PODM (w/ vol. adaptivity)", 1,
               ("delaunay case1.nrrd --delta 1.2 --size 1000 --size-points line.vtp --adapt-const 2 -o podm_sizes.vtu",), "podm_sizes.vtu",
               Paper(644e3, 141e3, minutes(n1=1.1, n10=0.15, n20=0.1), (4.65, 170.14), 2.42), image="case1.nrrd", figure="angles"),
        Method("case1_aflr", "AFLR (bl)", 1, paper=Paper(912e3, 183e3, minutes(n1=0.43), (1.48, 176.69)), figure="angles",
               **layers_of("case1.vtu", 1.2, "case1_layers")),
        Method("case1_cdt3d_iso", "CDT3D (iso)", 1,
               (surface_sizes("case1.vtu", "iso_sizes.vtu"), f"adapt iso_sizes.vtu {frozen} --reconnect-below 0.8 -o iso.vtu"),
               "iso.vtu", Paper(631e3, 122e3, minutes(n1=0.6, n10=0.3, n20=0.1), (3.99, 165.25)), figure="angles"),
        Method("case1_cdt3d_aniso", "CDT3D (aniso)", 1,
               (f"adapt case1_metric.vtu {frozen} --complexity {CASE1_COMPLEXITY} -o aniso.vtu",), "aniso.vtu",
               Paper(1.59e6, 284e3, minutes(n1=20, n10=3, n20=2)), figure="metric"),
        Method("case1_merge", "merge (VTK)", 1, ("merge aniso.vtu case1_layers.vtu -o case1_final.vtu",), "case1_final.vtu"),
        Method("case1_literal", "CDT3D (aniso), Table 1 to the letter", 1,
               (f"adapt literal_metric.vtu {literal(sref=0, cdfn=0.6, nqual=3, nsmth=5)} -o literal.vtu",), "literal.vtu",
               Paper(1.59e6, 284e3, minutes(n1=20, n10=3, n20=2)), "literal",
               (f"metric case1.vtu {aniso} --gradation 1e9 --frozen-sizes off -o literal_metric.vtu",), figure="metric"),
    ]


def case2():
    aniso = f"--velocity flow.vtp --complexity {CASE2_COMPLEXITY}"
    frozen = "--boundary frozen"
    paper = Paper(80e3, 15e3, {1: 910, 10: 105, 20: 69})
    adapted = Paper(90e3, seconds={20: 22})
    three = "metric case2_iso.vtu " + aniso + " --velocity-k 3 --gradation 1e9 --frozen-sizes off -o {}.vtu"
    return [
        Method("case2_tetgen", "TetGen (no adaptivity)", 2, ("delaunay case2.stl -o case2_tetgen.vtu",), "case2_tetgen.vtu",
               Paper(12e3, 3e3, {1: 1.54}, (2.71, 171.3)), figure="angles",
               before=("phantom bifurcation -o case2.nrrd --velocity flow.vtp", "lattice case2.nrrd -o case2.vtu --surface case2.stl")),
        Method("case2_aflr", "AFLR (bl)", 2, paper=Paper(82e3, 16e3, {1: 3.2}, (2.8, 171.83)), figure="angles",
               **layers_of("case2_tetgen.vtu", 0.12, "case2_layers")),
        Method("case2_cdt3d_iso", "CDT3D (iso)", 2,
               (surface_sizes("case2_tetgen.vtu", "case2_sizes.vtu"),
                f"adapt case2_sizes.vtu {frozen} --reconnect-below 0.8 -o case2_iso.vtu"), "case2_iso.vtu",
               Paper(31e3, 7e3, {1: 2.2, 10: 1.73, 20: 1.24}, (3.54, 172.93)), figure="angles"),
        Method("case2_cdt3d_aniso", "CDT3D (aniso)", 2,
               (f"adapt case2_metric.vtu {frozen} --complexity {CASE2_COMPLEXITY} -o case2_aniso.vtu",), "case2_aniso.vtu", paper,
               before=(f"metric case2_iso.vtu {aniso} --frozen-sizes on -o case2_metric.vtu",), figure="metric"),
        Method("case2_cdt3d_surface", "CDT3D (aniso), surface adapted", 2,
               (f"adapt case2_free.vtu --complexity {CASE2_COMPLEXITY} -o case2_surface.vtu",), "case2_surface.vtu", adapted,
               before=(f"metric case2_iso.vtu {aniso} -o case2_free.vtu",), figure="metric"),
        Method("case2_merge", "merge (VTK)", 2, ("merge case2_aniso.vtu case2_layers.vtu -o case2_final.vtu",), "case2_final.vtu"),
        Method("case2_literal", "CDT3D (aniso), to the letter", 2,
               (f"adapt literal2.vtu {literal(sref=0, cdfn=0.8, nqual=10, nsmth=10)} -o case2_literal.vtu",), "case2_literal.vtu",
               paper, "literal", (three.format("literal2"),), figure="metric"),
        Method("case2_literal_surface", "CDT3D (aniso), surface adapted, to the letter", 2,
               (f"adapt literal3.vtu {literal(sref=1, cdfn=0.6, nqual=3, nsmth=5)} -o case2_literal3.vtu",), "case2_literal3.vtu",
               adapted, "literal", (three.format("literal3"),), figure="metric"),
    ]


def large(part):
    """Groups of one each; {delta} is found by trials, see paper.py."""
    one, two = (round(complexity * part) for complexity in LARGE_COMPLEXITY)
    return [
        Method("large_podm", "PODM (no adaptivity)", 1, ("delaunay case1.nrrd --delta {delta} -o large_podm.meshb",),
               "large_podm.meshb", Paper(48.2e6, 8.6e6, minutes(n1=9.6, n2=4.8, n4=2.4, n8=1.3, n16=0.7, n32=0.4, n64=0.3, n96=0.2),
                                         (4.35, 170.29)), "podm", figure="angles"),
        Method("large_podm_sizes", "PODM (w/ adaptivity)", 1,
               ("delaunay case1.nrrd --delta {delta} --size-points line.vtp --adapt-const 2 -o large_podm_sizes.meshb",),
               "large_podm_sizes.meshb", Paper(49.3e6, 12.2e6, minutes(n1=50, n2=25, n4=13, n8=6.6, n16=3.4, n32=1.8, n64=1.1, n96=0.7),
                                               (4.25, 170.26)), "podm-sizes", figure="angles"),
        Method("large_case1", "CDT3D (Optimized)", 1,
               (f"adapt large1_metric.vtu --boundary frozen --complexity {one} -o large1.vtu",), "large1.vtu",
               Paper(47.3e6, 8.1e6, minutes(n1=259, n2=122, n4=65, n8=35, n16=19, n32=10, n64=7.8, n96=5.5)), "case1",
               (f"metric case1.vtu --points line.vtp --k 40 --complexity {one} --max-aspect 10 --frozen-sizes on -o large1_metric.vtu",),
               figure="metric"),
        Method("large_case2", "CDT3D (Optimized)", 2,
               (f"adapt large2_metric.vtu --complexity {two} -o large2.vtu",), "large2.vtu",
               Paper(97.9e6, 16.5e6, minutes(n1=554, n2=265, n4=146, n8=81, n16=43, n32=24, n64=16, n96=12)), "case2",
               (f"metric case2_iso.vtu --velocity flow.vtp --complexity {two} -o large2_metric.vtu",), figure="metric"),
    ]


def all_methods(part=1):
    """With a part of the large meshes' tetrahedra."""
    return [*case1(), *case2(), *large(part)]
