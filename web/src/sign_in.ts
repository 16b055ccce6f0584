// Who has no cookie yet exchanges a token for one, and gives the cookie back.
import {address, failure, send} from "./api";
import {h} from "./dom";
import {busy, heading, Notice, Page} from "./page";

// Of the link that the daemon prints: what stands behind "#" is sent nowhere, and so in nobody's log. Nor does it stay in
// the address.
export function takeToken(): string | null {
  const token = /^#token=(\S+)$/.exec(location.hash)?.[1] ?? null;
  if (token !== null) history.replaceState(null, "", location.pathname);
  return token;
}

export async function exchange(token: string): Promise<void> {
  const answer = await fetch(address("session"), {method: "POST", headers: {Authorization: `Bearer ${token}`},
    credentials: "same-origin"});
  if (!answer.ok) throw await failure(answer);
}

export async function signOut(): Promise<void> {
  await send("DELETE", address("session"));
}

export function signIn(then: () => void): Page {
  const notice = new Notice();
  const token = h("input", {id: "token", type: "password", autocomplete: "off", spellcheck: "false", required: true});
  const enter = h("button", {class: "primary"}, "Enter");
  const form = h("form", {class: "panel", onsubmit: event => {
    event.preventDefault();
    void busy(enter, () => notice.attempt(async () => {
      await exchange(token.value.trim());
      token.value = "";
      then();
    }));
  }}, h("div", {class: "field"}, h("label", {for: "token"}, "Token"), token,
    h("p", {class: "help"}, "As the daemon printed it when it started, or as whoever runs it gave it to you. It is exchanged for a cookie that ends after a week, and not kept.")),
    h("div", {class: "actions"}, enter));
  return {title: "Sign in", element: h("div", {class: "sign-in"}, heading("Sign in"), notice.element, form), close: () => undefined};
}
