// Sharing: an address with beta, time and camera in its hash, the command; and the light or dark theme.

const DARK = { top_color: [0.13, 0.15, 0.19], bottom_color: [0.07, 0.08, 0.1] }, LIGHT = { top_color: [0.95, 0.96, 0.98], bottom_color: [0.82, 0.85, 0.89] };
const prefersDark = matchMedia("(prefers-color-scheme: dark)");
let moved = false; // whether the user moved the camera
let waiting = 0;

const inHash = () => Object.fromEntries(location.hash.slice(1).split("&").map((part) => part.split("=")).filter((pair) => pair.length === 2));
const places = (vectors) => vectors.flatMap((each) => each.toArray()).map((value) => Number(value.toFixed(3))).join(",");

function hashNow() {
  const path = shownPath(), parts = [];
  if (!element("tradeoff").hidden) parts.push(`beta=${Number(Number(element("beta").value).toFixed(6))}`);
  if (path.waypoints.length > 1) parts.push(path.motion ? `t=${(share * path.motion.duration).toFixed(3)}` : `way=${share.toFixed(4)}`);
  if (moved) parts.push(`camera=${places([viewer.camera.position, viewer.controls.target])}`);
  if (root.dataset.theme !== (prefersDark.matches ? "dark" : "light")) parts.push(`theme=${root.dataset.theme}`);
  return `#${parts.join("&")}`;
}

// Delayed, and not per frame of a motion: browsers limit changes per second.
function remember() {
  clearTimeout(waiting);
  if (root.dataset.ready && !playing) waiting = setTimeout(() => {
    try { history.replaceState(null, "", hashNow()); } catch { /* a notebook's frame has a fixed address */ }
  }, 200);
}

function restore() {
  const { beta, t, way, camera, theme } = inHash();
  if (theme) setTheme(theme);
  if (beta !== undefined && !element("tradeoff").hidden && beta >= 0 && beta <= 1) {
    setBeta(Number(beta));
    showPath(pathAt(Number(beta)));
  }
  const { motion } = shownPath(), part = motion ? Number(t) / motion.duration : Number(way);
  if (Number.isFinite(part)) goTo(part);
  const numbers = (camera || "").split(",").map(Number);
  if (numbers.length !== 6 || !numbers.every(Number.isFinite)) return;
  viewer.camera.position.set(...numbers.slice(0, 3));
  viewer.controls.target.set(...numbers.slice(3));
  viewer.controls.update();
  moved = true;
}

function setTheme(theme) {
  root.dataset.theme = theme === "dark" ? "dark" : "light";
  for (const [name, value] of Object.entries(theme === "dark" ? DARK : LIGHT)) viewer.set_property(["Background"], name, value);
  grid.material.color.setHex(theme === "dark" ? 0x4a5260 : 0xffffff);
  drawPlots(shownPath(), otherPath());
}

// The command for a path: the plan's own, or one for another path of its roadmap or sweep.
function commandOf(k) {
  const beta = data.paths[k].choice?.beta ?? Number(Number(element("beta").value).toFixed(6));
  const folder = `'${decodeURIComponent(location.pathname).replace(/\/[^/]*$/, "").replace(/'/g, "'\\''")}'`;
  if (data.command.startsWith("planner sweep"))
    return location.protocol === "file:" ? `planner export ${folder} --beta ${beta}` : `${data.command}\nplanner export sweep --beta ${beta}`;
  if (data.beta === null || !data.command.startsWith("planner plan")) return data.command;
  if (k === data.current) return `${data.command} --beta ${data.beta}`;
  return `${data.command.replace(/ --(nodes|refinement-rounds) \S+/g, "")} --roadmap ${folder.slice(0, -1)}/roadmap.npz' --beta ${beta}`;
}

async function copyCommand() {
  element("command").textContent = commandOf(current);
  element("command").hidden = false;
  getSelection().selectAllChildren(element("command")); // for copying by hand if the browser forbids it here
  const done = await navigator.clipboard?.writeText(element("command").textContent).then(() => true, () => false);
  element("copy").textContent = done ? "copied" : "copy command";
  setTimeout(() => { element("copy").textContent = "copy command"; }, 1500);
}

function startSharing() {
  element("copy").hidden = !data.command;
  element("copy").onclick = copyCommand;
  element("theme").onclick = () => { setTheme(root.dataset.theme === "dark" ? "light" : "dark"); remember(); };
  prefersDark.addEventListener("change", () => { setTheme(prefersDark.matches ? "dark" : "light"); });
  viewer.controls.addEventListener("end", () => { moved = true; remember(); });
  addEventListener("hashchange", restore);
  setTheme(prefersDark.matches ? "dark" : "light");
  restore();
}
