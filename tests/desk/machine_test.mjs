// The machine in the view: the part dragged on its table, another machine chosen, bodies that move as the blocks say; and what is
// drawn while the view moves. In a real browser.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {after, test} from 'node:test';

import {Desk, check_accessible, check_layout, close_browser, differ, kPhone, end, open_page, part_file, pin_job, seen, shot, stop_desks, text_of, wait_until} from './harness.mjs';

after(async () => {
  stop_desks();
  await close_browser();
});

const open_tab = (page, tab) => page.locator(`#tab-${tab}`).click();
const part_zero = async (page) => /part_zero_mm: \[(.*)\]/.exec(await page.evaluate(async () => (await fetch('/api/v1/job/text')).text()))[1].split(',').map(Number);
/** The machine of the job as it stands is drawn. */
const drawn = (page) => page.waitForFunction(async () => {
  const {job, machine} = await (await fetch('/api/v1/state')).json();
  return machine?.state === 'ready' && machine.job === job.id && window.tiltfeed_setup.shows === machine.id;
}, {polling: 100});

test('the part is dragged on the table, put on it, over its axis; the travels are a box about it', async () => {
  const desk = await Desk.start(await pin_job('dragged.yaml', 2)), page = await open_page(desk);
  await page.waitForSelector('#facets');
  await open_tab(page, 'job');
  await drawn(page);
  const before = await part_zero(page), canvas = await (await page.$('#canvas')).boundingBox();
  // The box has the travels of the profile, about the part's zero.
  const travels = await page.evaluate(async () => {
    const {axes} = (await (await fetch('/api/v1/state')).json()).job, {machine} = window.tiltfeed, sides = [[1e9, -1e9], [1e9, -1e9], [1e9, -1e9]];
    const [m, edges] = [machine.placement().elements, machine.travel_edges(axes)];
    for (let k = 0; k < edges.length; k += 3)
      for (const a of [0, 1, 2]) {
        const along = m[a] * edges[k] + m[4 + a] * edges[k + 1] + m[8 + a] * edges[k + 2];  // of the table, from the part's zero
        sides[a] = [Math.min(sides[a][0], along), Math.max(sides[a][1], along)];
      }
    return {sides, limits: axes.slice(0, 3).map(({min, max}) => [min, max])};
  });
  travels.sides.forEach((side, a) => side.forEach((x, i) => assert(Math.abs(x - travels.limits[a][i]) < 1e-3, JSON.stringify(travels))));
  // By the handle's middle, in the plane of the screen; straight from above that is X and Y.
  await page.locator('[data-view="top"]').click();
  const grip = await page.evaluate(() => window.tiltfeed.project(...window.tiltfeed_setup.controls.object.position.toArray()));
  const [x, y] = [canvas.x + grip[0], canvas.y + grip[1]];
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 6; ++i) await page.mouse.move(x + 10 * i, y);
  const asked = await page.evaluate(() => window.tiltfeed_axis.live.took.length);
  await page.mouse.up();
  await page.waitForFunction(async (was) => !(await (await fetch('/api/v1/job/text')).text()).includes(was), {}, `part_zero_mm: [${before.join(', ')}]`);
  const moved = await part_zero(page), scale = await page.evaluate(() => window.tiltfeed.mm_of_pixel());
  assert(Math.abs(moved[0] - before[0] - 60 * scale) < 14 * scale && Math.abs(moved[1] - before[1]) < 1, `${before} ${moved}, ${scale} mm a pixel, asked ${asked} times`);
  await drawn(page);
  assert.match(await text_of(page, '#setup-state'), /% of the surface is cut/);
  await page.locator('#on-table').click();
  await page.waitForFunction(() => {
    const {machine, part} = window.tiltfeed, box = window.tiltfeed.part_box(part.matrix);
    return Math.abs(box.min.z - machine.table_top) < 2e-3;
  });
  await drawn(page);
  await page.locator('#on-axis').click();
  await page.waitForFunction(() => {
    const box = window.tiltfeed.part_box(window.tiltfeed.part.matrix);
    return Math.abs(box.min.x + box.max.x) < 4e-3 && Math.abs(box.min.y + box.max.y) < 4e-3;
  });
  await drawn(page);
  await page.locator('[data-view="iso"]').click();
  // The table is seen beside the part, in a colour of its own.
  const grey = await page.evaluate(() => {
    const {clientWidth: w, clientHeight: h} = document.getElementById('canvas'), points = [];
    for (let i = 0; i < 60; ++i) for (let k = 0; k < 60; ++k) points.push([w * (i + 0.5) / 60, h * (k + 0.5) / 60]);
    const all = window.tiltfeed.colours_at(points), ground = all[0];
    return all.filter((c) => c.some((x, i) => Math.abs(x - ground[i]) > 12)).length;
  });
  assert(grey > 100, `${grey} of 3,600 places show part or table`);
  await check_accessible(page);
  await check_layout(page, false);
  await shot(page, 'job-table-1920');
  // Elsewhere the part lies as in its file.
  await open_tab(page, 'axis');
  assert.deepEqual(await page.evaluate(() => window.tiltfeed.part.matrix.elements.filter((x, i) => x !== (i % 5 === 0 ? 1 : 0))), []);
  await end({desk, page});
});

test('another machine is chosen later; the job is saved with it', async () => {
  const job = await pin_job('elsewhere.yaml', 2), desk = await Desk.start(job), page = await open_page(desk, {viewport: kPhone});
  await page.waitForSelector('#facets');
  await page.tap('#tab-job');
  await page.waitForSelector('#job-machine option[value="linuxcnc-trunnion-ac"]');
  await page.select('#job-machine', 'linuxcnc-trunnion-ac');
  await page.waitForFunction(() => /linuxcnc-trunnion-ac/.test(document.getElementById('job-state').textContent));
  await drawn(page);
  await check_layout(page, true);
  await check_accessible(page);
  await shot(page, 'job-machine-390');
  await page.waitForSelector('#job-save:not(:disabled)');
  await page.locator('#job-save').click();
  await wait_until(() => /machine: .*linuxcnc-trunnion-ac\.yaml/.test(readFileSync(job, 'utf8')));
  await end({desk, page});
});

test('the machine moves as the blocks say', async () => {
  const desk = await Desk.start(await pin_job('moving.yaml', 2)), page = await open_page(desk);
  await page.waitForSelector('#facets');
  await open_tab(page, 'plan');
  await page.locator('#plan').click();
  await page.waitForFunction(() => document.querySelector('#blocks, #refused'));
  assert.equal(await page.$('#refused'), null);
  await drawn(page);
  // Its tip, by the axes alone, is where the planner put it.
  const off = await page.evaluate(() => {
    const {machine, path} = window.tiltfeed, n = path.all;
    let most = 0;
    for (let i = 0; i < path.blocks; i += 97) {
      const tip = machine.tip([...n.subarray(14 * i + 9, 14 * i + 14)]);
      most = Math.max(most, Math.hypot(tip.x - n[14 * i], tip.y - n[14 * i + 1], tip.z - n[14 * i + 2]));
    }
    return most;
  });
  assert(off < 2e-3, `${off} mm`);  // float32
  const bare = await seen(page);
  await page.select('#machine-shown', 'all');
  const end_of_run = await seen(page);
  assert(differ(bare, end_of_run) > 100, 'the machine is seen');
  await page.$eval('#time', (slider) => {
    slider.value = 4321;
    slider.dispatchEvent(new Event('input'));
  });
  assert(differ(await seen(page), end_of_run) > 20, 'it has moved');
  await check_accessible(page);
  await shot(page, 'plan-machine-1920');
  await end({desk, page});
});

test('a long path is thinned while the view moves, and whole when it rests', async () => {
  const desk = await Desk.start(await part_file('pin')), page = await open_page(desk);
  await page.waitForSelector('#facets');
  await open_tab(page, 'plan');
  await page.evaluate(() => {
    const {path, box} = window.tiltfeed, count = 60000, n = new Float32Array(14 * count), {min, max} = box;
    for (let i = 0; i < count; ++i) {
      const t = i / count, turn = 300 * 2 * Math.PI * t, r = 0.7 * (max.y - min.y);
      n.set([min.x + (max.x - min.x) * t, r * Math.cos(turn), r * Math.sin(turn), 0, 0, 1, i, 2, 1], 14 * i);
    }
    path.show(n, [], []);
    path.tool.group.visible = false;
  });
  const complete = () => page.waitForFunction(() => window.tiltfeed.frames.complete);
  await complete();
  // A card, or a quick computer, would draw all of it at once: here each line is said to take long.
  const thin = await page.evaluate(async () => {
    const {frames} = window.tiltfeed, heavy = frames.heavy.find(({count}) => count === 60000);
    heavy.ms_each = 0.01;
    frames.redraw();
    await new Promise(requestAnimationFrame);
    const {index, drawRange} = heavy.object.geometry, n = window.tiltfeed.path.all;
    // Every point left out is near the line that stands for it.
    let off = 0;
    for (let k = 0; index && k + 1 < drawRange.count; ++k) {
      const a = 14 * index.array[k], b = 14 * index.array[k + 1], d = [0, 1, 2].map((c) => n[b + c] - n[a + c]), d2 = d[0] ** 2 + d[1] ** 2 + d[2] ** 2;
      for (let i = a + 14; i < b; i += 14) {
        const p = [0, 1, 2].map((c) => n[i + c] - n[a + c]), t = Math.min(1, Math.max(0, (p[0] * d[0] + p[1] * d[1] + p[2] * d[2]) / d2));
        off = Math.max(off, Math.hypot(...p.map((x, c) => x - t * d[c])));
      }
    }
    return {drawn: index ? drawRange.count : 60000, off, complete: frames.complete, last: index?.array[drawRange.count - 1]};
  });
  assert(thin.drawn < 20000 && !thin.complete && thin.last === 59999, JSON.stringify(thin));
  const size = await page.evaluate(() => 2 * window.tiltfeed.sphere.radius);
  assert(thin.off > 0 && thin.off < size / 20, JSON.stringify(thin));
  await complete();
  const pieces = await page.screenshot({encoding: 'base64'});
  await page.evaluate(() => window.tiltfeed.render());
  assert.equal(await page.evaluate(() => window.tiltfeed.frames.heavy.find(({count}) => count === 60000).object.geometry.index), null);
  const apart = await page.evaluate(async (shots) => {
    const [a, b] = await Promise.all(shots.map(async (text) => {
      const bitmap = await createImageBitmap(new Blob([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))])), canvas = new OffscreenCanvas(bitmap.width, bitmap.height), to = canvas.getContext('2d');
      to.drawImage(bitmap, 0, 0);
      return to.getImageData(0, 0, bitmap.width, bitmap.height).data;
    }));
    let differ = 0;
    for (let i = 0; i < a.length; i += 4) if (Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 48) ++differ;
    return differ / (a.length / 4);
  }, [pieces, await page.screenshot({encoding: 'base64'})]);
  assert(apart < 1e-3, `in pieces and at once: ${apart} of the picture differs`);
  await end({desk, page});
});
