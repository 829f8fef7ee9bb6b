// All paths in the plane of their two costs, and a second path beside the one that is shown, with a robot of its own.

const COLOURS = { shown: 0xd9401a, other: 0x1565c0 };
let compared = null; // number of the second path

const otherPath = () => (compared === null || compared === current ? null : data.paths[compared]);
const optimal = () => data.paths.filter((path) => path.interval).length; // these come first

function pathName(k) {
  const { interval } = data.paths[k]; // null where there is one path and no trade-off
  return interval ? `path ${k + 1}, β ${betas(interval)}` : `path ${k + 1}`;
}

// the plane of the costs

const FRAME = { left: 40, right: 282, top: 8, bottom: 96 };

function costScale(index, from, to) {
  const values = data.paths.map((path) => path.costs[index]);
  const low = Math.min(...values), high = Math.max(...values), room = 0.08 * (high - low) || 0.1;
  return { low, high, at: (value) => from + ((value - low + room) / (high - low + 2 * room)) * (to - from) };
}

function words(x, y, text, anchor) {
  return vector("text", { x, y, "text-anchor": anchor }, text);
}

function drawCosts() {
  const x = costScale(0, FRAME.left, FRAME.right), y = costScale(1, FRAME.bottom, FRAME.top);
  const { left, right, top, bottom } = FRAME;
  const axes = vector("path", { class: "axis", d: `M${left} ${top}V${bottom}H${right}` });
  const numbers = [words(x.at(x.low), bottom + 11, x.low.toFixed(2), "middle"), words(left - 4, y.at(y.low) + 3, y.low.toFixed(2), "end"),
    words((left + right) / 2, bottom + 11, "manipulability cost Ω", "middle")];
  if (x.high > x.low) numbers.push(words(x.at(x.high), bottom + 11, x.high.toFixed(2), "middle"));
  if (y.high > y.low) numbers.push(words(left - 4, y.at(y.high) + 3, y.high.toFixed(2), "end"));
  const side = words(0, 0, "distance D", "middle");
  side.setAttribute("transform", `translate(9 ${(top + bottom) / 2}) rotate(-90)`);
  const marks = data.paths.map((path, k) => costMark(k, x.at(path.costs[0]), y.at(path.costs[1])));
  element("costs").replaceChildren(axes, side, ...numbers, ...marks);
}

// A dot for a path; it is a button.
function costMark(k, x, y) {
  const mark = vector("g", { class: "dot", transform: `translate(${x} ${y})`, tabindex: 0, role: "button",
    "aria-label": pathName(k) });
  mark.append(vector("circle", { class: "touch", r: 9 }), vector("title", {}, pathName(k)));
  mark.append(vector("circle", { r: 4 }));
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

function choosePath(k) {
  if (data.paths[k].interval) toInterval(k);
  else showPath(k);
}

// the second robot

const ghost = new THREE.Group();
ghost.visible = false;
viewer.scene.add(ghost);

// Copies of the links as they are seen, in one colour; the base stands where it stands.
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
  element("choice").hidden = data.paths.length < 2;
  if (element("choice").hidden) return;
  drawCosts();
  data.paths.forEach((_, k) => element("compare").append(new Option(pathName(k), k)));
  element("compare").onchange = () => compareWith(element("compare").value === "" ? null : Number(element("compare").value));
}
