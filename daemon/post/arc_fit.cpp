#include "daemon/post/arc_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "daemon/post/dialect.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/basics/units.h"

namespace tiltfeed::daemon {
namespace {

// Blocks of one arc, at most: what one look at it costs is bounded.
constexpr std::size_t kMostArcBlocks = 4096;
// Blocks of one feed differ in speed by this share, and by what their ends are rounded.
constexpr double kSameSpeed = 0.02;
// The printed centre is looked for among so many last digits to each side.
constexpr int kCentreDigits = 2;

struct Flat {
  double u = 0.0, v = 0.0;
};
Flat operator-(Flat p, Flat q) { return {p.u - q.u, p.v - q.v}; }
Flat operator+(Flat p, Flat q) { return {p.u + q.u, p.v + q.v}; }
Flat operator*(Flat p, double f) { return {p.u * f, p.v * f}; }
double dot(Flat p, Flat q) { return p.u * q.u + p.v * q.v; }
double cross(Flat p, Flat q) { return p.u * q.v - p.v * q.u; }
double length(Flat p) { return std::hypot(p.u, p.v); }

/// From the centre: how near a straight block comes to it.
double nearest(Flat p, Flat q) {
  const Flat way = q - p;
  const double square = dot(way, way);
  const double share = square > 0.0 ? std::clamp(-dot(p, way) / square, 0.0, 1.0) : 0.0;
  return length(p + way * share);
}

/// An arc through some blocks, judged.
struct Judged {
  double off = 0.0;    ///< the largest distance of the two ways, mm
  double turn = 0.0;   ///< radians, below 0 clockwise
  double start = 0.0;  ///< its radius, mm
};

class Fitter {
 public:
  Fitter(const JointPath& words, const ArcBreaks& breaks, const config::ProgramFormat& format,
         double tolerance)
      : moves_(words.moves),
        format_(format),
        planes_(table_of(format.dialect).arc_planes ? 3 : 1),
        tolerance_(tolerance),
        digit_(config::unit_of(format) / decimal_scale(format.linear_decimals)) {
    find_breaks(breaks);
  }
  ArcFit run();

 private:
  struct Found {
    PrintedArc arc;
    std::size_t blocks = 0;
    double seconds = 0.0;
  };
  void find_breaks(const ArcBreaks& breaks);
  std::size_t reach(std::size_t first) const;
  bool even_speed(std::size_t first, std::size_t blocks) const;
  void gather(std::size_t first, std::size_t blocks, const ArcAxes& axes);
  std::optional<Flat> centre() const;
  std::optional<Judged> judge(Flat from_start) const;
  std::optional<Found> fit(std::size_t first, std::size_t blocks, int plane);
  std::optional<Found> longest(std::size_t first, std::size_t most, int plane);

  const std::vector<JointMove>& moves_;
  const config::ProgramFormat& format_;
  const int planes_;
  const double tolerance_, digit_;
  std::vector<bool> breaks_;  ///< before a move
  Joints from_;               ///< where the next move begins
  // Of the arc that is looked at: its places from the first, and what the third axis strays by.
  std::vector<Flat> places_;
  double third_ = 0.0;
  double begins_off_ = 0.0;  ///< by how much it begins beside the block before: an arc there has left that
};

/// An event or a feed is of the first block whose move is not before it.
void Fitter::find_breaks(const ArcBreaks& breaks) {
  breaks_.assign(moves_.size(), false);
  auto event = breaks.events.begin();
  auto feed = breaks.feeds.begin();
  for (std::size_t i = 0; i < moves_.size(); ++i) {
    for (; event != breaks.events.end() && event->move <= moves_[i].move; ++event) breaks_[i] = true;
    for (; feed != breaks.feeds.end() && feed->move <= moves_[i].move; ++feed) breaks_[i] = true;
    const Joints &to = moves_[i].joints, &from = i > 0 ? moves_[i - 1].joints : to;
    if (i == 0 || moves_[i].kind == MoveKind::kRapid || moves_[i].kind != moves_[i - 1].kind ||
        to.a != from.a || to.c != from.c)
      breaks_[i] = true;
  }
}

/// So many blocks from `first` may be in one arc, at most.
std::size_t Fitter::reach(std::size_t first) const {
  const Joints &to = moves_[first].joints, &from = moves_[first - 1].joints;
  if (moves_[first].kind == MoveKind::kRapid || to.a != from.a || to.c != from.c) return 0;
  std::size_t last = first + 1;
  while (last < moves_.size() && !breaks_[last] && last - first < kMostArcBlocks) ++last;
  return last - first;
}

bool Fitter::even_speed(std::size_t first, std::size_t blocks) const {
  double slow = 0.0, fast = std::numeric_limits<double>::infinity();
  for (std::size_t i = first; i < first + blocks; ++i) {
    const Joints &p = moves_[i - 1].joints, &q = moves_[i].joints;
    const double way = std::hypot(q.x - p.x, q.y - p.y, q.z - p.z), seconds = moves_[i].seconds;
    if (!(seconds > 0.0)) return false;
    slow = std::max(slow, (way * (1.0 - kSameSpeed) - 2.0 * digit_) / seconds);
    fast = std::min(fast, (way * (1.0 + kSameSpeed) + 2.0 * digit_) / seconds);
  }
  return slow <= fast;
}

void Fitter::gather(std::size_t first, std::size_t blocks, const ArcAxes& axes) {
  const auto flat = [&](const Joints& at) { return Flat{at.*axes.first, at.*axes.second}; };
  const Flat start = flat(from_);
  places_.assign(1, Flat{});
  third_ = 0.0;
  const Joints& stated = moves_[first - 1].joints;
  begins_off_ = std::hypot(from_.x - stated.x, from_.y - stated.y, from_.z - stated.z);
  for (std::size_t i = first; i < first + blocks; ++i) {
    const Joints& at = moves_[i].joints;
    third_ = std::max(third_, std::abs(at.*axes.third - from_.*axes.third));
    places_.push_back(flat(at) - start);
  }
}

/// On the line that halves the chord: where the ends of the blocks and the middles between them are as near
/// to the circle as can be, by least squares.
std::optional<Flat> Fitter::centre() const {
  const Flat end = places_.back(), middle = end * 0.5;
  const double chord = length(end);
  if (!(chord > 0.0)) return std::nullopt;
  const Flat across = Flat{-end.v, end.u} * (1.0 / chord);
  const double half2 = 0.25 * chord * chord;
  double sum = 0.0, square = 0.0;
  const auto take = [&](Flat place) {
    const Flat p = place - middle;
    const double s = dot(across, p);
    sum += (dot(p, p) - half2) * s, square += s * s;
  };
  for (std::size_t i = 1; i < places_.size(); ++i) {
    take((places_[i - 1] + places_[i]) * 0.5);
    if (i + 1 < places_.size()) take(places_[i]);
  }
  if (!(square > 0.0)) return std::nullopt;
  const Flat centre = middle + across * (sum / (2.0 * square));
  if (!(length(centre) <= kMostArcRadius)) return std::nullopt;
  return centre;
}

/// With this centre; nothing: the blocks do not go round it, or too far.
std::optional<Judged> Fitter::judge(Flat from_start) const {
  const double start = length(from_start), end = length(places_.back() - from_start);
  if (std::abs(end - start) > kMostArcRadiusError || start < kLeastArcRadius) return std::nullopt;
  const auto off = [&](double far) { return std::max(std::abs(far - start), std::abs(far - end)); };
  Judged judged;
  judged.start = start;
  double flat = 0.0;
  for (std::size_t i = 1; i < places_.size(); ++i) {
    const Flat p = places_[i - 1] - from_start, q = places_[i] - from_start;
    const double turn = std::atan2(cross(p, q), dot(p, q));
    if (turn == 0.0 || turn * judged.turn < 0.0) return std::nullopt;
    judged.turn += turn;
    flat = std::max({flat, off(length(q)), off(nearest(p, q))});
  }
  if (std::abs(judged.turn) > Angle::from_degrees(kMostArcTurn).radians()) return std::nullopt;
  judged.off = std::hypot(flat, third_) + begins_off_;
  return judged;
}

std::optional<Fitter::Found> Fitter::fit(std::size_t first, std::size_t blocks, int plane) {
  gather(first, blocks, arc_axes(plane));
  const auto ideal = centre();
  if (!ideal || !even_speed(first, blocks)) return std::nullopt;
  // A centre between two last digits may be better than any that is printed, by as much as that.
  if (const auto rough = judge(*ideal); !rough || rough->off > tolerance_) return std::nullopt;
  std::optional<Judged> best;
  Flat at;
  for (int i = -kCentreDigits; i <= kCentreDigits; ++i)
    for (int j = -kCentreDigits; j <= kCentreDigits; ++j) {
      const Flat printed{config::printed_place(format_, ideal->u + i * digit_),
                         config::printed_place(format_, ideal->v + j * digit_)};
      const auto judged = judge(printed);
      if (judged && judged->off <= tolerance_ && (!best || judged->off < best->off))
        best = judged, at = printed;
    }
  if (!best) return std::nullopt;
  Found found;
  found.blocks = blocks;
  double straight = 0.0;
  for (std::size_t i = 1; i < places_.size(); ++i) {
    found.seconds += moves_[first + i - 1].seconds;
    straight += length(places_[i] - places_[i - 1]);
  }
  const double end = length(places_.back() - at);
  found.arc = {0,
               static_cast<std::uint32_t>(blocks),
               plane,
               best->turn < 0.0,
               at.u,
               at.v,
               std::abs(best->turn) * 0.5 * (best->start + end)};
  found.seconds *= found.arc.length / straight;
  return found;
}

/// The most blocks from `first` that are one arc: doubled while they fit, then halved to the last that do.
std::optional<Fitter::Found> Fitter::longest(std::size_t first, std::size_t most, int plane) {
  std::size_t fits = kLeastArcBlocks, fails = most + 1;
  auto best = fit(first, fits, plane);
  if (!best) return std::nullopt;
  while (fits < fails - 1) {
    const std::size_t next = fails == most + 1 ? std::min(2 * fits, most) : (fits + fails) / 2;
    if (auto found = fit(first, next, plane))
      best = found, fits = next;
    else
      fails = next;
  }
  // What a straight line does as well stays as it is.
  const double radius = std::hypot(best->arc.first, best->arc.second);
  const double height = radius * (1.0 - std::cos(0.5 * best->arc.length / radius));
  return height > tolerance_ ? best : std::nullopt;
}

ArcFit Fitter::run() {
  ArcFit fitted;
  fitted.words.moves.reserve(moves_.size());
  if (moves_.empty()) return fitted;
  fitted.words.moves.push_back(moves_.front());
  from_ = moves_.front().joints;
  for (std::size_t i = 1; i < moves_.size();) {
    const std::size_t most = reach(i);
    std::optional<Found> best;
    for (int plane = 17; plane < 17 + planes_ && most >= kLeastArcBlocks; ++plane)
      if (auto found = longest(i, most, plane); found && (!best || found->blocks > best->blocks))
        best = found;
    JointMove move = moves_[best ? i + best->blocks - 1 : i];
    if (best) {
      const ArcAxes axes = arc_axes(best->arc.plane);
      move.joints.*axes.third = from_.*axes.third;
      move.seconds = best->seconds;
      best->arc.block = fitted.words.moves.size();
      fitted.arcs.push_back(best->arc);
    }
    i += best ? best->blocks : 1;
    // After an arc a block may have nothing left to do.
    if (!best && move.kind != MoveKind::kRapid && move.joints == from_) continue;
    from_ = move.joints;
    fitted.words.moves.push_back(move);
  }
  return fitted;
}

}  // namespace

ArcFit fit_arcs(const JointPath& words, const ArcBreaks& breaks, const config::ProgramFormat& format,
                double tolerance) {
  ArcFit fitted = Fitter(words, breaks, format, tolerance).run();
  fitted.words.report = words.report;
  return fitted;
}

void put_arcs(Operation& op, const config::ProgramFormat& format, double tolerance,
              std::vector<std::unique_ptr<JointPath>>& words) {
  const bool shifted = std::any_of(op.events.begin(), op.events.end(), [](const PathEvent& event) {
    return event.kind == EventKind::kCutterLeft || event.kind == EventKind::kCutterRight ||
           event.kind == EventKind::kPlane;
  });
  if (!(tolerance > 0.0) || format.tcp || shifted) return;
  ArcFit fitted = fit_arcs(*op.words, {op.feeds, op.events}, format, tolerance);
  if (fitted.arcs.empty()) return;
  words.push_back(std::make_unique<JointPath>(std::move(fitted.words)));
  op.words = words.back().get();
  op.arcs = std::move(fitted.arcs);
}

}  // namespace tiltfeed::daemon
