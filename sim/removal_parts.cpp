#include "sim/removal_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/forward.h"

namespace tiltfeed::sim {
namespace {

// A straight step may leave the way of the tip by this share of the tolerance.
constexpr double kStrayTolerances = 0.2;
// And the way of the tool's upper end, and the turn of a piece of it, by this share of a cell.
constexpr double kStrayCells = 0.125;
// Longer ways, in least radii or cells, are cut up, so that bodies stay near what they are long for.
constexpr double kStepWays = 4.0;
constexpr int kMostSteps = 20000;
// Above this the surface winds round the point: inside.
constexpr double kInside = 0.5;
// The words are rounded, and so is F: this much way, mm, and this share of it, may be more than F makes.
constexpr double kFeedSlack = 0.005, kFeedShare = 0.05;
constexpr double kCubeCells = 4.0, kLeastCube = 2.0;
constexpr std::uint16_t kFarCubes = 60000;  // more are not counted

}  // namespace

void Haste::take(const Haste& other) {
  const std::uint64_t all = moves + other.moves;
  if (other.ahead > ahead) *this = other;
  moves = all;
}

Occupied::Occupied(const Stock& stock, double reach)
    : origin_(from_origin(stock.box.min)), cube_(std::max(kLeastCube, kCubeCells * stock.cell)) {
  by_ = static_cast<int>(reach / cube_) + 1;
  const double wide = by_ * cube_;
  origin_ = origin_ - Vec3{wide, wide, wide};
  const Vec3 size = from_origin(stock.box.max) + Vec3{wide, wide, wide} - origin_;
  size_ = {static_cast<int>(size.x / cube_) + 1, static_cast<int>(size.y / cube_) + 1,
           static_cast<int>(size.z / cube_) + 1};
  end_ = origin_ + Vec3{size_[0] * cube_, size_[1] * cube_, size_[2] * cube_};
  cubes_.assign(static_cast<std::size_t>(size_[0]) * size_[1] * size_[2], kFarCubes);
  for (const Dexels& dexels : stock.bundles) {
    for (int stripe = 0; stripe < Dexels::kStripes; ++stripe) {
      dexels.each(stripe, [&](Point<Part> foot, double low, double high) {
        std::array<double, 3> p{foot.x, foot.y, foot.z};
        p[dexels.axis()] = low;
        std::array<int, 3> from = index({p[0], p[1], p[2]});
        p[dexels.axis()] = high;
        const int last = index({p[0], p[1], p[2]})[dexels.axis()];
        for (int& k = from[dexels.axis()]; k <= last; ++k) cubes_[at(from[0], from[1], from[2])] = 0;
      });
    }
  }
  measure();
}

/// Forward and backward: a cube is at most one further than those of its neighbours that came before.
void Occupied::measure() {
  const auto look = [&](int x, int y, int z, int back) {
    std::uint16_t& here = cubes_[at(x, y, z)];
    const auto other = [&](int dx, int dy, int dz) {
      const int ox = x + dx, oy = y + dy, oz = z + dz;
      if (ox < 0 || oy < 0 || oz < 0 || ox >= size_[0] || oy >= size_[1] || oz >= size_[2]) return;
      here = std::min(here, static_cast<std::uint16_t>(cubes_[at(ox, oy, oz)] + 1));
    };
    for (int k = -1; k <= 1; ++k) {
      for (int l = -1; l <= 1; ++l) other(l, k, back);
      other(k, back, 0);
    }
    other(back, 0, 0);
  };
  for (int z = 0; z < size_[2]; ++z)
    for (int y = 0; y < size_[1]; ++y)
      for (int x = 0; x < size_[0]; ++x) look(x, y, z, -1);
  for (int z = size_[2]; z-- > 0;)
    for (int y = size_[1]; y-- > 0;)
      for (int x = size_[0]; x-- > 0;) look(x, y, z, 1);
}

std::array<int, 3> Occupied::index(Vec3 p) const {
  const auto cube = [&](double v, int size) {
    return static_cast<int>(std::clamp(v / cube_, 0.0, size - 1.0));
  };
  const Vec3 from = p - origin_;
  return {cube(from.x, size_[0]), cube(from.y, size_[1]), cube(from.z, size_[2])};
}

double Occupied::clear(Point<Part> p) const {
  const Vec3 q = from_origin(p), below = origin_ - q, above = q - end_;
  const double outside = std::max({below.x, below.y, below.z, above.x, above.y, above.z});
  if (outside > 0.0) return outside;
  const auto i = index(q);
  // Less than k cubes away from p is no further than k cubes from its own.
  const int cubes = cubes_[at(i[0], i[1], i[2])] - by_;
  return cubes > 0 ? (cubes - 1) * cube_ : -1.0;
}

Stand::Stand(const Job& job, const ExecutedPath& path, const Stock& stock, Probes& probes,
             const RemovalOptions& options)
    : path_(path),
      stock_(stock),
      probes_(probes),
      chain_(job.machine.model, job.setup),
      solid_(job.plan.cutter),
      sweep_(job.plan.cutter),
      contact_(path, chain_, solid_, sweep_, probes, options.tolerance),
      occupied_(stock, sweep_.piece_reach() + 0.5 * kStepWays * std::max(solid_.narrowest(), stock.cell)),
      tolerance_(options.tolerance),
      top_(solid_.top()),
      least_(solid_.narrowest()),
      cell_(stock.cell),
      feed_(std::max(job.plan.cut_feed.mm_per_min(), job.plan.plunge_feed.mm_per_min())) {}

/// A curve that strays by d from its chord strays by d / n^2 from n chords.
void Stand::add_steps(std::size_t move, const Pose& from, std::vector<SweptStep>& steps) const {
  const Joints &start = path_.from(move), &end = path_.moves[move].to;
  const Pose middle = chain_(between(start, end, 0.5)), to = chain_(end);
  const auto at = [](const Pose& p, double h) { return p.tip + p.axis * h; };
  const auto stray = [&](double h) { return distance(at(middle, h), lerp(at(from, h), at(to, h), 0.5)); };
  const auto way = [&](double h) {
    return distance(at(from, h), at(middle, h)) + distance(at(middle, h), at(to, h));
  };
  const double low = std::max(stray(0.0), stray(sweep_.core_low())), top = stray(top_);
  const double turn = angle_between(from.axis, to.axis) * sweep_.longest() / 4.0 / (kStrayCells * cell_);
  const double pieces = std::max(way(0.0), way(top_)) / (kStepWays * std::max(least_, cell_));
  const int count =
      static_cast<int>(std::ceil(std::clamp(std::max({std::sqrt(low / (kStrayTolerances * tolerance_)),
                                                      std::sqrt(top / (kStrayCells * cell_)), turn, pieces}),
                                            1.0, 1.0 * kMostSteps)));
  Pose last = from;
  for (int i = 1; i <= count; ++i) {
    const double begin = static_cast<double>(i - 1) / count, done = static_cast<double>(i) / count;
    const Pose next = i == count ? to : chain_(between(start, end, done));
    steps.push_back({static_cast<std::uint32_t>(move), begin, done,
                     std::max(low, top) / (static_cast<double>(count) * count), last, next});
    last = next;
  }
}

std::optional<MoveHit> Stand::starts_inside() const {
  const Pose start = chain_(path_.start);
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

/// Does F ask for more than the job's feeds make?
void Stand::time(std::size_t move, double way, Point<Part> place, Haste& haste) const {
  const double asked = path_.moves[move].asked, ahead = way - feed_ * asked / 60.0;
  if (feed_ <= 0.0 || asked <= 0.0 || ahead <= kFeedSlack + kFeedShare * way) return;
  haste.take({1, way / asked * 60.0, ahead, static_cast<std::uint32_t>(move), place});
}

void Stand::share_out(const SweptStep& step, std::vector<SweptBody>& bodies, Swept& out) const {
  bodies.clear();
  sweep_.bodies(
      step.from, step.to, [&](Point<Part> p) { return occupied_.clear(p); }, bodies);
  for (const SweptBody& body : bodies) {
    bool meets = false;
    for (std::size_t b = 0; b < stock_.bundles.size(); ++b) {
      const auto [first, last] = stock_.bundles[b].stripes(body);
      for (int s = first; s < last; ++s)
        out.by_stripe[b * Dexels::kStripes + s].push_back(static_cast<std::uint32_t>(out.pieces.size()));
      meets |= first < last;
    }
    if (meets) out.pieces.push_back({step.move, body});
  }
}

void Stand::sweep_moves(std::size_t begin, std::size_t end, Swept& out) const {
  out.by_stripe.resize(stock_.bundles.size() * Dexels::kStripes);
  std::vector<SweptStep> steps;
  Pose at = chain_(path_.from(begin));
  for (std::size_t m = begin; m < end; ++m) {
    add_steps(m, at, steps);
    at = steps.back().to;
  }
  const Contacts contacts = contact_.meet(steps);
  const auto hit = [&](const Overlap& o) {
    return MoveHit{path_.moves[o.move].rapid ? TroubleKind::kRapidPart : TroubleKind::kGouge,
                   o.tool,
                   o.move,
                   o.depth,
                   probes_.patches().mesh.source[o.patch],
                   o.place};
  };
  for (std::size_t k = 0; k < out.worst.size(); ++k)
    if (contacts.worst[k].depth > 0.0) out.worst[k] = hit(contacts.worst[k]);
  for (const Overlap& o : contacts.overlaps) out.hits.push_back(hit(o));
  std::vector<SweptBody> bodies;
  double way = 0.0;  // of the move
  for (const SweptStep& step : steps) {
    if (step.begin == 0.0) way = 0.0;
    way += distance(step.from.tip, step.to.tip);
    if (step.end == 1.0) {
      (path_.moves[step.move].rapid ? out.rapid_length : out.feed_length) += way;
      time(step.move, way, step.to.tip, out.haste);
    }
    share_out(step, bodies, out);
  }
}

}  // namespace tiltfeed::sim
