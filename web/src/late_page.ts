// A page whose program is large, and loaded when it is opened.
import {h, replace} from "./dom";
import {heading, Notice, Page} from "./page";

export class LatePage implements Page {
  readonly element = h("div", {});
  private page: Page | null = null;
  private closed = false;

  constructor(readonly title: string, load: () => Promise<Page>) {
    const notice = new Notice();
    replace(this.element, heading(title), notice.element);
    void notice.attempt(async () => {
      const page = await load();
      if (this.closed) return page.close();
      this.page = page;
      replace(this.element, page.element);
    });
  }

  close(): void {
    this.closed = true;
    this.page?.close();
  }
}
