// What a job states of its program: number, tool, registers, coolant, high-speed function.

#include <algorithm>

#include "config/enum_words.h"
#include "config/program_keys.h"

namespace tiltfeed::config {
namespace {

constexpr Range kSmoothed{0.001, 1.0};  // mm
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
      "program",
      {"number", "tool", "length_register", "work_offset", "coolant", "smoothing", "smoothing_tolerance_mm"});
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
  return data;
}

std::vector<std::pair<const char*, std::string>> not_of_control(const ProgramData& data,
                                                                const ProgramFormat& format) {
  std::vector<std::pair<const char*, std::string>> wrong;
  const Dialect control = format.dialect;
  const std::string name = name_of(control).name;
  if (const int most = most_work_offsets(control); data.work_offset > most)
    wrong.emplace_back("work_offset", std::to_string(data.work_offset) + " is more than the " +
                                          std::to_string(most) + " that " + name + " programs can call");
  if (data.coolant == Coolant::kThrough && format.through_on.empty())
    wrong.emplace_back("coolant", "the machine's profile has no program.through_coolant_on");
  if (data.smoothing != Smoothing::kNone && !has_smoothing(control))
    wrong.emplace_back("smoothing", name +
                                        " has no words for it; how corners are passed is the profile's "
                                        "program.path_control");
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
  out.add("program.length_register", data.length_register);
  out.add("program.smoothing", word(kSmoothings, data.smoothing));
  if (data.smoothing != Smoothing::kNone) out.add("program.smoothing_tolerance_mm", data.smoothing_tolerance);
}

}  // namespace tiltfeed::config
