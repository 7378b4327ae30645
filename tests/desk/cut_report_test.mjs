// The page that `tiltfeed verify --out` writes: the part in 3D with what is left on it, in one file, in a real browser.
import assert from 'node:assert/strict';
import {readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';

import {check_accessible, check_and_close, check_layout, close_browser, differ, kDesktop, kPhone, kTablet, open_file, pin_job, run, seen, shot, text_of, work} from './harness.mjs';

const folder = join(work, 'cut_report'), page_of = (name) => join(folder, name, 'index.html');
const kSmall = {width: 1100, height: 800};
let good, bad;

/** Blocks here and there go 0.5 mm deeper. */
function damage(text) {
  const lines = text.split('\n'), cuts = [...lines.keys()].filter((i) => /^[XYAC].*Z-?[\d.]+/.test(lines[i]));
  for (let k = 1; k < 20; ++k) {
    const at = cuts[Math.floor(cuts.length * k / 20)];
    lines[at] = lines[at].replace(/Z(-?[\d.]+)/, (_, z) => `Z${(Number(z) - 0.5).toFixed(4)}`);
  }
  return lines.join('\n');
}

before(async () => {
  const job = await pin_job('cut_report.yaml', 0.5), program = join(work, 'cut_report.nc'), broken = join(work, 'cut_report_bad.nc');
  assert.equal((await run('tiltfeed', 'plan', job, '--out', program, '--no-proof')).status, 0);
  writeFileSync(broken, damage(readFileSync(program, 'utf8')));
  assert.equal((await run('tiltfeed', 'verify', job, program, '--out', join(folder, 'good'))).status, 0);
  assert.equal((await run('tiltfeed', 'verify', job, broken, '--out', join(folder, 'bad'))).status, 1);
  [good, bad] = ['good', 'bad'].map((name) => JSON.parse(readFileSync(join(folder, name, 'report.json'), 'utf8')));
});
after(close_browser);

/** How many of the view's places have such a colour. */
const count_of = (page, colour) => page.evaluate((body) => {
  const is = new Function('r', 'g', 'b', `return ${body}`), {clientWidth: width, clientHeight: height} = document.getElementById('canvas'), points = [];
  for (let x = 0; x < 80; ++x)
    for (let y = 0; y < 60; ++y) points.push([width * (x + 0.5) / 80, height * (y + 0.5) / 60]);
  return window.tiltfeed.colours_at(points).filter(([r, g, b]) => is(r, g, b)).length;
}, colour);
const kGreen = 'g > r + 25 && g > b + 15', kBrown = 'r > g + 15 && g > b + 15 && r < 200', kSteel = 'b > r + 15 && b > g + 4 && r > 70';

const set_time = (page, value) => page.$eval('#cut-time', (slider, to) => {
  slider.value = to;
  slider.dispatchEvent(new Event('input'));
}, value);

test('the part shows what is left; the pointer tells the value that the report has', async () => {
  const page = await open_file(page_of('good'));
  assert(await count_of(page, kGreen) > 300, 'most of the part is finished');
  assert.equal(await page.$eval('#picture', (node) => node.hidden), true, 'the fixed picture stands back');
  await shot(page, 'cut-report-1920');
  // Where the report says that most is left, the pointer finds that facet and as much.
  const worst = good.most_left[0];
  await page.locator('#cut-places button').click();
  const [x, y] = await page.evaluate((place) => window.tiltfeed.project(...place), worst.place_mm ?? worst.place);
  const box = await (await page.$('#canvas')).boundingBox();
  await page.mouse.move(box.x + x, box.y + y);
  await page.waitForFunction((facet) => document.getElementById('cut-tip').textContent.includes(`facet ${facet.toLocaleString('en')}`), {}, worst.facet);
  const told = await text_of(page, '#cut-tip'), most = Number(/ to (-?[\d.]+) mm/.exec(told)[1]);
  assert(most >= (worst.left_mm ?? worst.left) - 1e-3, `${told} where ${JSON.stringify(worst)}`);
  await shot(page, 'cut-report-place');
  await check_and_close(page);
});

test('the stock becomes less as time goes, and the tool stands where it was', async () => {
  const page = await open_file(page_of('good'), {viewport: kSmall});
  await set_time(page, 0);
  const raw = await count_of(page, kBrown);
  assert(raw > 300 && await count_of(page, kSteel) === 0, 'nothing is cut yet');
  await set_time(page, 5000);
  assert(await count_of(page, kBrown) < raw && await count_of(page, kSteel) > 100, 'half is cut');
  await shot(page, 'cut-report-stock');
  assert.match(await text_of(page, '#cut-moment'), /^0:0\d:\d\d of 0:\d\d:\d\d$/);
  // By keys to the end: the part with its colours again.
  await page.focus('#cut-time');
  await page.keyboard.press('End');
  assert.equal(await page.$eval('#cut-shown', (node) => node.value), 'deviation');
  // Played, it comes to its end by itself.
  await set_time(page, 9000);
  await page.select('#cut-time-speed', '3600');
  await page.locator('#cut-time-play').click();
  await page.waitForFunction(() => document.getElementById('cut-time').value === '10000');
  // The slider's marks stand under the middle of its thumb, at both ends, too.
  const [first, last] = await page.evaluate(() => {
    const marks = document.querySelector('.time-marks').getBoundingClientRect(), slider = document.getElementById('cut-time').getBoundingClientRect();
    return [marks.left - slider.left, slider.right - marks.right];
  });
  assert.deepEqual([first, last], [11, 11]);
  await check_and_close(page);
});

test('machine and fixtures move as the run went; the tool that they carry is where the report has it', async () => {
  const page = await open_file(page_of('good'), {viewport: kSmall});
  await set_time(page, 3000);
  // By the axes alone, through the machine's links, the tip is where the verification had it.
  const off = await page.evaluate(() => {
    const {data, machine} = window.tiltfeed_cut.drawing;
    let most = 0;
    for (let share = 0; share <= 1; share += 1 / 4000) {
      const tip = machine.tip(data.axes(share)), [x, y, z] = data.pose(share);
      most = Math.max(most, Math.hypot(tip.x - x, tip.y - y, tip.z - z));
    }
    return most;
  });
  assert(off < 5e-3, `${off} mm`);  // float32
  const bare = await seen(page);
  await page.select('#cut-machine', 'all');
  assert(differ(bare, await seen(page)) > 100, 'the machine is seen');
  // What is drawn goes with the slider: the head leans as the tool does.
  for (const time of [3000, 9000, 10000]) {
    await set_time(page, time);
    const apart = await page.evaluate((at) => {
      const {data, machine} = window.tiltfeed_cut.drawing, e = machine.group.getObjectByName('head').matrixWorld.elements;
      return Math.hypot(...data.pose(at / 10000).slice(3).map((x, i) => x - e[8 + i]));
    }, time);
    assert(apart < 1e-3, `at ${time} the head stands ${apart} off the tool's axis`);
  }
  await shot(page, 'cut-report-machine');
  await check_accessible(page);
  await check_and_close(page);
});

test('a gouge is red, the first of the worst places, and found by a click', async () => {
  const page = await open_file(page_of('bad'), {viewport: kSmall});
  const place = await text_of(page, '#cut-places li:first-child');
  assert.match(place, /^gouge: cutter0\.\d{4} mm deep, line/);
  await page.locator('#cut-places button').click();
  assert(await count_of(page, 'r > 110 && r > 2 * g && r > 2 * b') > 10, 'the gouge is in the view');
  const depth = Number(/([\d.]+) mm deep/.exec(place)[1]);
  assert(Math.abs(depth - bad.troubles[0].depth_mm) < 1e-3, `${place}: ${JSON.stringify(bad.troubles[0])}`);
  await shot(page, 'cut-report-gouge');
  await check_and_close(page);
});

test('its policy lets no other script run', async () => {
  const text = readFileSync(page_of('bad'), 'utf8');
  const other = join(folder, 'changed.html'), at = text.lastIndexOf('<script>') + 8;
  writeFileSync(other, text.slice(0, at) + ' ' + text.slice(at));
  const page = await open_file(other, {ready: false});
  await page.waitForFunction(() => window.violations.length > 0);
  assert.equal(await page.$('canvas'), null);
  assert.equal(await page.$eval('#picture', (node) => node.checkVisibility()), true, 'the picture is there without a script');
  assert.match((await page.evaluate(() => window.violations)).join(), /script-src/);
  await page.browserContext().close();
});

for (const [viewport, scheme] of [[kDesktop, 'dark'], [kTablet, 'dark'], [kPhone, 'light']]) {
  test(`the report at ${viewport.width} px, ${scheme}, is without barriers`, async () => {
    const page = await open_file(page_of('bad'), {viewport, scheme});
    if (viewport.hasTouch) await page.tap('#cut-places button');
    await check_accessible(page);
    await check_layout(page, viewport.hasTouch);
    await shot(page, `cut-report-${viewport.width}-${scheme}`);
    await check_and_close(page);
  });
}
