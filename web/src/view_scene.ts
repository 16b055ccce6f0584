// The surface of a 2D result on a canvas: what of its tileset is seen is loaded, as fine as it can be drawn in time.
import * as three from "three";
import {TilesRenderer} from "3d-tiles-renderer/three";
import {MeshoptDecoder} from "meshopt-decoder";
import {GLTFLoader} from "three/examples/jsm/loaders/GLTFLoader.js";
import {Colouring, Colours, Materials} from "./view_colours";
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
  private readonly marked = new three.LineLoop(new three.BufferGeometry(), new three.LineBasicMaterial({color: "#ffffff", depthTest: false}));
  private readonly circle = new three.LineLoop(new three.BufferGeometry(), new three.LineBasicMaterial({color: "#ff3df2", depthTest: false}));
  protected readonly origin: three.Vector3;
  private inTime: number;  // the error with which a frame is drawn in time, as far as is known

  constructor(canvas: HTMLCanvasElement, url: string, tileset: TilesetDocument) {
    const {transform, boundingVolume: {box}} = tileset.root;
    super(canvas, new three.Vector3(box[0], box[1], box[2]), Math.hypot(box[3], box[7], box[11]) || 1, 1.2);
    this.origin = new three.Vector3(transform[12], transform[13], transform[14]);
    this.inTime = this.software ? 24 : 6;
    this.controls.maxPolarAngle = Math.PI * 0.495;
    this.materials = new Materials(tileset.extras, this.origin.z);
    this.marked.renderOrder = this.circle.renderOrder = 1;
    this.mark([]);
    this.scene.add(this.circle, this.marked);

    this.tiles = new TilesRenderer(url);
    this.tiles.fetchOptions = {credentials: "same-origin"};
    this.tiles.errorTarget = finest;
    this.tiles.manager.addHandler(/\.glb$/, new GLTFLoader().setMeshoptDecoder(MeshoptDecoder));
    // What is computed in 32 bits is near 0, wherever the data lies.
    this.tiles.group.position.copy(this.origin).multiplyScalar(-1);
    this.tiles.setCamera(this.camera);
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
    this.marked.geometry.dispose();
    this.circle.geometry.dispose();
  }

  colour(by: Colouring): void {
    this.by = by;
    for (const mesh of this.meshes) mesh.material = this.materials.get(by);
    this.draw();
  }

  // A ring of places of the plane, and the circle through them; none takes the mark away. Heights are those of what is
  // drawn there, and of the circle their mean.
  mark(ring: number[][], centre: number[] = [], radius = 0): void {
    const caster = new three.Raycaster(), top = this.camera.far, down = new three.Vector3(0, 0, -1);
    const places = ring.flatMap(([x, y]) => {
      const at = new three.Vector3(x - this.origin.x, y - this.origin.y, top);
      caster.set(at, down);
      return [at.x, at.y, caster.intersectObject(this.tiles.group, true)[0]?.point.z ?? this.controls.target.z];
    });
    const level = ring.reduce((sum, _, i) => sum + places[3 * i + 2] / ring.length, 0), parts = 96;
    const round = Array.from({length: ring.length > 0 ? parts : 0}, (_, i) => [centre[0] - this.origin.x + radius * Math.cos(2 * Math.PI * i / parts),
      centre[1] - this.origin.y + radius * Math.sin(2 * Math.PI * i / parts), level]).flat();
    for (const [line, at] of [[this.marked, places], [this.circle, round]] as const) {
      line.geometry.dispose();
      line.geometry = new three.BufferGeometry().setAttribute("position", new three.Float32BufferAttribute(at, 3));
      line.visible = ring.length > 0;
    }
    this.draw();
  }

  protected override clicked(caster: three.Raycaster): void {
    const hit = caster.intersectObject(this.tiles.group, true)[0];
    if (hit) this.onPick([hit.point.x + this.origin.x, hit.point.y + this.origin.y]);
  }

  protected override get shown(): boolean { return this.tiles.visibleTiles.size > 0; }

  protected override adapt(factor: number): void {
    this.inTime = Math.min(coarsest, this.inTime * Math.min(2, Math.max(0.97, Math.sqrt(factor))));
  }

  protected override prepare(moving: boolean): boolean {
    this.tiles.errorTarget = Math.max(finest, moving ? this.inTime : this.inTime / restsFiner);
    this.tiles.setResolutionFromRenderer(this.camera, this.renderer);
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
