"""Published numbers of other planners on the tasks of the GCS paper, their source, and how the setups differ."""

GCS = "gcs"
GCS_TASKS = (
    ("above-shelf", "top-shelf"),
    ("top-shelf", "centre-shelf"),
    ("centre-shelf", "left-bin"),
    ("left-bin", "right-bin"),
    ("right-bin", "above-shelf"),
)


LENGTHS_RAD = {
    "GCS": (3.3, 2.1, 2.6, 3.5, 1.8),
    "PRM": (9.7, 6.7, 3.7, 6.1, 4.2),
    "PRM, shortcuts": (5.6, 5.2, 2.7, 3.8, 1.9),
}
SECONDS = {
    "GCS": (0.11, 0.01, 0.05, 0.14, 0.08),
    "PRM": (0.26, 0.21, 0.20, 0.21, 0.21),
    "PRM, shortcuts": (0.61, 0.60, 0.44, 0.51, 0.54),
}

SOURCE = """T. Marcucci, M. Petersen, D. von Wrangel, R. Tedrake: Motion planning around obstacles with convex
optimization, arXiv 2205.04422v1, section 7.4, figure 10. The numbers are copied from a public summary of that version;
the article in Science Robotics (2023), whose PRM has 10,000 nodes, was not available. Differences. Robot: theirs is
Drake's iiwa 14 of spheres, ours has wider capsules; both carry the same gripper. Table: ours is 1 mm lower. Machine:
another one, so seconds compare poorly. Work: theirs are queries on 8 regions made in 53 s (from seeds set by hand) or
on a PRM of 15,000 samples made in 16 min, which are not counted; ours are whole plans, except on the saved roadmap.
Proof: GCS uses regions that were not certified, PRM samples its edges every 0.02 rad; ours proves every motion. GCS
minimises length only, in regions that cover part of free space: a shorter path of ours may leave them."""
