// Curves over time, or along a path without times, each with its unit and its nearest limit. The robot and the values in
// the legends follow the pointer.

const JOINT_COLOURS = ["#3b7dd8", "#e0582f", "#2ca25f", "#a35fc0", "#c9952b", "#17a2b8", "#d9467c", "#8a8f98"];
const EVEN = Array.from({ length: 241 }, (_, k) => k / 240); // shares of the way
const HEIGHT = 120, LEFT = 44, TOP = 20, LINE = 13; // px: the frame, its left and top margins, a line of the legend
const MOST = 1e5; // largest condition number in the plot
const hiddenJoints = new Set();

// The time in a motion, or the share of a path.
const moment = (path, part) => (path.motion ? `${(part * path.motion.duration).toFixed(2)} s` : percent(part));
const colour = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim();
const brief = (value) => (Number.isFinite(value) ? String(Number(value.toPrecision(3))).replace("-", "−") : "∞");

// The joints' names without their common prefix.
const jointNames = (() => {
  const names = data.joints.names, [first] = names;
  let same = names.length > 1 ? [...first].findIndex((c, k) => names.some((name) => name[k] !== c)) : 0;
  same = first.lastIndexOf("_", same) + 1;
  return names.map((name) => (/^\d*$/.test(name.slice(same)) ? `joint ${name.slice(same)}` : name.slice(same)));
})();

// The plots of a path: rows of values at even shares, and the limits of each row (null for none).
function plotsOf(path) {
  const { motion, clearance } = path, q = EVEN.map((share) => configurationAt(path, share)), { joints } = data;
  const [unit, none] = [[...new Set(joints.unit)].join(", "), [null, null]];
  const plots = [{ key: "w", title: "manipulability w", unit: data.unit, rows: [path.w], limits: [[data.floor || null, null]], zero: true }];
  if (path.condition) plots.push({ key: "condition", title: "condition number", unit: "", rows: [path.condition], wide: true });
  if (clearance) plots.push({ key: "clearance", title: "clearance", unit: "mm", rows: [clearance.map((c) => 1000 * c)], zero: true });
  const between = joints.names.map((_, j) => (joints.free[j] ? none : [joints.lower[j], joints.upper[j]]));
  plots.push({ key: "q", title: "joint positions q", unit, rows: joints.names.map((_, j) => q.map((values) => values[j])), limits: between });
  const kinds = [["velocity", "q′", "/s"], ["acceleration", "q″", "/s²"], ["jerk", "q‴", "/s³"]];
  for (const [key, letter, per] of motion ? kinds : []) {
    const limits = joints.names.map((_, j) => (motion.limits ? [-motion.limits[key][j], motion.limits[key][j]] : none));
    plots.push({ key, title: `joint ${key} ${letter}`, unit: unit.replace(/\w+/g, `$&${per}`), rows: motion[key], limits });
  }
  if (motion) plots.push({ key: "tool_speed", title: "tool speed", unit: "m/s", rows: [motion.tool_speed], limits: [[null, data.tool_speed]], zero: true });
  return plots.map((plot) => ({ limits: [none], ...plot, names: plot.rows.length > 1 || plot.key === "q" ? jointNames : [plot.title] }));
}

// The nearest limit of a visible row, relative to its range.
function activeLimit(plot, visible) {
  const candidates = visible.flatMap((k) => plot.limits[k].map((limit, side) => {
    if (limit === null) return null;
    const gap = side ? limit - Math.max(...plot.rows[k]) : Math.min(...plot.rows[k]) - limit;
    return { k, limit, slack: gap / (plot.limits[k][1] - plot.limits[k][0] || 1) };
  })).filter(Boolean);
  return candidates.reduce((best, each) => (!best || each.slack < best.slack ? each : best), null);
}

// About four round values in a range with their labels; powers of ten on a logarithmic scale.
function ticksBetween(low, high, log) {
  const step = log ? 1 : niceStep((high - low) / 1.6), first = Math.ceil(low / step);
  const values = Array.from({ length: Math.floor(high / step) - first + 1 }, (_, k) => (first + k) * step);
  return values.map((value) => [value, log ? brief(10 ** value) : tick(value, step).replace("-", "−")]);
}

function drawPlot(path, plot, other, width) {
  const right = width - 8, bottom = TOP + HEIGHT, many = plot.names.length > 1;
  const visible = plot.rows.map((_, k) => k).filter((k) => !(many && hiddenJoints.has(k)));
  const active = activeLimit(plot, visible), second = other && plotsOf(other).find(({ key }) => key === plot.key);
  const raw = visible.flatMap((k) => [...plot.rows[k], ...(second ? second.rows[k] : [])]).map((value) => value ?? Infinity);
  const log = plot.wide && Math.max(...raw) > 10 * Math.min(...raw), cut = log && Math.max(...raw) > MOST;
  const scaled = (value) => (log ? Math.log10(Math.min(value ?? MOST, MOST)) : value), values = raw.map((value) => scaled(value));
  if (active) values.push(active.limit);
  if (plot.zero) values.push(0);
  let low = values.length ? Math.min(...values) : 0, high = values.length ? Math.max(...values) : 1;
  const pad = 0.1 * (high - low) || 0.1 * Math.abs(high) || 0.1; // keeps curves off the frame
  [low, high] = [low - pad, high + pad];
  const x = (part) => LEFT + part * (right - LEFT), y = (value) => bottom - (HEIGHT * (value - low)) / (high - low);
  const line = (row) => "M" + row.map((value, k) => `${x(k / (row.length - 1)).toFixed(1)} ${y(scaled(value)).toFixed(1)}`).join("L");
  const stroke = (d, ink, more = {}) => vector("path", { d, fill: "none", stroke: ink, "stroke-width": 1.4, ...more });
  const text = (at, height, words, more = {}) => vector("text", { x: at, y: height, fill: colour("soft"), ...more }, words);
  const colourOf = (k) => (many ? JOINT_COLOURS[k % JOINT_COLOURS.length] : colour("curve"));
  const title = `${plot.title}${plot.unit && `, ${plot.unit}`}${cut ? `, cut at ${MOST}` : ""}`;
  const pieces = [text(0, 12, title, { "font-size": 12, fill: colour("ink") })];
  for (const [value, words] of ticksBetween(low, high, log)) {
    pieces.push(stroke(`M${LEFT} ${y(value)}H${right}`, colour("line"), { "stroke-width": 1 }));
    pieces.push(text(LEFT - 5, y(value) + 3.5, words, { "text-anchor": "end" }));
  }
  pieces.push(vector("rect", { x: LEFT, y: TOP, width: right - LEFT, height: HEIGHT, fill: "none", stroke: colour("frame") }));
  for (const part of [0, 0.5, 1]) pieces.push(text(x(part), bottom + 12, moment(path, part), { "text-anchor": ["start", "middle", "end"][2 * part] }));
  for (const k of second ? visible : []) pieces.push(stroke(line(second.rows[k]), many ? colourOf(k) : colour("other"), { "stroke-dasharray": "4 3" }));
  for (const k of visible) pieces.push(stroke(line(plot.rows[k]), colourOf(k), { class: "way" }));
  pieces.push(stroke("", colour("shown"), { class: "here" }));
  const longest = Math.max(...plot.names.map((name) => name.length)) + 7; // characters of a name and a value
  const columns = many ? Math.min(4, Math.max(1, Math.floor((right - LEFT) / (16 + 5.4 * longest)))) : 2, last = plot.names.length - 1;
  const placeOf = (k) => ({ left: LEFT + ((right - LEFT) / columns) * (k % columns), top: bottom + 26 + LINE * Math.floor(k / columns) });
  const wide = active && (last + 1) % columns > columns - 2 ? last + 1 + columns - ((last + 1) % columns) : last + 1; // two columns wide
  const height = placeOf(active ? wide : last).top + 8;
  if (active) {
    const { left, top } = placeOf(wide), words = `limit ${many ? `${plot.names[active.k]} ` : ""}${brief(active.limit)}`;
    pieces.push(stroke(`M${LEFT} ${y(active.limit)}H${right}`, colour("bad"), { class: "limit", "stroke-dasharray": "6 4" }));
    pieces.push(stroke(`M${left} ${top - 3.5}h10`, colour("bad"), { "stroke-dasharray": "4 2" }), text(left + 14, top, words, { fill: colour("bad") }));
  }
  plot.names.forEach((_, k) => {
    const at = placeOf(k);
    const entry = vector("g", { class: "entry", opacity: visible.includes(k) ? 1 : 0.4 });
    entry.append(stroke(`M${at.left} ${at.top - 3.5}h10`, colourOf(k), { "stroke-width": 3 }), text(at.left + 14, at.top, ""));
    if (many) {
      entry.onclick = () => { hiddenJoints[hiddenJoints.has(k) ? "delete" : "add"](k); drawPlots(path, other); };
      entry.append(vector("title", {}, `${data.joints.names[k]}: show or hide`));
    }
    pieces.push(entry);
  });
  plot.least = log ? 0 : 1e-3 * (high - low); // smaller values are 0 in a legend
  const size = { width, height, viewBox: `0 0 ${width} ${height}`, "font-family": "system-ui, sans-serif", "font-size": 10 };
  return vector("svg", { ...size, role: "img", "aria-label": plot.title }, ...pieces);
}

function drawPlots(path, other) {
  const panel = element("plots");
  panel.hidden = root.dataset.plots !== "true" || path.waypoints.length < 2;
  panel.replaceChildren();
  if (panel.hidden) return;
  if (other) panel.append(Object.assign(document.createElement("p"), { textContent: `dashed: ${pathName(data.paths.indexOf(other))}, at the same shares of its path` }));
  for (const plot of plotsOf(path)) {
    const frame = document.createElement("div"), svg = drawPlot(path, plot, other, panel.clientWidth - 28);
    const png = Object.assign(document.createElement("button"), { textContent: "PNG", onclick: () => savePicture(plot.key, svg) });
    const csv = Object.assign(document.createElement("button"), { textContent: "CSV", onclick: () => save(`${plot.key}.csv`, csvOf(path, plot), "text/csv") });
    frame.append(png, csv, svg);
    frame.plot = plot;
    panel.append(frame);
  }
  markMoment();
}

// The line at the current moment, and the values in each legend.
function markMoment() {
  for (const { plot, lastChild } of element("plots").querySelectorAll("div")) {
    const at = LEFT + share * (lastChild.viewBox.baseVal.width - 8 - LEFT), single = plot.names.length === 1;
    lastChild.querySelector(".here").setAttribute("d", `M${at.toFixed(1)} ${TOP}v${HEIGHT}`);
    lastChild.querySelectorAll(".entry text").forEach((words, k) => {
      let value = sampleAt(plot.rows[k].map((each) => each ?? Infinity), share);
      if (Math.abs(value) < plot.least) value = 0;
      words.textContent = single ? `${brief(value)} ${plot.unit} at ${moment(shownPath(), share)}` : `${plot.names[k]} ${brief(value)}`;
    });
  }
}

// files

function save(name, content, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.download = `${data.robot}-${data.scene}-${name}`.replace(/[^\w.-]+/g, "_");
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function csvOf(path, plot) {
  const last = plot.rows[0].length - 1, names = plot.names.length > 1 ? data.joints.names : [plot.key];
  const head = [path.motion ? "t (s)" : "share of the way", ...names.map((name) => (plot.unit ? `${name} (${plot.unit})` : name))];
  const lines = plot.rows[0].map((_, k) => [(k / last) * (path.motion ? path.motion.duration : 1), ...plot.rows.map((row) => row[k] ?? "inf")]);
  return [head, ...lines].map((cells) => cells.join(",")).join("\n") + "\n";
}

// Twice the screen's resolution, on the panel's colour.
async function savePicture(key, svg) {
  const { width, height } = svg.viewBox.baseVal, picture = new Image(), canvas = document.createElement("canvas");
  picture.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(new XMLSerializer().serializeToString(svg))}`;
  await picture.decode();
  [canvas.width, canvas.height] = [2 * width, 2 * height];
  const pen = canvas.getContext("2d");
  pen.fillStyle = colour("page");
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.drawImage(picture, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((content) => save(`${key}.png`, content, "image/png"));
}

function showPlots(on) {
  root.dataset.plots = String(on);
  element("plots-switch").setAttribute("aria-pressed", String(on));
  drawPlots(shownPath(), otherPath());
  fitAgain();
}

function startPlots() {
  root.dataset.plots = String(innerWidth >= 1200);
  element("plots-switch").setAttribute("aria-pressed", root.dataset.plots);
  element("plots-switch").onclick = () => showPlots(root.dataset.plots !== "true");
  element("speed").hidden = !shownPath().motion;
  element("plots").onpointermove = (event) => {
    const frame = event.target.closest("svg");
    if (playing || !frame) return;
    const box = frame.getBoundingClientRect();
    goTo((event.clientX - box.left - LEFT) / (box.width - 8 - LEFT));
  };
}

const speed = () => Number(element("speed").value);
