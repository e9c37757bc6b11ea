// node test/site.mjs FOLDER [--shots FOLDER] [--only WAY]: the site that dist/site assembled, in a real browser, four
// ways: https with a certificate of this machine, http on localhost, http on another name (where a browser keeps its
// service worker and clipboard to itself), and as files. Prints a line for each way; exit code 1 where one fails, 77
// without a browser.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, statSync } from "node:fs";
import { createServer as http } from "node:http";
import { createServer as https } from "node:https";
import { tmpdir } from "node:os";
import { extname, join, normalize } from "node:path";
import { pathToFileURL } from "node:url";
import { parseArgs } from "node:util";
import { chromium } from "playwright-core";

const { values: asked, positionals } = parseArgs({ allowPositionals: true, options: { shots: { type: "string" }, only: { type: "string" } } });
const site = normalize(positionals[0] ?? "").replace(/\/$/, "");
if (!existsSync(join(site, "index.html"))) {
  console.error("error: site.mjs: expected a folder that dist/site made");
  process.exit(2);
}
const executablePath = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((path) => path && existsSync(path));
if (!executablePath) {
  console.log("not run: there is no Chromium here");
  process.exit(77);
}
if (asked.shots) mkdirSync(asked.shots, { recursive: true });

// As simple as a server can be: no header but the type.
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml", ".json": "application/json", ".txt": "text/plain", ".webmanifest": "application/manifest+json", ".woff2": "font/woff2", ".png": "image/png" };
const answer = (request, to) => {
  const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname)), file = join(site, path.endsWith("/") ? `${path}index.html` : path);
  if (!file.startsWith(site) || !existsSync(file) || !statSync(file).isFile()) return to.writeHead(404).end();
  to.writeHead(200, { "Content-Type": TYPES[extname(file)] ?? "application/octet-stream" });
  to.end(readFileSync(file));
};
const work = mkdtempSync(join(tmpdir(), "erard-site-"));
execFileSync("openssl", ["req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost", "-keyout", join(work, "key"), "-out", join(work, "certificate")], { stdio: "ignore" });
const servers = [http(answer), https({ key: readFileSync(join(work, "key")), cert: readFileSync(join(work, "certificate")) }, answer)];
const [plain, safe] = await Promise.all(servers.map((server) => new Promise((resolve) => server.listen(0, "127.0.0.1", () => resolve(server.address().port)))));
// A name that is not localhost, at this machine: what a page on a plain server is. A service worker asks for its script
// by itself, and needs the certificate to be accepted by the browser, not by the page.
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--host-resolver-rules=MAP piano.example 127.0.0.1", "--ignore-certificate-errors"] });

const WAYS = {
  https: `https://localhost:${safe}/`,
  localhost: `http://localhost:${plain}/`,
  "a plain server": `http://piano.example:${plain}/`,
  file: `${pathToFileURL(site).href}/`,
};

const way = async (name, root) => {
  const served = name !== "file", secure = served && name !== "a plain server";
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 } });
  const faults = [];
  const go = async (path) => {
    const page = await context.newPage();
    page.setDefaultTimeout(90_000);
    page.on("pageerror", (error) => faults.push(`${path}: ${error.message}`));
    page.on("console", (message) => message.type() === "error" && faults.push(`${path}: ${message.text()}`));
    page.on("request", (request) => {
      if (!request.url().startsWith(root) && !/^(blob|data):/.test(request.url())) faults.push(`${path}: a request to ${request.url()}`);
    });
    await page.goto(root + path);
    return page;
  };
  const shot = async (page, what) => asked.shots && page.screenshot({ path: join(asked.shots, `${name.replaceAll(" ", "-")}-${what}.png`) });
  const told = [];

  // The front: one key, live where there is a server.
  const front = await go("index.html"), frame = front.frames().find((one) => one.url().endsWith("action.html"));
  assert.ok(frame, "the front has no frame");
  if (served) {
    await frame.waitForSelector("html[data-ready=true]");
    const grip = frame.locator(".grip");
    await grip.focus();
    for (let n = 0; n < 10; n++) await grip.press("ArrowDown");
    await frame.waitForFunction(() => Number.parseFloat(document.querySelectorAll(".facts dd")[1]?.textContent) > 20);
    told.push(`the key is down ${await frame.locator(".facts dd").nth(0).textContent()}, the hammer up ${await frame.locator(".facts dd").nth(1).textContent()}`.replaceAll("\u00a0", " "));
    assert.equal(await frame.locator("#still").count(), 0);
  } else {
    await frame.waitForFunction(() => getComputedStyle(document.getElementById("still")).opacity === "1");
    assert.ok(await frame.locator("svg.first").isVisible(), "no still picture");
    assert.notEqual(await frame.locator("svg.first .parts path").first().evaluate((path) => getComputedStyle(path).fill), "rgb(0, 0, 0)", "the picture has no colours");
    told.push("the front shows its picture and says what is missing");
  }
  await shot(front, "front");

  // Story and workbench.
  for (const [path, ready] of [["studio/index.html", "html[data-ready=true]"], ["studio/tools.html", "html[data-ready=true]"]]) {
    const page = await go(path);
    if (served) {
      await page.waitForSelector(ready);
      assert.equal(await page.locator("#still").count(), 0);
    } else {
      await page.waitForFunction(() => getComputedStyle(document.getElementById("still")).opacity === "1");
      assert.match(await page.locator("#still").innerText(), /erard studio/);
    }
    await shot(page, path.split("/")[1].replace(".html", ""));
    if (path.endsWith("tools.html")) {
      assert.equal(await page.evaluate(() => isSecureContext), secure || !served);
      if (secure) await page.waitForFunction(async () => (await navigator.serviceWorker.getRegistration())?.active, undefined, { polling: 500 });
      else if (served) assert.equal(await page.evaluate(() => "serviceWorker" in navigator), false);
      told.push(secure ? "kept for offline use" : served ? "not kept for offline use" : "story and workbench say what is missing");
    }
    await page.close();
  }

  // A page of the command moves by itself, however it comes.
  const moving = await go("gallery/press/run.html"), picture = () => moving.evaluate(() => document.querySelector("svg").innerHTML.length + [...document.querySelectorAll("input[type=range]")].map((one) => one.value).join());
  const before = await picture();
  const slider = moving.locator("input[type=range]").first();
  await slider.focus();
  for (let n = 0; n < 5; n++) await slider.press("ArrowRight");
  assert.notEqual(await picture(), before, "the page of a press does not move");
  await shot(moving, "gallery");

  // Text: chapters, references, downloads.
  for (const [path, word] of [["gallery/index.html", "Gallery"], ["book/index.html", "Erard"], ["book/real.html", "real"], ["reference/index.html", "erard.h"], ["downloads/index.html", "Nothing is signed"]]) {
    const page = await go(path);
    assert.match(await page.locator("body").innerText(), new RegExp(word, "i"), path);
    await shot(page, path.replace("/", "-").replace(".html", ""));
    await page.close();
  }
  await context.close();
  // What a browser says of scripts and the model that it does not load from files is what the line is for.
  const expected = served ? [] : [/from origin 'null' has been blocked by CORS policy/, /Failed to load resource: net::ERR_FAILED/, /Content Security Policy/, /Unsafe attempt to load URL/];
  const wrong = faults.filter((one) => !expected.some((pattern) => pattern.test(one)));
  assert.deepEqual(wrong, []);
  return told.join("; ");
};

let failed = 0;
for (const [name, root] of Object.entries(WAYS).filter(([one]) => !asked.only || one === asked.only)) {
  try {
    console.log(`passed   ${name}: ${await way(name, root)}`);
  } catch (error) {
    failed = 1;
    console.log(`FAILED   ${name}: ${error.message}`);
  }
}
await browser.close();
for (const server of servers) server.close();
rmSync(work, { recursive: true });
process.exit(failed);
