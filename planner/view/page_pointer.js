// Names of obstacles, links and nodes at the pointer; marks of obstacles in the list.

const ray = new THREE.Raycaster();
ray.params.Points.threshold = 0.012; // m
const named = new Map(); // the viewer's group of an object -> its name
let marked = null;

function objectsToPick() {
  const kind = element("collision").checked ? "/collision/" : "/visual/";
  const picked = Object.keys(data.names).filter((path) => !path.startsWith("robot/") || path.includes(kind));
  const objects = picked.map(group);
  if (data.roadmap && group("roadmap/nodes").visible) objects.push(group("roadmap/nodes"));
  return objects;
}

function nodeText(k) {
  const cost = (costField(shownPath()) || [])[k];
  const cells = [`node ${k}`, `w ${short(data.roadmap.w[k])} ${data.unit}`];
  if (cost !== undefined) cells.push(cost === null ? "reaches no goal" : `cost-to-go ${cost.toFixed(3)}`);
  return [...cells, `component ${data.roadmap.component[k]}`].join("\n");
}

// The name of the nearest object at a position in the window, or null.
function nameAt(x, y) {
  const place = new THREE.Vector2((2 * x) / innerWidth - 1, 1 - (2 * y) / innerHeight);
  ray.setFromCamera(place, viewer.camera);
  const [hit] = ray.intersectObjects(objectsToPick(), true);
  if (!hit) return null;
  if (hit.object.isPoints) return nodeText(hit.index);
  let object = hit.object;
  while (object && !named.has(object)) object = object.parent;
  return object ? named.get(object) : null;
}

function showTip(event) {
  const name = event.buttons ? null : nameAt(event.clientX, event.clientY);
  const tip = element("tip");
  tip.hidden = name === null;
  tip.textContent = name || "";
  const right = event.clientX + 14 + tip.offsetWidth > innerWidth;
  tip.style.left = `${event.clientX + (right ? -14 - tip.offsetWidth : 14)}px`;
  tip.style.top = `${Math.min(event.clientY + 12, innerHeight - tip.offsetHeight - 4)}px`;
}

// Moving obstacles are last in the list.
function obstaclePath(k) {
  const standing = data.obstacles.length - data.moving.length;
  return k < standing ? `obstacles/${k}` : `moving/${k - standing}/shape`;
}

function markObstacle(k, button) {
  const glow = (index, colour) => drawn(obstaclePath(index)).material.emissive.setHex(colour);
  if (marked !== null) {
    glow(marked.k, 0);
    marked.button.setAttribute("aria-pressed", "false");
  }
  marked = marked && marked.k === k ? null : { k, button };
  if (marked) {
    glow(k, 0xc86400);
    button.setAttribute("aria-pressed", "true");
  }
  root.dataset.marked = marked ? data.obstacles[k] : "";
  viewer.set_dirty();
}

function listObstacles() {
  element("obstacle-section").hidden = !data.obstacles.length;
  element("obstacle-section").querySelector("summary").textContent = `obstacles (${data.obstacles.length})`;
  data.obstacles.forEach((name, k) => {
    const item = document.createElement("li");
    const button = document.createElement("button");
    const colour = swatch("");
    colour.style.background = `#${drawn(obstaclePath(k)).material.color.getHexString()}`;
    button.append(colour, name);
    button.setAttribute("aria-pressed", "false");
    button.onclick = () => markObstacle(k, button);
    item.append(button);
    element("obstacles").append(item);
  });
}

function startPointer() {
  for (const [path, name] of Object.entries(data.names)) named.set(group(path), name);
  let waiting = null;
  const stage = element("viewer");
  stage.addEventListener("pointermove", (event) => {
    if (!waiting) requestAnimationFrame(() => { showTip(waiting); waiting = null; });
    waiting = event;
  });
  stage.addEventListener("pointerleave", () => { element("tip").hidden = true; });
  listObstacles();
}
