#include "kinematics/joints/move_subdivider.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "kinematics/basics/decimal.h"
#include "kinematics/joints/joint_errors.h"

namespace tiltfeed {
namespace {

// A move is halved at most this often: 2^-40 of a move is below the last bit of its length.
constexpr int kMaxHalvings = 40;
// A move is cut into as many parts as the square law of (K6) asks for, up to kGuessedParts; beyond that, and
// where the table turns far (degrees), i.e. near the pole, the law is a poor guess: kFewParts, then look
// again.
constexpr double kGuessedParts = 32.0;
constexpr double kSquareLawTurn = 90.0;
constexpr int kFewParts = 8;
// From so many halvings on a block may be as short as the last decimals of its words. Rounding then puts the
// tip early or late by more than the axis may be, and no cut mends that: such a block is compared with the
// pose that its axis is nearest to, too.
constexpr int kFineHalvings = 6;
// Blocks of one swing in place: half a turn at 0.01 degrees; a tolerance that asks for more cannot be met.
constexpr int kMaxSwing = 18000;
// A control that turns F into mm/min may not go below 0.1 mm/min (LinuxCNC), so that a linear way shorter
// than 0.1 mm/min times the block's time runs too fast; a tenth more because F is printed rounded.
constexpr double kSlowestFeed = 0.11;
// Moves at the pole that are looked through for where the path leaves it: bounds the work.
constexpr std::size_t kLookAhead = 512;

}  // namespace

double MoveSubdivider::seconds(const Joints& from, const Joints& to, double way) const {
  // (K10) in minutes.
  double minutes = 0.0;
  if (kind_ != MoveKind::kRapid) minutes = way / feed_of(path_, index_).mm_per_min();
  minutes = std::max(
      {minutes, std::abs(to.x - from.x) / machine_.x.velocity, std::abs(to.y - from.y) / machine_.y.velocity,
       std::abs(to.z - from.z) / machine_.z.velocity, std::abs(to.a - from.a) / machine_.tilt.velocity,
       std::abs(to.c - from.c) / machine_.rotary.velocity});
  const double seconds = minutes * 60.0;
  if (machine_.blends_rotary || (to.a == from.a && to.c == from.c)) return seconds;
  // Without look-ahead a block keeps its time only where T >= 2 v_i / a_i, v_i = |dq_i| / T.
  const double harshest = std::max({std::abs(to.x - from.x) / machine_.x.acceleration,
                                    std::abs(to.y - from.y) / machine_.y.acceleration,
                                    std::abs(to.z - from.z) / machine_.z.acceleration,
                                    std::abs(to.a - from.a) / machine_.tilt.acceleration,
                                    std::abs(to.c - from.c) / machine_.rotary.acceleration});
  return std::max(seconds, std::sqrt(2.0 * harshest));
}

Deviation MoveSubdivider::check(const Sweep& sweep, double f0, double f1, const Joints& to, Early by) const {
  const double centre = path_.tool.corner_radius, up = std::max(centre, options_.reach);
  return worst_deviation(chooser_.chain(), sweep, f0, f1, at_, to, {up, by == Early::kAxis ? up : centre});
}

/// The deviation over what is allowed; above 1 the block must be cut.
double MoveSubdivider::excess(const Deviation& deviation, const Joints& from, const Joints& to) const {
  const double factor = (1.0 - kSampleShare) * (kind_ == MoveKind::kRapid ? kRapidToleranceFactor : 1.0);
  const double angle = Angle::from_degrees(options_.axis_tolerance).radians();
  const double over =
      std::max(std::max(deviation.tip, deviation.end) / options_.tolerance, deviation.axis / angle) / factor;
  const bool half_turn = std::abs(to.c - from.c) >= 180.0 || std::abs(to.a - from.a) >= 180.0;
  return half_turn ? std::max(over, 2.0) : over;
}

void MoveSubdivider::note(const Joints& q, const Deviation& deviation) {
  JointPathReport& report = out_.report;
  report.min = least(report.min, q);
  report.max = greatest(report.max, q);
  if (kind_ == MoveKind::kRapid) {
    report.max_rapid_deviation = std::max({report.max_rapid_deviation, deviation.tip, deviation.end});
    return;
  }
  report.max_tip_deviation = std::max(report.max_tip_deviation, deviation.tip);
  report.max_end_deviation = std::max(report.max_end_deviation, deviation.end);
  report.max_axis_deviation =
      std::max(report.max_axis_deviation, Angle::from_radians(deviation.axis).degrees());
}

/// Leaves the linear axes where they are for a block of so much `time` in which they would move by rounding
/// noise only, if the path allows it.
void MoveSubdivider::quieten(const Sweep& sweep, double f0, double f1, JointSolution& to,
                             Deviation& deviation, double& time) const {
  if (kind_ == MoveKind::kRapid) return;
  const Joints &from = at_.joints, &q = to.joints;
  const double linear = length(Vec3{q.x - from.x, q.y - from.y, q.z - from.z});
  if (linear == 0.0 || linear >= kSlowestFeed * time / 60.0) return;
  const Joints still{from.x, from.y, from.z, q.a, q.c};
  const Deviation stands = check(sweep, f0, f1, still);
  if (excess(stands, from, still) > 1.0) return;
  to.joints = still;
  deviation = stands;
  time = seconds(from, still, sweep.distance() * (f1 - f0));
}

void MoveSubdivider::emit(const JointSolution& to, const Deviation& deviation, double time) {
  const bool moves = !(to.joints == at_.joints);
  at_ = to;
  if (!moves) return;
  note(to.joints, deviation);
  out_.moves.push_back({to.joints, time, kind_, static_cast<std::uint32_t>(index_)});
}

/// At a pose inside the pole cone, the tip held: what turns the table by `turn`; nothing where no block fits.
/// Leaves the joints where they are.
Result<std::optional<MoveSubdivider::Turned>> MoveSubdivider::turned_in_place(const Pose& pose, double turn) {
  const Sweep standing(pose, pose);  // held in place, nothing is early or late
  // (K6) with no linear way: the tip leaves its place by r dphi^2 / 8; half the tolerance for that.
  const double radius = std::max(chooser_.chain().radius(pose.tip), options_.tolerance);
  const double step = Angle::from_radians(std::sqrt(4.0 * options_.tolerance / radius)).degrees();
  const int count = static_cast<int>(std::ceil(std::abs(turn) / std::min(step, 90.0)));
  if (count > kMaxSwing) return std::nullopt;
  const JointSolution before = at_;
  Turned turned;
  for (int i = 1; i <= count; ++i) {
    const auto stop = chooser_.at_pole(pose, at_, before.joints.c + turn * i / count);
    const Deviation deviation = stop ? check(standing, 0.0, 0.0, stop->joints) : Deviation{};
    const bool fits = stop && excess(deviation, at_.joints, stop->joints) <= 1.0;
    if (fits) {
      turned.emplace_back(*stop, deviation);
      at_ = *stop;
      continue;
    }
    at_ = before;
    if (!stop) return tl::unexpected(stop.error());
    return std::nullopt;
  }
  at_ = before;
  return turned;
}

/// From a pose inside the pole cone: turns the table in place to where `goal` needs it, if one block then
/// reaches `goal`. Nothing is emitted otherwise.
Result<bool> MoveSubdivider::swing(const Sweep& sweep, double f0, double f1, const JointSolution& goal) {
  const auto turned = turned_in_place(sweep.at(f0), goal.joints.c - at_.joints.c);
  if (!turned) return tl::unexpected(turned.error());
  if (!*turned) return false;
  const JointSolution before = at_;
  if (!(*turned)->empty()) at_ = (*turned)->back().first;
  const Deviation last = check(sweep, f0, f1, goal.joints);
  const bool fits = excess(last, at_.joints, goal.joints) <= 1.0;
  at_ = before;
  if (!fits) return false;
  for (const auto& [choice, deviation] : **turned)
    emit(choice, deviation, seconds(at_.joints, choice.joints, 0.0));
  emit(goal, last, seconds(at_.joints, goal.joints, sweep.distance() * (f1 - f0)));
  ++out_.report.pole_swings;
  return true;
}

/// (K8) After a rapid that ends at the pole: the rotary, which is free there, is turned before the tool goes
/// into the material to where the path leaves the pole.
void MoveSubdivider::turn_ahead() {
  const std::vector<Move>& moves = path_.moves;
  if (kind_ != MoveKind::kRapid || !at_.at_pole) return;
  if (index_ + 1 >= moves.size() || moves[index_ + 1].kind == MoveKind::kRapid) return;
  const std::size_t end = std::min(moves.size(), index_ + 1 + kLookAhead);
  for (std::size_t next = index_ + 1; next < end && moves[next].kind != MoveKind::kRapid; ++next) {
    RotarySolutions solutions = chooser_.solve(moves[next].pose);
    if (solutions.in_cone) continue;
    if (!solutions.reachable) return;
    solutions = chooser_.leaving(moves[next - 1].pose, moves[next].pose);
    const double turn = chooser_.rotary_towards(solutions, at_) - at_.joints.c;
    const auto turned = turned_in_place(moves[index_].pose, turn);
    if (!turned || !*turned) return;  // a limit: the way into the cut then says so
    for (const auto& [choice, deviation] : **turned)
      emit(choice, deviation, seconds(at_.joints, choice.joints, 0.0));
    return;
  }
}

Result<void> MoveSubdivider::stuck(const Sweep& sweep, double f1, const JointSolution& goal) const {
  const Pose pose = sweep.at(f1);
  if (goal.forced) {
    if (const auto text = chooser_.nearest_breaks(pose, at_)) return fail(Code::kLimit, *text);
  }
  return fail(Code::kLimit,
              "no motion from " + std::string{machine_.tilt.letter} + decimal(at_.joints.a, 4) + " " +
                  machine_.rotary.letter + decimal(at_.joints.c, 4) + " to " + machine_.tilt.letter +
                  decimal(goal.joints.a, 4) + " " + machine_.rotary.letter + decimal(goal.joints.c, 4) +
                  " keeps the tool within " + decimal(options_.tolerance, 6) + " mm and " +
                  decimal(options_.axis_tolerance, 6) +
                  " degrees; allow more, or print more decimals: the last one may be too coarse");
}

Result<void> MoveSubdivider::advance(const Sweep& sweep, double f0, double f1, int halvings) {
  const Pose pose = sweep.at(f1);
  RotarySolutions solutions = *ends_;
  if (f1 < 1.0) solutions = chooser_.solve(pose), solutions.ahead = ends_->ahead;
  auto goal = chooser_.next(pose, solutions, at_);
  if (!goal) return tl::unexpected(goal.error());
  Deviation deviation = check(sweep, f0, f1, goal->joints);
  double over = excess(deviation, at_.joints, goal->joints);
  if (over > 1.0 && halvings >= kFineHalvings) {
    deviation = check(sweep, f0, f1, goal->joints, Early::kAxis);
    over = std::min(over, excess(deviation, at_.joints, goal->joints));
  }
  if (over <= 1.0) {
    double time = seconds(at_.joints, goal->joints, sweep.distance() * (f1 - f0));
    quieten(sweep, f0, f1, *goal, deviation, time);
    emit(*goal, deviation, time);
    return {};
  }
  if (at_.at_pole && !goal->at_pole) {
    const auto swung = swing(sweep, f0, f1, *goal);
    if (!swung) return tl::unexpected(swung.error());
    if (*swung) return {};
  }
  if (halvings >= kMaxHalvings) return stuck(sweep, f1, *goal);
  const double guess = std::ceil(std::sqrt(over));
  const bool trusted = guess <= kGuessedParts && std::abs(goal->joints.c - at_.joints.c) <= kSquareLawTurn;
  const int parts = trusted ? std::max(2, static_cast<int>(guess)) : kFewParts;
  double begin = f0;
  for (int i = 1; i <= parts; ++i) {
    const double end = i == parts ? f1 : f0 + (f1 - f0) * i / parts;
    if (auto part = advance(sweep, begin, end, halvings + 1); !part) return part;
    begin = end;
  }
  return {};
}

SubdividedMoves MoveSubdivider::walk(const JointSolution& start, std::size_t first,
                                     std::span<const RotarySolutions> solutions) {
  out_ = {};
  out_.moves.reserve(solutions.size() + solutions.size() / 2);
  out_.report.min = out_.report.max = start.joints;
  at_ = start;
  for (std::size_t i = 0; i < solutions.size(); ++i) {
    index_ = first + i;
    ends_ = &solutions[i];
    const Move& move = path_.moves[index_];
    kind_ = move.kind;
    const Sweep sweep(path_.moves[index_ - 1].pose, move.pose);
    const std::size_t before = out_.moves.size();
    if (auto done = advance(sweep, 0.0, 1.0, 0); !done) {
      const bool wound_up = limited_axis(done.error().message) == machine_.rotary.letter;
      out_.stop = {located(done.error(), index_, move.pose, machine_, chooser_.setup()), index_, wound_up};
      break;
    }
    if (out_.moves.size() > before + 1) ++out_.report.subdivided_moves;
    turn_ahead();
  }
  out_.end = at_;
  return std::move(out_);
}

}  // namespace tiltfeed
