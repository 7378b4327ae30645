#include "daemon/measure/check_result.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "daemon/measure/ball_readings.h"
#include "daemon/measure/pivot_fit.h"
#include "daemon/post/machine_check.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

constexpr std::size_t kFewestStops = 3;
constexpr double kMostLength = 10'000.0;

tl::unexpected<Error> wrong(const std::string& path, int line, const std::string& what) {
  return fail(Code::kInput, path + ":" + std::to_string(line) + ": " + what);
}

/// The four columns of a line: stop and three lengths.
Result<std::vector<double>> numbers_of(const std::vector<std::string>& cells, const std::string& path,
                                       int line) {
  std::vector<double> numbers;
  for (const std::string& cell : cells) {
    double value = 0.0;
    const char* const end = cell.data() + cell.size();
    const auto parsed = std::from_chars(cell.data() + (cell.starts_with('+') ? 1 : 0), end, value);
    if (parsed.ec != std::errc() || parsed.ptr != end || !(std::abs(value) <= kMostLength))
      return wrong(path, line, "'" + cell.substr(0, 40) + "' is no number up to 10000");
    numbers.push_back(value);
  }
  if (numbers.size() != 4)
    return wrong(path, line, "expected four values: the stop's number and three lengths");
  return numbers;
}

Result<BallReadings> read_table(const std::vector<CheckStop>& stops, double tool_length,
                                const std::string& table, const std::string& path) {
  BallReadings out;
  std::istringstream in(table);
  int line = 0;
  bool headed = false, off = false;
  for (std::string row; std::getline(in, row);) {
    ++line;
    const std::size_t first = row.find_first_not_of(" \t\r");
    if (first == std::string::npos || row[first] == '#') continue;
    const std::vector<std::string> cells = cells_of(row, ',');
    if (!headed) {
      off = cells == std::vector<std::string>{"stop", "dx_mm", "dy_mm", "dz_mm"};
      if (!off && cells != std::vector<std::string>{"stop", "x_mm", "y_mm", "z_mm"})
        return wrong(path, line, "expected the columns stop,x_mm,y_mm,z_mm or stop,dx_mm,dy_mm,dz_mm");
      headed = true;
      continue;
    }
    const auto numbers = numbers_of(cells, path, line);
    if (!numbers) return tl::unexpected<Error>(numbers.error());
    const double number = (*numbers)[0];
    if (number != std::floor(number) || number < 1 || number > static_cast<double>(stops.size()))
      return wrong(path, line,
                   "stop '" + cells[0] + "' is none of the program's 1 to " + std::to_string(stops.size()));
    if (std::find(out.places.begin(), out.places.end(), decimal(number, 0)) != out.places.end())
      return wrong(path, line, "stop " + decimal(number, 0) + " is there twice");
    const Joints q = stops[static_cast<std::size_t>(number) - 1].joints;
    const Vec3 found{(*numbers)[1], (*numbers)[2], (*numbers)[3]};
    const int place = static_cast<int>(out.places.size());
    // A tip that is off by d is centred by going back by d.
    out.all.push_back({{q.a, q.c, tool_length}, off ? Vec3{q.x, q.y, q.z} - found : found, place, line});
    out.places.push_back(decimal(number, 0));
  }
  if (out.places.size() < kFewestStops)
    return fail(Code::kInput, path + ": has " + std::to_string(out.places.size()) +
                                  " stops; expected at least " + std::to_string(kFewestStops));
  return out;
}

/// Where the ball is, and what else may be wrong.
std::vector<Unknown> freed(const MachineModel& m, const std::vector<Sought>& causes) {
  std::vector<Unknown> all;
  for (int i = 0; i < 3; ++i) all.push_back({m.rotary.present ? Sought::kBall : Sought::kCentre, i});
  if (m.structure == Structure::kHeadHead)
    for (Unknown& one : all) one.what = Sought::kBall;
  for (const Sought what : causes)
    for (int i = 0; i < (what == Sought::kTiltZero ? 1 : 3); ++i) all.push_back({what, i});
  return all;
}

/// Across the axis along which a point may slide.
Vec3 across(Vec3 v, const RotaryAxis& axis) { return v - axis.direction * dot(v, axis.direction); }

std::string list(Vec3 v) {
  return "[" + decimal(v.x, 3) + ", " + decimal(v.y, 3) + ", " + decimal(v.z, 3) + "]";
}

/// The change from one machine to the other as a person makes it.
std::string change_text(const MachineModel& from, const MachineModel& to, const std::vector<Sought>& causes) {
  std::vector<std::string> all;
  if (from.tilt.sign != to.tilt.sign) all.push_back("tilt.sign: " + std::to_string(to.tilt.sign));
  if (from.rotary.sign != to.rotary.sign) all.push_back("rotary.sign: " + std::to_string(to.rotary.sign));
  for (const Sought what : causes) {
    if (what == Sought::kTiltZero) all.push_back("tilt.zero_deg: " + decimal(to.tilt.zero, 4));
    if (what == Sought::kGauge)
      all.push_back("pivot_to_gauge_mm: " +
                    list(from.pivot_to_gauge + across(to.pivot_to_gauge - from.pivot_to_gauge, to.tilt)));
    if (what == Sought::kOffset) all.push_back("rotary_to_tilt_mm: " + list(to.rotary_to_tilt));
    if (what == Sought::kCentre)
      all.push_back("the work zero moved by " +
                    list(across(from_origin(to.table_centre) - from_origin(from.table_centre), to.rotary)) +
                    " onto the axis of " + to.rotary.letter);
  }
  std::string text;
  for (const std::string& one : all) text += (text.empty() ? "" : " and ") + one;
  return text;
}

/// Each by itself, then all together.
std::vector<std::vector<Sought>> causes_of(const MachineModel& m) {
  std::vector<std::vector<Sought>> all{{}};
  std::vector<Sought> together;
  const auto add = [&](bool is, Sought what) {
    if (!is) return;
    all.push_back({what});
    together.push_back(what);
  };
  const bool head_head = m.structure == Structure::kHeadHead;
  add(m.tilt.present && m.structure != Structure::kTableTable, Sought::kGauge);
  add(m.structure != Structure::kTableHead, Sought::kOffset);
  add(m.rotary.present && !head_head, Sought::kCentre);
  if (together.size() > 1) all.push_back(together);
  if (m.tilt.present) all.insert(all.begin() + 1, {Sought::kTiltZero});
  return all;
}

double worst_of(const Explanation& one) { return *std::max_element(one.rests.begin(), one.rests.end()); }

/// Signs with which the readings agree either way.
std::vector<std::string> unseen_signs(const BallMachine& machine, const BallReadings& readings,
                                      double within) {
  std::vector<std::string> all;
  for (const auto& [key, axis] :
       {std::pair{"tilt.sign", &MachineModel::tilt}, {"rotary.sign", &MachineModel::rotary}}) {
    BallMachine other = machine;
    RotaryAxis& turned = other.machine.*axis;
    turned.sign = -turned.sign;
    if (turned.present && worst_of(explained(other, readings, freed(other.machine, {}))) <= within)
      all.emplace_back(key);
  }
  return all;
}

}  // namespace

Result<CheckResult> judge_check(const config::MachineProfile& machine, double tool_length, double height,
                                double aside, const std::string& table, const std::string& path,
                                double within) {
  const auto stops = check_stops(machine, tool_length, height, aside);
  if (!stops) return tl::unexpected<Error>(stops.error());
  const auto readings = read_table(*stops, tool_length, table, path);
  if (!readings) return tl::unexpected<Error>(readings.error());
  // Words are read where the program's zero is: the table's point, seen by this tool at home.
  BallMachine start{machine.model, {aside, 0.0, height}, 0.0};
  const Vec3 centre = machine.model.spindle * -tool_length;
  start.machine.table_centre = {centre.x, centre.y, centre.z};
  if (!machine.model.rotary.present)
    start.machine.table_centre = start.machine.table_centre + start.ball, start.ball = {};
  const Explanation as_is = explained(start, *readings, freed(machine.model, {}));
  CheckResult result;
  result.stops = readings->places.size();
  result.worst = worst_of(as_is);
  result.passed = result.worst <= within;
  const auto at = static_cast<std::size_t>(std::max_element(as_is.rests.begin(), as_is.rests.end()) -
                                           as_is.rests.begin());
  const BallPlace& place = readings->all[at].at;
  result.where = "stop " + readings->places[at];
  for (const auto& [axis, word] :
       {std::pair{&machine.model.tilt, place.tilt}, {&machine.model.rotary, place.rotary}})
    if (axis->present) result.where += std::string(" ") + axis->letter + decimal(word, 3);
  if (result.passed) {
    result.unseen = unseen_signs(start, *readings, within);
    return result;
  }
  const auto all = causes_of(machine.model);
  for (std::size_t parts = 0; parts <= 2 && result.remedies.empty(); ++parts)
    for (const int turned : {0, 1, 2, 3}) {
      if ((turned & 1 && !machine.model.tilt.present) || (turned & 2 && !machine.model.rotary.present))
        continue;
      if (parts == 2 && !result.remedies.empty()) break;
      BallMachine other = start;
      if (turned & 1) other.machine.tilt.sign = -other.machine.tilt.sign;
      if (turned & 2) other.machine.rotary.sign = -other.machine.rotary.sign;
      for (const std::vector<Sought>& causes : all) {
        // First a sign or one thing alone, then signs with one thing, then all that there is.
        const std::size_t needed = causes.size() > 1 ? 2 : turned != 0 && !causes.empty() ? 1 : 0;
        if (needed != parts) continue;
        const Explanation one = explained(other, *readings, freed(machine.model, causes));
        if (worst_of(one) <= within && (turned != 0 || !causes.empty()))
          result.remedies.push_back({change_text(start.machine, one.machine.machine, causes), worst_of(one)});
      }
    }
  return result;
}

namespace {

std::string unseen_text(const CheckResult& r) {
  std::string keys;
  for (const std::string& key : r.unseen) keys += (keys.empty() ? "" : ", ") + key;
  if (keys.empty()) return "";
  return "; these stops do not tell " + keys +
         ": look which way the tool leans at each, or take the tip off the axis (--aside 50)";
}

}  // namespace

std::string text_of(const CheckResult& r, double within) {
  const std::string stops = std::to_string(r.stops) + " stops";
  if (r.passed)
    return "passed: " + stops + ", the tip strays by at most " + decimal(r.worst, 4) + " mm (allowed " +
           decimal(within, 4) + "), at " + r.where + unseen_text(r);
  std::string text = "FAILED: " + stops + ", the tip strays by " + decimal(r.worst, 4) + " mm (allowed " +
                     decimal(within, 4) + ") at " + r.where;
  if (r.remedies.empty())
    return text +
           "; no sign, zero, centre or pivot explains it: look at structure and directions, or measure them "
           "(tiltfeed machine measure)";
  for (std::size_t i = 0; i < r.remedies.size(); ++i)
    text += std::string(i == 0 ? "; it would agree, within " : "; or, within ") +
            decimal(r.remedies[i].worst, 4) + " mm, with " + r.remedies[i].change;
  return text;
}

}  // namespace tiltfeed::daemon
