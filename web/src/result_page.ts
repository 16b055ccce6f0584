// One result: what it is, its files, and what can be done with it.
import {address, Failure, get, Job, send, Triangulation} from "./api";
import {confirmed, h, replace} from "./dom";
import {bytes, count, moment} from "./format";
import {MadePanel} from "./made_panel";
import {fileAddress} from "./outcome";
import {action, Context, Figure, heading, Notice, Page} from "./page";

// The files that a result always has, in the order in which people want them (src/store/FORMAT.md).
const files: [string, string][] = [
  ["report.html", "How the run went, as a page"], ["triangulation.pvtu", "For ParaView: names the tiles"],
  ["manifest.json", "What the result is, and the checksum of every file"]];

export class ResultPage implements Page {
  readonly title: string;
  readonly element: HTMLElement;
  private readonly notice = new Notice();
  private readonly head: HTMLElement;
  private readonly body = h("div");

  constructor(private readonly context: Context, private readonly name: string) {
    this.title = name;
    this.head = heading(name);
    this.element = h("div", {}, this.head, this.notice.element, this.body);
    void this.notice.attempt(async () => this.tell(await get<Triangulation>(address("triangulations", name))));
  }

  close(): void { /* holds nothing */ }

  private tell(result: Triangulation): void {
    const may = this.context.caller.role !== "read";
    replace(this.head.querySelector(".actions")!,
      h("a", {class: "button primary", href: `#/view/${encodeURIComponent(this.name)}`}, "View"),
      result.dimension === 3 ? h("a", {class: "button", href: `#/surface/${encodeURIComponent(this.name)}`}, "Surface") : null,
      may ? action("Verify", () => this.verify()) : null,
      h("a", {class: "button", href: fileAddress(this.name, "report.html"), target: "_blank", rel: "noopener"}, "Report"),
      may ? action("Remove", () => this.remove()) : null);
    const d = result.dimension, box = result.bounds;
    const extent = box.length === 2 * d
      ? Array.from({length: d}, (_, axis) => `${"xyz"[axis]} ${number(box[axis])} to ${number(box[axis + d])}`) : [];
    if (result.heights?.length === 2) extent.push(`z ${number(result.heights[0])} to ${number(result.heights[1])}`);
    const figure = (name: string, text: string) => new Figure(name, text).element;
    replace(this.body,
      h("section", {class: "panel", "aria-label": "Figures"}, h("dl", {class: "figures"},
        figure("Dimension", `${d}D`), figure("Vertices", count(result.vertices)),
        figure(d === 2 ? "Triangles" : "Tetrahedra", count(result.cells)), figure("Tiles", count(result.tiles)),
        figure("Size of the tiles", bytes(result.bytes)), figure("Made", moment(result.created))),
        h("dl", {class: "facts"},
          ...fact("Digest", result.digest ?? "none"), ...fact("Coordinate system", crsName(result.crs)), ...fact("Extent", extent.join(", ") || "–"))),
      new MadePanel(this.context.caller, this.name, d).element,
      h("section", {class: "panel", "aria-labelledby": "files-title"}, h("h2", {id: "files-title"}, "Files"),
        h("ul", {class: "files"}, ...files.map(([path, about]) => h("li", {},
          h("a", path.endsWith(".html") ? {href: fileAddress(this.name, path), target: "_blank", rel: "noopener"}
            : {href: fileAddress(this.name, path), download: true}, path), h("span", {class: "sub"}, about)))),
        h("p", {class: "muted"}, "To copy the whole result, tiles included: ", h("code", {}, `tessera fetch ${this.name} -o ${this.name}/`))));
  }

  private async verify(): Promise<void> {
    await this.notice.attempt(async () => {
      const answer = await send("POST", `${address("processes", "verify")}/execution`, {body: {inputs: {triangulation: this.name}}});
      location.hash = `#/jobs/${(await answer.json() as Job).jobID}`;
    });
  }

  private async remove(): Promise<void> {
    if (!await confirmed(`Remove ${this.name}?`, "Its files are removed from the daemon's disk for good, exports included.", "Remove the result")) return;
    await this.notice.attempt(async () => {
      try {
        await send("DELETE", address("triangulations", this.name));
      } catch (error) {
        if (!(error instanceof Failure && error.status === 404)) throw error;  // somebody else was faster
      }
      location.hash = "#/results";
    });
  }
}

function number(value: number): string {
  return value.toLocaleString("en", {maximumFractionDigits: 3});
}

function fact(name: string, text: string): HTMLElement[] {
  return [h("dt", {}, name), h("dd", {}, text)];
}

// Of WKT, what it calls itself.
function crsName(crs: string | undefined): string {
  if (!crs) return "not known";
  return /^\w+\["([^"]+)"/.exec(crs)?.[1] ?? crs;
}
