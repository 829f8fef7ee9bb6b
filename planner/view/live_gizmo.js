// What the mouse or a finger drags on a live page: a thing itself (level, or across the view where that is seen edge on),
// along an axis by an arrow, or about the vertical by a ring.

const HANDLES = [["x", 0xd32f2f], ["y", 0x2e7d32], ["z", 0x1565c0]];
const LEVEL_VIEW = 0.25; // sine of the angle to the ground below which a thing is moved across the view
const gizmo = new THREE.Group();
const handles = []; // what is drawn
const grips = []; // what is hit: wider than what is drawn, and not seen

function handlePart(geometry, colour) {
  const look = new THREE.MeshBasicMaterial({ color: colour, depthTest: false, transparent: true, opacity: 0.85 });
  const part = new THREE.Mesh(geometry, look);
  part.renderOrder = 10; // in front of everything
  handles.push(part);
  return part;
}

function grip(geometry, kind) {
  const part = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ visible: false }));
  part.userData.kind = kind;
  grips.push(part);
  return part;
}

// Arrows along y as three.js has cylinders, turned to their axes; a ring in the ground's plane.
function makeGizmo() {
  HANDLES.forEach(([axis, colour], k) => {
    const arrow = new THREE.Group();
    const shaft = handlePart(new THREE.CylinderGeometry(0.014, 0.014, 0.86, 10), colour);
    const head = handlePart(new THREE.ConeGeometry(0.055, 0.18, 16), colour);
    const wide = grip(new THREE.CylinderGeometry(0.09, 0.09, 0.8, 8), axis);
    shaft.position.y = 0.43;
    head.position.y = 0.93;
    wide.position.y = 0.66; // not where the arrows meet
    arrow.add(shaft, head, wide);
    if (k === 0) arrow.rotateZ(-Math.PI / 2);
    if (k === 2) arrow.rotateX(Math.PI / 2);
    gizmo.add(arrow);
  });
  const ring = new THREE.Group();
  ring.add(handlePart(new THREE.TorusGeometry(0.62, 0.013, 8, 64), 0xb26a00), grip(new THREE.TorusGeometry(0.62, 0.06, 8, 32), "turn"));
  gizmo.add(ring);
  gizmo.scale.setScalar(0.28 * data.radius);
  viewer.scene.add(gizmo);
}

function showGizmo(position, turns) {
  gizmo.position.set(...position);
  gizmo.children[3].visible = turns;
  viewer.set_dirty();
}

// The pointer's ray in the room's own axes, z up; the ray that objects are hit by is left as the viewer has it.
function pointerRay(event) {
  ray.setFromCamera(new THREE.Vector2((2 * event.clientX) / innerWidth - 1, 1 - (2 * event.clientY) / innerHeight), viewer.camera);
  viewer.scene.updateMatrixWorld();
  return ray.ray.clone().applyMatrix4(viewer.scene.matrixWorld.clone().invert());
}

// How far along an axis through a point the place lies that is nearest to a ray; null where it looks along the axis.
function alongAxis(pointer, point, axis) {
  const apart = pointer.origin.clone().sub(point), b = axis.dot(pointer.direction);
  if (1 - b * b < 1e-3) return null;
  return (axis.dot(apart) - b * pointer.direction.dot(apart)) / (1 - b * b);
}

const onPlane = (pointer, normal, point) =>
  pointer.intersectPlane(new THREE.Plane().setFromNormalAndCoplanarPoint(normal, point), new THREE.Vector3());

const UP = new THREE.Vector3(0, 0, 1);

// Each kind of drag: from a pointer's ray to the pose, as it began in `pose` with the ray `first`.
function axisDrag(k, pose, first) {
  const axis = new THREE.Vector3().setComponent(k, 1), begin = alongAxis(first, pose.position, axis);
  return (pointer) => {
    const now = alongAxis(pointer, pose.position, axis);
    if (now === null || begin === null) return pose;
    return { ...pose, position: pose.position.clone().addScaledVector(axis, now - begin) };
  };
}

function turnDrag(pose, first) {
  const angle = (pointer) => {
    const place = onPlane(pointer, UP, pose.position);
    return place ? Math.atan2(place.y - pose.position.y, place.x - pose.position.x) : null;
  };
  const begin = angle(first);
  return (pointer) => {
    const now = angle(pointer);
    if (now === null || begin === null) return pose;
    return { ...pose, quaternion: new THREE.Quaternion().setFromAxisAngle(UP, now - begin).multiply(pose.quaternion) };
  };
}

function freeDrag(pose, first, place) {
  const level = Math.abs(first.direction.z) > LEVEL_VIEW;
  const normal = level ? UP : first.direction.clone().setZ(0).normalize();
  return (pointer) => {
    const now = onPlane(pointer, normal, place);
    return now ? { ...pose, position: pose.position.clone().add(now).sub(place) } : pose;
  };
}

function dragOf(kind, pose, first, place) {
  if (kind === "turn") return turnDrag(pose, first);
  if (kind === "free") return freeDrag(pose, first, place);
  return axisDrag("xyz".indexOf(kind), pose, first);
}
