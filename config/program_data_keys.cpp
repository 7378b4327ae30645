// What a job states of its program: number, tool, registers, coolant, high-speed function.

#include <algorithm>

#include "config/enum_words.h"
#include "config/program_keys.h"

namespace tiltfeed::config {
namespace {

constexpr Range kSmoothed{kLeastSmoothing, kMostSmoothing};    // mm
constexpr Range kArcs{kLeastArcTolerance, kMostArcTolerance};  // mm
constexpr std::initializer_list<EnumWord<Coolant>> kCoolants{{"none", Coolant::kOff},
                                                             {"flood", Coolant::kFlood},
                                                             {"mist", Coolant::kMist},
                                                             {"through", Coolant::kThrough}};
constexpr std::initializer_list<EnumWord<Smoothing>> kSmoothings{{"none", Smoothing::kNone},
                                                                 {"rough", Smoothing::kRough},
                                                                 {"semi", Smoothing::kSemi},
                                                                 {"finish", Smoothing::kFinish}};

}  // namespace

ProgramData read_program_data(const Section& root, int tool) {
  const Section section = root.optional_section(
      "program", {"number", "tool", "length_register", "work_offset", "coolant", "smoothing",
                  "smoothing_tolerance_mm", "arc_tolerance_mm", "plane_offsets"});
  const ProgramData usual;
  ProgramData data;
  data.number = section.integer("number", 1, 9999, usual.number);
  data.tool = section.integer("tool", 0, 9999, tool);
  data.work_offset = section.integer("work_offset", 1, kMostWorkOffsets, usual.work_offset);
  data.coolant = section.choice<Coolant>("coolant", kCoolants, usual.coolant);
  data.length_register = section.integer("length_register", 0, 9999, usual.length_register);
  data.smoothing = section.choice<Smoothing>("smoothing", kSmoothings, usual.smoothing);
  if (data.smoothing != Smoothing::kNone)
    data.smoothing_tolerance = section.number("smoothing_tolerance_mm", kSmoothed);
  else
    section.unused("smoothing_tolerance_mm", "unless smoothing is rough, semi or finish");
  if (section.has("arc_tolerance_mm")) data.arc_tolerance = section.number("arc_tolerance_mm", kArcs);
  data.plane_offsets = section.flag("plane_offsets", usual.plane_offsets);
  return data;
}

std::optional<Smoothing> smoothing_of(const std::string& word) {
  for (const EnumWord<Smoothing>& one : kSmoothings)
    if (word == one.word) return one.value;
  return std::nullopt;
}

std::string no_through_coolant(const std::string& profile) {
  return "the machine profile " + profile +
         " has no words for coolant through the spindle; state program.through_coolant_on and "
         "through_coolant_off there";
}

std::vector<std::pair<const char*, std::string>> not_of_control(const ProgramData& data,
                                                                const ProgramFormat& format,
                                                                const std::string& profile) {
  std::vector<std::pair<const char*, std::string>> wrong;
  const Dialect control = format.dialect;
  const std::string name = name_of(control).name;
  if (const int most = most_work_offsets(control); data.work_offset > most)
    wrong.emplace_back("work_offset", std::to_string(data.work_offset) + " is more than the " +
                                          std::to_string(most) + " that " + name + " programs can call");
  if (data.coolant == Coolant::kThrough && format.through_on.empty())
    wrong.emplace_back("coolant", no_through_coolant(profile));
  if (data.smoothing != Smoothing::kNone && !has_smoothing(control))
    wrong.emplace_back("smoothing", name +
                                        " has no words for it; how corners are passed is the profile's "
                                        "program.path_control");
  if (data.arc_tolerance > 0.0 && format.tcp && !format.tilted_planes)
    wrong.emplace_back("arc_tolerance_mm",
                       "the program is under TCP, where X Y Z are the tip's and no arc is posted; leave it "
                       "out, or state tcp: false or tilted_planes: true in the profile");
  if (data.plane_offsets && !has_tilted_planes(control))
    wrong.emplace_back("plane_offsets", name +
                                            " has no words for a tilted plane, with which a work offset "
                                            "would turn; expected false");
  else if (data.plane_offsets && !format.tilted_planes)
    wrong.emplace_back("plane_offsets", "the machine profile " + profile +
                                            " asks for no tilted planes; state program.tilted_planes: true "
                                            "there, or leave it out");
  const bool tnc = control == Dialect::kHeidenhain || control == Dialect::kHeidenhainIso;
  if (data.length_register > 0 && (tnc || control == Dialect::kGrbl))
    wrong.emplace_back("length_register", name + " takes the length of the tool that is called; expected 0");
  else if (data.length_register > 0 && data.tool == 0)
    wrong.emplace_back("length_register", "no tool is called (program.tool is 0); expected 0");
  return wrong;
}

void describe_program_data(Description& out, const ProgramData& data) {
  out.add("program.number", data.number);
  out.add("program.tool", data.tool);
  out.add("program.work_offset", data.work_offset);
  out.add("program.coolant", word(kCoolants, data.coolant));
  if (data.length_register > 0) out.add("program.length_register", data.length_register);
  out.add("program.smoothing", word(kSmoothings, data.smoothing));
  if (data.smoothing != Smoothing::kNone) out.add("program.smoothing_tolerance_mm", data.smoothing_tolerance);
  if (data.arc_tolerance > 0.0) out.add("program.arc_tolerance_mm", data.arc_tolerance);
  if (data.plane_offsets) out.add("program.plane_offsets", true);
}

}  // namespace tiltfeed::config
