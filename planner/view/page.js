"use strict";
// Replays the recorded scene into meshcat's viewer, then drives it from our own controls.
// The page says when it is ready, in the data-ready attribute of its root, or in data-error what went wrong.

const data = JSON.parse(document.getElementById("data").textContent);
const viewer = new MeshCat.Viewer(document.getElementById("viewer"));
const root = document.documentElement;
const element = (id) => document.getElementById(id);

async function unpack(base64) {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// The scene is MessagePack commands, one after another; the viewer decodes them one by one.
function replay(bytes, lengths) {
  let at = 0;
  for (const length of lengths) {
    viewer.handle_command_bytearray(bytes.slice(at, at + length));
    at += length;
  }
}

function look(eye, target) {
  // meshcat turns z-up into three.js's y-up
  viewer.camera.position.set(eye[0], eye[2], -eye[1]);
  viewer.controls.target.set(target[0], target[2], -target[1]);
  viewer.camera.fov = 40; // a longer lens than the viewer's own: less distortion
  viewer.camera.updateProjectionMatrix();
  viewer.controls.update();
  viewer.set_dirty();
}

function show(path, visible) {
  viewer.handle_command({ type: "set_property", path: "/meshcat/" + path, property: "visible", value: visible });
}

function fillPanel() {
  element("message").textContent = data.message;
  for (const [name, value] of data.numbers) {
    const row = element("numbers").insertRow();
    row.insertCell().textContent = name;
    row.insertCell().textContent = value;
  }
  for (const name of data.obstacles) {
    const item = document.createElement("li");
    item.textContent = name;
    element("obstacles").append(item);
  }
}

function colourNodes() {
  const choice = element("colour").value;
  for (const name of Object.keys(data.legends)) show("roadmap/nodes_" + name, name === choice);
  const legend = data.legends[choice];
  element("legend").style.visibility = element("legend-unit").style.visibility = legend ? "visible" : "hidden";
  if (!legend) return;
  element("low").textContent = legend.low;
  element("high").textContent = legend.high;
  element("legend-unit").textContent = legend.text;
  element("bar").style.background = data.gradient;
}

function showCollision() {
  const on = element("collision").checked;
  for (const joint of data.joints) {
    show("robot/" + joint + "/visual", !on);
    show("robot/" + joint + "/collision", on);
  }
}

// One frame: the column-major placement of every moving joint frame, joint after joint.
function setFrame(position) {
  const motion = data.motion;
  const k = Math.round(position * (motion.frames.length - 1));
  const frame = motion.frames[k];
  data.joints.slice(1).forEach((joint, j) => {
    viewer.set_transform(["meshcat", "robot", joint], frame.slice(16 * j, 16 * j + 16));
  });
  viewer.set_dirty();
  element("now").textContent = "w = " + motion.w[k].toFixed(4) + " · " + Math.round(100 * position) + " % of the way";
  root.dataset.frame = String(k);
}

function startPlayer() {
  if (!data.motion) {
    element("player").hidden = true;
    return;
  }
  const scrub = element("scrub"), play = element("play");
  const seconds = data.motion.seconds;
  let playing = false, last = 0;
  const step = (now) => {
    if (!playing) return;
    const position = Number(scrub.value) + (1000 * (now - last)) / (1000 * seconds);
    last = now;
    scrub.value = Math.min(position, 1000);
    setFrame(scrub.value / 1000);
    if (position >= 1000) stop();
    else requestAnimationFrame(step);
  };
  const stop = () => { playing = false; play.textContent = "Play"; };
  play.onclick = () => {
    if (playing) return stop();
    if (Number(scrub.value) >= 1000) scrub.value = 0;
    playing = true;
    play.textContent = "Pause";
    last = performance.now();
    requestAnimationFrame(step);
  };
  scrub.step = "any";
  scrub.oninput = () => { stop(); setFrame(scrub.value / 1000); };
  setFrame(0);
}

async function main() {
  replay(await unpack(element("scene").textContent), data.lengths);
  look(data.eye, data.target);
  fillPanel();
  element("colour").onchange = colourNodes;
  element("edges").onchange = () => show("roadmap/edges", element("edges").checked);
  element("collision").onchange = showCollision;
  colourNodes();
  showCollision();
  show("roadmap/edges", element("edges").checked);
  startPlayer();
  requestAnimationFrame(() => requestAnimationFrame(() => { root.dataset.ready = "true"; }));
}

main().catch((error) => { root.dataset.error = String(error); throw error; });
