#include "config/machine_vectors.h"

#include "config/key_ranges.h"

#include <cmath>

#include "kinematics/basics/decimal.h"

namespace tiltfeed::config {
namespace {

constexpr Range kWord{-1'000'000.0, 1'000'000.0};  // degrees
constexpr Range kToolLength{0.0, 10'000.0};        // mm
constexpr Range kMeasured = above(0.0, 10.0);      // mm; a place found less well says nothing of a sign
constexpr std::size_t kMostVectors = 100;
// An axis that was seen, not measured: which way the tool leans.
const double kSeen = Angle::from_degrees(5.0).radians();

double word_of(const Section& item, const char* key, const RotaryAxis& axis) {
  if (axis.present) return item.number(key, kWord);
  item.unused(key, "by a machine without that axis");
  return 0.0;
}

std::string triple(double x, double y, double z) {
  return "(" + decimal(x, 4) + ", " + decimal(y, 4) + ", " + decimal(z, 4) + ")";
}

bool agrees(const MachineModel& model, const MachineVector& v) {
  const Pose pose = forward(model, v.setup, v.words);
  return distance(pose.tip, v.tip) <= v.tolerance && (!v.axis || angle_between(pose.axis, *v.axis) <= kSeen);
}

/// The signs that have to be turned for the model to agree; empty where turning them does not help.
std::string signs_that_help(const MachineModel& model, const MachineVector& v) {
  for (const int turned : {1, 2, 3}) {
    MachineModel other = model;
    std::string keys;
    if (turned & 1) {
      other.tilt.sign = -other.tilt.sign;
      keys = "tilt.sign: " + std::to_string(other.tilt.sign);
    }
    if (turned & 2) {
      other.rotary.sign = -other.rotary.sign;
      keys += (keys.empty() ? "rotary.sign: " : " and rotary.sign: ") + std::to_string(other.rotary.sign);
    }
    if (agrees(other, v)) return keys;
  }
  return {};
}

}  // namespace

std::optional<std::string> disagreement(const MachineModel& model, const MachineVector& v) {
  if (agrees(model, v)) return std::nullopt;
  const Pose pose = forward(model, v.setup, v.words);
  std::string text = "the profile puts the tool at " + triple(pose.tip.x, pose.tip.y, pose.tip.z) +
                     ", axis " + triple(pose.axis.x, pose.axis.y, pose.axis.z) + "; measured " +
                     triple(v.tip.x, v.tip.y, v.tip.z) + ", " + decimal(distance(pose.tip, v.tip), 4) +
                     " mm away";
  if (v.axis) text += ", axis " + triple(v.axis->x, v.axis->y, v.axis->z);
  const std::string signs = signs_that_help(model, v);
  if (!signs.empty()) return text + "; it would agree with " + signs;
  return text + "; no sign makes it agree: look at zeros, offsets and tool length";
}

std::vector<MachineVector> read_vectors(const Section& root, const MachineModel& model) {
  std::vector<MachineVector> vectors;
  if (!root.has("check")) return vectors;
  for (const Section& item : root.list("check",
                                       {"x_mm", "y_mm", "z_mm", "tilt_deg", "rotary_deg", "tip_mm", "axis",
                                        "part_zero_mm", "tool_length_mm", "tolerance_mm"},
                                       kMostVectors)) {
    MachineVector v;
    v.words = {item.number("x_mm", kMachinePlace), item.number("y_mm", kMachinePlace),
               item.number("z_mm", kMachinePlace), word_of(item, "tilt_deg", model.tilt),
               word_of(item, "rotary_deg", model.rotary)};
    const Vec3 tip = item.vector("tip_mm", kMachinePlace);
    v.tip = {tip.x, tip.y, tip.z};
    if (item.has("axis")) v.axis = item.direction("axis");
    v.setup.part_zero = item.vector("part_zero_mm", kMachinePlace, Vec3{});
    v.setup.tool_length = item.number("tool_length_mm", kToolLength, 0.0);
    v.tolerance = item.number("tolerance_mm", kMeasured, v.tolerance);
    if (const auto text = disagreement(model, v)) item.complain("tip_mm", *text);
    vectors.push_back(v);
  }
  return vectors;
}

void describe_vectors(Description& out, const std::vector<MachineVector>& vectors) {
  out.add("check", std::to_string(vectors.size()) + " measured places agree");
}

}  // namespace tiltfeed::config
