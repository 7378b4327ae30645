// What both builders share: bundles by esbuild, bytes as C++.
import {execFileSync} from 'node:child_process';
import {readFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

import {build} from 'esbuild';

export const source = join(dirname(fileURLToPath(import.meta.url)), 'src');
export const read = (name) => readFileSync(join(source, name));

/** A script of the sources, bundled and minified, as bytes. */
export async function bundle(entry, format) {
  const bundled = await build({
    entryPoints: [join(source, entry)],
    bundle: true,
    minify: true,
    format,
    target: 'es2020',
    write: false,
    legalComments: 'inline',
    logLevel: 'warning',
  });
  return Buffer.from(bundled.outputFiles[0].contents);
}

/** By Debian's program: each version of node packs otherwise, and the same sources are to give the same package. */
export function packed(bytes) {
  return execFileSync('gzip', ['-9nc'], {input: bytes, maxBuffer: 1 << 30});
}

/** Octal escapes of three digits: no digit that follows can become part of one. */
export function literal(bytes) {
  const lines = [];
  for (let i = 0; i < bytes.length; i += 32)
    lines.push('"' + [...bytes.subarray(i, i + 32)].map((b) => '\\' + b.toString(8).padStart(3, '0')).join('') + '"');
  return lines.join('\n');
}
