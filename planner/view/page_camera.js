// From where the scene is seen: all of it in the free part of the window, start, goal and path past the obstacles.

const narrow = () => innerWidth <= 760; // as the style sheet has it

// The free part of the window, beside the panel (on a phone below its head) and above the player, in pixels.
function freeArea() {
  const folded = root.dataset.folded === "true";
  const x = narrow() || folded ? 0 : element("panel").getBoundingClientRect().right;
  const y = narrow() ? element("panel").getBoundingClientRect().bottom : 0;
  const bottom = element("player").hidden ? innerHeight : element("player").getBoundingClientRect().top;
  return { x, y, width: innerWidth - x, height: bottom - y };
}

// The place of the tool at shares of a path, start and goal among them, and how much it counts that each is seen; where
// there is no path those of starts and goals.
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

// How much of the places an eye there sees past the obstacles.
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

// From where most of the way is seen: from the front right where several are as good, else as near to that as can be.
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

// The ball around everything fills the free part of the window; seen from where it was seen, or at first from where
// start, goal and path are.
function lookAtAll(ahead = null) {
  const free = freeArea(), camera = viewer.camera;
  camera.fov = 36; // a longer lens than the viewer's own: less distortion
  const focal = innerHeight / 2 / Math.tan((camera.fov * Math.PI) / 360);
  // seen from here the ball is as wide as a disc of r / sqrt(1 - (r / distance)²)
  const distance = data.radius * Math.hypot(1, focal / (0.5 * Math.min(free.width, free.height)));
  const [x, y, z] = data.centre;
  const target = new THREE.Vector3(x, z, -y); // meshcat turns z-up into three.js's y-up
  camera.position.copy(target).addScaledVector(ahead || bestDirection(distance, target), distance);
  viewer.controls.target.copy(target);
  viewer.controls.update();
  centreView();
}

function centreView() {
  const free = freeArea();
  const x = innerWidth / 2 - (free.x + free.width / 2), y = innerHeight / 2 - (free.y + free.height / 2);
  viewer.camera.setViewOffset(innerWidth, innerHeight, x, y, innerWidth, innerHeight);
  viewer.set_dirty();
}
