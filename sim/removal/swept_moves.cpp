#include "sim/removal/swept_moves.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/motion/forward.h"

namespace tiltfeed::sim {
namespace {

// A straight step may leave the way of the tip by this share of the tolerance.
constexpr double kStrayTolerances = 0.2;
// Steps that follow each other are taken as one by the stock, if all of them are so near to it.
constexpr double kRunTolerances = 0.5;
// And the way of the tool's upper end, and the turn of a piece of it, by this share of a cell.
constexpr double kStrayCells = 0.125;
// Longer ways, in least radii or cells, are cut up, so that bodies stay near what they are long for.
constexpr double kStepWays = 4.0;
constexpr int kMostStepsPerMove = 20000;
// Above this the surface winds round the point: inside.
constexpr double kInside = 0.5;
// The words are rounded, and so is F: this much way, mm, and this share of it, may be more than F makes.
constexpr double kFeedSlack = 0.005, kFeedShare = 0.05;

}  // namespace

void Haste::take(const Haste& other) {
  const std::uint64_t all = moves + other.moves;
  if (other.ahead > ahead) *this = other;
  moves = all;
}

Stand::Stand(const config::Job& job, const ExecutedPath& path, const Stock& stock, Probes& probes,
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
      feed_(std::max({job.feeds.highest.mm_per_min(), job.plan.cut_feed.mm_per_min(),
                      job.plan.plunge_feed.mm_per_min()})),
      stock_alone_(options.stock_alone) {}

/// In how many parts of the turn no piece of the tool is off by more than what the upper end may be.
double Stand::turn_pieces(const Pose& from, const Pose& to) const {
  return angle_between(from.axis, to.axis) * sweep_.longest() / 4.0 / (kStrayCells * cell_);
}

/// A curve that strays by d from its chord strays by d / n^2 from n chords.
void Stand::add_steps(std::size_t move, const Pose& from, std::vector<SweptStep>& steps) const {
  const Joints &start = path_.from(move), &end = path_.moves[move].to;
  const Pose middle = chain_(between(start, end, 0.5)), to = chain_(end);
  const auto stray = [&](double h) {
    return distance(on_axis(middle, h), lerp(on_axis(from, h), on_axis(to, h), 0.5));
  };
  const auto way = [&](double h) {
    return distance(on_axis(from, h), on_axis(middle, h)) + distance(on_axis(middle, h), on_axis(to, h));
  };
  const double low = std::max(stray(0.0), stray(sweep_.core_low())), top = stray(top_);
  const double pieces = std::max(way(0.0), way(top_)) / (kStepWays * std::max(least_, cell_));
  const int count = static_cast<int>(
      std::ceil(std::clamp(std::max({std::sqrt(low / (kStrayTolerances * tolerance_)),
                                     std::sqrt(top / (kStrayCells * cell_)), turn_pieces(from, to), pieces}),
                           1.0, 1.0 * kMostStepsPerMove)));
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
  if (stock_alone_) return std::nullopt;
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

/// Where the steps end that the cutter makes one straight sweep of with that of `begin`: between its first
/// and last pose a tool that strays little from the sheet of its axis passes all of the sheet.
std::size_t Stand::run_end(const std::vector<SweptStep>& steps, std::size_t begin) const {
  const auto rapid = [&](std::size_t i) { return path_.moves[steps[i].move].rapid; };
  std::size_t end = begin + 1;
  if (rapid(begin)) return end;
  const double low = sweep_.core_low(), side = kStepWays * std::max(least_, cell_);
  const Pose& from = steps[begin].from;
  const Point<Part> foot = on_axis(from, low), top = on_axis(from, top_);
  const Cube where = cube_at(foot, side);
  for (; end < steps.size() && !rapid(end) && cube_at(on_axis(steps[end].from, low), side) == where; ++end) {
    const Pose& to = steps[end].to;
    const Point<Part> last_foot = on_axis(to, low), last_top = on_axis(to, top_);
    if (turn_pieces(from, to) > 1.0) break;
    const bool straight = std::all_of(&steps[begin], &steps[end], [&](const SweptStep& s) {
      return distance_to_segment(on_axis(s.to, low), foot, last_foot) <= kRunTolerances * tolerance_ &&
             distance_to_segment(on_axis(s.to, top_), top, last_top) <= kStrayCells * cell_;
    });
    if (!straight) break;
  }
  return end;
}

/// What the tool sweeps of the stock: the cutter in runs, shank and holder, which may touch nothing, step by
/// step.
void Stand::sweep_stock(const std::vector<SweptStep>& steps, Swept& out) const {
  std::vector<SweptBody> bodies;
  const auto clear = [&](Point<Part> p) { return occupied_.clear(p); };
  for (std::size_t begin = 0; begin < steps.size();) {
    const std::size_t end = run_end(steps, begin);
    const std::uint32_t first = steps[begin].move, moves = steps[end - 1].move - first + 1;
    bodies.clear();
    sweep_.cutter_bodies(steps[begin].from, steps[end - 1].to, clear, bodies);
    share_out(first, moves, bodies, out);
    for (; begin < end; ++begin) {
      bodies.clear();
      sweep_.rest_bodies(steps[begin].from, steps[begin].to, bodies);
      share_out(steps[begin].move, 1, bodies, out);
    }
  }
}

void Stand::share_out(std::uint32_t first_move, std::uint32_t moves, const std::vector<SweptBody>& bodies,
                      Swept& out) const {
  for (const SweptBody& body : bodies) {
    bool meets = false;
    for (std::size_t b = 0; b < stock_.bundles.size(); ++b) {
      const auto [first, last] = stock_.bundles[b].stripes(body);
      for (int s = first; s < last; ++s)
        out.by_stripe[b * Dexels::kStripes + s].push_back(static_cast<std::uint32_t>(out.pieces.size()));
      meets |= first < last;
    }
    if (meets) out.pieces.push_back({first_move, moves, body});
  }
}

void Stand::sweep_moves(std::size_t begin, std::size_t end, Swept& out) const {
  out.by_stripe.resize(stock_.bundles.size() * Dexels::kStripes);
  std::vector<SweptStep> steps;
  Pose last = chain_(path_.from(begin));
  for (std::size_t m = begin; m < end; ++m) {
    add_steps(m, last, steps);
    last = steps.back().to;
  }
  const Contacts contacts = stock_alone_ ? Contacts{} : contact_.meet(steps);
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
  sweep_stock(steps, out);
  double way = 0.0;  // of the move
  for (const SweptStep& step : steps) {
    if (step.begin == 0.0) way = 0.0;
    way += distance(step.from.tip, step.to.tip);
    if (step.end == 1.0) {
      out.ways.push_back(way);
      time(step.move, way, step.to.tip, out.haste);
    }
  }
}

}  // namespace tiltfeed::sim
