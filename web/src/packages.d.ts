// What src/base/phases_json.cc writes.
declare module "phases" {
  // `tiles` counts the tiles of a node that are as far as the phase goes, and they are called `tilesAre`.
  export interface PhaseRow { name: string; words: string; over: boolean; tiles: "tilesTriangulated" | "tilesStored"; tilesAre: string }
  const rows: readonly PhaseRow[];
  export default rows;
}
// What the viewer uses of its packages, which bring no types of their own that this compiler reads.
declare module "three" {
  export class Vector2 { constructor(x?: number, y?: number); x: number; y: number; set(x: number, y: number): this }
  export class Vector3 {
    constructor(x?: number, y?: number, z?: number);
    x: number; y: number; z: number;
    set(x: number, y: number, z: number): this;
    copy(v: Vector3): this;
    clone(): Vector3;
    add(v: Vector3): this;
    multiplyScalar(s: number): this;
    normalize(): this;
    project(camera: Camera): this;
    applyMatrix4(m: Matrix4): this;
    transformDirection(m: Matrix4): this;
    length(): number;
    distanceTo(v: Vector3): number;
  }
  export class Color { constructor(colour?: string | number); set(colour: string | number): this; setRGB(r: number, g: number, b: number): this }
  export class Sphere { constructor(); center: Vector3; radius: number }
  export class Object3D {
    position: Vector3; scale: Vector3; matrixWorld: Matrix4; matrixAutoUpdate: boolean; frustumCulled: boolean; visible: boolean; renderOrder: number; userData: unknown; children: Object3D[]; parent: Object3D | null;
    add(...objects: Object3D[]): this;
    remove(...objects: Object3D[]): this;
    traverse(visit: (object: Object3D) => void): void;
    updateMatrixWorld(force?: boolean): void;
  }
  export class Group extends Object3D {}
  export class Scene extends Object3D { background: Color | null }
  export class Camera extends Object3D { up: Vector3; projectionMatrix: Matrix4; matrixWorldInverse: Matrix4 }
  export class Matrix4 { constructor(); elements: number[]; multiplyMatrices(a: Matrix4, b: Matrix4): this; copy(m: Matrix4): this; invert(): this }
  export class PerspectiveCamera extends Camera {
    constructor(fov: number, aspect: number, near: number, far: number);
    aspect: number; near: number; far: number; fov: number;
    updateProjectionMatrix(): void;
  }
  export class BufferAttribute { constructor(array: ArrayLike<number>, itemSize: number); array: ArrayLike<number>; count: number; needsUpdate: boolean; getX(at: number): number; getY(at: number): number; getZ(at: number): number }
  export class Float32BufferAttribute extends BufferAttribute {}
  export class BufferGeometry {
    index: BufferAttribute | null;
    attributes: Record<string, BufferAttribute>;
    setAttribute(name: string, attribute: BufferAttribute): this;
    setIndex(index: number[] | BufferAttribute): this;
    dispose(): void;
  }
  export class Material { dispose(): void }
  export interface Uniform { value: unknown }
  export class ShaderMaterial extends Material {
    constructor(parameters: {uniforms: Record<string, Uniform>; vertexShader: string; fragmentShader: string; side?: number; glslVersion?: string});
    uniforms: Record<string, Uniform>;
  }
  export class LineBasicMaterial extends Material {
    constructor(parameters: {color: number | string; depthTest?: boolean; opacity?: number; transparent?: boolean});
    color: Color; opacity: number;
  }
  export class MeshBasicMaterial extends Material {
    constructor(parameters: {color: number | string; depthWrite?: boolean; opacity?: number; transparent?: boolean; side?: number});
  }
  export class SphereGeometry extends BufferGeometry { constructor(radius: number, across: number, up: number) }
  export class Mesh extends Object3D { constructor(geometry: BufferGeometry, material: Material); isMesh: true; geometry: BufferGeometry; material: Material }
  export class LineLoop extends Object3D { constructor(geometry: BufferGeometry, material: Material); geometry: BufferGeometry; material: Material }
  export class LineSegments extends LineLoop {}
  export interface Intersection { point: Vector3; distance: number; object: Object3D; faceIndex?: number }
  export class Raycaster {
    firstHitOnly: boolean; ray: {origin: Vector3; direction: Vector3};
    set(origin: Vector3, direction: Vector3): void;
    setFromCamera(at: Vector2, camera: Camera): void;
    intersectObject(object: Object3D, recursive?: boolean): Intersection[];
  }
  export class WebGLRenderer {
    constructor(parameters: {canvas: HTMLCanvasElement; antialias?: boolean});
    info: {render: {triangles: number; calls: number}};
    setPixelRatio(ratio: number): void;
    setSize(width: number, height: number, style?: boolean): void;
    render(scene: Scene, camera: Camera): void;
    dispose(): void;
  }
  export const DoubleSide: number;
  export const GLSL3: string;
}
declare module "three/examples/jsm/controls/OrbitControls.js" {
  import {Camera, Vector3} from "three";
  export class OrbitControls {
    constructor(camera: Camera, element: HTMLElement);
    target: Vector3; maxPolarAngle: number; minDistance: number; maxDistance: number; screenSpacePanning: boolean;
    keyPanSpeed: number; zoomToCursor: boolean; enabled: boolean;
    listenToKeyEvents(element: HTMLElement): void;
    addEventListener(kind: "change" | "start" | "end", then: () => void): void;
    update(): void;
    dispose(): void;
  }
}
declare module "three/examples/jsm/loaders/GLTFLoader.js" {
  import {Group} from "three";
  export class GLTFLoader {
    constructor();
    setMeshoptDecoder(decoder: unknown): this;
    parseAsync(data: ArrayBuffer, path: string): Promise<{scene: Group}>;
  }
}
declare module "3d-tiles-renderer/three" {
  import {Camera, Group, Object3D, Sphere, WebGLRenderer} from "three";
  export class TilesRenderer {
    constructor(url: string);
    group: Group; errorTarget: number; fetchOptions: RequestInit; loadProgress: number; visibleTiles: Set<unknown>;
    manager: {addHandler(pattern: RegExp, loader: unknown): void};
    lruCache: {maxBytesSize: number; minBytesSize: number};
    setCamera(camera: Camera): boolean;
    setResolutionFromRenderer(camera: Camera, renderer: WebGLRenderer): boolean;
    getBoundingSphere(sphere: Sphere): boolean;
    addEventListener(kind: "load-model" | "dispose-model", then: (event: {scene: Object3D}) => void): void;
    addEventListener(kind: "load-error", then: (event: {error: Error}) => void): void;
    addEventListener(kind: "load-root-tileset" | "needs-update" | "tiles-load-end", then: () => void): void;
    update(): void;
    dispose(): void;
  }
}
declare module "meshopt-decoder" {
  export const MeshoptDecoder: {ready: Promise<void>; supported: boolean};
}
