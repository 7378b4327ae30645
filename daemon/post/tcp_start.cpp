#include "daemon/post/tcp_start.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <utility>

#include "config/table_home.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/machine/machine.h"
#include "kinematics/timing/tcp_path.h"
#include "kinematics/timing/timing.h"

namespace tiltfeed::daemon {
namespace {

// A slide that is nearer to an end of its travel than this is over it: another's arithmetic differs by less,
// mm.
constexpr double kAtEnd = 1e-9;
// A slide at an end of its travel is moved off it so often: once each does, but for what a move of one does
// to others.
constexpr int kTries = 8;

bool begins_at_home(const config::MachineProfile& machine) {
  return machine.format.tcp && config::begins_at_home(machine.format.dialect);
}

bool at_home(const config::MachineProfile& machine, const Joints& words) {
  for (const config::TableTurn& turn : config::table_turns(machine.model))
    if (config::nearest_home(*turn.axis, words.*turn.word, machine.format.rotary_decimals) !=
        words.*turn.word)
      return false;
  return true;
}

/// How far a word is over an end of the axis's travel, with its sign.
double over_end(const LinearAxis& axis, double word) {
  return std::max(word - (axis.max - kAtEnd), 0.0) - std::max(axis.min + kAtEnd - word, 0.0);
}

/// One in the last decimal of a linear word, mm.
double last_digit(const config::ProgramFormat& format) {
  return config::unit_of(format) / decimal_scale(format.linear_decimals);
}

/// Rounded, and not over an end of the axis's travel by that.
double rounded_within(const config::ProgramFormat& format, const LinearAxis& axis, double word) {
  const double rounded = config::printed_place(format, word), unit = last_digit(format);
  const double over = over_end(axis, rounded);
  if (over == 0.0 || std::abs(over) > unit) return rounded;
  return config::printed_place(format, rounded - std::copysign(unit, over));
}

/// The words under TCP that put the axes at `at`: rounded, and no slide over an end of its travel by that.
Joints rounded_words(const config::MachineProfile& machine, const Setup& setup, Joints at) {
  const MachineModel& model = machine.model;
  const config::ProgramFormat& format = machine.format;
  Joints words = at;
  for (int tries = 0; tries < kTries; ++tries) {
    const Vec3 tip = setup.fixture * from_origin(forward(model, setup, at).tip);
    words.x = config::printed_place(format, tip.x);
    words.y = config::printed_place(format, tip.y);
    words.z = config::printed_place(format, tip.z);
    const Joints axes = axes_under_tcp(model, setup, words);
    bool within = true;
    for (const auto& [axis, word] :
         {std::pair{&model.x, &Joints::x}, {&model.y, &Joints::y}, {&model.z, &Joints::z}}) {
      const double over = over_end(*axis, axes.*word);
      if (over == 0.0) continue;
      at.*word -= over + std::copysign(last_digit(format), over);
      within = false;
    }
    if (within) break;
  }
  return words;
}

}  // namespace

Joints axes_under_tcp(const MachineModel& machine, const Setup& setup, const Joints& words) {
  return solve_linear(machine, setup, pose_under_tcp(machine, setup, words).tip, words.a, words.c);
}

Joints first_place(const config::MachineProfile& machine, const Setup& setup, const Joints& words) {
  if (!machine.format.tcp) return words;
  return place_above(machine, setup, words);
}

Joints place_above(const config::MachineProfile& machine, const Setup& setup, const Joints& tip_words) {
  const config::ProgramFormat& format = machine.format;
  Joints axes = axes_under_tcp(machine.model, setup, tip_words);
  axes.x = rounded_within(format, machine.model.x, axes.x);
  axes.y = rounded_within(format, machine.model.y, axes.y);
  return axes;
}

std::vector<Joints> tcp_start(const config::MachineProfile& machine, const Setup& setup,
                              const Joints& first) {
  const config::ProgramFormat& format = machine.format;
  if (!begins_at_home(machine) || at_home(machine, first)) return {};
  Joints home = first;
  home.z = std::max(first.z, machine.model.z.max - format.tcp_start_below);
  double turn_of_all = 0.0;
  for (const config::TableTurn& turn : config::table_turns(machine.model)) {
    home.*turn.word = *config::nearest_home(*turn.axis, first.*turn.word, format.rotary_decimals);
    turn_of_all += std::abs(first.*turn.word - home.*turn.word);
  }
  const double steps = std::ceil(turn_of_all / kStartStep);
  std::vector<Joints> places;
  for (double i = 0.0; i <= steps; ++i) {
    Joints at = home;
    for (double Joints::*word : {&Joints::a, &Joints::c})
      at.*word = round_decimal(home.*word + (first.*word - home.*word) * i / steps, format.rotary_decimals);
    places.push_back(rounded_words(machine, setup, at));
  }
  return places;
}

std::vector<JointMove> start_moves(const config::MachineProfile& machine, const Setup& setup,
                                   const std::vector<JointMove>& moves) {
  std::vector<JointMove> all;
  const Joints& first = moves.front().joints;
  for (const Joints& words : tcp_start(machine, setup, first))
    all.push_back({axes_under_tcp(machine.model, setup, words), 0.0, MoveKind::kRapid, 0});
  if (all.empty()) return all;
  all.push_back(moves.front());
  for (std::size_t i = 1; i < all.size(); ++i)
    all[i].seconds = rapid_seconds(machine.model, all[i - 1].joints, all[i].joints);
  return all;
}

Result<void> tcp_can_begin(const config::MachineProfile& machine, std::size_t operations) {
  const std::string file = machine.path.empty() ? "" : machine.path + ": ";
  if (const auto wrong = config::no_home(machine.model, machine.format))
    return fail(Code::kInput, file + "program.tcp: " + *wrong);
  if (operations > 1 && begins_at_home(machine) && machine.format.retract == "none" &&
      !config::table_turns(machine.model).empty())
    return fail(Code::kInput, file + "program.retract: none: TCP in " +
                                  config::name_of(machine.format.dialect).name +
                                  " begins anew in each operation, and the table turns home before, under "
                                  "the tool where the operation before has left it: state a retract, post "
                                  "the operations one by one, or post without tcp");
  return {};
}

}  // namespace tiltfeed::daemon
