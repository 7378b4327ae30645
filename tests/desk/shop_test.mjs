// Shop: all machines as the database has them; one that is not heard is never called idle; the queue and its orders by mouse
// and by key; a database that stops is said, with the age of what stands there; the queue halted and let go on.
import assert from 'node:assert/strict';
import {spawn} from 'node:child_process';
import {createInterface} from 'node:readline';
import {after, before, test} from 'node:test';

import {Desk, bin, check_accessible, check_and_close, check_layout, click, close_browser, kDesktop, kPhone, kTablet, open_page, shot, tab_to, text_of, wait_until} from './harness.mjs';

const kStage = new URL('../system/shop_stage.py', import.meta.url).pathname;
let stage, lines, desk, absent = false;

const next_line = async () => (await lines.next()).value ?? '';
async function tell(text) {
  stage.stdin.write(`${text}\n`);
  const answer = await next_line();
  assert(answer.startsWith('ok'), `${text}: ${answer}`);
  return answer.length > 3 ? JSON.parse(answer.slice(3)) : null;
}

before(async () => {
  stage = spawn('/usr/bin/python3', [kStage, bin], {stdio: ['pipe', 'pipe', 'inherit']});
  lines = createInterface({input: stage.stdout})[Symbol.asyncIterator]();
  const url = await next_line();
  absent = !url.startsWith('postgresql://');
  if (absent) return;
  process.env.TILTFEED_SHOP = url;
  desk = await Desk.start('--shop');
});
after(async () => {
  await close_browser();
  if (desk) assert.equal(await desk.stop(), 0);
  stage.stdin.end();
});

/** The card of a machine: its state, and all that it says. */
const card = (page, name) => page.$$eval('.machine', (cards, wanted) => {
  const found = cards.find((one) => one.querySelector('.name').textContent === wanted);
  return {state: found?.querySelector('.state').textContent, text: found?.textContent ?? ''};
}, name);
const ready = (page) => page.waitForFunction(() => document.querySelectorAll('.machine').length >= 6 && document.querySelector('.usage .words'));
const job_text = (page, job) => text_of(page, `#shop-job-${job}`);
const job_says = (page, job, words) => page.waitForFunction((id, wanted) => document.getElementById(id)?.textContent.includes(wanted), {}, `shop-job-${job}`, words);

test('every machine says what is known of it', async (t) => {
  if (absent) return t.skip('PostgreSQL is not here');
  for (const [name, viewport, scheme] of [['desk', kDesktop, 'light'], ['tablet', kTablet, 'dark'], ['phone', kPhone, 'light']]) {
    const page = await open_page(desk, {viewport, scheme});
    await ready(page);
    assert.equal(await page.$eval('[role=tab][aria-selected=true]', (node) => node.textContent), 'Shop');
    const north = await card(page, 'ac5 north');
    assert.equal(north.state, 'Running');
    assert.match(north.text, /seat rail, 31,200 of 48,000 blocks/);
    assert.match(north.text, /left/);
    assert.equal((await card(page, 'generic-ac')).state, 'Idle');
    const fault = await card(page, 'mill-3x');
    assert.equal(fault.state, 'Fault');
    assert.match(fault.text, /blocks 400 to 417 may have run/);
    const silent = await card(page, 'trunnion');
    assert.equal(silent.state, 'Not heard');
    assert.match(silent.text, /heard 2\d min ago/);
    assert.match(silent.text, /It was running with mould half when it was heard last\. What it does now is not known here: it may be moving\./);
    assert.equal((await card(page, 'fork head')).state, 'Service ended');
    assert.match(await text_of(page, '#shop-summary'), /6 machines: 1 fault, 1 running, 1 held, 1 idle, 1 not heard, 1 service ended\. 2 jobs wait for a machine, 1 of them fit none\./);
    assert.match(await text_of(page, '#shop-plans'), /mould core for ac5 north: planned by generic-ac, 40 % \(links\)seat rail 2 for ac5 north: waits for an idle machine/);
    await shot(page, `shop-${name}-${scheme}`);
    await check_layout(page, viewport.hasTouch ?? false);
    await check_accessible(page);
    await check_and_close(page);
  }
});

test('the usage of a day and a week adds up, and says what nobody knows', async (t) => {
  if (absent) return t.skip('PostgreSQL is not here');
  const page = await open_page(desk);
  await ready(page);
  const words = await page.$$eval('.machine .usage .words', (nodes) => nodes.map((node) => node.textContent));
  for (const text of words) {
    const sum = [...text.matchAll(/(\d+) %/g)].reduce((all, [, percent]) => all + Number(percent), 0);
    assert(Math.abs(sum - 100) <= 3, text);
  }
  const [day, week] = await page.$$eval('.machine', (cards) => [...cards.find((one) => one.querySelector('.name').textContent === 'ac5 north').querySelectorAll('.words')].map((node) => node.textContent));
  // Running 0.4 of each day, held 0.02, idle the rest; of the week 6.5 days are told; a fault of 0.36 of a day.
  assert.match(day, /running 40 %, held 2 %, idle 58 %/);
  assert.match(week, /not known 7 %/);
  assert.match(week, /fault 5 %/);
  await check_and_close(page);
});

test('the list is narrowed by state and by name', async (t) => {
  if (absent) return t.skip('PostgreSQL is not here');
  const page = await open_page(desk);
  await ready(page);
  await page.select('#shop-pick', 'fault');
  await page.waitForFunction(() => document.querySelectorAll('.machine').length === 1);
  assert.equal((await card(page, 'mill-3x')).state, 'Fault');
  await page.select('#shop-pick', 'all');
  await page.type('#shop-find', 'seat');
  await page.waitForFunction(() => document.querySelectorAll('.machine').length === 1);
  assert.equal((await card(page, 'ac5 north')).state, 'Running');
  await page.type('#shop-find', ' nothing like that');
  await page.waitForFunction(() => /No machine is like that/.test(document.getElementById('shop-none').textContent));
  await check_and_close(page);
});

test('jobs say why no machine fits, and are offered again and withdrawn by a word', async (t) => {
  if (absent) return t.skip('PostgreSQL is not here');
  const page = await open_page(desk, {viewport: kPhone});
  await ready(page);
  assert.match(await job_text(page, 2), /No machine fits: .*ac5 north: .*profile/);
  assert.equal(await page.$('#withdraw-3'), null, 'a job that runs is its machine\'s');
  assert.equal(await page.$('#release-6'), null, 'what is uncertain is never offered again');
  // By keys alone: the question has the focus, and says where to look first.
  await tab_to(page, '#withdraw-5');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#shop-confirm:not([hidden])');
  assert.match(await text_of(page, '#shop-confirm'), /It is ready at generic-ac.*Look there first/);
  await shot(page, 'shop-confirm-phone');
  await page.keyboard.press('Enter');  // the focus is on what changes nothing
  await page.waitForSelector('#shop-confirm', {hidden: true});
  assert.equal((await tell('sql SELECT state FROM tiltfeed.jobs WHERE number = 5'))[0][0], 'ready');
  await click(page, '#withdraw-5');
  await page.waitForSelector('#shop-confirm:not([hidden])');
  await click(page, '#shop-yes');
  await page.waitForFunction(() => /job 5 of the shop is withdrawn/.test(document.getElementById('shop-note').textContent));
  await job_says(page, 5, 'withdrawn');
  assert.equal((await tell('sql SELECT state FROM tiltfeed.jobs WHERE number = 5'))[0][0], 'withdrawn');
  await click(page, '#release-7');
  await click(page, '#shop-yes');
  await job_says(page, 7, 'open');
  // What has begun meanwhile is refused in the queue's own words.
  await tell("sql UPDATE tiltfeed.jobs SET state = 'running', machine = (SELECT id FROM tiltfeed.machines WHERE name = 'generic-ac') WHERE number = 1");
  await click(page, '#withdraw-1');
  await click(page, '#shop-yes');
  await page.waitForFunction(() => /it has begun/.test(document.getElementById('shop-problem').textContent));
  await wait_until(() => page.faults.length > 0);
  assert.match(page.faults.pop(), /409/);
  await check_accessible(page);
  await check_and_close(page);
});

test('a database that is gone is said, and nothing is called idle', async (t) => {
  if (absent) return t.skip('PostgreSQL is not here');
  const page = await open_page(desk);
  await ready(page);
  await tell('stop');
  await page.waitForSelector('#shop-trouble:not([hidden])');
  assert.match(await text_of(page, '#shop-trouble'), /does not answer: .*All below is of .* ago: what the machines do now is not known here\. Each machine works on by itself\./);
  await page.waitForFunction(() => [...document.querySelectorAll('.machine .state')].every((node) => /Not heard|Service ended/.test(node.textContent)));
  await shot(page, 'shop-lost');
  await check_accessible(page);
  await tell('start');
  await page.waitForSelector('#shop-trouble', {hidden: true});
  await page.waitForFunction(() => [...document.querySelectorAll('.machine .state')].some((node) => node.textContent === 'Idle'));
  await check_and_close(page);
});

test('a halted queue says why, who has not been back, and goes on by a word', async (t) => {
  if (absent) return t.skip('PostgreSQL is not here');
  const page = await open_page(desk);
  await ready(page);
  await tell("sql UPDATE tiltfeed.shop SET halted = 'the database is behind what ac5 north has seen of it'");
  await tell("sql UPDATE tiltfeed.machines SET told = false WHERE name = 'ac5 south'");
  await page.waitForSelector('#shop-raise', {visible: true});
  await shot(page, 'shop-halted');
  await page.waitForFunction(() => [...document.querySelectorAll('.machine')].some((one) => /has not told its part/.test(one.textContent)));
  await click(page, '#shop-raise');
  await page.waitForSelector('#shop-confirm:not([hidden])');
  assert.match(await text_of(page, '#shop-confirm'), /Halted: the database is behind.*Not back yet: ac5 south/);
  await click(page, '#shop-yes');
  await page.waitForSelector('#shop-halted', {hidden: true});
  assert.deepEqual(await tell('sql SELECT epoch, halted FROM tiltfeed.shop'), [['2', '']]);
  await check_and_close(page);
});
