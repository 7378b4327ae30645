#include "daemon/post/tcp_start.h"

#include <algorithm>
#include <cmath>

#include "kinematics/basics/decimal.h"
#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {
namespace {

// The rotaries of the table turn so far in a block at most, both together, degrees. Between its ends the
// slides leave their place by 4 % of the tip's distance from the axes.
constexpr double kStep = 30.0;
constexpr double kTurn = 360.0;

bool at_home(const config::MachineProfile& machine, const Joints& words) {
  for (const TableTurn& turn : table_turns(machine.model))
    if (nearest_home(*turn.axis, words.*turn.word, machine.format.rotary_decimals) != words.*turn.word)
      return false;
  return true;
}

}  // namespace

std::vector<TableTurn> table_turns(const MachineModel& machine) {
  std::vector<TableTurn> turns;
  if (machine.structure == Structure::kTableTable && machine.tilt.present)
    turns.push_back({&machine.tilt, &Joints::a});
  if (machine.structure != Structure::kHeadHead && machine.rotary.present)
    turns.push_back({&machine.rotary, &Joints::c});
  return turns;
}

std::optional<double> nearest_home(const RotaryAxis& axis, double word, int decimals) {
  const double turns = std::round((word - axis.zero) / kTurn);
  const double least = std::ceil((axis.min - axis.zero) / kTurn),
               most = std::floor((axis.max - axis.zero) / kTurn);
  if (least > most) return std::nullopt;
  return round_decimal(axis.zero + kTurn * std::clamp(turns, least, most), decimals);
}

std::vector<Joints> tcp_start(const config::MachineProfile& machine, const Setup& setup,
                              const Joints& first) {
  const config::ProgramFormat& format = machine.format;
  if (!format.tcp || !config::begins_at_home(format.dialect) || at_home(machine, first)) return {};
  Joints home = first;
  // The rounded words must not be over the travel.
  const double below = std::max(format.tcp_start_below, std::pow(10.0, 1 - format.linear_decimals));
  home.z = std::max(first.z, machine.model.z.max - below);
  double turn_of_all = 0.0;
  for (const TableTurn& turn : table_turns(machine.model)) {
    home.*turn.word = *nearest_home(*turn.axis, first.*turn.word, format.rotary_decimals);
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

std::optional<std::string> no_home(const config::MachineProfile& machine, const Joints& first) {
  const config::ProgramFormat& format = machine.format;
  if (!format.tcp || !config::begins_at_home(format.dialect)) return std::nullopt;
  for (const TableTurn& turn : table_turns(machine.model))
    if (!nearest_home(*turn.axis, first.*turn.word, format.rotary_decimals))
      return std::string(config::name_of(format.dialect).name) +
             " may count X Y Z from the table as it stands where TCP begins, and the travel of " +
             turn.axis->letter + " has no place at home for that; post without tcp";
  return std::nullopt;
}

}  // namespace tiltfeed::daemon
