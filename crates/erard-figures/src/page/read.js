// Reading the data: base64 to typed arrays, and values between frames.
const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);

const floats = (text) => {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Float32Array.from({ length: bytes.length >> 2 }, (_, i) => view.getFloat32(4 * i, true));
};

const time = floats(data.time);
const frames = time.length;
const begin = frames ? time[0] : 0;
const end = frames > 1 ? time[frames - 1] : begin + 1e-3;

// One action, or two on one clock.
for (const action of data.actions) {
  for (const body of action.bodies) body.angle = floats(body.angle);
  action.force = floats(action.force);
  if (action.string) action.string.shape = floats(action.string.shape);
  if (action.string?.pedal) action.string.pedal = floats(action.string.pedal);
  for (const pin of action.pins) [pin.x, pin.y] = [floats(pin.x), floats(pin.y)];
  // A zone's values only exist where it pushes; `force` is filled up with zeros so that it can be drawn as a curve.
  for (const zone of action.zones) {
    zone.values = floats(zone.values);
    zone.force = new Float32Array(frames);
    zone.at = new Int32Array(frames).fill(-1);
    let entry = 0;
    for (const [first, count] of zone.spans) {
      for (let i = first; i < first + count; i++, entry++) {
        zone.force[i] = zone.values[4 * entry];
        zone.at[i] = 4 * entry;
      }
    }
  }
}
for (const panel of data.panels) {
  for (const curve of panel.curves) {
    const { y, action, zone } = curve.source;
    curve.y = y === undefined ? data.actions[action].zones[zone].force : floats(y);
  }
}

// The last frame at or before t, by bisection.
const frameAt = (t) => {
  let low = 0, high = frames - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (time[middle] <= t) low = middle; else high = middle - 1;
  }
  return low;
};

// Where t lies between frames: the frame before, the frame after, and the share of the way.
const between = (t) => {
  const i = frameAt(t), j = Math.min(i + 1, frames - 1);
  const share = j > i ? Math.min(Math.max((t - time[i]) / (time[j] - time[i]), 0), 1) : 0;
  return { i, j, share };
};
const mix = (series, { i, j, share }) => series[i] + share * (series[j] - series[i]);

const milliseconds = (t) => `${(1e3 * t).toFixed(2)} ms`;
