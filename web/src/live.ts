// What happens, by one stream of events for the whole page, which is opened again when it ends: after the last event that
// was heard (Last-Event-ID). Read by fetch, not EventSource: that does not tell a refusal from a daemon that is away.
import {address, Failure, JobEvent, send} from "./api";

export type Connection = "connecting" | "live" | "lost";
type Heard = (event: JobEvent) => void;

const silenceMs = 45_000;  // the service says something every 15 s
const unseenMs = 30_000;
const pauseMs = [250, 500, 1000, 2000, 4000];

export class Live {
  state: Connection = "connecting";
  onState: (state: Connection) => void = () => undefined;
  private heard = new Set<Heard>();
  private back = new Set<() => void>();
  private last = "";
  private running: AbortController | null = null;
  private again = false;  // it was open before
  private unseen = 0;
  private paused = false;

  // `url`: of the stream.
  // Browsers have six connections for all pages of a daemon: one that nobody looks at gives its own back.
  constructor(private readonly url = address("events")) {
    document.addEventListener("visibilitychange", () => {
      clearTimeout(this.unseen);
      if (!document.hidden) return this.paused ? this.start() : undefined;
      this.unseen = window.setTimeout(() => {
        this.paused = this.running !== null;
        this.stop();
      }, unseenMs);
    });
  }

  // What to call for each event, and what when events may have been missed. Returns what ends both.
  listen(heard: Heard, back: () => void): () => void {
    this.heard.add(heard);
    this.back.add(back);
    return () => {
      this.heard.delete(heard);
      this.back.delete(back);
    };
  }

  start(): void {
    this.paused = false;
    if (this.running) return;
    this.running = new AbortController();
    void this.run(this.running.signal);
  }

  stop(): void {
    this.running?.abort();
    this.running = null;
  }

  private become(state: Connection): void {
    if (state === this.state) return;
    this.state = state;
    this.onState(state);
  }

  private async run(stop: AbortSignal): Promise<void> {
    let failures = 0;
    while (!stop.aborted) {
      const asked = this.last;
      let any = false, open = false;
      try {
        await this.once(stop, () => {
          failures = 0;
          open = true;
          this.become("live");
          if (this.again) for (const back of this.back) back();
          this.again = true;
        }, () => { any = true; });
      } catch (error) {
        if (stop.aborted) return;
        if (error instanceof Failure && error.status === 401) return this.stop();
      }
      // Too far behind to be told all of it: from now on. What is shown is asked for anew.
      if (!any && asked !== "") this.last = "";
      if (stop.aborted) return;
      // One that was open may end for any reason; only when no other can be opened is the daemon missed.
      this.become(open ? "connecting" : "lost");
      await new Promise(resolve => setTimeout(resolve, pauseMs[Math.min(failures++, pauseMs.length - 1)]));
    }
  }

  // One connection, until it ends.
  private async once(stop: AbortSignal, opened: () => void, event: () => void): Promise<void> {
    const given = new AbortController();
    const giveUp = () => given.abort();
    stop.addEventListener("abort", giveUp);
    let silence = setTimeout(giveUp, silenceMs);
    try {
      const headers: Record<string, string> = {Accept: "text/event-stream"};
      if (this.last) headers["Last-Event-ID"] = this.last;
      const answer = await send("GET", this.url, {headers, signal: given.signal});
      opened();
      const reader = answer.body!.pipeThrough(new TextDecoderStream()).getReader();
      let rest = "";
      for (;;) {
        const {done, value} = await reader.read();
        if (done) return;
        clearTimeout(silence);
        silence = setTimeout(giveUp, silenceMs);
        rest += value;
        for (let end = rest.indexOf("\n\n"); end >= 0; end = rest.indexOf("\n\n")) {
          if (this.take(rest.slice(0, end))) event();
          rest = rest.slice(end + 2);
        }
      }
    } finally {
      clearTimeout(silence);
      stop.removeEventListener("abort", giveUp);
      given.abort();
    }
  }

  private take(block: string): boolean {
    let data = "";
    for (const line of block.split("\n")) {
      if (line.startsWith("id: ")) this.last = line.slice(4);
      if (line.startsWith("data: ")) data += line.slice(6);
    }
    if (!data) return false;
    const event = JSON.parse(data) as JobEvent;
    for (const heard of this.heard) heard(event);
    return true;
  }
}
