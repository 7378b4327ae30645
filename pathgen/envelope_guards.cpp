// Which patches of shank and holder matter on a line of the envelope.

#include <algorithm>

#include "pathgen/envelope.h"

namespace tiltfeed {

/// Makes those patches of shank and holder candidates that can be higher than what was found of the cutting
/// part; false if none can.
bool Envelope::keep_guards(const LineEnvelope& found, const FlatLine& line) {
  const PatchId cutter = surface_.features();
  candidates_.clear();
  bool guarded = false;
  for (const Candidate& c : all_) {
    if (c.patch >= cutter) {
      if (!may_rise(c, found, line)) continue;
      guarded = true;
    }
    candidates_.push_back(c);
  }
  return guarded;
}

/// Can the candidate be higher than what was found of the cutting part, or is it where that finds nothing?
bool Envelope::may_rise(const Candidate& c, const LineEnvelope& found, const FlatLine& line) const {
  for (const Pass& pass : found.passes) {
    const auto run = [&](const EnvelopePoint& p) { return line.run_of(p.flat.x, p.flat.y); };
    if (run(pass.back()) < c.from) continue;
    if (run(pass.front()) > c.from || run(pass.back()) < c.to) return true;
    auto at = std::lower_bound(pass.begin(), pass.end(), c.from,
                               [&](const EnvelopePoint& p, double from) { return run(p) < from; });
    if (at != pass.begin()) --at;
    for (; at != pass.end(); ++at) {
      if (at->flat.z - options_.tolerance < static_cast<double>(c.top)) return true;
      if (run(*at) > c.to) break;
    }
    return false;
  }
  return true;
}

}  // namespace tiltfeed
