#include "sim/controller/grbl_offsets.h"

#include <charconv>
#include <cmath>

namespace tiltfeed::sim {
namespace {

constexpr int kDecimals = 3;

std::string number_text(double value) {
  std::array<char, 350> text;
  const char* const end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, kDecimals).ptr;
  return {text.data(), static_cast<std::size_t>(end - text.data())};
}

GrblAxes plus(GrblAxes a, const GrblAxes& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

std::optional<double> number_of(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto parsed =
      std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

}  // namespace

GrblAxes grbl_axes(const Joints& joints) { return {joints.x, joints.y, joints.z, joints.a, joints.c}; }

Joints grbl_joints(const GrblAxes& axes) { return {axes[0], axes[1], axes[2], axes[3], axes[4]}; }

std::string grbl_text(const GrblAxes& axes) {
  std::string text;
  for (const double axis : axes) text += (text.empty() ? "" : ",") + number_text(axis);
  return text;
}

std::optional<GrblWords> grbl_words(std::string_view line) {
  GrblWords words;
  for (std::size_t at = 0; at < line.size();) {
    if (line[at] == ' ' || line[at] == '\t' || line[at] == '\r') {
      ++at;
      continue;
    }
    const char letter = static_cast<char>(line[at] & ~0x20);
    if (letter < 'A' || letter > 'Z') return std::nullopt;
    std::size_t end = ++at;
    while (end < line.size() && (line[end] == '.' || line[end] == '-' || line[end] == '+' ||
                                 (line[end] >= '0' && line[end] <= '9')))
      ++end;
    const auto value = number_of(line.substr(at, end - at));
    if (!value) return std::nullopt;
    words.emplace_back(letter, *value);
    at = end;
  }
  return words;
}

// ---- offsets ---------------------------------------------------------------------------------------------

GrblOffsets::GrblOffsets(const MachineModel& machine) {
  zero_[2] = machine.z.max;
  GrblAxes part_zero{};
  part_zero[2] = -machine.z.max;
  systems_.fill(part_zero);
}

GrblAxes GrblOffsets::machine(const Joints& at) const {
  GrblAxes axes = grbl_axes(at);
  for (std::size_t i = 0; i < axes.size(); ++i) axes[i] -= zero_[i];
  return axes;
}

GrblAxes GrblOffsets::work() const { return plus(plus(systems_[selected_], g92_), tool_); }

Joints GrblOffsets::shift() const { return grbl_joints(plus(work(), zero_)); }

std::string GrblOffsets::name(std::size_t system) {
  return system < 6 ? "G" + std::to_string(54 + system) : "G59." + std::to_string(system - 5);
}

std::string GrblOffsets::report() const {
  std::string text;
  for (std::size_t i = 0; i < kSystems; ++i) text += "[" + name(i) + ":" + grbl_text(systems_[i]) + "]\r\n";
  const std::string none = grbl_text({});
  text += "[G28:" + none + "]\r\n[G30:" + none + "]\r\n[G92:" + grbl_text(g92_) + "]\r\n";
  return text + "[TLO:" + grbl_text(tool_) + "]\r\n";
}

// ---- settings --------------------------------------------------------------------------------------------

GrblSettings::GrblSettings(const MachineModel& machine)
    : values_{{0, "10.0"},   {1, "25"},         {2, "0"},      {3, "0"},      {4, "0"},      {5, "0"},
              {6, "0"},      {10, "511"},       {11, "0.010"}, {12, "0.002"}, {13, "0"},     {20, "1"},
              {21, "0"},     {22, "0"},         {23, "0"},     {24, "25.0"},  {25, "500.0"}, {26, "250"},
              {27, "1.000"}, {30, "24000.000"}, {31, "0.000"}, {32, "0"}} {
  const double velocity[] = {machine.x.velocity, machine.y.velocity, machine.z.velocity,
                             machine.tilt.velocity, machine.rotary.velocity};
  const double acceleration[] = {machine.x.acceleration, machine.y.acceleration, machine.z.acceleration,
                                 machine.tilt.acceleration, machine.rotary.acceleration};
  const double travel[] = {machine.x.max - machine.x.min, machine.y.max - machine.y.min,
                           machine.z.max - machine.z.min, machine.tilt.max - machine.tilt.min,
                           machine.rotary.max - machine.rotary.min};
  for (int axis = 0; axis < 5; ++axis) {
    values_[100 + axis] = number_text(250.0);
    values_[110 + axis] = number_text(velocity[axis]);
    values_[120 + axis] = number_text(acceleration[axis]);
    values_[130 + axis] = number_text(travel[axis]);
  }
}

double GrblSettings::value(int number) const {
  const auto found = values_.find(number);
  return found == values_.end() ? 0.0 : number_of(found->second).value_or(0.0);
}

bool GrblSettings::set(int number, std::string_view text) {
  const auto found = values_.find(number);
  const auto value = number_of(text);
  if (found == values_.end() || !value) return false;
  found->second = found->second.find('.') == std::string::npos ? std::to_string(std::lround(*value))
                                                               : number_text(*value);
  return true;
}

std::string GrblSettings::report() const {
  std::string text;
  for (const auto& [number, value] : values_) text += "$" + std::to_string(number) + "=" + value + "\r\n";
  return text;
}

}  // namespace tiltfeed::sim
