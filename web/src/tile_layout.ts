// Where tiles are drawn: as seen from above, side by side. A plane that cuts by height cuts the drawn rectangle across its
// longer side, so that no tile hides another and every tile's share of the picture is its share of the space.
import {Layout} from "./api";

export interface Plan {
  // Of each tile left, top, right, bottom, in a picture of width 1 and height `height`. Neighbours have the same edges, to
  // the last bit: rounded to pixels, too, they leave no gap.
  rectangles: Float64Array;
  height: number;
  rows: Float64Array;  // the same of each row of the layout, with all that is below it
  layout?: Layout;
}

interface Part { row: number; lo: number[]; hi: number[]; left: number; top: number; right: number; bottom: number }

function moved(corner: number[], axis: number, place: number): number[] {
  return corner.map((value, each) => each === axis ? place : value);
}

// Tiles without a place stand in rows.
function inRows(tiles: number): Plan {
  const columns = Math.max(1, Math.ceil(Math.sqrt(tiles * 2))), rows = Math.ceil(tiles / columns);
  const size = 1 / columns, rectangles = new Float64Array(tiles * 4);
  for (let tile = 0; tile < tiles; ++tile)
    rectangles.set([tile % columns, Math.floor(tile / columns), tile % columns + 1, Math.floor(tile / columns) + 1]
      .map(place => place * size), tile * 4);
  return {rectangles, height: rows * size, rows: new Float64Array(0)};
}

export function planOf(layout: Layout | undefined, tiles: number): Plan {
  if (!layout || layout.axis.length === 0 || layout.bounds.length !== 6) return inRows(tiles);
  const [x0, y0, z0, x1, y1, z1] = layout.bounds;
  const height = Math.min(1.6, Math.max(0.25, (y1 - y0) / (x1 - x0) || 1));
  const rectangles = new Float64Array(tiles * 4), rows = new Float64Array(layout.axis.length * 4);
  const parts: Part[] = [{row: 0, lo: [x0, y0, z0], hi: [x1, y1, z1], left: 0, top: 0, right: 1, bottom: height}];
  for (let part = parts.pop(); part; part = parts.pop()) {
    if (part.row < 0) {
      const tile = -1 - part.row;
      if (tile < tiles) rectangles.set([part.left, part.top, part.right, part.bottom], tile * 4);
      continue;
    }
    rows.set([part.left, part.top, part.right, part.bottom], part.row * 4);
    const axis = layout.axis[part.row], place = layout.place[part.row];
    const size = part.hi[axis] - part.lo[axis];
    const share = size > 0 ? Math.min(1, Math.max(0, (place - part.lo[axis]) / size)) : 0.5;
    const across = axis === 0 || (axis === 2 && part.right - part.left >= part.bottom - part.top);
    const below: Part = {...part, row: layout.below[part.row], hi: moved(part.hi, axis, place)};
    const above: Part = {...part, row: layout.above[part.row], lo: moved(part.lo, axis, place)};
    if (across) below.right = above.left = part.left + (part.right - part.left) * share;
    else below.top = above.bottom = part.top + (part.bottom - part.top) * (1 - share);  // north is up
    parts.push(below, above);
  }
  return {rectangles, height, rows, layout};
}

// How many are below a row of the layout.
export function tilesOf(plan: Plan, row: number): number {
  let tiles = 0;
  const parts = [row];
  for (let part = parts.pop(); part !== undefined && plan.layout; part = parts.pop()) {
    if (part < 0) ++tiles;
    else parts.push(plan.layout.below[part], plan.layout.above[part]);
  }
  return tiles;
}
