// The story: its text is the page, its figures come to life one at a time, where one looks.
import { engine } from "../engine/load";
import { byId, h } from "../page/dom";
import { Figure } from "./figure";
import { Live } from "./live";
import { STEPS } from "./scenes";

// Scripts run here, so that nothing is missing.
document.getElementById("still")?.remove();

/** An address of the workbench, which stood here before. */
if (location.hash.includes("=") && !location.hash.includes("tab=learn")) location.replace(`./tools.html${location.hash}`);

const first = document.querySelector<SVGSVGElement>("svg.first")!;
const figures = [...document.querySelectorAll<HTMLElement>(".figure")].map((element) => new Figure(element, STEPS[element.dataset.scene!]!, first));
const links = [...document.querySelectorAll<HTMLAnchorElement>(".bar nav a")];
let live: Live | null = null;
let active: Figure | null = null;

const fault = (message: string): void => {
  const place = byId("fault");
  place.replaceChildren(`The pictures have stopped: ${message}. `, h("button", { type: "button", onclick: again }, "Start them again"));
  place.hidden = false;
};

const again = (): void => {
  byId("fault").hidden = true;
  const was = active;
  active = null;
  live?.restart();
  if (was) activate(was);
};

const activate = (figure: Figure): void => {
  if (active === figure || !live) return;
  active?.end();
  active = figure;
  figure.begin(live).then(() => (document.documentElement.dataset.ready = "true"), (error: unknown) => fault(error instanceof Error ? error.message : String(error)));
};

/** The figure that one looks at: the one nearest to the middle of the window. */
const choose = (): void => {
  const middle = innerHeight / 2;
  const far = (figure: Figure): number => {
    const { top, bottom } = figure.element.querySelector(".frame")!.getBoundingClientRect();
    return Math.abs((top + bottom) / 2 - middle);
  };
  const nearest = figures.reduce((best, one) => (far(one) < far(best) ? one : best));
  for (const link of links) {
    if (link.hash === `#${nearest.id}`) link.setAttribute("aria-current", "true");
    else link.removeAttribute("aria-current");
  }
  // A hand or the focus on a figure keeps it, while it is seen.
  if (active?.busy || (active?.element.contains(document.activeElement) && far(active) < innerHeight / 2)) return;
  activate(nearest);
};

let asked = false;
const soon = (): void => {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    choose();
  });
};
addEventListener("scroll", soon, { passive: true });
addEventListener("resize", soon);
for (const figure of figures) {
  for (const event of ["pointerdown", "focusin", "keydown"] as const) figure.element.addEventListener(event, () => activate(figure), { capture: true });
}
// A name in the text shows its part.
for (const name of document.querySelectorAll<HTMLElement>(".scene .p")) {
  const figure = name.closest(".scene")!.querySelector<HTMLElement>(".figure");
  name.addEventListener("pointerenter", () => figure && (figure.dataset.mark = name.classList[1]!));
  name.addEventListener("pointerleave", () => figure && delete figure.dataset.mark);
}
// For tests.
Object.assign(window, { story: { figures: Object.fromEntries(figures.map((figure) => [figure.id, figure])), steps: STEPS, get live() { return live; }, get active() { return active?.id; } } });

engine((share) => figures.forEach((figure) => figure.wait(`loading the model, ${Math.round(100 * share)} %`))).then((module) => {
  live = new Live(module);
  live.onfault = fault;
  choose();
}, (error: unknown) => fault(error instanceof Error ? error.message : String(error)));
if ("serviceWorker" in navigator && import.meta.env.PROD) void navigator.serviceWorker.register("./sw.js").catch(() => {});
