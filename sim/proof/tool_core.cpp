#include "sim/proof/tool_core.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::sim {
namespace {

// Of half the angle between a corner's sides; narrower ones are none.
constexpr double kNarrowest = 0.1;
// A direction leans less than this from the axis (sine): all of a rim is as far along it.
constexpr double kAlongAxis = 1e-12;

/// The outline moved inwards by `depth`: arcs shrink about their centres, sharp corners run along their
/// bisectors.
ToolCore shrunk(ToolPart part, const Revolved& solid, double depth) {
  ToolCore core;
  core.part = part, core.solid = &solid, core.rounding = depth;
  double turn = 0.0;
  for (const Corner& corner : solid.corners()) {
    const double before = turn, inside = std::max(kNarrowest, std::cos(0.5 * (corner.turn - before))),
                 rest = corner.radius - depth;
    turn = corner.turn;
    if (rest >= 0.0) {
      core.corners.push_back({corner.r, corner.h, rest, corner.turn});
      continue;
    }
    // Outward normals are (sin, -cos) of the turn; the bisector is that of the middle, its length 1 / cos.
    const double middle = 0.5 * (before + turn), by = rest / inside;
    core.sharpness = std::max(core.sharpness, 1.0 / inside);
    core.corners.push_back({std::max(0.0, corner.r + by * std::sin(middle)), corner.h - by * std::cos(middle),
                            0.0, corner.turn});
  }
  return core;
}

void measure(ToolCore& core) {
  core.low = kInfinity, core.high = -kInfinity;
  for (const Corner& c : core.corners) {
    core.low = std::min(core.low, c.h), core.high = std::max(core.high, c.h);
    core.wide = std::max(core.wide, c.r + c.radius);
    core.reach = std::max(core.reach, std::hypot(c.r, c.h) + c.radius);
  }
}

}  // namespace

Vec3 ToolCore::furthest(Vec3 axis, Vec3 u) const {
  const double c = dot(axis, u);
  if (wide == 0.0) return axis * (c >= 0.0 ? high : low);
  // Twice: along the axis the first leaves rounding only, which points anywhere.
  const Vec3 across = u - axis * c, out = across - axis * dot(across, axis);
  const double s = length(out);
  double most = -kInfinity;
  const Corner* best = nullptr;
  for (const Corner& corner : corners) {
    const double value = corner.r * s + corner.h * c + corner.radius;
    if (value > most) most = value, best = &corner;
  }
  const Vec3 aside = s > kAlongAxis ? out * (best->r / s) : Vec3{};
  return axis * best->h + aside + u * best->radius;
}

std::vector<ToolCore> tool_cores(const ToolSolid& solid, double depth) {
  std::vector<ToolCore> cores;
  for (const ToolPart part : kToolParts) {
    for (const Revolved& piece : solid.pieces(part)) {
      const Corner& nose = piece.corners().front();
      const bool ball = part == ToolPart::kCutter && nose.r == 0.0 && nose.radius == piece.widest();
      if (ball) {
        // A ball end with a straight side is its axis grown by the radius; its flat top is a body of its own.
        const double top = piece.corners().back().h;
        ToolCore core;
        core.part = part, core.solid = &piece, core.rounding = nose.radius;
        core.corners = {{0.0, nose.h, 0.0, 0.0}, {0.0, std::max(nose.h, top - nose.radius), 0.0, 0.0}};
        cores.push_back(core);
        if (top <= nose.h) continue;
        cores.push_back(shrunk(part, piece, depth));
        std::vector<Corner>& corners = cores.back().corners;
        const double from = std::max(nose.h, top - 2.0 * nose.radius);
        corners.front() = {nose.radius - depth, std::min(from, corners.back().h), 0.0, 0.0};
        continue;
      }
      cores.push_back(shrunk(part, piece, depth));
    }
  }
  for (ToolCore& core : cores) measure(core);
  return cores;
}

}  // namespace tiltfeed::sim
