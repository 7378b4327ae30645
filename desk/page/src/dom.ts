// Elements from text and children; text is always text, never markup.

type Child = Node | string | null | undefined | false;
type Props = Record<string, string | boolean | number | EventListener | undefined>;

/** A prop whose value is a function is a listener: `click`, `input`. */
export function el<K extends keyof HTMLElementTagNameMap>(tag: K, props: Props = {}, ...children: Child[]) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(props)) {
    if (typeof value === 'function') node.addEventListener(name, value);
    else if (value === true) node.setAttribute(name, '');
    else if (value !== false && value !== undefined) node.setAttribute(name, String(value));
  }
  for (const child of children) if (child) node.append(child);
  return node;
}

/**
 * Other children in place of those before. What had the focus has it again, where something of its id is still there;
 * else the host has it, so that Tab goes on from here.
 */
export function refill(host: HTMLElement, ...nodes: (Node | string)[]): void {
  const had = document.activeElement, inside = had !== null && had !== host && host.contains(had);
  host.replaceChildren(...nodes);
  if (!inside) return;
  const again = had.id ? document.getElementById(had.id) : null;
  again?.focus({preventScroll: true});
  if (document.activeElement === again && again) return;
  host.tabIndex = -1;
  host.focus({preventScroll: true});
}

export function byId<T extends HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`no element ${id}`);
  return found as T;
}

/** A length for people: four digits. */
export const length_text = (mm: number) => Number(mm.toPrecision(4)).toString();

export const size_text = (size: number[]) => size.map(length_text).join(' x ') + ' mm';

export const count_text = (count: number) => count.toLocaleString('en');
