// The same bits in the page as from `press`: ten strokes, every row.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

/** A run's rows of angles, key and hammer, as `press` wrote them; its numbers read back to the bit. */
const rowsOf = (text) => {
  const [head, ...lines] = text.trim().split("\n");
  const titles = head.split(",");
  const angles = titles.map((title, column) => [title, column]).filter(([title]) => title.endsWith("_rad")).map(([, column]) => column);
  const columns = [titles.indexOf("key_m"), titles.indexOf("hammer_rise_m"), ...angles];
  return lines.map((line) => {
    const cells = line.split(",");
    return columns.map((column) => Number(cells[column]));
  });
};

export const bits = async ({ visit }) => {
  const work = mkdtempSync(join(tmpdir(), "erard-bits-"));
  let compared = 0;
  try {
    const page = await visit();
    const worker = page.workers().find((one) => one.url().includes("player"));
    assert(worker, "the player's worker");
    for (const nuance of ["pp", "p", "mf", "f", "ff"]) {
      for (const touch of ["pressed", "struck"]) {
        execFileSync(process.env.ERARD, ["press", "--stroke", nuance, "--touch", touch, "--out", join(work, "run"), "--force", "--quiet"]);
        const native = rowsOf(readFileSync(join(work, "run", "run.csv"), "utf8"));
        const found = await worker.evaluate(({ nuance, struck, rows }) => {
          const { library } = globalThis.player;
          const { raw } = library;
          const instrument = raw.erard_instrument_new(0, 0, 0);
          const action = raw.erard_action_of_instrument(instrument, 50e-6, 0);
          const stroke = library.given(nuance, (at) => raw.erard_stroke_builtin(instrument, at, struck, 0));
          const bodies = raw.erard_action_body_count(action);
          const reading = library.struct(112), angles = raw.erard_memory_new(8 * bodies);
          raw.erard_action_record_contacts(action);
          raw.erard_action_read(action, reading);
          const all = new Float64Array(rows * (2 + bodies));
          for (let row = 0; row < rows; row++) {
            if (row > 0 && raw.erard_action_step_stroke(action, stroke, reading) < 0) throw new Error("a step failed");
            raw.erard_action_angles(action, angles, bodies);
            const numbers = library.f64(reading + 8, 6);
            all[row * (2 + bodies)] = numbers[1];
            all[row * (2 + bodies) + 1] = numbers[5];
            all.set(library.f64(angles, bodies), row * (2 + bodies) + 2);
          }
          raw.erard_stroke_free(stroke);
          raw.erard_action_free(action);
          raw.erard_instrument_free(instrument);
          raw.erard_memory_free(reading, 112);
          raw.erard_memory_free(angles, 8 * bodies);
          return { width: 2 + bodies, all: [...new BigUint64Array(all.buffer)].map((word) => word.toString(16)).join(" ") };
        }, { nuance, struck: touch === "struck" ? 1 : 0, rows: native.length });
        assert.equal(native[0].length, found.width, "columns");
        const words = [...new BigUint64Array(Float64Array.from(native.flat()).buffer)];
        const theirs = found.all.split(" ");
        words.forEach((word, at) => {
          if (word.toString(16) !== theirs[at]) assert.fail(`${nuance} ${touch}: row ${Math.floor(at / found.width)}, number ${at % found.width}: ${theirs[at]} and not ${word.toString(16)}`);
        });
        compared += native.length;
      }
    }
  } finally {
    rmSync(work, { recursive: true, force: true });
  }
  return `${compared} rows of ten strokes, the same bits`;
};
