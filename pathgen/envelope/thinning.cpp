#include "pathgen/envelope/thinning.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

std::uint64_t leave_out(std::vector<Pass>& passes,
                        const std::function<bool(const EnvelopePoint&)>& unwanted) {
  std::uint64_t count = 0;
  std::vector<Pass> kept;
  for (Pass& pass : passes) {
    auto from = pass.begin();
    auto at = std::find_if(from, pass.end(), unwanted);
    if (at == pass.end()) {
      if (!pass.empty()) kept.push_back(std::move(pass));
      continue;
    }
    for (; at != pass.end(); at = std::find_if(from, pass.end(), unwanted)) {
      ++count;
      if (at != from) kept.emplace_back(from, at);
      from = at + 1;
    }
    if (from != pass.end()) kept.emplace_back(from, pass.end());
  }
  passes = std::move(kept);
  return count;
}

namespace {

/// Do the points between `from` and `to` lie within `tolerance` of the straight move?
bool all_on_move(const EnvelopePoint* from, const EnvelopePoint* to, double tolerance) {
  const Vec3 move = to->centre - from->centre;
  const double ll = squared_length(move), share = ll > 0.0 ? 1.0 / ll : 0.0;
  // The middle is the most likely to be off.
  const EnvelopePoint* middle = from + (to - from) / 2;
  const auto off = [&](const EnvelopePoint& p) {
    const Vec3 out = p.centre - from->centre;
    const double along = std::clamp(dot(out, move) * share, 0.0, 1.0);
    const double lever = static_cast<double>(p.lever);
    return squared_length(out - move * along) * (lever * lever) > tolerance * tolerance;
  };
  return !off(*middle) && (to - from == 2 || std::none_of(from + 1, to, off));
}

}  // namespace

Pass thinned(const Pass& pass, double tolerance, const EnvelopeOptions& options) {
  if (pass.empty()) return {};
  std::vector<std::size_t> stays{0};
  // (E4) Reach as far as every skipped point allows. The reach is capped, so that the work stays linear.
  constexpr std::size_t kLongestReach = 64;
  const double reach = options.max_distance;
  std::size_t from = 0;
  while (from + 1 < pass.size()) {
    std::size_t to = from + 1;
    for (std::size_t next = to + 1; next < pass.size() && next - from <= kLongestReach; ++next) {
      const double turn2 = squared_length(cross(pass[from].axis, pass[next].axis));
      if (!turns_little(pass[from], pass[next], turn2, options) ||
          squared_length(pass[next].centre - pass[from].centre) > reach * reach ||
          !all_on_move(&pass[from], &pass[next], tolerance))
        break;
      to = next;
    }
    stays.push_back(to);
    from = to;
  }
  Pass kept;
  kept.reserve(stays.size());
  for (const std::size_t i : stays) kept.push_back(pass[i]);
  return kept;
}

EnvelopePoint on_move(const EnvelopePoint& a, const EnvelopePoint& b, double f, const Deformation& map) {
  EnvelopePoint p = b;
  p.centre = lerp(a.centre, b.centre, f);
  p.axis = slerp(a.axis, b.axis, f);
  p.flat = lerp(a.flat, map.beside(b.flat, a.flat), f);
  p.flat.z = map.flatten(p.centre).z;
  return p;
}

Pass spaced(Pass pass, const Deformation& map, double max_distance) {
  if (!std::isfinite(max_distance)) return pass;
  Pass dense;
  for (std::size_t i = 0; i < pass.size(); ++i) {
    const double moves =
        i == 0 ? 1.0 : std::ceil(distance(pass[i - 1].centre, pass[i].centre) / max_distance - 1e-9);
    for (double k = 1.0; k < moves; ++k) dense.push_back(on_move(pass[i - 1], pass[i], k / moves, map));
    dense.push_back(pass[i]);
  }
  return dense;
}

void leave_held(LineEnvelope& found, const FlatLine& line) {
  if (!found.guarded) return;
  leave_out(found.passes, [&](const EnvelopePoint& p) {
    const double run = line.run_of(p.flat.x, p.flat.y);
    return std::none_of(found.cut.begin(), found.cut.end(),
                        [&](const auto& cut) { return run >= cut.first && run <= cut.second; });
  });
}

}  // namespace tiltfeed::pathgen
