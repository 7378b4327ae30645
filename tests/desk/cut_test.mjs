// Cut: the planned program on the simulated machine, followed, cancelled, shown, compared. In a real browser.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';

import {
  Desk, check_accessible, check_and_close, check_layout, close_browser, kPhone, kTablet, open_page, pin_job, run, shot, text_of, work,
} from './harness.mjs';

const kSmall = {width: 1200, height: 900};
let desk, job;
before(async () => {
  job = await pin_job('cut_job.yaml', 1);
  desk = await Desk.start(job);
});
after(async () => {
  await close_browser();
  assert.equal(await desk.stop(), 0);
});

const open_tab = async (page, tab) => {
  await page.waitForFunction(() => document.querySelector('#facets, #cut, #plan, #cut-cancel, #job-text, #tab-job'));
  await page.locator(`#tab-${tab}`).click();
};
/** How many of the view's places have such a colour. */
const count_of = (page, colour) => page.evaluate((body) => {
  const is = new Function('r', 'g', 'b', `return ${body}`), {clientWidth: width, clientHeight: height} = document.getElementById('canvas'), points = [];
  for (let x = 0; x < 80; ++x)
    for (let y = 0; y < 60; ++y) points.push([width * (x + 0.5) / 80, height * (y + 0.5) / 60]);
  return window.tiltfeed.colours_at(points).filter(([r, g, b]) => is(r, g, b)).length;
}, colour);

/** Plans and cuts, and waits for the verdict. */
async function plan_and_cut(page) {
  await open_tab(page, 'plan');
  const planned = await page.evaluate(() => fetch('/api/v1/state').then((reply) => reply.json()).then(({plan}) => plan?.id ?? 0));
  await page.locator('#plan').click();
  await page.waitForFunction((id) => fetch('/api/v1/state').then((reply) => reply.json()).then(({plan}) => plan?.id > id && plan.state !== 'planning'), {polling: 200}, planned);
  await page.waitForSelector('#blocks');
  await open_tab(page, 'cut');
  await page.locator('#cut').click();
  await page.waitForSelector('#cut-cancel');
  await page.waitForSelector('#cut-verdict, #cut-refused');
}

test('a plan is cut, and shown as by the command line; a second run is compared with it', async () => {
  const page = await open_page(desk, {viewport: kSmall});
  await page.waitForSelector('#facets');
  await open_tab(page, 'cut');
  assert.equal(await page.$eval('#cut', (node) => node.disabled), true, 'nothing is planned');
  await plan_and_cut(page);
  assert.equal(await page.$('#cut-refused'), null);
  // The same by the command line.
  const program = join(work, 'cut_by_hand.nc'), folder = join(work, 'cut_by_hand');
  assert.equal((await run('tiltfeed', 'plan', job, '--out', program, '--no-proof')).status, 0);
  const status = (await run('tiltfeed', 'verify', job, program, '--out', folder)).status;
  const report = JSON.parse(readFileSync(join(folder, 'report.json'), 'utf8'));
  assert.match(await text_of(page, '#cut-verdict'), {0: /^Passed/, 1: /^Failed/, 3: /^Incomplete/}[status]);
  assert.match(await text_of(page, '#cut-facts'), new RegExp(report.gouge_mm.toFixed(4)));
  const kGreen = 'g > r + 25 && g > b + 15';
  assert(await count_of(page, kGreen) > 100, 'finished surface is green');
  await check_accessible(page);
  await check_layout(page, false);
  await shot(page, 'cut-1200');
  assert.equal(await page.evaluate(async () => (await (await fetch(document.getElementById('cut-page').href)).text()).includes('report-viewer')), true);
  assert.equal(await page.$('#cut-shown option[value=difference]'), null, 'nothing to compare with yet');
  // Wider rows leave more: red where the difference is shown.
  await open_tab(page, 'job');
  await page.evaluate(() => {
    const area = document.getElementById('job-text');
    area.value = area.value.replace(/side_step_mm: [\d.]+/, 'side_step_mm: 2');
    area.dispatchEvent(new Event('input'));
  });
  await page.waitForFunction(() => !document.getElementById('job-save').disabled);
  await plan_and_cut(page);
  await page.select('#cut-shown', 'difference');
  assert(await count_of(page, 'r > g + 10 && r > b + 10') > 100, 'more is left');
  await shot(page, 'cut-difference');
  // Elsewhere the legend is gone.
  await open_tab(page, 'part');
  assert.equal(await page.$eval('#legend', (node) => node.hidden), true);
  await check_and_close(page);
});

for (const [viewport, scheme] of [[kTablet, 'dark'], [kPhone, 'light']]) {
  test(`the cut at ${viewport.width} px, ${scheme}, is without barriers`, async () => {
    const page = await open_page(desk, {viewport, scheme});
    await page.waitForSelector('#facets');
    await page.tap('#tab-cut');
    await page.waitForSelector('#cut-verdict');
    await check_accessible(page);
    await check_layout(page, true);
    await shot(page, `cut-${viewport.width}`);
    await check_and_close(page);
  });
}
