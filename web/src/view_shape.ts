// Parts of a 3D result as the service sends them (docs/viewer.md): of each cell its own vertices, one after the other.
import * as three from "three";
import {MeshoptDecoder} from "meshopt-decoder";
import {GLTFLoader} from "three/examples/jsm/loaders/GLTFLoader.js";
import {send} from "./api";
import {Colours} from "./view_colours";

export interface ShapeExtras extends Colours {
  kind: "hull" | "section" | "solids"; origin: number[]; cells: number;
  edgeLengths?: number[];  // of the longest edges of all cells, every hundredth
}
export interface CellName { tile: number; cell: number }

export class Shape {
  readonly geometry = new three.BufferGeometry();
  readonly edges = new three.BufferGeometry();
  private readonly pairs: number[] = [];  // of vertices, the ends of edges
  private readonly starts: number[] = [];  // the first vertex of each cell
  private readonly whole: Float32Array;   // positions as they came

  constructor(readonly extras: ShapeExtras, private readonly mesh: three.Mesh | null) {
    if (!mesh) {
      this.whole = new Float32Array();
      return;
    }
    const {position, _tile, _cell, _intensity, _classification} = mesh.geometry.attributes, {scale, position: moved} = mesh;
    this.whole = new Float32Array(3 * position.count);
    // glTF's y is up: z here.
    for (let i = 0; i < position.count; ++i) {
      this.whole[3 * i] = position.getX(i) * scale.x + moved.x;
      this.whole[3 * i + 1] = -(position.getZ(i) * scale.z + moved.z);
      this.whole[3 * i + 2] = position.getY(i) * scale.y + moved.y;
      // Three vertices are a facet of the hull: a cell may have several.
      const same = i > 0 && _cell.getX(i) === _cell.getX(i - 1) && _cell.getY(i) === _cell.getY(i - 1) && _tile.getX(i) === _tile.getX(i - 1);
      if (extras.kind === "hull" ? i % 3 === 0 : extras.kind === "solids" ? i % 4 === 0 : !same) this.starts.push(i);
    }
    const plain = (from: three.BufferAttribute) => new three.Float32BufferAttribute(Array.from({length: from.count}, (_, i) => from.getX(i)), 1);
    this.geometry.setAttribute("position", new three.Float32BufferAttribute(this.whole.slice(), 3));
    for (const [name, attribute] of Object.entries({_tile, _intensity, _classification})) this.geometry.setAttribute(name, plain(attribute));
    this.geometry.setIndex(mesh.geometry.index!);
    this.starts.forEach((from, i) => {
      const to = this.starts[i + 1] ?? position.count;
      for (let a = from; a < to; ++a) {
        if (extras.kind === "solids") for (let b = a + 1; b < to; ++b) this.pairs.push(a, b);
        else this.pairs.push(a, a + 1 < to ? a + 1 : from);
      }
    });
    this.edges.setIndex(this.pairs);
    this.edges.setAttribute("position", this.geometry.attributes.position);
  }

  // Of the cell that a triangle belongs to.
  cellOf(triangle: number): CellName {
    const {_tile, _cell} = this.mesh!.geometry.attributes, vertex = this.geometry.index!.getX(3 * triangle);
    return {tile: _tile.getX(vertex), cell: _cell.getX(vertex) + 65536 * _cell.getY(vertex)};
  }

  // Each cell towards its middle.
  shrink(part: number): void {
    if (!this.mesh) return;
    const {position} = this.geometry.attributes, array = position.array as Float32Array;
    this.starts.forEach((from, i) => {
      const to = this.starts[i + 1] ?? position.count;
      for (let axis = 0; axis < 3; ++axis) {
        let middle = 0;
        for (let v = from; v < to; ++v) middle += this.whole[3 * v + axis] / (to - from);
        for (let v = from; v < to; ++v) array[3 * v + axis] = middle + part * (this.whole[3 * v + axis] - middle);
      }
    });
    position.needsUpdate = true;
  }

  dispose(): void {
    this.geometry.dispose();
    this.edges.dispose();
  }
}

const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);

export async function loadShape(url: string, signal: AbortSignal): Promise<Shape> {
  const answer = await send("GET", url, {signal, headers: {Accept: "model/gltf-binary"}});
  const {scene} = await loader.parseAsync(await answer.arrayBuffer(), "");
  let mesh: three.Mesh | null = null;
  scene.traverse(object => { if ((object as three.Mesh).isMesh) mesh = object as three.Mesh; });
  signal.throwIfAborted();
  return new Shape(scene.userData as ShapeExtras, mesh);
}
