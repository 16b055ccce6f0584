// What is asked of every page, by tests/web/browser.py.
window.checks = (() => {
  const shifts = [];
  const note = entries => {
    for (const entry of entries)
      if (!entry.hadRecentInput) shifts.push([entry.value, ...entry.sources.map(s => s.node?.className || s.node?.nodeName || "")]);
  };
  const observer = new PerformanceObserver(list => note(list.getEntries()));
  observer.observe({type: "layout-shift", buffered: true});

  let events = 0;
  const parse = JSON.parse;
  JSON.parse = (text, ...more) => {
    const value = parse(text, ...more);
    if (value?.kind && value.jobID) ++events;
    return value;
  };

  const channels = colour => {
    const found = /^rgba?\(([^)]+)\)$/.exec(colour);
    if (!found) throw new Error(`a colour that the check cannot read: ${colour}`);
    const [r, g, b, a = 1] = found[1].split(/[\s,/]+/).map(Number);
    return {r, g, b, a};
  };
  const over = (top, low) => ({
    r: top.r * top.a + low.r * (1 - top.a), g: top.g * top.a + low.g * (1 - top.a), b: top.b * top.a + low.b * (1 - top.a), a: 1});
  const luminance = ({r, g, b}) => {  // WCAG 2.1, relative luminance
    const [x, y, z] = [r, g, b].map(v => v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4);
    return 0.2126 * x + 0.7152 * y + 0.0722 * z;
  };
  const ground = element => {
    const layers = [];
    for (let e = element; e; e = e.parentElement) {
      const colour = channels(getComputedStyle(e).backgroundColor);
      layers.push(colour);
      if (colour.a === 1) break;
    }
    return layers.reduceRight((low, top) => over(top, low), {r: 255, g: 255, b: 255, a: 1});
  };
  const visible = e => e.checkVisibility({checkOpacity: true, checkVisibilityCSS: true}) && e.getClientRects().length > 0;

  return {
    // How many events of jobs the page has heard.
    events: () => events,

    // What moved without having been told to, by how much (Layout Instability, 2: shares of the page), and what it was.
    shifts() {
      note(observer.takeRecords());
      return shifts;
    },

    // Text with less contrast than WCAG 2.1 AA asks for.
    contrast() {
      const poor = [];
      const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
      for (let node = texts.nextNode(); node; node = texts.nextNode()) {
        const element = node.parentElement;
        if (!node.data.trim() || !visible(element)) continue;
        const style = getComputedStyle(element);
        const colour = channels(style.color);
        if (colour.a === 0) continue;  // stands for a number that is not known yet
        const below = ground(element);
        const [light, dark] = [luminance(over(colour, below)), luminance(below)].sort((a, b) => b - a);
        const large = parseFloat(style.fontSize) >= 24 || (parseFloat(style.fontSize) >= 18.66 && style.fontWeight >= 700);
        const ratio = (light + 0.05) / (dark + 0.05);
        if (ratio < (large ? 3 : 4.5)) poor.push(`${node.data.trim().slice(0, 40)}: ${ratio.toFixed(2)} ${style.color}`);
      }
      return [...new Set(poor)];
    },

    // What stands out of the page to the right.
    beyond() {
      const width = document.documentElement.clientWidth;
      if (document.documentElement.scrollWidth <= width) return [];
      return [...document.querySelectorAll("body *")].filter(e => visible(e) && e.getBoundingClientRect().right > width + 1)
        .map(e => `${e.tagName} ${e.className} ${e.textContent.slice(0, 30)}`).slice(0, 5);
    },

    // Rows, panels and fields that lie over each other, and text that is cut off at the right without saying so.
    overlaps() {
      const wrong = [];
      for (const kind of [".row", ".panel", ".field", ".figure", "tbody tr"]) {
        const boxes = [...document.querySelectorAll(kind)].filter(visible).map(e => [e.getBoundingClientRect(), e]);
        boxes.forEach(([a, e], i) => boxes.slice(i + 1, i + 40).forEach(([b, f]) => {
          if (a.left + 1 < b.right && b.left + 1 < a.right && a.top + 1 < b.bottom && b.top + 1 < a.bottom && !e.contains(f))
            wrong.push(`${kind}: ${e.textContent.slice(0, 20)} and ${f.textContent.slice(0, 20)}`);
        }));
      }
      for (const e of document.querySelectorAll("button, .button, label, h1, h2, th, dt, .row > *, .state"))
        if (visible(e) && e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).display !== "inline"
            && getComputedStyle(e).textOverflow !== "ellipsis" && e.clientWidth > 1)
          wrong.push(`cut off: ${e.className} ${e.textContent.slice(0, 30)}`);
      return wrong.slice(0, 5);
    },

    // One h1, no level left out, one main, no id twice, every aria reference and label leads somewhere, each row in a table.
    structure() {
      const wrong = [];
      const levels = [...document.querySelectorAll("h1, h2, h3, h4")].filter(visible).map(e => Number(e.tagName[1]));
      if (levels.filter(l => l === 1).length !== 1) wrong.push(`h1: ${levels}`);
      levels.forEach((l, i) => { if (i && l > levels[i - 1] + 1) wrong.push(`heading levels: ${levels}`); });
      if (document.querySelectorAll("main").length !== 1) wrong.push("main");
      const ids = [...document.querySelectorAll("[id]")].map(e => e.id);
      for (const id of ids) if (ids.indexOf(id) !== ids.lastIndexOf(id)) wrong.push(`twice: ${id}`);
      for (const name of ["aria-labelledby", "aria-describedby", "for"])
        for (const e of document.querySelectorAll(`[${name}]`))
          for (const id of e.getAttribute(name).split(/\s+/)) if (!ids.includes(id)) wrong.push(`${name}: ${id}`);
      for (const cell of document.querySelectorAll("[role=cell], [role=columnheader]"))
        if (!cell.closest("[role=row]")?.closest("[role=table]")) wrong.push("a cell outside a table");
      if (document.documentElement.lang !== "en" || !document.title) wrong.push("language or title");
      return wrong;
    }
  };
})();
