// Elements, made without markup: text is only ever text.

type Child = Node | string | number | null | undefined | false;
type Attributes = Record<string, string | number | boolean | null | undefined | ((event: Event) => void)>;

// Attributes that are functions are listeners ("onclick"); true is an empty attribute; null, undefined and false none.
export function h<K extends keyof HTMLElementTagNameMap>(
  name: K, attributes: Attributes = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(key.slice(2), value);
    else if (value === true) element.setAttribute(key, "");
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(key, String(value));
  }
  element.append(...kept(children));
  return element;
}

function kept(children: Child[]): (Node | string)[] {
  return children.filter((c): c is Node | string | number => c !== null && c !== undefined && c !== false)
    .map(c => typeof c === "number" ? String(c) : c);
}

export function svg(name: string, attributes: Record<string, string | number>, ...children: Node[]): SVGElement {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.append(...children);
  return element;
}

export function replace(element: Element, ...children: Child[]): void {
  element.replaceChildren(...kept(children));
}

// Only when it changes: what reads pages aloud would say it again, and what is selected would be lost.
export function say(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

export function show(element: HTMLElement, shown: boolean): void {
  element.hidden = !shown;
}

// True when the button that does it was chosen; Escape and the other one are no.
export function confirmed(question: string, explanation: string, action: string): Promise<boolean> {
  return new Promise(resolve => {
    const yes = h("button", {class: "danger", value: "yes"}, action);
    const dialog = h("dialog", {"aria-labelledby": "question", "aria-describedby": "explanation"},
      h("form", {method: "dialog"},
        h("h2", {id: "question"}, question), h("p", {id: "explanation"}, explanation),
        h("div", {class: "actions end"}, h("button", {value: "no", autofocus: true}, "Keep"), yes)));
    dialog.addEventListener("close", () => {
      resolve(dialog.returnValue === "yes");
      dialog.remove();
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}
