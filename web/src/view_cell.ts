// What the service says of a cell: its vertices, neighbours and tile; and its circumscribed circle or sphere.
import {address, get} from "./api";
import {h, replace} from "./dom";

interface Vertex { id: number; tile: number; point: number[] }
interface Neighbor { tile: number; cell: number; vertices: number[] }
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

export class CellPanel {
  // Its vertices, and the circle or sphere through them; nothing when there is no cell.
  onFound: (corners: number[][], centre?: number[], radius?: number) => void = () => undefined;
  summary = "";
  readonly element: HTMLElement;
  private readonly body = h("div", {});
  private asked = 0;

  // `hint`: what is said before anything was asked.
  constructor(private readonly triangulation: string, hint: string) {
    this.element = h("section", {class: "panel cell", "aria-labelledby": "cell-title"}, h("h2", {id: "cell-title"}, "Cell"), this.body);
    replace(this.body, h("p", {class: "muted"}, hint));
  }

  // Of what was asked last, whatever is answered first. `what`: point=X,Y or cell=TILE,CELL.
  async ask(what: string): Promise<void> {
    const mine = ++this.asked;
    const found = await get<Location>(`${address("triangulations", this.triangulation, "locate")}?${what}`);
    if (mine === this.asked) this.tell(found);
  }

  private tell(found: Location): void {
    if (found.cell === null) {
      this.summary = "There is no cell: outside of the hull.";
      replace(this.body, h("p", {class: "muted"}, this.summary));
      return this.onFound([]);
    }
    const corners = found.vertices.map(v => v.point), solid = corners.length === 4;
    const {centre, radius} = solid ? sphere(corners) : circle(corners);
    this.summary = `Cell ${found.cell} of tile ${found.tile}`;
    replace(this.body, h("p", {class: "name"}, this.summary),
      h("h3", {}, "Vertices"),
      h("ul", {}, ...found.vertices.map(v => h("li", {}, h("span", {class: "number"}, `${v.id}`), h("span", {class: "sub"}, `${exact(v.point)} · tile ${v.tile}`)))),
      h("h3", {}, solid ? "Circumscribed sphere" : "Circumscribed circle"),
      h("p", {class: "number"}, `radius ${rounded(radius)}`), h("p", {class: "sub number"}, `centre ${centre.map(rounded).join(", ")}`),
      h("h3", {}, "Neighbours, opposite each vertex"),
      h("ul", {}, ...found.neighbors.map((n, k) => h("li", {}, h("span", {class: "number"}, `${found.vertices[k].id}`),
        h("span", {class: "sub"}, n ? `cell ${n.cell} of tile ${n.tile}: ${n.vertices.join(", ")}` : "none: on the hull")))));
    this.onFound(corners, centre, radius);
  }
}
