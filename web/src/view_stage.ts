// A canvas with something on it that is turned, moved, zoomed and clicked at; drawn when something has changed.
import * as three from "three";
import {OrbitControls} from "three/examples/jsm/controls/OrbitControls.js";
import {show} from "./dom";
import {standpoint, Triple} from "./view_camera";
import {Overlay} from "./view_overlay";

const wantedMs = 30;
const restsMs = 250;  // without a move; of slow machines, as long as three frames take
const slowestMs = 2000;
const wantedLoadingMs = 250;  // drawing takes the time of loading
const fewestPixels = 0.5;     // a side, of a picture that moves
const first: Triple = [-0.5, -1.2, 0.9], above: Triple = [0, -1e-4, 1];  // where the camera stands: at first, and for maps

// Whether no graphics processor draws, which takes many times as long.
function drawsBySoftware(): boolean {
  const probe = document.createElement("canvas").getContext("webgl2", {failIfMajorPerformanceCaveat: true});
  if (!probe) return true;
  const told = probe.getExtension("WEBGL_debug_renderer_info");
  const name = String(told ? probe.getParameter(told.UNMASKED_RENDERER_WEBGL) : "");
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export abstract class Stage {
  onFailure: (error: Error) => void = () => undefined;
  protected readonly renderer: three.WebGLRenderer;
  protected readonly scene = new three.Scene();
  protected readonly world = new three.Group();  // its heights are stretched; shaders of Materials do that themselves
  protected readonly overlay: Overlay;
  protected readonly camera: three.PerspectiveCamera;
  protected readonly controls: OrbitControls;
  protected readonly software = drawsBySoftware();
  private readonly size: ResizeObserver;
  private readonly retheme = () => this.theme();
  private readonly ratio: number;  // pixels of the canvas a pixel of the page, at rest
  private ratioNow = 0;
  private moving = false;
  private moved = false;  // when the last frame was drawn
  private drawn = 0;      // when it was
  private took = 0;       // a frame while moving, in ms
  private waiting = 0;    // the frame that is asked for
  private previous = 0;   // when the last one was
  private settled = 0;
  private closed = false;
  protected stretch = 1;
  private framed: [Triple, Triple];  // the box that fills the picture, of the scene, as high as it is
  private touched = false;           // somebody has chosen where to look from
  private triangle: Triple[] = [];     // of the triangle that was clicked at
  protected readonly radius: number;

  // `low`, `high`: the box around all that there is, of the scene. `unit`: of its coordinates.
  constructor(protected readonly canvas: HTMLCanvasElement, private readonly low: Triple, private readonly high: Triple, unit: string) {
    this.framed = [low, high];
    const radius = this.radius = Math.hypot(...low.map((value, axis) => high[axis] - value)) / 2 || 1;
    this.renderer = new three.WebGLRenderer({canvas, antialias: !this.software});
    this.ratio = this.software ? 1 : Math.min(devicePixelRatio, 2);
    this.overlay = new Overlay(canvas.parentElement!, unit);
    this.scene.add(this.world);
    this.camera = new three.PerspectiveCamera(45, 1, radius / 1000, radius * 20);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.keyPanSpeed = 40;
    this.controls.listenToKeyEvents(canvas);
    this.controls.addEventListener("change", () => this.move());
    this.controls.addEventListener("start", () => { this.touched = true; });
    canvas.addEventListener("keydown", event => { this.touched ||= event.key.startsWith("Arrow"); });
    this.reach();
    this.resize();
    this.stand(first);
    this.listenForClicks();
    addEventListener("theme", this.retheme);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", this.retheme);
    this.size = new ResizeObserver(() => {
      this.resize();
      if (!this.touched) this.stand(this.direction);
    });
    this.size.observe(canvas.parentElement!);
    this.theme();
  }

  // All that is looked at fills the picture, seen from where it is seen.
  fit(): void { this.stand(this.direction); }
  // The same from above, north up.
  top(): void { this.stand(above); }

  // Heights are drawn as so many times what they are.
  exaggerate(times: number): void {
    this.stretch = times;
    this.world.scale.set(1, 1, times);
    this.world.position.set(0, 0, this.middle * (1 - times));
    this.world.updateMatrixWorld(true);
    this.reach();
    this.stretched(this.middle, times);
    if (this.touched) this.draw();
    else this.stand(this.direction);
  }

  // What a box of the scene fills of the picture; with `once` without being what fit() shows.
  frame(low: Triple, high: Triple, once = false): void {
    if (!once) this.framed = [low, high];
    this.touched ||= once;
    this.stand(this.direction, [low, high]);
    if (once) this.pan([0, 1, 2].map(axis => (low[axis] + high[axis]) / 2) as Triple);
  }

  // A place of the scene comes into the middle of the picture.
  private pan([x, y, z]: Triple): void {
    const to = new three.Vector3(x, y, this.drawnAt(z)), {direction: [dx, dy, dz]} = this;
    this.controls.target.copy(to);
    this.camera.position.copy(to).add(new three.Vector3(dx, dy, dz));
    this.controls.update();
    this.draw();
  }

  // Turns around the middle of this box, from as far as before.
  turnAround(low: Triple, high: Triple): void {
    this.framed = [low, high];
    this.pan(low.map((value, axis) => (value + high[axis]) / 2) as Triple);
  }

  private get middle(): number { return (this.low[2] + this.high[2]) / 2; }
  // Where a height is drawn, and which height is drawn there.
  private drawnAt(z: number): number { return this.middle + (z - this.middle) * this.stretch; }
  private unstretched(z: number): number { return this.middle + (z - this.middle) / this.stretch; }

  private get direction(): Triple {
    const away = this.camera.position.clone().add(this.controls.target.clone().multiplyScalar(-1));
    return [away.x, away.y, away.z];
  }

  private stand(from: Triple, [low, high] = this.framed): void {
    const stretched = (at: Triple): Triple => [at[0], at[1], this.drawnAt(at[2])];
    const {target, position} = standpoint(stretched(low), stretched(high), from, Math.tan(this.camera.fov * Math.PI / 360), this.camera.aspect);
    this.controls.target.set(...target);
    this.camera.position.set(...position);
    this.controls.update();
    this.draw();
  }

  // How near and how far one may go.
  private reach(): void {
    const radius = Math.hypot(this.high[0] - this.low[0], this.high[1] - this.low[1], (this.high[2] - this.low[2]) * this.stretch) / 2 || 1;
    this.controls.minDistance = radius / 5000;
    this.controls.maxDistance = radius * 12;
    this.camera.far = radius * 30;
    this.camera.updateProjectionMatrix();
  }

  close(): void {
    this.closed = true;
    cancelAnimationFrame(this.waiting);
    clearTimeout(this.settled);
    this.size.disconnect();
    removeEventListener("theme", this.retheme);
    matchMedia("(prefers-color-scheme: dark)").removeEventListener("change", this.retheme);
    this.controls.dispose();
    this.renderer.dispose();
  }

  // Makes ready what will be drawn. True: more of it is on its way.
  protected prepare(_moving: boolean): boolean { return false; }
  // By how much too slow, or too fast, the last frame of a movement was.
  protected adapt(_factor: number): void { /* nothing depends on it */ }
  // A ray through what is not stretched.
  protected abstract clicked(caster: three.Raycaster): void;
  // Materials draw heights so from now on.
  protected abstract stretched(middle: number, times: number): void;
  protected abstract get shown(): boolean;  // something is
  protected abstract readonly origin: three.Vector3;  // of the scene, in the result's coordinates

  protected draw(): void {
    if (this.waiting || this.closed) return;
    this.waiting = requestAnimationFrame(now => this.render(now));
  }

  // Of a place of the canvas, in pixels from its upper left corner. What was seen there is kept for who wants to know,
  // as tests do: which place of the canvas (-1 to 1) a point of the result was at.
  private ask(x: number, y: number): void {
    const caster = this.through(x, y), {projectionMatrix, matrixWorldInverse} = this.camera, {origin} = this;
    this.canvas.dataset.seen = JSON.stringify({origin: [origin.x, origin.y, origin.z],
      matrix: new three.Matrix4().multiplyMatrices(new three.Matrix4().multiplyMatrices(projectionMatrix, matrixWorldInverse), this.world.matrixWorld).elements});
    this.clicked(caster);
  }

  private through(x: number, y: number): three.Raycaster {
    const caster = new three.Raycaster();
    caster.firstHitOnly = true;
    caster.setFromCamera(new three.Vector2(2 * x / this.canvas.clientWidth - 1, 1 - 2 * y / this.canvas.clientHeight), this.camera);
    const {origin, direction} = caster.ray;
    caster.ray.origin.set(origin.x, origin.y, this.unstretched(origin.z));
    caster.ray.direction.set(direction.x, direction.y, direction.z / this.stretch).normalize();
    return caster;
  }

  // A click is a press and a release at one place.
  private listenForClicks(): void {
    let down: PointerEvent | null = null;
    this.canvas.addEventListener("pointerdown", event => { down = event.isPrimary && !event.shiftKey ? event : null; });
    this.canvas.addEventListener("pointerup", event => {
      if (!down || Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) > 4) return;
      const box = this.canvas.getBoundingClientRect();
      this.ask(event.clientX - box.left, event.clientY - box.top);
    });
    this.canvas.addEventListener("keydown", event => {
      if (event.key === "+" || event.key === "=" || event.key === "-") this.step(event.key === "-" ? 1.25 : 0.8);
      if (event.key === "Enter") this.ask(this.canvas.clientWidth / 2, this.canvas.clientHeight / 2);
    });
  }

  private step(factor: number): void {
    this.touched = true;
    const {target} = this.controls, away = this.camera.position.clone().add(target.clone().multiplyScalar(-1)).multiplyScalar(factor);
    this.camera.position.copy(target).add(away);
    this.controls.update();
    this.draw();
  }

  private theme(): void {
    this.scene.background = new three.Color(getComputedStyle(document.documentElement).getPropertyValue("--sunken").trim());
    this.draw();
  }

  // The corners of a triangle, of the scene; none takes it away.
  protected markTriangle(corners: Triple[]): void {
    this.triangle = corners;
    this.draw();
  }

  protected get markedHeights(): number[] { return this.triangle.map(at => at[2]); }

  private drawOverlay(): void {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    const away = this.camera.position.distanceTo(this.controls.target);
    this.overlay.measure(2 * away * Math.tan(this.camera.fov * Math.PI / 360) / height);
    const seen = this.triangle.map(([x, y, z]) => new three.Vector3(x, y, this.drawnAt(z)).project(this.camera));
    this.overlay.mark(seen.some(at => at.z > 1) ? [] : seen.map(at => [(at.x + 1) / 2 * width, (1 - at.y) / 2 * height]));
  }

  private resize(): void {
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

  // By software each pixel counts: a picture that moves has a quarter of them, and is whole again when it rests.
  private sharpen(): void {
    const wanted = this.software && this.moving ? this.ratio * fewestPixels : this.ratio;
    if (wanted === this.ratioNow) return;
    this.ratioNow = wanted;
    this.renderer.setPixelRatio(wanted);
  }

  // While something moves, as fine as the machine can draw in time; finer when it rests.
  private render(now: number): void {
    this.waiting = 0;
    if (this.moving && this.moved) {
      this.took = Math.min(now - this.previous, slowestMs);
      this.adapt(this.took / wantedMs);
    }
    this.previous = now;
    this.moved = this.moving;
    this.sharpen();
    // As near as what is looked at needs, so that depths are told apart.
    this.camera.near = Math.min(this.radius / 1000, this.camera.position.distanceTo(this.controls.target) / 20);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    const loading = this.prepare(this.moving);
    if (loading) this.draw();
    if (loading && !this.moving && now - this.drawn < wantedLoadingMs) return;
    this.drawn = now;
    this.renderer.render(this.scene, this.camera);
    this.drawOverlay();
    const {dataset} = this.canvas, {triangles, calls} = this.renderer.info.render;
    dataset.triangles = String(triangles);
    dataset.calls = String(calls);
    dataset.frames = String(Number(dataset.frames ?? 0) + 1);
    dataset.loaded = String(!loading && this.shown);
  }
}

// What is drawn, or a sentence instead of an empty picture.
export function drawable<T>(stage: HTMLElement, make: () => T): T {
  try {
    return make();
  } catch (error) {
    show(stage, false);
    throw new Error(`This browser cannot draw in 3D (WebGL 2): ${error instanceof Error ? error.message : String(error)}`);
  }
}
