// What lies over the picture: how long something in its middle is, and the triangle that was clicked at, however small.
import {h, svg} from "./dom";
import {withUnit} from "./format";

const longestBar = 140, smallTriangle = 24, ringRadius = 14;  // in pixels

export class Overlay {
  private readonly bar = h("span", {class: "scale-bar", "aria-hidden": "true"});
  private readonly words = h("span", {class: "number"});
  private readonly scale = h("p", {class: "scale", role: "img"}, this.words, this.bar);
  private readonly triangle = svg("polygon", {class: "chosen"});
  private readonly ring = svg("circle", {class: "chosen-ring", r: ringRadius});
  private readonly picture = svg("svg", {class: "marks", "aria-hidden": "true"}, this.ring, this.triangle);

  constructor(stage: HTMLElement, private readonly unit: string) {
    this.scale.hidden = true;
    stage.append(this.picture, this.scale);
    this.mark([]);
  }

  // `length`: of a pixel in the middle of the picture.
  measure(length: number): void {
    this.scale.hidden = !(Number.isFinite(length) && length > 0);
    if (this.scale.hidden) return;
    const most = longestBar * length, step = 10 ** Math.floor(Math.log10(most));
    const round = [5, 2, 1].map(times => times * step).find(value => value <= most) ?? step;
    const text = withUnit(round, this.unit || "units", 12);
    if (this.words.textContent !== text) {
      this.words.textContent = text;
      this.scale.setAttribute("aria-label", `Scale: in the middle of the picture the bar is ${text} long`);
    }
    this.bar.style.width = `${round / length}px`;
  }

  // Corners in pixels from the upper left; none takes the mark away.
  mark(corners: [number, number][]): void {
    this.picture.toggleAttribute("hidden", corners.length === 0);
    if (corners.length === 0) return;
    this.triangle.setAttribute("points", corners.map(at => at.map(value => value.toFixed(2)).join(",")).join(" "));
    const [left, top] = [0, 1].map(axis => Math.min(...corners.map(at => at[axis])));
    const [right, low] = [0, 1].map(axis => Math.max(...corners.map(at => at[axis])));
    // A triangle of a few pixels is lost on the surface without it.
    this.ring.toggleAttribute("hidden", Math.max(right - left, low - top) > smallTriangle);
    this.ring.setAttribute("cx", ((left + right) / 2).toFixed(2));
    this.ring.setAttribute("cy", ((top + low) / 2).toFixed(2));
  }
}
