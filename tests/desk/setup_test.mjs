// From a lone STL to a proven program by clicks; forms, the axis dragged, what it reaches. In a real browser.
import assert from 'node:assert/strict';
import {readFileSync, rmSync, copyFileSync, existsSync, mkdirSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';

import {
  Desk, check_accessible, check_layout, close_browser, drop, kPhone, kTablet, end, open_page, part_file, run, shot, stop_desks, tab_to, text_of, type_field, wait_until, work,
} from './harness.mjs';

let pin;
before(async () => { pin = await part_file('pin'); });
after(async () => {
  stop_desks();
  await close_browser();
});

const text = (page) => page.evaluate(async () => (await fetch('/api/v1/job/text')).text());
const wait_state = (page, holds) => wait_until(async () => holds(await page.evaluate(async () => (await fetch('/api/v1/state')).json())));

/** A desk with a part and a job for it, on the tab Axis. */
async function with_job(options) {
  const desk = await Desk.start(pin), page = await open_page(desk, options);
  await page.waitForSelector('#make-job:not([disabled])');
  await page.select('#new-diameter', '6');
  await page.locator('#make-job').click();
  await page.waitForSelector('#proposal-0');
  return {desk, page};
}

/** The exact answer for the job as it stands is told. */
const exact = (page) => page.waitForFunction(async () => {
  const {job} = await (await fetch('/api/v1/state')).json(), {exact: is, of} = document.getElementById('reach')?.dataset ?? {};
  return is === 'true' && of === String(job.id);
}, {polling: 100});

test('a dropped STL becomes a proven program by clicks alone, nothing typed', async () => {
  const desk = await Desk.start(), page = await open_page(desk);
  await page.waitForSelector('#sample-pin');
  assert.equal((await page.$$('#steps li')).length, 6);
  await check_accessible(page);
  await shot(page, 'start-1920');
  await drop(page, pin);
  await page.waitForSelector('#make-job:not([disabled])');
  let clicks = 0;
  const click = async (selector) => {
    await page.waitForSelector(selector + ':not([disabled])');
    await page.locator(selector).click();
    ++clicks;
  };
  await click('#make-job');
  await click('#proposal-0');
  await page.waitForSelector('#proposal-0.taken');
  await wait_state(page, ({job}) => job.errors.length === 0);
  await click('#axis-next');
  await click('#plan');
  await page.waitForFunction(() => document.querySelector('#blocks, #refused'));
  assert.equal(await page.$('#refused'), null, await page.evaluate(() => document.getElementById('refused')?.textContent));
  assert.match(await text_of(page, '#gouge'), /proven over [\d,]+ moves/);
  assert.equal(clicks, 4);
  await end({desk, page});
});

test('by keyboard alone: a formula part becomes a proven program, and is cut', async () => {
  const desk = await Desk.start(), page = await open_page(desk);
  let tabs = 0;
  const press = async (selector, key = 'Enter') => {
    tabs += await tab_to(page, selector);
    await page.keyboard.press(key);
  };
  await press('#sample-pin');
  await press('#make-job');
  await press('#proposal-0');
  await page.waitForSelector('#proposal-0.taken');
  await wait_state(page, ({job}) => job.errors.length === 0);
  await press('#axis-next');
  // Rows further apart, typed into their field.
  await press('#tab-plan', 'ArrowLeft');
  await press('#form-pattern:not([open]) summary');
  tabs += await tab_to(page, '[id="key-pattern.side_step_mm"]');
  await page.keyboard.down('Control');
  await page.keyboard.press('a');
  await page.keyboard.up('Control');
  await page.keyboard.type('2');
  await page.keyboard.press('Tab');
  await wait_state(page, ({job}) => job.errors.length === 0);
  await page.waitForFunction(async () => /side_step_mm: 2\b/.test(await (await fetch('/api/v1/job/text')).text()), {polling: 100});
  await press('#tab-job', 'ArrowRight');
  await press('#plan');
  await page.waitForSelector('#blocks');
  await press('#tab-plan', 'ArrowRight');
  await press('#cut');
  await wait_state(page, ({cut}) => cut?.state === 'done');
  console.log(`by keyboard: ${tabs} tabs`);
  await end({desk, page});
});

test('a formula part is tried with a click', async () => {
  const desk = await Desk.start(), page = await open_page(desk);
  await page.waitForSelector('#sample-handle');
  await page.locator('#sample-handle').click();
  await page.waitForSelector('#make-job');
  assert.match(await text_of(page, 'h2'), /handle\.stl/);
  await page.waitForSelector('#facets');
  await end({desk, page});
});

test('a job made here is saved beside its part, and the command line plans it', async () => {
  const folder = join(work, 'beside');
  rmSync(folder, {recursive: true, force: true});
  mkdirSync(folder);
  copyFileSync(pin, join(folder, 'mine.stl'));
  const desk = await Desk.start(join(folder, 'mine.stl')), page = await open_page(desk);
  await page.waitForSelector('#make-job:not([disabled])');
  await page.locator('#make-job').click();
  await page.locator('#tab-job').click();
  await page.waitForSelector('#job-save:not([disabled])');
  await page.locator('#job-save').click();
  await page.waitForFunction(() => document.getElementById('job-save').disabled);
  assert.equal(readFileSync(join(folder, 'mine.yaml'), 'utf8'), await text(page));
  assert(existsSync(join(folder, 'generic-ac.yaml')));
  assert.equal((await run('tiltfeed', 'check', join(folder, 'mine.yaml'))).status, 0);
  await end({desk, page});
});

test('forms change the text where it stands; remarks stay; errors are told at their field', async () => {
  const {desk, page} = await with_job();
  await page.locator('#tab-job').click();
  await page.waitForSelector('#cutter-drawing');
  await page.focus('#job-text');
  const remark = '# of mine';
  await page.$eval('#job-text', (area, words) => {
    area.value = area.value.replace('tolerance_mm: 0.01', `tolerance_mm: 0.01   ${words}`);
    area.dispatchEvent(new Event('input'));
  }, remark);
  await page.waitForFunction(async (words) => (await (await fetch('/api/v1/job/text')).text()).includes(words), {}, remark);
  const before = await text(page);
  await type_field(page, 'key-tolerance_mm', '0.02');
  await wait_state(page, ({job}) => job.errors.length === 0);
  await page.waitForFunction(async () => (await (await fetch('/api/v1/job/text')).text()).includes('0.02'));
  assert.equal(await text(page), before.replace(`tolerance_mm: 0.01   ${remark}`, `tolerance_mm: 0.02   ${remark}`));
  await page.waitForFunction((words) => document.getElementById('job-text').value.includes(`0.02   ${words}`), {}, remark);
  // A wrong value is told at its field, with the line; the drawing follows what is typed.
  await type_field(page, 'key-tolerance_mm', '5');
  await page.waitForSelector('[id="key-tolerance_mm"][aria-invalid="true"]');
  assert.match(await text_of(page, '[id="key-tolerance_mm-help"]'), /Line \d+: .*out of range.* at most 1/);
  await type_field(page, 'key-tolerance_mm', '0.01');
  await page.waitForFunction(() => !document.querySelector('[aria-invalid="true"]'));
  const width = () => page.$eval('#cutter-drawing .cutting', (node) => node.getBBox().height);
  const narrow = await width();
  await type_field(page, 'key-cutter.diameter_mm', '8');
  await page.waitForFunction((was) => document.querySelector('#cutter-drawing .cutting').getBBox().height > was + 1, {}, narrow);
  await page.select('[id="key-cutter.type"]', 'bull_nose');
  await page.waitForSelector('[id="key-cutter.corner_radius_mm"]');
  await type_field(page, 'key-cutter.corner_radius_mm', '1');
  await wait_state(page, ({job}) => job.errors.length === 0);
  await page.locator('#holder-add').click();
  await page.waitForSelector('#cutter-drawing .holder');
  await page.select('[id="key-cutter.type"]', 'ball');
  await page.waitForFunction(() => !document.querySelector('[id="key-cutter.corner_radius_mm"]'));
  await wait_state(page, ({job}) => job.errors.length === 0);
  await check_accessible(page);
  await check_layout(page, false);
  await shot(page, 'forms-1920');
  await end({desk, page});
});

/** Classes of colour in the view: how many places show each. */
const colours = (page) => page.evaluate(() => {
  const {clientWidth: width, clientHeight: height} = document.getElementById('canvas'), points = [];
  for (let x = 0; x < 60; ++x)
    for (let y = 0; y < 45; ++y) points.push([width * (x + 0.5) / 60, height * (y + 0.5) / 45]);
  const found = {green: 0, orange: 0, blue: 0};
  for (const [r, g, b] of window.tiltfeed.colours_at(points)) {
    if (g > r + 25 && g > b + 15) ++found.green;
    if (r > g + 40 && g > b + 15) ++found.orange;
    if (b > r + 50) ++found.blue;
  }
  return found;
});

test('the axis is dragged: what it reaches follows, exact when released, as the plan reports', async () => {
  const {desk, page} = await with_job();
  await page.locator('#proposal-0').click();
  await page.waitForSelector('#proposal-0.taken');
  await exact(page);
  const share = async () => Number(/([\d.]+)/.exec(await text_of(page, '[data-class="cut"] .share'))[1]);
  const first = await share();
  assert(first > 30, `${first} % is cut`);
  assert((await colours(page)).green > 30, 'what is cut is green');
  // Dragged along by its handle.
  const before = await text(page), box = await (await page.$('#canvas')).boundingBox();
  await page.evaluate(() => document.getElementById('snap').scrollIntoView({block: 'center'}));
  const at = await page.evaluate(() => {
    const {frame} = window.tiltfeed_axis.gizmo, p = frame.origin;
    return window.tiltfeed.project(p.x, p.y, p.z);
  });
  await page.locator('#snap').click();
  // The handle's middle moves in the plane of the screen.
  await page.mouse.move(box.x + at[0], box.y + at[1]);
  await page.mouse.down();
  for (let i = 1; i <= 6; ++i) await page.mouse.move(box.x + at[0] + 4 * i, box.y + at[1] - 3 * i);
  await page.waitForFunction(() => window.tiltfeed_axis.live.took.length > 0);
  await page.mouse.up();
  await page.waitForFunction(async (was) => (await (await fetch('/api/v1/job/text')).text()) !== was, {}, before);
  await exact(page);
  assert.notEqual(await share(), first);
  await check_accessible(page);
  await shot(page, 'axis-1920');
  await end({desk, page});
});

test('a face is clicked, shapes are fitted through it, and the axis goes there', async () => {
  const {desk, page} = await with_job();
  await page.locator('#mode-line').click();
  await page.waitForSelector('#mode-line[aria-pressed="true"]');
  await page.locator('#pick').click();
  await page.locator('[data-view="right"]').click();
  const at = await page.evaluate(() => window.tiltfeed.project(...window.tiltfeed.sphere.center.toArray()));
  const box = await (await page.$('#canvas')).boundingBox();
  await page.evaluate(() => window.tiltfeed_axis.gizmo.show(false));  // its handle lies over the middle
  await page.mouse.click(box.x + at[0], box.y + at[1]);
  await page.waitForSelector('#shape-0');
  await page.locator('#shape-0').click();
  await wait_state(page, ({job}) => job.errors.length === 0);
  await page.select('#snap-way', '[0,0,1]');
  await page.waitForFunction(async () => / t: \[0, 0, 1\]/.test(await (await fetch('/api/v1/job/text')).text()));
  await page.select('#snap-place', '000');
  await page.waitForFunction(async () => {
    const {part} = await (await fetch('/api/v1/state')).json(), written = /origin_mm: \[(.*)\]/.exec(await (await fetch('/api/v1/job/text')).text())[1].split(',').map(Number);
    return written.every((x, i) => Math.abs(x - (part.min_mm[i] + part.max_mm[i]) / 2) < 1e-3);
  });
  await end({desk, page});
});

for (const [width, viewport, scheme] of [[1024, kTablet, 'dark'], [390, kPhone, 'light']]) {
  test(`the set-up at ${width} px, ${scheme}, is without barriers`, async () => {
    const desk = await Desk.start(pin), page = await open_page(desk, {viewport, scheme});
    await page.waitForSelector('#make-job:not([disabled])');
    await shot(page, `make-${width}`);
    await check_accessible(page);
    await page.locator('#make-job').click();
    await page.waitForSelector('#proposal-0');
    await page.locator('#proposal-0').click();
    await page.waitForSelector('#proposal-0.taken');
    for (const tab of ['axis', 'job', 'part']) {
      await page.tap(`#tab-${tab}`);
      if (tab === 'axis') await exact(page);
      await check_accessible(page);
      await check_layout(page, true);
      await shot(page, `setup-${tab}-${width}`);
    }
    await end({desk, page});
  });
}
