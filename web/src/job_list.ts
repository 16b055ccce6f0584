// The jobs that are known of all those there are: the newest first, loaded page by page as far as anybody looks.
import {address, get, Job, JobEvent, JobList as Answer, next} from "./api";

const page = 200;

export class JobList {
  total = 0;
  loaded = false;
  private ids: string[] = [];
  private known = new Map<string, Job>();
  private further: string | null = null;
  private loading: Promise<void> | null = null;
  private heard: Job[] | null = null;  // while the list is on its way, which may have been made before

  // `states`: only jobs in these, all when empty. `changed` is told how many rows came above the first.
  constructor(private readonly states: string[], private readonly changed: (above: number) => void) {}

  at(place: number): Job | undefined {
    return this.known.get(this.ids[place]);
  }

  async reload(): Promise<void> {
    const first = new URL(address("jobs"));
    first.searchParams.set("limit", String(page));
    if (this.states.length) first.searchParams.set("status", this.states.join(","));
    const heard: Job[] = this.heard = [];
    const list = await get<Answer>(first.href);
    if (this.heard !== heard) return;  // loaded once more meanwhile
    this.heard = null;
    this.ids = list.jobs.map(job => job.jobID);
    this.known = new Map(list.jobs.map(job => [job.jobID, job]));
    this.total = list.numberMatched;
    this.further = next(list, first.href);
    this.loaded = true;
    this.changed(0);
    for (const job of heard) this.put(job);
  }

  // Until the row `to` is known, or all are.
  async extend(to: number): Promise<void> {
    while (this.ids.length < Math.min(to, this.total) && this.further) {
      this.loading ??= this.more(this.further).finally(() => { this.loading = null; });
      await this.loading;
    }
  }

  private async more(from: string): Promise<void> {
    const list = await get<Answer>(from);
    if (this.further !== from) return;  // loaded anew meanwhile
    for (const job of list.jobs) {
      if (!this.known.has(job.jobID)) this.ids.push(job.jobID);
      this.known.set(job.jobID, job);
    }
    this.further = next(list, from);
    this.total = this.further ? Math.max(list.numberMatched, this.ids.length) : this.ids.length;
    this.changed(0);
  }

  hear(event: JobEvent): void {
    if (!event.status) return;
    this.heard?.push(event.status);
    this.put(event.status);
  }

  put(job: Job): void {
    const fits = this.states.length === 0 || this.states.includes(job.status);
    if (this.known.has(job.jobID)) {
      if (!fits) return this.forget(job.jobID);
      this.known.set(job.jobID, job);
      return this.changed(0);
    }
    // Ids ascend with time. Those further down come with their page.
    if (!fits || !this.loaded || (this.ids.length > 0 && job.jobID < this.ids[0])) return;
    this.ids.unshift(job.jobID);
    this.known.set(job.jobID, job);
    ++this.total;
    this.changed(1);
  }

  forget(id: string): void {
    if (!this.known.delete(id)) return;
    this.ids.splice(this.ids.indexOf(id), 1);
    --this.total;
    this.changed(0);
  }
}
