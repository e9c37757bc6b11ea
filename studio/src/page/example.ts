// The example that is shown: what there is to see, the same again, and the next one.
import type { App } from "./app";
import { byId, h } from "./dom";
import { addressOf, type Example, EXAMPLES, exampleOf } from "./examples";
import { named } from "./terms";

const titleOf = ({ id, title }: Example) => named(h("span"), `example.${id}`, title);

export const exampleStrip = (app: App): void => {
  const place = byId("example"), title = h("b"), see = h("span");
  const again = named(h("button", { type: "button", id: "example-again", onclick: () => app.perform() }), "play.again");
  const next = h("a", { id: "example-next" });
  const close = h("button", { type: "button", class: "back", "aria-label": "Close the example", onclick: () => void app.change({ example: "" }) }, "\u00d7");
  place.append(h("p", {}, title, " ", see), h("div", { class: "row" }, again, next, named(h("a", { href: "./index.html#examples" }), "example.all"), close));
  let told = "";
  app.onchange.push(() => {
    const shown = exampleOf(app.state.example);
    place.hidden = !shown;
    if (!shown || told === shown.id) return;
    told = shown.id;
    const after = EXAMPLES[(EXAMPLES.indexOf(shown) + 1) % EXAMPLES.length]!;
    title.replaceChildren(titleOf(shown), ".");
    see.textContent = shown.see;
    next.href = `#${addressOf(after)}`;
    next.replaceChildren(named(h("span"), "example.next"), ": ", titleOf(after));
  });
};
