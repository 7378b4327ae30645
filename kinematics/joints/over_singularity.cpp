#include "kinematics/joints/over_singularity.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "kinematics/joints/joint_errors.h"
#include "kinematics/joints/operation.h"
#include "kinematics/machine/sweep.h"

namespace tiltfeed {
namespace {

// A tilt word this near to a limit (degrees) is within it.
constexpr double kSlack = 1e-6;
// Places of a move that are looked at ahead.
constexpr int kLooks = 16;

struct Crossing {
  Vec3 axis;
  double fraction = 0.5;  ///< of the move
};

class Builder {
 public:
  Builder(const ToolPath& path, const MachineModel& machine, const Setup& setup, const ClearSpace& clear,
          double cone, bool lift)
      : path_(path), up_(rotary_up(machine, setup)), clear_(clear), cone_(cone), lift_(lift) {}

  PathOverSingularity build();

 private:
  void put(const Pose& pose, const Move& move, std::size_t index) {
    out_.path.moves.push_back({pose, move.kind, move.facet});
    out_.planned.push_back(static_cast<std::uint32_t>(index));
  }
  void go(const Pose& from, const Pose& to, std::size_t index);
  std::optional<Crossing> crossing(Vec3 from, Vec3 to) const;
  bool rises(const Pose& pose) const { return dot(pose.axis, up_) >= kLeastRise; }
  Pose raised(const Pose& pose) const {
    return {pose.tip + pose.axis * rise_to(*clear_.height, pose, up_), pose.axis};
  }

  const ToolPath& path_;
  Vec3 up_;
  const ClearSpace& clear_;
  double cone_;
  bool lift_;
  PathOverSingularity out_;
};

/// Where the great circle passes the pole, between its ends.
std::optional<Crossing> Builder::crossing(Vec3 from, Vec3 to) const {
  const double whole = angle_between(from, to);
  if (dot(from, to) < 0.0 && whole > kPi - kOpposite) {
    Vec3 way = up_ - from * dot(up_, from);
    if (length(way) < kOpposite) {
      const Vec3 side = std::abs(from.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
      way = side - from * dot(side, from);
    }
    return Crossing{normalized(way), 0.5};
  }
  const Vec3 across = cross(from, to);
  if (length(across) < kOpposite || angle_between(from, up_) <= cone_ || angle_between(to, up_) <= cone_)
    return std::nullopt;
  const Vec3 n = normalized(across), toward = up_ - n * dot(n, up_);
  // A level circle is nowhere nearer to the pole than elsewhere.
  if (length(toward) < kOpposite) return std::nullopt;
  const Vec3 near = normalized(toward);
  if (angle_between(near, up_) > cone_) return std::nullopt;
  if (dot(cross(from, near), n) <= 0.0 || dot(cross(near, to), n) <= 0.0) return std::nullopt;
  return Crossing{near, angle_between(from, near) / whole};
}

void Builder::go(const Pose& from, const Pose& to, std::size_t index) {
  const Move& move = path_.moves[index];
  const auto over = crossing(from.axis, to.axis);
  if (!over) return put(to, move, index);
  out_.changed = true;
  if (lift_ && move.kind == MoveKind::kRapid && rises(from) && rises(to)) {
    const Pose up = raised(from), down = raised(to);
    if (!(up == from)) put(up, move, index);
    put({up.tip + (down.tip - up.tip) * over->fraction, over->axis}, move, index);
    put(down, move, index);
    if (!(down == to)) put(to, move, index);
    return;
  }
  const Pose at{from.tip + (to.tip - from.tip) * over->fraction, over->axis};
  go(from, at, index);
  go(at, to, index);
}

PathOverSingularity Builder::build() {
  out_.path = path_;
  out_.path.moves.clear();
  put(path_.moves.front().pose, path_.moves.front(), 0);
  for (std::size_t i = 1; i < path_.moves.size(); ++i) go(path_.moves[i - 1].pose, path_.moves[i].pose, i);
  // Feeds count moves.
  for (FeedChange& change : out_.path.feeds)
    change.move = static_cast<std::uint32_t>(
        std::lower_bound(out_.planned.begin(), out_.planned.end(), change.move) - out_.planned.begin());
  return std::move(out_);
}

/// Looks along a path from pole to pole.
class LookAhead {
 public:
  LookAhead(const ToolPath& path, const MachineModel& machine, const JointChooser& chooser)
      : path_(path), machine_(machine), chooser_(chooser) {
    const double middle = (machine.tilt.min + machine.tilt.max) / 2.0;
    around_ = std::isfinite(middle) ? middle : machine.tilt.zero;
  }

  std::vector<WayFromPole> look();

 private:
  void pass(const Pose& pose, const RotarySolutions& solutions);
  WayFromPole found() const;

  const ToolPath& path_;
  const MachineModel& machine_;
  const JointChooser& chooser_;
  double around_;  ///< the tilt nearest to which a word is taken
  bool leads_[2] = {true, true};
  double at_[2] = {};  ///< the rotary so far, turns counted
  std::array<WayFromPole::Turns, 2> turns_;
};

void LookAhead::pass(const Pose& pose, const RotarySolutions& solutions) {
  const auto holds = [](const LinearAxis& axis, double word) { return word >= axis.min && word <= axis.max; };
  for (std::size_t branch = 0; branch < 2; ++branch) {
    const RotarySolutions::Words& words = solutions.words[branch];
    const double tilt = words.tilt + 360.0 * std::round((around_ - words.tilt) / 360.0);
    const Joints at = chooser_.placed(pose.tip, tilt, words.rotary).joints;
    leads_[branch] = leads_[branch] && tilt >= machine_.tilt.min - kSlack &&
                     tilt <= machine_.tilt.max + kSlack && holds(machine_.x, at.x) &&
                     holds(machine_.y, at.y) && holds(machine_.z, at.z);
    WayFromPole::Turns& turns = turns_[branch];
    const bool first = !std::isfinite(turns.min);
    at_[branch] =
        first ? words.rotary : words.rotary + 360.0 * std::round((at_[branch] - words.rotary) / 360.0);
    turns = {first ? at_[branch] : std::min(turns.min, at_[branch]),
             first ? at_[branch] : std::max(turns.max, at_[branch])};
  }
}

WayFromPole LookAhead::found() const {
  WayFromPole out;
  if (leads_[0] != leads_[1]) out.barred = leads_[0] ? 1 : 0;
  if (std::isfinite(machine_.rotary.min) || std::isfinite(machine_.rotary.max)) out.rotary = turns_;
  return out;
}

std::vector<WayFromPole> LookAhead::look() {
  std::vector<WayFromPole> out(path_.moves.size());
  std::size_t first = 0;
  const auto close = [&](std::size_t end) {
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(first),
              out.begin() + static_cast<std::ptrdiff_t>(end), found());
    first = end + 1;
    leads_[0] = leads_[1] = true;
    turns_ = {};
  };
  for (std::size_t i = 0; i < path_.moves.size(); ++i) {
    const Pose& pose = path_.moves[i].pose;
    const RotarySolutions solutions = chooser_.solve(pose);
    if (solutions.in_cone) {
      close(i);
      continue;
    }
    // A tilt that turns the tool along no meridian turns the rotary between a move's ends, too.
    if (i > 0) {
      const Sweep sweep(path_.moves[i - 1].pose, pose);
      for (int k = 0; k < kLooks; ++k) {
        const Pose between = sweep.at(static_cast<double>(k) / kLooks);
        if (const RotarySolutions there = chooser_.solve(between); !there.in_cone) pass(between, there);
      }
    }
    pass(pose, solutions);
  }
  close(path_.moves.size());
  return out;
}

}  // namespace

PathOverSingularity over_singularity(const ToolPath& path, const MachineModel& machine, const Setup& setup,
                                     const JointChooser& chooser, const ClearSpace& clear, double cone,
                                     bool lift) {
  PathOverSingularity out = Builder(path, machine, setup, clear, cone, lift).build();
  out.ahead = LookAhead(out.path, machine, chooser).look();
  return out;
}

}  // namespace tiltfeed
