// How quickly the page draws a path of a million blocks, and what memory it takes. A measurement, no test:
//   TILTFEED_BIN=build/release/bin TILTFEED_WORK=build/bench/view node tests/desk/view_bench.mjs [SIDE_STEP_MM]
// The tyre with rows so far apart; 0.12 mm makes some million blocks. chromium draws in software here.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';

import {Desk, close_browser, kDesktop, kPhone, open_browser, open_page, part_file, shot, work} from './harness.mjs';

const step = process.argv[2] ?? '0.12', kDrag = 5000;  // ms of moving the view

/** Of one process, MB; what several share counts in parts. */
function own_memory(pid) {
  try {
    return Number(/^Pss:\s+(\d+)/m.exec(readFileSync(`/proc/${pid}/smaps_rollup`, 'utf8'))[1]) / 1024;
  } catch {
    return 0;  // it has ended
  }
}

/** Of a process and all its children, MB; the page is the largest of the browser's. */
function memory_of(pid) {
  const rows = execFileSync('ps', ['-eo', 'pid=,ppid=,args='], {encoding: 'utf8'}).trim().split('\n').map((row) => row.trim().split(/\s+/));
  const family = new Set([String(pid)]);
  for (let size = 0; size !== family.size;) {
    size = family.size;
    for (const [child, parent] of rows) if (family.has(parent)) family.add(child);
  }
  const each = (word) => rows.filter(([id, , ...words]) => family.has(id) && words.join(' ').includes(word)).map(([id]) => own_memory(id));
  const all = each('').reduce((sum, mb) => sum + mb, 0);
  return {all, page: Math.max(0, ...each('--type=renderer')), gpu: Math.max(0, ...each('--type=gpu'))};
}

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

const text = readFileSync(new URL('../../config/jobs/tyre.yaml', import.meta.url), 'utf8'), job = join(work, 'view.yaml');
writeFileSync(job, text.replace(/stl: .*/, `stl: ${await part_file('tyre')}`).replace(/side_step_mm: .*/, `side_step_mm: ${step}`)
  .replace(/machine: \.\.\//, `machine: ${new URL('../../config/', import.meta.url).pathname}`));

for (const [width, viewport] of [[1920, kDesktop], [390, kPhone]]) {
  const desk = await Desk.start(job), page = await open_page(desk, {viewport});
  await page.waitForSelector('#facets');
  await page.locator('#tab-plan').click();
  await page.locator('#plan').click();
  await page.waitForFunction(() => document.querySelector('#blocks, #refused') && window.tiltfeed.frames.complete);
  const blocks = await page.evaluate(() => window.tiltfeed.path.blocks);
  assert(blocks > 0);
  const box = await (await page.$('#canvas')).boundingBox(), x = box.x + box.width / 2, y = box.y + box.height / 2;
  await page.evaluate(() => { window.tiltfeed.frames.took.length = 0; });
  await page.mouse.move(x, y);
  await page.mouse.down();
  let turn = 0;
  for (const begun = Date.now(); Date.now() - begun < kDrag; turn += 0.05)
    await page.mouse.move(x + box.width / 4 * Math.sin(turn), y + box.height / 8 * Math.sin(0.7 * turn));
  const took = await page.evaluate(() => [...window.tiltfeed.frames.took]);
  const begun = Date.now();
  await page.mouse.up();
  await page.waitForFunction(() => window.tiltfeed.frames.complete, {polling: 20});
  const whole = Date.now() - begun;
  const {JSHeapUsedSize: heap} = await page.metrics(), browser = memory_of((await open_browser()).process().pid);
  await shot(page, `view-${width}`);
  console.log(`${width} px: ${blocks} blocks; moving: ${(1000 / median(took)).toFixed(0)} frames/s (median of ${took.length}), the slowest ${Math.max(...took).toFixed(0)} ms; ` +
    `at rest whole after ${whole} ms; page ${browser.page.toFixed(0)} MB, of it JavaScript ${(heap / 1e6).toFixed(0)}; graphics ${browser.gpu.toFixed(0)} MB; ` +
    `desk ${memory_of(desk.child.pid).all.toFixed(0)} MB`);
  await page.browserContext().close();
  await desk.stop();
}
await close_browser();
