// Asks for what is wanted last: one request at a time, and none for what nobody wants any more.
const patienceMs = 400;  // that a request has before a newer wish ends it; twice what the last one took, if that is more

export class Latest<T> {
  private wanted: T | null = null;
  private running: AbortController | null = null;
  private began = 0;
  private took = 0;
  private closed = false;

  constructor(private readonly ask: (what: T, signal: AbortSignal) => Promise<void>) {}

  want(what: T): void {
    this.wanted = what;
    if (this.running && performance.now() - this.began > Math.max(patienceMs, 2 * this.took)) this.running.abort();
    if (!this.running) void this.run();
  }

  // Nothing is wanted any more.
  drop(): void {
    this.wanted = null;
    this.running?.abort();
  }

  close(): void {
    this.closed = true;
    this.drop();
  }

  private async run(): Promise<void> {
    while (this.wanted !== null && !this.closed) {
      const what = this.wanted;
      this.wanted = null;
      this.running = new AbortController();
      this.began = performance.now();
      try {
        await this.ask(what, this.running.signal);
        this.took = performance.now() - this.began;
      } finally {
        this.running = null;
      }
    }
  }
}
