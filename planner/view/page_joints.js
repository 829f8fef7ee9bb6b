// The joints against their limits: a row a joint, a line along the path in a frame whose edges are the limits.

const short2 = (value) => value.toFixed(2).replace("-", "−");

function vector(name, attributes, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

// What the frame of a joint spans: its limits, or where it turns freely what the shown paths need.
function jointSpan(j) {
  if (!data.joints.free[j]) return [data.joints.lower[j], data.joints.upper[j]];
  const values = data.paths.flatMap((path) => path.waypoints.map((q) => q[j]));
  const low = Math.min(...values), high = Math.max(...values), room = 0.1 * (high - low) + 0.1;
  return [low - room, high + room];
}

// The way of one joint, from the left to the right, in a frame of 100 x 100; a state is one stroke from limit to limit.
function jointCurve(path, j) {
  const [low, high] = jointSpan(j);
  const place = (value) => (100 * (value - low)) / (high - low);
  if (path.waypoints.length < 2) return `M${place(path.waypoints[0][j])} 0V100`;
  return "M" + path.waypoints.map((q, k) => `${(100 * path.shares[k]).toFixed(2)} ${(100 - place(q[j])).toFixed(2)}`).join("L");
}

// The joint that comes nearest to a limit, or goes farthest beyond: between waypoints no joint is nearer than at one.
function nearestLimit(path) {
  let nearest = null;
  path.waypoints.forEach((q, row) => q.forEach((value, j) => {
    const room = Math.min(value - data.joints.lower[j], data.joints.upper[j] - value);
    if (!data.joints.free[j] && (!nearest || room < nearest.room)) nearest = { room, j, share: path.shares[row] };
  }));
  return nearest;
}

function limitText(path) {
  const nearest = nearestLimit(path);
  if (!nearest) return "every joint turns freely";
  const { room, j, share } = nearest;
  const where = path.waypoints.length > 1 ? ` at ${moment(path, share)}${path.motion ? "" : " of the way"}` : "";
  const much = `${Math.abs(room).toFixed(Math.abs(room) < 0.01 ? 4 : 2)} ${data.joints.unit[j]}`;
  return room < 0 ? `${data.joints.names[j]} is ${much} beyond its limit${where}`
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
    limits.textContent = data.joints.free[j] ? "turns freely" : low === -high ? `± ${short2(high)}` : `${short2(low)}…${short2(high)}`;
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
