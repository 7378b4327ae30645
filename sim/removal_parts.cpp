#include "sim/removal_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/forward.h"

namespace tiltfeed::sim {
namespace {

// A straight step may leave the way of the tip by this much, mm: far below any tolerance.
constexpr double kStray = 5e-4;
// And the way of the tool's upper end, and the turn of a piece of it, by this share of a cell.
constexpr double kStrayCells = 0.125;
// Exact distances are taken at least every so many least radii, so that nothing is passed over.
constexpr double kLookRadii = 0.5;
constexpr int kMostSteps = 20000;
// Above this the surface winds round the point: inside.
constexpr double kInside = 0.5;
constexpr double kCubeCells = 16.0, kLeastCube = 2.0;

Joints between(const Joints& from, const Joints& to, double f) {
  const auto mix = [f](double a, double b) { return a + (b - a) * f; };
  return {mix(from.x, to.x), mix(from.y, to.y), mix(from.z, to.z), mix(from.a, to.a), mix(from.c, to.c)};
}

}  // namespace

Occupied::Occupied(const Stock& stock)
    : origin_(from_origin(stock.box.min)), cube_(std::max(kLeastCube, kCubeCells * stock.cell)) {
  const Vec3 size = stock.box.max - stock.box.min;
  size_ = {static_cast<int>(size.x / cube_) + 1, static_cast<int>(size.y / cube_) + 1,
           static_cast<int>(size.z / cube_) + 1};
  full_.assign(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2], false);
  for (const Dexels& dexels : stock.bundles) {
    for (int stripe = 0; stripe < Dexels::kStripes; ++stripe) {
      dexels.each(stripe, [&](Point<Part> foot, double low, double high) {
        std::array<double, 3> p{foot.x, foot.y, foot.z};
        p[dexels.axis()] = low;
        std::array<int, 3> from = index({p[0], p[1], p[2]});
        p[dexels.axis()] = high;
        const int last = index({p[0], p[1], p[2]})[dexels.axis()];
        for (int& k = from[dexels.axis()]; k <= last; ++k)
          full_[(static_cast<std::size_t>(from[2]) * size_[1] + from[1]) * size_[0] + from[0]] = true;
      });
    }
  }
}

std::array<int, 3> Occupied::index(Vec3 p) const {
  const auto at = [&](double v, int size) {
    return static_cast<int>(std::clamp(v / cube_, 0.0, size - 1.0));
  };
  const Vec3 from = p - origin_;
  return {at(from.x, size_[0]), at(from.y, size_[1]), at(from.z, size_[2])};
}

bool Occupied::meets(Vec3 low, Vec3 high) const {
  const Vec3 end = origin_ + Vec3{size_[0] * cube_, size_[1] * cube_, size_[2] * cube_};
  if (high.x < origin_.x || high.y < origin_.y || high.z < origin_.z || low.x > end.x || low.y > end.y ||
      low.z > end.z)
    return false;
  const auto from = index(low), to = index(high);
  for (int z = from[2]; z <= to[2]; ++z)
    for (int y = from[1]; y <= to[1]; ++y)
      for (int x = from[0]; x <= to[0]; ++x)
        if (full_[(static_cast<std::size_t>(z) * size_[1] + y) * size_[0] + x]) return true;
  return false;
}

Stand::Stand(const Job& job, const ExecutedPath& path, const Stock& stock, const Probes& probes,
             const RemovalOptions& options)
    : job_(job),
      path_(path),
      stock_(stock),
      probes_(probes),
      solid_(job.plan.cutter),
      sweep_(job.plan.cutter),
      occupied_(stock),
      tolerance_(options.tolerance),
      top_(solid_.top()),
      least_(solid_.narrowest()),
      cell_(stock.cell) {}

Pose Stand::pose(const Joints& joints) const {
  return forward_by_frames(job_.machine.model, job_.setup, joints);
}

/// A curve that strays by d from its chord strays by d / n^2 from n chords.
int Stand::steps(const Pose& from, const Pose& middle, const Pose& to) const {
  const auto end = [&](const Pose& p) { return p.tip + p.axis * top_; };
  const double tip = distance(middle.tip, lerp(from.tip, to.tip, 0.5)) / kStray;
  const double top = distance(end(middle), lerp(end(from), end(to), 0.5)) / (kStrayCells * cell_);
  const double turn = angle_between(from.axis, to.axis) * sweep_.longest() / 4.0 / (kStrayCells * cell_);
  const double way = std::max(distance(from.tip, middle.tip) + distance(middle.tip, to.tip),
                              distance(end(from), end(middle)) + distance(end(middle), end(to)));
  // Long ways are cut up so that the bodies stay near what they are long for.
  const double pieces = way / (4.0 * std::max(least_, cell_));
  return static_cast<int>(std::ceil(
      std::clamp(std::max({1.0, std::sqrt(tip), std::sqrt(top), turn, pieces}), 1.0, 1.0 * kMostSteps)));
}

std::pair<Segment, double> Stand::core(const SweptStep& step) const {
  const auto middle = [&](double h) {
    return lerp(step.from.tip + step.from.axis * h, step.to.tip + step.to.axis * h, 0.5);
  };
  const auto half = [&](double h) {
    return 0.5 * distance(step.from.tip + step.from.axis * h, step.to.tip + step.to.axis * h);
  };
  const double low = sweep_.core_low(), high = sweep_.core_high();
  return {{middle(low), middle(high)}, sweep_.reach() + std::max(half(low), half(high))};
}

double Stand::nearest(const SweptStep& step, Point<Part> p) const {
  const Vec3 axis = step.from.axis, way = step.to.tip - step.from.tip;
  const double low = sweep_.core_low(), high = sweep_.core_high();
  const double h = std::clamp(dot(p - step.from.tip, axis), low, high);
  // At one height the core sweeps a segment; along the axis it moves, and turns, by this much besides.
  const double turn = length(step.to.axis - step.from.axis);
  const double slack = std::abs(dot(way, axis)) + turn * (h + length(way)) * turn;
  return distance_to_segment(p, step.from.tip + axis * h, step.to.tip + step.to.axis * h) - sweep_.reach() -
         slack;
}

std::optional<Hit3> Stand::starts_inside() const {
  const Pose start = pose(path_.start);
  const Point<Part> centre = start.tip + start.axis * sweep_.core_low();
  if (probes_.surface().winding_number(centre) <= kInside) return std::nullopt;
  const std::uint32_t patch = probes_.surface().nearest(centre).facet;
  return Hit3{TroubleKind::kRapidPart,
              ToolPart::kCutter,
              0,
              solid_.cutting().widest(),
              probes_.patches().mesh.source[patch],
              start.tip};
}

void Stand::measure(const Pose& at, std::size_t move, Swept& out) const {
  const TroubleKind kind = path_.moves[move].rapid ? TroubleKind::kRapidPart : TroubleKind::kGouge;
  double& worst = out.worst[static_cast<int>(kind)];
  for (const ToolPart part : kToolParts) {
    // Of what is tolerated only the deepest matters.
    const Hit hit = solid_.clearance(probes_.surface(), at, part, -std::min(worst, tolerance_));
    if (hit.facet == kNoFacet) continue;
    worst = std::max(worst, -hit.value);
    if (-hit.value <= tolerance_) continue;
    out.hits.push_back({kind, part, static_cast<std::uint32_t>(move), -hit.value,
                        probes_.patches().mesh.source[hit.facet], at.tip});
  }
}

void Stand::share_out(const SweptStep& step, std::vector<SweptBody>& bodies, Swept& out) const {
  bodies.clear();
  sweep_.bodies(step.from, step.to, bodies);
  for (const SweptBody& body : bodies) {
    if (!occupied_.meets(body.low, body.high)) continue;
    for (std::size_t b = 0; b < stock_.bundles.size(); ++b) {
      const auto [first, last] = stock_.bundles[b].stripes(body);
      for (int s = first; s < last; ++s)
        out.by_stripe[b * Dexels::kStripes + s].push_back(static_cast<std::uint32_t>(out.pieces.size()));
    }
    out.pieces.push_back({step.move, body});
  }
}

void Stand::sweep_moves(std::size_t begin, std::size_t end, Swept& out) const {
  out.by_stripe.resize(stock_.bundles.size() * Dexels::kStripes);
  std::vector<SweptBody> bodies;
  Pose at = pose(path_.from(begin));
  for (std::size_t m = begin; m < end; ++m) {
    const Joints &from = path_.from(m), &to = path_.moves[m].to;
    const Pose middle = pose(between(from, to, 0.5)), last = pose(to);
    const int count = steps(at, middle, last);
    for (int i = 1; i <= count; ++i) {
      const SweptStep step{static_cast<std::uint32_t>(m), at,
                           i == count ? last : pose(between(from, to, static_cast<double>(i) / count))};
      const double way = distance(step.from.tip, step.to.tip);
      (path_.moves[m].rapid ? out.rapid_length : out.feed_length) += way;
      const double far =
          std::max(way, distance(step.from.tip + step.from.axis * top_, step.to.tip + step.to.axis * top_));
      const int looks = std::max(2, static_cast<int>(std::ceil(far / (kLookRadii * least_))));
      for (int k = 1; k < looks; ++k)
        measure(pose(between(from, to, (i - 1 + static_cast<double>(k) / looks) / count)), m, out);
      measure(step.to, m, out);
      out.steps.push_back(step);
      share_out(step, bodies, out);
      at = step.to;
    }
  }
}

}  // namespace tiltfeed::sim
