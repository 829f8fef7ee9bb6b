// The curve of w under the player, with its axes, the requested floor and the worst points.

let curveY = (w) => w; // from w to a height in the drawing, 0 (top) to 100

// One, two or five times a power of ten: two to five steps up to `high`.
function niceStep(high) {
  const raw = high / 2, decade = Math.pow(10, Math.floor(Math.log10(raw)));
  return decade * (raw >= 5 * decade ? 5 : raw >= 2 * decade ? 2 : 1);
}

// A value with as many digits as its step.
const tick = (value, step) => (step < 1e-4 ? value.toExponential(0) : value.toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9))));

function label(text, place, side, className = "") {
  const span = document.createElement("span");
  span.textContent = text;
  span.className = className;
  span.style[side] = `${place}%`;
  return span;
}

function drawHeights(high) {
  const step = niceStep(high), labels = [];
  for (let k = 0; k * step <= high * (1 + 1e-9); k++) labels.push(k * step);
  const last = labels.length - 1;
  const named = (w, k) => (k === last ? `w ${tick(w, step)} ${data.unit}` : tick(w, step));
  const spans = labels.map((w, k) => label(named(w, k), curveY(w), "top"));
  if (data.floor > 0) spans.push(label(`floor ${data.floor}`, curveY(data.floor), "top", "floor"));
  element("heights").replaceChildren(...spans);
  return labels.map((w) => `M0 ${curveY(w).toFixed(2)}H1000`).join("");
}

function drawShares(path) {
  const named = (place) => (path.motion ? moment(path, place / 100) : `${place} %`);
  const places = [0, 25, 50, 75].map((place) => label(named(place), place, "left", place === 75 ? "minor" : ""));
  const whole = path.motion ? moment(path, 1) : `100 % of ${path.length.toFixed(2)} rad`;
  element("shares").replaceChildren(...places, label(whole, 100, "left", "whole"));
}

const curveLine = (w) => w.map((value, k) => `${((1000 * k) / (w.length - 1)).toFixed(1)} ${curveY(value).toFixed(2)}`).join("L");

function drawCurve(path, other) {
  const shown = other ? [path, other] : [path];
  const high = 1.1 * Math.max(...shown.flatMap((each) => each.w), data.floor, 1e-9); // leaves space above a constant curve
  curveY = (w) => 98 - (94 * w) / high;
  const piece = (name, way) => vector("path", { class: name, d: way });
  const worst = path.worst.map((point) => `M${(1000 * point.share).toFixed(1)} ${curveY(point.w).toFixed(2)}h0.01`);
  const pieces = [piece("level", drawHeights(high)), piece("curve", `M0 98L${curveLine(path.w)}L1000 98`)];
  if (other) pieces.push(piece("other", `M${curveLine(other.w)}`));
  if (data.floor > 0) pieces.push(piece("floor", `M0 ${curveY(data.floor).toFixed(2)}H1000`));
  element("spark").replaceChildren(...pieces, piece("worst", worst.join("")), piece("here", ""));
  drawShares(path);
}
