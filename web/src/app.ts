// The frame around the pages: where they are, who looks, whether the daemon is there.
import {address, Caller, Failure, get, onSignedOut} from "./api";
import {h, replace, say, show} from "./dom";
import {JobPage} from "./job_page";
import {JobsPage} from "./jobs_page";
import {Connection, Live} from "./live";
import {NodesPage} from "./nodes_page";
import {LatePage} from "./late_page";
import {Context, emptyState, heading, Page} from "./page";
import {ResultPage} from "./result_page";
import {ResultsPage} from "./results_page";
import {exchange, signIn, signOut, takeToken} from "./sign_in";
import {SubmitPage} from "./submit_page";
import {themeSwitch} from "./theme";

const sections: [string, string][] = [["jobs", "Jobs"], ["results", "Results"], ["nodes", "Nodes"]];

class App {
  private readonly live = new Live();
  private readonly links = new Map<string, HTMLElement>();
  private readonly main = h("main", {id: "main"});
  private readonly connection = h("span", {class: "connection", role: "status"}, h("span", {class: "dot", "aria-hidden": "true"}), h("span"));
  private readonly who = h("span", {class: "who muted"});
  private readonly leave = h("button", {type: "button", class: "quiet leave", onclick: () => void this.endSession()}, "Sign out");
  private readonly lost = h("div", {class: "lost", role: "alert"});
  private readonly heard = h("p", {class: "unseen", "aria-live": "polite"});
  private readonly nav: HTMLElement;
  private context: Context | null = null;
  private page: Page | null = null;

  constructor() {
    this.nav = h("nav", {"aria-label": "Pages"}, ...sections.map(([id, text]) => {
      const link = h("a", {href: `#/${id}`}, text);
      this.links.set(id, link);
      return link;
    }));
    const theme = themeSwitch();
    const skip = h("a", {class: "skip", href: "#main", onclick: event => {
      event.preventDefault();
      this.main.querySelector<HTMLElement>("h1")?.focus();
    }}, "Skip to the content");
    document.body.append(skip,
      h("header", {}, h("a", {class: "brand", href: "#/jobs"}, h("img", {src: "icon.svg", alt: "", width: 24, height: 24}), "Tessera"),
        this.nav, h("div", {class: "side"}, this.connection, this.who, this.leave, theme)),
      this.lost, this.main, this.heard);
    show(this.lost, false);
    show(this.leave, false);
    this.live.onState = state => this.tellConnection(state);
    this.tellConnection("connecting");
    onSignedOut(() => this.askForToken());
    addEventListener("hashchange", () => this.open(true));
    void this.begin();
  }

  // Who looks decides what is shown.
  private async begin(): Promise<void> {
    let token = takeToken();
    for (let pause = 250; ; pause = Math.min(4000, pause * 2)) {
      try {
        if (token !== null) await this.bring(token);
        token = null;
        const caller = await get<Caller>(address("caller"));
        this.context = {caller, live: this.live, announce: text => say(this.heard, text)};
        say(this.who, `${caller.name} · ${caller.role}`);
        show(this.nav, true);
        show(this.leave, true);
        this.live.start();
        return this.open(false);
      } catch (error) {
        if (error instanceof Failure && error.status === 401) return;
        this.tellConnection("lost");
        await new Promise(resolve => setTimeout(resolve, pause));
      }
    }
  }

  // One that is refused leaves it to the form to ask for another.
  private async bring(token: string): Promise<void> {
    try {
      await exchange(token);
    } catch (error) {
      if (!(error instanceof Failure)) throw error;
    }
  }

  private async endSession(): Promise<void> {
    try {
      await signOut();
    } catch (error) {
      // Without the daemon it goes on, and so does the page.
      if (!(error instanceof Failure) || error.status !== 401) return this.tellConnection("lost");
    }
    this.askForToken();
  }

  private askForToken(): void {
    if (this.page?.title === "Sign in") return;
    this.live.stop();
    this.context = null;
    say(this.who, "");
    show(this.nav, false);
    show(this.leave, false);
    show(this.lost, false);
    say(this.connection.lastElementChild!, "");
    this.connection.dataset.state = "";
    this.put(signIn(() => void this.begin()), true);
  }

  private tellConnection(state: Connection): void {
    this.connection.dataset.state = state;
    say(this.connection.lastElementChild!, {connecting: "Connecting", live: "Live", lost: "Not connected"}[state]);
    say(this.lost, state === "lost" ? "The daemon cannot be reached. What is shown may be old; the page goes on by itself when it is back." : "");
    show(this.lost, state === "lost");
  }

  private open(moved: boolean): void {
    if (!this.context) return;
    const [path, query] = location.hash.replace(/^#\/?/, "").split("?");
    const [section, name] = path.split("/").map(part => decodeURIComponent(part));
    const given = Object.fromEntries(new URLSearchParams(query ?? ""));
    for (const [id, link] of this.links) {
      if (id === (section || "jobs") || (id === "jobs" && section === "submit") || (id === "results" && (section === "view" || section === "surface"))) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
    this.put(this.make(this.context, section, name, given), moved);
  }

  private make(context: Context, section: string, name: string | undefined, given: Record<string, string>): Page {
    if (section === "" || (section === "jobs" && !name)) return new JobsPage(context, given.show ?? "all");
    if (section === "jobs") return new JobPage(context, name!);
    if (section === "results") return name ? new ResultPage(context, name) : new ResultsPage(context);
    if (section === "nodes") return new NodesPage(context);
    if (section === "view" && name) return new LatePage(`View ${name}`, async () => new (await import("./view_page")).ViewPage(context, name));
    if (section === "surface" && name) return new LatePage(`Surface of ${name}`, async () => new (await import("./view_page")).ViewPage(context, name, true));
    if (section === "submit" && context.caller.role !== "read") {
      const {process, ...inputs} = given;
      return new SubmitPage(context, process ?? "triangulate", inputs);
    }
    const element = h("div", {}, heading("Nothing here"), emptyState("There is no such page", "The pages are linked above."));
    return {title: "Nothing here", element, close: () => undefined};
  }

  private put(page: Page, moved: boolean): void {
    this.page?.close();
    this.page = page;
    document.title = `${page.title} · Tessera`;
    replace(this.main, page.element);
    if (!moved) return;
    scrollTo(0, 0);
    page.element.querySelector<HTMLElement>("h1")?.focus({preventScroll: true});
  }
}

new App();
