// Bundles the page and writes its files, compressed, as C++: node build.mjs OUT.cpp
import {createHash} from 'node:crypto';
import {readFileSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {gzipSync} from 'node:zlib';

import {build} from 'esbuild';

const kMostBytes = 1024 * 1024;  // compressed, all files
const source = join(dirname(fileURLToPath(import.meta.url)), 'src');
const out = process.argv[2];
if (!out) throw new Error('build.mjs OUT.cpp');

const bundled = await build({
  entryPoints: [join(source, 'main.ts')],
  bundle: true,
  minify: true,
  format: 'esm',
  target: 'es2020',
  write: false,
  legalComments: 'inline',
  logLevel: 'warning',
});
const files = [
  {path: '/', type: 'text/html; charset=utf-8', bytes: readFileSync(join(source, 'index.html'))},
  {path: '/page.css', type: 'text/css; charset=utf-8', bytes: readFileSync(join(source, 'page.css'))},
  {path: '/icon.svg', type: 'image/svg+xml', bytes: readFileSync(join(source, 'icon.svg'))},
  {path: '/page.js', type: 'text/javascript; charset=utf-8', bytes: Buffer.from(bundled.outputFiles[0].contents)},
];

// Octal escapes of three digits: no digit that follows can become part of one.
const literal = (bytes) => {
  const lines = [];
  for (let i = 0; i < bytes.length; i += 32)
    lines.push('"' + [...bytes.subarray(i, i + 32)].map((b) => '\\' + b.toString(8).padStart(3, '0')).join('') + '"');
  return lines.join('\n');
};

let text = '// Made by desk/page/build.mjs.\n#include "desk/page/page_files.h"\n\nnamespace tiltfeed::desk {\nnamespace {\n\n';
let table = '', total = 0;
files.forEach(({path, type, bytes}, i) => {
  const gzip = gzipSync(bytes, {level: 9});
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
