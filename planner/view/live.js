// The live page: obstacles and the goal are dragged or set by numbers, the start by sliders. What is let go goes to the
// planner, one request after the other; its answer is the new path, or the sentence why not, and then all stands as it did.

let live = data.live; // what the planner has
let chosen = 0; // what is moved: 0 the goal, k the obstacle k - 1
let dragged = null; // while something is dragged
let waiting = Promise.resolve();

const FIELDS = ["x", "y", "z", "roll", "pitch", "yaw"];
const FROM_Y = new THREE.Matrix4().makeRotationX(Math.PI / 2); // three.js cylinders lie on y
const RED = 0xe61f1f;
const ownColours = new Map(); // of links and obstacles, by their path

// what can be moved

function poseOf(k) {
  const { position, quaternion } = k ? live.obstacles[k - 1] : { position: live.goal, quaternion: [0, 0, 0, 1] };
  return { position: new THREE.Vector3(...position), quaternion: new THREE.Quaternion(...quaternion) };
}

function place(k, pose) {
  if (k === 0) {
    const delta = pose.position.clone().sub(new THREE.Vector3(...live.goal));
    viewer.set_transform(["meshcat", "goal"], new THREE.Matrix4().makeTranslation(delta.x, delta.y, delta.z).toArray());
    return;
  }
  const matrix = new THREE.Matrix4().compose(pose.position, pose.quaternion, new THREE.Vector3(1, 1, 1));
  if (live.obstacles[k - 1].upright) matrix.multiply(FROM_Y);
  viewer.set_transform(["meshcat", "obstacles", String(k - 1)], matrix.toArray());
}

function fillFields(pose) {
  const turn = new THREE.Euler().setFromQuaternion(pose.quaternion, "ZYX");
  const values = [...pose.position.toArray(), turn.x, turn.y, turn.z];
  FIELDS.forEach((name, i) => {
    const field = element(`live-${name}`);
    field.value = Number(values[i].toFixed(4));
    field.parentElement.hidden = i > 2 && chosen === 0;
  });
}

function poseOfFields() {
  const [x, y, z, roll, pitch, yaw] = FIELDS.map((name) => element(`live-${name}`).valueAsNumber);
  return { position: new THREE.Vector3(x, y, z), quaternion: new THREE.Quaternion().setFromEuler(new THREE.Euler(roll, pitch, yaw, "ZYX")) };
}

function showPose(k, pose) {
  place(k, pose);
  if (k !== chosen) return;
  fillFields(pose);
  showGizmo(pose.position.toArray(), k > 0);
}

function choose(k) {
  chosen = k;
  element("live-target").value = String(k);
  root.dataset.chosen = k ? live.obstacles[k - 1].name : "goal";
  showPose(k, poseOf(k));
}

function commit(k, pose) {
  const position = pose.position.toArray();
  if (![...position, ...pose.quaternion.toArray()].every(Number.isFinite)) return refuse({ error: "Give numbers in every field.", red: [] });
  send(k ? { do: "move", name: live.obstacles[k - 1].name, position, quaternion: pose.quaternion.toArray() } : { do: "goal", position });
}

// dragging

function hitOf(event) {
  const pointer = pointerRay(event);
  const hit = (parts) => ray.intersectObjects(parts.filter((part) => part.parent.visible), false);
  const [onGrip] = hit(grips), onHandle = hit(handles).length > 0;
  const things = [group("goal"), ...live.obstacles.map((_, k) => group(`obstacles/${k}`))];
  const links = objectsToPick().filter((object) => named.has(object)); // what stands behind the robot is not meant
  const [onThing] = ray.intersectObjects([...new Set([...things, ...links])], true);
  let object = onThing?.object;
  while (object && !things.includes(object)) object = object.parent;
  // what is seen under the pointer: a handle as it is drawn, in front of all, then another thing, then a handle's margin
  if (onGrip && (onHandle || !object || things.indexOf(object) === chosen)) return { k: chosen, kind: onGrip.object.userData.kind, pointer };
  if (!object) return null;
  return { k: things.indexOf(object), kind: "free", pointer, place: viewer.scene.worldToLocal(onThing.point.clone()) };
}

function startDrag(event) {
  if (event.button !== 0 || !event.isPrimary || event.target.tagName !== "CANVAS") return;
  const hit = hitOf(event);
  if (!hit) return;
  event.stopPropagation(); // the view stays
  choose(hit.k);
  dragged = { k: hit.k, pose: poseOf(hit.k), to: dragOf(hit.kind, poseOf(hit.k), hit.pointer, hit.place), moved: false };
  element("viewer").setPointerCapture(event.pointerId);
}

function drag(event) {
  if (!dragged) return;
  event.stopPropagation();
  dragged.pose = dragged.to(pointerRay(event));
  dragged.moved = true;
  showPose(dragged.k, dragged.pose);
}

function endDrag(event) {
  if (!dragged) return;
  event.stopPropagation();
  const { k, pose, moved } = dragged;
  dragged = null;
  if (event.type === "pointercancel") showPose(k, poseOf(k));
  else if (moved) commit(k, pose);
}

function startDragging() {
  const stage = element("viewer");
  stage.addEventListener("pointerdown", startDrag, true);
  stage.addEventListener("pointermove", drag, true);
  for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, endDrag, true);
  for (const touch of ["touchstart", "touchmove"]) {
    stage.addEventListener(touch, (event) => { if (dragged) event.stopPropagation(); }, true);
  }
}

// asking the planner

function send(order) {
  waiting = waiting.then(() => ask(order)).catch((error) => {
    tell(`The planner does not answer (${error.message}): start 'planner view --live' again.`, true);
    root.dataset.busy = "false";
  });
}

async function post(order) {
  const headers = { "Content-Type": "application/json", "X-Planner-Token": live.fixed.token };
  const answer = await fetch("/act", { method: "POST", headers, body: JSON.stringify({ order }) });
  if (!answer.ok) throw new Error(await answer.text());
  return answer.json();
}

// Of a move the page first says whether the path that is shown still holds, which takes a moment; planning may take more.
async function look(order) {
  const { holds, error } = await post({ ...order, do: "look" });
  if (error || data.paths[0].waypoints.length < 2) return; // the move itself is refused with this sentence
  tell(holds ? "The path shown holds in the new place; looking for the best one." : "The path shown is blocked now; looking for another one.", !holds);
  root.dataset.holds = String(holds);
}

async function ask(order) {
  const began = performance.now();
  root.dataset.busy = "true";
  if (order.do === "move") await look(order);
  const result = await post(order);
  if (result.live && result.live.drawn !== live.drawn) location.reload(); // other objects than those drawn here
  else if (result.error) refuse(result);
  else if (result.saved) element("live-said").textContent = result.saved;
  else await update(result, began);
  root.dataset.busy = "false";
}

function tell(sentence, wrong) {
  element("message").textContent = sentence;
  element("message").classList.toggle("wrong", wrong);
}

// Everything back to where the planner has it; what is to blame is red.
function refuse({ error, red }) {
  tell(error, true);
  paintRed(red);
  placeAll();
  root.dataset.refused = String(Number(root.dataset.refused || 0) + 1);
}

async function update(result, began) {
  Object.assign(data, result.data, { lengths: result.lengths });
  live = data.live = { ...live, ...result.live };
  stop();
  share = 0;
  await replay(result.scene);
  element("tip").hidden = true; // it speaks of what was there
  roundDots();
  showPath(data.current);
  colourRoadmap(shownPath());
  showAnswer();
  const milliseconds = performance.now() - began;
  const parts = Object.entries(live.seconds).map(([part, seconds]) => `${part} ${seconds.toFixed(2)} s`);
  element("live-said").textContent = `${live.what}: ${(milliseconds / 1000).toFixed(2)} s to the new picture (${parts.join(", ")})`;
  root.dataset.milliseconds = milliseconds.toFixed(0);
  root.dataset.answers = String(Number(root.dataset.answers || 0) + 1);
}

function showAnswer() {
  tell(data.message, data.blamed !== null);
  element("player").hidden = !data.paths.some((path) => path.waypoints.length > 1);
  element("undo").disabled = live.undo === 0;
  for (const value of ["before", "change"]) element("colour").querySelector(`[value=${value}]`).disabled = !live.before;
  fillTable(element("live-report"), live.report);
  element("live-beta").value = data.beta;
  element("live-beta-now").textContent = data.beta.toFixed(2);
  paintRed(live.red);
  placeAll();
}

function placeAll() {
  live.obstacles.forEach((_, k) => place(k + 1, poseOf(k + 1)));
  place(0, poseOf(0));
  choose(Math.min(chosen, live.obstacles.length));
  live.start.forEach((value, j) => setSlider(j, value));
  goTo(share);
}

function paintRed(names) {
  for (const [path, name] of Object.entries(data.names)) {
    const colour = drawn(path).material.color;
    if (!ownColours.has(path)) ownColours.set(path, colour.getHex());
    colour.setHex(names.includes(name) ? RED : ownColours.get(path));
  }
  root.dataset.red = names.join(";");
  viewer.set_dirty();
}

// the start

function setSlider(j, value) {
  const slider = element("live-start").children[j].querySelector("input");
  slider.value = value;
  slider.nextElementSibling.textContent = `${short2(value)} ${data.joints.unit[j]}`;
}

const sliders = () => [...element("live-start").querySelectorAll("input")].map((slider) => slider.valueAsNumber);

function makeSliders() {
  data.joints.names.forEach((name, j) => {
    const [low, high] = data.joints.free[j] ? [-Math.PI, Math.PI] : [data.joints.lower[j], data.joints.upper[j]];
    const row = document.createElement("label"), title = document.createElement("span"), slider = document.createElement("input");
    title.textContent = title.title = name;
    Object.assign(slider, { type: "range", min: low, max: high, step: "any" });
    slider.oninput = () => {
      setSlider(j, slider.valueAsNumber);
      placeLinks(sliders());
    };
    slider.onchange = () => send({ do: "start", joints: sliders() });
    row.append(title, slider, document.createElement("output"));
    element("live-start").append(row);
  });
}

// the controls

function makeFields() {
  FIELDS.forEach((name, i) => {
    const label = document.createElement("label"), field = document.createElement("input");
    Object.assign(field, { type: "number", step: i < 3 ? 0.01 : 0.05, id: `live-${name}`, title: i < 3 ? "m" : "rad" });
    field.onchange = () => commit(chosen, poseOfFields());
    label.append(name, field);
    element("live-fields").append(label);
  });
}

function startLive() {
  element("live-target").append(new Option("goal", "0"), ...live.obstacles.map(({ name }, k) => new Option(name, k + 1)));
  element("live-target").onchange = () => choose(Number(element("live-target").value));
  for (const [value, text] of [["before", "cost-to-go before the change"], ["change", "change of the cost-to-go"]]) {
    element("colour").append(new Option(text, value));
  }
  makeGizmo();
  makeFields();
  makeSliders();
  startDragging();
  for (const order of ["undo", "save", "reload"]) element(order).onclick = () => send({ do: order });
  element("save").title = `to ${live.fixed.file}`;
  element("live-beta").oninput = () => { element("live-beta-now").textContent = element("live-beta").valueAsNumber.toFixed(2); };
  element("live-beta").onchange = () => send({ do: "beta", beta: element("live-beta").valueAsNumber });
  document.addEventListener("keydown", (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key === "z" && live.undo) {
      event.preventDefault();
      send({ do: "undo" });
    }
  });
  chosen = live.obstacles.length ? 1 : 0;
  showAnswer();
}
