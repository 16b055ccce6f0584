// Of a live result: which version is in memory, and which one is drawn. When another version is stored, the view is drawn
// again.
import {address, get, JobEvent, LiveInfo, Triangulation} from "./api";
import {h, say} from "./dom";
import {count} from "./format";
import {Live} from "./live";

export class Versions {
  readonly element = h("p", {class: "sub", id: "live-version", role: "status"});
  private readonly live: Live;
  private readonly leave: () => void;
  private newest: number;

  // `drawn`: the number of the version that is drawn; nothing when nobody knows.
  constructor(private readonly name: string, info: LiveInfo, private drawn: number | null, private readonly onStored: () => void) {
    this.newest = info.version;
    this.tell();
    this.live = new Live(address("triangulations", name, "events"));
    this.leave = this.live.listen(event => this.hear(event), () => void this.ask());
    this.live.start();
  }

  close(): void {
    this.leave();
    this.live.stop();
  }

  private hear(event: JobEvent): void {
    if (!event.made) return;
    if (event.kind === "version") this.newest = event.made.version;
    if (event.kind === "stored") this.stored(event.made.version);
    this.tell();
  }

  // Events may have been missed.
  private async ask(): Promise<void> {
    const {live} = await get<Triangulation>(address("triangulations", this.name));
    if (!live) return;
    this.newest = live.version;
    this.stored(live.storedVersion);
    this.tell();
  }

  private stored(version: number): void {
    if (version === this.drawn || this.drawn === null) return;
    this.drawn = version;
    this.onStored();
  }

  private tell(): void {
    const memory = `Live: version ${count(this.newest)} is in memory`;
    const seen = this.drawn === null ? "the surface is of the version that was exported" : this.drawn === this.newest ? "and is shown" : `version ${count(this.drawn)} is shown`;
    say(this.element, `${memory}${this.drawn === this.newest ? " " : ", "}${seen}.`);
  }
}
