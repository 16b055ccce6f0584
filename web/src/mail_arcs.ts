// Mail between tiles, drawn over their map: arcs that bend to the left of the way they go, so that both ways are seen.
import {Mail} from "./api";
import {h, replace, say, svg} from "./dom";
import {count} from "./format";
import {Plan, tilesOf} from "./tile_layout";
import {MapPart} from "./tile_zoom";

const size = 1000;  // of the picture, whose width is 1 in the plan

export class MailArcs {
  readonly picture = svg("svg", {class: "arcs", "aria-hidden": "true", preserveAspectRatio: "none"});
  readonly words = h("p", {class: "sub mail"});
  // What is said of them, for who does not see the picture.
  said = "";
  private readonly ground = svg("path", {class: "ground"});  // so that they are seen on tiles of any colour
  private arcs = new Map<string, SVGElement>();

  clear(): void {
    this.draw(undefined, null);
  }

  draw(mail: Mail | undefined, plan: Plan | null): void {
    const before = this.arcs;
    this.arcs = new Map();
    const from = mail?.from ?? [], to = mail?.to ?? [], points = mail?.points ?? [];
    const ways: string[] = [];
    for (let i = 0; plan && i < points.length; ++i) {
      const way = this.wayOf(plan, from[i], to[i]);
      if (!way) continue;
      const key = `${from[i]} ${to[i]}`;
      // One that stays goes on moving.
      const arc = before.get(key) ?? svg("path", {class: "arc"});
      arc.setAttribute("d", way);
      arc.style.setProperty("--weight", (1 + 2 * Math.sqrt(points[i] / points[0])).toFixed(1));
      before.delete(key);
      this.arcs.set(key, arc);
      ways.push(way);
    }
    for (const gone of before.values()) gone.remove();
    this.ground.setAttribute("d", ways.join(""));
    if (ways.length === 0) this.ground.remove();
    else if (!this.ground.isConnected) this.picture.prepend(this.ground);
    for (const arc of this.arcs.values()) if (!arc.isConnected) this.picture.append(arc);
    this.said = plan && ways.length > 0
      ? `Points have lately gone ${ways.length === 1 ? "one way" : `${count(ways.length)} ways`} between tiles; ` +
        `most from ${nameOf(plan, from[0])} to ${nameOf(plan, to[0])}: ${count(points[0])} points.`
      : "";
    if (this.said === "") say(this.words, "");
    else if (this.words.lastChild?.textContent !== this.said)
      replace(this.words, h("span", {class: "swatch arc-swatch", "aria-hidden": "true"}), this.said);
  }

  // Of a map whose part is seen.
  see(part: MapPart, height: number): void {
    this.picture.setAttribute("viewBox", [part.left, part.top, 1 / part.zoom, height / part.zoom].map(value => value * size).join(" "));
  }

  private wayOf(plan: Plan, from: number, to: number): string | null {
    const a = middleOf(plan, from), b = middleOf(plan, to);
    if (!a || !b) return null;
    const x = (a[0] + b[0]) / 2 + (b[1] - a[1]) * 0.2, y = (a[1] + b[1]) / 2 - (b[0] - a[0]) * 0.2;
    const at = (...place: number[]) => place.map(value => Number((value * size).toFixed(4))).join(" ");
    return `M${at(...a)}Q${at(x, y)} ${at(...b)}`;
  }
}

// Of a part: a row of the layout, or -1-tile.
function middleOf(plan: Plan, part: number): [number, number] | null {
  const all = part < 0 ? plan.rectangles : plan.rows, at = 4 * (part < 0 ? -1 - part : part);
  return at + 3 < all.length ? [(all[at] + all[at + 2]) / 2, (all[at + 1] + all[at + 3]) / 2] : null;
}

function nameOf(plan: Plan, part: number): string {
  return part < 0 ? `tile ${-1 - part}` : `a part of ${count(tilesOf(plan, part))} tiles`;
}
