// The roadmap's colours: manipulability, cost-to-go of the shown path, or component.

const PALETTE = ["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#8a8f00", "#4b4b4b"];
const GREY = [0.6, 0.6, 0.6];

function rampColour(share) {
  const place = Math.min(Math.max(share, 0), 1) * (data.ramp.length - 1);
  const k = Math.min(Math.floor(place), data.ramp.length - 2);
  return data.ramp[k].map((low, i) => low + (place - k) * (data.ramp[k + 1][i] - low));
}

const fromHex = (text) => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255);

// Components by size, the largest first: [[number, count], ...].
function componentSizes() {
  const counts = new Map();
  for (const number of data.roadmap.component) counts.set(number, (counts.get(number) || 0) + 1);
  return [...counts].sort((a, b) => b[1] - a[1]);
}

// A path without a beta has no cost-to-go: that of the slider's beta applies.
const costField = (path) => path.cost || (data.paths[0].cost ? data.paths[atBeta()].cost : data.cost);

// One colouring: a colour per node, and its legend.
function colouring(choice, path) {
  if (choice === "component") {
    const sizes = componentSizes();
    const rank = new Map(sizes.map(([number], place) => [number, place]));
    const colour = (number) => (rank.get(number) < PALETTE.length ? fromHex(PALETTE[rank.get(number)]) : GREY);
    const largest = sizes.slice(0, PALETTE.length).map(([, count]) => count).join(", ");
    const rest = sizes.length > PALETTE.length ? `, and ${sizes.length - PALETTE.length} more in grey` : "";
    const heading = sizes.length > 1 ? `${sizes.length} components, largest first` : "1 component";
    return {
      nodes: data.roadmap.component.map(colour),
      swatches: PALETTE.slice(0, sizes.length),
      text: `${heading}: ${largest} nodes${rest}`,
    };
  }
  const values = choice === "w" ? data.roadmap.w : costField(path);
  const high = Math.max(...values.filter((value) => value !== null), 1e-12);
  return {
    nodes: values.map((value) => (value === null ? GREY : rampColour(value / high))),
    low: "0",
    high: high.toFixed(choice === "w" ? 3 : 2),
    text: choice === "w" ? `manipulability w (${data.unit})` : "cost-to-go (no unit); grey nodes reach no goal",
  };
}

// Edges run from one end's colour to the other's.
function edgeColours(nodes, colours) {
  const pieces = data.roadmap.pieces;
  let at = 0;
  for (const [a, b] of data.roadmap.edges)
    for (let k = 0; k < pieces; k++)
      for (const share of [k / pieces, (k + 1) / pieces])
        for (let i = 0; i < 3; i++) colours[at++] = (1 - share) * nodes[a][i] + share * nodes[b][i];
}

function paint(name, fill) {
  const colours = drawn(name).geometry.attributes.color;
  fill(colours.array);
  colours.needsUpdate = true;
}

function colourRoadmap(path) {
  if (!data.roadmap) return;
  const choice = element("colour").value;
  show("roadmap/nodes", choice !== "none");
  element("legend").hidden = element("legend-unit").hidden = choice === "none";
  root.dataset.colour = choice;
  const result = colouring(choice === "none" ? "w" : choice, path);
  paint("roadmap/nodes", (colours) => result.nodes.forEach((colour, k) => colours.set(colour, 3 * k)));
  if (data.roadmap.edges.length) paint("roadmap/edges", (colours) => edgeColours(result.nodes, colours));
  element("low").textContent = result.low || "";
  element("high").textContent = result.high || "";
  element("legend-unit").textContent = result.text;
  const bar = element("bar");
  bar.style.background = result.swatches ? "none" : data.gradient;
  bar.replaceChildren(...(result.swatches || []).map((colour) => swatch(colour)));
}

function swatch(colour) {
  const box = document.createElement("i");
  box.style.background = colour;
  return box;
}

// Round dots instead of the viewer's squares.
function roundDots() {
  const disc = document.createElement("canvas");
  disc.width = disc.height = 64;
  const pen = disc.getContext("2d");
  pen.fillStyle = "#fff";
  pen.arc(32, 32, 31, 0, 2 * Math.PI);
  pen.fill();
  Object.assign(drawn("roadmap/nodes").material, { map: new THREE.CanvasTexture(disc), alphaTest: 0.5 });
}

function startRoadmap(current) {
  element("roadmap-controls").hidden = element("edges-switch").hidden = !data.roadmap;
  if (!data.roadmap) return;
  roundDots();
  if (!costField(data.paths[0])) element("colour").querySelector("[value=cost]").remove();
  element("colour").onchange = () => colourRoadmap(current());
  const edges = () => show("roadmap/edges", element("edges").checked);
  element("edges").onchange = edges;
  edges();
}
