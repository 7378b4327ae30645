#pragma once
// Work offsets of the Grbl firmware model, and its settings: what `$#`, `$$`, G10, G54..G59.3, G92 and G43.1
// read and write.

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/machine/machine.h"

namespace tiltfeed::sim {

using GrblAxes = std::array<double, 5>;  ///< X Y Z, tilt, rotary

GrblAxes grbl_axes(const Joints& joints);
Joints grbl_joints(const GrblAxes& axes);
/// Three decimals each, with commas between.
std::string grbl_text(const GrblAxes& axes);

/// Letter and value, as they stand in a line without blanks and comments; nothing where one is malformed.
using GrblWords = std::vector<std::pair<char, double>>;
std::optional<GrblWords> grbl_words(std::string_view line);

/// Machine coordinates have Z 0 at the top of its travel. At first every system has part zero where the job's
/// set-up has it.
class GrblOffsets {
 public:
  static constexpr std::size_t kSystems = 9;  ///< G54 to G59, G59.1 to G59.3

  explicit GrblOffsets(const MachineModel& machine);

  /// Machine coordinates of what the axes of the simulated machine say.
  GrblAxes machine(const Joints& at) const;
  /// From program coordinates to those of the simulated axes.
  Joints shift() const;
  /// From program coordinates to machine coordinates (WCO).
  GrblAxes work() const;

  void select(std::size_t system) { selected_ = system; }
  std::size_t selected() const { return selected_; }
  /// As a reset leaves it.
  void forget() { selected_ = 0, g92_ = tool_ = {}; }
  GrblAxes& system(std::size_t index) { return systems_[index]; }
  GrblAxes& g92() { return g92_; }
  GrblAxes& tool() { return tool_; }

  /// "G54" to "G59.3".
  static std::string name(std::size_t system);
  /// The reply to `$#`, without the probe's line.
  std::string report() const;

 private:
  GrblAxes zero_{};  ///< of machine coordinates, on the simulated axes
  std::array<GrblAxes, kSystems> systems_{};
  GrblAxes g92_{}, tool_{};
  std::size_t selected_ = 0;
};

/// Numbers and texts of `$$`. Homing ($22, $23, $27) and soft limits ($20) act; the others are kept.
class GrblSettings {
 public:
  explicit GrblSettings(const MachineModel& machine);

  double value(int number) const;
  /// False: there is no such setting, or the value is no number.
  bool set(int number, std::string_view text);
  std::string report() const;

 private:
  std::map<int, std::string> values_;
};

}  // namespace tiltfeed::sim
