// A result on the map: the hillshade that the service draws of its raster, and its contour lines over it.
import {address, get} from "./api";
import {h, replace, say, show, svg} from "./dom";
import {count} from "./format";

interface TileSet { boundingBox: {lowerLeft: number[]; upperRight: number[]} }
interface Collection { extent: {spatial: {bbox: number[][]}} }
interface Lines { features: {geometry: {coordinates: number[][]}}[]; numberMatched: number }

const highest = 420, deepest = 24, side = 256;  // in pixels; the map's last level; of a tile
const linesMost = 2000;                         // that are drawn

// On the square of Web Mercator, from 0 to 1, of longitude and latitude.
function place([longitude, latitude]: number[]): [number, number] {
  const sine = Math.sin(latitude * Math.PI / 180);
  return [longitude / 360 + 0.5, 0.5 - Math.log((1 + sine) / (1 - sine)) / 4 / Math.PI];
}

export class MapPicture {
  private readonly frame = h("div", {class: "map-picture", role: "img"});
  private readonly words = h("p", {class: "sub"});
  readonly element = h("figure", {class: "map-figure"}, this.frame, h("figcaption", {}, this.words));
  constructor() { show(this.element, false); }

  // `map`, `lines`: what there is.
  async tell(name: string, map: boolean, lines: boolean): Promise<void> {
    const collection = address("collections", `${name}.contours`);
    const box = map ? await get<TileSet>(address("triangulations", name, "map", "tiles", "WebMercatorQuad"))
      .then(set => [...set.boundingBox.lowerLeft, ...set.boundingBox.upperRight]) : (await get<Collection>(collection)).extent.spatial.bbox[0];
    const drawn = lines ? await get<Lines>(`${collection}/items?limit=${linesMost}`) : null;
    const [left, low] = place(box), [right, top] = place(box.slice(2));
    const width = Math.max(right - left, 1e-12), height = Math.max(low - top, 1e-12);
    const room = Math.min(this.frame.parentElement!.clientWidth || 600, 900);
    const scale = Math.min(room / width, highest / height);  // pixels of the whole square
    this.frame.style.width = `${width * scale}px`;
    this.frame.style.aspectRatio = `${width / height}`;  // where there is less room it is smaller
    replace(this.frame, ...(map ? this.tiles(name, [left, top, right, low], scale) : []));
    if (drawn) this.frame.append(this.paths(drawn, left, top, width, height));
    const what = [map ? "the hillshade of dem.tif" : "", drawn ? "the lines of contours.gpkg" : ""].filter(each => each !== "").join(" and ");
    this.frame.setAttribute("aria-label", `Map of ${name}: ${what}`);
    const some = drawn && drawn.numberMatched > drawn.features.length ? `, ${count(drawn.features.length)} of ${count(drawn.numberMatched)}` : "";
    say(this.words, `On the map, north up: ${what}${some}.`);
  }

  // At the first level at which a tile has a pixel for each that is seen.
  private tiles(name: string, [left, top, right, low]: number[], scale: number): HTMLElement[] {
    const level = Math.min(deepest, Math.max(0, Math.ceil(Math.log2(scale / side)))), across = 2 ** level;
    const part = (value: number, of: number) => `${100 * value / of}%`, width = right - left, height = low - top;
    const images: HTMLElement[] = [];
    for (let row = Math.floor(top * across); row <= Math.min(across - 1, Math.floor(low * across)); ++row)
      for (let column = Math.floor(left * across); column <= Math.min(across - 1, Math.floor(right * across)); ++column) {
        const image = h("img", {alt: "", src: `${address("triangulations", name, "map", "tiles", "WebMercatorQuad", String(level), String(row), String(column))}?style=hillshade`});
        image.style.left = part(column / across - left, width);
        image.style.top = part(row / across - top, height);
        image.style.width = part(1 / across, width);
        image.style.height = part(1 / across, height);
        images.push(image);
      }
    return images;
  }

  private paths(lines: Lines, left: number, top: number, width: number, height: number): SVGElement {
    const whole = 1000;
    const way = lines.features.map(feature => "M" + feature.geometry.coordinates.map(at => {
      const [x, y] = place(at);
      return `${((x - left) / width * whole).toFixed(1)} ${((y - top) / height * whole).toFixed(1)}`;
    }).join("L")).join("");
    return svg("svg", {viewBox: `0 0 ${whole} ${whole}`, preserveAspectRatio: "none", "aria-hidden": "true"}, svg("path", {d: way}));
  }
}
