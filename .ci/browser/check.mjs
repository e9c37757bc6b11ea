// Checks pages in a real browser: nothing overflows on a phone, no error, axe finds nothing, and run.html does what it
// says. Usage: node check.mjs PAGE.html... ; the page called run.html gets the checks of a run.
import { chromium } from 'playwright-core';
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { basename, dirname, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const axe = await readFile(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox'] });
let faults = 0;
const fail = (page, what) => { faults++; console.log(`FAIL ${page}: ${what}`); };
const expect = (page, holds, what) => { if (!holds) fail(page, what); };

const visit = async (path, hash, options, look) => {
  const context = await browser.newContext({ bypassCSP: true, acceptDownloads: true, ...options });
  const page = await context.newPage();
  page.on('pageerror', (error) => fail(path, error.message));
  page.on('console', (message) => message.type() === 'error' && fail(path, message.text()));
  await page.goto(pathToFileURL(resolve(path)) + hash);
  await page.waitForTimeout(200);
  await look(page);
  await context.close();
};

const run = async (path) => {
  const desk = { viewport: { width: 1400, height: 900 } };
  // Felts are dented: while the hammer is at the string its felt ends where the string begins, and is as drawn before
  // and after. The summary beside the page knows when it is there.
  const summary = JSON.parse(await readFile(resolve(dirname(path), 'summary.json'), 'utf8'));
  const { hammer_contact_s: struck } = summary.runs?.[0] ?? summary;
  await visit(path, '#shown=0.06,0.09', desk, async (page) => {
    const seen = await page.evaluate((struck) => {
      const part = (name) => [...document.querySelectorAll('[data-action="0"] .parts > path')].find((e) => e.querySelector('title')?.textContent === name);
      const felt = part('hammer felt'), string = part('string');
      if (!felt || !string) return null;
      const drawn = felt.getAttribute('d'), picture = document.getElementById('action').getScreenCTM().inverse();
      const heights = (e) => {
        const at = picture.multiply(e.getScreenCTM()), length = e.getTotalLength();
        return Array.from({ length: 2000 }, (_, k) => e.getPointAtLength((k * length) / 2000).matrixTransform(at).y);
      };
      const below = Math.max(...heights(string)), slider = document.getElementById('time');
      const into = () => below - Math.min(...heights(felt));
      let [dented, rigid, changed] = [-Infinity, -Infinity, 0];
      for (let t = struck; t < struck + 3e-3; t += 2e-4) {
        slider.value = t;
        slider.dispatchEvent(new Event('input'));
        dented = Math.max(dented, into());
        const now = felt.getAttribute('d');
        changed += now !== drawn;
        felt.setAttribute('d', drawn);
        rigid = Math.max(rigid, into());
        felt.setAttribute('d', now);
      }
      slider.value = 0.085;
      slider.dispatchEvent(new Event('input'));
      return { dented, rigid, changed, back: felt.getAttribute('d') === drawn };
    }, struck);
    if (!seen) return;
    expect(path, seen.rigid > 0.3 && seen.dented < 0.02, `the hammer's felt ends at the string: ${JSON.stringify(seen)}`);
    expect(path, seen.changed > 3 && seen.back, `felts are dented while they are pressed, and no longer: ${JSON.stringify(seen)}`);
  });
  await visit(path, '#t=0.053&shown=0.02,0.08&view=60,-200,250,180&names=1&beside=0', desk, async (page) => {
    const state = await page.evaluate(() => ({
      slider: [+document.getElementById('time').min, +document.getElementById('time').max, +document.getElementById('time').value],
      view: document.getElementById('action').getAttribute('viewBox'),
      names: document.getElementById('naming').checked,
    }));
    const near = (a, b) => Math.abs(a - b) < 1e-6;
    expect(path, near(state.slider[0], 0.02) && near(state.slider[1], 0.08) && near(state.slider[2], 0.053), `the slider spans the window: ${state.slider}`);
    expect(path, state.view === '60.000 -200.000 250.000 180.000', `the link sets the view: ${state.view}`);
    expect(path, state.names, 'the link sets the names');
    // boxes of the numbers against the arrows, at many instants
    for (let k = 0; k <= 60; k++) {
      await page.evaluate((t) => {
        const slider = document.getElementById('time');
        slider.value = t;
        slider.dispatchEvent(new Event('input'));
      }, 0.02 + 0.001 * k);
      const crossed = await page.evaluate(() => {
        const shown = (element) => element.style.display !== 'none';
        const texts = [...document.querySelectorAll('#numbers text')].filter(shown);
        const arrows = [...document.querySelectorAll('#forces path')].filter(shown);
        let found = 0;
        for (const text of texts) {
          const box = text.getBBox();
          for (const other of texts) {
            if (other === text) continue;
            const b = other.getBBox();
            if (box.x < b.x + b.width && b.x < box.x + box.width && box.y + 0.2 * box.height < b.y + 0.8 * b.height && b.y + 0.2 * b.height < box.y + 0.8 * box.height) found++;
          }
          for (const arrow of arrows) {
            const [, x1, y1, , , x2, y2] = arrow.getAttribute('d').match(/M(\S+) (\S+)L(\S+) (\S+)M(\S+) (\S+)L/);
            for (let s = 0; s <= 1; s += 0.02) {
              const x = +x1 + s * (x2 - x1), y = +y1 + s * (y2 - y1);
              if (x > box.x && x < box.x + box.width && y > box.y + 0.2 * box.height && y < box.y + 0.8 * box.height) { found++; break; }
            }
          }
        }
        return found;
      });
      expect(path, crossed === 0, `${crossed} numbers are crossed at ${20 + k} ms`);
    }
    // names on the screen do not cover each other
    const covered = await page.evaluate(() => {
      const boxes = [...document.querySelectorAll('#names .label')].filter((e) => e.style.display !== 'none').map((e) => e.getBBox());
      return boxes.filter((a, i) => boxes.some((b, j) => j > i && a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height)).length;
    });
    expect(path, covered === 0, `${covered} names cover each other`);
    for (const [button, name, least] of [['save-png', 'action.png', 20_000], ['save-curves', 'curves.csv', 1000], ['save-summary', 'summary.csv', 100]]) {
      const [file] = await Promise.all([page.waitForEvent('download'), page.click(`#${button}`)]);
      const bytes = (await readFile(await file.path())).length;
      expect(path, file.suggestedFilename() === name && bytes > least, `${button} gives ${file.suggestedFilename()} of ${bytes} bytes`);
      if (process.env.KEEP) await file.saveAs(`${process.env.KEEP}/${name}`);
    }
    await page.click('#link');
    expect(path, page.url().includes('#t=') && page.url().includes('shown=0.02,0.08'), `the address holds the page: ${page.url()}`);
  });
  // who follows no link sees the whole action play once by itself; who wants less motion does not
  await visit(path, '', desk, async (page) => {
    const state = () => page.evaluate(() => ({
      playing: document.getElementById('play').textContent === 'Pause',
      wide: document.getElementById('action').viewBox.baseVal.width,
      time: +document.getElementById('time').value,
      end: +document.getElementById('time').max,
    }));
    const early = await state();
    await page.click('#whole');
    const whole = (await state()).wide;
    await page.waitForFunction(() => document.getElementById('play').textContent === 'Play', null, { timeout: 20_000 });
    const late = await state();
    const ended = (at) => Math.abs(at.time - at.end) < 1e-9;
    // A short run may be over before a busy machine looks.
    expect(path, (early.playing || ended(early)) && early.wide === whole && ended(late), `it plays once: ${JSON.stringify([early, whole, late])}`);
  });
  await visit(path, '', { ...desk, reducedMotion: 'reduce' }, async (page) => {
    expect(path, (await page.textContent('#play')) === 'Play', 'it keeps still where less motion is wanted');
  });
  // two actions side by side: one view each, the second moved by its length, and back again
  await visit(path, '#view=60,-200,250,180&beside=1', desk, async (page) => {
    const state = () => page.evaluate(() => ({
      box: document.getElementById('action').getAttribute('viewBox').split(' ').map(Number),
      moved: [...document.querySelectorAll('#action [data-action]')].map((group) => group.getAttribute('transform')),
      cut: [...document.querySelectorAll('#action [data-action]')].map((group) => group.hasAttribute('clip-path')),
      one: !document.getElementById('beside'),
    }));
    const apart = await state();
    if (apart.one) return;
    const wider = apart.box[2] > 500 || apart.box[3] > 360;
    expect(path, wider && apart.cut.every(Boolean) && /translate\((25\d|0\.000 18)/.test(apart.moved[1]), `side by side: ${JSON.stringify(apart)}`);
    await page.click('#beside');
    const over = await state();
    expect(path, over.box.join() === '60,-200,250,180' && !over.cut.some(Boolean) && over.moved[1] === 'translate(0.000 0.000)', `and back: ${JSON.stringify(over)}`);
  });
  // the forces of the pins can be switched off, and those of the contacts with them
  await visit(path, '#t=0.04', desk, async (page) => {
    const shown = (kind) => page.evaluate((kind) => [...document.querySelectorAll(`#forces .${kind}`)].filter((e) => e.style.display !== 'none').length, kind);
    if (!(await page.$('#pin-forces'))) return expect(path, (await shown('pin')) === 0, 'pins without a record');
    expect(path, (await shown('pin')) > 2, `${await shown('pin')} pins`);
    const contacts = await shown('contact');
    await page.click('#pin-forces');
    expect(path, (await shown('pin')) === 0 && (await shown('contact')) === contacts, 'the pins are switched off alone');
  });
  // two fingers, apart: the picture grows
  await visit(path, '#view=whole', { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true }, async (page) => {
    const wide = () => page.evaluate(() => +document.getElementById('action').getAttribute('viewBox').split(' ')[2]);
    const before = await wide();
    const { x, y, width, height } = await page.locator('#action').boundingBox();
    const session = await page.context().newCDPSession(page);
    const touch = (type, apart) => session.send('Input.dispatchTouchEvent', {
      type,
      touchPoints: apart ? [-1, 1].map((side, id) => ({ x: x + width / 2 + side * apart, y: y + height / 2, id })) : [],
    });
    await touch('touchStart', 20);
    for (const apart of [30, 45, 60, 80]) await touch('touchMove', apart);
    await touch('touchEnd', 0);
    const after = await wide();
    expect(path, after < 0.6 * before, `two fingers zoom: ${before} to ${after} mm`);
  });
};

// Smallest letters on the screen of each picture that has any, px, and what it is called.
const letters = () => {
  const least = (root, scale) => Math.min(...[...root.querySelectorAll('text')].filter((e) => e.textContent.trim()).map((e) => {
    const own = (node) => node && (node.style?.fontSize || node.getAttribute?.('font-size') || own(node.parentElement));
    return parseFloat(own(e)) * scale;
  }));
  const found = [...document.querySelectorAll('img[src^="data:image/svg+xml;base64,"]')].map((img) => {
    const bytes = Uint8Array.from(atob(img.src.split(',')[1]), (c) => c.charCodeAt(0));
    const svg = new DOMParser().parseFromString(new TextDecoder().decode(bytes), 'image/svg+xml').documentElement;
    return [least(svg, img.clientWidth / svg.viewBox.baseVal.width), img.alt];
  });
  for (const svg of document.querySelectorAll('.drawn svg')) found.push([least(svg, svg.getScreenCTM().a), svg.querySelector('title')?.textContent]);
  return found.filter(([least]) => Number.isFinite(least));
};

for (const path of process.argv.slice(2)) {
  if (basename(path) === 'run.html') await run(path);
  for (const [name, options] of [
    ['at a desk', { viewport: { width: 1400, height: 900 } }],
    ['on a phone', { viewport: { width: 390, height: 844 } }],
    ['at night', { viewport: { width: 1400, height: 900 }, colorScheme: 'dark' }],
    ['on a phone at night', { viewport: { width: 390, height: 844 }, colorScheme: 'dark' }],
  ]) {
    await visit(path, '', options, async (page) => {
      const over = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      expect(path, over <= 0, `${name}: ${over} px too wide`);
      for (const [least, what] of await page.evaluate(letters)) expect(path, least >= 8, `${name}: letters of ${least.toFixed(1)} px in ${what}`);
      await page.evaluate(axe);
      const { violations } = await page.evaluate(() => axe.run());
      for (const { id, help, nodes } of violations) {
        fail(path, `${name}: axe, ${id}: ${help} (${nodes.length}: ${nodes.slice(0, 3).map((node) => node.html.slice(0, 90)).join(' | ')})`);
      }
      if (options.colorScheme) {
        const light = await page.evaluate(() => getComputedStyle(document.body).backgroundColor.match(/\d+/g).slice(0, 3).every((c) => +c > 128));
        expect(path, !light, `${name}: the page is light`);
      }
    });
  }
  console.log(`looked at ${path}`);
}
await browser.close();
if (faults) process.exit(1);
console.log('pages: no fault');
