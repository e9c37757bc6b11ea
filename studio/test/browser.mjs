// A real browser and the built page, for the tests.
import { chromium } from "playwright-core";
import { serve } from "../serve.mjs";

const WHERE = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

/** Opens the built pages in a browser of its own: `visit` the workbench, `read` the story. Every error, refused request
 * and request to elsewhere is collected in
 * `faults`. */
export const open = async () => {
  const server = await serve(0);
  const address = `http://localhost:${server.address().port}/`;
  const { existsSync } = await import("node:fs");
  const executablePath = process.env.CHROMIUM || WHERE.find((path) => existsSync(path));
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--enable-precise-memory-info", "--js-flags=--expose-gc"] });
  const faults = [];
  const go = async (path, options = {}) => {
    const context = await browser.newContext({ acceptDownloads: true, viewport: { width: 1440, height: 900 }, ...options });
    const page = await context.newPage();
    page.setDefaultTimeout(60_000);
    page.on("pageerror", (error) => faults.push(`error: ${error.message}`));
    page.on("console", (message) => message.type() === "error" && faults.push(`console: ${message.text()}`));
    page.on("request", (request) => {
      if (!request.url().startsWith(address) && !/^(blob|data):/.test(request.url())) faults.push(`a request to ${request.url()}`);
    });
    await page.goto(address + path);
    if (options.javaScriptEnabled !== false) await page.waitForSelector("html[data-ready=true]");
    return page;
  };
  const visit = (hash = "", options = {}) => go(`tools.html${hash}`, options);
  const read = (hash = "", options = {}) => go(hash, options);
  return { address, browser, server, faults, visit, read, close: async () => { await browser.close(); server.close(); } };
};
