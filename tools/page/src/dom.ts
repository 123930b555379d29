// Elements by one call.

type Child = Node | string;
type Attributes = Record<string, string | number | boolean | ((event: never) => void)>;

function fill<E extends Element>(element: E, attributes: Attributes, children: Child[]): E {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, value as EventListener);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false) element.setAttribute(name, String(value));
  }
  element.append(...children);
  return element;
}

/** An HTML element; attributes that are functions listen to the event of that name. */
export function html<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  return fill(document.createElement(tag), attributes, children);
}

/** An SVG element. */
export function svg<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): SVGElementTagNameMap[K] {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

export function table(head: string[], rows: Child[][]): HTMLElement {
  return html(
    "div",
    { class: "scroll", tabindex: 0, role: "region", "aria-label": head.join(", ") },
    html(
      "table",
      {},
      html("thead", {}, html("tr", {}, ...head.map((text) => html("th", { scope: "col" }, text)))),
      html("tbody", {}, ...rows.map((row) => html("tr", {}, ...row.map((cell) => html("td", {}, cell))))),
    ),
  );
}

export function button(id: string, text: string, click: () => void, attributes: Attributes = {}): HTMLButtonElement {
  return html("button", { type: "button", id, click, ...attributes }, text);
}

export function checkbox(id: string, isChecked: boolean, change: () => void): HTMLInputElement {
  return html("input", { type: "checkbox", id, checked: isChecked, change });
}

/** A range up to `max` in 200 steps, at 0.6 of it. */
export function slider(id: string, min: number, max: number, input: () => void): HTMLInputElement {
  return html("input", { type: "range", id, min, max, step: max / 200, value: 0.6 * max, input });
}

/** A labelled <select>. */
export function choice(
  id: string,
  label: string,
  options: [string, string][],
  changed: (value: string) => void,
): { element: HTMLElement; select: HTMLSelectElement } {
  const select = html(
    "select",
    { id, change: () => changed(select.value) },
    ...options.map(([value, text]) => html("option", { value }, text)),
  );
  return { element: html("label", {}, `${label} `, select), select };
}

/** A section with its heading; `id` names it in links. */
export function section(id: string, title: string, ...children: Child[]): HTMLElement {
  return html(
    "section",
    { id, "aria-labelledby": `${id}-title` },
    html("h2", { id: `${id}-title` }, title),
    ...children,
  );
}

export function figure(caption: string, ...children: Child[]): HTMLElement {
  return html("figure", {}, html("figcaption", {}, caption), ...children);
}

/** A patch of a CSS colour with what it stands for. Class names say how else it looks (style.css). */
export function swatch(text: string, colour: string, look = ""): HTMLElement {
  return html("span", {}, html("i", { class: `swatch ${look}`, style: colour ? `--c: ${colour}` : false }), text);
}

/** A heading with contents that are folded away at first. */
export function details(title: string, ...children: Child[]): HTMLElement {
  return html("details", {}, html("summary", {}, title), ...children);
}
