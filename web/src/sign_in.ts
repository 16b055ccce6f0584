// Who has no cookie yet exchanges a token for one.
import {failure} from "./api";
import {h} from "./dom";
import {busy, heading, Notice, Page} from "./page";

export function signIn(then: () => void): Page {
  const notice = new Notice();
  const token = h("input", {id: "token", type: "password", autocomplete: "off", spellcheck: "false", required: true});
  const enter = h("button", {class: "primary"}, "Enter");
  const form = h("form", {class: "panel", onsubmit: event => {
    event.preventDefault();
    void busy(enter, () => notice.attempt(async () => {
      // The page's own address may stand below a prefix; the service's root is one up.
      const url = new URL("../", document.baseURI);
      url.searchParams.set("token", token.value.trim());
      const answer = await fetch(url, {headers: {Accept: "text/html"}, credentials: "same-origin"});
      if (!answer.ok) throw await failure(answer);
      token.value = "";
      then();
    }));
  }}, h("div", {class: "field"}, h("label", {for: "token"}, "Token"), token,
    h("p", {class: "help"}, "As the daemon printed it when it started, or as whoever runs it gave it to you. It is exchanged for a cookie, and not kept.")),
    h("div", {class: "actions"}, enter));
  return {title: "Sign in", element: h("div", {class: "sign-in"}, heading("Sign in"), notice.element, form), close: () => undefined};
}
