// Run: a run on the simulated machine watched, held by key, resumed, stopped by a press; one seat; whatever ends, it goes on;
// part and path in the view, wherever they were planned, and the facet where an alarm came.
import assert from 'node:assert/strict';
import {spawn} from 'node:child_process';
import {readFileSync, rmSync, mkdirSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {createInterface} from 'node:readline';
import {after, before, test} from 'node:test';

import {
  Desk, at_rest, bin, check_accessible, check_and_close, check_layout, click, close_browser, is_red, kPhone, kTablet, open_browser, open_page, part_file, pin_job, run, shot, tab_to, text_of, wait_until, work,
} from './harness.mjs';

const root = new URL('../..', import.meta.url).pathname, shop = join(work, 'shop'), socket = join(shop, 'api.sock');
const kFeeds = 40000;  // of 0.1 s: more than any test waits for
const started = [];

/** A program that goes on and starts when it says so. */
function start(name, words, ready) {
  const child = spawn(join(bin, name), words, {stdio: ['ignore', 'pipe', 'pipe']});
  started.push(child);
  child.stderr.resume();
  return new Promise((done, failed) => {
    child.on('error', failed);
    createInterface({input: child.stdout}).on('line', (line) => { if (ready(line)) done([child, line]); });
    if (!ready('')) return;
    done([child, '']);
  });
}

const tiltfeed = async (...words) => {
  const {status, out} = await run('tiltfeed', ...words, '--socket', socket, '--json');
  return {status, answer: out.startsWith('{') ? JSON.parse(out) : null};
};
const state_of = async (job) => (await tiltfeed('show', String(job))).answer;

let desk, service, job;

async function serve() {
  [service] = await start('tiltfeed', ['serve', '--config', join(shop, 'service.yaml')], () => true);
  while ((await tiltfeed('list')).status !== 0);
}

before(async () => {
  rmSync(shop, {recursive: true, force: true});
  mkdirSync(shop, {recursive: true});
  const [, line] = await start('tiltfeed-sim', ['--grbl-tcp', '127.0.0.1:0', '--speed', '2', '--probe-plate', '-20', '--job', join(root, 'config/jobs/sphere.yaml')], (text) => text.startsWith('ready on '));
  const feeds = Array.from({length: kFeeds}, (_, i) => `G1 X${10 * (i % 2)} Y${(i % 50) / 5} Z${60 + (i % 7)} A0 C${(i / 4) % 3000} F600`);
  writeFileSync(join(shop, 'long.nc'), ['G21 G90 G94', 'G0 X0 Y0 Z60 A0 C0', 'M3 S8000', 'G93', ...feeds, 'G94', 'M5', 'M2', ''].join('\n'));
  writeFileSync(join(shop, 'turns.nc'), ['G21 G90 G94', '(TILTFEED tool length 80.0000 mm is in the words)', 'G0 X0 Y0 A0 C0', 'G53 G0 Z0', 'T3 M6 (ball)',
    'M3 S8000', 'G1 X10 F3000', 'G1 X0', 'M5', 'M2', ''].join('\n'));
  writeFileSync(join(shop, 'service.yaml'), `machine: ${root}/config/machines/generic-ac.yaml\nlink: grbl-tcp:${line.split(' ')[2]}\nspool: spool\nsocket: api.sock\n`);
  await serve();
  job = (await tiltfeed('submit', join(shop, 'long.nc'))).answer.job;
  desk = await Desk.start('--service', socket);
});
after(async () => {
  await close_browser();
  if (desk) assert.equal(await desk.stop(), 0);
  for (const child of started.reverse()) child.kill('SIGKILL');
});

/** Until the head of the page says so; in tabs behind others, too, which draw no frames. */
const says = (page, doing) => page.waitForFunction((wanted) => document.getElementById('machine-state')?.dataset.doing === wanted, {polling: 'mutation'}, doing);
const executed = (page) => page.$eval('#run-figures', (node) => Number(node.textContent.replaceAll(',', '').split(' ')[0]));
const goes_on = async (page) => {
  const before = await executed(page);
  await page.waitForFunction((count) => Number(document.getElementById('run-figures').textContent.replaceAll(',', '').split(' ')[0]) > count + 3, {}, before);
};
const take_seat = async (page) => {
  await page.locator('#tab-run').click();
  await page.waitForSelector('#seat-ask').then((button) => button.click());
  await page.waitForSelector('#seat-give');
};
const leave_seat = async (page) => {
  await click(page, '#seat-give');
  await page.waitForFunction(() => /Nobody has the seat/.test(document.getElementById('seat')?.textContent));
};
/** As a thumb does: down, and up when `until` has come. */
async function press(page, selector, until) {
  const box = await at_rest(page, selector);
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await until();
  await page.mouse.up();
}

test('a job is started, watched, held by key, resumed, and stopped by a press of a second', async () => {
  const page = await open_page(desk);
  await says(page, 'idle');
  await page.waitForSelector('#places tbody tr');
  assert.match(await text_of(page, '#seat'), /Nobody has the seat/);
  assert.equal(await page.$eval(`#start-${job}`, (node) => node.disabled), true, 'without the seat');
  await shot(page, 'run-idle-1920');
  await take_seat(page);
  await page.waitForSelector(`#start-${job}:not(:disabled)`).then((button) => button.click());
  await says(page, 'running');
  await goes_on(page);
  const now = await text_of(page, '#line-now');
  assert.equal(now.trim().replace(/^\d+ +/, ''), readFileSync(join(shop, 'long.nc'), 'utf8').split('\n')[Number(now.trim().split(' ')[0]) - 1]);
  await check_accessible(page);
  await check_layout(page, false);
  await shot(page, 'run-1920');
  const began = Date.now();
  await page.focus('#override-feed + button');
  await page.keyboard.press('Space');
  await says(page, 'held');
  console.log(`hold by key, until the page shows it: ${Date.now() - began} ms`);
  assert.equal((await state_of(job)).phase, 'hold');
  await shot(page, 'run-held-1920');
  await page.locator('#resume').click();
  await says(page, 'running');
  await goes_on(page);
  await page.locator('#stop').click();  // a click is no press
  assert.equal((await state_of(job)).phase, 'run');
  await page.keyboard.press('!');
  await says(page, 'held');
  await page.keyboard.press('~');
  await says(page, 'running');
  await page.locator('#overrides [aria-label="feed by -10 percent"]').click();
  await page.waitForFunction(() => document.getElementById('override-feed').textContent === '90 %');
  await press(page, '#stop', () => says(page, 'idle'));
  assert.equal((await state_of(job)).state, 'stopped');
  await page.waitForFunction((id) => /stopped/.test(document.getElementById(id)?.textContent), {}, `job-${job}`);
  await leave_seat(page);
  await check_and_close(page);
});

test('by keyboard alone: the seat taken, a job started, held, resumed, stopped, the seat left', async () => {
  const page = await open_page(desk), number = (await tiltfeed('submit', join(shop, 'long.nc'))).answer.job;
  const press = async (selector) => {
    await tab_to(page, selector);
    await page.keyboard.press('Enter');
  };
  await press('#seat-ask');
  await press(`#start-${number}`);
  await says(page, 'running');
  await page.keyboard.press('Space');
  await says(page, 'held');
  await press('#resume');
  await says(page, 'running');
  await press('#overrides [aria-label="feed by -10 percent"]');
  await page.waitForFunction(() => document.getElementById('override-feed').textContent === '90 %');
  await tab_to(page, '#stop');
  await page.keyboard.down('Enter');
  await says(page, 'idle');
  await page.keyboard.up('Enter');
  assert.equal((await state_of(number)).state, 'stopped');
  await press('#seat-give');
  await page.waitForFunction(() => /Nobody has the seat/.test(document.getElementById('seat')?.textContent));
  await check_and_close(page);
});

const again = async () => {
  const number = (await tiltfeed('submit', join(shop, 'long.nc'))).answer.job;
  while ((await state_of(number)).state !== 'ready');
  assert.equal((await tiltfeed('start', String(number))).status, 0);
  return number;
};

test('it goes on whatever ends: a page reloaded in a hold, a page killed, the desk killed; a lost service is told', async () => {
  const number = await again(), page = await open_page(desk);
  await take_seat(page);
  await says(page, 'running');
  await page.keyboard.press('!');
  await says(page, 'held');
  await page.reload();
  await page.waitForSelector('body[data-ready]');
  await says(page, 'held');
  await page.locator('#tab-run').click();
  await page.waitForSelector('#resume:not(:disabled)').then((button) => button.click());
  await says(page, 'running');
  const at = (await state_of(number)).executed;
  const other = await open_page(desk);
  const crashed = new Promise((done) => page.once('error', done)), session = await page.createCDPSession();
  session.send('Page.crash').catch(() => undefined);  // it never answers
  await crashed;
  await says(other, 'running');
  await other.locator('#tab-run').click();
  await other.waitForFunction(() => /is lost/.test(document.getElementById('seat')?.textContent));
  assert((await state_of(number)).executed > at);
  await shot(other, 'run-seat-lost-1920');
  const origin = desk.origin;
  desk.child.kill('SIGKILL');
  await other.waitForFunction(() => document.getElementById('link').classList.contains('lost'));
  assert.match(await text_of(other, '#link'), /does not answer/);
  await shot(other, 'run-desk-lost-1920');
  other.faults.length = 0;
  await other.browserContext().close();
  assert.equal((await state_of(number)).phase, 'run', origin);
  desk = await Desk.start('--service', socket);
  const last = await open_page(desk);
  await take_seat(last);
  await says(last, 'running');
  await press(last, '#stop', () => says(last, 'idle'));
  service.kill('SIGKILL');
  await says(last, 'lost');
  assert.match(await text_of(last, '#run-state'), /service does not answer/);
  await shot(last, 'run-service-lost-1920');
  await serve();
  await says(last, 'idle');
  await leave_seat(last);
  await check_and_close(last);
});

test('two browsers, one seat: the other watches, holds, asks, is given it', async () => {
  const number = await again(), one = await open_page(desk, {viewport: kTablet, scheme: 'dark'}), two = await open_page(desk, {viewport: kPhone});
  await one.locator('#tab-run').click();
  await one.waitForSelector('#seat-ask').then((button) => button.tap());
  await two.tap('#tab-run');
  await two.waitForFunction(() => /has the seat; you watch/.test(document.getElementById('seat')?.textContent));
  for (const id of ['resume', 'stop']) assert.equal(await two.$eval(`#${id}`, (node) => node.disabled), true, id);
  await says(one, 'running');
  await two.tap('#hold');
  for (const page of [one, two]) await says(page, 'held');
  await two.tap('#seat-ask');
  await one.waitForFunction(() => /asks for the seat/.test(document.getElementById('seat')?.textContent));
  for (const page of [one, two]) {
    await check_accessible(page);
    await check_layout(page, true);
  }
  await shot(one, 'run-1024-dark');
  await shot(two, 'run-390');
  await one.tap('#seat-give');
  await two.waitForSelector('#resume:not(:disabled)').then((button) => button.tap());
  for (const page of [one, two]) await says(page, 'running');
  assert.equal(await one.$eval('#stop', (node) => node.disabled), true);
  await press(two, '#stop', () => says(two, 'idle'));
  assert.equal((await state_of(number)).state, 'stopped');
  await check_and_close(one);
  await leave_seat(two);
  await check_and_close(two);
});

test('a jog goes as long as the button is held, by mouse and by key', async () => {
  const page = await open_page(desk);
  await take_seat(page);
  const x = () => page.$eval('#place-X', (node) => Number(node.textContent));
  await page.waitForSelector('#place-X');
  await page.evaluate(() => { for (const fold of document.querySelectorAll('#sheet details')) fold.open = true; });
  await check_accessible(page);
  await check_layout(page, false);
  const before = await x();
  await press(page, '#jog-Xplus', () => says(page, 'command'));
  await says(page, 'idle');
  await page.waitForFunction((place) => Number(document.getElementById('place-X').textContent) > place, {}, before);
  const right = await x();
  await page.focus('#jog-Xminus');
  await page.keyboard.down('Enter');
  await says(page, 'command');
  await page.keyboard.up('Enter');
  await says(page, 'idle');
  await page.waitForFunction((place) => Number(document.getElementById('place-X').textContent) < place, {}, right);
  await shot(page, 'machine-1920');
  await leave_seat(page);
  await check_and_close(page);
});

test('a tool change is led through: a wrong length refused, the right one measured, the way back shown, then on', async () => {
  const number = (await tiltfeed('submit', join(shop, 'turns.nc'))).answer.job, page = await open_page(desk), other = await open_page(desk, {viewport: kPhone, scheme: 'dark'});
  await take_seat(page);
  await page.waitForSelector(`#start-${number}:not(:disabled)`).then((button) => button.click());
  for (const one of [page, other]) await says(one, 'changing');
  assert.equal(await text_of(page, '#tool-title'), 'Tool change: T3 (ball)');
  assert.match(await text_of(page, '#tool-where'), /before line 5/);
  assert.match(await text_of(page, '#tool-parked'), /parked/);
  assert.match(await text_of(page, '#tool-wanted'), /for 80 mm/);
  await other.tap('#tab-run');
  await other.waitForSelector('#tool-change');
  for (const id of ['tool-take', 'tool-probe', 'tool-way', 'tool-stop']) assert.equal(await other.$eval(`#${id}`, (node) => node.disabled), true, id);
  await page.waitForSelector('#tool-take:not(:disabled)');
  assert.equal(await page.$eval('#tool-way', (node) => node.disabled), true, 'before the length is known');
  await page.type('#tool-length', '81,5');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => /1.5 mm longer/.test(document.getElementById('tool-problem').textContent));
  assert.equal(await page.$eval('#tool-way', (node) => node.disabled), true, 'after one that is refused');
  await wait_until(() => page.faults.length > 0);
  assert.match(page.faults.pop(), /409/);
  await page.locator('#tool-change summary').click();
  await page.type('#tool-setter', '-100');
  await page.$eval('#tool-feed', (node) => { node.value = '3000'; });
  await page.locator('#tool-probe').click();
  await page.waitForSelector('#tool-way:not(:disabled)');
  assert.match(await text_of(page, '#tool-said'), /length=80/);
  assert.equal((await state_of(number)).length, 80);
  await page.locator('#tool-way').click();
  await page.waitForFunction(() => /X0/.test(document.getElementById('tool-preview').textContent));
  await check_accessible(page);
  await check_layout(page, false);
  await shot(page, 'tool-change-1920');
  await other.waitForFunction(() => /Mounted: 80 mm/.test(document.getElementById('tool-wanted').textContent));
  await check_accessible(other);
  await check_layout(other, true);
  await shot(other, 'tool-change-390-dark');
  await page.locator('#tool-go').click();  // a click is no press
  assert.equal((await state_of(number)).state, 'tool change');
  await press(page, '#tool-go', () => page.waitForFunction((id) => /executed to its end/.test(document.getElementById(id)?.textContent), {}, `job-${number}`));
  assert.equal((await state_of(number)).state, 'done');
  await page.waitForFunction(() => document.getElementById('tool-change').hidden);
  await check_and_close(other);
  await leave_seat(page);
  await check_and_close(page);
});

/** A machine of its own that goes into an alarm in the middle of a path, its service, and a desk beside it. */
async function alarming() {
  const folder = join(work, 'alarm'), machine = join(root, 'config/machines/generic-ac.yaml');
  rmSync(folder, {recursive: true, force: true});
  mkdirSync(folder, {recursive: true});
  writeFileSync(join(folder, 'faults'), 'alarm at=20\n');
  const [, line] = await start('tiltfeed-sim', ['--grbl-tcp', '127.0.0.1:0', '--speed', '4', '--faults', join(folder, 'faults'), '--job', join(root, 'config/jobs/sphere.yaml')], (text) => text.startsWith('ready on '));
  const config = join(folder, 'service.yaml'), at = ['--socket', join(folder, 'api.sock'), '--json'];
  writeFileSync(config, `machine: ${machine}\nlink: grbl-tcp:${line.split(' ')[2]}\nspool: spool\nsocket: api.sock\n`);
  await start('tiltfeed', ['serve', '--config', config], () => true);
  while ((await run('tiltfeed', 'list', ...at)).status !== 0);
  const ask = async (...words) => JSON.parse((await run('tiltfeed', ...words, ...at)).out);
  return {desk: await Desk.start('--beside', config), ask};
}

test('a job from elsewhere stands in the view as its program makes it; where an alarm cuts it off, the facet is red', async () => {
  const {desk: beside, ask} = await alarming(), number = (await ask('submit', await pin_job('elsewhere.yaml', 1))).job;
  while ((await ask('show', String(number))).state !== 'ready');
  const page = await open_page(beside), other = await open_page(beside, {viewport: kPhone, scheme: 'dark'});
  await take_seat(page);
  await page.waitForSelector(`#start-${number}:not(:disabled)`).then((button) => button.click());
  await page.waitForFunction(() => window.tiltfeed.run.points > 0 && window.tiltfeed.run.facets > 0);
  await page.waitForFunction(() => window.tiltfeed.run.tool.group.visible);
  const seen = await page.evaluate(() => {
    const {run, part, path} = window.tiltfeed;
    return {facets: run.facets, part: part.visible, path: path.group.visible, run: run.group.visible};
  });
  assert.deepEqual(seen, {facets: (readFileSync(await part_file('pin')).length - 84) / 50, part: false, path: false, run: true});
  assert.equal(await page.$eval('#hint', (node) => node.checkVisibility()), false, 'nothing is to be dropped here');
  await page.evaluate(() => window.tiltfeed.render());
  await shot(page, 'run-elsewhere-1920');
  await page.waitForFunction(() => /^Cut off at line/.test(document.getElementById('run-scene').textContent));
  // The first block that is not known to be executed, as the service tells it.
  const told = await ask('show', String(number)), {origin} = await ask('show', String(number), '--block', String(told.executed + 1));
  assert(origin.line > 8, JSON.stringify(origin));
  const facet = await page.evaluate(() => window.tiltfeed.run.facet);
  assert.equal(facet, origin.facet ?? -1);
  assert((await text_of(page, '#run-scene')).startsWith(`Cut off at line ${origin.line}: ${origin.text}`));
  if (facet >= 0) {
    await page.locator('#run-place').click();
    const [at] = await page.evaluate(() => {
      const {run} = window.tiltfeed, {x, y, z} = run.middle(run.facet);
      return window.tiltfeed.colours_at([window.tiltfeed.project(x, y, z)]);
    });
    assert(is_red(at), `the facet's colour is ${at}`);
  }
  await check_accessible(page);
  await check_layout(page, false);
  await shot(page, 'run-alarm-1920');
  await page.reload();
  await page.waitForSelector('body[data-ready]');
  await page.locator('#tab-run').click();
  await page.waitForFunction((lit) => window.tiltfeed.run.facet === lit, {}, facet);
  await other.tap('#tab-run');
  await other.waitForFunction((lit) => window.tiltfeed.run.facet === lit, {}, facet);
  assert.equal(await other.evaluate(() => window.tiltfeed.run.group.visible), true, 'also where the tab was shown before');
  await check_layout(other, true);
  await other.evaluate(() => window.tiltfeed.render());
  await shot(other, 'run-alarm-390-dark');
  await leave_seat(page);
  await check_and_close(page);
  await check_and_close(other);
  assert.equal(await beside.stop(), 0);
});

test('twenty tabs of one browser: one stream, all told', async () => {
  const page = await open_page(desk), tabs = [page];
  while (tabs.length < 20) {
    const tab = await page.browserContext().newPage();
    await tab.goto(desk.origin);
    tabs.push(tab);
  }
  for (const tab of tabs) await tab.waitForSelector('body[data-ready]');
  const number = await again();
  for (const tab of tabs) await says(tab, 'running');
  assert.equal((await tiltfeed('stop', String(number))).status, 0);
  for (const tab of tabs) await says(tab, 'idle');
  await tabs[0].close();  // perhaps the one that listened
  tabs.shift();
  const last = await again();
  for (const tab of tabs) await says(tab, 'running');
  assert.equal((await tiltfeed('stop', String(last))).status, 0);
  for (const tab of tabs) await says(tab, 'idle');
  await tabs[0].browserContext().close();
  assert.deepEqual(page.faults, []);
});

test('where there are users, the page asks for name and password; who watches sees no order that works', async () => {
  const users = join(shop, 'users');
  await new Promise((done) => {
    const child = spawn(join(bin, 'tiltfeed'), ['desk', 'user', 'add', 'bob', '--role', 'watch', '--users', users], {stdio: ['pipe', 'ignore', 'inherit']});
    child.on('close', done);
    child.stdin.end('the secret of bob\n');
  });
  writeFileSync(join(shop, 'access.yaml'), 'listen: 127.0.0.1:0\nusers: users\n');
  const closed = await Desk.start('--service', socket, '--access', join(shop, 'access.yaml'));
  const context = await (await open_browser()).createBrowserContext(), page = await context.newPage();
  await page.goto(await closed.address());
  await page.waitForSelector('#user-name');
  await check_accessible(page);
  for (const [password, then] of [['not his secret', () => page.waitForFunction(() => /wrong/.test(document.getElementById('signed-out').textContent))],
    ['the secret of bob', () => page.waitForSelector('body[data-ready]')]]) {
    await page.$eval('#user-name', (node) => { node.value = ''; });
    await page.type('#user-name', 'bob');
    await page.$eval('#user-password', (node) => { node.value = ''; });
    await page.type('#user-password', password);
    await shot(page, 'sign-in-1920');
    await page.keyboard.press('Enter');
    await then();
  }
  await says(page, 'idle');
  await page.waitForSelector('#hold').then((button) => button.click());
  await page.waitForFunction(() => /watch only/.test(document.getElementById('run-problem')?.textContent));
  await context.close();
  assert.equal(await closed.stop(), 0);
});
