// The motion in time: how fast each joint moves and accelerates, as shares of its limits, and the clearance, in one
// chart each above the curve of w; where the pointer is over them, the robot is shown at that moment.

const JOINT_COLOURS = ["#1f5fbf", "#d9401a", "#1a8f4a", "#7a1fa2", "#b8860b", "#0f9aa8", "#c2185b", "#555555"];

// Of a motion in time the moment, of a path the share of the way.
const moment = (path, part) => (path.motion ? `${(part * path.motion.duration).toFixed(2)} s` : percent(part));

// From low to high on a scale of its own, where that is not even; `ticks` are the levels that are named.
function chart(title, low, high, series, colours, levels, { scaled = (value) => value, ticks = [] } = {}) {
  const place = (value) => (100 * (scaled(high) - scaled(value))) / (scaled(high) - scaled(low));
  const line = (values) => "M" + values.map((value, k) => `${((1000 * k) / (values.length - 1)).toFixed(1)} ${place(value).toFixed(2)}`).join("L");
  const drawn = series.map((values, k) => vector("path", { class: "way", style: `stroke:${colours[k % colours.length]}`, d: line(values) }));
  const grid = vector("path", { class: "level", d: levels.map((level) => `M0 ${place(level)}H1000`).join("") });
  const frame = vector("svg", { viewBox: "0 0 1000 100", preserveAspectRatio: "none" }, grid, ...drawn, vector("path", { class: "here", d: "" }));
  const plot = document.createElement("div"), name = document.createElement("span");
  name.textContent = title;
  name.className = "name";
  plot.append(name, frame, ...ticks.map((value) => label(`${1000 * value}`, place(value), "top", "tick")));
  return plot;
}

// Millimetres matter where little is left: 1 mm of 133 is a seventh of the height.
function clearanceChart(clearance) {
  const most = Math.max(...clearance, 1e-3), ticks = [1e-3, 1e-2, 1e-1, 1].filter((level) => level <= most);
  const plot = chart("clearance, mm", 0, most, [clearance], ["#33528c"], [0, ...ticks], { scaled: (c) => Math.log1p(c / 1e-3), ticks });
  plot.className = "clearance";
  return plot;
}

// Positions as shares of what lies between the limits, joint by joint.
function positionsWithinLimits(path) {
  return data.joints.names.map((_, j) => {
    const [low, high] = jointSpan(j);
    return path.waypoints.map((q) => (q[j] - low) / (high - low));
  });
}

function drawMotion(path) {
  const motion = path.motion;
  element("plots-switch").hidden = element("speed").hidden = !motion;
  element("plots").hidden = !motion || root.dataset.plots !== "true";
  element("plots").replaceChildren();
  if (!motion) return;
  const plots = [
    chart("position within limits", 0, 1, positionsWithinLimits(path), JOINT_COLOURS, [0, 0.5, 1]),
    chart("velocity / limit", -1, 1, motion.velocity, JOINT_COLOURS, [-1, 0, 1]),
    chart("acceleration / limit", -1, 1, motion.acceleration, JOINT_COLOURS, [-1, 0, 1]),
  ];
  if (motion.clearance) plots.push(clearanceChart(motion.clearance));
  element("plots").append(...plots);
}

// The panel ends above the player, which grows by the plots.
function makeRoom() {
  root.style.setProperty("--plots", `${element("plots").offsetHeight}px`);
}

function markMoment() {
  for (const line of element("plots").querySelectorAll(".here")) line.setAttribute("d", `M${1000 * share} 0V100`);
}

function showPlots(on) {
  root.dataset.plots = String(on);
  element("plots-switch").setAttribute("aria-pressed", String(on));
  drawMotion(shownPath());
  makeRoom();
  markMoment();
  centreView();
}

function startMotion() {
  root.dataset.plots = String(!narrow() && innerHeight > 850);
  element("plots-switch").setAttribute("aria-pressed", root.dataset.plots);
  element("plots-switch").onclick = () => showPlots(root.dataset.plots !== "true");
  element("plots").onpointermove = (event) => {
    const frame = element("plots").querySelector("svg");
    if (playing || !frame) return;
    const box = frame.getBoundingClientRect();
    goTo((event.clientX - box.left) / box.width);
  };
}

const speed = () => Number(element("speed").value);
