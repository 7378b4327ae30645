#include "kinematics/joints/operation.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace tiltfeed {
namespace {

// Ways to go on that are looked at before the search is given up: far more than any sane path needs.
constexpr std::size_t kMostPlaces = 2000;
// Places at which a turning tilt is looked at, degrees.
constexpr double kTiltLook = 5.0;

/// What a way costs: compared in this order.
struct Cost {
  std::size_t in_cut = 0, changes = 0, wrong_side = 0;
  double minutes = 0.0;
  auto rank() const { return std::tie(in_cut, changes, wrong_side, minutes); }
  auto order() const { return std::tie(in_cut, changes); }
};

/// A place where the joints can be chosen anew, and the way that led there.
struct Place {
  std::size_t move = 0;  ///< at whose end
  Cost cost;
  int parent = -1;       ///< the place before; -1: the start
  JointSolution chosen;  ///< there, for the way that led here
  bool instead = false;  ///< chosen for the end of the rapid after it
  JointSolution at;      ///< joints with which the tool arrives here
};

/// One way followed from a place without a change.
struct Run {
  std::size_t dies = 0;  ///< the move that cannot be done so; the count of moves: none
  double minutes = 0.0;  ///< up to there
  struct Stop {
    std::size_t move = 0;
    JointSolution at;
    double minutes = 0.0;
  } air, cut;  ///< the last place with the tool in the air, and the last of all, where a change is possible
};

class Search {
 public:
  Search(const ToolPath& path, const MachineModel& machine, const Setup& setup, const JointChooser& chooser,
         const ClearSpace& clear, const std::vector<bool>& replaced)
      : path_(path),
        machine_(machine),
        setup_(setup),
        chooser_(chooser),
        clear_(clear),
        replaced_(replaced),
        up_(rotary_up(machine, setup)),
        solutions_(path.moves.size()) {
    tbb::parallel_for(std::size_t{0}, solutions_.size(),
                      [&](std::size_t i) { solutions_[i] = chooser_.solve(path_.moves[i].pose); });
  }
  std::optional<OperationPlan> best();

 private:
  bool in_air(std::size_t move) const {
    return path_.moves[move].kind == MoveKind::kRapid ||
           (move + 1 < path_.moves.size() && path_.moves[move + 1].kind == MoveKind::kRapid);
  }
  bool rises(std::size_t move) const { return dot(path_.moves[move].pose.axis, up_) >= kLeastRise; }
  /// How far along its axis the tool is clear; nothing where it cannot be taken off.
  std::optional<double> way_off(std::size_t move) const {
    const Pose& pose = path_.moves[move].pose;
    // Turning the rotary at the pole does not turn the tool.
    if (solutions_[move].in_cone || solutions_[move].rotary_free) return std::nullopt;
    if (rises(move)) return clear_.height ? std::optional(rise_to(*clear_.height, pose, up_)) : std::nullopt;
    return clear_.radius ? way_out(*clear_.radius, pose, machine_, setup_) : std::nullopt;
  }
  /// The tool taken off there, with these rotary words, is within the travels.
  bool clears(std::size_t move, const Joints& at) const {
    const std::optional<double> way = way_off(move);
    if (!way) return false;
    const Pose& pose = path_.moves[move].pose;
    return within_limits(machine_, chooser_.placed(pose.tip + pose.axis * *way, at.a, at.c).joints);
  }
  /// A tool that lies stands while the work turns: it keeps its tilt. One that rises does so all the way.
  bool may_change(std::size_t move, const JointSolution& from, const JointSolution& to) const {
    return rises(move) ? stays_up(from.joints, to.joints)
                       : from.branch == to.branch && from.joints.a == to.joints.a;
  }
  /// The tip is held while the tilt turns: a tool that passed through lying would come down on the part.
  bool stays_up(const Joints& from, const Joints& to) const {
    const int steps = 1 + static_cast<int>(std::abs(to.a - from.a) / kTiltLook);
    for (int i = 1; i < steps; ++i) {
      const double a = from.a + (to.a - from.a) * i / steps;
      if (dot(forward(machine_, setup_, {0.0, 0.0, 0.0, a, from.c}).axis, up_) < kLeastRise) return false;
    }
    return true;
  }
  double minutes(const Joints& from, const Joints& to) const {
    return std::max(std::abs(to.a - from.a) / machine_.tilt.velocity,
                    std::abs(to.c - from.c) / machine_.rotary.velocity);
  }
  /// A way on from a place: joints at the end of the move there, or of the rapid after it.
  struct Way {
    JointSolution chosen;
    bool instead = false;
  };
  std::vector<Way> ways(const Place& from) const;
  Run run(std::size_t place, const JointSolution& start) const;
  void expand(std::size_t index);
  void offer(const Place& place);
  OperationPlan plan_to(const Place& end) const;

  const ToolPath& path_;
  const MachineModel& machine_;
  const Setup& setup_;
  const JointChooser& chooser_;
  const ClearSpace& clear_;
  const std::vector<bool>& replaced_;
  Vec3 up_;
  std::vector<RotarySolutions> solutions_;
  std::vector<Place> places_;
  std::vector<std::size_t> open_;  ///< of places_, at most one for each order of cost
  std::optional<Place> end_;
};

Run Search::run(std::size_t place, const JointSolution& start) const {
  Run out;
  JointSolution at = start;
  std::size_t move = place + 1;
  for (; move < path_.moves.size() && !replaced_[move]; ++move) {
    const auto next = chooser_.next(path_.moves[move].pose, solutions_[move], at);
    // Another solution than the nearest can be walked to at the pole only.
    if (!next || (next->forced && !at.at_pole)) break;
    out.minutes += minutes(at.joints, next->joints);
    at = *next;
    if (!clears(move, at.joints)) continue;
    out.cut = {move, at, out.minutes};
    if (in_air(move)) out.air = out.cut;
  }
  out.dies = move;
  return out;
}

/// From a place further on everything can be done that can be done from one before it.
void Search::offer(const Place& place) {
  for (std::size_t& index : open_) {
    const Place& other = places_[index];
    if (other.cost.order() != place.cost.order()) continue;
    if (place.move > other.move || (place.move == other.move && place.cost.rank() < other.cost.rank())) {
      places_.push_back(place);
      index = places_.size() - 1;
    }
    return;
  }
  places_.push_back(place);
  open_.push_back(places_.size() - 1);
}

std::vector<Search::Way> Search::ways(const Place& from) const {
  std::vector<Way> out;
  const bool starts = from.parent < 0;
  const auto offer_at = [&](std::size_t move, bool instead) {
    for (const JointSolution& to : chooser_.choices(path_.moves[move].pose, solutions_[move], from.at))
      if (starts || (clears(move, to.joints) && may_change(from.move, from.at, to)))
        out.push_back({to, instead});
  };
  offer_at(from.move, false);
  const std::size_t next = from.move + 1;
  if (!starts && next < path_.moves.size() && path_.moves[next].kind == MoveKind::kRapid &&
      rises(from.move) && rises(next))
    offer_at(next, true);
  return out;
}

void Search::expand(std::size_t index) {
  const Place from = places_[index];
  const std::vector<Way> ways = this->ways(from);
  std::vector<Run> runs(ways.size());
  tbb::parallel_for(std::size_t{0}, ways.size(), [&](std::size_t k) {
    runs[k] = run(from.move + (ways[k].instead ? 1 : 0), ways[k].chosen);
  });
  for (std::size_t k = 0; k < ways.size(); ++k) {
    const JointSolution& chosen = ways[k].chosen;
    Place next{path_.moves.size(), from.cost, static_cast<int>(index), chosen, ways[k].instead, {}};
    if (from.parent >= 0) next.cost.minutes += minutes(from.at.joints, chosen.joints);
    if ((chosen.joints.a - machine_.tilt.zero) * machine_.preferred_tilt < 0.0) ++next.cost.wrong_side;
    const auto stop_at = [&](const Run::Stop& stop, std::size_t in_cut) {
      Place place = next;
      place.move = stop.move;
      place.at = stop.at;
      place.cost.minutes += stop.minutes;
      place.cost.in_cut += in_cut;
      ++place.cost.changes;
      if (stop.move > from.move) offer(place);
    };
    if (runs[k].dies < path_.moves.size()) {
      stop_at(runs[k].air, 0);
      if (runs[k].cut.move > runs[k].air.move) stop_at(runs[k].cut, 1);
      continue;
    }
    next.cost.minutes += runs[k].minutes;
    if (!end_ || next.cost.rank() < end_->cost.rank()) end_ = next;
  }
}

OperationPlan Search::plan_to(const Place& end) const {
  OperationPlan plan;
  Place at = end;
  for (; places_[static_cast<std::size_t>(at.parent)].parent >= 0;
       at = places_[static_cast<std::size_t>(at.parent)]) {
    const Place& place = places_[static_cast<std::size_t>(at.parent)];
    plan.changes.push_back({place.move, place.at, at.chosen, !rises(place.move), at.instead});
  }
  plan.start = at.chosen;
  std::reverse(plan.changes.begin(), plan.changes.end());
  return plan;
}

std::optional<OperationPlan> Search::best() {
  Place start;
  start.at.joints.c = std::clamp(0.0, machine_.rotary.min, machine_.rotary.max);
  offer(start);
  for (std::size_t tried = 0; !open_.empty() && tried < kMostPlaces; ++tried) {
    const auto least = std::min_element(open_.begin(), open_.end(), [&](std::size_t a, std::size_t b) {
      return places_[a].cost.order() < places_[b].cost.order();
    });
    const std::size_t index = *least;
    if (end_ && end_->cost.order() < places_[index].cost.order()) break;
    open_.erase(least);
    expand(index);
  }
  if (!end_) return std::nullopt;
  return plan_to(*end_);
}

}  // namespace

std::optional<OperationPlan> plan_operation(const ToolPath& path, const MachineModel& machine,
                                            const Setup& setup, const JointChooser& chooser,
                                            const ClearSpace& clear, const std::vector<bool>& replaced) {
  return Search(path, machine, setup, chooser, clear, replaced).best();
}

}  // namespace tiltfeed
