// The viewer that a notebook embeds: one surface, which the page itself brings along (python/tessera/_view.py).
import * as three from "three";
import {Triple} from "./view_camera";
import {Materials} from "./view_colours";
import {drawable, Stage} from "./view_stage";

// Places are relative to the middle of all, as numbers of 32 bits; `rows` name three of them for each triangle.
interface Given { low: Triple; high: Triple; unit: string; places: string; rows: string }

const bytes = (text: string): ArrayBuffer => Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer;

class Surface extends Stage {
  protected override readonly origin = new three.Vector3();
  private readonly materials: Materials;

  constructor(canvas: HTMLCanvasElement, {low, high, unit, places, rows}: Given) {
    super(canvas, low, high, unit);
    this.materials = new Materials({heights: [low[2], high[2]], intensityMax: 0, classes: [], attributes: [], tiles: 1}, 0);
    const geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.BufferAttribute(new Float32Array(bytes(places)), 3));
    geometry.setIndex(new three.BufferAttribute(new Uint32Array(bytes(rows)), 1));
    this.world.add(new three.Mesh(geometry, this.materials.get("height")));
    this.draw();
  }

  protected override clicked(): void { /* nobody is there to be asked about a cell */ }
  protected override stretched(middle: number, times: number): void { this.materials.stretch(middle, times); }
  protected override get shown(): boolean { return true; }
  protected override prepare(): boolean {
    this.materials.light(this.camera);
    return false;
  }
}

const canvas = document.querySelector("canvas")!, stage = canvas.parentElement!;
try {
  drawable(stage, () => new Surface(canvas, JSON.parse(document.getElementById("given")!.textContent!) as Given));
} catch (error) {
  document.body.append(error instanceof Error ? error.message : String(error));
}
