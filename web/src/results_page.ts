// What was made.
import {address, get, next, Triangulation, TriangulationList} from "./api";
import {h, replace, say, show} from "./dom";
import {bytes, count, moment} from "./format";
import {Context, emptyState, heading, Notice, Page} from "./page";
import {Rows, VirtualList} from "./virtual_list";

const page = 100;

export class ResultsPage implements Page, Rows {
  readonly title = "Results";
  readonly element: HTMLElement;
  private readonly notice = new Notice();
  private readonly list = new VirtualList(this);
  private readonly counted = h("p", {class: "muted", role: "status"});
  private readonly table: HTMLElement;
  private readonly nothing = h("div");
  private readonly leave: () => void;
  private known: Triangulation[] = [];
  private total = 0;
  private further: string | null = null;
  private loading: Promise<void> | null = null;

  constructor(context: Context) {
    this.table = h("div", {class: "table results", role: "table", "aria-label": "Results"},
      h("div", {class: "head", role: "row", "aria-rowindex": 1},
        ...["Result", "Dimension", "Vertices", "Cells", "Tiles", "Size", "Made"].map(name =>
          h("span", {role: "columnheader", class: `c-${name.toLowerCase()}`}, name))),
      this.list.element);
    this.element = h("div", {}, heading("Results"), this.counted, this.notice.element, this.table, this.nothing);
    replace(this.nothing, emptyState("No results yet", "A triangulation that is finished stands here, with its files.",
      context.caller.role === "read" ? null : h("a", {class: "button", href: "#/submit"}, "New job")));
    show(this.table, false);
    show(this.nothing, false);
    // A job that has ended well may have made one.
    this.leave = context.live.listen(event => { if (event.kind === "status" && event.status?.status === "successful") this.load(); },
      () => this.load());
    this.load();
  }

  close(): void {
    this.leave();
    this.list.close();
  }

  private load(): void {
    void this.notice.attempt(async () => {
      this.known = [];
      await this.more(`${address("triangulations")}?limit=${page}`);
    });
  }

  private async more(from: string): Promise<void> {
    const list = await get<TriangulationList>(from);
    this.known.push(...list.triangulations);
    this.further = next(list, from);
    this.total = this.further ? Math.max(list.numberMatched, this.known.length) : this.known.length;
    say(this.counted, this.total === 1 ? "1 result" : `${count(this.total)} results`);
    this.table.setAttribute("aria-rowcount", String(this.total + 1));
    show(this.table, this.total > 0);
    show(this.nothing, this.total === 0);
    this.list.refresh();
  }

  get length(): number { return this.total; }
  key(at: number): string { return this.known[at]?.name ?? ""; }

  wanted(_from: number, to: number): void {
    void this.notice.attempt(async () => {
      while (this.known.length < Math.min(to, this.total) && this.further) {
        this.loading ??= this.more(this.further).finally(() => { this.loading = null; });
        await this.loading;
      }
    });
  }

  make(at: number): HTMLElement {
    const name = this.known[at]?.name ?? "";
    return h("div", {class: "row", role: "row"},
      h("div", {role: "cell", class: "c-result"},
        h("a", {class: "name", href: name ? `#/results/${encodeURIComponent(name)}` : null}, name), h("span", {class: "sub"})),
      ...["dimension", "vertices", "cells", "tiles", "size", "made"].map(column => h("div", {role: "cell", class: `c-${column}`})));
  }

  update(at: number, row: HTMLElement): void {
    const result = this.known[at];
    row.classList.toggle("unknown", !result);
    if (!result) return;
    const cell = (name: string) => row.querySelector<HTMLElement>(`.c-${name}`)!;
    say(cell("result").lastElementChild!, result.digest ? `digest ${result.digest.slice(0, 12)}` : "");
    say(cell("dimension"), `${result.dimension}D`);
    say(cell("vertices"), count(result.vertices));
    say(cell("cells"), count(result.cells));
    say(cell("tiles"), count(result.tiles));
    say(cell("size"), bytes(result.bytes));
    say(cell("made"), moment(result.created));
  }
}
