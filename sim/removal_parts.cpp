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
// Longer ways, in least radii or cells, are cut up, so that bodies stay near what they are long for.
constexpr double kStepWays = 4.0;
constexpr int kMostSteps = 20000;
// Above this the surface winds round the point: inside.
constexpr double kInside = 0.5;
constexpr double kCubeCells = 4.0, kLeastCube = 2.0;

Joints between(const Joints& from, const Joints& to, double f) {
  const auto mix = [f](double a, double b) { return a + (b - a) * f; };
  return {mix(from.x, to.x), mix(from.y, to.y), mix(from.z, to.z), mix(from.a, to.a), mix(from.c, to.c)};
}

}  // namespace

Occupied::Occupied(const Stock& stock, double reach)
    : origin_(from_origin(stock.box.min)), cube_(std::max(kLeastCube, kCubeCells * stock.cell)) {
  const int by = static_cast<int>(reach / cube_) + 1;
  const double wide = by * cube_;
  origin_ = origin_ - Vec3{wide, wide, wide};
  const Vec3 size = from_origin(stock.box.max) + Vec3{wide, wide, wide} - origin_;
  size_ = {static_cast<int>(size.x / cube_) + 1, static_cast<int>(size.y / cube_) + 1,
           static_cast<int>(size.z / cube_) + 1};
  end_ = origin_ + Vec3{size_[0] * cube_, size_[1] * cube_, size_[2] * cube_};
  full_.assign(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2], 0);
  for (const Dexels& dexels : stock.bundles) {
    for (int stripe = 0; stripe < Dexels::kStripes; ++stripe) {
      dexels.each(stripe, [&](Point<Part> foot, double low, double high) {
        std::array<double, 3> p{foot.x, foot.y, foot.z};
        p[dexels.axis()] = low;
        std::array<int, 3> from = index({p[0], p[1], p[2]});
        p[dexels.axis()] = high;
        const int last = index({p[0], p[1], p[2]})[dexels.axis()];
        for (int& k = from[dexels.axis()]; k <= last; ++k) full_[at(from[0], from[1], from[2])] = 1;
      });
    }
  }
  for (int axis = 0; axis < 3; ++axis) widen(axis, by);
}

/// Every cube takes the largest of those up to `by` before and behind it.
void Occupied::widen(int axis, int by) {
  const std::vector<char> before = full_;
  std::array<int, 3> i{};
  for (i[2] = 0; i[2] < size_[2]; ++i[2])
    for (i[1] = 0; i[1] < size_[1]; ++i[1])
      for (i[0] = 0; i[0] < size_[0]; ++i[0]) {
        if (before[at(i[0], i[1], i[2])] == 0) continue;
        std::array<int, 3> k = i;
        const int last = std::min(size_[axis] - 1, i[axis] + by);
        for (k[axis] = std::max(0, i[axis] - by); k[axis] <= last; ++k[axis]) full_[at(k[0], k[1], k[2])] = 1;
      }
}

std::array<int, 3> Occupied::index(Vec3 p) const {
  const auto cube = [&](double v, int size) {
    return static_cast<int>(std::clamp(v / cube_, 0.0, size - 1.0));
  };
  const Vec3 from = p - origin_;
  return {cube(from.x, size_[0]), cube(from.y, size_[1]), cube(from.z, size_[2])};
}

bool Occupied::near(Point<Part> p) const {
  if (p.x < origin_.x || p.y < origin_.y || p.z < origin_.z || p.x > end_.x || p.y > end_.y || p.z > end_.z)
    return false;
  const auto i = index(from_origin(p));
  return full_[at(i[0], i[1], i[2])] != 0;
}

Stand::Stand(const Job& job, const ExecutedPath& path, const Stock& stock, Probes& probes,
             const RemovalOptions& options)
    : job_(job),
      path_(path),
      stock_(stock),
      probes_(probes),
      solid_(job.plan.cutter),
      sweep_(job.plan.cutter),
      occupied_(stock, sweep_.piece_reach() + 0.5 * kStepWays * std::max(solid_.narrowest(), stock.cell)),
      plain_(job.plan.cutter.type == CutterType::kBall && !solid_.has(ToolPart::kShank) &&
             !solid_.has(ToolPart::kHolder)),
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
  const double pieces = way / (kStepWays * std::max(least_, cell_));
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
  const double low = sweep_.core_low(), high = plain_ ? std::max(low, top_) : sweep_.core_high();
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

std::optional<MoveHit> Stand::starts_inside() const {
  const Pose start = pose(path_.start);
  const Point<Part> centre = start.tip + start.axis * sweep_.core_low();
  if (probes_.surface().winding_number(centre) <= kInside) return std::nullopt;
  const std::uint32_t patch = probes_.surface().nearest(centre).facet;
  return MoveHit{TroubleKind::kRapidPart,
                 ToolPart::kCutter,
                 0,
                 solid_.cutting().widest(),
                 probes_.patches().mesh.source[patch],
                 start.tip};
}

Hit Stand::clearance(const Pose& at, ToolPart part, const std::vector<std::uint32_t>& near,
                     double bound) const {
  if (!plain_ || part != ToolPart::kCutter) return solid_.clearance(probes_.surface(), at, part, bound);
  // All that the capsule can touch is among the patches at hand.
  const double radius = sweep_.reach();
  const Segment core{at.tip + at.axis * radius, at.tip + at.axis * std::max(radius, top_)};
  const Patches& patches = probes_.patches();
  Hit hit{bound, kNoFacet};
  for (const std::uint32_t patch : near) {
    const double far = hit.value + radius;
    if (distance_to_segment(patches.middle[patch], core.from, core.to) >
        far + static_cast<double>(patches.radius[patch]))
      continue;
    const double d2 = squared_distance(probes_.surface().triangle(patch), core);
    if (d2 < far * far) hit = {std::sqrt(d2) - radius, patch};
  }
  return hit;
}

/// Exact distances at the step's poses, and the probes that it passes.
void Stand::look(const SweptStep& step, Bench& bench, Swept& out) const {
  const auto [segment, radius] = core(step);
  probes_.near(segment, radius + probes_.reach(), bench.near);
  const TroubleKind kind = path_.moves[step.move].rapid ? TroubleKind::kRapidPart : TroubleKind::kGouge;
  double& worst = out.worst[static_cast<int>(kind)];
  for (const Pose& at : bench.looks) {
    for (const ToolPart part : kToolParts) {
      // Of what is tolerated only the deepest matters.
      const Hit hit = clearance(at, part, bench.near, -std::min(worst, tolerance_));
      if (hit.facet == kNoFacet) continue;
      worst = std::max(worst, -hit.value);
      if (-hit.value <= tolerance_) continue;
      out.hits.push_back(
          {kind, part, step.move, -hit.value, probes_.patches().mesh.source[hit.facet], at.tip});
    }
  }
  probes_.pass(
      bench.near, radius, step.move, [&](Point<Part> p) { return sweep_.cutter_near(step.from, step.to, p); },
      [&](Point<Part> p) { return nearest(step, p); });
}

void Stand::share_out(const SweptStep& step, Bench& bench, Swept& out) const {
  bench.bodies.clear();
  sweep_.bodies(
      step.from, step.to, [&](Point<Part> p) { return occupied_.near(p); }, bench.bodies);
  for (const SweptBody& body : bench.bodies) {
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
  Bench bench;
  Pose at = pose(path_.from(begin));
  for (std::size_t m = begin; m < end; ++m) {
    const Joints &from = path_.from(m), &to = path_.moves[m].to;
    const Pose middle = pose(between(from, to, 0.5)), last = pose(to);
    const int count = steps(at, middle, last);
    for (int i = 1; i <= count; ++i) {
      const auto within = [&](double f) {
        return count == 1 && f == 0.5 ? middle : pose(between(from, to, (i - 1 + f) / count));
      };
      const SweptStep step{static_cast<std::uint32_t>(m), at, i == count ? last : within(1.0)};
      const double way = distance(step.from.tip, step.to.tip);
      (path_.moves[m].rapid ? out.rapid_length : out.feed_length) += way;
      const double far =
          std::max(way, distance(step.from.tip + step.from.axis * top_, step.to.tip + step.to.axis * top_));
      const int looks = std::max(2, static_cast<int>(std::ceil(far / (kLookRadii * least_))));
      bench.looks.clear();
      for (int k = 1; k < looks; ++k) bench.looks.push_back(within(static_cast<double>(k) / looks));
      bench.looks.push_back(step.to);
      look(step, bench, out);
      share_out(step, bench, out);
      at = step.to;
    }
  }
}

}  // namespace tiltfeed::sim
