// The files that a job may read, to choose from: folder by folder, as the service lists them.
import {address, get, Input, InputList, next} from "./api";
import {h, replace, say, show} from "./dom";
import {bytes, count} from "./format";
import {Notice} from "./page";

export class InputChooser {
  readonly element = h("details", {class: "chooser"}, h("summary", {}, "Choose from the files of the daemon"));
  private readonly notice = new Notice();
  private readonly where = h("nav", {class: "where", "aria-label": "Folders"});
  private readonly list = h("ul", {class: "inputs", "aria-label": "Files and folders"});
  private readonly more = h("button", {type: "button", class: "quiet", onclick: () => void this.extend()}, "Show more");
  private readonly told = h("p", {class: "unseen", role: "status"});
  private further: string | null = null;
  private folder = "";

  // `chosen`: whether a name is among what was typed; `choose` puts it there, or takes it away.
  constructor(private readonly chosen: (name: string) => boolean, private readonly choose: (name: string, on: boolean) => void) {
    this.element.append(this.where, this.notice.element, this.list, this.more, this.told);
    show(this.more, false);
    this.element.addEventListener("toggle", () => { if (this.element.open && this.list.childElementCount === 0) void this.open(""); });
  }

  // What is typed may have changed.
  refresh(): void {
    for (const box of this.list.querySelectorAll<HTMLInputElement>("input")) box.checked = this.chosen(box.value);
  }

  private async open(folder: string): Promise<void> {
    this.folder = folder;
    this.further = `${address("inputs")}?folder=${encodeURIComponent(folder)}`;
    await this.extend(true);
  }

  private async extend(anew = false): Promise<void> {
    await this.notice.attempt(async () => {
      const from = this.further, {folder} = this;
      if (from === null) return;
      const page = await get<InputList>(from);
      if (folder !== this.folder || from !== this.further) return;  // somewhere else meanwhile
      this.further = next(page, from);
      const rows = page.inputs.map(each => this.row(each));
      if (anew) {
        this.tellWhere();
        replace(this.list, ...(rows.length ? rows : [h("li", {class: "muted"}, "No point files and no folders here.")]));
      } else {
        this.list.append(...rows);
      }
      show(this.more, this.further !== null);
      say(this.told, `${folder || "All folders"}: ${count(page.numberMatched)} files and folders`);
    });
  }

  private tellWhere(): void {
    const parts = this.folder.split("/").filter(part => part !== ""), begin = this.folder.startsWith("/") ? "/" : "";
    const step = (text: string, folder: string) => folder === this.folder ? h("span", {"aria-current": "location"}, text)
      : h("button", {type: "button", class: "quiet", onclick: () => void this.open(folder)}, text);
    replace(this.where, step("All folders", ""), ...parts.map((part, i) => step(part, begin + parts.slice(0, i + 1).join("/"))),
      this.folder === "" ? null : this.whole());
  }

  // The folder itself is an input, too: all files in it.
  private whole(): HTMLElement {
    return h("label", {class: "whole"}, this.box(this.folder), "All files in it");
  }

  private box(name: string): HTMLInputElement {
    const box = h("input", {type: "checkbox", value: name, onchange: () => {
      this.choose(name, box.checked);
      this.refresh();
    }});
    box.checked = this.chosen(name);
    return box;
  }

  private row(input: Input): HTMLElement {
    const name = input.name.slice(input.name.lastIndexOf("/") + 1);
    if (input.folder)
      return h("li", {}, h("button", {type: "button", class: "quiet folder", onclick: () => void this.open(input.name)}, `${name}/`));
    const points = input.points === undefined ? "" : `${count(input.points)} points`, {bounds = []} = input, d = bounds.length / 2;
    const sides = Array.from({length: d}, (_, axis) => (bounds[axis + d] - bounds[axis]).toLocaleString("en", {maximumSignificantDigits: 4}));
    const about = [bytes(input.bytes), points, sides.join(" × "), input.crs ?? ""].filter(text => text !== "").join(" · ");
    return h("li", {}, h("label", {}, this.box(input.name), h("span", {}, name)), h("span", {class: "sub"}, about),
      input.note ? h("span", {class: "sub wrong"}, input.note) : null);
  }
}
