// Replays the recorded scene into meshcat's viewer, then drives it by the page's controls.
// The root's data-ready attribute marks a complete page.

const STEP = 0.01; // share of the path per arrow key
let current = 0; // number of the shown path
let share = 0; // of its joint motion
let playing = false;

const shownPath = () => data.paths[current];
const short = (w) => (w === 0 ? "0" : w >= 5e-4 ? w.toFixed(4) : w.toExponential(1));
const percent = (part) => `${Math.round(100 * part)} %`;

// The scene is a sequence of MessagePack commands; the viewer decodes one at a time.
async function replay(scene) {
  const bytes = await unpack(scene);
  let at = 0;
  for (const length of data.lengths) {
    viewer.handle_command_bytearray(bytes.slice(at, at + length));
    at += length;
  }
}

// Lights fixed to the scene. Their sum is 1 on the brightest side, so that white is not overexposed.
function lightAll() {
  const lights = [new THREE.AmbientLight(0xffffff, 0.38)];
  for (const [strength, place] of [[0.58, [-0.5, -0.8, 1.3]], [0.2, [1, -0.1, 0.4]], [0.14, [0, 1, -0.3]]]) {
    const light = new THREE.DirectionalLight(0xffffff, strength);
    light.position.set(...place);
    lights.push(light);
  }
  viewer.scene.add(...lights);
}

const CELL = data.radius > 0.6 ? 0.5 : 0.1, CELLS = 2 * Math.ceil((1.6 * data.radius) / CELL); // m
const grid = new THREE.GridHelper(CELLS * CELL, CELLS, 0xa9b4c0, 0xc3cbd4);
grid.rotateX(Math.PI / 2);
grid.position.set(data.centre[0], data.centre[1], 0);
viewer.scene.add(grid);

function fold(folded) {
  root.dataset.folded = String(folded);
  element("body").hidden = folded;
  element("fold").textContent = folded ? "unfold" : "fold";
  element("fold").setAttribute("aria-expanded", String(!folded));
}

function fillTable(table, rows, wrong = []) {
  table.replaceChildren();
  for (const [name, value] of rows) {
    const row = table.insertRow();
    row.insertCell().textContent = name;
    row.insertCell().textContent = value;
    if (wrong.includes(name)) row.className = "wrong";
  }
}

function fillKey() {
  const entries = [["#26a640", "start"], ["#cc1a26", "goal"], ["#d9401a", "the tool's path"],
    ["#7a1fa2", "the two lowest local minima of w along the path"],
    ["#a7c4e6", `manipulability ellipsoid: tool velocities at joint velocities of norm 1 rad/s; ${scale} m drawn for 1 m/s`],
    ["#c3cbd4", `grid of ${CELL} m on the floor`]];
  if (data.touching.length) entries.unshift(["#e61f1f", "in contact"]);
  if (data.blamed === "separated") entries.unshift(["#e61f1f", "separates start from goal; the shortest blocked motion"]);
  if (data.blamed === "budget_spent") entries.unshift(["#e61f1f", "the shortest motion between the components, and its contact"]);
  if (data.blamed === "blocked_in_time") entries.unshift(["#e61f1f", "moving obstacle that blocks the way"]);
  if (data.moving.length) entries.push(["#b3bcc8", "path of a moving obstacle, drawn at the shown time"]);
  const useful = data.roadmap ? entries : entries.filter(([, text]) => /ellipsoid|grid|contact|moving/.test(text));
  for (const [colour, text] of useful) {
    const item = document.createElement("li"), words = document.createElement("span");
    words.textContent = text;
    item.append(swatch(colour), words);
    element("key").append(item);
  }
}

// The numbers of the path, and of the second one in another column.
function fillNumbers(path, other) {
  fillTable(element("numbers"), path.numbers, data.wrong);
  if (!other) return;
  const values = Object.fromEntries(other.numbers);
  [...element("numbers").rows].forEach((row, k) => { row.insertCell().textContent = values[path.numbers[k][0]] ?? ""; });
  const head = element("numbers").createTHead().insertRow();
  ["", "shown", "compared"].forEach((text) => { head.insertCell().textContent = text; });
}

// the worst points: labelled dots in the scene, and a line each in the panel

const dots = new THREE.Group();
viewer.scene.add(dots);

function markWorst(path, other) {
  dots.clear();
  element("marks").replaceChildren();
  element("worst-list").replaceChildren();
  element("worst").hidden = path.waypoints.length < 2;
  element("worst").querySelector("h2").textContent = `lowest manipulability of the ${path.motion ? "motion" : "path"}`;
  if (path.waypoints.length < 2) return;
  for (const point of path.worst) {
    const dot = new THREE.Mesh(new THREE.SphereGeometry(0.016 * data.marks, 20, 14), new THREE.MeshPhongMaterial({ color: 0x7a1fa2 }));
    dot.position.set(...point.position);
    dots.add(dot);
    const line = document.createElement("button"), mark = document.createElement("button");
    line.textContent = `w = ${short(point.w)} ${data.unit} at ${moment(path, point.share)}${path.motion ? "" : " of the way"}`;
    mark.textContent = `w ${short(point.w)}`;
    mark.className = "mark";
    for (const button of [line, mark]) {
      button.title = "go there";
      button.onclick = () => { stop(); goTo(point.share); };
    }
    element("worst-list").append(line);
    element("marks").append(mark);
  }
  if (other) element("worst-list").append(`compared path: at least ${short(other.worst[0].w)} ${data.unit}`);
}

function placeMarks() {
  const free = freeArea(), seen = dots.children.map((dot) => dot.getWorldPosition(new THREE.Vector3()).project(viewer.camera));
  const xs = seen.map((place) => ((place.x + 1) / 2) * innerWidth), first = xs.indexOf(Math.min(...xs));
  [...element("marks").children].forEach((mark, k) => {
    mark.style.left = `${xs[k]}px`;
    mark.style.top = `${((1 - seen[k].y) / 2) * innerHeight}px`;
    mark.hidden = seen[k].z > 1;
    // labels point away from each other if there is space
    const outward = k === first && xs.length > 1 && xs[k] > free.x + 90;
    mark.classList.toggle("left", outward || xs[k] > free.x + free.width - 90);
  });
}

// the player

function goTo(place) {
  share = Math.min(Math.max(place, 0), 1);
  const path = shownPath(), other = otherPath(), w = (each) => `w = ${short(sampleAt(each.w, share))} ${data.unit}`;
  placeRobot(path, share);
  placeMoving(path, share);
  placeGhost();
  placeJoints(configurationAt(path, share), share);
  element("scrub").value = 1000 * share;
  element("spark").querySelector(".here").setAttribute("d", `M${1000 * share} 0V100`);
  markMoment();
  element("now").textContent = `${w(path)} · ${moment(path, share)}`;
  element("now-other").textContent = other ? w(other) : "";
  root.dataset.share = share.toFixed(4);
  remember();
}

function stop() {
  playing = false;
  element("play").textContent = "Play";
  root.dataset.playing = "false";
  remember();
}

function play() {
  if (playing) return stop();
  if (share >= 1) goTo(0);
  playing = true;
  element("play").textContent = "Pause";
  root.dataset.playing = "true";
  let last = performance.now();
  const step = (now) => {
    if (!playing) return;
    goTo(share + (speed() * Math.max(0, now - last)) / (1000 * shownPath().seconds));
    last = now;
    if (share >= 1) stop();
    else requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

function onKey(event) {
  const tag = event.target.tagName;
  if (event.ctrlKey || event.altKey || event.metaKey || tag === "SELECT" || event.target.id === "beta") return;
  if (event.key === " " && tag !== "BUTTON" && tag !== "SUMMARY" && event.target.type !== "checkbox") play();
  else if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
    stop();
    goTo(share + (event.key === "ArrowLeft" ? -STEP : STEP));
  } else return;
  event.preventDefault();
}

function startPlayer() {
  element("player").hidden = !data.paths.some((path) => path.waypoints.length > 1);
  if (element("player").hidden) return;
  element("play").onclick = play;
  element("scrub").oninput = () => { stop(); goTo(element("scrub").value / 1000); };
  element("spark").onclick = (event) => {
    const box = element("spark").getBoundingClientRect();
    stop();
    goTo((event.clientX - box.left) / box.width);
  };
  document.addEventListener("keydown", onKey);
}

// the trade-off: one path per interval of beta

function showPath(k) {
  current = k;
  const path = shownPath(), other = otherPath();
  data.paths.forEach((each, number) => {
    if (each.waypoints.length < 2) return;
    show(`paths/${number}`, each === path || each === other);
    drawn(`paths/${number}`).material.color.setHex(each === other ? COLOURS.other : COLOURS.shown);
  });
  root.dataset.path = String(k);
  root.dataset.compared = other ? String(compared) : "";
  fillNumbers(path, other);
  markWorst(path, other);
  drawSummary(path, other);
  drawCurve(path, other);
  drawPlots(path, other);
  drawJoints(path, other);
  markCosts();
  if (element("colour").value === "cost" || !root.dataset.colour) colourRoadmap(path);
  goTo(share);
  [...element("strip").children].forEach((piece, number) => piece.classList.toggle("on", number === k));
  drawChoices();
  if (!path.interval) return; // one path and no trade-off
  element("which").textContent = `path ${k + 1} of ${optimal()}`;
  const [low, high] = path.interval;
  element("interval").textContent = low === high ? `one of several optimal paths at β = ${low}` : `optimal for β from ${betas(path.interval)}`;
}

// enough digits to distinguish two betas
function digits(beta, other) {
  const apart = Math.abs(beta - other);
  return String(Number(beta.toFixed(apart > 0 ? Math.min(12, Math.max(4, 2 - Math.floor(Math.log10(apart)))) : 4)));
}

const betas = ([low, high]) => `${digits(low, high)} to ${digits(high, low)}`;

function setBeta(beta) {
  element("beta").value = beta;
  element("beta-now").textContent = digits(beta, beta);
  root.dataset.beta = String(beta);
  remember();
}

function pathAt(beta) {
  const k = data.paths.findIndex((path) => path.interval && beta <= path.interval[1]);
  return k < 0 ? optimal() - 1 : k;
}

// The path of the slider's beta; the shown path may be one that is optimal for no beta.
const atBeta = () => (shownPath().interval ? current : pathAt(Number(element("beta").value)));

function toInterval(k) {
  const place = Math.min(Math.max(k, 0), optimal() - 1);
  const [low, high] = data.paths[place].interval;
  setBeta((low + high) / 2);
  showPath(place);
}

function onBetaKey(event) {
  const here = atBeta();
  const moves = { ArrowLeft: here - 1, ArrowDown: here - 1, ArrowRight: here + 1, ArrowUp: here + 1, Home: 0,
    End: optimal() - 1 };
  if (!(event.key in moves)) return;
  event.preventDefault();
  toInterval(moves[event.key]);
}

function startTradeoff() {
  element("tradeoff").hidden = !data.paths[0].interval;
  if (element("tradeoff").hidden) return;
  for (const path of data.paths.slice(0, optimal())) {
    const piece = document.createElement("i");
    piece.style.flexGrow = path.interval[1] - path.interval[0];
    element("strip").append(piece);
  }
  const slider = element("beta");
  slider.oninput = () => {
    const beta = Number(slider.value), k = pathAt(beta);
    setBeta(beta);
    if (k !== current) showPath(k);
  };
  slider.onchange = () => toInterval(atBeta()); // on release the slider snaps to the middle of its interval
  slider.onkeydown = onBetaKey;
  element("less").onclick = () => toInterval(atBeta() - 1);
  element("more").onclick = () => toInterval(atBeta() + 1);
  setBeta(data.beta);
}

function showCollision() {
  const on = element("collision").checked;
  for (const path of Object.keys(data.names)) {
    if (path.startsWith("robot/")) group(path).visible = path.includes("/collision/") === on;
  }
  viewer.set_dirty();
}

function startPanel() {
  element("message").textContent = data.message;
  fillTable(element("about"), data.about, data.wrong);
  element("about-section").hidden = !data.about.length;
  drawRounds();
  element("joints-section").open = !narrow();
  element("fold").onclick = () => {
    fold(root.dataset.folded !== "true");
    fitAgain();
  };
  element("file").onchange = compareWithFile;
  element("collision").onchange = showCollision;
  element("ellipsoid").onchange = () => {
    ellipsoid.visible = element("ellipsoid").checked;
    viewer.set_dirty();
  };
  showCollision();
}

async function main() {
  await replay(element("scene").textContent);
  const render = viewer.render;
  viewer.render = function () {
    render.call(viewer);
    placeMarks();
  };
  data.paths.forEach((path, k) => { if (path.waypoints.length > 1) drawWay(path, k); });
  lightAll();
  fold(narrow() || flat()); // leaves the robot visible on a phone
  startPanel();
  startPlayer();
  current = data.current;
  startPlots();
  startPointer();
  startRoadmap(shownPath);
  startTradeoff();
  startChoice();
  showPath(current);
  fillKey();
  lookAtAll();
  startSharing();
  window.addEventListener("resize", () => { drawPlots(shownPath(), otherPath()); fitAgain(); });
  requestAnimationFrame(() => requestAnimationFrame(() => { root.dataset.ready = "true"; }));
}

main().catch((error) => setTimeout(() => { throw error; })); // so that the error listener reports it
