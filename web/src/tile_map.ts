// The tiles of a job as a map on which they light up. Only what has changed is drawn again.
import {Tiles} from "./api";
import {h, replace, say, show} from "./dom";
import {count} from "./format";
import {MailArcs} from "./mail_arcs";
import {Plan, planOf} from "./tile_layout";
import {MapPart, Spot, spotsOf} from "./tile_zoom";

const stages: [string, string, string][] = [  // letter, property of the style sheet, word
  ["w", "--tile-waiting", "waiting"], ["t", "--tile-triangulated", "triangulated"], ["s", "--tile-splayed", "joined"],
  ["q", "--tile-settled", "settled"], ["d", "--tile-stored", "stored"]];

const pointing = matchMedia("(hover: none)").matches ? "Touch a tile to see which it is." : "Point at a tile to see which it is.";
const step = 1.5, keyStep = 0.1;  // how much closer at once, and of what is seen how far to the side

export class TileMap {
  readonly element: HTMLElement;
  private readonly canvas = h("canvas", {role: "img", tabindex: 0, "aria-label": "Map of the tiles", "aria-describedby": "map-keys"});
  private readonly arcs = new MailArcs();
  private readonly places = h("div", {class: "spots"});
  private readonly sheet = h("div", {class: "sheet"}, this.canvas, this.arcs.picture, this.places);
  private readonly frame = h("div", {class: "frame"}, this.sheet);
  private readonly whole = h("button", {type: "button", class: "quiet", onclick: () => this.see(() => this.part.whole())}, "All");
  private readonly buttons = h("div", {class: "map-buttons", role: "group", "aria-label": "View of the map"},
    h("button", {type: "button", class: "quiet", "aria-label": "Closer", title: "Closer", onclick: () => this.closer(step)}, "+"),
    h("button", {type: "button", class: "quiet", "aria-label": "Farther", title: "Farther", onclick: () => this.closer(1 / step)}, "−"), this.whole);
  private readonly hint = h("p", {class: "sub hint"}, "The tiles are shown when the points have been read.");
  private readonly part = new MapPart();
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
    this.element = h("div", {class: "map"}, legend, this.frame,
      h("div", {class: "below-map"}, this.hint, this.buttons), this.arcs.words,
      h("p", {class: "unseen", id: "map-keys"}, "Keys: + and − zoom, arrows move, 0 shows all."));
    show(this.sheet, false);
    show(this.buttons, false);
    this.canvas.addEventListener("pointermove", event => this.point(event));
    this.canvas.addEventListener("pointerdown", event => this.point(event));
    this.canvas.addEventListener("pointerleave", () => this.plan && say(this.hint, pointing));
    this.listenForMoves();
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
      this.part.of(this.plan.height);
      say(this.hint, pointing);
      show(this.sheet, true);
      show(this.buttons, true);
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
    this.arcs.see(this.part, this.plan.height);
    this.draw();
    this.mark(spotsOf(this.plan.rectangles, this.stages, this.part, this.canvas.clientWidth, this.canvas.clientHeight));
    this.whole.setAttribute("aria-disabled", String(this.part.zoom === 1));
    this.canvas.classList.toggle("moves", this.part.zoom > 1);
  }

  // Places with many tiles that are too small: who chooses one sees them.
  private mark(spots: Spot[]): void {
    replace(this.places, ...spots.map(spot => {
      const button = h("button", {type: "button", onclick: () => {
        this.see(() => this.part.show(spot.box));
        this.canvas.focus({preventScroll: true});
      }}, `${count(spot.tiles)} tiles`);
      // At the border of the map it is beside its place, so that all of it is seen.
      const inside = (at: number, room: number, all: number) => `${Math.min(all - room, Math.max(room, at))}px`;
      button.style.left = inside(spot.x, 36, this.canvas.clientWidth);
      button.style.top = inside(spot.y, 14, this.canvas.clientHeight);
      return button;
    }));
  }

  private see(change: () => void): void {
    if (!this.plan) return;
    change();
    this.redraw();
  }

  // Towards what is in the middle.
  private closer(factor: number): void {
    this.see(() => this.part.closer(factor, this.part.left + 0.5 / this.part.zoom, this.part.top + this.plan!.height / 2 / this.part.zoom));
  }

  private listenForMoves(): void {
    let last: PointerEvent | null = null;
    this.canvas.addEventListener("pointerdown", event => {
      if (this.part.zoom === 1 || !event.isPrimary) return;
      last = event;
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", event => {
      if (!last) return;
      const length = this.canvas.clientWidth * this.part.zoom, {clientX, clientY} = last;
      last = event;
      this.see(() => this.part.move((clientX - event.clientX) / length, (clientY - event.clientY) / length));
    });
    for (const kind of ["pointerup", "pointercancel"] as const) this.canvas.addEventListener(kind, () => { last = null; });
    // Without Ctrl the wheel moves the page.
    this.canvas.addEventListener("wheel", event => {
      if (!event.ctrlKey || !this.plan) return;
      event.preventDefault();
      const [x, y] = this.placeOf(event);
      this.see(() => this.part.closer(event.deltaY < 0 ? step : 1 / step, x, y));
    }, {passive: false});
    this.canvas.addEventListener("keydown", event => {
      const by = keyStep / this.part.zoom;
      const does: Record<string, () => void> = {"+": () => this.closer(step), "=": () => this.closer(step), "-": () => this.closer(1 / step),
        "0": () => this.see(() => this.part.whole()), ArrowLeft: () => this.see(() => this.part.move(-by, 0)), ArrowRight: () => this.see(() => this.part.move(by, 0)),
        ArrowUp: () => this.see(() => this.part.move(0, -by)), ArrowDown: () => this.see(() => this.part.move(0, by))};
      if (!does[event.key] || (event.key.startsWith("Arrow") && this.part.zoom === 1)) return;
      event.preventDefault();
      does[event.key]();
    });
  }

  // Of the map.
  private placeOf(event: MouseEvent): [number, number] {
    const length = this.canvas.clientWidth * this.part.zoom;
    return [this.part.left + event.offsetX / length, this.part.top + event.offsetY / length];
  }

  private draw(): void {
    const pen = this.canvas.getContext("2d")!;
    const scale = this.canvas.width * this.part.zoom, all = this.plan!.rectangles, {left: west, top: north} = this.part;
    // A line between tiles as long as they are large enough to leave one.
    const gap = scale / Math.sqrt(this.stages.length) > 6 ? Math.max(1, Math.round(devicePixelRatio)) : 0;
    for (const [letter, colour] of this.colours) {
      pen.fillStyle = colour;
      for (let tile = 0; tile < this.stages.length; ++tile) {
        if (this.stages[tile] !== letter || this.drawn[tile] === letter) continue;
        const at = tile * 4;
        const x = Math.round((all[at] - west) * scale), y = Math.round((all[at + 1] - north) * scale);
        const right = Math.round((all[at + 2] - west) * scale), low = Math.round((all[at + 3] - north) * scale);
        if (right < 0 || low < 0 || x > this.canvas.width || y > this.canvas.height) continue;
        pen.fillRect(x, y, Math.max(1, right - x - gap), Math.max(1, low - y - gap));
      }
    }
    this.drawn = this.stages;
  }

  private point(event: PointerEvent): void {
    if (!this.plan) return;
    const [x, y] = this.placeOf(event);
    const all = this.plan.rectangles;
    for (let at = 0; at < all.length; at += 4) {
      if (x < all[at] || y < all[at + 1] || x >= all[at + 2] || y >= all[at + 3]) continue;
      const word = stages.find(([letter]) => letter === this.stages[at / 4])?.[2] ?? "without points";
      return say(this.hint, `Tile ${at / 4}: ${word}`);
    }
  }
}
