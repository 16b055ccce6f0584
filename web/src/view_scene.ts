// The surface of a 2D result on a canvas: what of its tileset is seen is loaded, as fine as it can be drawn in time.
import * as three from "three";
import {TilesRenderer} from "3d-tiles-renderer/three";
import {MeshoptDecoder} from "meshopt-decoder";
import {GLTFLoader} from "three/examples/jsm/loaders/GLTFLoader.js";
import {Colouring, Colours, Materials} from "./view_colours";
import {Triple} from "./view_camera";
import {Stage} from "./view_stage";

export interface TilesetDocument {
  root: {transform: number[]; boundingVolume: {box: number[]}};
  extras: Colours & {cells: number};
}

const finest = 1, coarsest = 64, restsFiner = 6;  // pixels that a surface may be off on the screen, and how many times less at rest

export class Scene extends Stage {
  onPick: (point: [number, number]) => void = () => undefined;
  private readonly tiles: TilesRenderer;
  private readonly materials: Materials;
  private readonly meshes = new Set<three.Mesh>();  // that are loaded
  private by: Colouring = "height";
  // The camera as it is where nothing is stretched: what it sees there is loaded.
  private readonly eye = new three.PerspectiveCamera(45, 1, 1, 2);
  private readonly circle = new three.LineLoop(new three.BufferGeometry(), new three.LineBasicMaterial({color: "#ff3df2", depthTest: false}));
  protected readonly origin: three.Vector3;
  private inTime: number;  // the error with which a frame is drawn in time, as far as is known

  constructor(canvas: HTMLCanvasElement, url: string, tileset: TilesetDocument, unit: string) {
    const {transform, boundingVolume: {box}} = tileset.root;
    const half = [box[3], box[7], box[11]], end = (sign: number) => half.map((length, axis) => box[axis] + sign * length) as Triple;
    super(canvas, end(-1), end(1), unit);
    this.origin = new three.Vector3(transform[12], transform[13], transform[14]);
    this.inTime = this.software ? 24 : 6;
    this.controls.maxPolarAngle = Math.PI * 0.495;
    this.materials = new Materials(tileset.extras, this.origin.z);
    this.circle.renderOrder = 1;
    this.mark([], []);
    this.world.add(this.circle);

    this.tiles = new TilesRenderer(url);
    this.tiles.fetchOptions = {credentials: "same-origin"};
    this.tiles.errorTarget = finest;
    this.tiles.manager.addHandler(/\.glb$/, new GLTFLoader().setMeshoptDecoder(MeshoptDecoder));
    // What is computed in 32 bits is near 0, wherever the data lies.
    this.tiles.group.position.copy(this.origin).multiplyScalar(-1);
    this.eye.matrixAutoUpdate = false;
    this.tiles.setCamera(this.eye);
    this.tiles.addEventListener("load-model", ({scene}) => this.dress(scene));
    this.tiles.addEventListener("dispose-model", ({scene}) => scene.traverse(object => this.meshes.delete(object as three.Mesh)));
    this.tiles.addEventListener("load-error", ({error}) => this.onFailure(error));
    for (const kind of ["load-root-tileset", "needs-update", "tiles-load-end"] as const)
      this.tiles.addEventListener(kind, () => this.draw());
    this.scene.add(this.tiles.group);
  }

  override close(): void {
    super.close();
    this.tiles.dispose();
    this.materials.dispose();
    this.circle.geometry.dispose();
  }

  colour(by: Colouring): void {
    this.by = by;
    for (const mesh of this.meshes) mesh.material = this.materials.get(by);
    this.draw();
  }

  // The corners of a triangle in the plane, their heights if they are known, and the circle through them; none takes the
  // mark away. What is not known is where the surface is drawn there; the circle is as high as their mean.
  mark(ring: number[][], heights: (number | null)[], centre: number[] = [], radius = 0): void {
    const caster = new three.Raycaster(), top = this.camera.far, down = new three.Vector3(0, 0, -1);
    const places = ring.map(([x, y], i): Triple => {
      const at = new three.Vector3(x - this.origin.x, y - this.origin.y, top), known = heights[i] ?? null;
      caster.set(at, down);
      return [at.x, at.y, known === null ? caster.intersectObject(this.tiles.group, true)[0]?.point.z ?? 0 : known - this.origin.z];
    });
    const level = places.reduce((sum, at) => sum + at[2] / places.length, 0), parts = 96;
    const round = Array.from({length: ring.length > 0 ? parts : 0}, (_, i) => [centre[0] - this.origin.x + radius * Math.cos(2 * Math.PI * i / parts),
      centre[1] - this.origin.y + radius * Math.sin(2 * Math.PI * i / parts), level]).flat();
    this.circle.geometry.dispose();
    this.circle.geometry = new three.BufferGeometry().setAttribute("position", new three.Float32BufferAttribute(round, 3));
    this.circle.visible = ring.length > 0;
    this.markTriangle(places);
  }

  // So near to a triangle that was marked that it is seen.
  approach(ring: number[][]): void {
    const places = ring.map(([x, y]) => [x - this.origin.x, y - this.origin.y]);
    const end = (most: (...values: number[]) => number): number[] => [0, 1].map(axis => most(...places.map(at => at[axis])));
    const low = end(Math.min), high = end(Math.max), room = Math.max(high[0] - low[0], high[1] - low[1]);
    const levels = this.markedHeights, level = levels.reduce((sum, z) => sum + z / levels.length, 0);
    this.frame([low[0] - room, low[1] - room, level], [high[0] + room, high[1] + room, level], true);
  }

  protected override clicked(caster: three.Raycaster): void {
    const hit = caster.intersectObject(this.tiles.group, true)[0];
    if (hit) this.onPick([hit.point.x + this.origin.x, hit.point.y + this.origin.y]);
  }

  protected override stretched(middle: number, times: number): void { this.materials.stretch(middle, times); }

  protected override get shown(): boolean { return this.tiles.visibleTiles.size > 0; }

  protected override adapt(factor: number): void {
    this.inTime = Math.min(coarsest, this.inTime * Math.min(2, Math.max(0.97, Math.sqrt(factor))));
  }

  protected override prepare(moving: boolean): boolean {
    this.tiles.errorTarget = Math.max(finest, moving ? this.inTime : this.inTime / restsFiner);
    this.eye.matrixWorldInverse.multiplyMatrices(this.camera.matrixWorldInverse, this.world.matrixWorld);
    this.eye.matrixWorld.copy(this.eye.matrixWorldInverse).invert();
    this.eye.projectionMatrix.copy(this.camera.projectionMatrix);
    this.tiles.setResolutionFromRenderer(this.eye, this.renderer);
    this.tiles.update();
    this.materials.light(this.camera);
    return this.tiles.loadProgress < 1;
  }

  private dress(scene: three.Object3D): void {
    scene.traverse(object => {
      const mesh = object as three.Mesh;
      if (!mesh.isMesh) return;
      mesh.material.dispose();
      mesh.material = this.materials.get(this.by);
      this.meshes.add(mesh);
    });
    this.draw();
  }
}
