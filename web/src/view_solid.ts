// A 3D result on a canvas: its hull as edges or a body, and in it a section or some cells; a cell that was clicked at.
import * as three from "three";
import {Colouring, Materials} from "./view_colours";
import {CellName, Shape, ShapeExtras} from "./view_shape";
import {Triple} from "./view_camera";
import {Stage} from "./view_stage";

const edgesMost = 0.55, edgesFew = 3000, edgesNone = 60000;  // how strong edges are of so many cells; of more they would hide what they are edges of, of many they are not drawn

export class SolidScene extends Stage {
  onPick: (cell: CellName) => void = () => undefined;
  // Shift and the mouse: by how much of the result's extent it was moved along `along`.
  onPull: (part: number) => void = () => undefined;
  along: three.Vector3 | null = null;
  private readonly materials: Materials;
  protected readonly origin: three.Vector3;
  private readonly line = (color: string, opacity = 1) => new three.LineBasicMaterial({color, opacity, transparent: opacity < 1});
  private readonly hullEdges = new three.LineSegments(new three.BufferGeometry(), this.line("#7f8c99", 0.5));
  private readonly body: three.Mesh;
  private readonly bodyEdges = new three.LineSegments(new three.BufferGeometry(), this.line("#10161c", edgesMost));
  private readonly box = new three.LineSegments(new three.BufferGeometry(), this.line("#e0803a"));
  private readonly marked = new three.LineSegments(new three.BufferGeometry(), new three.LineBasicMaterial({color: "#ff3df2", depthTest: false}));
  private readonly sphere = new three.Mesh(new three.SphereGeometry(1, 48, 24),
    new three.MeshBasicMaterial({color: "#ff9bf8", transparent: true, opacity: 0.16, depthWrite: false, side: three.DoubleSide}));
  private readonly circles = new three.LineSegments(new three.BufferGeometry(), this.line("#ff3df2", 0.6));
  private hull: Shape | null = null;
  private shape: Shape | null = null;

  // `lowest`, `highest`: the corners of the box around all, in the result's coordinates.
  constructor(canvas: HTMLCanvasElement, hull: ShapeExtras, private readonly lowest: number[], private readonly highest: number[], unit: string) {
    super(canvas, lowest.map((value, axis) => value - hull.origin[axis]) as Triple, highest.map((value, axis) => value - hull.origin[axis]) as Triple, unit);
    this.origin = new three.Vector3(hull.origin[0], hull.origin[1], hull.origin[2]);
    // Edges are in front of the facets that they are edges of.
    this.materials = new Materials(hull, this.origin.z, {polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1});
    this.body = new three.Mesh(new three.BufferGeometry(), this.materials.get("height"));
    this.circles.geometry.setAttribute("position", new three.Float32BufferAttribute(greatCircles(), 3));
    for (const above of [this.marked, this.sphere, this.circles]) above.renderOrder = 1;
    this.mark([]);
    this.outline([], []);
    this.body.frustumCulled = false;  // where it is drawn the shader knows
    this.scene.add(this.body);
    this.world.add(this.bodyEdges, this.hullEdges, this.box, this.marked, this.sphere, this.circles);
    this.listenForPulls();
  }

  override close(): void {
    super.close();
    this.hull?.dispose();
    if (this.shape !== this.hull) this.shape?.dispose();
    for (const object of [this.box, this.marked, this.sphere, this.circles]) object.geometry.dispose();
    this.materials.dispose();
  }

  colour(by: Colouring): void {
    this.body.material = this.materials.get(by);
    this.draw();
  }

  setHull(hull: Shape): void {
    const before = this.hull;
    this.hull = hull;
    this.hullEdges.geometry = hull.edges;
    this.put(hull);
    if (before !== hull) before?.dispose();
  }

  // What is seen as a body; none: the hull.
  put(shape: Shape | null): void {
    const next = shape ?? this.hull!;
    if (this.shape && this.shape !== this.hull && this.shape !== next) this.shape.dispose();
    this.shape = next;
    this.body.geometry = next.geometry;
    this.bodyEdges.geometry = next.edges;
    (this.bodyEdges.material as three.LineBasicMaterial).opacity = edgesMost * Math.min(1, Math.sqrt(edgesFew / Math.max(1, next.extras.cells)));
    this.bodyEdges.visible = next.extras.cells <= edgesNone;
    // The border of cells is within the hull, whose edges would only be in its way.
    this.hullEdges.visible = next.extras.kind !== "hull";
    this.draw();
  }

  // Nothing but the hull's edges, until something comes.
  clear(): void {
    this.put(null);
    this.body.geometry = this.bodyEdges.geometry = new three.BufferGeometry();
    this.hullEdges.visible = true;
  }

  shrink(part: number): void {
    if (this.shape && this.shape !== this.hull) this.shape.shrink(part);
    this.draw();
  }

  // Turns around the middle of this box; with `anew` it fills the picture.
  look(low: number[], high: number[], anew: boolean, once = false): void {
    const place = (p: number[]): Triple => [p[0] - this.origin.x, p[1] - this.origin.y, p[2] - this.origin.z];
    if (anew) this.frame(place(low), place(high), once);
    else this.turnAround(place(low), place(high));
  }

  // The edges of a box, which may be flat; none takes them away.
  outline(low: number[], high: number[]): void {
    const corner = (bits: number) => [0, 1, 2].map(axis => (bits >> axis & 1 ? high : low)[axis] - [this.origin.x, this.origin.y, this.origin.z][axis]);
    const ends = low.length === 0 ? [] : [0, 1, 2].flatMap(axis => [0, 1, 2, 3, 4, 5, 6, 7].filter(bits => !(bits >> axis & 1))
      .flatMap(bits => [...corner(bits), ...corner(bits | 1 << axis)]));
    setLines(this.box, ends);
    this.draw();
  }

  // A cell by its corners, in the result's coordinates, and the sphere through them; none takes the mark away.
  mark(corners: number[][], centre?: number[], radius = 0): void {
    const place = (p: number[]) => [p[0] - this.origin.x, p[1] - this.origin.y, p[2] - this.origin.z];
    setLines(this.marked, corners.flatMap((a, i) => corners.slice(i + 1).flatMap(b => [...place(a), ...place(b)])));
    const seen = centre !== undefined && Number.isFinite(radius);
    for (const part of [this.sphere, this.circles]) {
      // Within a sphere as large as all of it everything would look like it.
      part.visible = seen && (part === this.circles || radius < this.radius);
      if (!seen) continue;
      const [x, y, z] = place(centre);
      part.position.set(x, y, z);
      part.scale.set(radius, radius, radius);
    }
    this.draw();
  }

  protected override prepare(): boolean {
    this.materials.light(this.camera);
    return false;
  }

  protected override stretched(middle: number, times: number): void { this.materials.stretch(middle, times); }

  protected override get shown(): boolean { return this.shape !== null; }

  protected override clicked(caster: three.Raycaster): void {
    const hit = caster.intersectObject(this.body, false)[0];
    if (hit && this.shape) this.onPick(this.shape.cellOf(hit.faceIndex!));
  }

  // Along the picture of the direction, so that what is pulled follows the mouse.
  private listenForPulls(): void {
    let last: PointerEvent | null = null;
    this.canvas.parentElement!.addEventListener("pointerdown", event => {
      if (!event.shiftKey || !this.along || event.button !== 0) return;
      last = event;
      this.controls.enabled = false;
      this.canvas.setPointerCapture(event.pointerId);
    }, {capture: true});
    this.canvas.addEventListener("pointermove", event => {
      if (!last || !this.along) return;
      const from = this.controls.target.clone().project(this.camera);
      const to = this.controls.target.clone().add(this.along).project(this.camera);
      const x = (to.x - from.x) * this.canvas.clientWidth / 2, y = (from.y - to.y) * this.canvas.clientHeight / 2;
      const length2 = x * x + y * y;
      if (length2 > 1) this.onPull(((event.clientX - last.clientX) * x + (event.clientY - last.clientY) * y) / length2);
      last = event;
    });
    for (const kind of ["pointerup", "pointercancel"] as const)
      this.canvas.addEventListener(kind, () => {
        last = null;
        this.controls.enabled = true;
      });
  }

  // The extent along an axis, as `along` has it.
  extent(axis: number): three.Vector3 {
    const length = this.highest[axis] - this.lowest[axis];
    return new three.Vector3(axis === 0 ? length : 0, axis === 1 ? length : 0, axis === 2 ? length * this.stretch : 0);
  }
}

function setLines(lines: three.LineSegments, ends: number[]): void {
  lines.geometry.dispose();
  lines.geometry = new three.BufferGeometry().setAttribute("position", new three.Float32BufferAttribute(ends, 3));
  lines.visible = ends.length > 0;
}

// Three of them, of radius 1, as pairs of ends.
function greatCircles(): number[] {
  const parts = 72, ends: number[] = [];
  for (let axis = 0; axis < 3; ++axis)
    for (let i = 0; i < 2 * parts; ++i) {
      const turn = 2 * Math.PI * Math.floor((i + 1) / 2) / parts, at = [0, 0, 0];
      at[(axis + 1) % 3] = Math.cos(turn);
      at[(axis + 2) % 3] = Math.sin(turn);
      ends.push(...at);
    }
  return ends;
}
