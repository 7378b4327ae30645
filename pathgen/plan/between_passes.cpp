#include "pathgen/plan/between_passes.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "pathgen/options/side_step.h"

namespace tiltfeed::pathgen {

namespace {

/// Cells are as wide as so many steps, and no smaller than this share of the tool's radius.
constexpr double kSteps = 2.0, kSmallestCell = 0.125;
/// The least distance along a move is found to this share of the move.
constexpr double kShare = 1e-3;
/// Bits of a cell's number along each axis, and its middle.
constexpr int kBits = 21;
constexpr std::int64_t kMiddle = std::int64_t{1} << (kBits - 1);
/// Cells of a block along each axis, as a power of two.
constexpr int kBlockBits = 2;

std::uint64_t packed(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto part = [](std::int64_t v) {
    return static_cast<std::uint64_t>(std::clamp<std::int64_t>(v + kMiddle, 0, 2 * kMiddle - 1));
  };
  return part(x) << (2 * kBits) | part(y) << kBits | part(z);
}

/// Of the cell with that number.
std::uint64_t block_of(std::uint64_t cell) {
  const auto index = [&](int axis) {
    return (static_cast<std::int64_t>((cell >> (axis * kBits)) & ((std::uint64_t{1} << kBits) - 1)) -
            kMiddle) >>
           kBlockBits;
  };
  return packed(index(2), index(1), index(0));
}

}  // namespace

bool leaves_no_more(const PlanOptions& options) {
  return options.pattern.kind != PatternKind::kPencil && options.rest_more_than == 0.0;
}

double asked_height(const PlanOptions& options) {
  const Pattern& pattern = options.pattern;
  if (pattern.measure == StepMeasure::kScallop) return pattern.scallop;
  if (pattern.kind == PatternKind::kRough) return pattern.step_down;
  if (!leaves_no_more(options)) return options.cutter.radius();
  const bool levels = pattern.kind == PatternKind::kZLevel || pattern.kind == PatternKind::kSplit;
  const double step = std::max(pattern.side_step, levels ? pattern.step_down : 0.0),
               radius = options.cutter.radius(), half = std::min(step / 2.0, radius);
  const double times = pattern.measure == StepMeasure::kSurface ? 2.0 : 4.0;
  return std::min(radius, times * (radius - std::sqrt(radius * radius - half * half)));
}

CuttingMoves::CuttingMoves(const std::vector<Move>& moves, const ToolPiece& piece, double reference_height,
                           double step)
    : moves_(moves),
      piece_(piece),
      height_(reference_height),
      size_(std::max(kSteps * step, kSmallestCell * piece.outer)),
      farthest_(piece.outer),
      widest_search_(2.0 * piece.outer + size_) {
  for (std::size_t i = 1; i < moves.size(); ++i)
    if (moves[i].kind == MoveKind::kCut) take(i);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order(ways_.size());
  tbb::parallel_for(std::size_t{0}, ways_.size(), [&](std::size_t i) {
    const Way& way = ways_[i];
    const double middle = 0.5 * (static_cast<double>(way.begin) + static_cast<double>(way.end));
    order[i] = {cell_of(lerp(reference(way.move - 1), reference(way.move), middle)),
                static_cast<std::uint32_t>(i)};
  });
  for (const auto& [cell, way] : order) blocks_.insert(block_of(cell));
  tbb::parallel_sort(order.begin(), order.end());
  std::vector<Way> placed(ways_.size());
  std::size_t cells = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    placed[i] = ways_[order[i].second];
    cells += i == 0 || order[i].first != order[i - 1].first ? 1 : 0;
  }
  ways_ = std::move(placed);
  middles_.resize(ways_.size());
  tbb::parallel_for(std::size_t{0}, ways_.size(), [&](std::size_t i) { middles_[i] = middle_of(ways_[i]); });
  slots_.resize(std::bit_ceil(2 * cells + 2));
  for (std::size_t i = 0, next = 0; i < order.size(); i = next) {
    while (next < order.size() && order[next].first == order[i].first) ++next;
    Slot& slot = slots_[static_cast<std::size_t>(&find(order[i].first) - slots_.data())];
    slot = {order[i].first, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(next - i)};
  }
}

Point<Part> CuttingMoves::reference(std::size_t move) const {
  const Pose& pose = moves_[move].pose;
  return pose.tip + pose.axis * height_;
}

void CuttingMoves::take(std::size_t move) {
  const double pieces = std::max(1.0, std::ceil(distance(reference(move - 1), reference(move)) / size_));
  for (double i = 0.0; i < pieces; ++i)
    ways_.push_back({static_cast<std::uint32_t>(move), static_cast<float>(i / pieces),
                     static_cast<float>((i + 1.0) / pieces)});
}

std::uint64_t CuttingMoves::cell_of(Point<Part> p) const {
  const auto index = [&](double v) { return static_cast<std::int64_t>(std::floor(v / size_)); };
  return packed(index(p.x), index(p.y), index(p.z));
}

/// The cell's slot, or the free one where it would be.
const CuttingMoves::Slot& CuttingMoves::find(std::uint64_t cell) const {
  // Mixed as by splitmix64 [Steele, Lea, Flood 2014].
  std::uint64_t key = (cell ^ (cell >> 30)) * 0xBF58476D1CE4E5B9u;
  key = (key ^ (key >> 27)) * 0x94D049BB133111EBu;
  std::size_t i = (key ^ (key >> 31)) & (slots_.size() - 1);
  while (slots_[i].count > 0 && slots_[i].cell != cell) i = (i + 1) & (slots_.size() - 1);
  return slots_[i];
}

CuttingMoves::Middle CuttingMoves::middle_of(const Way& way) const {
  const Pose &from = moves_[way.move - 1].pose, &to = moves_[way.move].pose;
  const double low = static_cast<double>(way.begin), half = 0.5 * (static_cast<double>(way.end) - low),
               share = low + half;
  const Vec3 axis = normalized(from.axis * (1.0 - share) + to.axis * share);
  return {lerp(from.tip, to.tip, share) + axis * (height_ + piece_.above_reference), axis,
          half * distance(from.tip, to.tip), kTurnOfChord * half * length(to.axis - from.axis)};
}

/// Seen from the tool the place moves from the middle of the way by no more than its tip and its turn do, mm.
double CuttingMoves::moves_by(Point<Part> place, const Middle& middle) const {
  if (middle.turn <= 0.0) return middle.way;
  return middle.way + middle.turn * (distance(place, middle.ring) +
                                     std::abs(height_ + piece_.above_reference) + middle.way);
}

/// No tool on that way is nearer.
double CuttingMoves::least_gap(Point<Part> place, const Middle& middle) const {
  const Vec3 w = place - middle.ring;
  const double h = dot(w, middle.axis);
  return distance_to_piece(piece_, std::sqrt(std::max(0.0, squared_length(w) - h * h)), h) -
         moves_by(place, middle);
}

double CuttingMoves::gap(Point<Part> place, const Way& way, const Middle& middle, double least) const {
  const Pose &from = moves_[way.move - 1].pose, &to = moves_[way.move].pose;
  const auto at = [&](double share) {
    const Vec3 axis = normalized(from.axis * (1.0 - share) + to.axis * share);
    const Vec3 w = place - (lerp(from.tip, to.tip, share) + axis * (height_ + piece_.above_reference));
    const double h = dot(w, axis);
    return std::pair(distance_to_piece(piece_, std::sqrt(std::max(0.0, squared_length(w) - h * h)), h), h);
  };
  double low = static_cast<double>(way.begin), high = static_cast<double>(way.end);
  if (piece_.is_ball_at_reference()) {
    const Point<Part> a = from.tip + from.axis * height_;
    const Vec3 along = to.tip + to.axis * height_ - a;
    const double square = squared_length(along);
    const double share = square > 0.0 ? std::clamp(dot(place - a, along) / square, low, high) : low;
    if (const auto [distance, h] = at(share); h < 0.0) return distance;
  }
  // Convex along the move but for the little that the axis turns.
  const double least_at_ends = std::min(at(low).first, at(high).first);
  // The axis turns a little faster where it is half way.
  const double exact = kShare * (high - low),
               rate = kTurnOfChord * 2.0 * moves_by(place, middle) / (high - low);
  while (high - low > exact) {
    const double third = (high - low) / 3.0, a = low + third, b = high - third;
    const double at_a = at(a).first, at_b = at(b).first, nearest = std::min(at_a, at_b);
    // Nowhere is further than a third from one of them.
    if (nearest - rate * third >= least && least_at_ends >= least) return nearest;
    (at_a <= at_b ? high : low) = at_a <= at_b ? b : a;
  }
  return std::min(at(low).first, least_at_ends);
}

/// No move with its reference further than `radius` from where the tool touches a place leaves less there.
double CuttingMoves::unseen(double radius) const {
  const double beyond = radius - 2.0 * piece_.flat;
  return beyond <= 0.0 ? 0.0 : std::hypot(piece_.corner, beyond) - piece_.corner;
}

double CuttingMoves::left(Point<Part> place, Point<Part> touching, double enough) const {
  double least = farthest_;
  const auto look = [&](std::uint64_t cell) {
    const Slot& slot = find(cell);
    for (std::uint32_t i = slot.first; i < slot.first + slot.count && least > enough; ++i)
      if (least_gap(place, middles_[i]) < least)
        least = std::min(least, gap(place, ways_[i], middles_[i], least));
  };
  const auto index = [&](double v) { return static_cast<std::int64_t>(std::floor(v / size_)); };
  look(cell_of(touching));
  using Cell = std::array<std::int64_t, 3>;
  Cell seen_low = {index(touching.x), index(touching.y), index(touching.z)}, seen_high = seen_low;
  for (double radius = size_ / 2.0; least > enough; radius = std::min(2.0 * radius, widest_search_)) {
    const double reach = radius + size_ / 2.0;
    const Cell low{index(touching.x - reach), index(touching.y - reach), index(touching.z - reach)},
        high{index(touching.x + reach), index(touching.y + reach), index(touching.z + reach)};
    // Block by block, as most of them have no way.
    for (auto i = low[0] >> kBlockBits; i <= high[0] >> kBlockBits; ++i)
      for (auto j = low[1] >> kBlockBits; j <= high[1] >> kBlockBits; ++j)
        for (auto k = low[2] >> kBlockBits; k <= high[2] >> kBlockBits; ++k) {
          if (!blocks_.contains(packed(i, j, k))) continue;
          const auto first = [&](std::size_t axis, std::int64_t block) {
            return std::max(low[axis], block << kBlockBits);
          };
          const auto last = [&](std::size_t axis, std::int64_t block) {
            return std::min(high[axis], ((block + 1) << kBlockBits) - 1);
          };
          for (auto x = first(0, i); x <= last(0, i); ++x)
            for (auto y = first(1, j); y <= last(1, j); ++y)
              for (auto z = first(2, k); z <= last(2, k); ++z) {
                const bool again = x >= seen_low[0] && x <= seen_high[0] && y >= seen_low[1] &&
                                   y <= seen_high[1] && z >= seen_low[2] && z <= seen_high[2];
                if (!again) look(packed(x, y, z));
              }
        }
    seen_low = low, seen_high = high;
    if (least <= unseen(radius) || radius >= widest_search_) break;
  }
  return least;
}

}  // namespace tiltfeed::pathgen
