// The viewer: of a 2D result its surface, what the colours mean, and what a cell is; of a 3D one SolidView, or the closed
// surface between outside and inside. It is loaded when it is asked for.
import {address, get, Job, send, Triangulation} from "./api";
import {h, replace} from "./dom";
import {count} from "./format";
import {Context, emptyState, heading, Notice, Page} from "./page";
import {CellPanel} from "./view_cell";
import {colourPanel} from "./view_legend";
import {Scene, TilesetDocument} from "./view_scene";
import {SolidView} from "./view_solid_page";
import {drawable} from "./view_stage";
import {heightSlider, viewButtons} from "./view_tools";
import {Versions} from "./view_versions";

export class ViewPage implements Page {
  readonly title: string;
  readonly element: HTMLElement;
  private readonly notice = new Notice();
  private readonly body = h("div");
  private readonly leave: () => void;
  private scene: Scene | null = null;
  private result: Triangulation | null = null;
  private solid: SolidView | null = null;
  private versions: Versions | null = null;
  private making: {line: HTMLElement; bar: HTMLProgressElement; job: string} | null = null;
  private closed = false;

  // `closedSurface`: of a 3D result, in place of its cells.
  constructor(private readonly context: Context, private readonly name: string, private readonly closedSurface = false) {
    this.title = `${closedSurface ? "Surface of" : "View"} ${name}`;
    this.element = h("div", {class: "viewer"}, heading(name, h("a", {class: "button", href: `#/results/${encodeURIComponent(name)}`}, "Figures and files")),
      this.notice.element, this.body);
    this.leave = context.live.listen(event => { if (event.status) this.hear(event.status); },
      () => { if (this.making) void this.notice.attempt(async () => this.hear(await get<Job>(address("jobs", this.making!.job)))); });
    this.begin();
  }

  private begin(): void {
    void this.notice.attempt(async () => {
      const result = this.result = await get<Triangulation>(address("triangulations", this.name));
      this.follow(result);
      if (result.dimension === 2 || this.closedSurface) await (result.tileset ? this.open() : this.prepare());
      else {
        this.solid = new SolidView(this.context, this.notice, this.body, result);
        await this.solid.open();
      }
    });
  }

  close(): void {
    this.closed = true;
    this.leave();
    this.versions?.close();
    this.scene?.close();
    this.solid?.close();
  }

  // Of a 3D result its stored version is drawn; a surface is a file of its own.
  private follow({live, dimension}: Triangulation): void {
    if (!live || this.versions || this.closed) return;
    const drawn = dimension === 3 && !this.closedSurface ? live.storedVersion : null;
    this.versions = new Versions(this.name, live, drawn, () => this.solid?.again());
    this.body.before(this.versions.element);
  }

  private get process(): string { return this.result?.dimension === 3 ? "surface" : "export"; }
  private get tileset(): string { return address("triangulations", this.name, "3dtiles", "tileset.json"); }

  private async open(): Promise<void> {
    const tileset = await get<TilesetDocument>(this.tileset);
    if (!this.closed) this.draw(tileset);
  }

  // The first one who looks has the levels of detail made, by a job; they stay with the result.
  private async prepare(): Promise<void> {
    if (this.context.caller.role === "read") {
      replace(this.body, emptyState("Not prepared for viewing yet", "A token that may submit jobs prepares it by opening this page."));
      return;
    }
    const inputs = {triangulation: this.name, output: "3dtiles", format: "3dtiles"};
    const answer = await send("POST", `${address("processes", this.process)}/execution`, {body: {inputs}});
    const job = await answer.json() as Job;
    const line = h("p", {role: "status"}, this.process === "surface" ? "The closed surface and its levels of detail are made once, and stay with the result."
      : "Levels of detail are made once, and stay with the result.");
    const bar = h("progress", {max: 100, value: 0, "aria-label": "Preparing"});
    this.making = {line, bar, job: job.jobID};
    replace(this.body, h("section", {class: "panel", "aria-labelledby": "making"}, h("h2", {id: "making"}, "Preparing the view"), line, bar,
      h("p", {class: "muted"}, h("a", {href: `#/jobs/${job.jobID}`}, "The job that does it"))));
    this.hear(await get<Job>(address("jobs", job.jobID)));
  }

  private hear(job: Job): void {
    // Somebody else's, which refused ours.
    if (!this.making && !this.scene && job.processID === this.process && job.triangulation === this.name && job.status === "successful") this.begin();
    if (this.making?.job !== job.jobID) return;
    this.making.bar.value = job.progress;
    if (job.status === "successful") {
      this.making = null;
      void this.notice.attempt(() => this.open());
    } else if (job.status === "failed" || job.status === "dismissed") {
      this.making = null;
      replace(this.body);
      this.notice.tell(new Error(job.problem?.detail ?? "The job that prepares the view was stopped."));
    }
  }

  private draw(tileset: TilesetDocument): void {
    const canvas = h("canvas", {tabindex: 0, role: "img", "aria-label": `Surface of ${this.name}, ${count(tileset.extras.cells)} triangles`, "aria-describedby": "view-help"});
    const {unit = "", heightUnit = ""} = this.result ?? {};
    const asks = this.result?.dimension === 2;  // a place has one triangle
    const help = h("p", {class: "sub", id: "view-help"},
      `Drag turns, the right button or two fingers move, the wheel or two fingers zoom${asks ? "; a click asks for the cell" : ""}. Keys: arrows move, with Shift they turn, + and − zoom${asks ? ", Enter asks for the cell in the middle" : ""}.`);
    const stage = h("div", {class: "stage"}, canvas, viewButtons(() => this.scene)), side = h("div", {class: "view-side"}, help);
    replace(this.body, h("div", {class: "view"}, stage, side));
    const scene = drawable(stage, () => new Scene(canvas, this.tileset, tileset, unit));
    this.scene = scene;
    scene.onFailure = error => this.notice.tell(error);
    if (asks) side.prepend(this.cellPanel(scene, tileset.extras.attributes.includes("z") ? heightUnit : null));
    const colours = colourPanel(tileset.extras, heightUnit, by => scene.colour(by));
    colours.append(heightSlider(() => this.scene));
    side.prepend(colours);
  }

  // What a cell is that somebody clicks on.
  private cellPanel(scene: Scene, heightUnit: string | null): HTMLElement {
    const cell = new CellPanel(this.name, "Click on the surface.", heightUnit);
    let corners: number[][] = [];
    cell.onFound = (...found) => {
      corners = found[0];
      scene.mark(...found);
    };
    cell.onLook = () => scene.approach(corners);
    scene.onPick = point => void this.notice.attempt(async () => {
      await cell.ask(`point=${point.join(",")}`);
      this.context.announce(cell.summary);
    });
    return cell.element;
  }
}
