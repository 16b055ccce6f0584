// Where a camera stands so that a box fills its picture.
export type Triple = [number, number, number];

const filled = 0.9;  // of the picture's width or height

const dot = (a: Triple, b: Triple) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Triple, b: Triple): Triple => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const along = (a: Triple, b: Triple, by: number): Triple => [a[0] + b[0] * by, a[1] + b[1] * by, a[2] + b[2] * by];
function unit(a: Triple): Triple {
  const length = Math.hypot(...a) || 1;
  return [a[0] / length, a[1] / length, a[2] / length];
}

export function corners(low: Triple, high: Triple): Triple[] {
  return [0, 1, 2, 3, 4, 5, 6, 7].map(bits => [0, 1, 2].map(axis => (bits >> axis & 1 ? high : low)[axis]) as Triple);
}

// `from`: the direction in which the camera stands, seen from what it looks at. `slope`: the tangent of half the angle
// that it sees, from the lower to the upper edge; `aspect`: how much more from left to right.
export function standpoint(low: Triple, high: Triple, from: Triple, slope: number, aspect: number): {target: Triple; position: Triple} {
  const back = unit(from), up: Triple = Math.abs(back[2]) > 0.999 ? [0, 1, 0] : [0, 0, 1];
  const right = unit(cross(up, back)), over = cross(back, right);
  const middle = [0, 1, 2].map(axis => (low[axis] + high[axis]) / 2) as Triple;
  const places = corners(low, high).map(corner => along(corner, middle, -1)), near = places.map(at => dot(at, back));
  const sides = [[right, slope * aspect], [over, slope]] as const;
  const distance = Math.max(...sides.map(([side, tangent]) => {
    const ends = places.map((at, i) => [dot(at, side) + near[i] * tangent, dot(at, side) - near[i] * tangent]);
    return (Math.max(...ends.map(([most]) => most)) - Math.min(...ends.map(([, least]) => least))) / 2 / tangent;
  })) / filled || 1;
  let target = middle;
  for (const [side] of sides) target = along(target, side, balance(places.map(at => dot(at, side)), near, distance));
  return {target, position: along(target, back, distance)};
}

// What is nearer looks larger, so the mean is not in the middle of the picture: how far to the side one must look for as
// much room on both sides.
function balance(across: number[], near: number[], distance: number): number {
  let low = Math.min(...across), high = Math.max(...across);
  for (let i = 0; i < 50; ++i) {
    const tried = (low + high) / 2, seen = across.map((at, k) => (at - tried) / (distance - near[k]));
    if (Math.max(...seen) + Math.min(...seen) > 0) low = tried;
    else high = tried;
  }
  return (low + high) / 2;
}
