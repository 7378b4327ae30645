#include "sim/control/plane_words.h"

#include <array>
#include <cstdlib>
#include <vector>

#include "kinematics/basics/units.h"

namespace tiltfeed::sim {
namespace {

using Wrong = std::optional<std::string>;
constexpr std::array<Vec3, 3> kAxes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};

/// A turn about x (0), y (1) or z (2).
Rotation about(std::size_t axis, double degrees) {
  return rotation_about(kAxes[axis], Angle::from_degrees(degrees).radians());
}

std::optional<double> number_of(std::string_view text) {
  const std::string digits(text);
  char* end = nullptr;
  const double value = std::strtod(digits.c_str(), &end);
  if (digits.empty() || *end != '\0' || digits.find_first_not_of("+-.0123456789") != digits.npos)
    return std::nullopt;
  return value;
}

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = text.find(at);
    parts.push_back(text.substr(0, end));
    if (end == text.npos) return parts;
    text.remove_prefix(end + 1);
  }
}

}  // namespace

Wrong read_g68_2(const ControlWords& words, ReadPlane& plane) {
  constexpr std::string_view kTaken = "XYZIJK";
  for (char letter = 'A'; letter <= 'Z'; ++letter)
    if (words.has(letter) && kTaken.find(letter) == kTaken.npos)
      return std::string(1, letter) + " beside G68.2 is not understood: only X Y Z I J K are";
  for (const char letter : kTaken)
    if (!words.has(letter) || !words.has_point(letter))
      return std::string("G68.2 without ") + letter + ", or its number without a point";
  if (words.g_count > 1 || words.m_count > 0 || words.name_count > 0)
    return "G68.2 stands with other words; let it stand alone";
  plane.origin = {words['X'], words['Y'], words['Z']};
  plane.frame = about(2, words['I']) * about(0, words['J']) * about(2, words['K']);
  return std::nullopt;
}

Wrong read_cycle800(std::string_view call, ReadPlane& plane) {
  constexpr std::size_t kFirst = std::string_view("CYCLE800(").size();
  constexpr std::size_t kSwivel = 1, kMode = 3, kOrigin = 4, kTurns = 7, kShift = 10, kDirection = 13;
  if (call.size() < kFirst + 1 || call.back() != ')') return "CYCLE800 without its brackets";
  const auto parts = split(call.substr(kFirst, call.size() - kFirst - 1), ',');
  if (parts.size() != 15) return "CYCLE800 wants 15 values";
  std::array<double, 15> value{};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i == kSwivel && parts[i] == "\"0\"") return "CYCLE800 with \"0\" ends the swivel data";
    if (i == kSwivel) continue;  // the name of the swivel data
    const auto number = number_of(parts[i]);
    if (!number) return "\"" + std::string(parts[i]) + "\" in CYCLE800 is no number";
    value[i] = *number;
  }
  const bool moves = value[0] != 0.0 || value[14] != 0.0;
  if (moves || value[2] != 0.0) return "CYCLE800 that retracts by itself or adds to a plane is refused";
  for (std::size_t i = kShift; i < kShift + 3; ++i)
    if (value[i] != 0.0) return "CYCLE800 with a second shift is refused";
  if (value[kMode] != 27.0 && value[kMode] != 57.0)
    return "CYCLE800 in another mode than 27 or 57, turns by axis, is refused";
  plane.side = value[kDirection] == 1.0 ? 1 : value[kDirection] == -1.0 ? -1 : 0;
  if (plane.side == 0) return "CYCLE800 without a direction of 1 or -1";
  plane.origin = {value[kOrigin], value[kOrigin + 1], value[kOrigin + 2]};
  // Two bits an axis, that of the first turn the lowest: 1 x, 2 y, 3 z.
  const int mode = static_cast<int>(value[kMode]);
  for (std::size_t i = 0; i < 3; ++i)
    plane.frame = plane.frame * about(static_cast<std::size_t>((mode >> (2 * i) & 3) - 1), value[kTurns + i]);
  return std::nullopt;
}

std::optional<std::string_view> swivel_name(std::string_view call) {
  const std::size_t open = call.find('"');
  const std::size_t close = open == call.npos ? call.npos : call.find('"', open + 1);
  if (close == call.npos) return std::nullopt;
  return call.substr(open + 1, close - open - 1);
}

Wrong read_plane_spatial(std::string_view line, ReadPlane& plane) {
  const auto words = split(line, ' ');
  const std::array<std::string_view, 9> form{"PLANE", "SPATIAL", "SPA",   "SPB", "SPC",
                                             "STAY",  "SEQ",     "TABLE", "ROT"};
  if (words.size() != form.size()) return "expected PLANE SPATIAL SPA SPB SPC STAY SEQ TABLE ROT";
  std::array<double, 3> turn{};
  for (std::size_t i = 0; i < form.size(); ++i) {
    const bool open = (i >= 2 && i <= 4) || i == 6;
    if (open ? !words[i].starts_with(form[i]) : words[i] != form[i])
      return "\"" + std::string(words[i]) + "\" in a tilted plane is not understood; expected " +
             std::string(form[i]) +
             (form[i] == "STAY" ? ": any other word for it turns the rotaries by itself" : "");
    if (i < 2 || i > 4) continue;
    const auto number = number_of(words[i].substr(form[i].size()));
    if (!number) return "\"" + std::string(words[i]) + "\" has no number";
    turn[i - 2] = *number;
  }
  if (words[6] != "SEQ+" && words[6] != "SEQ-") return "expected SEQ+ or SEQ-";
  plane.side = words[6] == "SEQ+" ? 1 : -1;
  plane.origin = {};
  plane.frame = about(2, turn[2]) * about(1, turn[1]) * about(0, turn[0]);
  return std::nullopt;
}

}  // namespace tiltfeed::sim
