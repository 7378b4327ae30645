/** Tells where the pointer is over the canvas, in its own pixels, once a frame; a touch, too. `left`: a mouse has gone. */
export function on_hover(canvas: HTMLCanvasElement, wanted: () => boolean, at: (x: number, y: number) => void, left: () => void): void {
  let due = false;
  const hover = (event: PointerEvent) => {
    if (due || !wanted()) return;
    due = true;
    requestAnimationFrame(() => {
      due = false;
      const box = canvas.getBoundingClientRect();
      at(event.clientX - box.left, event.clientY - box.top);
    });
  };
  canvas.addEventListener('pointermove', (event) => { if (event.buttons === 0) hover(event); });
  canvas.addEventListener('pointerdown', hover);
  canvas.addEventListener('pointerleave', (event) => { if (event.pointerType === 'mouse') left(); });
}
