#include "pathgen/stock/stock_on_cuts.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

/// Lines stand a share of the smallest cutter's diameter apart, and are so many along a side at most.
constexpr double kApartShare = 0.1, kMostLines = 1500.0;
/// Of their distance: less than this deep is none.
constexpr double kTouchShare = 0.4;
/// Of their distance: ridges that poses one behind the other leave, at most.
constexpr double kRidgeShare = 0.2;
/// Of the cutter's radius: poses are no further apart, and shank and holder are not looked at oftener within
/// a straight move.
constexpr double kPoseShare = 0.5;
constexpr double kTouchTolerances = 2.0;
/// Poses that are taken at a time.
constexpr std::size_t kBatch = 2048;

int main_direction(const std::vector<ToolMoves>& operations) {
  Vec3 sum;
  for (const ToolMoves& one : operations)
    for (const Move& move : *one.moves)
      if (move.kind != MoveKind::kRapid)
        sum = sum + Vec3{std::abs(move.pose.axis.x), std::abs(move.pose.axis.y), std::abs(move.pose.axis.z)};
  return sum.z >= sum.x && sum.z >= sum.y ? 2 : sum.y >= sum.x ? 1 : 0;
}

double lines_apart(const Mesh& blank, const std::vector<ToolMoves>& operations) {
  Box box{blank.vertices.front(), blank.vertices.front()};
  for (const Point<Part>& p : blank.vertices) box = grown(box, p);
  const Vec3 size = box.max - box.min;
  double least = 1e300;
  for (const ToolMoves& one : operations) least = std::min(least, kApartShare * one.cutter->diameter);
  return std::max(least, std::max({size.x, size.y, size.z}) / kMostLines);
}

/// Poses along the feed moves, near enough to each other.
class Poses {
 public:
  struct Sample {
    Pose pose;
    double way = 0.0;   ///< of the tip on feed moves up to there, mm
    bool looks = true;  ///< for shank and holder in stock
  };
  Poses(const ToolMoves& of, double apart)
      : moves_(*of.moves),
        top_(of.cutter->cutting_end()),
        apart_(apart),
        look_(kPoseShare * of.cutter->radius()),
        step_(std::min(look_, std::sqrt(8.0 * kRidgeShare * apart * of.cutter->radius()))) {}

  /// Appends so many at most. False: there are none.
  bool next(std::size_t count, std::vector<Sample>& out) {
    while (move_ < moves_.size() && out.size() < count) {
      if (moves_[move_].kind == MoveKind::kRapid) {
        ++move_, fresh_ = true;
        continue;
      }
      const Pose &from = moves_[move_ - 1].pose, &to = moves_[move_].pose;
      const double way = distance(from.tip, to.tip), turn = angle_between(from.axis, to.axis);
      if (fresh_) out.push_back({from, way_, true}), fresh_ = false, since_ = 0.0;
      const bool last = move_ + 1 == moves_.size() || moves_[move_ + 1].kind != moves_[move_].kind;
      since_ += way + top_ * turn;
      way_ += way;
      ++move_;
      if (since_ < apart_ && !last) continue;
      const double steps = std::max(1.0, std::ceil((way + top_ * turn) / step_)),
                   each = std::floor(look_ / step_);
      for (double k = 1.0; k <= steps; ++k)
        out.push_back({{lerp(from.tip, to.tip, k / steps), slerp(from.axis, to.axis, k / steps)},
                       way_ - way * (1.0 - k / steps),
                       k == steps || std::fmod(k, each) == 0.0});
      since_ = 0.0;
    }
    return !out.empty();
  }
  double share() const { return static_cast<double>(move_) / static_cast<double>(moves_.size()); }

 private:
  const std::vector<Move>& moves_;
  double top_, apart_, look_, step_;  ///< mm
  std::size_t move_ = 1;
  double way_ = 0.0, since_ = 0.0;  ///< mm; since the last pose
  bool fresh_ = true;               ///< a rapid was before
};

/// All of the tool at each pose, solid after solid.
void place(const std::vector<Poses::Sample>& samples, const std::vector<RoundSolid>& solids, int along,
           std::vector<PlacedSolid>& placed) {
  placed.clear(), placed.reserve(samples.size() * solids.size());
  for (const Poses::Sample& sample : samples)
    for (const RoundSolid& solid : solids) placed.emplace_back(solid, sample.pose, along);
}

/// Adds what is found of one part of the tool.
class Stretches {
 public:
  Stretches(double diameter, StockContact& found) : diameter_(diameter), found_(found) {}
  void take(const Pose& pose, double way, double depth) {
    if (depth > found_.depth) found_.depth = depth, found_.at = pose;
    if (!last_ || way - *last_ > diameter_)
      ++found_.places;
    else
      found_.length += way - *last_;
    last_ = way;
  }

 private:
  double diameter_;
  StockContact& found_;
  std::optional<double> last_;
};

}  // namespace

StockLeft::StockLeft(const Mesh& blank, const std::vector<ToolMoves>& operations)
    : lines_(blank, main_direction(operations), lines_apart(blank, operations)) {}

/// What shank and holder have gone through is no longer there for the next operation.
void StockLeft::take_met() {
  tbb::parallel_for(std::size_t{0}, lines_.rows(), [&](std::size_t row) {
    for (const auto& [solid, pose] : met_)
      if (const PlacedSolid placed(met_solids_[solid], pose, lines_.along()); lines_.in_row(row, placed))
        lines_.cut(row, placed);
  });
  met_.clear();
}

void StockLeft::clear(const ToolMoves& operation) {
  take_met();
  const std::vector<RoundSolid> solids = round_solids(*operation.cutter);
  std::vector<Poses::Sample> samples;
  std::vector<PlacedSolid> placed;
  Poses poses(operation, lines_.apart());
  while (samples.clear(), poses.next(kBatch, samples)) {
    place(samples, solids, lines_.along(), placed);
    tbb::parallel_for(std::size_t{0}, lines_.rows(), [&](std::size_t row) {
      for (const PlacedSolid& one : placed)
        if (lines_.in_row(row, one)) lines_.cut(row, one);
    });
  }
}

std::optional<StockOnCuts> StockLeft::cut(const ToolMoves& operation, const ReportShare& report) {
  take_met();
  met_solids_ = round_solids(*operation.cutter);
  const std::vector<RoundSolid>& solids = met_solids_;
  const std::size_t count = solids.size();
  StockOnCuts found{
      lines_.apart(), std::max(kTouchShare * lines_.apart(), kTouchTolerances * operation.tolerance), {}, {}};
  Stretches shank(operation.cutter->diameter, found.shank), holder(operation.cutter->diameter, found.holder);
  struct Touch {
    std::size_t placed = 0;
    double depth = 0.0;
  };
  std::vector<std::vector<Touch>> touches(lines_.rows());
  std::vector<Poses::Sample> samples;
  std::vector<PlacedSolid> placed;
  std::vector<double> depths;
  Poses poses(operation, lines_.apart());
  while (samples.clear(), poses.next(kBatch, samples)) {
    if (report && !report(poses.share())) return std::nullopt;
    place(samples, solids, lines_.along(), placed);
    tbb::parallel_for(std::size_t{0}, lines_.rows(), [&](std::size_t row) {
      touches[row].clear();
      for (std::size_t i = 0; i < placed.size(); ++i) {
        if (!lines_.in_row(row, placed[i])) continue;
        if (i % count == 0)
          lines_.cut(row, placed[i]);
        else if (!samples[i / count].looks)
          continue;
        else if (const double deep = lines_.deepest(row, placed[i]); deep > found.touch)
          touches[row].push_back({i, deep});
      }
    });
    depths.assign(placed.size(), 0.0);
    for (const auto& row : touches)
      for (const Touch& one : row) depths[one.placed] = std::max(depths[one.placed], one.depth);
    for (std::size_t i = 0; i < placed.size(); ++i) {
      if (depths[i] == 0.0) continue;
      const Poses::Sample& sample = samples[i / count];
      (solids[i % count].part == ToolPart::kHolder ? holder : shank).take(sample.pose, sample.way, depths[i]);
      met_.push_back({i % count, sample.pose});
    }
  }
  return found;
}

}  // namespace tiltfeed::pathgen
