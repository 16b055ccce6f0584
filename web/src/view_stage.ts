// A canvas with something on it that is turned, moved, zoomed and clicked at; drawn when something has changed.
import * as three from "three";
import {OrbitControls} from "three/examples/jsm/controls/OrbitControls.js";
import {show} from "./dom";

const wantedMs = 30;
const restsMs = 250;  // without a move; of slow machines, as long as three frames take
const slowestMs = 2000;
const wantedLoadingMs = 250;  // drawing takes the time of loading
const fewestPixels = 0.5;     // a side, of a picture that moves

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

  // `away`: the higher, the more there is around what is seen at first.
  constructor(protected readonly canvas: HTMLCanvasElement, centre: three.Vector3, protected readonly radius: number, away: number) {
    this.renderer = new three.WebGLRenderer({canvas, antialias: !this.software});
    this.ratio = this.software ? 1 : Math.min(devicePixelRatio, 2);
    this.camera = new three.PerspectiveCamera(45, 1, radius / 1000, radius * 20);
    this.camera.up.set(0, 0, 1);
    this.camera.position.copy(centre).add(new three.Vector3(-0.5, -1.2, 0.9).multiplyScalar(radius * away));
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.target.copy(centre);
    this.controls.minDistance = radius / 500;
    this.controls.maxDistance = radius * 8;
    this.controls.zoomToCursor = true;
    this.controls.keyPanSpeed = 40;
    this.controls.listenToKeyEvents(canvas);
    this.controls.update();
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
    this.renderer.dispose();
  }

  // Makes ready what will be drawn. True: more of it is on its way.
  protected prepare(_moving: boolean): boolean { return false; }
  // By how much too slow, or too fast, the last frame of a movement was.
  protected adapt(_factor: number): void { /* nothing depends on it */ }
  protected abstract clicked(caster: three.Raycaster): void;
  protected abstract get shown(): boolean;  // something is
  protected abstract readonly origin: three.Vector3;  // of the scene, in the result's coordinates

  protected draw(): void {
    if (this.waiting || this.closed) return;
    this.waiting = requestAnimationFrame(now => this.frame(now));
  }

  // Of a place of the canvas, in pixels from its upper left corner. What was seen there is kept for who wants to know,
  // as tests do: which place of the canvas (-1 to 1) a point of the result was at.
  private ask(x: number, y: number): void {
    const caster = this.through(x, y), {projectionMatrix, matrixWorldInverse} = this.camera, {origin} = this;
    this.canvas.dataset.seen = JSON.stringify({origin: [origin.x, origin.y, origin.z],
      matrix: new three.Matrix4().multiplyMatrices(projectionMatrix, matrixWorldInverse).elements});
    this.clicked(caster);
  }

  private through(x: number, y: number): three.Raycaster {
    const caster = new three.Raycaster();
    caster.firstHitOnly = true;
    caster.setFromCamera(new three.Vector2(2 * x / this.canvas.clientWidth - 1, 1 - 2 * y / this.canvas.clientHeight), this.camera);
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

  // By software each pixel counts: a picture that moves has a quarter of them, and is whole again when it rests.
  private sharpen(): void {
    const wanted = this.software && this.moving ? this.ratio * fewestPixels : this.ratio;
    if (wanted === this.ratioNow) return;
    this.ratioNow = wanted;
    this.renderer.setPixelRatio(wanted);
  }

  // While something moves, as fine as the machine can draw in time; finer when it rests.
  private frame(now: number): void {
    this.waiting = 0;
    if (this.moving && this.moved) {
      this.took = Math.min(now - this.previous, slowestMs);
      this.adapt(this.took / wantedMs);
    }
    this.previous = now;
    this.moved = this.moving;
    this.sharpen();
    this.camera.updateMatrixWorld();
    const loading = this.prepare(this.moving);
    if (loading) this.draw();
    if (loading && !this.moving && now - this.drawn < wantedLoadingMs) return;
    this.drawn = now;
    this.renderer.render(this.scene, this.camera);
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
