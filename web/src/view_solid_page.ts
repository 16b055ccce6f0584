// The viewer of a 3D result: its hull, a cut through it, the cells of a box; and what a cell is.
import {address, Failure, Triangulation} from "./api";
import {h, replace, say, show} from "./dom";
import {count, withUnit} from "./format";
import {action, Context, Notice} from "./page";
import {CellPanel} from "./view_cell";
import {Latest} from "./view_latest";
import {choice, colourPanel} from "./view_legend";
import {loadShape, Shape} from "./view_shape";
import {Slider} from "./view_slider";
import {SolidScene} from "./view_solid";
import {drawable} from "./view_stage";
import {heightSlider, viewButtons} from "./view_tools";

type Mode = "hull" | "cut" | "cells";
const modes: [Mode, string][] = [["hull", "Hull"], ["cut", "Cut"], ["cells", "Cells"]];
const airy = 3;           // times the longest edge of half of the cells is that of nine in ten, in a scan
const usualCells = 2000;  // of the box at first, if cells were everywhere alike
const smallest = 0.005;   // side of a box, as a part of the result's
const mostCells = 1e6;    // that the service is asked for; what it has room for may be less

export class SolidView {
  private readonly low: number[];
  private readonly high: number[];
  private readonly told = h("p", {class: "sub", role: "status"});
  private readonly axis = [0, 1, 2];
  private readonly place: Slider;
  private readonly centre: Slider[];
  private readonly side: Slider;
  private readonly shrunk: Slider;
  private readonly longest: Slider;  // edge of what is seen
  private lengths: number[] = [];    // of the longest edges of all cells, every hundredth
  private guessed = true;            // nobody has said what the longest edge is
  private readonly shapes: Latest<string>;
  private readonly cell: CellPanel;
  private readonly closing = new AbortController();
  private scene: SolidScene | null = null;
  private mode: Mode = "hull";
  private hullWords = "The outer facets: no other cell lies behind them.";
  private chosen = false;  // the box is as somebody wants it
  private cut = 1;  // the axis that the plane is upright on
  private corners: number[][] = [];

  constructor(private readonly context: Context, private readonly notice: Notice, private readonly body: HTMLElement,
              private readonly result: Triangulation) {
    this.low = result.bounds.slice(0, 3);
    this.high = result.bounds.slice(3);
    this.cell = new CellPanel(result.name, "Click on a cell.");
    this.shapes = new Latest(async (url, signal) => {
      await this.notice.attempt(async () => {
        try {
          this.take(await loadShape(url, signal));
        } catch (error) {
          if (!(error instanceof Failure && error.status === 422 && this.mode === "hull" && this.guessed)) throw error;
          this.longest.move(Math.log(1.4));  // until the service has room for the border
        }
      });
    });
    this.place = new Slider("cut-place", "Place", () => this.ask());
    this.centre = this.axis.map(axis => new Slider(`cells-${"xyz"[axis]}`, `Middle, ${"xyz"[axis]}`, () => {
      this.chosen = true;
      this.ask();
      this.look(false);
    }));
    const part = Math.cbrt(usualCells / Math.max(1, result.cells));
    this.side = new Slider("cells-side", "Size", () => {
      this.chosen = true;
      this.ask();
    }, value => `${(100 * value).toLocaleString("en", {maximumSignificantDigits: 2})} % of a side`);
    this.side.range(Math.log(smallest), 0, Math.log(Math.max(smallest, Math.min(1, part))), Math.exp);
    this.shrunk = new Slider("cells-shrink", "Shrunk to", () => this.scene?.shrink(this.shrunk.value), value => `${Math.round(100 * value)} %`);
    this.shrunk.range(0.05, 1, 0.75);
    this.longest = new Slider("longest-edge", "Longest edge", () => this.ask(), length => this.edgeWords(length));
    this.longest.element.addEventListener("input", () => { this.guessed = false; }, {capture: true});
    this.centre.forEach((slider, axis) => slider.range(this.low[axis], this.high[axis], (this.low[axis] + this.high[axis]) / 2));
  }

  close(): void {
    this.closing.abort();
    this.shapes.close();
    this.scene?.close();
  }

  // The stored result has changed: what is shown is asked for anew.
  again(): void {
    void this.notice.attempt(async () => {
      const hull = await this.loadHull();
      this.scene?.setHull(hull);
      this.shapes.drop();
      this.ask();
    });
  }

  private shape(name: string, query = ""): string { return address("triangulations", this.result.name, "shapes", name) + query; }

  async open(): Promise<void> {
    const hull = await this.loadHull();
    const canvas = h("canvas", {tabindex: 0, role: "img", "aria-label": `${this.result.name}, ${count(this.result.cells)} tetrahedra`, "aria-describedby": "view-help"});
    const {unit = "", heightUnit = ""} = this.result;
    const stage = h("div", {class: "stage"}, canvas, viewButtons(() => this.scene));
    const panels = {cut: this.cutPanel(), cells: this.cellsPanel()};
    const chosen = (mode: Mode) => {
      const other = (mode === "cells") !== (this.mode === "cells");
      this.mode = mode;
      show(panels.cut, mode === "cut");
      show(panels.cells, mode === "cells");
      this.ask();
      if (other) this.look(true);
    };
    const side = h("div", {class: "view-side"},
      h("section", {class: "panel", "aria-labelledby": "show-title"}, h("h2", {id: "show-title"}, "Shown"),
        h("fieldset", {class: "choices three", "aria-labelledby": "show-title"}, ...modes.map(([id, text]) => choice("shown", `show-${id}`, text, id === "hull", () => chosen(id)))),
        h("div", {class: "sliders"}, this.longest.element), panels.cut, panels.cells, this.told));
    replace(this.body, h("div", {class: "view"}, stage, side));
    const scene = this.scene = drawable(stage, () => new SolidScene(canvas, hull.extras, this.low, this.high, unit));
    scene.setHull(hull);
    const colours = colourPanel(hull.extras, heightUnit, by => scene.colour(by));
    colours.append(heightSlider(() => this.scene));
    side.append(colours, this.cell.element, h("p", {class: "sub", id: "view-help"},
      "Drag turns, the right button or two fingers move, the wheel or two fingers zoom; with Shift a drag moves the cut. A click asks for the cell. Keys: arrows move, with Shift they turn, + and − zoom, Enter asks for the cell in the middle."));
    scene.onPick = ({tile, cell}) => void this.notice.attempt(async () => {
      await this.cell.ask(`cell=${tile},${cell}`);
      this.context.announce(this.cell.summary);
    });
    this.cell.onFound = (corners, _, centre, radius) => {
      this.corners = corners;
      scene.mark(corners, centre, radius);
    };
    this.cell.onLook = () => {
      const end = (most: (...values: number[]) => number) => this.axis.map(axis => most(...this.corners.map(at => at[axis])));
      const low = end(Math.min), high = end(Math.max), room = Math.max(...this.axis.map(axis => high[axis] - low[axis]));
      scene.look(low.map(value => value - room), high.map(value => value + room), true, true);
    };
    scene.onPull = part => this.place.move(part * (this.high[this.cut] - this.low[this.cut]));
    this.turn(this.cut);
    this.rangeOfEdges(hull.extras.edgeLengths ?? []);
    chosen("hull");
  }

  // From the shortest cells to all.
  private rangeOfEdges(lengths: number[]): void {
    this.lengths = lengths;
    show(this.longest.element, lengths.length > 0);
    if (lengths.length === 0) return;
    const [least, middle, most] = [lengths[1], lengths[50], lengths[100]].map(Math.log);
    // Of a scan most cells are small, along what was scanned, and few are large, through the air: at first without these.
    const scanned = lengths[90] > airy * lengths[50];
    this.longest.range(least, most, scanned ? middle + Math.log(4) : most, Math.exp);
  }

  // Nothing: all cells.
  private get longestEdge(): number | null {
    const {value} = this.longest;
    return this.lengths.length === 0 || value >= this.lengths[100] * 0.9999 ? null : Number(value.toPrecision(3));
  }

  private edgeWords(length: number): string {
    if (this.longestEdge === null) return "all cells";
    return `${withUnit(Number(length.toPrecision(3)), this.result.unit ?? "", 12)}: ${this.lengths.filter(each => each <= length).length - 1} % of the cells`;
  }

  // One with too many facets is left out: an empty section tells the rest of what it would.
  private async loadHull(): Promise<Shape> {
    try {
      return await loadShape(this.shape("hull"), this.closing.signal);
    } catch (error) {
      if (!(error instanceof Failure && error.status === 422)) throw error;
      this.hullWords = error.message;
      const beside = this.high.map((value, axis) => value + (value - this.low[axis]));
      return await loadShape(this.shape("section", `?through=${beside.join(",")}&normal=1,1,1`), this.closing.signal);
    }
  }

  private cutPanel(): HTMLElement {
    return h("div", {class: "sliders"},
      h("fieldset", {class: "choices three", "aria-label": "The cut is upright on"}, ...this.axis.map(axis =>
        choice("axis", `cut-${"xyz"[axis]}`, "XYZ"[axis], axis === this.cut, () => {
          this.turn(axis);
          this.ask();
        }))), this.place.element);
  }

  private cellsPanel(): HTMLElement {
    return h("div", {class: "sliders"}, ...this.centre.map(slider => slider.element), this.side.element, this.shrunk.element,
      action("Around the cell", async () => {
        if (this.corners.length === 0) return;
        this.centre.forEach((slider, axis) => slider.set(this.corners.reduce((sum, p) => sum + p[axis] / this.corners.length, 0)));
        this.ask();
        this.look(true);
      }));
  }

  // At what is shown.
  private look(anew: boolean): void {
    const [low, high] = this.mode === "cells" ? this.box : [this.low, this.high];
    this.scene?.look(low, high, anew);
  }

  private get box(): [number[], number[]] {
    const half = this.axis.map(axis => (this.high[axis] - this.low[axis]) * this.side.value / 2);
    return [this.axis.map(axis => this.centre[axis].value - half[axis]), this.axis.map(axis => this.centre[axis].value + half[axis])];
  }

  private turn(axis: number): void {
    this.cut = axis;
    this.place.range(this.low[axis], this.high[axis], (this.low[axis] + this.high[axis]) / 2);
  }

  // The shape that the sliders tell of.
  private ask(): void {
    const {scene, low, high} = this;
    if (!scene) return;
    scene.along = this.mode === "cut" ? scene.extent(this.cut) : null;
    const edge = this.longestEdge, limits = edge === null ? "" : `&max-edge=${edge}&limit=${mostCells}`;
    if (this.mode === "hull" && edge !== null) {
      scene.outline([], []);
      this.shapes.want(this.shape("hull", `?${limits.slice(1)}`));
    } else if (this.mode === "hull") {
      this.shapes.drop();
      this.notice.clear();
      scene.put(null);
      scene.outline([], []);
      say(this.told, this.hullWords);
    } else if (this.mode === "cut") {
      const at = (bounds: number[]) => bounds.map((value, axis) => axis === this.cut ? this.place.value : value);
      scene.outline(at(low), at(high));
      const through = at(low).join(","), normal = this.axis.map(axis => axis === this.cut ? 1 : 0).join(",");
      this.shapes.want(this.shape("section", `?through=${through}&normal=${normal}${limits}`));
    } else {
      const [from, to] = this.box;
      scene.outline(from, to);
      this.shapes.want(this.shape("cells", `?bbox=${[...from, ...to].join(",")}${limits}`));
    }
  }

  private take(shape: Shape): void {
    // What was chosen may have changed meanwhile.
    const kind = {hull: "hull", cut: "section", cells: "solids"}[this.mode];
    if (shape.extras.kind !== kind || (kind === "hull" && this.longestEdge === null)) return shape.dispose();
    if (this.mode === "cells") {
      shape.shrink(this.shrunk.value);
      // Where there are few, a larger one.
      this.chosen ||= shape.extras.cells > usualCells / 4 || this.side.value > 0.6;
      if (!this.chosen) {
        this.side.grow(Math.log(1.6));
        this.ask();
        this.look(true);
      }
    }
    this.scene!.put(shape);
    const cells = count(shape.extras.cells);
    say(this.told, {hull: `${cells} cells on the border of the cells without longer edges.`, cut: `The plane cuts ${cells} cells.`,
      cells: `${cells} cells meet the box.`}[this.mode]);
  }
}
