// The curves of the last second: travels and forces, of one action or of two, or what differs between two.
import uPlot from "uplot";
import { h } from "./dom";
import { called, onlanguage, speaks } from "./terms";

export interface Curves {
  times: Float64Array;
  /** For every action: key mm, hammer mm, finger N, string N. */
  series: Float64Array[][];
}

const ROWS = [
  { title: "curve.travel", of: [0, 1], names: ["curve.key", "curve.hammer"], least: 12 },
  { title: "curve.force", of: [2, 3], names: ["curve.finger", "curve.string"], least: 2 },
] as const;

export class CurvePanel {
  private plots: uPlot[] = [];
  private made = "";
  private readonly into: HTMLElement;
  onseek: (time: number) => void = () => {};

  constructor(into: HTMLElement) {
    this.into = into;
    new ResizeObserver(() => this.fit()).observe(into);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (this.made = ""));
    onlanguage.push(() => (this.made = ""));
  }

  private size(): { width: number; height: number } {
    const columns = this.into.clientWidth > 620 ? 2 : 1;
    return { width: Math.max(Math.floor(this.into.clientWidth / columns) - 4, 160), height: 150 };
  }

  private fit(): void {
    for (const plot of this.plots) plot.setSize(this.size());
  }

  private make(names: string[], difference: boolean): void {
    this.plots.forEach((plot) => plot.destroy());
    const style = getComputedStyle(document.documentElement);
    const colour = (name: string) => style.getPropertyValue(name).trim();
    const inks = [[colour("--curve-key"), colour("--curve-hammer")], [colour("--touch"), colour("--arrow")]];
    this.into.replaceChildren();
    this.plots = ROWS.map((row, index) => {
      const shown = difference ? ["B \u2212 A"] : names;
      const series = shown.flatMap((whose, action) =>
        row.names.map((name, k) => ({
          label: shown.length > 1 || difference ? `${called(name).text}, ${whose}` : called(name).text,
          stroke: inks[index]![k]!,
          width: 1.5,
          dash: action > 0 || difference ? [6, 3] : [],
          value: (_: uPlot, value: number | null) => (value === null || Number.isNaN(value) ? "\u2013" : value.toFixed(2)),
        })));
      const axis = { stroke: colour("--soft"), grid: { stroke: colour("--grid"), width: 1 }, ticks: { stroke: colour("--grid"), width: 1 } };
      const title = called(row.title), into = h("div", { class: "plot", role: "img", "aria-label": title.text });
      speaks(into, title.lang);
      this.into.append(into);
      const plot = new uPlot({
        ...this.size(),
        title: title.text,
        scales: {
          x: { time: false },
          // What rests is a line at the foot, not noise as tall as the plot.
          y: { range: (_, low, high) => [Math.min(low ?? 0, 0) * 1.05, Math.max(high ?? 0, difference ? 0.1 : row.least) * 1.05] },
        },
        axes: [
          { ...axis, size: 28, label: "ms", labelSize: 14, labelFont: "11px system-ui, sans-serif", labelGap: -1, values: (_, ticks) => ticks.map((tick) => `${Number((1e3 * tick).toFixed(2))}`) },
          { ...axis, size: 42 },
        ],
        // Whose curve it is shows in the legend as in the plot: B's is broken.
        legend: { live: false, markers: { dash: (_, index) => (series[index - 1]?.dash.length ? "dashed" : "solid") } },
        cursor: { drag: { x: false, y: false }, points: { show: false }, y: false },
        series: [{ label: "ms" }, ...series],
        hooks: {
          ready: [(made) => made.over.addEventListener("pointerdown", (event) => {
            const seek = (at: PointerEvent) => this.onseek(made.posToVal(at.clientX - made.over.getBoundingClientRect().left, "x"));
            seek(event);
            made.over.setPointerCapture(event.pointerId);
            made.over.onpointermove = seek;
            made.over.onpointerup = made.over.onpointercancel = () => (made.over.onpointermove = null);
          })],
        },
      }, [[], ...series.map(() => [])] as unknown as uPlot.AlignedData, into);
      return plot;
    });
  }

  draw(curves: Curves, names: string[], difference: boolean, at: number | null): void {
    difference &&= curves.series.length > 1;
    const made = `${names.join("|")} ${difference}`;
    if (made !== this.made) {
      this.make(names, difference);
      this.made = made;
    }
    ROWS.forEach((row, index) => {
      const data = difference
        ? row.of.map((k) => curves.series[1]![k]!.map((value, n) => value - curves.series[0]![k]![n]!))
        : curves.series.flatMap((series) => row.of.map((k) => series[k]!));
      // uPlot knows gaps as null, not as NaN.
      const gaps = data.map((series) => Array.from(series, (value) => (Number.isNaN(value) ? null : value)));
      const plot = this.plots[index]!;
      plot.setData([curves.times, ...gaps] as unknown as uPlot.AlignedData);
      const left = at === null ? -10 : plot.valToPos(at, "x");
      plot.setCursor({ left, top: 10 }, false);
    });
  }
}
