#include "daemon/post/nc_reader.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <sstream>
#include <string_view>
#include <utility>

#include "daemon/post/dialect_words.h"
#include "daemon/post/nc_arcs.h"
#include "daemon/post/nc_functions.h"
#include "daemon/post/nc_lines.h"
#include "daemon/post/nc_planes.h"
#include "daemon/post/nc_rules.h"
#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

using Mistake = std::optional<std::string>;
// The third decimal of a word rounds by no more, degrees.
constexpr double kAtHome = 5.1e-4;
constexpr double kInch = 25.4;

bool of_plane(int tenths, config::Dialect dialect) {
  if (dialect == config::Dialect::kFanuc) return tenths == 531;
  return dialect == config::Dialect::kHaas && (tenths == 2540 || tenths == 2550);
}

/// Whether a code selects inches, or mm; nothing: neither. On a Heidenhain G73 is a rotation.
std::optional<bool> unit_code(int tenths) {
  if (tenths == 200 || tenths == 700 || tenths == 7000) return true;
  if (tenths == 210 || tenths == 710 || tenths == 7100) return false;
  return std::nullopt;
}

class Reader {
 public:
  Reader(std::string name, const TextLanguage& language)
      : name_(std::move(name)), language_(language), functions_(facts_, language_) {
    tnc_ = language.dialect == config::Dialect::kHeidenhain ||
           language.dialect == config::Dialect::kHeidenhainIso;
    known_[3] = language.tilt == kNoLetter;
    known_[4] = language.rotary == kNoLetter;
  }
  Result<void> read(std::string line);
  Result<void> too_long() const;
  bool ended() const { return ended_; }
  Result<NcProgram> finish();

 private:
  tl::unexpected<Error> wrong(const std::string& what) const {
    return fail(Code::kInput, name_ + ":" + std::to_string(line_) + ": " + what);
  }
  Result<void> room(std::size_t bytes);
  bool dialogue(const std::string& line, Mistake& mistake);
  Mistake apply(const DialectWords& words);
  Mistake codes(const DialectWords& words);
  Mistake one_code(int tenths);
  double unit() const { return language_.inches ? kInch : 1.0; }
  Mistake other_unit(bool inches) const {
    if (inches == language_.inches) return std::nullopt;
    return inches ? "the program is in inches; post it in mm, or state units: inch in the profile"
                  : "the program is in mm, and the profile says units: inch";
  }
  void mode_codes(const DialectWords& words);
  void note_table();
  Mistake begin_plane(Result<TextPlane> plane);
  Mistake call_offset(std::pair<int, double> called);
  Mistake own_offset();
  Mistake planes(const DialectWords& words);
  Mistake motion(const DialectWords& words);
  double turned(const DialectWords& words, char letter, RotaryWord counting, double from) const;

  std::string name_;
  std::vector<std::string> comments_;  ///< of the line
  TextLanguage language_;
  NcProgram facts_;
  FunctionReader functions_;
  std::uint32_t line_ = 0;
  bool tnc_ = false;  ///< a Heidenhain control, whose M126 to M129 others may use for anything
  bool ended_ = false, rapid_ = true, motion_known_ = false, inverse_ = false, tcp_ = false,
       incremental_ = false, shorter_ = false, moved_ = false;
  double feed_ = 0.0;
  int plane_ = 17;
  ArcReader arcs_;
  std::pair<int, double> offset_{};  ///< the code in tenths, and its P
  /// Work offsets of planes, and where the rotaries stand in these.
  std::vector<std::pair<std::pair<int, double>, std::array<double, 2>>> own_offsets_;
  std::uint64_t bytes_ = 0;
  std::size_t blocks_ = 0, last_blocks_ = 0;
  std::uint32_t tilted_ = 0;  ///< of facts_.planes, from 1
  Joints at_;
  std::array<bool, 5> known_{};
};

/// Lines in words of a Heidenhain dialogue, and those that only set a control up; true when it was one.
bool Reader::dialogue(const std::string& line, Mistake& mistake) {
  const auto is = [&](const char* head) { return line.starts_with(head); };
  const bool iso_head = is("%") && language_.dialect == config::Dialect::kHeidenhainIso;
  if (is("BEGIN PGM") || iso_head)
    mistake = other_unit(line.ends_with(" INCH") || (iso_head && line.find(" G70") != line.npos));
  if (is("%") || is("BEGIN PGM") || is("END PGM") || is("FGROUP") || is("FGREF") || is("CYCLE832(") ||
      is("CYCL DEF 247") || is("CYCL DEF 9.0") || is("CYCL DEF 10.0 ROTATION") ||
      line == "CYCL DEF 10.1 ROT+0" || line == "G73 G90 H+0")
    return true;
  if (tnc_ && (is("Q339") || is("G247"))) {
    constexpr int kPreset = 2470;
    double number = 0.0;
    const std::size_t at = line.find("Q339=");
    if (at == line.npos || !(std::istringstream(line.substr(at + 5)) >> number))
      mistake = "the preset has no number";
    else
      mistake = call_offset({kPreset, number});
    return true;
  }
  if (line == "PLANE RESET STAY" || line == "PLANE RESET" || line == "CYCLE800()") {
    tilted_ = 0;
    return true;
  }
  // The high-speed function.
  const bool iso = language_.dialect == config::Dialect::kHeidenhainIso;
  const bool fanuc = language_.dialect == config::Dialect::kFanuc,
             haas = language_.dialect == config::Dialect::kHaas;
  if (is("TOOL DEF ")) return true;  // makes the next tool ready
  if (is("CYCL DEF 32.") || (iso && is("G62")) || (fanuc && (line == "G5.1 Q1" || line == "G5.1 Q0")) ||
      (haas && (line == "G187" || is("G187 "))))
    return true;
  if (is("PLANE ") || is("CYCLE800(")) {
    mistake = begin_plane(plane_of_line(line, language_.swivel_data));
    return true;
  }
  if ((fanuc || haas) && line.size() > 1 && line[0] == 'O' &&
      line.find_first_not_of("0123456789", 1) == std::string::npos)
    return true;
  if (is("CYCL DEF 9.1 DWELL ")) {
    double seconds = 0.0;
    if (!(std::istringstream(line.substr(19)) >> seconds)) mistake = "the dwell has no time";
    functions_.event(EventKind::kDwell, seconds);
    return true;
  }
  if (!is("TOOL CALL ")) return false;
  mistake = functions_.tool_call(line.substr(10));
  return true;
}

/// Another zero on the way is no place that is known, but where the program says that all are at part zero.
Mistake Reader::call_offset(std::pair<int, double> called) {
  if (called == std::exchange(offset_, called) || !moved_) return std::nullopt;
  if (!facts_.own_offsets) return "another work offset behind the first move is not understood";
  if (tilted_ != 0) return "a work offset is called in a tilted plane";
  return std::nullopt;
}

/// Each place of the rotaries has one work offset, and each of these one place.
Mistake Reader::own_offset() {
  const auto same = [&](const std::array<double, 2>& place) {
    return std::abs(std::remainder(place[0] - at_.a, 360.0)) < kAtHome &&
           std::abs(std::remainder(place[1] - at_.c, 360.0)) < kAtHome;
  };
  for (const auto& [offset, place] : own_offsets_) {
    if (offset == offset_ && same(place)) return std::nullopt;
    if (offset == offset_)
      return "the work offset of another plane is in force: is the call of this plane's lost?";
    if (same(place)) return "this plane has had another work offset before";
  }
  own_offsets_.push_back({offset_, {at_.a, at_.c}});
  return std::nullopt;
}

/// X Y Z are not known in the plane until they are stated.
Mistake Reader::begin_plane(Result<TextPlane> plane) {
  if (!plane) return plane.error().message;
  if (tcp_) return "a tilted plane under TCP is not understood";
  if (!known_[3] || !known_[4]) return "a tilted plane before the rotaries are at their place";
  if (facts_.own_offsets)
    if (auto bad = own_offset()) return bad;
  plane->origin = plane->origin * unit();
  facts_.planes.push_back(*plane);
  tilted_ = static_cast<std::uint32_t>(facts_.planes.size());
  known_[0] = known_[1] = known_[2] = false;
  return std::nullopt;
}

/// Where such a control counts X Y Z from is its parameters' to say.
void Reader::note_table() {
  for (const TableLetter& axis : language_.table) {
    const bool tilt = axis.letter == language_.tilt;
    const double at = tilt ? at_.a : at_.c;
    if (known_[tilt ? 3 : 4] && std::abs(std::remainder(at - axis.home, 360.0)) < kAtHome) continue;
    facts_.notes.push_back("line " + std::to_string(line_) + ": TCP begins while " + axis.letter +
                           " of the table is not at home; X Y Z are read as from the table at home, and the "
                           "control may count them from where it stands");
  }
}

Mistake Reader::one_code(int tenths) {
  const bool fanuc = language_.dialect == config::Dialect::kFanuc;
  // G18 and G19 without a turn of the tool's length.
  const bool planes = !tnc_ && language_.dialect != config::Dialect::kSiemens;
  if (tenths == 510 && language_.dialect == config::Dialect::kHeidenhainIso) return std::nullopt;
  constexpr std::array<int, 15> kNothing{40,  210, 280, 400, 410, 420, 430, 530,
                                         610, 640, 690, 710, 800, 970, 7100};
  if (tenths == 0 || tenths == 10) {
    rapid_ = tenths == 0;
    motion_known_ = true, arcs_.motion = 0;
  } else if (tenths == 930 || tenths == 940) {
    if (inverse_ != (tenths == 930)) feed_ = 0.0;
    inverse_ = tenths == 930;
  } else if ((tenths == 434 && fanuc) || (tenths == 2340 && language_.dialect == config::Dialect::kHaas)) {
    note_table();
    tcp_ = true;
  } else if (tenths == 490) {
    tcp_ = false;
  } else if (tenths == 900 || tenths == 910) {
    incremental_ = tenths == 910;
  } else if (tenths == 170 || ((tenths == 180 || tenths == 190) && planes)) {
    plane_ = tenths / 10;
  } else if (const auto inches = unit_code(tenths)) {
    return other_unit(*inches);
  } else if (tenths == 20 || tenths == 30) {
    rapid_ = false, motion_known_ = true, arcs_.motion = tenths / 10;
  } else if (std::find(kNothing.begin(), kNothing.end(), tenths) == kNothing.end() &&
             !is_work_offset(tenths, language_.dialect) && !of_plane(tenths, language_.dialect)) {
    return "G" + decimal(tenths / 10.0, 1) + " is not understood";
  }
  return std::nullopt;
}

/// M codes that say how motion is read, or end the program.
void Reader::mode_codes(const DialectWords& words) {
  for (const int code : words.m) {
    if (tnc_ && (code == 128 || code == 129)) tcp_ = code == 128;
    if (tnc_ && (code == 126 || code == 127)) shorter_ = code == 126;
    if (code == 2 || code == 30) ended_ = true;
  }
}

/// Where an axis at `from` goes by its word: the shorter way where the program says so, on these controls.
double Reader::turned(const DialectWords& words, char letter, RotaryWord counting, double from) const {
  const double word = words.values.at(letter);
  if (tnc_ || language_.dialect == config::Dialect::kSiemens) {
    const bool shorter = tnc_ ? shorter_ : words.direct.find(letter) != std::string::npos;
    counting = shorter && counting == RotaryWord::kShortest ? RotaryWord::kShortest : RotaryWord::kAccumulate;
    if (words.direct.find(letter) != std::string::npos) counting = RotaryWord::kShortest;
  }
  return counted_turn(counting, word, from);
}

Mistake Reader::motion(const DialectWords& words) {
  const std::array<char, 5> letters{'X', 'Y', 'Z', language_.tilt, language_.rotary};
  const std::array<double*, 5> places{&at_.x, &at_.y, &at_.z, &at_.a, &at_.c};
  const bool elsewhere = words.has_g(530) || words.has_g(280) || words.named("SUPA") ||
                         (tnc_ && (words.has_m(91) || words.has_m(92)));
  const Joints from = at_;
  const bool began = std::all_of(known_.begin(), known_.end(), [](bool one) { return one; });
  if (arcs_.take_pole(words, language_)) return std::nullopt;
  bool moves = false;
  for (std::size_t i = 0; i < letters.size(); ++i) {
    if (!words.has(letters[i])) continue;
    if (i > 2 && tilted_ != 0) return "a rotary turns in a tilted plane";
    moves = true;
    known_[i] = !elsewhere;
    if (elsewhere) continue;
    const double word = words.values.at(letters[i]);
    *places[i] =
        i < 3 ? word * unit()
              : turned(words, letters[i], i == 3 ? language_.tilt_word : language_.rotary_word, *places[i]);
  }
  if (elsewhere || !moves) return std::nullopt;
  if (incremental_) return "incremental words are not understood; post with G90";
  const bool plain = language_.dialect == config::Dialect::kHeidenhain;
  const bool arc = plain ? words.named("C") : arcs_.motion != 0;
  if (plain && !arc && !words.named("L")) return "axis words without L";
  if (!plain && !motion_known_) return "axis words before the first G0 or G1";
  const bool rapid = plain ? words.named("FMAX") : rapid_;
  const bool whole = std::all_of(known_.begin(), known_.end(), [](bool one) { return one; });
  if (!whole && rapid) return std::nullopt;
  if (!whole) return "a feed move before all five axis words were stated";
  if (!rapid && inverse_ && !words.has('F')) return "no F: in inverse time every feed move needs one";
  if (!rapid && !(feed_ > 0.0)) return "a feed move without F";
  std::uint32_t arc_number = 0;
  if (arc) {
    if (tcp_) return "an arc under TCP is not understood";
    if (!began) return "an arc from a place that is not known";
    auto made = arcs_.arc(words, plane_, language_, from, at_);
    if (!made) return made.error().message;
    facts_.arcs.push_back(*made);
    arc_number = static_cast<std::uint32_t>(facts_.arcs.size());
  }
  moved_ = true;
  const bool slides = words.has('X') || words.has('Y') || words.has('Z');
  const double feed = feed_ * (slides && !inverse_ ? unit() : 1.0);
  functions_.operation().blocks.push_back(
      {at_, rapid, tcp_, !rapid && inverse_, rapid ? 0.0 : feed, line_, tilted_, arc_number});
  return std::nullopt;
}

Mistake Reader::codes(const DialectWords& words) {
  if (auto bad = misread(words, language_, incremental_)) return bad;
  for (const int code : words.g) {
    if (!is_work_offset(code, language_.dialect)) continue;
    const double p = words.has('P') ? words.values.at('P') : 0.0;
    if (auto bad = call_offset({code, p})) return bad;
  }
  if (words.has_g(800)) motion_known_ = false;
  for (const int code : words.g)
    if (auto bad = one_code(code)) return bad;
  for (const std::string& name : words.names) {
    const bool siemens = language_.dialect == config::Dialect::kSiemens,
               plain = language_.dialect == config::Dialect::kHeidenhain;
    constexpr std::array<std::string_view, 5> kDialogue{"RL", "RR", "C", "CC", "DR"};
    if (plain && std::find(kDialogue.begin(), kDialogue.end(), name) != kDialogue.end()) continue;
    if (siemens && (name == "TRAORI" || name == "TRAFOOF"))
      tcp_ = name == "TRAORI";
    else if (name != "ORIMKS" && name != "ORIAXES" && name != "TOROTOF" && name != "PAROTOF" &&
             name != "TRANS" && name != "SUPA" && name != "FMAX" && name != "L")
      return "\"" + name + "\" is not understood";
  }
  if (auto bad = arcs_.misplaced(words, plane_, language_)) return bad;
  constexpr std::string_view kOthers = "XYZFSTHDPRIJK";
  for (const auto& [letter, value] : words.values)
    if (kOthers.find(letter) == std::string_view::npos && letter != language_.tilt &&
        letter != language_.rotary)
      return std::string(1, letter) + " is no word of this machine";
  return std::nullopt;
}

/// G68.2 and G53.1, which turns no axis where the program has turned them before; G254, G255.
Mistake Reader::planes(const DialectWords& words) {
  if (language_.dialect == config::Dialect::kHaas && words.has_g(2540)) return begin_plane(TextPlane{});
  if (words.has_g(690) || words.has_g(2550)) {
    if (tilted_ != 0) known_[0] = known_[1] = known_[2] = false;
    tilted_ = 0;
  }
  return std::nullopt;
}

Mistake Reader::apply(const DialectWords& words) {
  if (language_.dialect == config::Dialect::kFanuc && words.has_g(682))
    return begin_plane(plane_of_words(words));
  if (auto bad = codes(words)) return bad;
  if (auto bad = planes(words)) return bad;
  if (words.has_g(40)) return functions_.dwell(words);
  if (words.has('F')) feed_ = words.values.at('F');
  functions_.machine_codes(words);
  functions_.compensation(words, plane_);
  mode_codes(words);
  return motion(words);
}

/// The limits of what is held in memory.
Result<void> Reader::room(std::size_t bytes) {
  bytes_ += bytes + 1;
  const TextOperation& op = facts_.operations.back();
  if (op.blocks.size() != last_blocks_) ++blocks_;
  last_blocks_ = op.blocks.size();
  if (line_ <= kMostTextLines && bytes_ <= kMostTextBytes && blocks_ <= kMostTextBlocks &&
      op.events.size() <= kMostTextEvents && facts_.operations.size() <= kMostTextTools)
    return {};
  return fail(
      Code::kLimit,
      name_ + ":" + std::to_string(line_) +
          ": the program is too long to be read at once (1000000 blocks, 3000000 lines, 200 MB, 200000 "
          "events, 10000 tools); divide it");
}

Result<void> Reader::read(std::string line) {
  ++line_;
  if (auto fits = room(line.size()); !fits) return fits;
  comments_.clear();
  if (auto bad = strip_line(line, language_.dialect, comments_)) return wrong(*bad);
  for (const std::string& text : comments_) take_header(text, facts_);
  if (line.empty()) return {};
  if (line == language_.through_on) return functions_.event(EventKind::kCoolant, 3.0), Result<void>{};
  if (std::ranges::find(language_.other_axes, line) != language_.other_axes.end()) return {};
  Mistake mistake;
  if (dialogue(line, mistake)) return mistake ? Result<void>(wrong(*mistake)) : Result<void>{};
  DialectWords words;
  if (auto bad = split_words(line, words)) return wrong(*bad);
  if (auto bad = apply(words)) return wrong(*bad);
  return {};
}

Result<void> Reader::too_long() const {
  return fail(Code::kInput, name_ + ":" + std::to_string(line_ + 1) + ": the line is longer than " +
                                std::to_string(kLongestTextLine) + " bytes");
}

Result<NcProgram> Reader::finish() {
  std::erase_if(facts_.operations, [](const TextOperation& op) { return op.blocks.empty(); });
  if (facts_.operations.empty()) return wrong("no motion block before the end");
  if (!own_offsets_.empty())
    facts_.notes.push_back(std::to_string(own_offsets_.size()) +
                           " planes have work offsets of their own; all are read as at part zero");
  return std::move(facts_);
}

}  // namespace

Result<NcProgram> read_nc_program(std::istream& in, const std::string& name, const TextLanguage& language) {
  Reader reader(name, language);
  for (std::string line; !reader.ended();) {
    const LineRead got = read_bounded_line(in, line, kLongestTextLine);
    if (got == LineRead::kEnd) break;
    const auto read = got == LineRead::kLine ? reader.read(line) : reader.too_long();
    if (!read) return tl::unexpected(read.error());
  }
  if (in.bad()) return fail(Code::kIo, name + ": cannot be read");
  return reader.finish();
}

}  // namespace tiltfeed::daemon
