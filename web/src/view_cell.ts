// What the service says of a cell: its vertices, neighbours and tile, of a surface the heights; and its circumscribed
// circle or sphere.
import {address, get, send} from "./api";
import {h, replace} from "./dom";
import {withUnit} from "./format";

interface Vertex { id: number; tile: number; point: number[] }
interface Neighbor { tile: number; cell: number; vertices: number[] }
interface Heights { answers: {value: number | null}[] }
interface Location { point: number[]; cell: number | null; tile: number; vertices: Vertex[]; neighbors: (Neighbor | null)[] }

// Of the circle through three points of the plane. Relative to one of them: coordinates may be large.
function circle([a, b, c]: number[][]): {centre: number[]; radius: number} {
  const bx = b[0] - a[0], by = b[1] - a[1], cx = c[0] - a[0], cy = c[1] - a[1], d = 2 * (bx * cy - by * cx);
  const b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
  const x = (cy * b2 - by * c2) / d, y = (bx * c2 - cx * b2) / d;
  return {centre: [a[0] + x, a[1] + y], radius: Math.hypot(x, y)};
}

// Of the sphere through four points of space, likewise: three planes between the first and the others meet in its centre.
function sphere([a, ...others]: number[][]): {centre: number[]; radius: number} {
  const rows = others.map(p => p.map((value, axis) => value - a[axis]));
  const half = rows.map(([x, y, z]) => (x * x + y * y + z * z) / 2);
  const cross = (u: number[], v: number[]) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const sides = [cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1])];
  const volume = rows[0].reduce((sum, value, axis) => sum + value * sides[0][axis], 0);
  const away = [0, 1, 2].map(axis => (half[0] * sides[0][axis] + half[1] * sides[1][axis] + half[2] * sides[2][axis]) / volume);
  return {centre: away.map((value, axis) => a[axis] + value), radius: Math.hypot(...away)};
}

// The digits that are the number: they are compared with those of the command.
const exact = (values: number[]) => values.join(", ");
const rounded = (value: number) => value.toLocaleString("en", {maximumSignificantDigits: 9, useGrouping: false});
const heightDigits = 3, storedDigits = 17;  // after the point: of a height between vertices, and of one that was measured

export class CellPanel {
  // Its vertices, their heights as far as they are known, and the circle or sphere through them; nothing when there is no
  // cell.
  onFound: (corners: number[][], heights: (number | null)[], centre?: number[], radius?: number) => void = () => undefined;
  // Somebody wants to see the cell near by.
  onLook: () => void = () => undefined;
  summary = "";
  readonly element: HTMLElement;
  private readonly body = h("div", {});
  private asked = 0;

  // `hint`: what is said before anything was asked. `heights`: what they count, of a surface that has some.
  constructor(private readonly triangulation: string, hint: string, private readonly heights: string | null = null) {
    this.element = h("section", {class: "panel cell", "aria-labelledby": "cell-title"}, h("h2", {id: "cell-title"}, "Cell"), this.body);
    replace(this.body, h("p", {class: "muted"}, hint));
  }

  // Of what was asked last, whatever is answered first. `what`: point=X,Y or cell=TILE,CELL.
  async ask(what: string): Promise<void> {
    const mine = ++this.asked;
    const found = await get<Location>(`${address("triangulations", this.triangulation, "locate")}?${what}`);
    if (mine !== this.asked) return;
    const heights = this.heights !== null && found.cell !== null ? await this.heightsOf([found.point, ...found.vertices.map(v => v.point)]) : [];
    if (mine === this.asked) this.tell(found, heights);
  }

  private async heightsOf(points: number[][]): Promise<(number | null)[]> {
    const answer = await send("POST", `${address("triangulations", this.triangulation, "interpolate")}?value=z`, {body: {points}});
    return (await answer.json() as Heights).answers.map(each => each.value);
  }

  private tell(found: Location, [height, ...heights]: (number | null)[]): void {
    if (found.cell === null) {
      this.summary = "There is no cell here: this place is outside of the hull.";
      replace(this.body, h("p", {class: "muted"}, this.summary));
      return this.onFound([], []);
    }
    const corners = found.vertices.map(v => v.point), solid = corners.length === 4;
    const {centre, radius} = solid ? sphere(corners) : circle(corners);
    const tall = (value: number | null | undefined, digits: number) => typeof value === "number" ? `Height ${withUnit(value, this.heights ?? "", digits)}` : null;
    const here = tall(height, heightDigits), name = `Cell ${found.cell} of tile ${found.tile}`;
    this.summary = here === null ? name : `${here}. ${name}`;
    replace(this.body, h("div", {class: "heading"}, h("p", {class: "name"}, name),
      h("button", {type: "button", class: "quiet", onclick: () => this.onLook()}, "Look closer")),
      here === null ? null : h("p", {class: "height"}, here, h("span", {class: "sub"}, ` at ${found.point.map(value => value.toFixed(heightDigits)).join(", ")}`)),
      h("h3", {}, "Vertices"),
      h("ul", {}, ...found.vertices.map((v, k) => h("li", {}, h("span", {class: "number"}, `${v.id}`), h("span", {class: "sub"}, `${exact(v.point)} · tile ${v.tile}`),
        tall(heights[k], storedDigits) === null ? null : h("span", {class: "number"}, tall(heights[k], storedDigits))))),
      h("h3", {}, solid ? "Circumscribed sphere" : "Circumscribed circle"),
      h("p", {class: "number"}, `radius ${rounded(radius)}`), h("p", {class: "sub number"}, `centre ${centre.map(rounded).join(", ")}`),
      h("h3", {}, "Neighbours, opposite each vertex"),
      h("ul", {}, ...found.neighbors.map((n, k) => h("li", {}, h("span", {class: "number"}, `${found.vertices[k].id}`),
        h("span", {class: "sub"}, n ? `cell ${n.cell} of tile ${n.tile}: ${n.vertices.join(", ")}` : "none: on the hull")))));
    this.onFound(corners, heights, centre, radius);
  }
}
