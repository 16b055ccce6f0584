// How a surface is coloured, for its shader and for the legend that explains it.
import * as three from "three";

export type Colouring = "height" | "class" | "intensity" | "tile";
export const colourings: [Colouring, string][] = [["height", "Height"], ["class", "Class"], ["intensity", "Intensity"], ["tile", "Tile"]];

// From low to high; even in lightness, and told apart by all kinds of sight (after "viridis" of matplotlib, CC0).
export const ramp = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

// Of the ASPRS, those that are common; others are grey.
export const classes: Record<number, [string, number[]]> = {
  1: ["Unclassified", [170, 170, 170]], 2: ["Ground", [190, 140, 90]], 3: ["Low vegetation", [170, 210, 110]],
  4: ["Medium vegetation", [100, 180, 80]], 5: ["High vegetation", [40, 130, 60]], 6: ["Building", [215, 80, 70]],
  7: ["Noise", [230, 60, 200]], 9: ["Water", [70, 140, 220]], 10: ["Rail", [120, 90, 150]], 11: ["Road", [110, 110, 120]],
  17: ["Bridge", [240, 190, 60]], 18: ["High noise", [230, 60, 200]],
};
const grey = [140, 140, 140];

export const classColour = (number: number): number[] => classes[number]?.[1] ?? grey;
export const className = (number: number): string => classes[number]?.[0] ?? `Class ${number}`;

const vec3 = (colour: number[]) => `vec3(${colour.map(c => (c / 255).toFixed(4)).join(", ")})`;

const colourOfClass = Object.entries(classes).map(([number, [, colour]]) => `  if (n == ${number}) return ${vec3(colour)};`).join("\n");

// Of one way to colour. Where software draws it runs all of a shader, also what is behind a condition: so each way has a
// program of its own, and a colour is found for a vertex, of which there are fewer than of pixels. Heights are z of the
// page's scene. What has no values between is that of one corner.
const vertexShader = (by: Colouring) => `
uniform vec2 heights;
uniform vec2 stretched;
uniform float brightest;
in float ${{height: "_tile", class: "_classification", intensity: "_intensity", tile: "_tile"}[by]};
out vec3 seen;
${by === "class" || by === "tile" ? "flat " : ""}out vec3 plain;
vec3 onRamp(float part) {
  float at = clamp(part, 0.0, 1.0) * ${(ramp.length - 1).toFixed(1)};
  vec3 mixed = ${vec3(ramp[0])};
${ramp.slice(1).map((next, i) => `  mixed = mix(mixed, ${vec3(next)}, clamp(at - ${i.toFixed(1)}, 0.0, 1.0));`).join("\n")}
  return mixed;
}
vec3 ofClass(int n) {
${colourOfClass}
  return ${vec3(grey)};
}
vec3 ofTile(float n) {
  float hue = fract(n * 0.61803399);
  return 0.45 + 0.4 * cos(6.2831853 * (hue + vec3(0.0, 0.33, 0.67)));
}
void main() {
  vec4 place = modelMatrix * vec4(position, 1.0);
  float level = place.z;
  place.z = stretched.x + (place.z - stretched.x) * stretched.y;
  vec4 view = viewMatrix * place;
  seen = view.xyz;
  plain = ${{
    height: "onRamp((level - heights.x) / max(heights.y - heights.x, 1e-9))", class: "ofClass(int(_classification + 0.5))",
    intensity: "vec3(clamp(_intensity / brightest, 0.0, 1.0) * 0.9 + 0.08)", tile: "ofTile(_tile)"}[by]};
  gl_Position = projectionMatrix * view;
}`;

// Lit as facets: a triangle is what is looked at here.
const fragmentShader = (by: Colouring) => `
uniform vec3 sun;
in vec3 seen;
${by === "class" || by === "tile" ? "flat " : ""}in vec3 plain;
out vec4 colour;
void main() {
  vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
  colour = vec4(plain * (0.45 + 0.6 * abs(dot(normal, sun))), 1.0);
}`;

// What there is to colour by.
export interface Colours {
  heights: [number, number]; intensityMax: number; classes: number[]; attributes: string[]; tiles: number;
}

// The ways to colour what has such values. `level`: the height of the result that is 0 in the scene.
export class Materials {
  private readonly sun = new three.Vector3();
  private readonly stretched = new three.Vector2(0, 1);  // the height that stays where it is, and by what heights from it on are multiplied
  private readonly made = new Map<Colouring, three.ShaderMaterial>();

  constructor(private readonly colours: Colours, private readonly level: number, private readonly more: object = {}) {}

  stretch(middle: number, times: number): void { this.stretched.set(middle, times); }

  get(by: Colouring): three.ShaderMaterial {
    const material = this.made.get(by) ?? new three.ShaderMaterial({glslVersion: three.GLSL3, side: three.DoubleSide,
      vertexShader: vertexShader(by), fragmentShader: fragmentShader(by), uniforms: {
        heights: {value: new three.Vector2(this.colours.heights[0] - this.level, this.colours.heights[1] - this.level)},
        stretched: {value: this.stretched},
        brightest: {value: Math.max(this.colours.intensityMax, 1)},
        sun: {value: this.sun}}, ...this.more});
    this.made.set(by, material);
    return material;
  }

  // Where the light comes from, seen from the camera: it stays where it is in the scene.
  light(camera: three.Camera): void {
    this.sun.set(-0.4, 0.5, 0.75).normalize().transformDirection(camera.matrixWorldInverse);
  }

  dispose(): void { for (const material of this.made.values()) material.dispose(); }
}
