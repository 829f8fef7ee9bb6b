// The best cost after each refinement round.

function drawRounds() {
  const curve = data.curve;
  element("rounds-section").hidden = curve.length < 2;
  if (curve.length < 2) return;
  const { left, right, top } = FRAME, bottom = 80;
  const costs = curve.map(([, cost]) => cost), low = Math.min(...costs), high = Math.max(...costs);
  const rounds = curve[curve.length - 1][0], pad = 0.1 * (high - low) || 0.1 * high;
  const x = (spent) => left + ((right - left) * spent) / rounds;
  const y = (cost) => bottom - ((bottom - top) * (cost - low + pad)) / (high - low + 2 * pad);
  const steps = curve.map(([spent, cost], k) => (k ? `H${x(spent).toFixed(1)}V${y(cost).toFixed(1)}` : `M${x(spent)} ${y(cost).toFixed(1)}`));
  const pieces = [vector("path", { class: "axis", d: `M${left} ${top}V${bottom}H${right}` }), vector("path", { class: "steps", d: steps.join("") })];
  pieces.push(words(left - 4, y(low) + 3, low.toPrecision(3), "end"), words(right, bottom + 11, `${rounds}`, "middle"));
  if (high > low) pieces.push(words(left - 4, y(high) + 3, high.toPrecision(3), "end"));
  pieces.push(words(left, bottom + 11, "0", "middle"), words((left + right) / 2, bottom + 11, "refinement rounds", "middle"));
  element("rounds").replaceChildren(...pieces);
}
