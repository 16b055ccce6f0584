// Who works on the jobs. Leases are looked at while the page is: nothing happens to them that an event could tell.
import {address, get, NodeInfo, send} from "./api";
import {confirmed, h, say, show} from "./dom";
import {bytes, count, duration} from "./format";
import {action, Context, heading, Notice, Page} from "./page";

const everyMs = 2000;
const lateMs = 3000;  // without a word of a node that should speak each second

interface Row { element: HTMLElement; update(node: NodeInfo): void; seen: NodeInfo; gone: boolean }

export class NodesPage implements Page {
  readonly title = "Nodes";
  readonly element: HTMLElement;
  private readonly notice = new Notice();
  private readonly counted = h("p", {class: "muted", role: "status"});
  private readonly body = h("tbody");
  private readonly rows = new Map<string, Row>();
  private readonly timer: number;
  private readonly leave: () => void;

  constructor(private readonly context: Context) {
    const names = ["Node", "State", "Last heard", "Threads", "Tiles", "Memory of jobs", "Member for", ...(this.admin ? ["Actions"] : [])];
    this.element = h("div", {}, heading("Nodes"), this.counted, this.notice.element,
      h("div", {class: "panel scrolls", tabindex: 0, role: "region", "aria-label": "The nodes, as a table"},
        h("table", {class: "nodes", "aria-label": "Nodes"}, h("thead", {}, h("tr", {}, ...names.map(name => h("th", {scope: "col"}, name)))), this.body)));
    this.timer = window.setInterval(() => { if (!document.hidden) this.load(); }, everyMs);
    this.leave = context.live.listen(() => undefined, () => this.load());
    this.load();
  }

  private get admin(): boolean { return this.context.caller.role === "admin"; }

  close(): void {
    clearInterval(this.timer);
    this.leave();
  }

  private load(): void {
    if (this.context.live.state === "lost") return;
    void this.notice.attempt(async () => this.tell((await get<{nodes: NodeInfo[]}>(address("nodes"))).nodes));
  }

  private tell(nodes: NodeInfo[]): void {
    const here = new Set<string>();
    for (const node of nodes) {
      const key = node.id || node.name;
      here.add(key);
      let row = this.rows.get(key);
      if (!row) {
        row = this.make(node);
        this.rows.set(key, row);
        this.body.append(row.element);
      }
      row.seen = node;
      row.gone = false;
      row.update(node);
    }
    for (const [key, row] of this.rows) {
      if (here.has(key) || row.gone) continue;
      row.gone = true;
      row.update({...row.seen, state: "gone"});
    }
    const threads = nodes.reduce((sum, node) => sum + node.threads, 0);
    say(this.counted, `${nodes.length === 1 ? "1 node" : `${count(nodes.length)} nodes`}, ${count(threads)} threads`);
  }

  private make(node: NodeInfo): Row {
    const state = h("span", {class: "state"}, h("span", {class: "dot", "aria-hidden": "true"}), h("span"));
    const heard = h("td", {class: "number"}), threads = h("td", {class: "number"}), tiles = h("td", {class: "number"}), here = h("td", {class: "number"});
    const memory = h("meter", {min: 0, "aria-label": `Memory of jobs on ${node.name}`}), memoryWords = h("span", {class: "sub number"});
    const drain = action("Drain", () => this.drain(row), {class: "quiet", "aria-label": `Drain ${node.name}`});
    const element = h("tr", {}, h("th", {scope: "row"}, node.name,
      node.coordinator ? h("span", {class: "tag"}, "this daemon") : null, h("span", {class: "sub"}, node.address ?? "")),
      h("td", {}, state), heard, threads, tiles, h("td", {}, memory, memoryWords), here, this.admin ? h("td", {}, drain) : null);
    const row: Row = {element, seen: node, gone: false, update: now => {
      state.dataset.state = now.state;
      say(state.lastElementChild!, now.state === "gone" ? "gone, lost or ended" : now.state);
      element.classList.toggle("gone", now.state === "gone");
      say(heard, now.state === "gone" ? "–" : `${duration(now.silentMs / 1000)} ago`);
      heard.classList.toggle("late", now.silentMs > lateMs);
      say(threads, count(now.threads));
      say(tiles, now.state === "gone" ? "–" : count(now.tiles));
      memory.max = now.memoryBytes || 1;
      memory.value = now.memoryUsedBytes;
      say(memoryWords, `${bytes(now.memoryUsedBytes)} of ${bytes(now.memoryBytes)}`);
      say(here, duration(now.seconds));
      show(drain, now.state !== "gone" && now.state !== "draining");
    }};
    return row;
  }

  private async drain(row: Row): Promise<void> {
    const node = row.seen;
    if (!await confirmed(`Drain ${node.name}?`, "The other nodes take over its tiles as they are, then its process ends.", "Drain the node")) return;
    await this.notice.attempt(async () => {
      row.update(await (await send("POST", `${address("nodes", node.id || node.name)}/drain`)).json() as NodeInfo);
    });
  }
}
