// The names of the parts, around whatever the view shows: two rows above and two below, each with a line to its part.
const named = data.actions[0].labels.map(({ text, piece, at }) => {
  const group = $("names");
  const leader = element("path", { class: "leader" }, group);
  const end = element("circle", { class: "leader-end", r: 0.9 }, group);
  const label = element("text", { class: "label", "text-anchor": "middle" }, group);
  label.textContent = text;
  return { text, piece: data.actions[0].pieces[piece], at, leader, end, label };
});
const anchorOf = ({ piece, at }) => {
  const [x, y] = carry(piece.frame ?? STILL, at);
  return [x, -y];
};

// Puts the labels of one side into two rows, in the order of what they name, pushed apart until none covers another.
const spread = (side, left, right) => {
  side.sort((a, b) => a.anchor[0] - b.anchor[0]);
  side.forEach((label, index) => {
    label.row = index % 2;
    label.x = label.anchor[0];
  });
  const apart = (a, b, room) => {
    const lack = room - (b.x - a.x);
    if (lack > 0) {
      a.x -= lack / 2;
      b.x += lack / 2;
    }
  };
  for (let round = 0; round < 600; round++) {
    for (let i = 1; i < side.length; i++) {
      apart(side[i - 1], side[i], (side[i].row ? side[i - 1] : side[i]).wide / 2 + 6 * pixel);
      if (i > 1) apart(side[i - 2], side[i], (side[i - 2].wide + side[i].wide) / 2 + 8 * pixel);
    }
    for (const label of side) label.x = Math.max(Math.min(label.x, right - label.wide / 2), left + label.wide / 2);
  }
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
    const heights = inside.map(({ anchor }) => anchor[1]).sort((p, q) => p - q);
    const middle = heights[heights.length >> 1];
    for (const above of [true, false]) {
      let side = inside.filter(({ anchor }) => anchor[1] < middle === above);
      for (const label of side) label.wide = 7.4 * label.text.length * pixel;
      // a narrow view has no room for all: the longest chains of neighbours lose every other name
      while (side.length > 1 && side.reduce((sum, { wide }) => sum + wide + 8 * pixel, 0) > 1.8 * (r - l)) side = side.filter((_, i) => i % 2 === 0);
      spread(side, l + 3 * pixel, r - 3 * pixel);
      for (const label of side) {
        label.placed = true;
        label.y = above ? t + (14 + 16 * (1 - label.row)) * pixel : b - (6 + 16 * (1 - label.row)) * pixel;
        label.from = above ? label.y + 3 * pixel : label.y - 12 * pixel;
      }
    }
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
