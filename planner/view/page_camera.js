// The camera: the whole scene in the free part of the window, with start, goal and path visible past the obstacles.

const narrow = () => innerWidth <= 760; // as in the style sheet
const flat = () => innerHeight <= 500; // a phone in landscape

// The free part of the window in pixels: right of the panel (on a phone below its head) and above the player.
function freeArea() {
  const folded = root.dataset.folded === "true";
  const x = narrow() || folded ? 0 : element("panel").getBoundingClientRect().right;
  const y = narrow() ? element("panel").getBoundingClientRect().bottom : 0;
  const plots = element("plots"), player = element("player");
  const bottom = narrow() && !plots.hidden ? plots.getBoundingClientRect().top : player.hidden ? innerHeight : player.getBoundingClientRect().top;
  const right = plots.hidden || narrow() ? innerWidth : plots.getBoundingClientRect().left;
  return { x, y, width: Math.max(right - x, 80), height: Math.max(bottom - y, 80) };
}

// Tool positions along a path, start and goal included, with weights for their visibility; starts and goals without a path.
function placesToSee(path) {
  const count = 12;
  if (path.waypoints.length < 2) {
    const ends = ["start", "goal"].flatMap((role) => group(role).children);
    return ends.map((dot) => ({ place: new THREE.Box3().setFromObject(dot).getCenter(new THREE.Vector3()), weight: 1 }));
  }
  return Array.from({ length: count + 1 }, (_, k) => {
    const [x, y, z] = toolPosition(placements(configurationAt(path, k / count)));
    return { place: new THREE.Vector3(x, z, -y), weight: k === 0 || k === count ? 4 : 1 }; // three.js has y up
  });
}

// The weight of the positions that are visible from a viewpoint past the obstacles.
function seenFrom(eye, places, things) {
  const look = new THREE.Raycaster();
  return places.reduce((sum, { place, weight }) => {
    const away = place.clone().sub(eye);
    look.far = away.length() - 0.01;
    look.set(eye, away.normalize());
    return look.intersectObjects(things, true).length ? sum : sum + weight;
  }, 0);
}

const FRONT = -0.974, LOW = 0.337, TURN = Math.PI / 6; // from the front right, a little above

// The direction with the most visible path; among equal ones the nearest to the front right.
function bestDirection(distance, target) {
  const places = placesToSee(shownPath()), things = data.obstacles.map((_, k) => group(obstaclePath(k)));
  let best = { seen: -1 };
  viewer.scene.updateMatrixWorld();
  for (const up of [LOW, 2 * LOW, 3 * LOW]) {
    for (const turns of [0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6]) {
      const around = FRONT + turns * TURN;
      const ahead = new THREE.Vector3(Math.cos(up) * Math.cos(around), Math.sin(up), -Math.cos(up) * Math.sin(around));
      const seen = seenFrom(target.clone().addScaledVector(ahead, distance), places, things);
      if (seen > best.seen) best = { seen, ahead };
    }
  }
  return best.ahead;
}

// Fit robot and path into the free part of the window, from the same direction or at first from the best one. Each round
// centres the projected outermost points, and moves as near as they allow.
function lookAtAll(ahead = null) {
  const free = freeArea(), camera = viewer.camera;
  camera.fov = 36; // a longer lens than the viewer's own: less distortion
  const focal = innerHeight / 2 / Math.tan((camera.fov * Math.PI) / 360);
  const seen = ([x, y, z]) => new THREE.Vector3(x, z, -y); // meshcat turns z-up into three.js's y-up
  const target = seen(data.centre), points = data.fit.map(seen);
  let distance = (2 * data.radius * focal) / Math.min(free.width, free.height) + data.radius;
  const from = ahead || bestDirection(distance, target);
  const right = new THREE.Vector3(0, 1, 0).cross(from).normalize(), up = from.clone().cross(right);
  for (let round = 0; round < 12; round++) {
    const offsets = points.map((point) => point.clone().sub(target));
    const [across, along] = [right, up].map((axis) => {
      const slopes = offsets.map((offset) => offset.dot(axis) / Math.max(distance - offset.dot(from), 0.1 * distance));
      return [Math.min(...slopes), Math.max(...slopes)];
    });
    target.addScaledVector(right, (distance * (across[0] + across[1])) / 2).addScaledVector(up, (distance * (along[0] + along[1])) / 2);
    distance *= focal * Math.max((across[1] - across[0]) / (0.86 * free.width), (along[1] - along[0]) / (0.86 * free.height));
  }
  camera.position.copy(target).addScaledVector(from, distance);
  viewer.controls.target.copy(target);
  viewer.controls.update();
  centreView();
}

// Fit after a change of the free part, unless the user moved the camera.
function fitAgain() {
  if (moved) centreView();
  else lookAtAll(viewer.camera.position.clone().sub(viewer.controls.target).normalize());
}

function centreView() {
  const free = freeArea();
  const x = innerWidth / 2 - (free.x + free.width / 2), y = innerHeight / 2 - (free.y + free.height / 2);
  viewer.camera.setViewOffset(innerWidth, innerHeight, x, y, innerWidth, innerHeight);
  viewer.set_dirty();
}
