// CAD files on the page: bodies and faces by name and colour, which are machined, which are not to be touched. In a real browser.
import assert from 'node:assert/strict';
import {existsSync, mkdirSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {after, test} from 'node:test';

import {
  Desk, bin, check_accessible, check_and_close, check_layout, click, close_browser, drop, kPhone, kTablet, open_page, run, shot, stop_desks, text_of, wait_until, work,
} from './harness.mjs';

after(async () => {
  stop_desks();
  await close_browser();
});

const state = (page) => page.evaluate(async () => (await fetch('/api/v1/state')).json());
const job_text = (page) => page.evaluate(async () => (await fetch('/api/v1/job/text')).text());
const part_ready = (page, facets) => wait_until(async () => {
  const {part} = await state(page);
  return part?.state === 'ready' && part.facets === facets;
});

/** A ZIP archive whose entries lie there as they are [APPNOTE 6.3.10]. */
function zip(entries) {
  const sum = (bytes) => {
    let crc = ~0;
    for (const byte of bytes) {
      crc ^= byte;
      for (let bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >>> 1 ^ 0xedb88320 : crc >>> 1;
    }
    return ~crc >>> 0;
  };
  const locals = [], directory = [];
  let at = 0;
  for (const [name, text] of entries) {
    const bytes = Buffer.from(text), common = Buffer.alloc(26);
    common.writeUInt16LE(20, 0);
    common.writeUInt32LE(sum(bytes), 10);
    common.writeUInt32LE(bytes.length, 14);
    common.writeUInt32LE(bytes.length, 18);
    common.writeUInt16LE(name.length, 22);
    const local = Buffer.concat([Buffer.from('PK\x03\x04'), common, Buffer.from(name), bytes]), rest = Buffer.alloc(14);
    rest.writeUInt32LE(at, 10);
    directory.push(Buffer.from('PK\x01\x02'), Buffer.from([20, 0]), common, rest, Buffer.from(name));
    locals.push(local);
    at += local.length;
  }
  const list = Buffer.concat(directory), end = Buffer.alloc(22);
  end.write('PK\x05\x06', 0, 'latin1');
  end.writeUInt16LE(entries.length, 8);
  end.writeUInt16LE(entries.length, 10);
  end.writeUInt32LE(list.length, 12);
  end.writeUInt32LE(at, 16);
  return Buffer.concat([...locals, list, end]);
}

/** Two blocks of 40 x 30 x 20 mm beside each other; the top of the first is red, of the material "seal". */
function two_blocks(name) {
  const corners = [...Array(8).keys()].map((i) => [40 * (i & 1), 30 * ((i >> 1) & 1), 20 * ((i >> 2) & 1)]);
  const facets = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]];
  const mesh = (red) => `<mesh><vertices>${corners.map(([x, y, z]) => `<vertex x="${x}" y="${y}" z="${z}"/>`).join('')}</vertices><triangles>${
    facets.map(([a, b, c], i) => `<triangle v1="${a}" v2="${b}" v3="${c}"${red && (i === 2 || i === 3) ? ' pid="9" p1="0"' : ''}/>`).join('')}</triangles></mesh>`;
  const model = `<?xml version="1.0"?><model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>
<basematerials id="9"><base name="seal" displaycolor="#FF0000"/></basematerials>
<object id="1" name="housing">${mesh(true)}</object><object id="2" name="lid">${mesh(false)}</object></resources>
<build><item objectid="1"/><item objectid="2" transform="1 0 0 0 1 0 0 0 1 60 0 0"/></build></model>`;
  const relations = '<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/part.model" Id="r0" ' +
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>';
  const file = join(work, name);
  writeFileSync(file, zip([['_rels/.rels', relations], ['3D/part.model', model]]));
  return file;
}

test('bodies and faces of a 3MF are listed; the job takes what is ticked, and is planned', async () => {
  const desk = await Desk.start(), page = await open_page(desk), file = two_blocks('blocks.3mf');
  await drop(page, file);
  await part_ready(page, 24);
  await page.waitForSelector('#part-bodies');
  assert.match(await text_of(page, '#file-format'), /^3MF, 2 bodies/);
  assert.match(await text_of(page, '#file-unit'), /millimeter, as the file says/);
  assert.equal(await page.$('#unit'), null, 'nobody is asked for the unit');
  assert.match(await text_of(page, '#part-bodies'), /housing.*lid/);
  assert.equal(await page.$eval('#body-0', (node) => node.disabled), true, 'there is no job to say it');
  await page.waitForSelector('#make-job:not([disabled])');
  await page.locator('#make-job').click();
  await page.waitForFunction(async () => (await (await fetch('/api/v1/state')).json()).job !== null);
  await page.locator('#tab-part').click();
  // One body: the part is drawn without the other, and so are size and facets.
  await click(page, '#body-1');
  await part_ready(page, 12);
  await page.waitForFunction(() => document.getElementById('size')?.textContent === '40 x 30 x 20 mm');
  assert.match(await job_text(page), /bodies: \["housing"\]/);
  assert.deepEqual(await page.$$eval('#part-bodies input', (nodes) => nodes.map((node) => node.checked)), [true, false]);
  // Faces by their colour; what is ticked is lit.
  const row = await page.$$eval('#part-faces [data-word]', (nodes) => nodes.map((node) => [node.dataset.word, node.textContent]));
  const red = row.findIndex(([, words]) => words.includes('#ff0000'));
  assert(red >= 0, `${row}`);
  await click(page, `#face-${red}`);
  await page.waitForFunction(async () => (await (await fetch('/api/v1/state')).json()).job.avoid_faces.length === 1);
  await part_ready(page, 12);
  assert.deepEqual((await state(page)).part.warnings, []);
  const yellow = () => page.evaluate(() => {
    window.tiltfeed.look('top');
    window.tiltfeed.render();
    const {clientWidth: width, clientHeight: height} = document.getElementById('canvas');
    const [r, g, b] = window.tiltfeed.colours_at([[width / 2 + 20, height / 2 + 20]])[0];
    return r > 180 && g > 150 && b < 110;
  });
  await page.waitForFunction(() => document.querySelector('#canvas').dataset.part === 'blocks.3mf');
  await page.evaluate(() => document.activeElement.blur());
  assert(await yellow(), 'the top is lit');
  await shot(page, 'cad-part-1920');
  await check_accessible(page);
  await check_layout(page, false);
  assert.equal((await state(page)).job.errors.length, 0);
  // A click on that face in the view finds it in the list.
  const middle = await page.$eval('#canvas', (canvas) => { const {left, top, width, height} = canvas.getBoundingClientRect(); return [left + width / 2 + 20, top + height / 2 + 20]; });
  await page.mouse.click(...middle);
  await page.waitForFunction((id) => document.activeElement?.id === id, {}, `face-${red}`);
  // A body that is not there: told in words, and mended on the same page.
  await page.evaluate(async () => {
    const csrf = (await (await fetch('/api/v1/session')).json()).csrf;
    const text = (await (await fetch('/api/v1/job/text')).text()).replace('["housing"]', '["cover"]');
    await fetch('/api/v1/job', {method: 'PUT', body: text, headers: {'Content-Type': 'application/octet-stream', 'X-Tiltfeed-Csrf': csrf}});
  });
  await page.waitForFunction(() => /no body has the name "cover"; there are "housing", "lid"/.test(document.querySelector('#sheet [role=alert]')?.textContent ?? ''));
  await click(page, '#body-0');
  await part_ready(page, 12);
  await click(page, `#face-${red}`);
  await page.waitForFunction(async () => (await (await fetch('/api/v1/state')).json()).job.avoid_faces.length === 0);
  await part_ready(page, 12);
  await page.locator('#tab-plan').click();
  await page.waitForSelector('#plan:not([disabled])');
  await page.locator('#plan').click();
  await page.waitForFunction(() => document.querySelector('#blocks, #refused'));
  assert.equal(await page.$('#refused'), null, await page.evaluate(() => document.getElementById('refused')?.textContent));
  const report = await page.evaluate(async () => (await fetch('/api/v1/plan/report')).json());
  assert.deepEqual(report.part_file.bodies, ['housing']);
  await check_and_close(page);
  assert.equal(await desk.stop(), 0);
});

/** "block" is the name of a body and of the product of two: what that means is said. The other way round it is possible. */
async function one_of_a_product(page) {
  await page.locator('#make-job').click();
  await wait_until(async () => (await state(page)).job !== null);
  await page.locator('#tab-part').click();
  await click(page, '#body-1');
  await page.waitForSelector('#part-choice-problem');
  assert.match(await text_of(page, '#part-choice-problem'), /"block" takes all bodies of that product, "block \(2\)" too/);
  await click(page, '#body-0');
  await wait_until(async () => (await state(page)).job.bodies.join() === 'block (2),knob');
  await page.waitForFunction(() => JSON.stringify([...document.querySelectorAll('#part-bodies input')].map((node) => node.checked)) === '[false,true,true]');
}

test('a STEP file, on a tablet and a phone', {skip: !existsSync(join(bin, 'cad_files'))}, async () => {
  const folder = join(work, 'cad');
  mkdirSync(folder, {recursive: true});
  assert.equal((await run('cad_files', folder)).status, 0);
  const desk = await Desk.start(join(folder, 'assembly.step'));
  const listed = JSON.parse((await run('tiltfeed-cad', join(folder, 'assembly.step'), '--json')).out);
  for (const [name, viewport, scheme] of [['1024', kTablet, 'light'], ['390', kPhone, 'dark']]) {
    const page = await open_page(desk, {viewport, scheme});
    await page.waitForSelector('#part-bodies li');
    assert.deepEqual(await page.$$eval('#part-bodies label > span', (nodes) => nodes.map((node) => node.firstChild.textContent)), listed.bodies.map((body) => body.name));
    assert.equal(await text_of(page, '#file-format'), `${listed.format}, ${listed.bodies.length} bodies, ${listed.faces.length} faces`);
    assert.equal(await text_of(page, '#facets'), listed.faces.reduce((sum, {facets}) => sum + facets, 0).toLocaleString('en'));
    assert.equal(await text_of(page, '#deviation'), `${listed.deviation_mm.toFixed(4)} mm at most`);
    const colours = [...new Set(listed.faces.map((face) => face.name || face.colour).filter(Boolean))];
    assert.deepEqual(await page.$$eval('#part-faces [data-word]', (nodes) => nodes.map((node) => node.dataset.word)), colours);
    await shot(page, `cad-part-${name}`);
    await check_layout(page, true);
    await check_accessible(page);
    if (name === '390') await one_of_a_product(page);
    await check_and_close(page);
  }
  assert.equal(await desk.stop(), 0);
});

test('a damaged file is refused in words', async () => {
  const desk = await Desk.start(), page = await open_page(desk), file = join(work, 'cut_short.step');
  writeFileSync(file, 'ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT(\'\',(0.,0.,0.));\n#2=VERTEX_POINT(\'\',#7);\n');
  await drop(page, file);
  await page.waitForFunction(() => document.querySelector('#sheet [role=alert]'));
  const told = await text_of(page, '#sheet [role=alert]');
  assert.match(told, /cut_short\.step/);
  assert.doesNotMatch(told, /tiltfeed-desk-|part\.stl/, 'no path of the desk');
  await check_and_close(page);
  assert.equal(await desk.stop(), 0);
});
