// Builds the page into site/: static files for any web space. The engine and the first picture are in built/, which
// `studio/wasm` fills.
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { defineConfig, type Plugin } from "vite";
import { addressOf, EXAMPLES } from "./src/page/examples.js";

/** What the page may do: nothing but itself. */
export const POLICY = [
  "default-src 'none'", "script-src 'self' 'wasm-unsafe-eval'", "worker-src 'self'", "connect-src 'self'", "style-src 'self'", "img-src 'self' data: blob:",
  "manifest-src 'self'", "base-uri 'none'", "form-action 'none'",
].join("; ");

const built = (name: string) => readFileSync(new URL(`./built/${name}`, import.meta.url));

const page = (name: string) => readFileSync(new URL(`./${name}`, import.meta.url));
/** The first picture, each path with the part that it belongs to: a style sheet can colour it before any script
 * runs. */
const picture = () => built("picture.svg").toString().trim().replace(
  /<path ([^>]*)><title>([^<]*)<\/title><\/path>/g,
  (_, path: string, name: string) => `<path ${path} data-part="${name.split(",")[0]!.trim()}" data-detail="${name}"/>`,
);
/** The same for the story, which colours it itself: without inks, and to a tenth of a millimetre, for the first picture
 * waits for every byte of it. */
const plain = () => picture()
  .replace(/<defs>.*<\/defs>/s, "")
  .replace(/ (fill|stroke)="[^"]*"/g, "").replace(/ data-detail="[^"]*"/g, "")
  .replace(/-?\d+\.\d{2,}/g, (number) => String(Number(Number(number).toFixed(1)) + 0))
  .replace(/(-?[\d.]+ -?[\d.]+)(?:L\1(?![\d.]))+/g, "$1");

/** The cards of the gallery: a picture and a title, one click from the workbench. */
const cards = () => {
  const drawn = JSON.parse(built("pictures.json").toString()) as Record<string, string>;
  return EXAMPLES.map((example) => `<li><a href="./tools.html#${addressOf(example).replaceAll("&", "&amp;")}">${drawn[example.id]}<span>${example.title}</span></a></li>`).join("\n");
};

/** Scripts are asked for once the page itself is here: before, they would share the line with the first picture. */
const last = (html: string) => {
  const scripts = html.match(/<script type="module"[^>]*src=[^>]*><\/script>|<link rel="modulepreload"[^>]*>/g) ?? [];
  return scripts.reduce((rest, one) => rest.replace(one, ""), html).replace("</body>", `${scripts.join("\n")}\n</body>`);
};

/** The policy, the first picture, the engine, and a service worker that keeps all of it for when there is no
 * network. */
const studio = (): Plugin => ({
  name: "studio",
  transformIndexHtml: {
    order: "post",
    handler: (html, { server, path }) => {
      const policy = server ? "" : `<meta http-equiv="Content-Security-Policy" content="${POLICY}">`;
      html = last(html);
      // Of the page's own folder. With this word, a page that is opened as a file would have no style.
      html = html.replaceAll('<link rel="stylesheet" crossorigin', '<link rel="stylesheet"');
      return html.replace("<!--policy-->", policy).replace("<!--examples-->", cards).replace("<!--picture-->", path.endsWith("tools.html") ? picture() : plain());
    },
  },
  configureServer(server) {
    server.middlewares.use((request, answer, next) => {
      if (request.url?.split("?")[0] !== "/engine.bin") return next();
      answer.setHeader("Content-Type", "application/octet-stream");
      answer.end(built("engine.bin"));
    });
  },
  // After the pages have taken in the scripts that only load another one: those files do not exist.
  generateBundle: {
    order: "post",
    handler(_, bundle) {
      this.emitFile({ type: "asset", fileName: "engine.bin", source: built("engine.bin") });
      const files = ["./", "tools.html", "action.html", "engine.bin", "icon.svg", "studio.webmanifest", ...Object.keys(bundle).filter((name) => !name.endsWith(".html") && name !== "engine.bin")];
      const version = createHash("sha256").update(built("engine.bin")).update(Object.keys(bundle).join()).update(built("picture.svg")).update(built("pictures.json")).update(page("index.html")).update(page("tools.html")).update(page("action.html")).digest("hex").slice(0, 16);
      const source = readFileSync(new URL("./src/sw.js", import.meta.url), "utf8").replace("/*version*/", version).replace("/*files*/", files.map((name) => JSON.stringify(name)).join(", "));
      this.emitFile({ type: "asset", fileName: "sw.js", source });
    },
  },
});

export default defineConfig({
  base: "./",
  plugins: [studio()],
  build: { rolldownOptions: { input: ["index.html", "tools.html", "action.html"] }, target: "es2022", outDir: "site", emptyOutDir: true, assetsInlineLimit: 0, modulePreload: { polyfill: false }, reportCompressedSize: false },
  worker: { format: "es" },
  preview: { headers: { "Content-Security-Policy": POLICY } },
});
