// A small curve over time.
import {h, say, svg} from "./dom";

const width = 240, height = 48;

export class Chart {
  readonly element: HTMLElement;
  private readonly now = h("span", {class: "number"}, "–");
  private readonly most = h("span", {class: "sub"}, "\u00a0");
  private readonly area = svg("path", {class: "area"});
  private readonly line = svg("path", {class: "line", "vector-effect": "non-scaling-stroke"});

  constructor(title: string, since: string) {
    this.element = h("figure", {class: "chart"},
      h("figcaption", {}, h("span", {}, title), this.now),
      svg("svg", {viewBox: `0 0 ${width} ${height}`, preserveAspectRatio: "none", "aria-hidden": "true"}, this.area, this.line),
      h("p", {class: "axis"}, h("span", {class: "sub"}, since), this.most));
  }

  // `values` at equal or growing `times`; `least` is what the top of the picture stands for at least.
  update(times: number[], values: number[], least: number, words: (value: number) => string,
         now = words(values.at(-1) ?? 0)): void {
    if (values.length === 0) return;
    const top = Math.max(least, ...values) || 1;
    const from = times[0], span = times[times.length - 1] - from || 1;
    const points = values.map((value, i) =>
      `${((times[i] - from) / span * width).toFixed(1)} ${(height - 1 - value / top * (height - 2)).toFixed(1)}`);
    if (points.length === 1) points.push(points[0].replace(/^\S+/, String(width)));
    this.line.setAttribute("d", `M${points.join("L")}`);
    this.area.setAttribute("d", `M0 ${height}L${points.join("L")}L${width} ${height}Z`);
    say(this.now, now);
    say(this.most, `at most ${words(Math.max(...values))}`);
  }
}
