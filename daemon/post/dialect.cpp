#include "daemon/post/dialect.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace tiltfeed::daemon {
namespace {

constexpr std::size_t kMaxProgramName = 24;
// Largest N words; Fanuc and Haas have five digits, Grbl counts to here and starts again.
constexpr std::uint64_t kFiveDigits = 99'999, kSevenDigits = 9'999'999, kEightDigits = 99'999'999;

// clang-format off
constexpr std::array<DialectTable, 7> kTables{{
    {.dialect = config::Dialect::kRs274,
     .comment_open = "(", .comment_close = ")", .numbering = Numbering::kOptional, .unnumbered = "%(",
     .first_number = 1, .last_number = kSevenDigits, .block_end = "",
     .point = false, .plus = false, .modal_motion = true, .rapid = "G0", .feed = "G1",
     .first_end = "", .rapid_end = "", .feed_decimals = 9,
     .shorter_open = "", .shorter_close = "", .shorter_on = "", .shorter_off = "",
     .open = "", .setup = "{units} G90 G17 G40 G49 {offset}", .tool = "T{tool} M6|G43 H{register}",
     .spindle = "S{rpm} M{turn}", .spindle_off = "M5", .flood = "M8", .mist = "M7", .coolant_off = "M9",
     .cutter_left = "G41 D{cutter}", .cutter_right = "G42 D{cutter}", .cutter_off = "G40",
     .shifts_in_zx = true,
     .length_in_tool = ", H{register} too", .length_alone = ", use G49",
     .length = "", .tcp_length = "", .length_off = "", .plane_off = "", .plane_on = "", .plane_done = "",
     .tcp_on = "", .tcp_off = "",
     .inverse_on = "G93", .per_minute_on = "G94", .degrees = "", .radius = "",
     .exact = "G61", .blend = "G64 P{tolerance}", .dwell = "G4 P{seconds}", .stop = "M0",
     .optional_stop = "M1", .retract = "G53 G0 Z0", .end = "M2", .arc_planes = true},
    {.dialect = config::Dialect::kGrbl,
     .comment_open = "(", .comment_close = ")", .numbering = Numbering::kOptional, .unnumbered = "%(",
     .first_number = 1, .last_number = kSevenDigits, .block_end = "",
     .point = false, .plus = false, .modal_motion = true, .rapid = "G0", .feed = "G1",
     .first_end = "", .rapid_end = "", .feed_decimals = 9,
     .shorter_open = "", .shorter_close = "", .shorter_on = "", .shorter_off = "",
     .open = "", .setup = "{units} G90 G17 G40 G49 {offset}", .tool = "T{tool}|M0",
     .spindle = "S{rpm} M{turn}", .spindle_off = "M5", .flood = "M8", .mist = "M7", .coolant_off = "M9",
     .cutter_left = "", .cutter_right = "", .cutter_off = "",
     .length_in_tool = ", use G49", .length_alone = ", use G49",
     .length = "", .tcp_length = "", .length_off = "", .plane_off = "", .plane_on = "", .plane_done = "",
     .preselect = "",
     .tcp_on = "", .tcp_off = "",
     .inverse_on = "G93", .per_minute_on = "G94", .degrees = "", .radius = "",
     .exact = "G61", .blend = "", .dwell = "G4 P{seconds}", .stop = "M0", .optional_stop = "M1",
     .retract = "G53 G0 Z0", .end = "M2", .arc_planes = true},
    {.dialect = config::Dialect::kFanuc,
     .comment_open = "(", .comment_close = ")", .numbering = Numbering::kOptional, .unnumbered = "%(O",
     .first_number = 1, .last_number = kFiveDigits, .block_end = "",
     .point = true, .plus = false, .modal_motion = true, .rapid = "G0", .feed = "G1",
     .first_end = "", .rapid_end = "", .feed_decimals = 3,
     .shorter_open = "", .shorter_close = "", .shorter_on = "", .shorter_off = "",
     .open = "O{number} ({name})", .setup = "{units} G90 G17 G40 G80 G94 {offset}", .tool = "T{tool} M6",
     .spindle = "S{rpm} M{turn}", .spindle_off = "M5", .flood = "M8", .mist = "M7", .coolant_off = "M9",
     .cutter_left = "G41 D{cutter}", .cutter_right = "G42 D{cutter}", .cutter_off = "G40",
     .shifts_in_zx = true, .shifts_in_yz = true,
     .length_in_tool = ", H{register} too", .length_alone = ", use G49",
     .length = "G43 H{register}", .tcp_length = "G43.4 H{register}", .length_off = "G49",
     .plane_off = "G69", .plane_on = "G68.2 X0. Y0. Z0. {angles}|G53.1", .plane_done = "G69",
     .plane_offset = "{offset}",
     .tcp_on = "", .tcp_off = "", .tcp_frame = "No.19696 bit 5 is 0, No.1401 bit 1 is 1",
     .inverse_on = "G93", .per_minute_on = "G94", .degrees = "", .radius = "",
     .smooth_on = "G5.1 Q1",
     .smooth_off = "G5.1 Q0",
     .exact = "", .blend = "", .dwell = "G4 P{milliseconds}", .stop = "M0", .optional_stop = "M1",
     .retract = "G91 G28 Z0.|G90", .end = "M30", .arc_planes = true},
    {.dialect = config::Dialect::kHaas,
     .comment_open = "(", .comment_close = ")", .numbering = Numbering::kOptional, .unnumbered = "%(O",
     .first_number = 1, .last_number = kFiveDigits, .block_end = "",
     .point = true, .plus = false, .modal_motion = true, .rapid = "G0", .feed = "G1",
     .first_end = "", .rapid_end = "", .feed_decimals = 3,
     .shorter_open = "", .shorter_close = "", .shorter_on = "", .shorter_off = "",
     .open = "O0{number} ({name})", .setup = "{units} G90 G17 G40 G80 G94 {offset}", .tool = "T{tool} M6",
     .spindle = "S{rpm} M{turn}", .spindle_off = "M5", .flood = "M8", .mist = "M7", .coolant_off = "M9",
     .cutter_left = "G41 D{cutter}", .cutter_right = "G42 D{cutter}", .cutter_off = "G40",
     .length_in_tool = ", H{register} too", .length_alone = ", use G49",
     .length = "G43 H{register}", .tcp_length = "G234 H{register}", .length_off = "G49",
     .plane_off = "G69", .plane_on = "G254", .plane_done = "G255",
     .plane_offset = "{offset}",
     .tcp_on = "", .tcp_off = "",
     .inverse_on = "G93", .per_minute_on = "G94", .degrees = "", .radius = "",
     .smooth_on = "G187 P{mode} E{within}",
     .smooth_off = "G187",
     .exact = "", .blend = "", .dwell = "G4 P{milliseconds}", .stop = "M0", .optional_stop = "M1",
     .retract = "G0 G53 Z0.", .end = "M30", .arc_planes = true},
    {.dialect = config::Dialect::kSiemens,
     .comment_open = "; ", .comment_close = "", .numbering = Numbering::kOptional, .unnumbered = ";%",
     .first_number = 1, .last_number = kEightDigits, .block_end = "",
     .point = false, .plus = false, .modal_motion = true, .rapid = "G0", .feed = "G1",
     .first_end = "", .rapid_end = "", .feed_decimals = 3,
     .shorter_open = "=DC(", .shorter_close = ")", .shorter_on = "", .shorter_off = "",
     .mm = "G710", .inch = "G700",
     .open = "", .setup = "TRAFOOF|TOROTOF|PAROTOF|TRANS|{units} G90 G17 G40 G94 {offset}", .tool = "T{tool}|M6|D{edge}",
     .spindle = "S{rpm} M{turn}", .spindle_off = "M5", .flood = "M8", .mist = "M7", .coolant_off = "M9",
     .cutter_left = "G41", .cutter_right = "G42", .cutter_off = "G40",
     .length_in_tool = ", D{edge} too", .length_alone = ", use D0",
     .length = "", .tcp_length = "", .length_off = "", .plane_off = "",
     // 27: by axis, about Z, Y, X.
     .plane_on = R"(CYCLE800(0,{swivel},0,27,0,0,0,{angles},0,0,0,{side},0))", .plane_done = "CYCLE800()",
     .plane_offset = "{offset}",
     .edge = "D{edge}",
     // Both orientation words: whichever of the two G groups the machine data enables, rotaries go linearly.
     .tcp_on = "TRAORI|{offset}|ORIMKS ORIAXES", .tcp_off = "TRAFOOF",
     .inverse_on = "G93", .per_minute_on = "G94",
     .degrees = "FGROUP(X,Y,Z{rotaries})|{in_degrees}",
     .radius = "FGROUP(X,Y,Z{rotaries})|{at_radius}",
     .smooth_on = "CYCLE832({within},{mode},{leans})",
     .smooth_off = "CYCLE832(0,0,1)",
     .exact = "", .blend = "", .dwell = "G4 F{seconds}", .stop = "M0", .optional_stop = "M1",
     .retract = "G0 SUPA Z0 D0", .end = "M30"},
    {.dialect = config::Dialect::kHeidenhain,
     .comment_open = "; ", .comment_close = "", .numbering = Numbering::kPlain, .unnumbered = " ",
     .first_number = 0, .last_number = kEightDigits, .block_end = "",
     .point = false, .plus = true, .modal_motion = false, .rapid = "L", .feed = "L",
     .first_end = " R0", .rapid_end = " FMAX", .feed_decimals = 3,
     .shorter_open = "", .shorter_close = "", .shorter_on = "M126", .shorter_off = "M127",
     .mm = "MM", .inch = "INCH",
     .open = "BEGIN PGM {name} {units}", .setup = "M129|PLANE RESET STAY|CYCL DEF 10.0 ROTATION|CYCL DEF 10.1 ROT+0|M127|"
              "CYCL DEF 247 DATUM SETTING ~|  Q339=+{offset} ;DATUM NUMBER",
     .tool = "TOOL CALL {tool} Z", .spindle = "TOOL CALL S{rpm}|M{turn}", .spindle_off = "M5",
     .flood = "M8", .mist = "M7", .coolant_off = "M9",
     .cutter_left = " RL", .cutter_right = " RR", .cutter_off = " R0", .sides = Sides::kBehind,
     .length_in_tool = ", the table's too", .length_alone = ", the table's too",
     .length = "", .tcp_length = "", .length_off = "", .plane_off = "",
     .plane_on = "PLANE SPATIAL {angles} STAY {side} TABLE ROT", .plane_done = "PLANE RESET STAY",
     .plane_offset = "CYCL DEF 247 DATUM SETTING ~|  Q339=+{offset} ;DATUM NUMBER",
     .preselect = "TOOL DEF {next}",
     .tcp_on = "M128", .tcp_off = "M129",
     .inverse_on = "", .per_minute_on = "", .degrees = "", .radius = "",
     .smooth_on = "CYCL DEF 32.0 TOLERANCE|CYCL DEF 32.1 T{within}|CYCL DEF 32.2 HSC-MODE:{mode} TA{leans}",
     .smooth_off = "CYCL DEF 32.0 TOLERANCE|CYCL DEF 32.1",
     .exact = "", .blend = "", .dwell = "CYCL DEF 9.0 DWELL TIME|CYCL DEF 9.1 DWELL {seconds}", .stop = "M0",
     .optional_stop = "M1", .retract = "L Z-1 R0 FMAX M91", .end = "M30|END PGM {name} {units}",
     .clockwise = "C", .clockwise_end = " DR-", .counter = "C", .counter_end = " DR+", .pole = "CC ", .pole_letters = "XY"},
    {.dialect = config::Dialect::kHeidenhainIso,
     .comment_open = ";", .comment_close = "", .numbering = Numbering::kN, .unnumbered = "%N",
     .first_number = 10, .last_number = kEightDigits - 1, .block_end = "*",
     .point = false, .plus = true, .modal_motion = true, .rapid = "G00", .feed = "G01",
     .first_end = "", .rapid_end = "", .feed_decimals = 3,
     .shorter_open = "", .shorter_close = "", .shorter_on = "M126", .shorter_off = "M127",
     .mm = "G71", .inch = "G70",
     .open = "%{name} {units} *", .setup = "M129|PLANE RESET STAY|G73 G90 H+0|M127|G247 Q339=+{offset}|G90 G17 G40",
     .tool = "T{tool} G17", .spindle = "S{rpm} M{turn}", .spindle_off = "M5", .flood = "M8", .mist = "M7",
     .coolant_off = "M9",
     .cutter_left = " G41", .cutter_right = " G42", .cutter_off = " G40", .sides = Sides::kBefore,
     .length_in_tool = ", the table's too", .length_alone = ", the table's too",
     .length = "", .tcp_length = "", .length_off = "", .plane_off = "",
     .plane_on = "PLANE SPATIAL {angles} STAY {side} TABLE ROT", .plane_done = "PLANE RESET STAY",
     .plane_offset = "G247 Q339=+{offset}",
     .preselect = "G51 T{next}",
     .tcp_on = "M128", .tcp_off = "M129",
     .inverse_on = "", .per_minute_on = "", .degrees = "", .radius = "",
     .smooth_on = "G62 T{within} P01 {mode} P02 {leans}",
     .smooth_off = "G62",
     .exact = "", .blend = "", .dwell = "G04 F{seconds}", .stop = "M0", .optional_stop = "M1",
     .retract = "G00 G40 G90 Z-1 M91", .end = "M30|N99999999 %{name} {units} *",
     .clockwise = "G02", .counter = "G03", .pole_letters = "IJ"},
}};
// clang-format on

/// Appends `line` with its braces filled; false when it asks for what there is not.
bool fill(std::string_view line, const Filling& filling, std::string& text) {
  while (!line.empty()) {
    const std::size_t open = line.find('{');
    text += line.substr(0, open);
    if (open == line.npos) return true;
    const std::size_t close = line.find('}', open);
    assert(close != line.npos);
    const std::string_view name = line.substr(open + 1, close - open - 1);
    const auto found =
        std::find_if(filling.begin(), filling.end(), [&](const auto& one) { return one.first == name; });
    if (found == filling.end() || found->second.empty()) return false;
    text += found->second;
    line.remove_prefix(close + 1);
  }
  return true;
}

}  // namespace

const DialectTable& table_of(config::Dialect dialect) {
  return *std::find_if(kTables.begin(), kTables.end(),
                       [&](const DialectTable& table) { return table.dialect == dialect; });
}

std::vector<std::string> filled(std::string_view lines, const Filling& filling) {
  std::vector<std::string> texts;
  while (!lines.empty()) {
    const std::size_t end = std::min(lines.find('|'), lines.size());
    std::string text;
    if (fill(lines.substr(0, end), filling, text) && !text.empty()) texts.push_back(text);
    lines.remove_prefix(std::min(end + 1, lines.size()));
  }
  return texts;
}

std::string filled_line(std::string_view words, const Filling& filling) {
  const std::vector<std::string> lines = filled(words, filling);
  return lines.empty() ? "" : lines.front();
}

std::string work_offset_word(config::Dialect dialect, int offset) {
  if (dialect == config::Dialect::kHeidenhain || dialect == config::Dialect::kHeidenhainIso)
    return std::to_string(offset);
  if (dialect == config::Dialect::kSiemens && offset > 4) return "G" + std::to_string(500 + offset);
  constexpr int kPlain = 6;  // G54 to G59
  const std::string more = std::to_string(offset - kPlain);
  if (offset > kPlain && dialect == config::Dialect::kFanuc) return "G54.1 P" + more;
  if (offset > kPlain && dialect == config::Dialect::kHaas) return "G154 P" + more;
  if (offset > kPlain) return "G59." + more;
  return "G" + std::to_string(53 + offset);
}

std::string program_name(std::string_view name) {
  std::string text;
  for (const char c : name) {
    const char upper = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    const bool kept =
        (upper >= 'A' && upper <= 'Z') || (upper >= '0' && upper <= '9') || upper == '_' || upper == '-';
    if (text.size() < kMaxProgramName && (kept || upper == ' ')) text += kept ? upper : '_';
  }
  return text.empty() ? "TILTFEED" : text;
}

}  // namespace tiltfeed::daemon
