// What the browser tests share: a desk, a browser, pages that are watched.
import assert from 'node:assert/strict';
import {spawn} from 'node:child_process';
import {existsSync, mkdirSync, readFileSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {join} from 'node:path';
import {createInterface} from 'node:readline';
import {setTimeout as sleep} from 'node:timers/promises';

import puppeteer from 'puppeteer-core';

export const bin = process.env.TILTFEED_BIN;
export const work = process.env.TILTFEED_WORK;
assert(bin && work, 'TILTFEED_BIN (the programs) and TILTFEED_WORK (a folder for files) say where');
mkdirSync(work, {recursive: true});

export const kHang = Number(process.env.TILTFEED_HANG_MS ?? 120_000);  // ms: no measure of speed, only a hang reaches it

/** The program's end: {status, out}. */
export function run(program, ...words) {
  return new Promise((done, failed) => {
    const child = spawn(join(bin, program), words, {stdio: ['ignore', 'pipe', 'inherit']});
    let out = '';
    child.stdout.on('data', (text) => { out += text; });
    child.on('error', failed);
    child.on('close', (status) => done({status, out}));
  });
}

/** A part of tiltfeed-sim as an STL file, made once. */
export async function part_file(name) {
  const file = join(work, `${name}.stl`);
  if (!existsSync(file)) assert.equal((await run('tiltfeed-sim', 'part', name, '--out', file)).status, 0);
  return file;
}

/** A job for the pin of tiltfeed-sim with rows so far apart. */
export const pin_job = (name, side_step) => part_job('pin', name, side_step);

/** Likewise the job of another formula part. */
export async function part_job(part, name, side_step) {
  const machines = new URL('../../config/machines/', import.meta.url).pathname;
  const file = join(work, name), text = readFileSync(new URL(`../../config/jobs/${part}.yaml`, import.meta.url), 'utf8');
  const changed = text.replace(/stl: .*/, `stl: ${await part_file(part)}`).replace(/machine: \.\.\/machines\//, `machine: ${machines}`)
    .replace(/side_step_mm: [0-9.]+/, `side_step_mm: ${side_step}`);
  assert.notEqual(changed, text);
  writeFileSync(file, changed);
  return file;
}

/** Desks that run; one that a failed test left would keep the tests from ending. */
const started = new Set();

/** `tiltfeed desk WORDS...` */
export class Desk {
  static async start(...words) {
    const desk = new Desk();
    desk.child = spawn(join(bin, 'tiltfeed'), ['desk', ...words], {stdio: ['pipe', 'pipe', 'inherit']});
    started.add(desk.child);
    desk.child.on('close', () => started.delete(desk.child));
    desk.lines = createInterface({input: desk.child.stdout})[Symbol.asyncIterator]();
    desk.first = await desk.line();
    desk.origin = new URL(desk.first).origin;
    return desk;
  }

  async line() {
    const {value, done} = await this.lines.next();
    assert(!done, 'tiltfeed desk ended');
    return value;
  }

  /** An address that nobody has used. */
  async address() {
    if (this.first) {
      const address = this.first;
      this.first = null;
      return address;
    }
    this.child.stdin.write('\n');
    return this.line();
  }

  async stop(signal = 'SIGTERM') {
    const ended = new Promise((done) => this.child.on('close', done));
    this.child.kill(signal);
    return ended;
  }
}

let browser;
export async function open_browser() {
  browser ??= await puppeteer.launch({
    executablePath: '/usr/bin/chromium', protocolTimeout: kHang,
    args: ['--no-sandbox', '--enable-unsafe-swiftshader', '--use-angle=swiftshader', '--disable-background-networking',
      '--disable-component-update', '--no-first-run'],
  });
  return browser;
}
export const close_browser = async () => browser?.close();
export const stop_desks = () => { for (const child of started) child.kill('SIGTERM'); };

export const kDesktop = {width: 1920, height: 1080};
export const kTablet = {width: 1024, height: 768, hasTouch: true};
export const kPhone = {width: 390, height: 844, hasTouch: true, isMobile: true, deviceScaleFactor: 2};

/**
 * A page of its own context, signed in. What must never happen is collected in `faults`: a request off this machine, a
 * violation of the policy, an error in the console, an exception.
 */
export async function open_page(desk, looks = {}) {
  const page = await watched_page((url) => url.origin === desk.origin, looks);
  await page.goto(await desk.address());
  await page.waitForSelector('body[data-ready]');
  return page;
}

/** The same for a file of this computer, which may ask for nothing. `ready`: wait until it says so. */
export async function open_file(file, {ready = true, ...looks} = {}) {
  const page = await watched_page((url) => url.href === `file://${file}`, looks);
  await page.goto(`file://${file}`);
  if (ready) await page.waitForSelector('body[data-ready]');
  return page;
}

async function watched_page(allowed, {viewport = kDesktop, scheme = 'light'} = {}) {
  const context = await (await open_browser()).createBrowserContext();
  const page = await context.newPage();
  page.faults = [];
  page.setDefaultTimeout(kHang);
  await page.setViewport(viewport);
  await page.emulateMediaFeatures([{name: 'prefers-color-scheme', value: scheme}]);
  page.on('request', (request) => {
    const url = new URL(request.url());
    if (!allowed(url) && url.protocol !== 'data:') page.faults.push(`request to ${request.url()}`);
  });
  page.on('pageerror', (error) => page.faults.push(`exception: ${error.message}`));
  page.on('console', (message) => { if (message.type() === 'error') page.faults.push(`console: ${message.text()}`); });
  await page.evaluateOnNewDocument(() => {
    window.violations = [];
    document.addEventListener('securitypolicyviolation', (event) => window.violations.push(`${event.violatedDirective} ${event.blockedURI}`));
  });
  return page;
}

/** Nothing that must never happen has happened. */
export async function check_and_close(page) {
  const violations = await page.evaluate(() => window.violations);
  await page.browserContext().close();
  assert.deepEqual([...page.faults, ...violations], []);
}

/** The page as check_and_close() wants it, and its server ends well. */
export async function end({desk, page}) {
  await check_and_close(page);
  assert.equal(await desk.stop(), 0);
}

/** Types into the field with this id, as a person does, and leaves it. */
export async function type_field(page, id, value) {
  const field = `[id="${id}"]`;
  await page.waitForSelector(field);
  await page.$eval(field, (node) => { node.closest('details')?.setAttribute('open', ''); node.scrollIntoView({block: 'center'}); });
  await page.locator(field).click({count: 3});
  await page.keyboard.press('Backspace');
  await page.keyboard.type(value);
  await page.keyboard.press('Tab');
}

/** Serious complaints of axe-core: none. */
export async function check_accessible(page) {
  const source = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
  await page.evaluate(source);
  const found = await page.evaluate(() => axe.run(document, {resultTypes: ['violations']}));
  const serious = found.violations.filter(({impact}) => impact === 'serious' || impact === 'critical');
  assert.deepEqual(serious.map(({id, nodes}) => `${id}: ${nodes.map(({html, failureSummary}) => html + ' ' + failureSummary).join('; ')}`), []);
}

/** Nothing reaches over the sides of the window or of a legend, and what is touched is large enough for a thumb. */
export async function check_layout(page, touch) {
  const wrong = await page.evaluate((thumb) => {
    const wide = document.documentElement.scrollWidth > innerWidth ? ['the page scrolls sideways'] : [];
    const small = [...document.querySelectorAll('button, select, input:not([type=file])')].filter((node) => {
      const {width, height} = node.getBoundingClientRect();
      return node.checkVisibility() && thumb && (height < 36 || width < 36);
    }).map((node) => `small: ${node.outerHTML}`);
    const out = [...document.querySelectorAll('.legend *, .cut-over *')].filter((node) => {
      const {left, right} = node.getBoundingClientRect(), box = node.closest('.legend, .cut-over').getBoundingClientRect();
      return node.checkVisibility() && (left < box.left || right > box.right);
    }).map((node) => `out of its box: ${node.outerHTML}`);
    return [...wide, ...small, ...out];
  }, touch);
  assert.deepEqual(wrong, []);
}

/** Until it is so; for what no page can tell. */
export async function wait_until(is_so) {
  for (const begun = Date.now(); !await is_so(); await sleep(50)) assert(Date.now() - begun < kHang, `not so after ${kHang} ms: ${is_so}`);
}

/** The box of what is in the middle of the window, may be touched, and has stopped moving. */
export async function at_rest(page, selector) {
  const node = await page.waitForSelector(`${selector}:not(:disabled)`);
  await node.evaluate((it) => it.scrollIntoView({block: 'center'}));
  let box = null, before;
  do {
    before = box;
    await sleep(50);
    box = await node.boundingBox();
  } while (JSON.stringify(box) !== JSON.stringify(before));
  return box;
}

/** The colours of the view at 40 x 40 places, and at how many of them two such looks differ. */
export const seen = (page) => page.evaluate(() => {
  const {clientWidth: w, clientHeight: h} = document.getElementById('canvas'), points = [];
  for (let i = 0; i < 40; ++i) for (let k = 0; k < 40; ++k) points.push([w * (i + 0.5) / 40, h * (k + 0.5) / 40]);
  return window.tiltfeed.colours_at(points);
});
export const differ = (a, b) => a.filter((c, i) => c.some((x, k) => Math.abs(x - b[i][k]) > 8)).length;

/** Clicks what can be clicked. Found and clicked in one step: the page may draw it anew between two. */
export const click = (page, selector) => page.waitForFunction((wanted) => {
  const node = document.querySelector(`${wanted}:not(:disabled)`);
  node?.click();
  return node !== null;
}, {}, selector);

export const text_of = (page, selector) => page.$eval(selector, (node) => node.textContent);

const kMostTabs = 120;

/** Goes by Tab to what a selector names, as one does who has no mouse; returns how many it took. The focus must be seen. */
export async function tab_to(page, selector) {
  await page.waitForSelector(`${selector}:not(:disabled)`);
  const here = () => page.evaluate((wanted) => document.activeElement?.matches(wanted) ?? false, selector);
  for (let tabs = 0; tabs <= kMostTabs; ++tabs) {
    if (await here()) {
      const outline = await page.evaluate(() => getComputedStyle(document.activeElement).outlineStyle);
      assert.notEqual(outline, 'none', `${selector}: nobody sees that it has the focus`);
      return tabs;
    }
    await page.keyboard.press('Tab');
  }
  assert.fail(`${selector} is not reached by ${kMostTabs} tabs`);
}

/** Drops a file onto the page as a person does. */
export async function drop(page, file) {
  await page.evaluate(() => {
    const input = document.createElement('input');
    input.type = 'file';
    input.id = 'test-file';
    input.hidden = true;
    document.body.append(input);
  });
  const input = await page.$('#test-file');
  await input.uploadFile(file);
  await page.evaluate(() => {
    const taken = document.getElementById('test-file');
    const carried = new DataTransfer();
    carried.items.add(taken.files[0]);
    taken.remove();
    for (const kind of ['dragover', 'drop'])
      document.getElementById('viewer').dispatchEvent(new DragEvent(kind, {bubbles: true, cancelable: true, dataTransfer: carried}));
  });
}

/** Of a shot that a person looks at. */
export const shot = (page, name) => page.screenshot({path: join(work, `${name}.png`)});

/** Colours are told by class: which channel leads. */
export const is_red = ([r, g, b]) => r > 150 && r > 2 * g && r > 2 * b;
