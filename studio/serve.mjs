// node serve.mjs [PORT] [FOLDER]: serves the built page on this machine only. Any web server does: the files are
// static.
import { createReadStream } from "node:fs";
import { stat } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml", ".webmanifest": "application/manifest+json", ".bin": "application/octet-stream" };
/** The same as in the page itself (vite.config.ts); workers take theirs from here. */
const POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'; style-src 'self'; img-src 'self' data: blob:; manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/** Serves a folder; resolves to the server, once it listens. */
export const serve = (port, folder = fileURLToPath(new URL("site", import.meta.url))) => {
  const server = createServer(async (request, answer) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
    const file = join(folder, path.endsWith("/") ? `${path}index.html` : path);
    const found = file.startsWith(folder) && (request.method === "GET" || request.method === "HEAD") && (await stat(file).catch(() => null));
    if (!found || !found.isFile()) {
      answer.writeHead(404).end();
      return;
    }
    answer.writeHead(200, {
      "Content-Type": TYPES[extname(file)] ?? "application/octet-stream", "Content-Length": found.size, "Content-Security-Policy": POLICY,
      "X-Content-Type-Options": "nosniff", "Cache-Control": "no-cache",
    });
    if (request.method === "HEAD") answer.end();
    else createReadStream(file).pipe(answer);
  });
  return new Promise((resolve, reject) => server.once("error", reject).listen(port, "127.0.0.1", () => resolve(server)));
};

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const port = Number(process.argv[2] ?? 8088);
  const server = await serve(port, process.argv[3]).catch((error) => {
    console.error(`port ${process.argv[2] ?? 8088} cannot be opened: ${error.code ?? error.message}; studio/run NUMBER takes another, 0 any that is free`);
    process.exit(2);
  });
  console.log(`the studio is at http://localhost:${server.address().port}/ (Ctrl-C ends it)`);
}
