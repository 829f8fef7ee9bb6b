// The summary: outcome, warnings, duration, the lowest w on a gauge, clearance, and the nearest limit.

const { gauge } = data; // typical and largest w of the roadmap, and the ends of the bands; null without a roadmap
const LEAST = 1e-3; // start of the gauge, as a share of the typical w

const bandOf = (w) => (gauge ? (gauge.bands.find(([, end]) => w < end) || ["good"])[0] : "");
const shareOf = (w) => `${Number(((100 * w) / gauge.typical).toPrecision(2))} %`;
const ofTypical = (w) => `${shareOf(w)} of the roadmap's median`;
const whereAt = (path, part) => `at ${moment(path, part)}${path.motion ? "" : " of the way"}`;
const millimetres = (metres) => `${(1000 * metres).toFixed(metres < 0.0995 ? 1 : 0)} mm`;

// The smallest known clearance of a path, and its share of the path if that is known.
function clearanceOf({ nearest, motion, choice, clearance }) {
  if (nearest) return { ...nearest, share: motion ? (nearest.at - motion.begin) / motion.duration : nearest.at };
  if (choice && choice.clearance !== null) return { min: choice.clearance };
  if (!clearance) return null;
  const min = Math.min(...clearance);
  return { min, share: clearance.indexOf(min) / (clearance.length - 1) };
}

// The facts of a path: name, value, note, the share of the path to go to, and a rating.
function factsOf(path) {
  const { w, share } = path.worst[0], near = clearanceOf(path), limit = nearestLimit(path);
  const seconds = path.motion ? path.motion.duration : path.choice?.duration;
  const proof = path.motion?.proven ? "proven free and within limits" : "not proven";
  return [
    ["duration", seconds ? `${seconds.toFixed(2)} s` : "no times", path.motion ? proof : seconds ? "" : "a path, not a motion"],
    ["lowest w", `${short(w)} ${data.unit}`, whereAt(path, share), share, bandOf(w)],
    ...(near ? [["clearance", millimetres(near.min), near.pair ? near.pair.join(" – ") : "", near.share]] : []),
    ["nearest limit", limit ? `${short2(limit.slack)} ${data.joints.unit[limit.j]}` : "none",
      limit ? `${data.joints.names[limit.j]} ${whereAt(path, limit.share)}` : "", limit?.share, limit?.slack < 0 ? "singular" : ""],
  ];
}

function drawFacts(path, other) {
  const others = Object.fromEntries(other ? factsOf(other) : []);
  element("facts").replaceChildren(...factsOf(path).map(([name, value, note, share, level]) => {
    const fact = document.createElement("button");
    const parts = [["span", name], ["b", value], ...(other ? [["b", others[name] || "not known", "other"]] : []), ["small", note]];
    fact.append(...parts.map(([tag, text, className = ""]) => Object.assign(document.createElement(tag), { textContent: text, className })));
    fact.className = level || "";
    fact.title = note;
    fact.disabled = share === undefined;
    fact.onclick = () => { stop(); goTo(share); };
    return fact;
  }));
}

function drawGauge(path, other) {
  element("gauge-section").hidden = !gauge;
  if (!gauge) return;
  const least = LEAST * gauge.typical, most = Math.max(gauge.most, ...data.paths.flatMap((each) => each.w));
  const place = (w) => Math.min(Math.max(Math.log(w / least) / Math.log(most / least), 0), 1);
  const named = [...gauge.bands, ["good", most]], ends = named.map(([, end]) => place(end));
  const bands = named.map(([name], k) => {
    const band = Object.assign(document.createElement("i"), { className: name, textContent: name });
    band.style.flexGrow = ends[k] - (ends[k - 1] || 0);
    return band;
  });
  const needles = [path, other].filter(Boolean).map((each) => {
    const needle = Object.assign(document.createElement("b"), { className: each === other ? "other" : "" });
    needle.style.left = `${100 * place(each.worst[0].w)}%`;
    return needle;
  });
  const { w } = path.worst[0], [measured] = data.rows;
  const rows = { pose: "position and orientation", translation: "position", rotation: "orientation", planar: "position in the plane" }[measured];
  element("gauge").replaceChildren(...bands, ...needles);
  element("gauge").setAttribute("aria-label", `lowest w ${short(w)} ${data.unit}: ${bandOf(w)}`);
  element("gauge-text").textContent = `${data.measure === "yoshikawa" ? "w" : data.measure} of ${rows}: ${ofTypical(w)}, ${short(gauge.typical)} ` +
    `${data.unit}. Below ${gauge.bands.map(([name, end]) => `${shareOf(end)}: ${name}`).join(", ")}.`;
}

// Warnings about a path: those of the plan, and those computed here; and mild ones about assumed limits.
function warningsOf(path) {
  const own = path === data.paths[data.current] ? data.about.filter(([name]) => data.wrong.includes(name)).map(([, text]) => text) : [];
  const warnings = [], limit = nearestLimit(path), { w, share } = path.worst[0], moves = path.waypoints.length > 1;
  for (const [name, at] of moves ? [["start", path.w[0]], ["goal", path.w.at(-1)]] : [])
    if (bandOf(at) === "singular") warnings.push(`The ${name} is singular: w is ${short(at)} ${data.unit} there.`);
  const low = { singular: "The arm is singular", poor: "w is poor" }[bandOf(w)];
  if (moves && low && !warnings.length && !own.length) warnings.push(`${low} ${whereAt(path, share)}: w is ${ofTypical(w)}.`);
  if (limit?.slack < 0) warnings.push(`${limitText(path)}.`);
  if (path.motion && !path.motion.proven) warnings.push("The motion is not proven free and within limits.");
  const assumed = Object.entries(path.motion?.limits?.source || {}).filter(([, source]) => source.startsWith("assumed")).map(([kind]) => kind);
  const mild = assumed.length ? [`The limits on ${assumed.join(" and ")} are assumed, as the robot's files have none.`] : [];
  return [[...warnings, ...own, ...data.notes.filter(([, grave]) => grave).map(([text]) => text)], mild];
}

const listItems = (texts) => texts.map((text) => Object.assign(document.createElement("li"), { textContent: text }));

function drawSummary(path, other) {
  const [warnings, mild] = warningsOf(path), moves = path.waypoints.length > 1;
  const outside = data.wrong.some((name) => data.joints.names.includes(name));
  const failed = !moves && (data.roadmap || data.blamed || data.touching.length || outside);
  element("message").className = failed ? "failed" : warnings.length ? "warned" : "fine";
  element("warnings").replaceChildren(...listItems([...warnings, ...mild]));
  const notes = data.notes.filter(([, grave]) => !grave).map(([text]) => text);
  element("notes").replaceChildren(...listItems(notes));
  element("notes-section").hidden = !notes.length;
  element("facts").hidden = !moves;
  if (moves) drawFacts(path, other);
  drawGauge(path, other);
  element("gauge-section").hidden ||= !moves;
}
