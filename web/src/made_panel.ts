// What was made of a result: rasters, lines, meshes; to take, to remove, and of what has a place on the earth a picture.
import {address, Caller, Export, ExportList, Failure, get, next, send} from "./api";
import {confirmed, h, replace, show} from "./dom";
import {bytes, count, moment} from "./format";
import {MapPicture} from "./map_picture";
import {action, Notice} from "./page";

// By the process, or when its job is forgotten by the name.
function kindOf(made: Export): string {
  const ending = /\.(\w+)$/.exec(made.name)?.[1] ?? "";
  if (made.name === "3dtiles") return "Levels of detail, for viewers";
  if (made.processID === "contours" || /^contours\./.test(made.name)) return "Contour lines";
  if (made.processID === "hag") return "Heights above the ground";
  const products: Record<string, string> = {alpha: "Alpha shape", voronoi: "Voronoi cells", density: "Density or field", volume: "Volumes"};
  if (made.processID && products[made.processID]) return products[made.processID];
  if (made.processID === "dem" || ending === "tif") return "Raster";
  return ending ? `Export, ${ending}` : "Export";
}

export class MadePanel {
  readonly element = h("section", {class: "panel", "aria-labelledby": "made-title"}, h("h2", {id: "made-title"}, "Made from this result"));
  private readonly list = h("div", {});
  private readonly notice = new Notice();
  private readonly picture = new MapPicture();

  constructor(private readonly caller: Caller, private readonly name: string, dimension: number) {
    const make = (process: string, text: string) =>
      h("a", {class: "button", href: `#/submit?process=${process}&triangulation=${encodeURIComponent(name)}`}, text);
    this.element.append(this.notice.element, this.picture.element, this.list);
    if (caller.role !== "read")
      this.element.append(h("div", {class: "actions"}, ...(dimension === 2 ? [make("dem", "Make a raster"), make("contours", "Draw contour lines")] : []),
        make("export", "Export")));
    void this.load();
  }

  private async load(): Promise<void> {
    await this.notice.attempt(async () => {
      const made: Export[] = [];
      for (let from: string | null = `${address("triangulations", this.name, "exports")}?limit=1000`; from !== null;) {
        const page: ExportList = await get<ExportList>(from);
        made.push(...page.exports);
        from = next(page, from);
      }
      replace(this.list, made.length === 0 ? h("p", {class: "muted"}, "Nothing yet.")
        : h("ul", {class: "files"}, ...made.map(each => this.row(each))));
      const has = (rel: string) => made.some(each => each.links.some(link => link.rel === rel));
      const map = has("http://www.opengis.net/def/rel/ogc/1.0/tilesets-map"), lines = has("collection");
      show(this.picture.element, map || lines);
      if (map || lines) await this.picture.tell(this.name, map, lines);
    });
  }

  private row(made: Export): HTMLElement {
    const file = made.links.find(link => link.rel === "item"), single = /\.\w+$/.test(made.name);  // others are folders
    // The service's own address of it may be another than this page's.
    const to = single && file ? address("triangulations", this.name, "files", "exports", made.name) : null;
    const about = [kindOf(made), single ? "" : `${count(made.files)} files`, made.bytes > 0 ? bytes(made.bytes) : "", moment(made.created), made.submitter ? `by ${made.submitter}` : ""];
    const may = this.caller.role === "admin" || (this.caller.role === "submit" && this.caller.name === made.submitter);
    return h("li", {}, to ? h("a", {href: to, download: true}, made.name) : h("span", {class: "name"}, made.name),
      h("span", {class: "sub"}, about.filter(text => text !== "").join(" · ")),
      made.jobID ? h("a", {class: "sub", href: `#/jobs/${made.jobID}`}, "Job") : null,
      may ? action("Remove", () => this.remove(made), {class: "quiet", "aria-label": `Remove ${made.name}`}) : null);
  }

  private async remove(made: Export): Promise<void> {
    if (!await confirmed(`Remove ${made.name}?`, "It is removed from the daemon's disk for good; the result stays.", "Remove the export")) return;
    await this.notice.attempt(async () => {
      try {
        await send("DELETE", address("triangulations", this.name, "files", "exports", made.name));
      } catch (error) {
        if (!(error instanceof Failure && error.status === 404)) throw error;  // somebody else was faster
      }
      await this.load();
    });
  }
}
