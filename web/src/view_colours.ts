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

// Heights are z of the page's scene.
const vertexShader = `
in float _intensity;
in float _classification;
in float _tile;
out vec3 seen;
out float height;
out float intensity;
flat out int classOf;
flat out int tileOf;
void main() {
  vec4 place = modelMatrix * vec4(position, 1.0);
  vec4 view = viewMatrix * place;
  seen = view.xyz;
  height = place.z;
  intensity = _intensity;
  classOf = int(_classification + 0.5);
  tileOf = int(_tile + 0.5);
  gl_Position = projectionMatrix * view;
}`;

// Lit as facets: a triangle is what is looked at here.
const fragmentShader = `
uniform int colouring;
uniform vec2 heights;
uniform float brightest;
in vec3 seen;
in float height;
in float intensity;
flat in int classOf;
flat in int tileOf;
out vec4 colour;
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
vec3 ofTile(int n) {
  float hue = fract(float(n) * 0.61803399);
  return 0.45 + 0.4 * cos(6.2831853 * (hue + vec3(0.0, 0.33, 0.67)));
}
void main() {
  vec3 plain = colouring == 0 ? onRamp((height - heights.x) / max(heights.y - heights.x, 1e-9))
    : colouring == 1 ? ofClass(classOf)
    : colouring == 2 ? vec3(clamp(intensity / brightest, 0.0, 1.0) * 0.9 + 0.08)
    : ofTile(tileOf);
  vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
  vec3 sun = normalize((viewMatrix * vec4(-0.4, 0.5, 0.75, 0.0)).xyz);
  colour = vec4(plain * (0.45 + 0.6 * abs(dot(normal, sun))), 1.0);
}`;

// What there is to colour by.
export interface Colours {
  heights: [number, number]; intensityMax: number; classes: number[]; attributes: string[]; tiles: number;
}

// `level`: the height of the result that is 0 in the scene.
export function surfaceMaterial(colours: Colours, level: number): three.ShaderMaterial {
  const [low, high] = colours.heights;
  return new three.ShaderMaterial({glslVersion: three.GLSL3, side: three.DoubleSide, vertexShader, fragmentShader, uniforms: {
    colouring: {value: 0},
    heights: {value: new three.Vector2(low - level, high - level)},
    brightest: {value: Math.max(colours.intensityMax, 1)}}});
}
