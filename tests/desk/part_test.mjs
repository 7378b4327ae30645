// Part: an STL is dropped, seen, told of, asked about. In a real browser.
import assert from 'node:assert/strict';
import {writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, before, test} from 'node:test';

import {
  Desk, check_accessible, check_and_close, check_layout, close_browser, drop, is_red, kPhone, kTablet, open_page,
  part_file, shot, text_of, work,
} from './harness.mjs';

let desk;
before(async () => { desk = await Desk.start(); });
after(async () => {
  await close_browser();
  assert.equal(await desk.stop(), 0);
});

const kGround = '233,237,241';  // of the view in the light scheme

/** A cube of this edge as ASCII STL, some of its twelve facets left out. */
function cube(name, edge, without = []) {
  const corners = [...Array(8).keys()].map((i) => [i & 1, (i >> 1) & 1, (i >> 2) & 1].map((bit) => bit * edge));
  const facets = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]];
  const text = facets.filter((_, i) => !without.includes(i)).map((facet) =>
    `facet normal 0 0 0\nouter loop\n${facet.map((i) => `vertex ${corners[i].join(' ')}`).join('\n')}\nendloop\nendfacet\n`).join('');
  const file = join(work, name);
  writeFileSync(file, `solid cube\n${text}endsolid cube\n`);
  return file;
}

/** Until this file has been read and, where it is a part, drawn. */
async function shown(page, name) {
  await page.waitForFunction((wanted) => document.querySelector('#sheet h2')?.textContent === wanted &&
    !document.querySelector('.busy') && (document.querySelector('#canvas').dataset.part === wanted
      ? document.querySelector('#defects') : document.querySelector('[role=alert]')),
    {polling: 100}, name);  // a tab that is behind another has no animation frames
  await page.evaluate(() => window.tiltfeed.render());
}

/** The colours of the view along a grid of 225 points. */
const grid = (page) => page.evaluate(() => {
  const {clientWidth: width, clientHeight: height} = document.getElementById('canvas'), points = [];
  for (let x = 1; x < 16; ++x)
    for (let y = 1; y < 16; ++y) points.push([width * x / 16, height * y / 16]);
  return window.tiltfeed.colours_at(points);
});

/** A pixel at this place of the part, or beside it, is red. */
const marked = async (page, place) => (await page.evaluate((at) => {
  const [x, y] = window.tiltfeed.project(...at), points = [];
  for (let i = -1; i <= 1; ++i)
    for (let j = -1; j <= 1; ++j) points.push([x + i, y + j]);
  return window.tiltfeed.colours_at(points);
}, place)).some(is_red);

test('before there is a part, the page says what to do', async () => {
  const page = await open_page(desk);
  assert.match(await text_of(page, '#hint'), /Drop an STL, OBJ, PLY, 3MF, STEP or IGES/);
  assert.match(await text_of(page, '#sheet'), /Open a part/);
  const all = new Set((await grid(page)).map(String));
  assert.equal(all.size, 1, 'the view is empty');
  await check_accessible(page);
  await check_and_close(page);
});

test('a part of 236,748 facets is dropped, measured and drawn', async () => {
  const page = await open_page(desk);
  await drop(page, await part_file('tyre'));
  await shown(page, 'tyre.stl');
  assert.equal(await text_of(page, '#facets'), '236,748');
  assert.equal(await text_of(page, '#size'), '280.5 x 147.4 x 98.38 mm');
  const drawn = (await grid(page)).filter((colour) => String(colour) !== kGround);
  assert(drawn.length > 60, `${drawn.length} of 225 places show the part`);
  console.log(`dropped to seen: ${await page.$eval('#sheet', (node) => node.dataset.seenAfterMs)} ms`);
  await shot(page, 'part-1920');
  await check_and_close(page);
});

test('open edges are counted and marked red where they are', async () => {
  const page = await open_page(desk);
  await drop(page, cube('open.stl', 20, [3]));
  await shown(page, 'open.stl');
  assert.match(await text_of(page, '#defects'), /3 edges are marked red/);
  assert.match(await text_of(page, '#defects'), /3 edges have one facet only/);
  // The facet left out is (20,0,20) (20,20,20) (0,20,20): its three edges are open, all others are not.
  for (const open of [[20, 10, 20], [10, 20, 20], [12, 8, 20]]) assert(await marked(page, open), `${open} is marked`);
  for (const sound of [[0, 0, 10], [10, 0, 20], [0, 0, 20]]) assert(!await marked(page, sound), `${sound} is not`);
  await check_accessible(page);
  await check_layout(page, false);
  await shot(page, 'defects-1920');
  await check_and_close(page);
});

test('a size that nobody means brings the question for the unit, and its answer the part', async () => {
  const page = await open_page(desk, {viewport: kTablet, scheme: 'dark'});
  await drop(page, cube('metres.stl', 0.08));
  await shown(page, 'metres.stl');
  assert.match(await text_of(page, '#unit-question'), /Is the file in mm\? Then the part is 0\.08 x 0\.08 x 0\.08 mm/);
  assert.deepEqual(await page.$$eval('#unit-question button', (all) => all.map((node) => node.textContent)), ['It is in m: 80 x 80 x 80 mm']);
  await check_accessible(page);
  await check_layout(page, true);
  await shot(page, 'unit-1024');
  await page.tap('#unit-m');
  await page.waitForFunction(() => document.getElementById('size')?.textContent === '80 x 80 x 80 mm');
  assert.equal(await page.$('#unit-question'), null);
  await check_and_close(page);
});

test('a file that is no STL is refused in words, and the next one is taken', async () => {
  const page = await open_page(desk, {viewport: kPhone});
  const wrong = join(work, 'notes.stl');
  writeFileSync(wrong, 'These are notes.\n');
  await drop(page, wrong);
  await shown(page, 'notes.stl');
  assert.match(await text_of(page, '[role=alert]'), /STL/);
  await drop(page, cube('cube.stl', 20));
  await shown(page, 'cube.stl');
  assert.match(await text_of(page, '#defects'), /closed, without defects/);
  await check_accessible(page);
  await check_layout(page, true);
  await shot(page, 'part-390');
  await check_and_close(page);
});

test('by keyboard alone: the view turns, zooms and fits; the file dialogue opens', async () => {
  const page = await open_page(desk);
  await drop(page, cube('cube.stl', 20));
  await shown(page, 'cube.stl');
  await page.focus('#canvas');
  const place = () => page.evaluate(() => window.tiltfeed.project(20, 0, 20));
  const before = await place();
  await page.keyboard.press('ArrowLeft');
  const turned = await place();
  assert.notDeepEqual(turned, before);
  await page.keyboard.press('ArrowRight');
  for (const [i, value] of (await place()).entries()) assert(Math.abs(value - before[i]) < 0.01);
  const edge = async () => {
    const [a, b] = await page.evaluate(() => [window.tiltfeed.project(0, 0, 0), window.tiltfeed.project(0, 0, 20)]);
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  const length = await edge();
  await page.keyboard.press('+');
  assert(Math.abs(await edge() / length - 1.2) < 1e-6);
  await page.keyboard.press('f');
  assert(Math.abs(await edge() / length - 1) < 1e-6);
  const chooser = page.waitForFileChooser();
  await page.focus('#open-stl');
  await page.keyboard.press('Enter');
  await (await chooser).accept([cube('second.stl', 30)]);
  await shown(page, 'second.stl');
  assert.equal(await text_of(page, '#size'), '30 x 30 x 30 mm');
  await check_and_close(page);
});

test('dragging turns the part', async () => {
  const page = await open_page(desk);
  await drop(page, cube('cube.stl', 20));
  await shown(page, 'cube.stl');
  const box = await (await page.$('#canvas')).boundingBox(), x = box.x + box.width / 2, y = box.y + box.height / 2;
  const before = await page.evaluate(() => window.tiltfeed.project(20, 0, 20));
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 100, y, {steps: 5});
  await page.mouse.up();
  const turned = await page.evaluate(() => window.tiltfeed.project(20, 0, 20));
  assert(Math.hypot(turned[0] - before[0], turned[1] - before[1]) > 20);
  await check_and_close(page);
});

test('what one tab opens, all tabs of all browsers show; the address works once', async () => {
  const one = await open_page(desk), two = await open_page(desk);
  const third = await one.browserContext().newPage();
  await third.goto(desk.origin);
  await third.waitForSelector('body[data-ready]');
  await drop(one, cube('shared.stl', 20));
  for (const page of [one, two, third]) await shown(page, 'shared.stl');
  const used = await desk.address();
  await two.goto(used);  // in a tab that is open: only the fragment changes
  await two.waitForFunction(() => location.hash === '' && document.body.dataset.ready);
  const stranger = await (await two.browser().createBrowserContext()).newPage();
  await stranger.goto(used);
  assert.match(await stranger.waitForSelector('#signed-out').then((node) => node.evaluate((n) => n.textContent)), /has been used/);
  await stranger.browserContext().close();
  await check_and_close(two);
  await check_and_close(one);
});
