// The engine's file, fetched and compiled; knows nothing of pages.

/** The engine's bytes, packed or not, whatever a server makes of them. `progress` receives which share of them is
 * here. */
export const engine = async (progress: (share: number) => void = () => {}): Promise<WebAssembly.Module> => {
  const answer = await fetch(new URL("engine.bin", document.baseURI));
  if (!answer.ok) throw new Error(`the engine is not where the page expects it: ${answer.url} answers ${answer.status}`);
  const all = Number(answer.headers.get("Content-Length")), pieces: Uint8Array<ArrayBuffer>[] = [];
  let here = 0;
  for (const reader = answer.body!.getReader(); ; ) {
    const { done, value } = await reader.read();
    if (done) break;
    pieces.push(value);
    here += value.length;
    // A server that packs the answer says how long the packed one is.
    if (all > 0) progress(Math.min(here / all, 1));
  }
  const bytes = new Uint8Array(await new Blob(pieces).arrayBuffer());
  if (bytes[0] !== 0x1f) return WebAssembly.compile(bytes);
  const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return WebAssembly.compileStreaming(new Response(unpacked, { headers: { "Content-Type": "application/wasm" } }));
};
