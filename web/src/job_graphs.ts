// What moves while a triangulation runs: the map of its tiles, threads, memory, mail. Asked for when an event says that
// something has changed, never twice at once.
import {address, Failure, get, Job, Tiles} from "./api";
import {Chart} from "./chart";
import {h, say, show} from "./dom";
import {bytes, count} from "./format";
import {TileMap} from "./tile_map";

const kept = 600;  // samples of memory and mail; half of them go when there are more

export class JobGraphs {
  readonly element: HTMLElement;
  private readonly map = new TileMap();
  private readonly again = h("p", {class: "sub"});
  private readonly threads = new Chart("Threads at work", "since the job began");
  private readonly memory = new Chart("Memory of the tiles", "since this page was opened");
  private readonly mail = new Chart("Updates on the way", "since this page was opened");
  private readonly nodes = new Chart("Nodes at work", "since this page was opened");
  private readonly charts = h("section", {class: "panel charts", "aria-label": "Over time"},
    this.threads.element, this.memory.element, this.mail.element, this.nodes.element);
  private seen = false;
  private times: number[] = [];
  private memories: number[] = [];
  private mails: number[] = [];
  private atWork: number[] = [];
  private asking = false;
  private stale = false;
  private closed = false;

  constructor(private readonly job: string) {
    show(this.again, false);
    show(this.nodes.element, false);
    this.element = h("div", {class: "graphs"},
      h("section", {class: "panel tiles", "aria-labelledby": "map-title"}, h("h2", {id: "map-title"}, "Tiles"),
        this.map.element, this.again), this.charts);
  }

  close(): void {
    this.closed = true;
    this.map.close();
  }

  update(job: Job): void {
    const has = job.processID === "triangulate" && (job.status === "running" || job.status === "successful");
    const comes = job.processID === "triangulate" && job.status === "accepted";
    this.seen ||= has || comes;
    // Of one that was stopped the map stays as it was last seen; if it never was, there is none.
    show(this.element, this.seen && (has || comes || !this.map.needsLayout));
    const f = job.figures;
    // Of one that had ended before the page was opened nothing is told but the map.
    const charts = comes || job.status === "running" || this.times.length > 0;
    show(this.charts, charts);
    this.element.classList.toggle("alone", !charts);
    if (!has) {
      this.map.rest();
      return;
    }
    if (f && (this.times.length === 0 || f.elapsed > this.times[this.times.length - 1])) {
      this.times.push(f.elapsed);
      this.memories.push(f.memoryBytes);
      this.mails.push(Math.max(0, f.updatesSent - f.updatesProcessed));
      // Without a cluster there is one, and nothing to be seen.
      const nodes = f.nodes ?? [];
      this.atWork.push(nodes.filter(node => !node.lost).length);
      show(this.nodes.element, nodes.length > 0 || !this.nodes.element.hidden);
      if (this.times.length > kept) {
        for (const list of [this.times, this.memories, this.mails, this.atWork])
          list.splice(0, list.length, ...list.filter((_, i) => i % 2 === 0));
      }
      this.memory.update(this.times, this.memories, 1 << 20, bytes);
      this.mail.update(this.times, this.mails, 10, count);
      this.nodes.update(this.times, this.atWork, 1, count);
    }
    void this.ask();
  }

  private async ask(): Promise<void> {
    this.stale = true;
    if (this.asking) return;
    this.asking = true;
    try {
      while (this.stale && !this.closed) {
        this.stale = false;
        this.tell(await get<Tiles>(`${address("jobs", this.job, "tiles")}${this.map.needsLayout ? "?layout=true" : ""}`));
      }
    } catch (error) {
      // It has ended a moment ago, or the daemon is away: the page says so elsewhere.
      if (!(error instanceof Failure)) throw error;
    } finally {
      this.asking = false;
    }
  }

  private tell(tiles: Tiles): void {
    if (this.closed) return;
    if (tiles.stages) this.map.update(tiles);
    // Of a job that has ended it is not told any more.
    if (tiles.begunAgain > 0) say(this.again, `${count(tiles.begunAgain)} tiles were begun again after a loss.`);
    if (tiles.begunAgain > 0) show(this.again, true);
    const busy = tiles.busyThreads ?? [];
    if (tiles.busy > 0 && busy.length > 0) {
      this.threads.update(busy.map((_, i) => (i + 0.5) * tiles.busy / busy.length), busy, 1, threads => threads.toFixed(1),
        `${(busy.reduce((sum, threads) => sum + threads) / busy.length).toFixed(1)} on average`);
    }
  }
}
