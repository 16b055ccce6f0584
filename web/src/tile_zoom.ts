// Which part of a map is seen, and where on it many tiles are too small to be seen. The map is 1 wide and `height` high.
const farthest = 1e6;

export class MapPart {
  zoom = 1;
  left = 0;
  top = 0;
  constructor(private height = 1) {}

  of(height: number): void {
    this.height = height;
    this.whole();
  }

  whole(): void {
    [this.zoom, this.left, this.top] = [1, 0, 0];
  }

  // What is at this place of the map stays where it is seen.
  closer(factor: number, x: number, y: number): void {
    const zoom = Math.min(farthest, Math.max(1, this.zoom * factor)), kept = this.zoom / zoom;
    this.left = x - (x - this.left) * kept;
    this.top = y - (y - this.top) * kept;
    this.zoom = zoom;
    this.inside();
  }

  move(x: number, y: number): void {
    this.left += x;
    this.top += y;
    this.inside();
  }

  // All of a box, with some room around it.
  show([left, top, right, bottom]: number[]): void {
    this.zoom = Math.min(farthest, Math.max(1, 0.8 / Math.max(right - left, (bottom - top) / this.height, 1 / farthest)));
    this.left = (left + right - 1 / this.zoom) / 2;
    this.top = (top + bottom - this.height / this.zoom) / 2;
    this.inside();
  }

  private inside(): void {
    this.left = Math.min(1 - 1 / this.zoom, Math.max(0, this.left));
    this.top = Math.min(this.height - this.height / this.zoom, Math.max(0, this.top));
  }
}

export interface Spot { box: number[]; tiles: number; x: number; y: number }

const tiny = 3, spotSize = 32, spotsMost = 12, large = 6;  // in pixels, but for how many

// Where tiles are too small, while there would be room for all of them if they were alike. `stages`: of tiles with points.
export function spotsOf(rectangles: Float64Array, stages: string, part: MapPart, width: number, height: number): Spot[] {
  const scale = width * part.zoom, spots = new Map<string, Spot>();
  if (width * height < large * large * stages.length) return [];
  for (let tile = 0; tile < stages.length; ++tile) {
    const [left, top, right, bottom] = rectangles.subarray(4 * tile, 4 * tile + 4);
    const x = ((left + right) / 2 - part.left) * scale, y = ((top + bottom) / 2 - part.top) * scale;
    if (stages[tile] === "e" || right === left || Math.max(right - left, bottom - top) * scale > tiny || x < 0 || y < 0 || x > width || y > height) continue;
    const key = `${Math.floor(x / spotSize)} ${Math.floor(y / spotSize)}`;
    const spot = spots.get(key) ?? {box: [left, top, right, bottom], tiles: 0, x, y};
    spot.box = [Math.min(spot.box[0], left), Math.min(spot.box[1], top), Math.max(spot.box[2], right), Math.max(spot.box[3], bottom)];
    ++spot.tiles;
    spots.set(key, spot);
  }
  return [...spots.values()].filter(spot => spot.tiles > 1).sort((a, b) => b.tiles - a.tiles).slice(0, spotsMost);
}
