// A job of several operations: listed, changed, planned, drawn, cut and told by name. In a real browser.
import assert from 'node:assert/strict';
import {readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, test} from 'node:test';

import {
  Desk, check_accessible, check_and_close, check_layout, click, close_browser, kPhone, kTablet, end, open_page, part_file, run, shot, stop_desks, text_of, type_field, wait_until, work,
} from './harness.mjs';

after(async () => {
  stop_desks();
  await close_browser();
});

const kNames = ['semi-finish', 'finish', 'middle once more'];

/** The job of config/jobs with wide steps, so that it is quick. */
async function operations_job(name) {
  const machines = new URL('../../config/machines/', import.meta.url).pathname, file = join(work, name);
  const text = readFileSync(new URL('../../config/jobs/pin_operations.yaml', import.meta.url), 'utf8')
    .replace(/stl: .*/, `stl: ${await part_file('pin')}`).replace('../machines/', machines)
    .replace('side_step_mm: 1.5', 'side_step_mm: 4').replace('side_step_mm: 0.5', 'side_step_mm: 3').replace('side_step_mm: 0.3', 'side_step_mm: 2');
  writeFileSync(file, text);
  return {file, text};
}

const job_text = (page) => page.evaluate(async () => (await fetch('/api/v1/job/text')).text());
const state = (page) => page.evaluate(async () => (await fetch('/api/v1/state')).json());
const names = (page) => page.$$eval('.operation .card strong', (nodes) => nodes.map((node) => node.textContent.replace(/^\d+\. /, '')));
const names_are = (page, wanted) => page.waitForFunction((all) => JSON.stringify([...document.querySelectorAll('.operation .card strong')].map((node) => node.textContent.replace(/^\d+\. /, ''))) === all,
  {polling: 100}, JSON.stringify(wanted));

async function open_job(name, options) {
  const {file, text} = await operations_job(name), desk = await Desk.start(file), page = await open_page(desk, options);
  await page.waitForSelector('#facets');
  return {file, text, desk, page};
}

/** Changed lines of a text, as [before, after]. */
function changes(before, after) {
  const a = before.split('\n'), b = after.split('\n');
  assert.equal(a.length, b.length, after);
  return a.flatMap((line, i) => line === b[i] ? [] : [[line.trim(), b[i].trim()]]);
}

test('operations are listed, and each is changed where it stands', async () => {
  const opened = await open_job('operations_edited.yaml'), {page, text} = opened;
  await page.locator('#tab-job').click();
  await names_are(page, kNames);
  assert.match(await text_of(page, '#operation-1'), /tool 1, ball 4 mm, raster, axis line.*not planned/);
  assert.match(await text_of(page, '#operation-2'), /tool 2, ball 2 mm/);
  await page.waitForFunction(async () => (await (await fetch('/api/v1/state')).json()).machine?.state === 'ready', {polling: 100});
  await shot(page, 'operations-job-1920');
  await check_accessible(page);
  await check_layout(page, false);
  await page.setViewport({width: 900, height: 700});  // small views are drawn faster
  // A section of its own: that operation's alone.
  await type_field(page, 'key-cutter.diameter_mm', '5');
  await page.waitForFunction(() => document.querySelector('#operation-1').textContent.includes('ball 5 mm'));
  let now = await job_text(page);
  assert.deepEqual(changes(text, now), [['cutter: {type: ball, diameter_mm: 4, length_mm: 110, shank_length_mm: 40}', 'cutter: {type: ball, diameter_mm: 5, length_mm: 110, shank_length_mm: 40}']]);
  assert.match(await text_of(page, '#operation-2'), /ball 2 mm/);
  // A section of all: what the other operations have, too, until it becomes its own.
  await page.locator('#operation-2').click();
  await page.waitForSelector('#operation-2[aria-pressed=true]');
  await page.waitForFunction(() => document.getElementById('key-cutter.diameter_mm')?.value === '2');
  await type_field(page, 'key-cutter.length_mm', '125');
  await page.waitForFunction(async () => (await (await fetch('/api/v1/job/text')).text()).includes('length_mm: 125, shank'));
  assert.equal(changes(now, now = await job_text(page)).length, 1);
  await click(page, '#own-cutter');
  await page.waitForFunction(() => document.querySelector('#own-cutter')?.textContent === 'Take that of all');
  now = await job_text(page);
  assert.match(now, /- name: finish\n[^-]*cutter: \{type: ball, diameter_mm: 2, length_mm: 125, shank_length_mm: 40\}/);
  assert(now.includes('# What each has by itself: a section here stands in place of the section above.'));
  await type_field(page, 'key-cutter.diameter_mm', '3');
  // Two cutters under one number: told, at its line.
  await page.waitForFunction(() => /different cutters under one tool number/.test(document.getElementById('job-errors').textContent));
  await type_field(page, 'key-program.tool', '3');
  await page.waitForFunction(() => document.querySelector('#operation-2').textContent.includes('tool 3, ball 3 mm'));
  await page.waitForFunction(() => document.querySelectorAll('#job-errors li').length === 0);
  // Another place, a copy, another name, one less.
  await click(page, '#operation-up-3');
  await names_are(page, ['semi-finish', 'middle once more', 'finish']);
  await page.waitForSelector('#operation-3[aria-pressed=true]', 'the one that was chosen goes with its fields');
  await type_field(page, 'operation-new', 'last');
  await page.locator('#operation-add').click();
  await names_are(page, ['semi-finish', 'middle once more', 'finish', 'last']);
  await page.locator('#operation-add').click();
  await page.waitForSelector('#operation-problem');
  assert.match(await text_of(page, '#operation-problem'), /is no name of an operation/);
  await wait_until(() => page.faults.length > 0);
  assert.match(page.faults.pop(), /409/);  // the browser tells of it, too
  assert.deepEqual(page.faults, []);
  await click(page, '#operation-remove-1');
  await names_are(page, ['middle once more', 'finish', 'last']);
  await type_field(page, 'operation-name', 'fine');
  await names_are(page, ['middle once more', 'fine', 'last']);
  assert.match(await job_text(page), /  # - name: semi-finish\n/);
  // By tool: the place in the program is told.
  await page.select('#operation-order', 'by_tool');
  await page.waitForFunction(async () => (await (await fetch('/api/v1/state')).json()).job.operation_order === 'by_tool');
  assert.equal((await state(page)).job.errors.length, 0);
  await page.locator('#job-save').click();
  await page.waitForFunction(() => document.getElementById('job-save').disabled);
  const checked = JSON.parse((await run('tiltfeed', 'check', opened.file, '--json')).out);
  assert.deepEqual(checked.job.map((one) => one.operation ?? one['operation.name'] ?? Object.entries(one).find(([key]) => key.startsWith('operation'))[1]).map((name) => name.replace(/.*\d of \d,? ?/, '').replace(/ \(.*/, '')).length, 3);
  await end(opened);
});

test('all are planned, drawn and cut by name, as the command line does it; one alone, too', async () => {
  const opened = await open_job('operations_planned.yaml', {viewport: {width: 900, height: 700}}), {page, file} = opened;
  await page.locator('#tab-plan').click();
  await page.waitForSelector('#plan:not([disabled])');
  assert.deepEqual(await page.$$eval('#plan-what option', (nodes) => nodes.map((node) => node.value)), ['', ...kNames]);
  await page.locator('#plan').click();
  await page.waitForFunction(() => document.querySelector('#blocks, #refused'));
  assert.equal(await page.$('#refused'), null);
  const out = join(work, 'operations.nc'), report_file = join(work, 'operations.json');
  assert.equal((await run('tiltfeed', 'plan', file, '--out', out, '--report', report_file, '--no-proof')).status, 0);
  const report = JSON.parse(readFileSync(report_file, 'utf8')), blocks = report.operations.map((one) => one.blocks);
  const rows = await page.$$eval('#plan-operations tbody tr', (nodes) => nodes.map((row) => [...row.children].map((cell) => cell.textContent)));
  assert.deepEqual(rows.map((row) => row[0]), ['all', ...kNames]);
  assert.deepEqual(rows.map((row) => Number(row[4].replace(/,/g, ''))), [report.blocks, ...blocks]);
  assert.deepEqual(rows.slice(1).map((row) => row[1]), ['1', '2', '2']);
  assert.match(await text_of(page, '#lower-bound'), /^No less than \d+:\d\d:\d\d \(\d+ % of the time\)/);
  const bound = report.operations.reduce((sum, one) => sum + one.lower_bounds.blocks_seconds, 0);
  assert.equal(Number(/\((\d+) %/.exec(await text_of(page, '#lower-bound'))[1]), Math.round(100 * bound / report.machining_seconds));
  assert.match(await text_of(page, '#moment'), /, middle once more$/);
  // What stays uncut, with the reasons, as the report counts them.
  const words = await text_of(page, '#plan-words'), walls = report.operations[0].uncut.facets.filter(({why}) => why === 'wall').length;
  assert(words.includes(`a wall along the tool axis (${walls.toLocaleString('en')} facets)`), words);
  // Each by its colour; one alone shows that colour and no other.
  await page.evaluate(() => window.tiltfeed.render());
  const colours = [[0, 114, 178], [213, 94, 0], [0, 158, 115]];
  const seen = () => page.evaluate((wanted) => {
    window.tiltfeed.render();
    const {clientWidth: width, clientHeight: height} = document.getElementById('canvas'), points = [];
    for (let x = 0; x < 160; ++x)
      for (let y = 0; y < 120; ++y) points.push([width * (x + 0.5) / 160, height * (y + 0.5) / 120]);
    const found = window.tiltfeed.colours_at(points);
    return wanted.map((colour) => found.filter((one) => colour.every((level, i) => Math.abs(level - one[i]) < 24)).length);
  }, colours);
  const all = await seen();
  assert(all.every((count) => count > 5), `every operation is seen: ${all}`);
  for (let i = 0; i < 3; ++i) {
    await click(page, `#path-operation-${i}`);
    const alone = await seen();
    assert(alone[i] > 5 && alone.every((count, k) => k === i || count === 0), `operation ${i} alone: ${alone}`);
    const last = blocks.slice(0, i + 1).reduce((sum, count) => sum + count, 0);
    assert.match(await text_of(page, '#moment'), new RegExp(`block ${last.toLocaleString('en')}, ${kNames[i]}$`));
    // The tool is the operation's.
    const radius = await page.evaluate(() => window.tiltfeed.path.tool.group.children.reduce((most, {geometry}) => {
      geometry.computeBoundingBox();
      return Math.min(most, geometry.boundingBox.max.x);
    }, Infinity));
    assert(Math.abs(radius - [2, 1, 1][i]) < 1e-3, `${radius}`);
  }
  await click(page, '#path-operation--1');
  await shot(page, 'operations-plan-900');
  await check_accessible(page);
  await check_layout(page, false);
  // Cut: the stock goes on.
  await page.locator('#tab-cut').click();
  await page.locator('#cut').click();
  await page.waitForSelector('#cut-operations, #cut-refused');
  assert.equal(await page.$('#cut-refused'), null);
  const verified = JSON.parse((await run('tiltfeed', 'verify', file, out, '--json')).out);
  const told = await page.$$eval('#cut-operations button', (nodes) => nodes.map((node) => [...node.children].map((child) => child.textContent)));
  assert.deepEqual(told, verified.operations.map(({operation, verdict}) => [operation, verdict[0].toUpperCase() + verdict.slice(1)]));
  for (const [i, name] of kNames.entries()) {
    await click(page, `#cut-operation-${name.replaceAll(' ', '-')}`);
    const removed = Math.round(verified.operations[i].removed_mm3).toLocaleString('en');
    await page.waitForFunction((title, text) => document.querySelector('#sheet h3')?.textContent === title && document.getElementById('cut-facts')?.textContent.includes(text), {}, name, `Removed${removed} mm³`);
  }
  await shot(page, 'operations-cut-900');
  await page.locator('#tab-job').click();
  assert.match(await text_of(page, '[data-state="1"]'), /^planned, cut: /);
  // One alone.
  await page.locator('#tab-plan').click();
  await page.select('#plan-what', 'finish');
  await page.locator('#plan').click();
  await page.waitForSelector('#planned-alone, #refused');
  assert.match(await text_of(page, '#planned-alone'), /finish alone/);
  assert.equal(await text_of(page, '#blocks'), blocks[1].toLocaleString('en'));
  await page.locator('#tab-job').click();
  assert.match(await text_of(page, '[data-state="1"]'), /^not planned$/);
  assert.match(await text_of(page, '[data-state="2"]'), /^planned alone$/);
  await end(opened);
});

test('an optimised plan says in words what it has changed', async () => {
  const opened = await open_job('operations_optimised.yaml'), {page} = opened;
  await page.locator('#tab-plan').click();
  await page.waitForSelector('#plan:not([disabled])');
  await page.select('#plan-what', 'semi-finish');
  await page.select('#plan-optimise', 'time');
  await page.locator('#plan').click();
  await page.waitForFunction(() => document.querySelector('#blocks, #refused'));
  assert.equal(await page.$('#refused'), null);
  const report = await page.evaluate(async () => (await fetch('/api/v1/plan/report')).json()), [tried] = report.shortest_time;
  assert.match(await text_of(page, '#plan-words'), tried.angle_deg === null ? /none of \d+ other plans/ : new RegExp(`with the passes ${tried.n ? "round the axis of the table" : `at ${tried.angle_deg}°`}.*, the best of ${tried.plans_tried} plans`));
  assert.equal((await state(page)).plan.optimise, 'time');
  await end(opened);
});

test('on a tablet and a phone, light and dark', async () => {
  const {file} = await operations_job('operations_small.yaml'), desk = await Desk.start(file);
  for (const [name, viewport, scheme] of [['1024', kTablet, 'dark'], ['390', kPhone, 'light']]) {
    const page = await open_page(desk, {viewport, scheme});
    await page.waitForSelector('#facets');
    await page.locator('#tab-job').click();
    await names_are(page, kNames);
    await page.waitForSelector('#own-cutter');
    await shot(page, `operations-job-${name}`);
    assert(await page.evaluate(() => document.getElementById('operations').compareDocumentPosition(document.getElementById('setup-stage')) & Node.DOCUMENT_POSITION_FOLLOWING), 'operations first');
    await check_layout(page, true);
    await check_accessible(page);
    await page.locator('#tab-axis').click();
    await page.waitForSelector('#axis-operation');
    await page.waitForSelector('#reach li');
    await check_layout(page, true);
    await shot(page, `operations-axis-${name}`);
    await check_and_close(page);
  }
  assert.equal(await desk.stop(), 0);
});
