"""Make the visual meshes of ``iiwa14.urdf``: ``python make_visuals.py [folder]`` writes ``visual/*.stl``.

The shapes are our own design after the look of a KUKA LBR iiwa 14; no mesh of anyone was used. NumPy
only, no random numbers: the same files come out every time. The planner never imports this module; it is
run by hand when a shape is to change.

How a link is made
------------------
1. Its smooth housing is the zero set of a distance-like function ``f(points)`` (negative inside), put
   together from tubes and knuckles with rounded unions (``smin``) and clipped to the link's collision
   capsule shrunk by 1 mm. So what is seen lies inside what is checked for collision; only link 5's blend
   between its two capsules (3 mm) and a few rings and gaskets (2 mm) stand out.
2. Rays leave a spine inside the housing, ring after ring; where they cross ``f = 0`` there is a vertex.
   Neighbouring rays make quads that follow the shape, and the rays are spaced so that the surface turns
   by about the same angle from one to the next: it shades well even without vertex normals (STL has
   none).
3. The room in which the neighbour turns (a disc and a cone about the joint axis) is cut away exactly:
   triangles are clipped at the cut, and the cut's own surface, clipped to the inside of the housing,
   closes it.
4. Covers, rings and gaskets are surfaces of revolution pushed a little into the housing.

Colours come from the URDF, so every colour of a link is a file of its own: ``link_i`` (silver),
``link_i_accent`` (orange), ``link_i_dark``. All coordinates are metres in the link's frame; "canonical"
below means: interface to the neighbour at z = 0, axis of the bending joint parallel to y at height h,
housing on the side y < 0. A half turn or a mirror takes it to the link frame.
"""

import sys
from pathlib import Path

import numpy as np

INSIDE = 0.001  # housings stay this far inside the collision capsule (m)
GAP = 0.0015  # half the visible gap at a joint (m)
COLUMNS = 50  # rays a ring
ROUND = 44  # segments of covers, rings, gaskets


# --- distance-like functions ----------------------------------------------------------------------


def smin(a, b, k):
    """Minimum with a rounded transition: at most k / 4 smaller than the true minimum."""
    h = np.maximum(k - np.abs(a - b), 0.0) / k
    return np.minimum(a, b) - h * h * k / 4


def smax(a, b, k):
    """Maximum with a rounded transition."""
    return -smin(-a, -b, k)


def capsule(p, a, b, r):
    """Signed distance to a capsule with axis end points a, b."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    ab = b - a
    t = np.clip(((p - a) @ ab) / (ab @ ab), 0.0, 1.0)
    return np.linalg.norm(p - a - t[..., None] * ab, axis=-1) - r


def knuckle(p, h, radius, y_dome, rounding):
    """Round cylinder about the joint axis (y direction, height h), closed at y = y_dome, open towards +y."""
    d = np.hypot(p[..., 0], p[..., 2] - h)
    return smax(d - radius, y_dome - p[..., 1], rounding)


# --- surfaces: arrays (n, 3, 3) of triangles ------------------------------------------------------


def grid(points, wrap):
    """Triangles of a grid of points (rows, columns, 3) but degenerate ones; wrap closes the columns."""
    p = np.concatenate([points, points[:, :1]], axis=1) if wrap else points
    a, b, c, d = p[:-1, :-1], p[:-1, 1:], p[1:, 1:], p[1:, :-1]

    def fold(*corners):  # cosine of the angle between the two triangles of a quad
        m, n = (np.cross(v - u, w - u) for u, v, w in corners)
        return (m * n).sum(-1) / np.maximum(np.linalg.norm(m, axis=-1) * np.linalg.norm(n, axis=-1), 1e-15)

    first = (fold((a, b, c), (a, c, d)) >= fold((a, b, d), (b, c, d)))[..., None, None]  # the flatter choice
    one = np.where(first, np.stack([a, b, c], -2), np.stack([a, b, d], -2))
    two = np.where(first, np.stack([a, c, d], -2), np.stack([b, c, d], -2))
    return clean(np.concatenate([one.reshape(-1, 3, 3), two.reshape(-1, 3, 3)]))


def clean(tri):
    """Without triangles of (nearly) no area."""
    return tri[np.linalg.norm(normals(tri), axis=-1) > 2e-9]


def normals(tri):
    """Unnormalised normals: twice the area long."""
    return np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])


def flip(tri):
    return tri[:, ::-1]


def facing(tri, f, sign=1.0):
    """The same triangles, each turned so that f grows (sign 1) or falls (-1) along its normal."""
    n = normals(tri)
    n = n / np.linalg.norm(n, axis=-1, keepdims=True)
    c = tri.mean(axis=1)
    up = (f(c + 5e-4 * n) - f(c - 5e-4 * n)) * sign >= 0
    return np.where(up[:, None, None], tri, flip(tri))


def clip(tri, f):
    """The part of the triangles where f <= 0, cut exactly (bisection along the edges)."""
    v = f(tri)
    inside = v <= 0
    count = inside.sum(axis=1)
    out = [tri[count == 3]]
    for k in (1, 2):
        t, s = tri[count == k], inside[count == k]
        if not len(t):
            continue
        odd = np.argmax(s if k == 1 else ~s, axis=1)  # the corner that is alone on its side
        rows = np.arange(len(t))
        a, b, c = t[rows, odd], t[rows, (odd + 1) % 3], t[rows, (odd + 2) % 3]
        if k == 1:
            out.append(np.stack([a, cross_point(a, b, f), cross_point(a, c, f)], 1))
        else:
            ab, ac = cross_point(b, a, f), cross_point(c, a, f)
            out += [np.stack([ab, b, c], 1), np.stack([ab, c, ac], 1)]
    return clean(np.concatenate(out))


def cross_point(inner, outer, f):
    """Where f changes sign between points inside (f <= 0) and points outside."""
    lo, hi = np.zeros(len(inner)), np.ones(len(inner))
    for _ in range(40):
        mid = 0.5 * (lo + hi)
        now = f(inner + mid[:, None] * (outer - inner)) <= 0
        lo, hi = np.where(now, mid, lo), np.where(now, hi, mid)
    return inner + lo[:, None] * (outer - inner)


def shoot(f, origins, directions, reach=0.2, step=0.001):
    """First crossing of f = 0 along rays that start inside."""
    t = np.zeros(directions.shape[:-1])
    alive = f(origins) < 0
    assert alive.all(), "a ray starts outside its housing"
    for k in range(1, int(reach / step) + 1):
        alive = alive & (f(origins + (k * step) * directions) < 0)
        t = np.where(alive, k * step, t)
    assert not alive.any(), "a ray left no housing"
    lo, hi = t, t + step
    for _ in range(40):
        mid = 0.5 * (lo + hi)
        now = f(origins + mid[..., None] * directions) < 0
        lo, hi = np.where(now, mid, lo), np.where(now, hi, mid)
    return origins + lo[..., None] * directions


def revolve(profile, segments=48, axis="z", centre=(0.0, 0.0, 0.0)):
    """Surface of revolution of a profile [(radius, height), ...], normals to its right.

    A profile that starts on the axis below, goes outwards and comes back above encloses its solid.
    ``axis`` "-y" lets the height grow towards -y (the covers of the knuckles).
    """
    angle = 2 * np.pi * np.arange(segments) / segments
    r, z = np.asarray(profile, float).T
    x, y = r[:, None] * np.cos(angle), r[:, None] * np.sin(angle)
    z = np.broadcast_to(z[:, None], x.shape)
    points = np.stack([x, y, z] if axis == "z" else [x, -z, y], -1)  # z goes to -y by a quarter turn about x
    return grid(points + np.asarray(centre), wrap=True)


def rounded(r, low, high, edge, steps=3, r_in=None):
    """Profile of a disc (or of a ring with inner radius r_in) from low to high with a rounded upper edge."""
    a = np.linspace(0, np.pi / 2, steps + 1)
    top = [(r - edge + edge * np.cos(t), high - edge + edge * np.sin(t)) for t in a]
    if r_in is None:
        return [(r, low), *top, (0.0, high)]
    back = [(r_in + edge - edge * np.cos(t), high - edge + edge * np.sin(t)) for t in a[::-1]]
    return [(r, low), *top, *back, (r_in, low)]


# --- housings with a bending joint ----------------------------------------------------------------


def rays(spine, b, heights, angles):
    """Ray origins and directions.

    Heights up to 1 are fractions of the way from the interface to the point b, rings at spine(z) = (y, tilt);
    heights from 1 to 2 are the cap about b, 2 its pole (+z).
    """
    c, s = np.cos(angles), np.sin(angles)
    origins, directions = [], []
    for t in heights:
        if t <= 1:
            z = GAP + t * (b[2] - GAP)
            y, tilt = spine(z)
            origins.append(np.tile([0.0, y, z], (len(angles), 1)))
            directions.append(np.stack([c, s * np.cos(tilt), s * np.sin(tilt)], -1))
        else:
            e = (t - 1) * np.pi / 2
            origins.append(np.tile(b, (len(angles), 1)))
            directions.append(np.stack([c * np.cos(e), s * np.cos(e), np.full(len(angles), np.sin(e))], -1))
    return np.array(origins), np.array(directions)


def gradient(f, p, step=1e-5):
    g = np.stack([f(p + step * e) - f(p - step * e) for e in np.eye(3)], -1)
    return g / np.maximum(np.linalg.norm(g, axis=-1, keepdims=True), 1e-12)


def skin(f, spine, b, rows, seen):
    """Mesh of f = 0 with `rows` rings, spaced by the surface's turning where seen(points) holds."""
    heights, angles = np.linspace(0, 2, 121), np.linspace(0, 2 * np.pi, 145)
    p = shoot(f, *rays(spine, b, heights, angles))
    n, show = gradient(f, p), seen(p)

    def spaced(values, axis, count, floor):
        n_, p_, show_ = (np.moveaxis(x, axis, 0) for x in (n, p, show))
        turn = np.arccos(np.clip((n_[1:] * n_[:-1]).sum(-1), -1, 1))
        length = np.linalg.norm(p_[1:] - p_[:-1], axis=-1)
        use = show_[1:] & show_[:-1]
        cost = ((turn + 4.0 * length) * use).sum(1) / np.maximum(use.sum(1), 1)
        cost = np.maximum(cost, floor * cost.mean())
        cost = np.convolve(np.pad(cost, 4, mode="edge"), np.full(9, 1 / 9), mode="valid")
        total = np.concatenate([[0.0], np.cumsum(cost)])
        return np.interp(np.linspace(0, total[-1], count), total, values)

    chosen = rays(spine, b, spaced(heights, 0, rows, 0.25), spaced(angles, 1, COLUMNS + 1, 0.5)[:-1])
    p = shoot(f, *chosen)
    lip = np.array([p[0], p[0] * [0.85, 0.85, 1.0]])  # closes the edge at the interface
    return np.concatenate([facing(grid(p, wrap=True), f), facing(grid(lip, wrap=True), lambda q: -q[..., 2])])


def elbow(f, spine, b, rows, h, seam, r_cut, slope, y_far, r_seam, hidden):
    """Housing f minus the neighbour's room: y > seam, within a cone about the joint axis from r_cut on."""

    def room(p):  # > 0 inside the neighbour's room
        y = p[..., 1] - seam
        return np.minimum(y, r_cut + slope * y - np.hypot(p[..., 0], p[..., 2] - h))

    def seen(p):
        return (room(p) < 0) & ~hidden(p)

    housing = skin(f, spine, b, rows, seen)
    housing = clip(housing[~hidden(housing).all(axis=1)], room)
    radii = [(0.0, 0.0), (0.6 * r_seam, 0.0), (r_cut, 0.0)]
    disc = clip(revolve(radii, COLUMNS, "-y", (0.0, seam, h)), f)
    reach = y_far - seam
    steps = [(r_cut + slope * t * reach, -t * reach) for t in np.linspace(0, 1, 4)]
    cone = revolve(steps, 80, "-y", (0.0, seam, h))
    cone = clip(clip(cone, f), lambda p: GAP - p[..., 2])
    out_of_room = lambda p: -room(p)  # noqa: E731
    return np.concatenate([housing, facing(disc, out_of_room, 1.0), facing(cone, out_of_room, 1.0)])


def under_cover(h, r, y_dome):
    """Which points of the housing the cover hides."""
    return lambda p: (p[..., 1] < y_dome + 0.006) & (np.hypot(p[..., 0], p[..., 2] - h) < r)


def cover(h, r, y_dome, rise=0.0025):
    """Silver button and orange ring on the knuckle's round end; the heights count from y_dome towards -y."""
    button = rounded(r, -0.008, rise, 0.003, 2)
    ring = rounded(r + 0.006, -0.012, rise - 0.0015, 0.0015, 1, r_in=r - 0.0005)
    centre = (0.0, y_dome, h)
    return revolve(button, ROUND, "-y", centre), revolve(ring, ROUND, "-y", centre)


def gasket(r, axis, centre):
    """Dark band in a joint's gap."""
    return revolve([(r, -GAP), (r, GAP)], ROUND, axis, centre)


def collar(r, low, high):
    """Orange band about the z axis."""
    return revolve([(r - 0.004, low), (r, low + 0.0006), (r, high - 0.0006), (r - 0.004, high)], ROUND + 8)


def standard_elbow(
    *, h, a, b, r, tube, knuckle_r, y_dome, cover_r, seam=0.0, r_cut=None, slope=0.75, blend=0.05, narrow=0.0
):
    """One of links 1, 2, 3, 4, 6 in canonical coordinates: a, b = (y, z) ends of the capsule of radius r."""
    a3, b3 = np.array([0.0, *a]), np.array([0.0, *b])

    def f(p):
        tube_f = capsule(p, [0, 0, -1.0], [0, 0, h - 0.02], tube)
        near_seam = np.maximum(p[..., 1] - seam + 0.03, 0.0)  # the knuckle may narrow over its last 3 cm
        both = smin(tube_f, knuckle(p, h, knuckle_r - narrow * near_seam, y_dome, 0.03), blend)
        both = smax(both, y_dome - p[..., 1], 0.01)
        return smax(both, capsule(p, a3, b3, r) + INSIDE, 0.006)

    def spine(z):
        return float(np.interp(z, [a[1], b[1]], [a[0], b[0]])), 0.0

    r_cut = knuckle_r + 0.004 if r_cut is None else r_cut
    hidden = under_cover(h, cover_r, y_dome)
    body = elbow(f, spine, b3, 18, h, seam - GAP, r_cut, slope, 0.10, knuckle_r, hidden)
    button, ring = cover(h, cover_r, y_dome)
    return np.concatenate([body, button]), ring


def upside_down(tri, h):
    """Canonical -> link frame of a link whose bending joint is at the bottom: half turn about x."""
    return tri * np.array([1.0, -1.0, -1.0]) + np.array([0.0, 0.0, h])


def mirrored(tri):
    """Mirror in y."""
    return flip(tri * np.array([1.0, -1.0, 1.0]))


def join(*parts):
    return np.concatenate(parts)


# --- the links ------------------------------------------------------------------------------------


def link_0():
    """Foot: a waisted column on a round foot, with the connector box behind (-x)."""
    t = np.linspace(0, 1, 7)
    waist = [(0.1005 - 0.0150 * (3 * s**2 - 2 * s**3), 0.022 + 0.100 * s) for s in t]
    column = [(0.0, 0.0), (0.1205, 0.0), (0.1205, 0.0125), (0.1185, 0.0145), (0.107, 0.0150)]
    column += [(0.1025, 0.0165), *waist, (0.0855, 0.1575 - GAP), (0.0720, 0.1575 - GAP)]
    body = revolve(column, 60)
    box, panel = connector_box()
    sockets = [revolve(rounded(r, 0.0, 0.0035, 0.001, 1), 20) for r in (0.011, 0.011, 0.008)]
    places = [(-0.144, 0.019, 0.060), (-0.144, -0.019, 0.060), (-0.144, 0.0, 0.036)]
    turn = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])  # z to -x
    sockets = [s @ turn.T + np.array(c) for s, c in zip(sockets, places, strict=True)]
    bolts = []
    for k in range(4):
        w = np.pi / 4 + k * np.pi / 2
        centre = (0.1125 * np.cos(w), 0.1125 * np.sin(w), 0.0)
        bolts.append(revolve(rounded(0.0052, 0.010, 0.0185, 0.001, 1), 12, centre=centre))
    return {
        "": join(body, box),
        "_accent": collar(0.0867, 0.1430, 0.1490),
        "_dark": join(panel, *bolts, gasket(0.0820, "z", (0, 0, 0.1575)), *sockets),
    }


def connector_box():
    """Rounded box from the column to x = -0.144, its rear face dark."""
    angle = 2 * np.pi * (np.arange(36) + 0.5) / 36
    c, s = np.cos(angle), np.sin(angle)

    def section(x, inset):  # superellipse: a rectangle with round corners
        half_y, half_z, e = 0.043 - inset, 0.0345 - inset, 0.35
        y = half_y * np.sign(c) * np.abs(c) ** e
        z = 0.0495 + half_z * np.sign(s) * np.abs(s) ** e
        return np.stack([np.full_like(y, x), y, z], -1)

    edge = [(-0.06, 0.0), (-0.138, 0.0), (-0.1405, 0.0008), (-0.142, 0.0025), (-0.142, 0.005)]
    box = grid(np.array([section(*e) for e in edge]), wrap=True)
    middle = np.tile([-0.143, 0.0, 0.0495], (36, 1))
    face = np.array([section(-0.142, 0.005), section(-0.143, 0.0055), middle])
    mid = np.array([-0.09, 0.0, 0.0495])
    out = lambda p: np.linalg.norm((p - mid) / [0.052, 0.043, 0.0345], axis=-1)  # noqa: E731
    return facing(box, out), facing(grid(face, wrap=True), out)


def link_1():
    h = 0.2025
    shape = dict(a=(0.0, 0.029), b=(-0.030, 0.204), r=0.092, tube=0.0855)
    body, ring = standard_elbow(h=h, **shape, knuckle_r=0.085, y_dome=-0.1005, cover_r=0.051)
    return {"": body, "_accent": ring, "_dark": gasket(0.0815, "-y", (0, 0, h))}


def link_2():
    h = 0.2045
    shape = dict(a=(0.0, 0.0645), b=(-0.039, 0.2055), r=0.095, tube=0.069)
    body, ring = standard_elbow(h=h, **shape, knuckle_r=0.085, y_dome=-0.112, cover_r=0.051, blend=0.07)
    return {
        "": upside_down(body, h),
        "_accent": upside_down(ring, h),
        "_dark": gasket(0.0655, "z", (0, 0, h)),
    }


def link_3():
    h = 0.2155
    shape = dict(a=(0.0, 0.039), b=(-0.040, 0.217), r=0.080, tube=0.069)
    body, ring = standard_elbow(h=h, **shape, knuckle_r=0.068, y_dome=-0.1015, cover_r=0.042)
    return {
        "": mirrored(body),
        "_accent": join(mirrored(ring), collar(0.0702, 0.0085, 0.0145)),
        "_dark": gasket(0.0645, "-y", (0, 0, h)),
    }


def link_4():
    h = 0.1845
    shape = dict(a=(0.0, 0.0405), b=(-0.041, 0.1855), r=0.081, tube=0.068)
    body, ring = standard_elbow(h=h, **shape, knuckle_r=0.068, y_dome=-0.1035, cover_r=0.042)
    ring = join(mirrored(ring), collar(0.0692, 0.0085, 0.0145))
    return {
        "": upside_down(mirrored(body), h),
        "_accent": upside_down(ring, h),
        "_dark": gasket(0.0645, "z", (0, 0, h)),
    }


def link_5():
    """Tube that leans over into a slender arm at the side of the wrist."""
    h, seam, y_dome, cover_r = 0.2155, -0.026, -0.1100, 0.026
    a1, a2, b1, b2 = [0, 0, 0.024], [0, -0.024, 0.060], [0, -0.065, 0.144], [0, -0.064, 0.216]

    def f(p):
        allowed = smin(capsule(p, a1, a2, 0.076), capsule(p, b1, b2, 0.055), 0.016) + INSIDE
        tube = capsule(p, [0, 0, -1.0], [0, -0.002, 0.060], 0.068)
        arm = smin(capsule(p, [0, -0.020, 0.070], b1, 0.052), capsule(p, b1, [0, -0.064, h], 0.054), 0.01)
        return smax(smax(smin(tube, arm, 0.03), y_dome - p[..., 1], 0.01), allowed, 0.006)

    def spine(z):
        s = np.clip((z - 0.02) / 0.125, 0, 1)
        return -0.064 * (3 * s**2 - 2 * s**3), 0.5 * np.sin(np.pi * np.clip((z - 0.01) / 0.175, 0, 1)) ** 2

    hidden = under_cover(h, cover_r, y_dome)
    body = elbow(f, spine, np.array([0.0, -0.064, h]), 22, h, seam - GAP, 0.0765, 0.1, 0.06, 0.046, hidden)
    button, ring = cover(h, cover_r, y_dome)
    return {"": join(body, button), "_accent": ring, "_dark": gasket(0.041, "-y", (0, seam, h))}


def link_6():
    h = 0.071
    body, ring = standard_elbow(
        h=h,
        a=(0.0, 0.049),
        b=(0.0, 0.087),
        r=0.080,
        tube=0.0515,
        knuckle_r=0.073,
        y_dome=-0.0635,
        cover_r=0.038,
        seam=0.026,
        r_cut=0.0565,
        slope=0.2,
        blend=0.03,
        narrow=0.3,
    )
    return {"": upside_down(body, h), "_accent": upside_down(ring, h), "_dark": gasket(0.048, "z", (0, 0, h))}


def link_7():
    """Flange: a short drum, dark face with seven bolt holes on a 50 mm circle and a centring recess."""
    drum = [(0.0, -0.0083), (0.0505, -0.0083), (0.0515, -0.0073), (0.0515, 0.0265), (0.0488, 0.0278)]
    drum += [(0.0515, 0.0291), (0.0515, 0.0435), (0.0500, 0.0450), (0.0455, 0.0450), (0.0448, 0.0443)]
    face = [(0.0448, 0.0443), (0.0160, 0.0443), (0.0157, 0.0400), (0.0, 0.0400)]
    holes = []
    for k in range(7):
        w = (k + 1) * np.pi / 4  # eight places, the eighth takes the dowel hole
        ring = [(0.0042, 0.0440), (0.0042, 0.0448), (0.0030, 0.0448), (0.0030, 0.0440)]
        holes.append(revolve(ring, 12, centre=(0.025 * np.cos(w), 0.025 * np.sin(w), 0.0)))
    return {
        "": join(revolve(drum, 52), *holes),
        "_accent": collar(0.0520, 0.0120, 0.0165),
        "_dark": revolve(face, 52),
    }


LINKS = (link_0, link_1, link_2, link_3, link_4, link_5, link_6, link_7)


def write_stl(path, tri):
    """Binary STL with unit face normals."""
    tri = clean(tri.astype("<f4").astype(float))
    n = normals(tri)
    record = np.zeros(len(tri), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])
    record["normal"] = n / np.linalg.norm(n, axis=-1, keepdims=True)
    record["corners"] = tri
    header = f"iiwa14 {path.stem}, made by make_visuals.py".encode().ljust(80, b" ")
    path.write_bytes(header + np.uint32(len(tri)).astype("<u4").tobytes() + record.tobytes())
    return len(tri)


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    total = 0
    for make in LINKS:
        for suffix, tri in make().items():
            path = folder / f"{make.__name__}{suffix}.stl"
            count = write_stl(path, tri)
            total += count
            print(f"{path.name:22s} {count:6d} triangles {path.stat().st_size:8d} bytes")
    print(f"{'together':22s} {total:6d} triangles")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "visual")
