#include "daemon/post/program_filling.h"

#include <string>

#include "daemon/post/comment_text.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

constexpr std::size_t kOfTool = 3;

/// The letters of the machine's rotary axes, each between two words.
std::string rotaries(const MachineModel& machine, const std::string& before, const std::string& after) {
  std::string text;
  for (const RotaryAxis* axis : {&machine.tilt, &machine.rotary})
    if (axis->present) text += before + axis->letter + after;
  return text;
}

}  // namespace

Filling filling_of(const Posting& posting) {
  const config::ProgramFormat& format = posting.machine.format;
  const MachineModel& model = posting.machine.model;
  const std::string number = std::to_string(posting.data.number);
  const bool named = table_of(format.dialect).numbering != Numbering::kOptional;
  return {{"name", named ? program_name(posting.name) : plain(posting.name)},
          {"number", std::string(number.size() < 4 ? 4 - number.size() : 0, '0') + number},
          {"offset", work_offset_word(format.dialect, posting.data.work_offset)},
          {"units", format.inches ? table_of(format.dialect).inch : table_of(format.dialect).mm},
          {"swivel", "\"" + format.swivel_data + "\""},
          {"rotaries", rotaries(model, ",", "")},
          {"in_degrees", rotaries(model, " FGREF[", "]=57.29578")},
          {"at_radius", rotaries(model, " FGREF[", "]=" + decimal(format.feed_radius, 4))},
          {"tolerance", decimal(kBlendWord * format.blend_tolerance, 6)},
          {"register", ""},
          {"edge", "1"},
          {"tool", ""}};
}

void fill_tool(Filling& filling, const Operation& op) {
  const std::string tool = op.tool_number > 0 ? std::to_string(op.tool_number) : "";
  const std::string stated = op.length_register > 0 ? std::to_string(op.length_register) : "";
  filling.resize(filling.size() - kOfTool);
  filling.emplace_back("register", stated.empty() ? tool : stated);
  filling.emplace_back("edge", stated.empty() ? "1" : stated);
  filling.emplace_back("tool", tool);
}

}  // namespace tiltfeed::daemon
