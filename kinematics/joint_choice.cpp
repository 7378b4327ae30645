#include "kinematics/joint_choice.h"

#include <algorithm>
#include <cmath>

#include "kinematics/decimal.h"

namespace tiltfeed {
namespace {

// Two ways whose times (min) differ by less are equally long: rounding noise of the angles.
constexpr double kSameTime = 1e-12;
// Starts to consider: two branches on a few turns of the table.
constexpr std::size_t kMaxStarts = 8;
constexpr int kStartTurns = 2;

double nearest_turn(double word, double from) { return word + 360.0 * std::round((from - word) / 360.0); }

/// The word rounded; to the other side where rounding alone would carry it over a limit.
double rounded_within(double word, const RotaryAxis& axis, int decimals) {
  const double rounded = round_decimal(word, decimals), step = 1.0 / decimal_scale(decimals);
  if (rounded < axis.min && rounded + step >= axis.min) return round_decimal(rounded + step, decimals);
  if (rounded > axis.max && rounded - step <= axis.max) return round_decimal(rounded - step, decimals);
  return rounded;
}

}  // namespace

JointChooser::JointChooser(const MachineModel& machine, const Setup& setup, int linear_decimals,
                           int rotary_decimals, double pole_cone)
    : machine_(machine),
      chain_(machine, setup),
      linear_decimals_(linear_decimals),
      rotary_decimals_(rotary_decimals),
      pole_cone_(pole_cone) {}

Joints JointChooser::rounded(Point<Part> tip, double a, double c) const {
  // (K9): rotaries first, then X Y Z from the rounded angles.
  a = rounded_within(a, machine_.tilt, rotary_decimals_);
  c = rounded_within(c, machine_.rotary, rotary_decimals_);
  const Vec3 p = chain_.linear(tip, Trig::of(chain_.head_radians(a)), Trig::of(chain_.table_radians(c)));
  return {round_decimal(p.x, linear_decimals_), round_decimal(p.y, linear_decimals_),
          round_decimal(p.z, linear_decimals_), a, c};
}

bool JointChooser::in_cone(const Pose& pose) const {
  const Vec3 axis = chain_.on_table(pose.axis);
  return std::hypot(axis.x, axis.y) <= std::sin(pole_cone_) && axis.z > 0.0;
}

Result<std::array<RotaryAngles, 2>> JointChooser::solve(const Pose& pose, double c_at_pole) const {
  const Vec3 axis = chain_.on_table(pose.axis);
  const auto solved = chain_.solve_axis(axis, chain_.table_radians(c_at_pole));
  if (!solved) return fail(Code::kUnreachable, unreachable_text(machine_, pose.axis, axis));
  return *solved;
}

double JointChooser::cost(const Choice& choice, const Choice& from) const {
  return std::max(std::abs(choice.joints.a - from.joints.a) / machine_.tilt.velocity,
                  std::abs(choice.joints.c - from.joints.c) / machine_.rotary.velocity);
}

Choice JointChooser::candidate(const Pose& pose, const RotaryAngles& angles, int branch,
                               const Choice& from) const {
  const double a = nearest_turn(chain_.head_word(angles.head), from.joints.a);
  const double c = nearest_turn(chain_.table_word(angles.table), from.joints.c);
  return {rounded(pose.tip, a, c), branch, false, false};
}

Result<Choice> JointChooser::next(const Pose& pose, const Choice& from) const {
  if (in_cone(pose)) return at_pole(pose, from, from.joints.c);
  const auto angles = solve(pose, from.joints.c);
  if (!angles) return tl::unexpected(angles.error());
  std::array<Choice, 2> nearest{candidate(pose, (*angles)[0], 0, from),
                                candidate(pose, (*angles)[1], 1, from)};
  const double difference = cost(nearest[1], from) - cost(nearest[0], from);
  const bool swap = std::abs(difference) <= kSameTime ? from.branch == 1 : difference < 0.0;
  if (swap) std::swap(nearest[0], nearest[1]);
  if (within_limits(machine_, nearest[0].joints)) return nearest[0];
  return next_within_limits(pose, nearest, from);
}

Result<Choice> JointChooser::next_within_limits(const Pose& pose, const std::array<Choice, 2>& nearest,
                                                const Choice& from) const {
  std::optional<Choice> best;
  for (const Choice& near : nearest) {
    for (const double tilt_turn : {0.0, -360.0, 360.0}) {
      for (const double turn : {0.0, -360.0, 360.0}) {
        Choice choice = near;
        choice.joints = rounded(pose.tip, near.joints.a + tilt_turn, near.joints.c + turn);
        choice.forced = true;
        if (!within_limits(machine_, choice.joints)) continue;
        if (!best || cost(choice, from) < cost(*best, from) - kSameTime) best = choice;
      }
    }
  }
  if (best) return *best;
  return fail(Code::kLimit, *broken_limit(machine_, nearest[0].joints));
}

std::optional<std::string> JointChooser::nearest_breaks(const Pose& pose, const Choice& from) const {
  const auto angles = solve(pose, from.joints.c);
  if (!angles) return std::nullopt;
  std::array<Choice, 2> nearest{candidate(pose, (*angles)[0], 0, from),
                                candidate(pose, (*angles)[1], 1, from)};
  return broken_limit(machine_, nearest[cost(nearest[1], from) < cost(nearest[0], from) ? 1 : 0].joints);
}

Result<Choice> JointChooser::at_pole(const Pose& pose, const Choice& from, double c) const {
  const Vec3 axis = chain_.on_table(pose.axis);
  c = rounded_within(c, machine_.rotary, rotary_decimals_);
  const double head = chain_.nearest_head(axis, Trig::of(chain_.table_radians(c)));
  const double wanted = nearest_turn(chain_.head_word(head), from.joints.a);
  // A head that ends at the pole stands at its limit while the axis passes within the cone beyond it.
  const double a = std::clamp(wanted, machine_.tilt.min, machine_.tilt.max);
  const double missed = std::abs(chain_.head_radians(a) - chain_.head_radians(wanted));
  Choice choice{rounded(pose.tip, missed <= pole_cone_ ? a : wanted, c), from.branch, true, false};
  if (auto text = broken_limit(machine_, choice.joints)) return fail(Code::kLimit, *text);
  return choice;
}

std::vector<Choice> JointChooser::start_turns(const Pose& pose, const Choice& first) const {
  std::vector<Choice> found;
  for (int turn = -kStartTurns; turn <= kStartTurns; ++turn) {
    Choice choice = first;
    choice.joints.c = first.joints.c + 360.0 * turn;
    if (first.at_pole) {
      if (const auto standing = at_pole(pose, choice, choice.joints.c)) found.push_back(*standing);
      continue;
    }
    choice.joints = rounded(pose.tip, choice.joints.a, choice.joints.c);
    if (within_limits(machine_, choice.joints)) found.push_back(choice);
  }
  return found;
}

Result<std::vector<Choice>> JointChooser::starts(const Pose& pose) const {
  // The turn nearest to 0, or to the limit next to it, and its neighbours.
  const double base = std::clamp(0.0, machine_.rotary.min, machine_.rotary.max);
  const Choice home{{0.0, 0.0, 0.0, 0.0, base}, 0, in_cone(pose), false};
  std::vector<Choice> found;
  if (home.at_pole) {
    found = start_turns(pose, home);
    if (found.empty()) return fail(Code::kLimit, at_pole(pose, home, base).error().message);
  } else {
    const auto angles = solve(pose, base);
    if (!angles) return tl::unexpected(angles.error());
    std::array<Choice, 2> nearest;
    for (int branch = 0; branch < 2; ++branch) {
      nearest[branch] = candidate(pose, (*angles)[branch], branch, home);
      for (const Choice& choice : start_turns(pose, nearest[branch])) found.push_back(choice);
    }
    if (found.empty()) {
      const auto text = broken_limit(machine_, nearest[0].joints);
      return fail(Code::kLimit, text ? *text : *broken_limit(machine_, nearest[1].joints));
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Choice& p, const Choice& q) {
    if (std::abs(p.joints.c) != std::abs(q.joints.c)) return std::abs(p.joints.c) < std::abs(q.joints.c);
    return p.joints.a > q.joints.a;
  });
  if (found.size() > kMaxStarts) found.resize(kMaxStarts);
  return found;
}

}  // namespace tiltfeed
