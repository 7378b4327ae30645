#include "config/program_keys.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "config/enum_words.h"
#include "config/program_lines.h"
#include "config/start_words.h"
#include "config/table_home.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::config {
namespace {

constexpr Range kInverseTime = above(0.0, 1e9);      // 1/min
constexpr Range kMaxFeed = above(0.0, 1e6);          // mm/min
constexpr Range kFeedRadius = above(0.0, 10'000.0);  // mm
constexpr Range kBlend{0.001, 1.0};                  // mm
constexpr Range kStartBelow{0.0, 10'000.0};          // mm
constexpr int kMostBlocks = 1'000'000'000;
constexpr int kMostProgramBytes = 2'000'000'000;
constexpr std::size_t kMostWords = 40;       // characters of words that a profile states
constexpr std::size_t kMostSwivelName = 32;  // of swivel data: STRING[32] in the call
constexpr std::size_t kMostLines = 20;       // of `start` and of `end`
constexpr std::size_t kMostLine = 72;        // characters of one of them

constexpr std::initializer_list<EnumWord<FeedMode>> kFeedModes{{"inverse_time", FeedMode::kInverseTime},
                                                               {"per_minute", FeedMode::kPerMinute}};
constexpr std::initializer_list<EnumWord<FeedMeasure>> kFeedMeasures{
    {"xyz", FeedMeasure::kXyz}, {"degrees", FeedMeasure::kDegrees}, {"radius", FeedMeasure::kRadius}};
constexpr std::initializer_list<EnumWord<PathControl>> kPathControls{
    {"control", PathControl::kControl}, {"exact", PathControl::kExact}, {"blend", PathControl::kBlend}};

constexpr std::initializer_list<EnumWord<Dialect>> kDialectChoices{
    {"rs274", Dialect::kRs274},
    {"grbl", Dialect::kGrbl},
    {"fanuc", Dialect::kFanuc},
    {"haas", Dialect::kHaas},
    {"siemens", Dialect::kSiemens},
    {"heidenhain", Dialect::kHeidenhain},
    {"heidenhain_iso", Dialect::kHeidenhainIso}};

constexpr std::initializer_list<const char*> kFormatKeys{"dialect",
                                                         "units",
                                                         "linear_decimals",
                                                         "rotary_decimals",
                                                         "max_line_length",
                                                         "line_numbers",
                                                         "line_number_step",
                                                         "line_end",
                                                         "percent",
                                                         "max_blocks",
                                                         "max_program_bytes",
                                                         "tcp",
                                                         "tcp_start_below_mm",
                                                         "tilted_planes",
                                                         "swivel_data",
                                                         "feed_mode",
                                                         "feed_measure",
                                                         "feed_radius_mm",
                                                         "max_inverse_time_per_min",
                                                         "max_feed_mm_per_min",
                                                         "path_control",
                                                         "blend_tolerance_mm",
                                                         "retract",
                                                         "start",
                                                         "end",
                                                         "clamp_tilt",
                                                         "unclamp_tilt",
                                                         "clamp_rotary",
                                                         "unclamp_rotary",
                                                         "preselect_tools",
                                                         "through_coolant_on",
                                                         "through_coolant_off"};

/// Words of a program that a profile states: upper case, printable, nothing that opens a comment.
std::string read_words(const Section& program, const char* key, const std::string& usual) {
  const std::string text = program.text(key, usual);
  const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == ' ' || c == '.' || c == '-' || c == '+' ||
           c == '=';
  });
  if (program.has(key) && text != usual && text != "none" && text != "default" &&
      (!plain || text.size() > kMostWords))
    program.complain(key, "expected words of a program, at most " + std::to_string(kMostWords) +
                              " of A-Z 0-9 blank . - + =, found \"" + text + "\"");
  return text;
}

/// The name of the swivel data in quotes of a program. "0" would end the swivel data.
std::string read_swivel_data(const Section& program, Dialect dialect) {
  if (dialect != Dialect::kSiemens) {
    program.unused("swivel_data", "unless the dialect is siemens");
    return {};
  }
  const std::string name = program.text("swivel_data", "");
  const bool plain = std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
  });
  if (name == "0")
    program.complain("swivel_data", "the name 0 ends the swivel data of the control; expected another name");
  else if (!plain || name.size() > kMostSwivelName)
    program.complain("swivel_data", "expected the name of the control's swivel data, at most " +
                                        std::to_string(kMostSwivelName) + " of A-Z 0-9 _ - ., found \"" +
                                        name + "\"");
  return name;
}

/// Lines of a program that a profile states: one text or a list of them.
std::vector<std::string> read_lines(const Section& program, const char* key, Dialect dialect) {
  std::vector<std::string> lines = program.lines(key, kMostLines);
  if (lines == std::vector<std::string>{"none"}) return {};
  for (const std::string& line : lines) {
    const bool plain = std::all_of(line.begin(), line.end(), [](char c) {
      return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
             std::string_view(" .-+=(),_/\"").find(c) != std::string_view::npos;
    });
    const auto opened = std::count(line.begin(), line.end(), '('),
               closed = std::count(line.begin(), line.end(), ')');
    if (!plain || line.size() > kMostLine || opened != closed || line.front() == '/' || line.front() == ' ')
      program.complain(key, "expected words of a program, at most " + std::to_string(kMostLine) +
                                " of A-Z 0-9 blank . - + = ( ) , _ / \" in a line, found \"" + line + "\"");
    else if (moves_the_tool(line))
      program.complain(key,
                       "\"" + line +
                           "\" moves an axis where nothing is known of the part; expected a move in machine "
                           "coordinates (G53, G28, SUPA, M91) or none");
  }
  const bool before_motion = std::string_view(key) == "start";
  if (const auto wrong = breaks_words(lines, before_motion)) {
    program.complain(key, *wrong);
    return lines;
  }
  for (const std::string& line : lines)
    if (const auto word = before_motion ? unknown_before_motion(line, dialect) : std::nullopt)
      program.complain(key, "\"" + line + "\" has " + *word +
                                ", which may change what the words of the program mean; expected smoothing, "
                                "exact stop, blending, a work offset, what cancels, a dwell, coolant, or a "
                                "move in machine coordinates");
  return lines;
}

void read_retract(const Section& program, const ProgramFormat& usual, ProgramFormat& format) {
  format.retract = read_words(program, "retract", usual.retract);
  if (format.retract == "default" || format.retract == "none") return;
  if (const auto wrong = breaks_words({format.retract}, true))
    program.complain("retract", *wrong);
  else if (const auto none = no_retract(format.retract, format.dialect))
    program.complain("retract", *none);
}

void read_feed(const Section& program, const ProgramFormat& usual, ProgramFormat& format) {
  format.max_inverse_time = program.number("max_inverse_time_per_min", kInverseTime, usual.max_inverse_time);
  format.max_feed = program.number("max_feed_mm_per_min", kMaxFeed, usual.max_feed);
  if (format.tcp) {
    program.unused("feed_mode", "under TCP, where F is the tip's feed");
    program.unused("feed_measure", "under TCP, where F is the tip's feed");
    program.unused("feed_radius_mm", "under TCP, where F is the tip's feed");
    return;
  }
  format.feed_mode = program.choice<FeedMode>("feed_mode", kFeedModes, usual.feed_mode);
  if (format.feed_mode == FeedMode::kInverseTime && !has_inverse_time(format.dialect))
    program.complain("feed_mode",
                     std::string(name_of(format.dialect).name) + " has no inverse time; expected per_minute");
  format.feed_measure = program.choice<FeedMeasure>("feed_measure", kFeedMeasures, usual.feed_measure);
  if (format.feed_measure == FeedMeasure::kRadius)
    format.feed_radius = program.number("feed_radius_mm", kFeedRadius);
  else
    program.unused("feed_radius_mm", "unless feed_measure is radius");
}

/// An inch has one decimal more.
void read_units(const Section& program, ProgramFormat& format) {
  format.inches = program.choice<bool>("units", {{"mm", false}, {"inch", true}}, false);
  if (!format.inches) return;
  if (format.dialect == Dialect::kRs274 || format.dialect == Dialect::kGrbl)
    program.complain("units", std::string(name_of(format.dialect).name) +
                                  " programs are sent, followed and resumed in mm; expected mm");
  constexpr int kMost = 6;
  format.linear_decimals = std::min(format.linear_decimals + 1, kMost);
  format.most_linear_decimals = std::min(format.most_linear_decimals + 1, kMost);
}

/// A degree that counts as a mm, or as an arc in mm, would count as inches.
void check_feed_unit(const Section& program, const ProgramFormat& format) {
  const bool measures =
      !format.tcp && format.feed_mode == FeedMode::kPerMinute && format.feed_measure != FeedMeasure::kXyz;
  if (format.inches && measures)
    program.complain(
        program.has("feed_measure") ? "feed_measure" : "units",
        "with units: inch F per minute measures X Y Z alone; state feed_measure: xyz, or tcp: true");
}

void read_path_control(const Section& program, const ProgramFormat& usual, ProgramFormat& format) {
  format.path_control = program.choice<PathControl>("path_control", kPathControls, usual.path_control);
  if (format.path_control != PathControl::kControl && format.dialect != Dialect::kRs274)
    program.complain("path_control", "exact and blend are words of rs274; expected control");
  if (format.path_control == PathControl::kBlend)
    format.blend_tolerance = program.number("blend_tolerance_mm", kBlend);
  else
    program.unused("blend_tolerance_mm", "unless path_control is blend");
}

/// M codes of the machine builder's, with blanks between: none that stops, changes tools, turns the spindle,
/// or runs another program.
std::string read_switch(const Section& program, const char* key) {
  constexpr std::array kTaken{0,  1,  2,  3,  4,  5,   6,   19,  30,  60,  91, 92,
                              94, 96, 97, 98, 99, 126, 127, 128, 129, 140, 198};
  const std::string text = read_words(program, key, "");
  std::istringstream in(text);
  for (std::string word; in >> word;) {
    const bool code = word.size() >= 2 && word.size() <= 4 && word[0] == 'M' &&
                      word.find_first_not_of("0123456789", 1) == word.npos;
    if (code && std::find(kTaken.begin(), kTaken.end(), std::stoi(word.substr(1))) == kTaken.end()) continue;
    program.complain(key, "expected M codes that switch the coolant, as M88, found \"" + word + "\"");
    break;
  }
  return text;
}

void read_switches(const Section& program, const ProgramFormat& usual, ProgramFormat& format) {
  format.clamp_tilt = read_words(program, "clamp_tilt", "");
  format.unclamp_tilt = read_words(program, "unclamp_tilt", "");
  format.clamp_rotary = read_words(program, "clamp_rotary", "");
  format.unclamp_rotary = read_words(program, "unclamp_rotary", "");
  if (format.clamp_tilt.empty() != format.unclamp_tilt.empty())
    program.complain("clamp_tilt", "clamp_tilt and unclamp_tilt belong together; state both or none");
  if (format.clamp_rotary.empty() != format.unclamp_rotary.empty())
    program.complain("clamp_rotary", "clamp_rotary and unclamp_rotary belong together; state both or none");
  format.preselects = program.flag("preselect_tools", usual.preselects);
  if (format.preselects && format.dialect == Dialect::kGrbl)
    program.complain("preselect_tools", "grbl changes no tools by itself; expected false");
  format.through_on = read_switch(program, "through_coolant_on");
  format.through_off = read_switch(program, "through_coolant_off");
  if (format.through_on.empty() != format.through_off.empty())
    program.complain("through_coolant_on",
                     "through_coolant_on and through_coolant_off belong together; state both or none");
  else if (!format.through_on.empty() && format.through_on == format.through_off)
    program.complain("through_coolant_off", "is the same as through_coolant_on");
  if (format.through_on.empty()) format.through_on = usual.through_on, format.through_off = usual.through_off;
}

/// What a profile states of another control's text says nothing of this one's, but the machine's clamps
/// remain.
ProgramFormat for_another(Dialect dialect, const ProgramFormat& stated) {
  ProgramFormat format = usual_format(dialect);
  format.line_numbers = stated.line_numbers;
  format.tcp_start_below = stated.tcp_start_below;
  format.clamp_tilt = stated.clamp_tilt;
  format.unclamp_tilt = stated.unclamp_tilt;
  format.clamp_rotary = stated.clamp_rotary;
  format.unclamp_rotary = stated.unclamp_rotary;
  format.preselects = stated.preselects && dialect != Dialect::kGrbl;
  if (format.through_on.empty())
    format.through_on = stated.through_on, format.through_off = stated.through_off;
  return format;
}

std::string or_none(const std::string& text) { return text.empty() ? "none" : text; }
std::string or_none(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : " | ") + line;
  return or_none(text);
}

}  // namespace

const DialectName& name_of(Dialect dialect) {
  return *std::find_if(kDialects.begin(), kDialects.end(),
                       [&](const DialectName& one) { return one.dialect == dialect; });
}

const char* refusal_of(Dialect dialect, RotaryWord word) {
  if (word == RotaryWord::kAccumulate) return nullptr;
  const DialectName& row = name_of(dialect);
  return word == RotaryWord::kShortest ? row.no_shortest : row.no_signed;
}

ProgramFormat fine_enough(ProgramFormat format, double tolerance, double axis_tolerance) {
  // Half of the last decimal in each of three words, and in each of two.
  const auto widen = [](int& decimals, int most, double worst, double allowed) {
    while (decimals < most && worst / decimal_scale(decimals) > allowed * kRoundingShare) ++decimals;
  };
  widen(format.linear_decimals, format.most_linear_decimals, unit_of(format) * std::sqrt(3.0) / 2.0,
        tolerance);
  widen(format.rotary_decimals, format.most_rotary_decimals, std::sqrt(2.0) / 2.0, axis_tolerance);
  return format;
}

double printed_place(const ProgramFormat& format, double mm) {
  const double unit = unit_of(format);
  return round_decimal(mm / unit, format.linear_decimals) * unit;
}

ProgramFormat usual_format(Dialect dialect) {
  ProgramFormat format;
  format.dialect = dialect;
  format.most_linear_decimals = format.most_rotary_decimals = name_of(dialect).most_decimals;
  format.retract = "default";
  if (dialect == Dialect::kRs274 || dialect == Dialect::kGrbl) return format;
  format.max_line_length = 100;
  if (dialect == Dialect::kHaas) format.through_on = "M88", format.through_off = "M89";
  if (dialect == Dialect::kFanuc || dialect == Dialect::kHaas) {
    // Least input increment IS-B; the F of G93 that the smallest of these controls takes.
    format.linear_decimals = format.rotary_decimals = 3;
    format.max_inverse_time = 9999.0;
    format.percent = true;
  }
  if (!has_inverse_time(dialect)) {
    format.feed_mode = FeedMode::kPerMinute;
    format.feed_measure = FeedMeasure::kDegrees;
    format.max_feed = 99999.0;
  }
  if (dialect == Dialect::kSiemens) format.feed_measure = FeedMeasure::kDegrees;
  if (dialect == Dialect::kHeidenhainIso) format.line_number_step = 10;
  return format;
}

ProgramFormat read_format(const Section& root, std::optional<Dialect> dialect) {
  const Section program = root.optional_section("program", kFormatKeys);
  const ProgramFormat usual =
      usual_format(program.choice<Dialect>("dialect", kDialectChoices, Dialect::kRs274));
  ProgramFormat result = usual;
  read_units(program, result);
  result.linear_decimals = program.integer("linear_decimals", 1, 6, result.linear_decimals);
  result.rotary_decimals = program.integer("rotary_decimals", 1, 6, usual.rotary_decimals);
  if (program.has("linear_decimals")) result.most_linear_decimals = result.linear_decimals;
  if (program.has("rotary_decimals")) result.most_rotary_decimals = result.rotary_decimals;
  result.max_line_length = program.integer("max_line_length", 16, 4096, usual.max_line_length);
  result.line_numbers = program.flag("line_numbers", usual.line_numbers);
  result.line_number_step = program.integer("line_number_step", 1, 100, usual.line_number_step);
  result.crlf = program.choice<bool>("line_end", {{"lf", false}, {"crlf", true}}, usual.crlf);
  if (result.crlf && result.dialect == Dialect::kGrbl)
    program.complain("line_end", "Grbl answers CR LF with two ok, which spoils the counting; expected lf");
  result.percent = program.flag("percent", usual.percent);
  if (result.percent && !has_percent(result.dialect))
    program.complain("percent", std::string(name_of(result.dialect).name) +
                                    " programs do not stand between two %; expected false");
  result.max_blocks = program.integer("max_blocks", 0, kMostBlocks, usual.max_blocks);
  result.max_bytes = program.integer("max_program_bytes", 0, kMostProgramBytes, usual.max_bytes);
  result.tcp = program.flag("tcp", usual.tcp);
  if (result.tcp && !has_tcp(result.dialect))
    program.complain("tcp",
                     std::string(name_of(result.dialect).name) + " has no words for TCP; expected false");
  if (result.tcp && begins_at_home(result.dialect))
    result.tcp_start_below = program.number("tcp_start_below_mm", kStartBelow, usual.tcp_start_below);
  else
    program.unused("tcp_start_below_mm", "unless tcp is true and the dialect is fanuc or haas");
  result.tilted_planes = program.flag("tilted_planes", usual.tilted_planes);
  result.swivel_data = read_swivel_data(program, result.dialect);
  read_feed(program, usual, result);
  read_path_control(program, usual, result);
  read_retract(program, usual, result);
  check_feed_unit(program, result);
  result.start = read_lines(program, "start", result.dialect);
  result.end = read_lines(program, "end", result.dialect);
  read_switches(program, usual, result);
  return dialect && *dialect != result.dialect ? for_another(*dialect, result) : result;
}

ProgramFormat in_tilted_planes(ProgramFormat format) {
  format.tcp = false;
  format.feed_mode = FeedMode::kPerMinute;
  format.feed_measure = FeedMeasure::kXyz;
  return format;
}

std::optional<std::string> no_planes(const MachineModel& model, const ProgramFormat& format) {
  const std::string control = name_of(format.dialect).name;
  const bool head_turns = model.structure == Structure::kHeadHead ||
                          (model.structure == Structure::kTableHead && model.tilt.present);
  if (!has_tilted_planes(format.dialect)) return control + " has no words for a tilted plane";
  if (!model.tilt.present && !model.rotary.present) return "the machine has no rotary axis";
  if (plane_follows_table(format.dialect) && (head_turns || model.spindle != Vec3{0, 0, 1}))
    return control +
           "'s G254 follows the table alone, and the head of this machine turns or its spindle is not "
           "along Z";
  if (format.retract == "none")
    return "retract is none, and between two planes the rotaries turn at the retract; state one";
  return std::nullopt;
}

void check_planes(const Section& root, const MachineModel& model, const ProgramFormat& format) {
  if (!format.tilted_planes) return;
  if (const auto why = no_planes(model, format))
    root.optional_section("program", kFormatKeys).complain("tilted_planes", *why + "; expected false");
}

void check_home(const Section& root, const MachineModel& model, const ProgramFormat& format) {
  if (const auto wrong = no_home(model, format))
    root.optional_section("program", kFormatKeys).complain("tcp", *wrong);
}

void describe_format(Description& out, const ProgramFormat& format) {
  out.add("program.dialect", name_of(format.dialect).name);
  out.add("program.units", format.inches ? "inch" : "mm");
  out.add("program.linear_decimals", format.linear_decimals);
  out.add("program.rotary_decimals", format.rotary_decimals);
  out.add("program.max_line_length", format.max_line_length);
  out.add("program.line_numbers", format.line_numbers);
  out.add("program.line_number_step", format.line_number_step);
  out.add("program.line_end", format.crlf ? "crlf" : "lf");
  out.add("program.percent", format.percent);
  out.add("program.max_blocks", format.max_blocks);
  out.add("program.max_program_bytes", format.max_bytes);
  out.add("program.tcp", format.tcp);
  if (format.tcp && begins_at_home(format.dialect))
    out.add("program.tcp_start_below_mm", format.tcp_start_below);
  out.add("program.tilted_planes", format.tilted_planes);
  if (format.dialect == Dialect::kSiemens) out.add("program.swivel_data", or_none(format.swivel_data));
  if (!format.tcp) {
    out.add("program.feed_mode", word(kFeedModes, format.feed_mode));
    out.add("program.feed_measure", word(kFeedMeasures, format.feed_measure));
  }
  if (format.feed_measure == FeedMeasure::kRadius) out.add("program.feed_radius_mm", format.feed_radius);
  out.add("program.max_inverse_time_per_min", format.max_inverse_time);
  out.add("program.max_feed_mm_per_min", format.max_feed);
  out.add("program.path_control", word(kPathControls, format.path_control));
  if (format.path_control == PathControl::kBlend)
    out.add("program.blend_tolerance_mm", format.blend_tolerance);
  out.add("program.retract", format.retract);
  out.add("program.start", or_none(format.start));
  out.add("program.end", or_none(format.end));
  out.add("program.clamp_tilt", or_none(format.clamp_tilt));
  out.add("program.unclamp_tilt", or_none(format.unclamp_tilt));
  out.add("program.clamp_rotary", or_none(format.clamp_rotary));
  out.add("program.unclamp_rotary", or_none(format.unclamp_rotary));
  out.add("program.preselect_tools", format.preselects);
  out.add("program.through_coolant_on", or_none(format.through_on));
  out.add("program.through_coolant_off", or_none(format.through_off));
}

}  // namespace tiltfeed::config
