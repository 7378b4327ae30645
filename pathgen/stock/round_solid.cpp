#include "pathgen/stock/round_solid.h"

#include <algorithm>
#include <cmath>

#include "kinematics/basics/units.h"

namespace tiltfeed::pathgen {

namespace {

/// Chords of a rounded edge.
constexpr int kChords = 6;
/// Of a quadratic's leading coefficient, and of a direction's share along the tool: so little is none.
constexpr double kFlat = 1e-12;

RoundSolid cutting_part(const Cutter& cutter) {
  RoundSolid solid;
  const double r = cutter.radius(), end = cutter.cutting_end(), edge = cutter.nose_radius();
  switch (cutter.type) {
    case CutterType::kBall:
      solid.ball = r;
      solid.rims = {{r, r}};
      break;
    case CutterType::kTaperBall: {
      const double taper = cutter.taper.radians();
      solid.ball = r;
      solid.rims = {{r * std::cos(taper), r - r * std::sin(taper)}};
      break;
    }
    default:
      for (int i = 0; i <= (edge > 0.0 ? kChords : 0); ++i) {
        const double turn = 0.5 * kPi * i / kChords;
        solid.rims.push_back({r - edge + edge * std::sin(turn), edge - edge * std::cos(turn)});
      }
  }
  if (end > solid.rims.back().height) solid.rims.push_back({cutter.cutting_top_radius(), end});
  if (solid.rims.size() == 1) solid.rims.push_back(solid.rims.front());
  return solid;
}

}  // namespace

double RoundSolid::widest() const {
  double most = ball;
  for (const Rim& rim : rims) most = std::max(most, rim.radius);
  return most;
}

std::vector<RoundSolid> round_solids(const Cutter& cutter) {
  std::vector<RoundSolid> solids{cutting_part(cutter)};
  const auto stand_on = [&](ToolPart part, double lower, double upper, double length) {
    const double from = solids.back().highest();
    solids.push_back({part, 0.0, {{lower, from}, {upper, from + length}}, {}});
  };
  if (cutter.shank_length > cutter.cutting_end())
    stand_on(ToolPart::kShank, cutter.shank_radius(), cutter.shank_radius(),
             cutter.shank_length - cutter.cutting_end());
  for (const HolderStep& step : cutter.holder)
    stand_on(ToolPart::kHolder, 0.5 * step.lower_diameter, 0.5 * step.upper_diameter, step.length);
  std::vector<RoundSolid::Rim> outline;
  for (const RoundSolid& solid : solids) outline.insert(outline.end(), solid.rims.begin(), solid.rims.end());
  outline.push_back({0.0, outline.back().height});
  for (RoundSolid& solid : solids) solid.outline = outline;
  return solids;
}

PlacedSolid::PlacedSolid(const RoundSolid& solid, const Pose& pose, int along)
    : solid_(&solid), tip_(line_place(from_origin(pose.tip), along)), axis_(line_place(pose.axis, along)) {
  // A disc across the axis reaches so much of its radius along each coordinate.
  const auto bound = [&](double LinePlace::*k) {
    const double a = axis_.*k, across = std::sqrt(std::max(0.0, 1.0 - a * a));
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const RoundSolid::Rim& rim : solid.rims)
      low = std::min(low, a * rim.height - across * rim.radius),
      high = std::max(high, a * rim.height + across * rim.radius);
    if (solid.ball > 0.0)
      low = std::min(low, (a - 1.0) * solid.ball), high = std::max(high, (a + 1.0) * solid.ball);
    low_.*k = tip_.*k + low, high_.*k = tip_.*k + high;
  };
  bound(&LinePlace::u), bound(&LinePlace::v), bound(&LinePlace::t);
}

std::optional<LineSpan> PlacedSolid::on_line(double u, double v) const {
  // From the tip, at its height on the line: t of that.
  const double du = u - tip_.u, dv = v - tip_.v, k = axis_.t;
  const double q = du * du + dv * dv, h0 = du * axis_.u + dv * axis_.v;
  const double widest = std::numeric_limits<double>::infinity();
  const auto slab = [&](double low, double high) -> LineSpan {
    if (std::abs(k) < kFlat) return h0 >= low && h0 <= high ? LineSpan{-widest, widest} : LineSpan{1.0, 0.0};
    const double a = (low - h0) / k, b = (high - h0) / k;
    return {std::min(a, b), std::max(a, b)};
  };
  LineSpan all{widest, -widest};
  const auto take = [&](double low, double high) {
    if (low < high) all.low = std::min(all.low, low), all.high = std::max(all.high, high);
  };
  if (const double r = solid_->ball; r > 0.0) {
    const double root = r * k * r * k - q + 2.0 * r * h0;
    const LineSpan within = slab(0.0, solid_->highest());
    if (root > 0.0)
      take(std::max(within.low, r * k - std::sqrt(root)), std::min(within.high, r * k + std::sqrt(root)));
  }
  for (std::size_t i = 1; i < solid_->rims.size(); ++i) {
    const RoundSolid::Rim &lower = solid_->rims[i - 1], &upper = solid_->rims[i];
    if (upper.height <= lower.height) continue;
    const LineSpan within = slab(lower.height, upper.height);
    if (within.low >= within.high) continue;
    // (LE1) a t^2 - 2 b t + c <= 0.
    const double m = (upper.radius - lower.radius) / (upper.height - lower.height);
    const double g = lower.radius + m * (h0 - lower.height);
    const double a = 1.0 - k * k * (1.0 + m * m), b = k * (h0 + g * m), c = q - h0 * h0 - g * g;
    if (std::abs(a) < kFlat) {
      if (std::abs(b) < kFlat) {
        if (c <= 0.0) take(within.low, within.high);
      } else if (const double end = 0.5 * c / b; b > 0.0) {
        take(std::max(within.low, end), within.high);
      } else {
        take(within.low, std::min(within.high, end));
      }
      continue;
    }
    const double root = b * b - a * c;
    if (root <= 0.0) {
      if (a < 0.0) take(within.low, within.high);
      continue;
    }
    const double s = std::sqrt(root), one = (b - s) / a, other = (b + s) / a;
    if (a > 0.0) {
      take(std::max(within.low, one), std::min(within.high, other));
    } else {  // of both halves of the cone one is in the slab
      take(within.low, std::min(within.high, other));
      take(std::max(within.low, one), within.high);
    }
  }
  if (all.low >= all.high) return std::nullopt;
  return LineSpan{all.low + tip_.t, all.high + tip_.t};
}

double PlacedSolid::depth(LinePlace place, double enough) const {
  const double du = place.u - tip_.u, dv = place.v - tip_.v, dt = place.t - tip_.t;
  const double h = du * axis_.u + dv * axis_.v + dt * axis_.t;
  const double r = std::sqrt(std::max(0.0, du * du + dv * dv + dt * dt - h * h));
  // Straight outwards it is no nearer.
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < solid_->rims.size(); ++i) {
    const RoundSolid::Rim &lower = solid_->rims[i - 1], &upper = solid_->rims[i];
    if (h < lower.height || h > upper.height || lower.height == upper.height) continue;
    const double share = (h - lower.height) / (upper.height - lower.height);
    least = std::min(least, lower.radius + share * (upper.radius - lower.radius) - r);
  }
  for (std::size_t i = 1; i < solid_->outline.size() && least > enough; ++i) {
    const RoundSolid::Rim &from = solid_->outline[i - 1], &to = solid_->outline[i];
    const double along_r = to.radius - from.radius, along_h = to.height - from.height;
    const double square = along_r * along_r + along_h * along_h;
    const double share =
        square > 0.0
            ? std::clamp(((r - from.radius) * along_r + (h - from.height) * along_h) / square, 0.0, 1.0)
            : 0.0;
    least = std::min(least, std::hypot(r - from.radius - share * along_r, h - from.height - share * along_h));
  }
  return least;
}

bool PlacedSolid::may_meet(LinePlace low, LinePlace high) const {
  const LinePlace middle{0.5 * (low.u + high.u) - tip_.u, 0.5 * (low.v + high.v) - tip_.v,
                         0.5 * (low.t + high.t) - tip_.t};
  const LinePlace half{0.5 * (high.u - low.u), 0.5 * (high.v - low.v), 0.5 * (high.t - low.t)};
  const double h = middle.u * axis_.u + middle.v * axis_.v + middle.t * axis_.t;
  const double along = half.u * std::abs(axis_.u) + half.v * std::abs(axis_.v) + half.t * std::abs(axis_.t);
  if (h - along > solid_->highest() || h + along < solid_->lowest()) return false;
  // Off the axis towards the middle of the box.
  const LinePlace off{middle.u - h * axis_.u, middle.v - h * axis_.v, middle.t - h * axis_.t};
  const double away = std::sqrt(off.u * off.u + off.v * off.v + off.t * off.t);
  const double across = half.u * std::abs(off.u) + half.v * std::abs(off.v) + half.t * std::abs(off.t);
  return away * away - across <= solid_->widest() * away;
}

}  // namespace tiltfeed::pathgen
