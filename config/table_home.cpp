#include "config/table_home.h"

#include <algorithm>
#include <cmath>

#include "kinematics/basics/decimal.h"

namespace tiltfeed::config {
namespace {

constexpr double kFullTurn = 360.0;

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
  const double turns = std::round((word - axis.zero) / kFullTurn);
  const double least = std::ceil((axis.min - axis.zero) / kFullTurn),
               most = std::floor((axis.max - axis.zero) / kFullTurn);
  if (least > most) return std::nullopt;
  const double unit = 1.0 / decimal_scale(decimals);
  const double home = round_decimal(axis.zero + kFullTurn * std::clamp(turns, least, most), decimals);
  if (home > axis.max) return round_decimal(home - unit, decimals);
  return home < axis.min ? round_decimal(home + unit, decimals) : home;
}

std::optional<std::string> no_home(const MachineModel& machine, const ProgramFormat& format) {
  if (!format.tcp || !begins_at_home(format.dialect)) return std::nullopt;
  for (const TableTurn& turn : table_turns(machine))
    if (!nearest_home(*turn.axis, turn.axis->zero, format.rotary_decimals))
      return std::string(name_of(format.dialect).name) +
             " may count X Y Z from the table as it stands where TCP begins, and the travel of " +
             turn.axis->letter + " has no place at home for that; post without tcp";
  return std::nullopt;
}

}  // namespace tiltfeed::config
