#include "kinematics/joints/singularity_bend.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "kinematics/joints/axis_shift_search.h"
#include "kinematics/joints/path_splice.h"
#include "kinematics/joints/singularity_pieces.h"
#include "kinematics/machine/sweep.h"

namespace tiltfeed {
namespace {

// Nodes are this share of their distance from the pole apart (of the tolerance where they are nearer), so
// that the rotary turns by 15 degrees between them and the bend changes by one level at least.
constexpr double kNodeShare = 0.25;
// Rounding of that distance, as a share.
constexpr double kNodeRounding = 1e-9;
// A bend must save a tenth of what the rotaries take of their speed.
constexpr double kGain = 0.9;
// The bow of the axis between points grows by (1 + slope)^2 - 1 at most; its eighth, with some room.
constexpr double kBowGrowth = 0.08;
// A point that leans by less (rad) does not lean.
constexpr double kNoLean = 1e-12;
// Each round takes a level off the bend where the tool is not clear.
constexpr int kMostRounds = 4 * kBendLevels;

/// A point of the path or between two of them.
struct Station {
  Move move;
  Vec3 ahead;
  double turned = 0.0, minutes = 0.0;
  std::size_t node = 0;   ///< the last one not after it
  bool original = false;  ///< a point of the path
  bool closest = false;   ///< nearer to the pole than those about it
};

struct Bent {
  std::vector<Move> moves;  ///< instead of first + 1 to last; empty: as they are
  std::vector<std::uint8_t> original;
  std::size_t points = 0;
  double largest = 0.0;
  bool refused = false;
};

class Bender {
 public:
  Bender(const ToolPath& path, const MachineModel& machine, const Setup& setup,
         const SingularityBendOptions& options, const MoveCheck& clear)
      : path_(path),
        machine_(machine),
        clear_(clear),
        chooser_(machine, setup, 9, 9, 0.0),
        pole_(rotary_up(machine, setup)),
        most_(options.axis_tolerance.radians()),
        radius_(path.tool.corner_radius),
        longest_turn_(radius_ > 0.0 ? std::sqrt(options.tolerance / (kBowGrowth * radius_)) : kPi),
        choice_(machine, chooser_, pole_, most_) {}

  Bent bend(const SingularityPiece& piece) const;

 private:
  double off_pole(Vec3 axis) const { return angle_between(axis, pole_); }
  double closest_on(Vec3 a, Vec3 b, double angle) const;
  std::vector<Station> stations(const SingularityPiece& piece) const;
  std::vector<ShiftNode> nodes(std::vector<Station>& stations) const;
  std::vector<Move> bent(const std::vector<Station>& stations, const std::vector<ShiftNode>& nodes,
                         const std::vector<Vec3>& shifts) const;
  bool restrain(const std::vector<Station>& stations, const std::vector<Move>& moves,
                const std::vector<Vec3>& shifts, std::vector<ShiftNode>& nodes) const;

  const ToolPath& path_;
  const MachineModel& machine_;
  const MoveCheck& clear_;
  JointChooser chooser_;
  Vec3 pole_;
  double most_, radius_, longest_turn_;
  AxisShiftSearch choice_;
};

/// Where between a and b, `angle` apart, the axis is nearest to the pole: a share of the angle; 0 or 1 at an
/// end.
double Bender::closest_on(Vec3 a, Vec3 b, double angle) const {
  if (angle <= kNoTurn) return 1.0;
  return std::clamp(std::atan2(dot(pole_, way_of(a, b)), dot(pole_, a)) / angle, 0.0, 1.0);
}

std::vector<Station> Bender::stations(const SingularityPiece& piece) const {
  std::vector<Station> out{{path_.moves[piece.first], {}, 0.0, 0.0, 0, true}};
  Vec3 ahead{};
  for (std::size_t i = piece.first + 1; i <= piece.last; ++i) {
    const Sweep sweep(path_.moves[i - 1].pose, path_.moves[i].pose);
    const double way = sweep.distance(), angle = sweep.angle();
    const double minutes = std::max({way / feed_of(path_, i).mm_per_min(),
                                     Angle::from_radians(angle).degrees() / machine_.tilt.velocity, 1e-9});
    const double turned = out.back().turned, before = out.back().minutes;
    const double closest = closest_on(path_.moves[i - 1].pose.axis, path_.moves[i].pose.axis, angle);
    for (double f = 0.0; f < 1.0;) {
      const double step =
          std::min(kNodeShare * std::max(most_, off_pole(out.back().move.pose.axis)), longest_turn_);
      const double goal = f < closest ? closest : 1.0;
      const int left =
          angle > 0.0 ? static_cast<int>(std::ceil((goal - f) * angle / step - kNodeRounding)) : 1;
      f = left <= 1 ? goal : f + (goal - f) / left;
      Station next{path_.moves[i], {}, turned + f * angle, before + f * minutes, 0, f >= 1.0, false};
      next.move.pose = sweep.at(f);
      out.push_back(next);
    }
  }
  // The way at a station: the mean of those before and after.
  for (std::size_t k = 0; k < out.size(); ++k) {
    const Vec3 at = out[k].move.pose.axis;
    Vec3 sum{};
    if (k > 0) sum = sum - way_of(at, out[k - 1].move.pose.axis);
    if (k + 1 < out.size()) sum = sum + way_of(at, out[k + 1].move.pose.axis);
    if (squared_length(sum) > 0.0) ahead = normalized(sum - at * dot(at, sum));
    out[k].ahead = ahead;
    const auto off = [&](std::size_t i) { return off_pole(out[i].move.pose.axis); };
    out[k].closest =
        k > 0 && k + 1 < out.size() && off(k) <= most_ && off(k) < off(k - 1) && off(k) <= off(k + 1);
  }
  return out;
}

std::vector<ShiftNode> Bender::nodes(std::vector<Station>& stations) const {
  std::vector<ShiftNode> out;
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < stations.size(); ++k) {
    const Station& s = stations[k];
    const double least = kNodeShare * std::max(most_, off_pole(s.move.pose.axis)) * (1.0 - kNodeRounding);
    const bool wanted = s.closest || k + 1 == stations.size();
    if (!out.empty() && !wanted && s.turned - out.back().turned < least) continue;
    // One that is wanted takes the place of one just before it.
    if (wanted && out.size() > 1 && s.turned - out.back().turned < least / 2.0 &&
        !stations[chosen.back()].closest)
      out.pop_back(), chosen.pop_back();
    out.push_back({s.move.pose, s.ahead, s.turned, s.minutes, -most_, most_});
    chosen.push_back(k);
  }
  for (std::size_t k = 0, node = 0; k < stations.size(); ++k) {
    if (node + 1 < chosen.size() && chosen[node + 1] <= k) ++node;
    stations[k].node = node;
  }
  return out;
}

/// The stations with their axes bent, the shift linear between the nodes, the ball's centre where it was.
std::vector<Move> Bender::bent(const std::vector<Station>& stations, const std::vector<ShiftNode>& nodes,
                               const std::vector<Vec3>& shifts) const {
  std::vector<Move> out;
  for (const Station& s : stations) {
    const std::size_t i = s.node, j = std::min(i + 1, nodes.size() - 1);
    const double whole = nodes[j].turned - nodes[i].turned,
                 f = whole > 0.0 ? std::clamp((s.turned - nodes[i].turned) / whole, 0.0, 1.0) : 0.0;
    const Vec3 shift = shifts[i] + (shifts[j] - shifts[i]) * f;
    out.push_back(s.move);
    if (length(shift) <= kNoLean) continue;
    Pose& pose = out.back().pose;
    Vec3 axis = normalized(pose.axis + shift);
    const double lean = angle_between(pose.axis, axis);
    if (lean > most_) axis = slerp(pose.axis, axis, most_ / lean);
    pose.tip = pose.tip + (pose.axis - axis) * radius_;
    pose.axis = axis;
  }
  return out;
}

/// Takes a level off the bends about every move that is not clear; false where all are.
bool Bender::restrain(const std::vector<Station>& stations, const std::vector<Move>& moves,
                      const std::vector<Vec3>& shifts, std::vector<ShiftNode>& nodes) const {
  const double level = most_ / kBendLevels;
  bool any = false;
  for (std::size_t k = 1; k < moves.size(); ++k) {
    const bool leans =
        !(moves[k].pose == stations[k].move.pose) || !(moves[k - 1].pose == stations[k - 1].move.pose);
    if (!leans || clear_(moves[k - 1].pose, moves[k].pose)) continue;
    any = true;
    for (std::size_t j = stations[k - 1].node; j <= std::min(stations[k].node + 1, nodes.size() - 1); ++j) {
      ShiftNode& node = nodes[j];
      const double side = dot(shifts[j], cross(node.pose.axis, node.ahead));
      if (side > 0.0) node.high = std::min(node.high, std::max(0.0, side - level));
      if (side < 0.0) node.low = std::max(node.low, std::min(0.0, side + level));
    }
  }
  return any;
}

Bent Bender::bend(const SingularityPiece& piece) const {
  std::vector<Station> points = stations(piece);
  std::vector<ShiftNode> nodes = this->nodes(points);
  if (nodes.size() < 3) return {};
  const auto exact = choice_.cost(nodes, std::vector<Vec3>(nodes.size()));
  Bent out;
  for (int round = 0; round < kMostRounds; ++round) {
    const auto shifts = choice_.best(nodes);
    if (!shifts) return out;
    const auto cost = choice_.cost(nodes, *shifts);
    if (!cost || (exact && !(*cost < kGain * *exact))) return out;
    const std::vector<Move> moves = bent(points, nodes, *shifts);
    if (restrain(points, moves, *shifts, nodes)) {
      out.refused = true;
      continue;
    }
    out.refused = false;
    for (std::size_t k = 1; k < moves.size(); ++k) {
      const auto lean = [&](std::size_t i) {
        return angle_between(moves[i].pose.axis, points[i].move.pose.axis);
      };
      const double here = lean(k);
      if (!points[k].original && here == 0.0 && lean(k - 1) == 0.0 &&
          (k + 1 == moves.size() || lean(k + 1) == 0.0))
        continue;
      out.moves.push_back(moves[k]);
      out.original.push_back(points[k].original ? 1 : 0);
      out.points += here > 0.0 ? 1 : 0;
      out.largest = std::max(out.largest, here);
    }
    return out;
  }
  return out;
}

}  // namespace

SingularityBend bend_at_singularity(const ToolPath& path, const MachineModel& machine, const Setup& setup,
                                    const SingularityBendOptions& options, const MoveCheck& clear) {
  const Bender bender(path, machine, setup, options, clear);
  const std::vector<SingularityPiece> pieces =
      pieces_near_singularity(path, rotary_up(machine, setup), kPoleReach * options.axis_tolerance.radians());
  std::vector<Bent> bent(pieces.size());
  tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t k) { bent[k] = bender.bend(pieces[k]); });
  SingularityBend out;
  PathSplice splice(path);
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    out.report.refused += bent[k].refused ? 1 : 0;
    if (bent[k].moves.empty() || bent[k].points == 0) continue;
    splice.replace(pieces[k].first, bent[k].moves, bent[k].original);
    ++out.report.stretches;
    out.report.points += bent[k].points;
    out.report.largest = std::max(out.report.largest, Angle::from_radians(bent[k].largest));
  }
  out.path = splice.finish();
  return out;
}

}  // namespace tiltfeed
