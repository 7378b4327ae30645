// Bundles the page and writes its files, compressed, as C++: node build.mjs OUT.cpp
import {createHash} from 'node:crypto';
import {readFileSync, writeFileSync} from 'node:fs';

import {bundle, literal, packed, read} from './bundle.mjs';

const kMostBytes = 1024 * 1024;  // compressed, all files
const out = process.argv[2];
if (!out) throw new Error('build.mjs OUT.cpp');

const files = [
  {path: '/', type: 'text/html; charset=utf-8', bytes: read('index.html')},
  {path: '/page.css', type: 'text/css; charset=utf-8', bytes: Buffer.concat([read('page.css'), read('cut.css'), read('shop.css')])},
  {path: '/icon.svg', type: 'image/svg+xml', bytes: read('icon.svg')},
  {path: '/openapi.json', type: 'application/json', bytes: readFileSync(new URL('../api/openapi.json', import.meta.url))},
  {path: '/page.js', type: 'text/javascript; charset=utf-8', bytes: await bundle('main.ts', 'esm')},
];

let text = '// Made by desk/page/build.mjs.\n#include "desk/page/page_files.h"\n\nnamespace tiltfeed::desk {\nnamespace {\n\n';
let table = '', total = 0;
files.forEach(({path, type, bytes}, i) => {
  const gzip = packed(bytes);
  total += gzip.length;
  const etag = createHash('sha256').update(bytes).digest('hex').slice(0, 32);
  text += `constexpr char kFile${i}[] =\n${literal(gzip)};\n`;
  table += `    {"${path}", "${type}", "\\"${etag}\\"", {kFile${i}, sizeof kFile${i} - 1}},\n`;
});
if (total > kMostBytes) throw new Error(`the page has ${total} bytes compressed; at most ${kMostBytes} are allowed`);
text += `\nconstexpr PageFile kFiles[] = {\n${table}};\n\n}  // namespace\n\n`;
text += 'std::span<const PageFile> page_files() { return kFiles; }\n\n}  // namespace tiltfeed::desk\n';
writeFileSync(out, text);
console.log(`page: ${total} bytes compressed`);
