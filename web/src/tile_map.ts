// The tiles of a job as a map on which they light up. Only what has changed is drawn again.
import {Tiles} from "./api";
import {h, say, show} from "./dom";
import {count} from "./format";
import {MailArcs} from "./mail_arcs";
import {Plan, planOf} from "./tile_layout";

const stages: [string, string, string][] = [  // letter, property of the style sheet, word
  ["w", "--tile-waiting", "waiting"], ["t", "--tile-triangulated", "triangulated"], ["s", "--tile-splayed", "splayed"],
  ["q", "--tile-settled", "settled"], ["d", "--tile-stored", "stored"]];

const pointing = "Point at a tile to see which it is.";

export class TileMap {
  readonly element: HTMLElement;
  private readonly canvas = h("canvas", {role: "img", "aria-label": "Map of the tiles"});
  private readonly arcs = new MailArcs();
  private readonly sheet = h("div", {class: "sheet"}, this.canvas, this.arcs.picture);
  private readonly frame = h("div", {class: "frame"}, this.sheet);
  private readonly hint = h("p", {class: "sub hint"}, "The tiles are shown when the points are routed into them.");
  private readonly counts = new Map<string, HTMLElement>();
  private plan: Plan | null = null;
  private drawn = "";
  private stages = "";
  private colours = new Map<string, string>();
  private readonly resized = new ResizeObserver(() => this.redraw());
  private readonly scheme = matchMedia("(prefers-color-scheme: dark)");
  private readonly repaint = () => this.redraw();

  constructor() {
    const legend = h("ul", {class: "legend"}, ...stages.map(([letter, , word]) => {
      const number = h("span", {class: "number"}, "0");
      this.counts.set(letter, number);
      return h("li", {}, h("span", {class: `swatch tile-${letter}`, "aria-hidden": "true"}), `${word} `, number);
    }));
    this.element = h("div", {class: "map"}, legend, this.frame, this.arcs.words, this.hint);
    show(this.sheet, false);
    this.canvas.addEventListener("pointermove", event => this.point(event));
    this.canvas.addEventListener("pointerleave", () => this.plan && say(this.hint, pointing));
    this.resized.observe(this.frame);
    this.scheme.addEventListener("change", this.repaint);
    addEventListener("theme", this.repaint);
  }

  close(): void {
    this.resized.disconnect();
    this.scheme.removeEventListener("change", this.repaint);
    removeEventListener("theme", this.repaint);
  }

  // Whether the next tiles must come with how they lie.
  get needsLayout(): boolean { return this.plan === null; }

  update(tiles: Tiles): void {
    const told = tiles.stages ?? "";
    if (told === "") return;
    if (this.plan && told.length !== this.stages.length) this.plan = null;  // another run
    this.stages = told;
    if (!this.plan) {
      if (!tiles.layout) return;
      this.plan = planOf(tiles.layout, told.length);
      say(this.hint, pointing);
      show(this.sheet, true);
      this.redraw();
    } else {
      this.draw();
    }
    this.arcs.draw(tiles.mail, this.plan);
    this.tell();
  }

  // Nothing goes on any more.
  rest(): void {
    this.arcs.clear();
    this.tell();
  }

  private tell(): void {
    const numbers = new Map<string, number>();
    for (const letter of this.stages) numbers.set(letter, (numbers.get(letter) ?? 0) + 1);
    const words: string[] = [];
    for (const [letter, , word] of stages) {
      const number = numbers.get(letter) ?? 0;
      say(this.counts.get(letter)!, count(number));
      if (number) words.push(`${count(number)} ${word}`);
    }
    this.canvas.setAttribute("aria-label", `Map of the tiles: ${words.join(", ") || "none yet"}${this.arcs.said && `. ${this.arcs.said}`}`);
  }

  private redraw(): void {
    const style = getComputedStyle(this.element);
    this.colours = new Map(stages.map(([letter, property]) => [letter, style.getPropertyValue(property).trim()]));
    if (this.frame.clientWidth === 0 || !this.plan) return;
    // As large as the frame, which does not depend on it, has room for.
    const side = Math.floor(Math.min(this.frame.clientWidth, this.frame.clientHeight / this.plan.height));
    this.canvas.style.width = `${side}px`;
    this.canvas.style.height = `${Math.round(side * this.plan.height)}px`;
    const width = Math.round(this.canvas.clientWidth * Math.min(2, devicePixelRatio));
    const height = Math.round(this.canvas.clientHeight * Math.min(2, devicePixelRatio));
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    this.canvas.getContext("2d")!.clearRect(0, 0, width, height);
    this.drawn = "";
    this.draw();
  }

  private draw(): void {
    const pen = this.canvas.getContext("2d")!;
    const scale = this.canvas.width, all = this.plan!.rectangles;
    // A line between tiles as long as they are large enough to leave one.
    const gap = scale / Math.sqrt(this.stages.length) > 6 ? Math.max(1, Math.round(devicePixelRatio)) : 0;
    for (const [letter, colour] of this.colours) {
      pen.fillStyle = colour;
      for (let tile = 0; tile < this.stages.length; ++tile) {
        if (this.stages[tile] !== letter || this.drawn[tile] === letter) continue;
        const at = tile * 4;
        const x = Math.round(all[at] * scale), y = Math.round(all[at + 1] * scale);
        const right = Math.round(all[at + 2] * scale), low = Math.round(all[at + 3] * scale);
        pen.fillRect(x, y, Math.max(1, right - x - gap), Math.max(1, low - y - gap));
      }
    }
    this.drawn = this.stages;
  }

  private point(event: PointerEvent): void {
    if (!this.plan) return;
    const x = event.offsetX / this.canvas.clientWidth, y = event.offsetY / this.canvas.clientWidth;
    const all = this.plan.rectangles;
    for (let at = 0; at < all.length; at += 4) {
      if (x < all[at] || y < all[at + 1] || x >= all[at + 2] || y >= all[at + 3]) continue;
      const word = stages.find(([letter]) => letter === this.stages[at / 4])?.[2] ?? "without points";
      return say(this.hint, `Tile ${at / 4}: ${word}`);
    }
  }
}
