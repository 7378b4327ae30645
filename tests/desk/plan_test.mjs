// Job and Plan: the text is checked as it is typed, the program planned, followed, cancelled, drawn. In a real browser.
import assert from 'node:assert/strict';
import {appendFileSync, readFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, test} from 'node:test';

import {
  Desk, check_accessible, check_and_close, check_layout, close_browser, kPhone, kTablet, end, open_page, part_job, pin_job, run, shot, stop_desks, text_of, work,
} from './harness.mjs';

after(async () => {
  stop_desks();
  await close_browser();
});

/** A desk of its own with a job of its own. */
async function with_desk(name) {
  const job = await pin_job(`${name}.yaml`, 2);
  return {job, desk: await Desk.start(job)};
}

const open_tab = (page, tab) => page.locator(`#tab-${tab}`).click();
const ready = (page) => page.waitForFunction(() => document.querySelector('#facets'));

/** Puts the text in place of all that is in the editor, by keys, and waits for the check. */
async function type_job(page, text) {
  await page.focus('#job-text');
  await page.evaluate((value) => {
    const area = document.getElementById('job-text');
    area.value = value;
    area.dispatchEvent(new Event('input'));
  }, text.slice(0, -1));
  await page.keyboard.down('Control');
  await page.keyboard.press('End');
  await page.keyboard.up('Control');
  await page.keyboard.type(text.slice(-1));
}

test('an error in the job is told at its line; what is right is saved, remarks and all', async () => {
  const {desk, job} = await with_desk('typed');
  const page = await open_page(desk);
  await ready(page);
  await open_tab(page, 'job');
  const text = await page.$eval('#job-text', (area) => area.value);
  assert.equal(text, readFileSync(job, 'utf8'));
  const line = text.split('\n').findIndex((words) => words.startsWith('tolerance_mm')) + 1;
  await type_job(page, text.replace('tolerance_mm', 'tolerance_in'));
  await page.waitForFunction(() => document.querySelectorAll('#job-errors li').length > 0);
  const told = await text_of(page, '#job-errors');
  assert.match(told, new RegExp(`Line ${line} .*tolerance_in.*tolerance_mm`));
  assert.equal(await page.$eval('#job-save', (node) => node.disabled), true);
  await page.locator('#job-errors button').click();
  await page.waitForFunction((wanted) => {
    const area = document.getElementById('job-text');
    return area.value.slice(0, area.selectionStart).split('\n').length === wanted;
  }, {}, line);
  await check_accessible(page);
  await check_layout(page, false);
  await shot(page, 'job-1920');
  const right = text.replace(/^tolerance_mm/m, '# typed in the page\ntolerance_mm');
  await type_job(page, right);
  await page.waitForFunction(() => !document.getElementById('job-save').disabled);
  assert.equal(readFileSync(job, 'utf8'), text, 'nothing is saved unasked');
  await page.locator('#job-save').click();
  await page.waitForFunction(() => document.getElementById('job-save').disabled);
  assert.equal(readFileSync(job, 'utf8'), right);
  await end({desk, page});
});

test('a plan is made and proven, its path drawn, the slider goes through its time', async () => {
  const {desk, job} = await with_desk('planned');
  const page = await open_page(desk);
  await ready(page);
  await open_tab(page, 'plan');
  await page.locator('#plan').click();
  await page.waitForFunction(() => document.querySelector('#blocks, #refused'));
  assert.equal(await page.$('#refused'), null, 'not refused');
  assert.match(await text_of(page, '#gouge'), /proven over [\d,]+ moves/);
  // The same job by the command line, and its drawing read here.
  const out = join(work, 'by_hand.nc'), drawing = join(work, 'by_hand.f32');
  const planned = await run('tiltfeed', 'plan', job, '--out', out, '--drawing', drawing, '--no-proof');
  assert.equal(planned.status, 0);
  const bytes = readFileSync(drawing), numbers = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
  const blocks = numbers.length / 14, seconds = numbers[numbers.length - 8];
  assert.equal(await text_of(page, '#blocks'), blocks.toLocaleString('en'));
  assert.match(await text_of(page, '#moment'), new RegExp(`block ${blocks.toLocaleString('en')}$`));
  // Half the time: the tool stands where the last block that has ended then ends.
  await page.$eval('#time', (slider) => {
    slider.value = 5000;
    slider.dispatchEvent(new Event('input'));
  });
  let last = 0;
  while (last + 1 < blocks && numbers[14 * (last + 1) + 6] <= seconds / 2) ++last;
  assert.match(await text_of(page, '#moment'), new RegExp(`block ${(last + 1).toLocaleString('en')}$`));
  const tool = await page.evaluate(() => window.tiltfeed.path.tool.group.position.toArray()), next = 14 * (last + 1);
  const share = (seconds / 2 - numbers[next - 8]) / (numbers[next + 6] - numbers[next - 8]);
  for (let k = 0; k < 3; ++k) assert(Math.abs(tool[k] - numbers[next - 14 + k] * (1 - share) - numbers[next + k] * share) < 1e-2, `${tool} after block ${last}`);
  // By keys, too.
  await page.focus('#time');
  await page.keyboard.press('Home');
  assert.match(await text_of(page, '#moment'), /^0:00:00, block 1$/);
  await page.keyboard.press('End');
  for (const colouring of ['height', 'tilt', 'time', 'feed', 'axis', 'kind']) {
    await page.select('#colour', colouring);
    assert.equal(await page.$eval('#legend', (node) => node.hidden), colouring === 'kind');
  }
  // Cuts are green in the light scheme, and some of what is drawn is a cut.
  const green = await page.evaluate(() => {
    const {clientWidth: width, clientHeight: height} = document.getElementById('canvas'), points = [];
    for (let x = 0; x < 80; ++x)
      for (let y = 0; y < 60; ++y) points.push([width * (x + 0.5) / 80, height * (y + 0.5) / 60]);
    return window.tiltfeed.colours_at(points).filter(([r, g, b]) => g > r + 40 && g > b + 20).length;
  });
  assert(green > 20, `${green} places show a cut`);
  // The pointer on the end of a block in sight tells which it is; the map says of which move.
  const spot = await page.evaluate(() => {
    const {path, canvas} = window.tiltfeed, n = path.all;
    for (let i = Math.floor(path.blocks / 3); i < path.blocks; ++i) {
      const [x, y] = window.tiltfeed.project(n[14 * i], n[14 * i + 1], n[14 * i + 2]);
      if (window.tiltfeed.pick_block(x, y) === i) return {i, x: x + canvas.getBoundingClientRect().left, y: y + canvas.getBoundingClientRect().top};
    }
    return null;
  });
  assert(spot, 'a block is found where it is drawn');
  await page.mouse.move(spot.x, spot.y);
  await page.waitForFunction((i) => document.getElementById('plan-tip').textContent.includes(`block ${(i + 1).toLocaleString('en')},`), {}, spot.i);
  assert.match(await text_of(page, '#plan-tip'), /move [\d,]+, facet [\d,]+/);
  // The plots' words are those of the last block, their peaks those of the numbers.
  await page.locator('#plots summary').click();
  const words = await page.$$eval('.plot-word', (nodes) => nodes.map((node) => parseFloat(node.textContent)));
  words.forEach((word, a) => assert(Math.abs(word - numbers[numbers.length - 5 + a]) < 2e-3, `${words}`));
  const course = await page.$$eval('canvas.plot', (nodes) => nodes.map((node) => node.getAttribute('aria-label')));
  assert.equal(course.length, 5);
  for (const text of course) {
    const [speed, fastest, gain, hardest] = [...text.matchAll(/([\d.,]+) of ([\d.,]+)/g)].flatMap(([, a, b]) => [a, b].map((digits) => Number(digits.replace(/,/g, ''))));
    assert(speed <= fastest * 1.001 && gain <= hardest * 1.001, text);
  }
  let least = Infinity, most = -Infinity;
  for (let i = 0; i < blocks; ++i) [least, most] = [Math.min(least, numbers[14 * i + 9]), Math.max(most, numbers[14 * i + 9])];
  const [, from, to] = /time: (\S+) to (\S+) mm/.exec(course[0]).map((text) => Number(text.replace(/,/g, '')));
  assert(Math.abs(from - least) <= Math.abs(least) * 1e-3 && Math.abs(to - most) <= Math.abs(most) * 1e-3, course[0]);
  // A click in a plot goes to that time, and the cursor stands there.
  const plot = await (await page.$('canvas.plot')).boundingBox();
  await page.mouse.click(plot.x + plot.width / 4, plot.y + 20);
  assert(Math.abs(await page.$eval('#time', (node) => Number(node.value)) - 2500) < 50);
  const cursor = await page.$eval('.plot-cursor', (node) => node.getBoundingClientRect().left);
  assert(Math.abs(cursor + 1 - plot.x - plot.width / 4) < 3);
  await check_accessible(page);
  await check_layout(page, false);
  await shot(page, 'plan-1920');
  const program = await page.evaluate(async () => (await fetch(document.getElementById('download').href)).text());
  const strip = (text) => text.split('\n').filter((words) => !words.startsWith('(')).join('\n');
  assert.equal(strip(program), strip(readFileSync(out, 'utf8')), 'the blocks are those of the command line');
  await end({desk, page});
});

for (const [width, viewport, scheme] of [[1024, kTablet, 'dark'], [390, kPhone, 'dark']]) {
  test(`the steps at ${width} px, dark, are without barriers`, async () => {
    const {desk} = await with_desk(`steps-${width}`);
    const page = await open_page(desk, {viewport, scheme});
    await ready(page);
    for (const tab of ['part', 'job', 'plan']) {
      await page.tap(`#tab-${tab}`);
      assert.equal(await page.$eval(`#tab-${tab}`, (node) => node.getAttribute('aria-selected')), 'true');
      await check_accessible(page);
      await check_layout(page, true);
      await shot(page, `${tab}-${width}`);
    }
    await end({desk, page});
  });
}

test('axes that turn evenly and rows that go all the way round are told in words', async () => {
  const job = await part_job('sphere', 'calm.yaml', 6);
  appendFileSync(job, 'points: {calm_deg: 5}\n');
  const desk = await Desk.start(job), page = await open_page(desk);
  await ready(page);
  await open_tab(page, 'plan');
  await page.waitForSelector('#plan:not([disabled])');
  await page.locator('#plan').click();
  await page.waitForFunction(() => document.querySelector('#blocks, #refused'));
  assert.equal(await page.$('#refused'), null, 'not refused');
  const planned = await run('tiltfeed', 'plan', job, '--out', join(work, 'calm.nc'), '--json'), report = JSON.parse(planned.out);
  assert(report.calm.points > 0 && report.closed_rows > 1, planned.out);
  const words = await text_of(page, '#plan-words');
  assert.match(words, new RegExp(`For even turns the axis leans by up to ${Number(report.calm.largest_deg.toPrecision(4))}° at ${report.calm.points.toLocaleString('en')} points\\.`));
  assert.match(words, new RegExp(`${report.closed_rows} rows go all the way round\\.`));
  await end({page, desk});
});

test('tabs go by arrow keys; a changed job makes the plan stale', async () => {
  const {desk} = await with_desk('stale');
  const page = await open_page(desk);
  await ready(page);
  await open_tab(page, 'plan');
  await page.locator('#plan').click();
  await page.waitForSelector('#blocks');
  await open_tab(page, 'axis');
  await page.keyboard.press('ArrowRight');
  assert.equal(await page.evaluate(() => document.activeElement.id), 'tab-job');
  const text = await page.$eval('#job-text', (area) => area.value);
  await type_job(page, text + '# a remark\n');
  await page.waitForFunction(() => !document.getElementById('job-save').disabled);
  await page.focus('#tab-job');
  await page.keyboard.press('ArrowRight');
  await page.waitForSelector('#stale');
  await end({desk, page});
});

test('a long plan is cancelled; another page sees it', async () => {
  const endless = await Desk.start(await pin_job('endless.yaml', 0.002));
  const page = await open_page(endless), other = await open_page(endless);
  for (const each of [page, other]) {
    await ready(each);
    await open_tab(each, 'plan');
  }
  await page.locator('#plan').click();
  await other.waitForSelector('#cancel');
  await other.waitForFunction(() => /, \d+ %$/.test(document.getElementById('stage').textContent));
  await other.locator('#cancel').click();
  for (const each of [page, other]) {
    await each.waitForSelector('#cancelled');
    await check_and_close(each);
  }
  assert.equal(await endless.stop(), 0);
});
