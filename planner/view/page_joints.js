// The joints and their limits: a row per joint, with its curve in a frame from limit to limit.

const short2 = (value) => value.toFixed(2).replace("-", "−");

function vector(name, attributes, ...children) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

// The range of a joint's frame: its limits, or for a continuous joint the range of the paths.
function jointSpan(j) {
  if (!data.joints.free[j]) return [data.joints.lower[j], data.joints.upper[j]];
  const values = data.paths.flatMap((path) => path.waypoints.map((q) => q[j]));
  const low = Math.min(...values), high = Math.max(...values), pad = 0.1 * (high - low) + 0.1;
  return [low - pad, high + pad];
}

// The curve of one joint in a frame of 100 x 100; a single state is a stroke.
function jointCurve(path, j) {
  const [low, high] = jointSpan(j);
  const place = (value) => (100 * (value - low)) / (high - low);
  if (path.waypoints.length < 2) return `M${place(path.waypoints[0][j])} 0V100`;
  return "M" + path.waypoints.map((q, k) => `${(100 * path.shares[k]).toFixed(2)} ${(100 - place(q[j])).toFixed(2)}`).join("L");
}

// The joint nearest to a limit, or farthest beyond one: its extreme is at a waypoint.
function nearestLimit(path) {
  let nearest = null;
  path.waypoints.forEach((q, row) => q.forEach((value, j) => {
    const slack = Math.min(value - data.joints.lower[j], data.joints.upper[j] - value);
    if (!data.joints.free[j] && (!nearest || slack < nearest.slack)) nearest = { slack, j, share: path.shares[row] };
  }));
  return nearest;
}

function limitText(path) {
  const nearest = nearestLimit(path);
  if (!nearest) return "no joint has a limit";
  const { slack, j, share } = nearest;
  const where = path.waypoints.length > 1 ? ` at ${moment(path, share)}${path.motion ? "" : " of the way"}` : "";
  const much = `${Math.abs(slack).toFixed(Math.abs(slack) < 0.01 ? 4 : 2)} ${data.joints.unit[j]}`;
  return slack < 0 ? `${data.joints.names[j]} is ${much} beyond its limit${where}`
    : `${data.joints.names[j]} is nearest to a limit: ${much}${where}`;
}

function drawJoints(path, other) {
  const still = path.waypoints.length < 2;
  const rows = data.joints.names.map((name, j) => {
    const row = document.createElement("tr"), [label, frame, value, limits] = [0, 1, 2, 3].map(() => row.insertCell());
    label.textContent = label.title = name;
    const lines = [vector("path", { class: "way", d: jointCurve(path, j) })];
    if (other) lines.unshift(vector("path", { class: "other", d: jointCurve(other, j) }));
    if (!still) lines.push(vector("path", { class: "here", d: "" }));
    frame.append(vector("svg", { viewBox: "0 0 100 100", preserveAspectRatio: "none",
      class: data.joints.free[j] ? "free" : still ? "still" : "" }, ...lines));
    value.className = "value";
    const [low, high] = jointSpan(j);
    limits.textContent = data.joints.free[j] ? "no limit" : low === -high ? `± ${short2(high)}` : `${short2(low)}…${short2(high)}`;
    if (data.wrong.includes(name)) row.className = "wrong";
    return row;
  });
  element("joints").replaceChildren(...rows);
  element("joint-limit").textContent = limitText(path);
}

function placeJoints(q, share) {
  [...element("joints").rows].forEach((row, j) => {
    row.querySelector(".value").textContent = `${short2(q[j])} ${data.joints.unit[j]}`;
    row.querySelector(".here")?.setAttribute("d", `M${100 * share} 0V100`);
  });
}
