#include "kinematics/joints/joint_chooser.h"

#include <algorithm>
#include <cmath>

#include "kinematics/basics/decimal.h"
#include "kinematics/machine/sweep.h"

namespace tiltfeed {
namespace {

// Two ways whose times (min) differ by less are equally long: rounding noise of the angles.
constexpr double kSameTime = 1e-12;
// Rounding moves a word by this many of its last decimals at most.
constexpr double kRoundedBy = 2.0;
// A rotary that comes to its limit to so much (degrees) comes to it by rounding.
constexpr double kLimitSlack = 1e-6;
// Starts to consider: two branches on a few turns of the table.
constexpr std::size_t kMaxStarts = 8;
constexpr int kStartTurns = 2;
// Where a move leaves the pole cone is known to this many binary places.
constexpr int kHalvings = 40;

double nearest_turn(double word, double from) {
  return std::abs(from - word) < 180.0 ? word : word + 360.0 * std::round((from - word) / 360.0);
}

/// The word rounded; to the other side where rounding alone would carry it over a limit; off a whole turn
/// where its sign is the way and 0 has none.
double rounded_within(double word, const RotaryAxis& axis, int decimals) {
  const double rounded = round_decimal(word, decimals);
  if (axis.word != RotaryWord::kSigned && rounded >= axis.min && rounded <= axis.max) return rounded;
  const double step = 1.0 / decimal_scale(decimals);
  if (axis.word == RotaryWord::kSigned && std::remainder(rounded, 360.0) == 0.0)
    return round_decimal(rounded + step, decimals);
  if (rounded < axis.min && rounded + step >= axis.min) return round_decimal(rounded + step, decimals);
  if (rounded > axis.max && rounded - step <= axis.max) return round_decimal(rounded - step, decimals);
  return rounded;
}

}  // namespace

JointChooser::JointChooser(const MachineModel& machine, const Setup& setup, int linear_decimals,
                           int rotary_decimals, double pole_cone)
    : machine_(machine),
      setup_(setup),
      chain_(machine, setup),
      linear_decimals_(linear_decimals),
      rotary_decimals_(rotary_decimals),
      pole_cone_(pole_cone),
      cone_sine_(std::sin(pole_cone)),
      rounding_time_(
          2.0 * kRoundedBy /
          (decimal_scale(rotary_decimals) * std::min(machine.tilt.velocity, machine.rotary.velocity))) {}

Posture JointChooser::placed(Point<Part> tip, double a, double c) const {
  const Trig tilt = chain_.tilt_trig(a), rotary = chain_.rotary_trig(c);
  const Vec3 p = chain_.linear(tip, tilt, rotary);
  return {{round_decimal(p.x, linear_decimals_), round_decimal(p.y, linear_decimals_),
           round_decimal(p.z, linear_decimals_), a, c},
          tilt,
          rotary};
}

JointSolution JointChooser::placed(Point<Part> tip, const Candidate& candidate) const {
  return {placed(tip, candidate.a, candidate.c), candidate.branch, false, false};
}

Posture JointChooser::rounded(Point<Part> tip, double a, double c) const {
  // (K9): rotaries first, then X Y Z from the rounded angles.
  return placed(tip, rounded_within(a, machine_.tilt, rotary_decimals_),
                rounded_within(c, machine_.rotary, rotary_decimals_));
}

RotarySolutions JointChooser::solve(const Pose& pose) const {
  const Vec3 axis = chain_.on_table(pose.axis);
  const AxisSolutions angles = chain_.solve_axis(axis);
  RotarySolutions found;
  found.reachable = angles.missed <= pole_cone_;
  found.in_cone = found.reachable && angles.off_pole <= cone_sine_;
  found.rotary_free = angles.rotary_free;
  for (std::size_t i = 0; i < 2; ++i)
    found.words[i] = {chain_.tilt_word(angles.angles[i].tilt), chain_.rotary_word(angles.angles[i].rotary)};
  return found;
}

RotarySolutions JointChooser::leaving(const Pose& from, const Pose& to) const {
  const Sweep sweep(from, to);
  double in = 0.0, out = 1.0;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (in + out);
    (solve(sweep.at(middle)).in_cone ? in : out) = middle;
  }
  return solve(sweep.at(out));
}

tl::unexpected<Error> JointChooser::unreachable(const Pose& pose) const {
  return fail(Code::kUnreachable, unreachable_text(machine_, pose.axis, chain_.on_table(pose.axis)));
}

double JointChooser::cost(double a, double c, const Joints& from) const {
  return std::max(std::abs(a - from.a) / machine_.tilt.velocity,
                  std::abs(c - from.c) / machine_.rotary.velocity);
}

RotarySolutions::Words JointChooser::nearest(const RotarySolutions& solutions, int branch,
                                             const Joints& from) const {
  const RotarySolutions::Words& words = solutions.words[branch];
  return {nearest_turn(words.tilt, from.a),
          solutions.rotary_free ? from.c : nearest_turn(words.rotary, from.c)};
}

JointChooser::Candidate JointChooser::candidate(const RotarySolutions& solutions, int branch,
                                                const Joints& from) const {
  const RotarySolutions::Words words = nearest(solutions, branch, from);
  return {rounded_within(words.tilt, machine_.tilt, rotary_decimals_),
          rounded_within(words.rotary, machine_.rotary, rotary_decimals_), branch};
}

std::array<JointChooser::Candidate, 2> JointChooser::candidates(const RotarySolutions& solutions,
                                                                const Joints& from) const {
  return {candidate(solutions, 0, from), candidate(solutions, 1, from)};
}

int JointChooser::preferred(const RotarySolutions& solutions, const JointSolution& from) const {
  if (from.at_pole && solutions.ahead.barred >= 0) return 1 - solutions.ahead.barred;
  const auto time = [&](int branch) {
    const RotarySolutions::Words words = nearest(solutions, branch, from.joints);
    return cost(words.tilt, words.rotary, from.joints);
  };
  const double clear = time(1) - time(0);
  if (std::abs(clear) > rounding_time_) return clear < 0.0 ? 1 : 0;
  const std::array<Candidate, 2> found = candidates(solutions, from.joints);
  const double difference =
      cost(found[1].a, found[1].c, from.joints) - cost(found[0].a, found[0].c, from.joints);
  if (std::abs(difference) <= kSameTime) return from.branch;
  return difference < 0.0 ? 1 : 0;
}

Result<JointSolution> JointChooser::next(const Pose& pose, const RotarySolutions& solutions,
                                         const JointSolution& from) const {
  if (solutions.in_cone) return at_pole(pose, from, from.joints.c);
  if (!solutions.reachable) return unreachable(pose);
  const int branch = preferred(solutions, from);
  const Candidate best = candidate(solutions, branch, from.joints);
  const JointSolution choice = placed(pose.tip, best);
  const WayFromPole* ahead = from.at_pole && solutions.ahead.asks() ? &solutions.ahead : nullptr;
  if (within_limits(machine_, choice.joints) && (!ahead || leads(*ahead, best.branch, best.c))) return choice;
  const Candidate other = candidate(solutions, 1 - branch, from.joints);
  if (ahead) {
    if (const auto led = next_within_limits(pose, {best, other}, from, ahead)) return *led;
    if (const auto text = breaks_ahead(*ahead, choice)) return fail(Code::kLimit, *text);
  }
  if (const auto turned = next_within_limits(pose, {best, other}, from, nullptr)) return *turned;
  return fail(Code::kLimit, *broken_limit(machine_, choice.joints));
}

WayFromPole::Turns JointChooser::turns_from(const WayFromPole& ahead, int branch, double c) const {
  const WayFromPole::Turns& way = ahead.rotary[static_cast<std::size_t>(branch)];
  if (!std::isfinite(way.min)) return {c, c};
  const double turns = 360.0 * std::round((c - 0.5 * (way.min + way.max)) / 360.0);
  return {way.min + turns, way.max + turns};
}

bool JointChooser::leads(const WayFromPole& ahead, int branch, double c) const {
  const WayFromPole::Turns way = turns_from(ahead, branch, c);
  return branch != ahead.barred && way.min >= machine_.rotary.min - kLimitSlack &&
         way.max <= machine_.rotary.max + kLimitSlack;
}

std::optional<std::string> JointChooser::breaks_ahead(const WayFromPole& ahead,
                                                      const JointSolution& from) const {
  const WayFromPole::Turns way = turns_from(ahead, from.branch, from.joints.c);
  Joints furthest = from.joints;
  furthest.c = way.min < machine_.rotary.min ? way.min : way.max;
  return broken_limit(machine_, furthest);
}

Result<JointSolution> JointChooser::next_rotary(const Pose& pose, const RotarySolutions& solutions,
                                                const JointSolution& from) const {
  if (solutions.in_cone || !solutions.reachable) return next(pose, solutions, from);
  const Candidate best = candidate(solutions, preferred(solutions, from), from.joints);
  if (best.a < machine_.tilt.min || best.a > machine_.tilt.max || best.c < machine_.rotary.min ||
      best.c > machine_.rotary.max || (from.at_pole && !leads(solutions.ahead, best.branch, best.c)))
    return next(pose, solutions, from);
  JointSolution choice;
  choice.joints.a = best.a;
  choice.joints.c = best.c;
  choice.branch = best.branch;
  return choice;
}

std::optional<JointSolution> JointChooser::next_within_limits(const Pose& pose,
                                                              const std::array<Candidate, 2>& nearest,
                                                              const JointSolution& from,
                                                              const WayFromPole* ahead) const {
  std::optional<JointSolution> best;
  const auto time = [&](const JointSolution& choice) {
    return cost(choice.joints.a, choice.joints.c, from.joints);
  };
  for (const Candidate& near : nearest) {
    for (const double tilt_turn : {0.0, -360.0, 360.0}) {
      for (const double turn : {0.0, -360.0, 360.0}) {
        const JointSolution choice{rounded(pose.tip, near.a + tilt_turn, near.c + turn), near.branch, false,
                                   true};
        if (!within_limits(machine_, choice.joints)) continue;
        if (ahead && !leads(*ahead, near.branch, choice.joints.c)) continue;
        if (!best || time(choice) < time(*best) - kSameTime) best = choice;
      }
    }
  }
  return best;
}

std::optional<std::string> JointChooser::nearest_breaks(const Pose& pose, const JointSolution& from) const {
  const RotarySolutions solutions = solve(pose);
  if (!solutions.reachable) return std::nullopt;
  const auto [first, second] = candidates(solutions, from.joints);
  const bool swap = cost(second.a, second.c, from.joints) < cost(first.a, first.c, from.joints);
  return broken_limit(machine_, placed(pose.tip, swap ? second : first).joints);
}

Result<JointSolution> JointChooser::at_pole(const Pose& pose, const JointSolution& from, double c) const {
  const Vec3 axis = chain_.on_table(pose.axis);
  c = rounded_within(c, machine_.rotary, rotary_decimals_);
  const double tilt = chain_.nearest_tilt(axis, chain_.rotary_trig(c));
  const double wanted = nearest_turn(chain_.tilt_word(tilt), from.joints.a);
  // A tilt that ends at the pole stands at its limit while the axis passes within the cone beyond it.
  const double a = std::clamp(wanted, machine_.tilt.min, machine_.tilt.max);
  const double missed = std::abs(chain_.tilt_radians(a) - chain_.tilt_radians(wanted));
  JointSolution choice{rounded(pose.tip, missed <= pole_cone_ ? a : wanted, c), from.branch, true, false};
  if (auto text = broken_limit(machine_, choice.joints)) return fail(Code::kLimit, *text);
  return choice;
}

std::vector<JointSolution> JointChooser::choices(const Pose& pose, const RotarySolutions& solutions,
                                                 const JointSolution& from) const {
  if (!solutions.reachable) return {};
  std::vector<JointSolution> found;
  const double middle = (machine_.tilt.min + machine_.tilt.max) / 2.0;
  for (int branch = 0; branch < 2; ++branch) {
    const RotarySolutions::Words& words = solutions.words[branch];
    const bool held = solutions.in_cone || solutions.rotary_free;
    const double c = held ? from.joints.c : words.rotary,
                 a = nearest_turn(words.tilt, std::isfinite(middle) ? middle : machine_.tilt.zero);
    // The turns next to the limits are within them: from there the rotary can go furthest.
    const double turns[] = {from.joints.c, 0.0, machine_.rotary.min + 180.0, machine_.rotary.max - 180.0};
    for (const double near : turns) {
      if (!std::isfinite(near)) continue;
      for (const double turn : {0.0, -360.0, 360.0}) {
        const double word = nearest_turn(c, near) + turn;
        auto choice = held ? at_pole(pose, from, word)
                           : JointSolution{rounded(pose.tip, a, word), branch, false, false};
        if (!choice || !within_limits(machine_, choice->joints)) continue;
        const bool known = std::any_of(found.begin(), found.end(), [&](const JointSolution& other) {
          return other.joints == choice->joints && other.branch == choice->branch;
        });
        if (!known) found.push_back(*choice);
      }
    }
  }
  return found;
}

std::vector<JointSolution> JointChooser::start_turns(const Pose& pose, const JointSolution& first) const {
  std::vector<JointSolution> found;
  for (int turn = -kStartTurns; turn <= kStartTurns; ++turn) {
    const double c = first.joints.c + 360.0 * turn;
    if (first.at_pole) {
      if (const auto standing = at_pole(pose, first, c)) found.push_back(*standing);
      continue;
    }
    const JointSolution choice{rounded(pose.tip, first.joints.a, c), first.branch, false, false};
    if (within_limits(machine_, choice.joints)) found.push_back(choice);
  }
  return found;
}

Result<std::vector<JointSolution>> JointChooser::starts(const Pose& pose,
                                                        const RotarySolutions* leave) const {
  // The turn nearest to 0, or to the limit next to it, and its neighbours.
  const double base = std::clamp(0.0, machine_.rotary.min, machine_.rotary.max);
  JointSolution home;
  home.joints.c = base;
  const RotarySolutions solutions = solve(pose);
  std::vector<JointSolution> found;
  if (solutions.in_cone) {
    home.at_pole = true;
    for (int branch = 0; branch < 2 && leave != nullptr; ++branch) {
      home.branch = branch;
      home.joints.c = nearest_turn(leave->words[branch].rotary, base);
      for (const JointSolution& choice : start_turns(pose, home)) found.push_back(choice);
    }
    home.branch = 0, home.joints.c = base;
    if (found.empty()) found = start_turns(pose, home);
    if (found.empty()) return fail(Code::kLimit, at_pole(pose, home, base).error().message);
  } else {
    if (!solutions.reachable) return unreachable(pose);
    const std::array<Candidate, 2> nearest = candidates(solutions, home.joints);
    for (const Candidate& near : nearest)
      for (const JointSolution& choice : start_turns(pose, placed(pose.tip, near))) found.push_back(choice);
    if (found.empty()) {
      const auto text = broken_limit(machine_, placed(pose.tip, nearest[0]).joints);
      return fail(Code::kLimit, text ? *text : *broken_limit(machine_, placed(pose.tip, nearest[1]).joints));
    }
  }
  const auto preferred = [&](const JointSolution& choice) {
    const bool ahead = choice.at_pole && leave != nullptr;
    const double tilt = ahead ? leave->words[choice.branch].tilt : choice.joints.a;
    return (tilt - machine_.tilt.zero) * machine_.preferred_tilt > 0.0;
  };
  std::stable_sort(found.begin(), found.end(), [&](const JointSolution& p, const JointSolution& q) {
    if (preferred(p) != preferred(q)) return preferred(p);
    if (std::abs(p.joints.c) != std::abs(q.joints.c)) return std::abs(p.joints.c) < std::abs(q.joints.c);
    return p.joints.a > q.joints.a;
  });
  if (found.size() > kMaxStarts) found.resize(kMaxStarts);
  return found;
}

}  // namespace tiltfeed
