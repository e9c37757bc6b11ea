// The story: each step's task is done by hand, and every claim of its text is held against the engine's numbers.
import { rewrite, rewriting } from "./claims.mjs";
import { assert, until } from "./help.mjs";

/** Scrolls to a step's figure; it is then the one that the engine plays. */
export const to = async (page, id) => {
  await page.evaluate((id) => {
    const { top, height } = document.querySelector(`[data-scene=${id}] .frame`).getBoundingClientRect();
    scrollTo({ top: scrollY + top + height / 2 - innerHeight / 2, behavior: "instant" });
  }, id);
  await until(page, (id) => story.active === id && document.querySelector(`[data-scene=${id}]`).dataset.live === "true", id);
};
const now = (page, id) => page.evaluate((id) => {
  const { now, done, slowest } = story.figures[id];
  return { ...now?.press, up_mm: now?.press.up_mm, key_mm: 1e3 * (now?.pose.key_m ?? 0), hammer_mm: 1e3 * (now?.pose.hammer_rise_m ?? 0), swing: now?.pose.swing_m, events: now?.events, resting: now?.resting, done, slowest };
}, id);
const rest = (page, id) => until(page, (id) => story.figures[id].now?.pose.key_m < 2e-4 && story.figures[id].now.resting, id, 60_000);
export const done = (page, id) => until(page, (id) => story.figures[id].done, id, 30_000).catch(async () => {
  assert.fail(`${id}: the task is not done: ${await page.textContent(`[data-scene=${id}] .outcome`)} ${JSON.stringify(await now(page, id))}`);
});
/** Where a finger of a figure stands, px, and how far a millimetre of the key is. */
export const finger = (page, id) => page.evaluate((id) => {
  const grip = document.querySelector(`[data-scene=${id}] .grip`).getBoundingClientRect(), track = document.querySelector(`[data-scene=${id}] .track`).getBoundingClientRect();
  return { x: grip.left + grip.width / 2, y: track.top, mm: track.height / 11 };
}, id);
export const press = async (page, id) => {
  await page.locator(`[data-scene=${id}] .press`).hover();
  await page.mouse.down();
};
/** Moves a mouse that is down on a figure's finger from one depth to another, mm, at an even pace: an event with every
 * frame of the page, as a browser that is not busy sends them. Returns the longest time between two of them, ms. */
const move = (page, { x, y, mm }, from, to_mm, ms) => page.evaluate(([x, y, mm, from, to_mm, ms]) => new Promise((resolve) => {
  const grip = document.elementFromPoint(x, y), began = performance.now();
  let last = began, longest = 0;
  const step = () => {
    const at = performance.now(), share = Math.min((at - began) / ms, 1);
    longest = Math.max(longest, at - last);
    last = at;
    grip.dispatchEvent(new PointerEvent("pointermove", { pointerId: 1, clientX: x, clientY: y + (from + share * (to_mm - from)) * mm, bubbles: true }));
    if (share < 1) requestAnimationFrame(step);
    else resolve(longest);
  };
  requestAnimationFrame(step);
}), [x, y, mm, from, to_mm, ms]);
const choose = async (page, id, which) => {
  await page.locator(`[data-scene=${id}] .switch label`).nth(which).click();
  // Strings whose dampers the pedal has just lifted tremble for long: rest is not waited for.
  await until(page, ([id, which]) => story.figures[id].now?.option === which && story.figures[id].now.pose.key_m < 1e-3, [id, which]);
  await page.waitForTimeout(500);
};
/** Plays a table on a figure's action from its rest, and waits until it is over. */
const play = async (page, id, ...through) => {
  await page.evaluate(() => story.live.stop());
  await rest(page, id);
  await page.evaluate(([through]) => {
    const rows = ["time_s,position_m"];
    for (let n = 0; n <= 1000 * through.at(-1)[0]; n++) {
      const time = n / 1000, next = Math.max(through.findIndex(([at]) => at >= time), 1);
      const [[from, start], [to, end]] = [through[next - 1], through[next]];
      rows.push(`${time.toFixed(3)},${((start + (end - start) * (0.5 - 0.5 * Math.cos((Math.PI * (time - from)) / (to - from)))) / 1000).toFixed(10)}`);
    }
    story.live.play(rows.join("\n"));
  }, [through]);
  await until(page, (id) => story.figures[id].now.pose.key_m > 1e-3, id);
  await rest(page, id);
};
/** Down, up by so many millimetres, and down again. */
const again = (mm) => [[0, 0], [0.02, 0], [0.06, 9.4], [0.25, 9.4], [0.34, 9.4 - mm], [0.5, 9.4 - mm], [0.54, 9.4], [0.7, 9.4], [0.85, 0], [0.95, 0]];
/** Something of every row that the player keeps: time, key and hammer, mm, finger and string, N. */
const rows = (page) => page.workers().find((one) => one.url().includes("player")).evaluate(() => {
  const { ring } = globalThis.player.actions[0];
  return Array.from({ length: ring.length }, (_, k) => [ring.timeOf(k), 1e3 * ring.at(k, 0), 1e3 * ring.at(k, 1), ring.at(k, 2), ring.at(k, 3)]);
});
const measured = (page, id, lines) => page.evaluate(([id, lines]) => story.live.measure(story.steps[id].setups.at(-1), lines), [id, lines]);

/** Every step's task is done by hand, time slows down by itself, and each claim of the text holds. */
export const tasks = async ({ read }) => {
  const page = await read("", { viewport: { width: 1400, height: 900 } });
  const values = await page.evaluate(() => Object.fromEntries([...document.querySelectorAll("data[data-claim]")].map((one) => [one.dataset.claim, Number(one.value)])));
  const held_true = new Set();
  /** A claim of the page holds; `holds` is given the number that the text is about. */
  const claim = (name, holds, found) => {
    assert(name in values, `no claim ${name} is on the page`);
    assert(holds(values[name]), `${name}: the page says ${values[name]}, found ${found}`);
    held_true.add(name);
  };
  /** The number of a claim; `.ci/regenerate story` writes the engine's where it differs. */
  const changed = new Map();
  const near = (name, found, within) => {
    const holds = (value) => Math.abs(found - value) <= within;
    if (rewriting && name in values && !holds(values[name])) {
      if (!changed.has(name)) changed.set(name, found);
      held_true.add(name);
    } else claim(name, holds, `${found}; \`.ci/regenerate story\` rewrites it`);
  };
  const slow = async (id) => assert((await now(page, id)).slowest < 0.11, `${id}: time did not slow down by itself`);

  // 1. Halfway down by the finger; then a press that goes all the way.
  await to(page, "lever");
  const at = await finger(page, "lever");
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  await move(page, at, 0, 5, 500);
  await done(page, "lever");
  await until(page, () => Math.abs(story.figures.lever.now.pose.key_m - 5e-3) < 4e-4);
  await page.waitForTimeout(400);
  const half = await now(page, "lever");
  near("ratio", half.hammer_mm / half.key_mm, 0.2);
  await page.mouse.up();
  await rest(page, "lever");
  await press(page, "lever");
  await until(page, () => story.figures.lever.now.press.impacts > 0);
  await page.mouse.up();
  await slow("lever");
  const sheet = await measured(page, "lever", "dip_mm,blow_mm,strike_weight_g,strike_weight_ratio_weights,effective_inertia_kg,effective_inertia_hammer_kg,check_mm,damper_start_share");
  near("dip", sheet.dip_mm, 0.6);
  claim("blow", (value) => sheet.blow_mm < value && sheet.blow_mm > value - 4, sheet.blow_mm);
  near("grams", sheet.strike_weight_g, 0.5);
  near("weight", sheet.strike_weight_ratio_weights, 0.2);

  // 2. A hammer that is pushed to the string and held there, and 3. one that is set free.
  const swings = {};
  for (const id of ["flight", "escapement"]) {
    await to(page, id);
    const at = await finger(page, id);
    await page.mouse.move(at.x, at.y);
    await page.mouse.down();
    await move(page, at, 0, 10.6, 60);
    await done(page, id);
    await page.mouse.up();
    await slow(id);
    await rest(page, id);
    const before = (await now(page, id)).first_impact_s;
    await press(page, id);
    await until(page, ([id, before]) => story.figures[id].now.press.first_impact_s > before && story.figures[id].now.press.later_m > 0, [id, before], 60_000);
    swings[id] = await now(page, id);
    if (id === "escapement") {
      const all = await rows(page);
      const first = all.findIndex(([, , , , string_n]) => string_n > 0), away = all.findIndex(([, , , , string_n], k) => k > first && string_n === 0);
      claim("contact", (value) => first > 0 && 1e3 * (all[away][0] - all[first][0]) < value, 1e3 * (all[away][0] - all[first][0]));
    }
    await page.mouse.up();
    await rest(page, id);
  }
  claim("drums", (value) => swings.flight.impacts > value, swings.flight.impacts);
  claim("choked", (value) => swings.flight.later_m < value * swings.flight.swing_m, swings.flight.later_m / swings.flight.swing_m);
  near("once", swings.escapement.impacts, 0);
  claim("free", (value) => swings.escapement.later_m > value * swings.escapement.swing_m, swings.escapement.later_m / swings.escapement.swing_m);
  near("let-off", (await measured(page, "escapement", "let_off_mm")).let_off_mm, 0.1);
  // Too soft, and the page says so. A machine that stalls lets the finger jump: that press is not soft, and is made
  // again.
  const gently = await finger(page, "escapement");
  const soft = () => page.evaluate(() => document.querySelector("[data-scene=escapement] .outcome").textContent.startsWith("Too soft"));
  for (let n = 0; n < 3; n++) {
    await page.mouse.move(gently.x, gently.y);
    await page.mouse.down();
    await move(page, gently, 0, 10, 3000);
    await page.waitForTimeout(500);
    if (await soft()) break;
    await page.mouse.up();
    await rest(page, "escapement");
  }
  assert(await soft(), "a soft press says so");
  near("soft", (await now(page, "escapement")).impacts, 0);
  await page.mouse.up();

  // 4. Without the check, and with it.
  await to(page, "check");
  const impacts = [];
  for (const which of [0, 1]) {
    await choose(page, "check", which);
    await press(page, "check");
    await until(page, (which) => story.figures.check.now.option === which && story.figures.check.now.resting && story.figures.check.now.press.impacts > 0, which, 60_000);
    impacts.push(await now(page, "check"));
    await page.mouse.up();
    await rest(page, "check");
  }
  await done(page, "check");
  await slow("check");
  near("twice", impacts[0].impacts, 0);
  near("caught", impacts[1].impacts, 0);
  near("check", sheet.check_mm, 0.5);
  near("check", sheet.blow_mm - impacts[1].hammer_mm, 2);

  // 5. Held, then let go; and with the pedal.
  await to(page, "damper");
  const left = [];
  for (const which of [0, 1]) {
    await choose(page, "damper", which);
    await press(page, "damper");
    await until(page, () => story.figures.damper.now.press.impacts > 0 && story.figures.damper.now.pose.time_s > story.figures.damper.now.press.first_impact_s + 0.3, undefined, 60_000);
    const before = await now(page, "damper");
    await page.mouse.up();
    await until(page, () => story.figures.damper.now.pose.key_m < 1e-3);
    const up = await page.evaluate(() => story.figures.damper.now.pose.time_s);
    await until(page, (up) => story.figures.damper.now.pose.time_s > up + 0.2, up);
    left.push((await now(page, "damper")).swing / before.swing_m);
  }
  await done(page, "damper");
  await slow("damper");
  claim("damped", (value) => left[0] < value, left[0]);
  claim("pedal", (value) => left[1] > value, left[1]);
  near("half", sheet.damper_start_share, 0.05);

  // 6. and 7. Down, halfway up, down again: without the repetition lever and with it.
  const twice = {};
  for (const id of ["again", "erard"]) {
    await to(page, id);
    const at = await finger(page, id);
    await page.mouse.move(at.x, at.y);
    // A machine that stalls makes an uneven hand, whose press strikes twice or not at all, or whose key comes up too
    // far in between: then once more. How often the hammer struck at the end does not decide.
    for (let tried = 0; tried < 5; tried++) {
      await rest(page, id);
      await page.mouse.down();
      let longest = await move(page, at, 0, 10.2, 60);
      await until(page, (id) => story.figures[id].now.press.presses === 1 && story.figures[id].now.resting, id, 60_000);
      const first = await now(page, id);
      if (first.impacts !== 1 || first.hammer_mm > 40) {
        await page.mouse.up();
        continue;
      }
      longest = Math.max(longest, await move(page, at, 10.2, 5.2, 180));
      await until(page, (id) => story.figures[id].now.pose.key_m < 6e-3, id, 60_000);
      await page.waitForTimeout(700);
      longest = Math.max(longest, await move(page, at, 5.2, 10.2, 60));
      await until(page, (id) => story.figures[id].now.press.presses === 2 && story.figures[id].now.resting, id, 60_000);
      await done(page, id);
      await page.mouse.up();
      twice[id] = { ...(await now(page, id)), longest_ms: longest };
      if (longest < 60 && Math.abs(twice[id].released_mm - 4.9) < 0.7) break;
    }
    await slow(id);
    await rest(page, id);
  }
  assert(twice.again.impacts === 1 && twice.erard.impacts === 2, JSON.stringify(twice));
  const struck = async (id, mm) => {
    await play(page, id, ...again(mm));
    return (await now(page, id)).impacts;
  };
  await to(page, "again");
  const [most, least] = [await struck("again", values["way-up"]), await struck("again", values["way-up"] - 0.5)];
  claim("way-up", () => most === 2 && least === 1, `${most} impacts after that way, ${least} after half a millimetre less`);
  const nothing = await struck("again", values["half-up"]);
  claim("half-up", () => nothing === 1, `${nothing} impacts`);
  await to(page, "erard");
  const small = await struck("erard", values.small);
  claim("small", () => small === 2, `${small} impacts`);
  const all = await rows(page);
  // While the key comes up and the second press has not begun, how far the hammer rises from where it was held.
  const down = all.findIndex(([, key]) => key > 9.3), up = all.findIndex(([, key], k) => k > down && key < 9.4 - 0.3);
  const second = all.findIndex(([, key], k) => k > up && key > all[k - 1][1] + 1e-4 && key > 9.4 - values.small + 0.3);
  const rise = Math.max(...all.slice(up, second).map(([, , hammer]) => hammer)) - all[up][2];
  claim("rises", (value) => rise > value, rise);

  // 8. A slow press draws the action's inside; a loud one does not.
  await to(page, "touch");
  const slowly = await finger(page, "touch");
  await page.mouse.move(slowly.x, slowly.y);
  await page.mouse.down();
  await move(page, slowly, 0, 10, 3600);
  await done(page, "touch");
  await page.mouse.up();
  assert((await page.evaluate(() => document.querySelector(".plot .trace").getAttribute("d").length)) > 400, "the curve is drawn");
  await rest(page, "touch");
  await page.click("[data-scene=touch] .show");
  await until(page, () => story.figures.touch.now.pose.key_m > 9.5e-3, undefined, 60_000);
  const curve = (await rows(page)).filter(([, key, , n]) => key > 0.3 && n > 0);
  await rest(page, "touch");
  const grams = (from, to_mm, of) => of(curve.filter(([, key]) => key > from && key < to_mm).map(([, , , n]) => n * 101.97));
  const mean = (list) => list.reduce((sum, one) => sum + one, 0) / list.length;
  // The ring keeps three seconds of the four: the way from two millimetres on.
  const weight = grams(3, 4.6, mean), damped = grams(5.3, 5.7, mean), notch = grams(6, 8.8, (list) => Math.max(...list));
  near("down", weight, 4);
  near("damper-step", damped - weight, 4);
  near("notch", notch / weight, 0.5);
  const loud = await page.workers().find((one) => one.url().includes("player")).evaluate(() => {
    const { player } = globalThis;
    player.begin({ nuance: "f", struck: false });
    let most = 0, speed = 0;
    for (let n = 0; n < 60; n++) {
      player.advance(0.005, { kind: "finger", position_m: null });
      const one = player.actions[0], { ring } = one;
      for (let k = Math.max(ring.length - 100, 0); k < ring.length; k++) most = Math.max(most, ring.at(k, 2));
      speed = one.hammer_speed_m_per_s;
      if (one.impact_count) break;
    }
    return { most, speed };
  });
  claim("loud", (value) => (loud.most * 101.97) / weight > value, `${loud.most} N at ${loud.speed} m/s`);
  near("fifths", sheet.effective_inertia_hammer_kg / sheet.effective_inertia_kg, 0.03);
  await rest(page, "touch");
  await press(page, "touch");
  await until(page, () => story.figures.touch.now.press.impacts > 0);
  await page.mouse.up();
  await slow("touch");

  // What is tried at the workbench holds, too: the links lead there.
  for (const link of await page.evaluate(() => [...document.querySelectorAll(".cards a")].map((one) => one.getAttribute("href")))) await bench(await read(link), link, claim);
  assert.deepEqual(Object.keys(values).filter((name) => !held_true.has(name)), [], "claims that no test holds against the engine");
  if (rewriting) assert.deepEqual(rewrite(changed), [], "the page has the engine's numbers; these words are to be rewritten by hand");
  return `${held_true.size} claims; ${half.hammer_mm.toFixed(1)} mm of hammer for ${half.key_mm.toFixed(1)} mm of key; ${swings.flight.impacts} and ${swings.escapement.impacts} impacts, ` +
    `${((100 * swings.flight.later_m) / swings.flight.swing_m).toFixed(0)} and ${((100 * swings.escapement.later_m) / swings.escapement.swing_m).toFixed(0)} % of the swing after half a second; ${weight.toFixed(0)}, ${damped.toFixed(0)} and ${notch.toFixed(0)} g; forte ${loud.most.toFixed(1)} N`;
};

/** The cards at the end: what they say happens at the workbench does. */
const bench = async (page, link, claim) => {
  const over = async (stroke) => {
    const before = await page.evaluate(() => `${studio.events[0]?.hammer_contact_s}`);
    await page.evaluate((stroke) => studio.stroke(stroke), stroke);
    await until(page, (before) => studio.events[0].hammer_contact_s > 0 && `${studio.events[0].hammer_contact_s}` !== before, before);
    await until(page, () => document.getElementById("clock").textContent === "at rest");
    return page.evaluate(() => studio.events.map((one, which) => ({ ...one, speed: studio.hammerSpeedOf(which) })));
  };
  if (link.includes("front_punching")) {
    const [f] = await over({ nuance: "f", struck: false });
    claim("aftertouch", (value) => f.impact_count === value, f.impact_count);
  } else if (link.includes("hammer")) {
    const [a, b] = await over({ csv: "time_s,force_N\n0,0\n0.012,5\n0.3,5\n0.31,0", name: "5 N" });
    const mass = await page.evaluate(() => studio.loaded.map(({ setting, dials }) => setting.turns.hammer ?? dials.find(({ name }) => name === "hammer").value));
    claim("heavy", (value) => Math.abs(mass[1] - mass[0] - value) < 0.5 && b.speed < 0.97 * a.speed && b.hammer_contact_s - b.key_start_s > a.hammer_contact_s - a.key_start_s, `${mass}; ${a.speed} and ${b.speed} m/s`);
  } else {
    const [ff] = await over({ nuance: "ff", struck: false }), [pp] = await over({ nuance: "pp", struck: false });
    claim("key-first", (value) => ff.key_bottom_after_impact_s < value, ff.key_bottom_after_impact_s);
    claim("hammer-first", (value) => pp.key_bottom_after_impact_s > value, pp.key_bottom_after_impact_s);
  }
  await page.context().close();
};
