#include "daemon/measure/measured_profile.h"

#include <algorithm>

#include "config/yaml_edit.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

// A direction's last digit moves a point 1 m away by 1e-6 mm; so near the pole stays in reach.
constexpr int kDirectionDigits = 9, kLengthDigits = 4, kAngleDigits = 5;

std::string list(Vec3 v, int digits) {
  return "[" + decimal(v.x, digits) + ", " + decimal(v.y, digits) + ", " + decimal(v.z, digits) + "]";
}

/// The value of a key as a profile has it; empty: no key.
std::string text_of(const std::string& key, const MachineModel& m) {
  if (key == "rotary.direction") return list(m.rotary.direction, kDirectionDigits);
  if (key == "tilt.direction") return list(m.tilt.direction, kDirectionDigits);
  if (key == "spindle_direction") return list(m.spindle, kDirectionDigits);
  if (key == "rotary.zero_deg") return decimal(m.rotary.zero, kAngleDigits);
  if (key == "tilt.zero_deg") return decimal(m.tilt.zero, kAngleDigits);
  if (key == "table_centre_mm") return list(from_origin(m.table_centre), kLengthDigits);
  if (key == "pivot_to_gauge_mm") return list(m.pivot_to_gauge, kLengthDigits);
  if (key == "rotary_to_tilt_mm") return list(m.rotary_to_tilt, kLengthDigits);
  if (key == "rotary.sign") return std::to_string(m.rotary.sign);
  if (key == "tilt.sign") return std::to_string(m.tilt.sign);
  return "";
}

std::vector<std::string> key_order(const std::string& section) {
  if (section.empty())
    return {"name",
            "linear",
            "structure",
            "tilt",
            "rotary",
            "table_centre_mm",
            "pivot_to_gauge_mm",
            "rotary_to_tilt_mm",
            "spindle_direction",
            "control",
            "check",
            "program",
            "link",
            "wire"};
  return {"letter", "direction", "sign", "zero_deg", "word", "continuous", "prefer", "min_deg", "max_deg"};
}

bool agrees(const config::MachineProfile& before, const MachineModel& settled) {
  return std::none_of(before.vectors.begin(), before.vectors.end(), [&](const config::MachineVector& one) {
    return config::disagreement(settled, one).has_value();
  });
}

}  // namespace

std::vector<ProfileChange> profile_changes(const std::string& text, const PivotFit& fit,
                                           const std::vector<ValueSpread>& spreads,
                                           const MachineModel& before) {
  const MachineModel m = settled(fit.found, before, fit.spindle, fit.tool_length);
  std::vector<ProfileChange> all;
  for (const auto& [key, was, now] : {std::tuple{"rotary.sign", before.rotary.sign, m.rotary.sign},
                                      {"tilt.sign", before.tilt.sign, m.tilt.sign}})
    if (was != now) all.push_back({key, "", text_of(key, m), 0.0, ""});
  for (const ValueSpread& one : spreads) {
    const std::string value = text_of(one.value.key, m);
    if (value.empty() || !one.told) continue;
    all.push_back(
        {one.value.key, "", value, *std::max_element(one.spread.begin(), one.spread.end()), one.value.unit});
  }
  std::vector<std::string> keys;
  for (const ProfileChange& one : all) keys.push_back(one.key);
  const auto stated = config::value_texts(text, keys);
  for (std::size_t i = 0; stated && i < all.size(); ++i) all[i].before = (*stated)[i];
  return all;
}

Result<MeasuredProfile> measured_profile(const std::string& text, const config::MachineProfile& before,
                                         const MachineModel& settled,
                                         const std::vector<ProfileChange>& changes,
                                         const std::vector<std::string>& remarks) {
  MeasuredProfile out{text, !agrees(before, settled)};
  std::vector<config::YamlEdit> edits;
  for (const ProfileChange& one : changes) edits.push_back({one.key, one.after});
  if (out.check_dropped) edits.push_back({"check", std::nullopt});
  for (const config::YamlEdit& edit : edits) {
    Result<std::string> changed = config::edited(out.text, edit, key_order);
    if (!changed)
      return tl::unexpected<Error>({changed.error().code, before.path + ": " + changed.error().message});
    out.text = *changed;
  }
  if (!out.text.ends_with('\n')) out.text += '\n';
  out.text += '\n';
  for (const std::string& line : remarks) out.text += line + '\n';
  const auto loads = config::parse_machine(out.text, before.path);
  if (!loads) return tl::unexpected<Error>(loads.error());
  return out;
}

}  // namespace tiltfeed::daemon
