// The numbers at the current time.
const row = (table, name, swatch) => {
  const tr = $(table).tBodies[0].insertRow();
  const th = document.createElement("th");
  th.scope = "row";
  if (swatch) {
    const mark = document.createElement("span");
    mark.className = "swatch";
    mark.style.background = swatch;
    th.append(mark);
  }
  th.append(name);
  tr.append(th);
  return { tr, cell: tr.insertCell() };
};

const readings = [];
const contacts = [];
for (const panel of data.panels) {
  for (const curve of panel.curves) {
    if (panel.lanes) contacts.push({ curve, ...row("pushes", curve.label, curveColour(curve)) });
    else {
      const name = panel.curves.length > 1 ? `${curve.label} ${panel.quantity}` : panel.quantity;
      readings.push({ curve, unit: panel.unit, ...row("now", name, curveColour(curve)) });
    }
  }
}
const nothing = row("pushes", "nothing touches");
const carried = data.actions.flatMap(({ pins }) => pins.map((pin) => ({ pin, ...row("pins", pin.label) })));
$("pins").hidden = !carried.length;

const readOut = (where) => {
  for (const { curve, unit, cell } of readings) cell.textContent = `${mix(curve.y, where).toFixed(2)} ${unit}`;
  let touching = 0;
  for (const { curve, tr, cell } of contacts) {
    const force = mix(curve.y, where);
    tr.hidden = !(force > 0);
    touching += force > 0;
    cell.textContent = force > 0 && force < 0.005 ? "< 0.01 N" : newtons(force);
  }
  nothing.tr.hidden = touching > 0;
  const signed = (f) => `${f < -0.005 ? "\u2212" : ""}${Math.abs(f).toFixed(2)} N`;
  for (const { pin, cell } of carried) cell.textContent = `${signed(mix(pin.x, where))}, ${signed(mix(pin.y, where))}`;
};
