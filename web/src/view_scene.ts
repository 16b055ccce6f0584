// The surface of a 2D result on a canvas: what of its tileset is seen is loaded, and drawn when something has changed.
import * as three from "three";
import {TilesRenderer} from "3d-tiles-renderer/three";
import {MeshoptDecoder} from "meshopt-decoder";
import {GLTFLoader} from "three/examples/jsm/loaders/GLTFLoader.js";
import {OrbitControls} from "three/examples/jsm/controls/OrbitControls.js";
import {Colouring, colourings, fragmentShader, vertexShader} from "./view_colours";

export interface TilesetDocument {
  root: {transform: number[]; boundingVolume: {box: number[]}};
  extras: {heights: [number, number]; intensityMax: number; classes: number[]; attributes: string[]; tiles: number; cells: number};
}

const wantedMs = 33;
const restsMs = 250;  // without a move; of slow machines, as long as three frames take
const slowestMs = 2000;
const wantedLoadingMs = 250;  // drawing takes the time of loading
const finest = 1, coarsest = 64, restsFiner = 6;  // pixels that a surface may be off on the screen, and how many times less at rest

// Whether no graphics processor draws, which takes many times as long.
function drawsBySoftware(): boolean {
  const probe = document.createElement("canvas").getContext("webgl2", {failIfMajorPerformanceCaveat: true});
  if (!probe) return true;
  const told = probe.getExtension("WEBGL_debug_renderer_info");
  const name = String(told ? probe.getParameter(told.UNMASKED_RENDERER_WEBGL) : "");
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export class Scene {
  onPick: (point: [number, number]) => void = () => undefined;
  onFailure: (error: Error) => void = () => undefined;
  private readonly renderer: three.WebGLRenderer;
  private readonly scene = new three.Scene();
  private readonly camera: three.PerspectiveCamera;
  private readonly controls: OrbitControls;
  private readonly tiles: TilesRenderer;
  private readonly material: three.ShaderMaterial;
  private readonly marked: three.LineLoop;
  private readonly origin: three.Vector3;
  private readonly size: ResizeObserver;
  private readonly retheme = () => this.theme();
  private moving = false;
  private moved = false;  // when the last frame was drawn
  private drawn = 0;      // when it was
  private took = 0;       // a frame while moving, in ms
  private inTime = 6;     // the error with which a frame is drawn in time, as far as is known
  private waiting = 0;    // the frame that is asked for
  private previous = 0;   // when the last one was
  private settled = 0;
  private closed = false;

  constructor(private readonly canvas: HTMLCanvasElement, url: string, tileset: TilesetDocument) {
    const {transform, boundingVolume: {box}} = tileset.root;
    this.origin = new three.Vector3(transform[12], transform[13], transform[14]);
    const software = drawsBySoftware();
    this.renderer = new three.WebGLRenderer({canvas, antialias: !software});
    this.renderer.setPixelRatio(software ? 1 : Math.min(devicePixelRatio, 2));
    if (software) this.inTime = 24;
    const centre = new three.Vector3(box[0], box[1], box[2]);
    const radius = Math.hypot(box[3], box[7], box[11]) || 1;
    this.camera = new three.PerspectiveCamera(45, 1, radius / 1000, radius * 20);
    this.camera.up.set(0, 0, 1);
    this.camera.position.copy(centre).add(new three.Vector3(-0.5, -1.2, 0.9).multiplyScalar(radius * 1.2));
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.target.copy(centre);
    this.controls.maxPolarAngle = Math.PI * 0.495;
    this.controls.minDistance = radius / 500;
    this.controls.maxDistance = radius * 8;
    this.controls.zoomToCursor = true;
    this.controls.keyPanSpeed = 40;
    this.controls.listenToKeyEvents(canvas);
    this.controls.update();

    this.material = new three.ShaderMaterial({glslVersion: three.GLSL3, side: three.DoubleSide, vertexShader, fragmentShader, uniforms: {
      colouring: {value: 0},
      heights: {value: new three.Vector2(...tileset.extras.heights)},
      brightest: {value: Math.max(tileset.extras.intensityMax, 1)}}});
    this.marked = new three.LineLoop(new three.BufferGeometry(), new three.LineBasicMaterial({color: "#ffffff", depthTest: false}));
    this.marked.renderOrder = 1;
    this.marked.visible = false;
    this.scene.add(this.marked);

    this.tiles = new TilesRenderer(url);
    this.tiles.fetchOptions = {credentials: "same-origin"};
    this.tiles.errorTarget = finest;
    this.tiles.manager.addHandler(/\.glb$/, new GLTFLoader().setMeshoptDecoder(MeshoptDecoder));
    // What is computed in 32 bits is near 0, wherever the data lies.
    this.tiles.group.position.copy(this.origin).multiplyScalar(-1);
    this.tiles.setCamera(this.camera);
    this.tiles.addEventListener("load-model", ({scene}) => this.dress(scene));
    this.tiles.addEventListener("load-error", ({error}) => this.onFailure(error));
    for (const kind of ["load-root-tileset", "needs-update", "tiles-load-end"] as const)
      this.tiles.addEventListener(kind, () => this.draw());
    this.scene.add(this.tiles.group);

    this.controls.addEventListener("change", () => this.move());
    this.listenForClicks();
    addEventListener("theme", this.retheme);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", this.retheme);
    this.size = new ResizeObserver(() => this.fit());
    this.size.observe(canvas.parentElement!);
    this.theme();
    this.fit();
  }

  close(): void {
    this.closed = true;
    cancelAnimationFrame(this.waiting);
    clearTimeout(this.settled);
    this.size.disconnect();
    removeEventListener("theme", this.retheme);
    matchMedia("(prefers-color-scheme: dark)").removeEventListener("change", this.retheme);
    this.controls.dispose();
    this.tiles.dispose();
    this.material.dispose();
    this.marked.geometry.dispose();
    this.renderer.dispose();
  }

  colour(by: Colouring): void {
    this.material.uniforms.colouring.value = colourings.findIndex(([id]) => id === by);
    this.draw();
  }

  // A ring of places of the plane; none takes the mark away. Its heights are those of what is drawn there.
  mark(ring: number[][]): void {
    const caster = new three.Raycaster(), top = this.camera.far, down = new three.Vector3(0, 0, -1);
    const places = ring.flatMap(([x, y]) => {
      const at = new three.Vector3(x - this.origin.x, y - this.origin.y, top);
      caster.set(at, down);
      return [at.x, at.y, caster.intersectObject(this.tiles.group, true)[0]?.point.z ?? this.controls.target.z];
    });
    this.marked.geometry.dispose();
    this.marked.geometry = new three.BufferGeometry().setAttribute("position", new three.Float32BufferAttribute(places, 3));
    this.marked.visible = ring.length > 0;
    this.draw();
  }

  // Where the surface is under a place of the canvas, in pixels from its upper left corner.
  pick(x: number, y: number): [number, number] | null {
    const caster = new three.Raycaster();
    caster.firstHitOnly = true;
    caster.setFromCamera(new three.Vector2(2 * x / this.canvas.clientWidth - 1, 1 - 2 * y / this.canvas.clientHeight), this.camera);
    const hit = caster.intersectObject(this.tiles.group, true)[0];
    return hit ? [hit.point.x + this.origin.x, hit.point.y + this.origin.y] : null;
  }

  private dress(scene: three.Object3D): void {
    scene.traverse(object => {
      const mesh = object as three.Mesh;
      if (!mesh.isMesh) return;
      mesh.material.dispose();
      mesh.material = this.material;
    });
    this.draw();
  }

  // A click is a press and a release at one place.
  private listenForClicks(): void {
    let down: PointerEvent | null = null;
    this.canvas.addEventListener("pointerdown", event => { down = event.isPrimary ? event : null; });
    this.canvas.addEventListener("pointerup", event => {
      if (!down || Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) > 4) return;
      const box = this.canvas.getBoundingClientRect();
      const found = this.pick(event.clientX - box.left, event.clientY - box.top);
      if (found) this.onPick(found);
    });
    this.canvas.addEventListener("keydown", event => {
      if (event.key === "+" || event.key === "=" || event.key === "-") this.step(event.key === "-" ? 1.25 : 0.8);
      if (event.key !== "Enter") return;
      const found = this.pick(this.canvas.clientWidth / 2, this.canvas.clientHeight / 2);
      if (found) this.onPick(found);
    });
  }

  private step(factor: number): void {
    const {target} = this.controls, away = this.camera.position.clone().add(target.clone().multiplyScalar(-1)).multiplyScalar(factor);
    this.camera.position.copy(target).add(away);
    this.controls.update();
    this.draw();
  }

  private theme(): void {
    this.scene.background = new three.Color(getComputedStyle(document.documentElement).getPropertyValue("--sunken").trim());
    this.draw();
  }

  private fit(): void {
    const {clientWidth: width, clientHeight: height} = this.canvas.parentElement!;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  private move(): void {
    this.moving = true;
    clearTimeout(this.settled);
    this.settled = window.setTimeout(() => {
      this.moving = false;
      this.draw();
    }, Math.max(restsMs, 3 * this.took));
    this.draw();
  }

  private draw(): void {
    if (this.waiting || this.closed) return;
    this.waiting = requestAnimationFrame(now => this.frame(now));
  }

  // While something moves, as fine as the machine can draw in time; some times finer when it rests.
  private frame(now: number): void {
    this.waiting = 0;
    if (this.moving && this.moved) {
      this.took = Math.min(now - this.previous, slowestMs);
      this.inTime = Math.min(coarsest, this.inTime * Math.min(2, Math.max(0.97, Math.sqrt(this.took / wantedMs))));
    }
    this.previous = now;
    this.moved = this.moving;
    this.tiles.errorTarget = Math.max(finest, this.moving ? this.inTime : this.inTime / restsFiner);
    this.camera.updateMatrixWorld();
    this.tiles.setResolutionFromRenderer(this.camera, this.renderer);
    this.tiles.update();
    const loading = this.tiles.loadProgress < 1;
    if (loading) this.draw();
    if (loading && !this.moving && now - this.drawn < wantedLoadingMs) return;
    this.drawn = now;
    this.renderer.render(this.scene, this.camera);
    const {dataset} = this.canvas;
    dataset.triangles = String(this.renderer.info.render.triangles);
    dataset.frames = String(Number(dataset.frames ?? 0) + 1);
    dataset.loaded = String(!loading && this.tiles.visibleTiles.size > 0);
  }
}
