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
    h("p", {class: "help"}, "The daemon prints a token when it starts; otherwise ask the person who runs the daemon. This page exchanges the token for a cookie that ends after a week, and does not keep the token.")),
    h("div", {class: "actions"}, enter));
  return {title: "Sign in", element: h("div", {class: "sign-in"}, heading("Sign in"), notice.element, form), close: () => undefined};
}
