// Bundles the viewer of the verification's report and writes it as C++: node build_viewer.mjs OUT.cpp
import {createHash} from 'node:crypto';
import {writeFileSync} from 'node:fs';

import {bundle, literal, packed, read} from './bundle.mjs';

const out = process.argv[2];
if (!out) throw new Error('build_viewer.mjs OUT.cpp');

const script = await bundle('report_main.ts', 'iife');
// It stands in a page, and what ends a script there must not be in it.
if (/<!--|<\/?script/i.test(script.toString())) throw new Error('the viewer has text that a page takes for markup');
const hash = 'sha256-' + createHash('sha256').update(script).digest('base64');

writeFileSync(out, `// Made by desk/page/build_viewer.mjs.
#include "sim/viewer/viewer_files.h"

namespace tiltfeed::sim {
namespace {

constexpr char kScript[] =
${literal(packed(script))};
constexpr char kStyle[] =
${literal(read('cut.css'))};

}  // namespace

ViewerFiles viewer_files() {
  return {{kScript, sizeof kScript - 1}, "${hash}", {kStyle, sizeof kStyle - 1}};
}

}  // namespace tiltfeed::sim
`);
console.log(`viewer: ${script.length} bytes`);
