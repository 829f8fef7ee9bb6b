"use strict";
// The viewer, and the robot at a configuration: forward kinematics as in planner.kinematics.forward.

const THREE = MeshCat.THREE;
const viewer = new MeshCat.Viewer(element("viewer"));

const group = (path) => viewer.scene_tree.find(["meshcat", ...path.split("/")]).object;
const drawn = (path) => viewer.scene_tree.find(["meshcat", ...path.split("/"), "<object>"]).object;

function show(path, visible) {
  group(path).visible = visible;
  viewer.set_dirty();
}

// 3 x 3 matrices are rows in one array of nine
function product(a, b) {
  const c = new Array(9);
  for (let i = 0; i < 3; i++)
    for (let j = 0; j < 3; j++)
      c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
  return c;
}

const turned = (a, v) => [0, 1, 2].map((i) => a[3 * i] * v[0] + a[3 * i + 1] * v[1] + a[3 * i + 2] * v[2]);
const plus = (u, v, scale = 1) => [0, 1, 2].map((i) => u[i] + scale * v[i]);

// Rotation and position of every joint frame in the world; number 0 is the base.
function placements(q) {
  const chain = data.chain;
  const frames = [{ rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], position: [0, 0, 0] }];
  chain.leader.forEach((leader, j) => {
    const value = chain.factor[j] * q[leader] + chain.zero[j];
    const { rotation, position } = frames[chain.parent[j]];
    const [c0, c1, c2] = chain.rotations[j];
    let origin = plus(position, turned(rotation, chain.offset[j]));
    let local = c0;
    if (chain.prismatic[j]) origin = plus(origin, turned(rotation, chain.slide[j]), value);
    else local = c0.map((c, k) => c + Math.sin(value) * c1[k] + (1 - Math.cos(value)) * c2[k]);
    frames.push({ rotation: product(rotation, local), position: origin });
  });
  return frames;
}

function toolPosition(frames) {
  const { parent, offset } = data.chain.tool;
  return plus(frames[parent].position, turned(frames[parent].rotation, offset));
}

// Column-major, as three.js and meshcat's set_transform expect.
const columns = (r, p) => [r[0], r[3], r[6], 0, r[1], r[4], r[7], 0, r[2], r[5], r[8], 0, p[0], p[1], p[2], 1];

// The configuration at a share in [0, 1] of a path's joint motion.
function configurationAt(path, share) {
  const last = path.waypoints.length - 1;
  let k = 0;
  while (k < last - 1 && path.shares[k + 1] <= share) k++;
  const a = path.waypoints[k], b = path.waypoints[Math.min(k + 1, last)];
  const length = last ? path.shares[k + 1] - path.shares[k] : 0;
  const part = length > 0 ? (share - path.shares[k]) / length : 0;
  return a.map((value, j) => value + part * (b[j] - value));
}

// Linear interpolation of samples at even shares of the motion.
function sampleAt(samples, share) {
  const place = share * (samples.length - 1);
  const k = Math.min(Math.floor(place), samples.length - 2);
  const mix = (a, b) => a + (place - k) * (b - a);
  const a = samples[k], b = samples[k + 1];
  return Array.isArray(a) ? a.map((value, i) => mix(value, b[i])) : mix(a, b);
}

// The ellipsoid's scale: a round number of metres per 1 m/s that suits the largest one.
function ellipsoidScale() {
  const lengths = data.paths.flatMap((path) => path.ellipsoids.map((s) => Math.hypot(...s.slice(0, 3))));
  const target = (0.35 * data.radius) / Math.max(...lengths, 1e-9);
  const decade = Math.pow(10, Math.floor(Math.log10(target)));
  return decade * (target >= 5 * decade ? 5 : target >= 2 * decade ? 2 : 1);
}

const scale = ellipsoidScale();
const ellipsoid = new THREE.Mesh(
  new THREE.SphereGeometry(1, 40, 24),
  new THREE.MeshPhongMaterial({ color: 0x1565c0, opacity: 0.3, transparent: true, depthWrite: false }),
);
ellipsoid.matrixAutoUpdate = false;
ellipsoid.visible = false;
viewer.scene.add(ellipsoid);

function placeLinks(q) {
  const frames = placements(q);
  frames.slice(1).forEach((frame, j) => {
    viewer.set_transform(["meshcat", "robot", String(j + 1)], columns(frame.rotation, frame.position));
  });
  viewer.set_dirty();
  return frames;
}

function placeRobot(path, share) {
  const frames = placeLinks(configurationAt(path, share));
  const [xx, yy, zz, xy, xz, yz] = sampleAt(path.ellipsoids, share);
  const flat = 1e-3; // a singular direction is thin, but visible
  const rows = [xx + flat, xy, xz, xy, yy + flat, yz, xz, yz, zz + flat].map((value) => scale * value);
  ellipsoid.matrix.fromArray(columns(rows, toolPosition(frames)));
  ellipsoid.matrixWorldNeedsUpdate = true;
  viewer.set_dirty();
}

// The tool's path as a tube.
function drawWay(path, k) {
  const count = Math.max(240, Math.ceil(path.length / 0.08)); // 0.08 rad: the tool leaves the chord by less than the tube's radius
  const points = Array.from({ length: count + 1 }, (_, i) => new THREE.Vector3(...toolPosition(placements(configurationAt(path, i / count)))));
  const tube = new THREE.TubeGeometry(new THREE.CatmullRomCurve3(points), count, 0.006 * data.marks, 8);
  viewer.set_object(["meshcat", "paths", String(k)], new THREE.Mesh(tube, new THREE.MeshPhongMaterial({ color: COLOURS.shown })));
}
