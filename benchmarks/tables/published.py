"""Numbers that others have published, where they stand, and what differs; typed off, never measured here."""

from __future__ import annotations

from dataclasses import dataclass

GCS, MBM = "gcs", "motionbenchmaker"
GCS_TASKS = (
    ("above-shelf", "top-shelf"),
    ("top-shelf", "centre-shelf"),
    ("centre-shelf", "left-bin"),
    ("left-bin", "right-bin"),
    ("right-bin", "above-shelf"),
)
ALL = "all"


@dataclass(frozen=True)
class Published:
    """What ``method`` is said to need for ``task`` of ``table``: the path's length (rad) and seconds."""

    table: str
    task: str
    method: str
    length_rad: float
    seconds: float


def _gcs() -> tuple[Published, ...]:
    lengths = {
        "GCS": (3.3, 2.1, 2.6, 3.5, 1.8),
        "PRM": (9.7, 6.7, 3.7, 6.1, 4.2),
        "PRM, shortcuts": (5.6, 5.2, 2.7, 3.8, 1.9),
    }
    seconds = {
        "GCS": (0.11, 0.01, 0.05, 0.14, 0.08),
        "PRM": (0.26, 0.21, 0.20, 0.21, 0.21),
        "PRM, shortcuts": (0.61, 0.60, 0.44, 0.51, 0.54),
    }
    return tuple(
        Published(GCS, f"{start} to {goal}", method, lengths[method][k], seconds[method][k])
        for method in lengths
        for k, (start, goal) in enumerate(GCS_TASKS)
    )


PUBLISHED = (
    *_gcs(),
    Published(MBM, ALL, "VAMP RRT-Connect, median", 7.76256, 35e-6),
    Published(MBM, ALL, "VAMP RRT-Connect, simplified, median", 4.90312, 99e-6),
)

SOURCES = {
    GCS: """T. Marcucci, M. Petersen, D. von Wrangel, R. Tedrake: Motion planning around obstacles with convex
optimization, arXiv 2205.04422v1, section 7.4, figure 10. The numbers are typed off a public summary of that version;
the article in Science Robotics (2023), whose PRM has 10,000 nodes, could not be read here. What differs. Robot: theirs
is Drake's iiwa 14 of spheres, ours has wider capsules; both carry the same gripper. Table: ours is 1 mm lower.
Machine: not ours, so seconds say little. Work: theirs are queries on 8 regions made in 53 s (by hand-placed seeds) or
on a PRM of 15,000 samples made in 16 min, which are not counted; ours are whole plans from nothing, but for the kept
roadmap. Proof: GCS keeps to regions that were not certified, PRM samples its edges every 0.02 rad; ours proves every
motion. GCS minimises length only, in regions that hold part of free space: a shorter path of ours may leave them.""",
    MBM: """VAMP: W. Thomason, Z. Kingston, L. Kavraki: Motions in microseconds via vectorized sampling-based planning,
2024; the numbers are its repository's reference timings for the Panda (resources/README.md): 699 of 700 problems
solved. What differs. Problems: all 700 there, a folder of the same seven scene types here. Robot: spheres around the
meshes there, meshes here, fingers 6.5 cm apart in both. Machine: an AMD Ryzen 9 7950X with AVX2 there. Proof: VAMP
checks states along edges, ours proves edges; its robots are compiled beforehand, four of them.""",
}

MISSING = (
    "The 700 MotionBenchMaker problems for each robot: archives of a repository and of a web server, in no package. "
    "Any folder of them runs with `python -m benchmarks tables FOLDER` and `python -m benchmarks plan FOLDER`.",
    "Robometrics and Motion Policy Networks (Panda): pickled problems in a repository, in no package.",
    "Manipulability: F. Marić et al., Manipulability maximization using continuous-time Gaussian processes, 2018; "
    "F. Marić et al., A Riemannian metric for geometry-aware singularity avoidance, 2021; A. Gil Aparicio, J. Valls "
    "Miro, An efficient stochastic constrained path planner for redundant manipulators, 2021; J. Haviland, P. Corke, "
    "NEO, 2021. They follow given tool paths or react to a goal, and their scenes and states could not be had as "
    "files: so no published number about manipulability stands beside ours.",
)
"""What was looked for and could not be had without a network."""
