// The names of the parts, around whatever the view shows: two rows above and two below, each with a line to its part.
const named = data.actions[0].labels.map(({ text, piece, at }) => {
  const group = $("names");
  const leader = element("path", { class: "leader" }, group);
  const end = element("circle", { class: "leader-end", r: 0.9 }, group);
  const label = element("text", { class: "label", "text-anchor": "middle" }, group);
  label.textContent = text;
  const moving = data.actions[0].moving.find((one) => one.element === data.actions[0].pieces[piece]);
  return { text, moving, at, leader, end, label };
});
const anchorOf = ({ moving, at }) => {
  const [x, y] = carry(moving?.frame ?? STILL, at);
  return [x, -y];
};

let layoutOfNames = "";
const nameParts = () => {
  const on = $("naming").checked && !data.actions[0].group.hasAttribute("hidden");
  $("names").style.display = on ? "" : "none";
  if (!on) return;
  const [left, top, wide, tall] = view;
  // which are seen decides the layout; while nothing enters or leaves, labels stand still and only their lines move
  const matrix = picture.getScreenCTM(), frame = picture.getBoundingClientRect();
  const seen = (at) => at[0] > left && at[0] < left + wide && at[1] > top && at[1] < top + tall;
  const inside = named.filter((label) => seen((label.anchor = anchorOf(label))));
  const layout = `${view} ${pixel} ${isBeside()} ${inside.map(({ text }) => text)}`;
  if (layout !== layoutOfNames && matrix) {
    layoutOfNames = layout;
    // the element shows more than the view box where their shapes differ
    const edge = (x, y) => [(x - matrix.e) / matrix.a, (y - matrix.f) / matrix.d];
    const [l, t] = isBeside() ? [left, top] : edge(frame.left, frame.top);
    const [r, b] = isBeside() ? [left + wide, top + tall] : edge(frame.right, frame.bottom);
    for (const label of named) label.placed = false;
    layNames(inside, [l, t, r, b], pixel);
  }
  for (const label of named) {
    const shown = label.placed && inside.includes(label);
    for (const part of [label.leader, label.end, label.label]) part.style.display = shown ? "" : "none";
    if (!shown) continue;
    const [x, y] = label.anchor;
    label.leader.setAttribute("d", `M${label.x.toFixed(2)} ${label.from.toFixed(2)}L${x.toFixed(2)} ${y.toFixed(2)}`);
    label.leader.setAttribute("stroke-width", pixel.toFixed(3));
    label.end.setAttribute("cx", x.toFixed(2));
    label.end.setAttribute("cy", y.toFixed(2));
    label.end.setAttribute("r", (2 * pixel).toFixed(3));
    label.label.setAttribute("x", label.x.toFixed(2));
    label.label.setAttribute("y", label.y.toFixed(2));
  }
};
$("naming").addEventListener("change", () => {
  nameParts();
  remember();
});
