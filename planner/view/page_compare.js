// A second plan, from a file: its path, curves and numbers next to the shown ones.

const STEP_OF_JOINT = 1e-5; // rad, m: of central differences

// The columns of the tool's Jacobian, by differences of the page's own kinematics.
function jacobianAt(q) {
  return q.map((_, j) => {
    const [ahead, behind] = [1, -1].map((sign) => placements(q.map((value, i) => value + (i === j ? sign * STEP_OF_JOINT : 0))));
    const linear = plus(toolPosition(ahead), toolPosition(behind), -1), [a, b] = [ahead, behind].map((frames) => frames[data.chain.tool.parent].rotation);
    const turn = product(a, [b[0], b[3], b[6], b[1], b[4], b[7], b[2], b[5], b[8]]);
    const angular = [turn[7] - turn[5], turn[2] - turn[6], turn[3] - turn[1]].map((value) => value / 2);
    return [...linear, ...angular].slice(...data.rows.slice(1)).map((value) => value / (2 * STEP_OF_JOINT));
  });
}

// w, the volume that the rows of the Jacobian span, by Gram-Schmidt.
function manipulabilityAt(q) {
  const columns = jacobianAt(q), rows = columns[0].map((_, i) => columns.map((column) => column[i]));
  const vectors = rows.length <= columns.length ? rows : columns;
  return vectors.reduce((volume, row, k) => {
    const length = Math.hypot(...row);
    for (const later of length ? vectors.slice(k + 1) : []) {
      const along = later.reduce((sum, value, i) => sum + value * row[i], 0) / length ** 2;
      row.forEach((value, i) => { later[i] -= along * value; });
    }
    return volume * length;
  }, 1);
}

// The path of a plan.json in the page's form; an error explains why a path cannot be shown.
function pathOfRecord(record, name) {
  const { path, joints, cost, clearance, trajectory, path_length: length } = record;
  if (!path?.length || !Array.isArray(joints)) throw new Error("the file must be a plan.json with a path.");
  if (data.measure !== "yoshikawa") throw new Error(`the page must measure w, got ${data.measure}, which a plan.json does not hold.`);
  if (joints.join() !== data.joints.names.join()) throw new Error(`its joints must be ${data.joints.names.join(", ")}, got ${joints.join(", ")}.`);
  const steps = path.slice(1).map((q, k) => Math.hypot(...q.map((value, j) => value - path[k][j])));
  const along = steps.reduce((sums, step) => [...sums, sums.at(-1) + step], [0]), total = along.at(-1);
  const result = { name, waypoints: path, shares: along.map((sum) => sum / (total || 1)), length: total, seconds: Math.max(2, 0.8 * total) };
  result.w = EVEN.map((part) => manipulabilityAt(configurationAt(result, part)));
  const lowest = result.w.indexOf(Math.min(...result.w));
  result.worst = [{ w: result.w[lowest], share: EVEN[lowest], position: toolPosition(placements(configurationAt(result, EVEN[lowest]))) }];
  result.ellipsoids = [[0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0]];
  result.nearest = clearance?.path || null;
  result.choice = { duration: trajectory?.duration ?? null, clearance: clearance?.path?.min ?? null };
  result.numbers = [["manipulability cost Ω", cost?.manipulability.toFixed(4)], ["distance cost D", cost?.distance.toFixed(4)],
    [`w mean (${data.unit})`, record.manipulability?.mean.toPrecision(3)], ["joint motion", `${total.toFixed(3)} rad`],
    ["tool's path", length && `${length.workspace.toFixed(3)} m`], ["waypoints", String(path.length)]];
  return result;
}

async function compareWithFile() {
  const [file] = element("file").files, message = element("file-message");
  element("file").value = "";
  try {
    const path = pathOfRecord(JSON.parse(await file.text()), file.name), k = data.paths.push(path) - 1;
    drawWay(path, k);
    element("choice").hidden = false;
    element("compare").append(new Option(path.name, k, true, true));
    message.textContent = "";
    compareWith(k);
  } catch (error) {
    message.textContent = `${file.name} cannot be compared: ${error.message}`;
  }
}
