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

namespace tiltfeed::daemon {
namespace {

// The rotaries of the table turn so far in a block at most, both together, degrees. Between its ends the
// slides leave their place by 4 % of the tip's distance from the axes.
constexpr double kStep = 30.0;

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

}  // namespace

Joints axes_under_tcp(const MachineModel& machine, const Setup& setup, const Joints& words) {
  return solve_linear(machine, setup, pose_under_tcp(machine, setup, words).tip, words.a, words.c);
}

Joints first_place(const config::MachineProfile& machine, const Setup& setup, const Joints& words) {
  const config::ProgramFormat& format = machine.format;
  if (!format.tcp) return words;
  Joints axes = axes_under_tcp(machine.model, setup, words);
  axes.x = round_decimal(axes.x, format.linear_decimals);
  axes.y = round_decimal(axes.y, format.linear_decimals);
  return axes;
}

std::vector<Joints> tcp_start(const config::MachineProfile& machine, const Setup& setup,
                              const Joints& first) {
  const config::ProgramFormat& format = machine.format;
  if (!begins_at_home(machine) || at_home(machine, first)) return {};
  Joints home = first;
  // The rounded words must not be over the travel.
  const double below = std::max(format.tcp_start_below, std::pow(10.0, 1 - format.linear_decimals));
  home.z = std::max(first.z, machine.model.z.max - below);
  double turn_of_all = 0.0;
  for (const config::TableTurn& turn : config::table_turns(machine.model)) {
    home.*turn.word = *config::nearest_home(*turn.axis, first.*turn.word, format.rotary_decimals);
    turn_of_all += std::abs(first.*turn.word - home.*turn.word);
  }
  const double steps = std::ceil(turn_of_all / kStep);
  std::vector<Joints> places;
  for (double i = 0.0; i <= steps; ++i) {
    Joints at = home;
    for (double Joints::*word : {&Joints::a, &Joints::c})
      at.*word = round_decimal(home.*word + (first.*word - home.*word) * i / steps, format.rotary_decimals);
    const Vec3 tip = setup.fixture * from_origin(forward(machine.model, setup, at).tip);
    at.x = round_decimal(tip.x, format.linear_decimals);
    at.y = round_decimal(tip.y, format.linear_decimals);
    at.z = round_decimal(tip.z, format.linear_decimals);
    places.push_back(at);
  }
  return places;
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
