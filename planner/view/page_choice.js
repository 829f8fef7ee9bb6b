// All paths in the plane of their two costs, and a second path with its own robot next to the shown one.

const COLOURS = { shown: 0xd9401a, other: 0x1565c0 };
let compared = null; // number of the second path

const otherPath = () => (compared === null || compared === current ? null : data.paths[compared]);
const optimal = () => data.paths.filter((path) => path.interval).length; // sorted first

function pathName(k) {
  const { interval, name } = data.paths[k]; // a single path has no interval
  if (name) return name;
  return interval ? `path ${k + 1}, β ${betas(interval)}` : `path ${k + 1}`;
}

// the plane of the costs

const FRAME = { left: 40, right: 282, top: 8, bottom: 96 };

const withCosts = () => data.paths.filter((path) => path.costs); // sorted before the path of a file
const tickOf = ({ low, high }, value) => value.toFixed(high > low ? Math.min(6, Math.max(2, 1 - Math.floor(Math.log10(high - low)))) : 2);

function costScale(index, from, to) {
  const values = withCosts().map((path) => path.costs[index]);
  const low = Math.min(...values), high = Math.max(...values), pad = 0.08 * (high - low) || 0.1;
  return { low, high, at: (value) => from + ((value - low + pad) / (high - low + 2 * pad)) * (to - from) };
}

function words(x, y, text, anchor) {
  return vector("text", { x, y, "text-anchor": anchor }, text);
}

function drawCosts() {
  const x = costScale(0, FRAME.left, FRAME.right), y = costScale(1, FRAME.bottom, FRAME.top);
  const { left, right, top, bottom } = FRAME;
  const axes = vector("path", { class: "axis", d: `M${left} ${top}V${bottom}H${right}` });
  const numbers = [words(x.at(x.low), bottom + 11, tickOf(x, x.low), "middle"), words(left - 4, y.at(y.low) + 3, tickOf(y, y.low), "end"),
    words((left + right) / 2, bottom + 11, "manipulability cost Ω", "middle")];
  if (x.high > x.low) numbers.push(words(x.at(x.high), bottom + 11, tickOf(x, x.high), "middle"));
  if (y.high > y.low) numbers.push(words(left - 4, y.at(y.high) + 3, tickOf(y, y.high), "end"));
  const side = words(0, 0, "distance D", "middle");
  side.setAttribute("transform", `translate(9 ${(top + bottom) / 2}) rotate(-90)`);
  const marks = withCosts().map((path, k) => costMark(k, x.at(path.costs[0]), y.at(path.costs[1])));
  element("costs").replaceChildren(axes, side, ...numbers, ...marks);
}

// A dot per path, as a button.
function costMark(k, x, y) {
  const mark = vector("g", { class: "dot", transform: `translate(${x} ${y})`, tabindex: 0, role: "button",
    "aria-label": pathName(k) });
  mark.append(vector("circle", { class: "touch", r: 9 }), vector("title", {}, pathName(k)));
  mark.append(vector("circle", { r: 4 }));
  if (data.paths[k].choice?.knee) mark.append(vector("circle", { class: "knee", r: 8 }), words(0, -11, "knee", "middle"));
  mark.onclick = () => choosePath(k);
  mark.onkeydown = (event) => { if (event.key === "Enter") choosePath(k); };
  return mark;
}

function markCosts() {
  element("costs").querySelectorAll("g").forEach((mark, k) => {
    mark.classList.toggle("on", k === current);
    mark.classList.toggle("other", k === compared && k !== current);
  });
}

// A row per path of a sweep: gain and price of its betas, and the sentence on the shown path.
function drawChoices() {
  const { choice } = shownPath(), share = (part) => (part === null ? "" : percent(part)), all = data.paths.map((path, k) => [path, k]);
  element("buys").textContent = !choice ? "" : choice.gain || choice.added_length
    ? `This path: ${choice.buys.split(": ")[1]}${choice.knee ? ". This is the knee: beyond it additional length gains less." : ""}`
    : choice.buys && "The shortest path, without a gain in w.";
  const rows = all.filter(([path]) => path.choice && path.interval).map(([path, k]) => {
    const { w_min: w, duration, clearance, gain, added_length: added, knee } = path.choice, none = "–", row = document.createElement("tr");
    const [low, high] = path.interval.map((beta) => String(Number(beta.toFixed(3))));
    const cells = [`${knee ? "◆ " : ""}${low === high ? betas(path.interval) : `${low} – ${high}`}`, short(w), duration === null ? none : duration.toFixed(2),
      clearance === null ? none : (1000 * clearance).toFixed(1), share(gain), share(added)];
    cells.forEach((text) => { row.insertCell().textContent = text; });
    row.className = [k === current ? "on" : "", knee ? "knee" : ""].join(" ");
    row.onclick = () => choosePath(k);
    return row;
  });
  element("choices").hidden = !rows.length;
  element("choices").tBodies[0].replaceChildren(...rows);
}

function choosePath(k) {
  if (data.paths[k].interval) toInterval(k);
  else showPath(k);
}

// the second robot

const ghost = new THREE.Group();
ghost.visible = false;
viewer.scene.add(ghost);

// Copies of the links in one colour; the base is shared.
function makeGhost() {
  const look = new THREE.MeshPhongMaterial({ color: COLOURS.other, opacity: 0.35, transparent: true, depthWrite: false });
  data.chain.parent.forEach((_, j) => {
    const copy = group(`robot/${j + 1}`).clone(true);
    copy.traverse((part) => {
      part.visible = part.name !== "collision";
      if (part.isMesh) part.material = look;
    });
    ghost.add(copy);
  });
}

function placeGhost() {
  const other = otherPath();
  ghost.visible = other !== null;
  if (!other) return;
  placements(configurationAt(other, share)).slice(1).forEach((frame, j) => {
    const copy = ghost.children[j];
    copy.matrix.fromArray(columns(frame.rotation, frame.position));
    copy.matrix.decompose(copy.position, copy.quaternion, copy.scale);
  });
}

function compareWith(k) {
  compared = k;
  if (k !== null && !ghost.children.length) makeGhost();
  showPath(current);
}

function startChoice() {
  element("choice").hidden = element("costs").toggleAttribute("hidden", data.paths.length < 2);
  if (data.paths.length > 1) drawCosts();
  data.paths.forEach((_, k) => element("compare").append(new Option(pathName(k), k)));
  element("compare").onchange = () => compareWith(element("compare").value === "" ? null : Number(element("compare").value));
}
