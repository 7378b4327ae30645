#include "sim/gcode/gcode_reader.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <optional>

#include "sim/gcode/arc_way.h"
#include "sim/gcode/gcode_words.h"
#include "sim/gcode/lines.h"

namespace tiltfeed::sim {
namespace {

constexpr unsigned kAllPlaced = 0b111;

bool has_axes(const Words& words, char tilt, char rotary) {
  return words.has('X') || words.has('Y') || words.has('Z') || words.has(tilt) || words.has(rotary);
}

/// P belongs to G4 or G64, S, F, T and N to anything.
Check check_use(const Words& words, bool axes, MotionMode motion) {
  const bool dwell = words.code[kNonModal] == 40;
  const bool blend = words.code[kPathControl] == 640;
  const bool machine = words.code[kNonModal] == kMachinePlace;
  if (machine && (words.has('X') || words.has('Y') || !words.has('Z')))
    return mistake(Fault::kUnsupported, "G53 moves Z alone here: of this machine only the top of Z is known");
  if (machine && is_feed(motion)) return mistake(Fault::kUnsupported, "G53 with G1; retract with G0");
  if (!axes && (words.code[kMotion] == 20 || words.code[kMotion] == 30))
    return mistake(Fault::kNoMotionMode, words.code[kMotion] == 20
                                             ? "'G2' without an end: an arc wants X, Y or Z"
                                             : "'G3' without an end: an arc wants X, Y or Z");
  for (const char letter : {'I', 'J', 'K'})
    if (words.has(letter) && !(axes && is_arc(motion)))
      return mistake(Fault::kUnusedWord, std::string(1, letter) + " belongs to no arc (G2, G3)");
  if (dwell && !words.has('P')) return mistake(Fault::kMissingP, "G4 has no P (seconds)");
  if (dwell && axes) return mistake(Fault::kUnusedWord, "G4 with axis words; give the dwell its own line");
  if (words.has('P') && !dwell && !blend) return mistake(Fault::kUnusedWord, "P without G4 or G64");
  if (dwell && blend) return mistake(Fault::kUnusedWord, "P with G4 and G64 on one line");
  if (axes && motion == MotionMode::kNone)
    return mistake(Fault::kNoMotionMode, "axis words, but neither G0 nor G1 is in force");
  return std::nullopt;
}

MotionMode motion_mode(const Words& words, MotionMode before) {
  switch (words.code[kMotion]) {
    case 0:
      return MotionMode::kRapid;
    case 10:
      return MotionMode::kFeed;
    case 20:
      return MotionMode::kClockwise;
    case 30:
      return MotionMode::kCounterClockwise;
    case 800:
      return MotionMode::kNone;
    default:
      return before;
  }
}

/// F: on every G1 of G93; in G94 it stays, but not across a change of mode.
Check resolve_feed(const Words& words, bool feed_move, ModalState& modal) {
  const bool inverse = words.code[kFeedMode] == kAbsent ? modal.inverse_time : words.code[kFeedMode] == 930;
  if (inverse != modal.inverse_time) modal.feed = 0.0;
  modal.inverse_time = inverse;
  if (inverse) modal.feed = 0.0;
  if (words.has('F')) modal.feed = words['F'];
  if (feed_move && modal.feed <= 0.0)
    return mistake(Fault::kNoFeed, inverse ? "G1 in G93 wants an F above zero on its own line"
                                           : "G1 before any F above zero in G94");
  return std::nullopt;
}

/// The centre is from the start of the arc.
Check resolve_arc(const Words& words, const ModalState& before, const ModalState& modal, ArcWords& arc) {
  const ArcPlane& plane = arc_plane(modal.plane);
  if (words.has(plane.centre[2]))
    return mistake(Fault::kUnusedWord, std::string(1, plane.centre[2]) + " is no word of an arc in G" +
                                           std::to_string(modal.plane) + ": is its plane lost?");
  if (!words.has(plane.centre[0]) && !words.has(plane.centre[1]))
    return mistake(Fault::kNoCentre,
                   std::string("an arc without ") + plane.centre[0] + " and " + plane.centre[1]);
  if (modal.relative) return mistake(Fault::kUnsupported, "an arc in G91 is not understood");
  if (before.placed != kAllPlaced)
    return mistake(Fault::kUnsupported, "an arc from a place that is not known");
  const auto offset = [&](char letter) { return words.has(letter) ? words[letter] : 0.0; };
  arc = {modal.plane, modal.motion == MotionMode::kClockwise,
         before.at.*plane.first + offset(plane.centre[0]), before.at.*plane.second + offset(plane.centre[1])};
  if (auto wrong = arc_is_wrong(before.at, modal.at, arc)) return mistake(Fault::kBadArc, std::move(*wrong));
  return std::nullopt;
}

/// A move, an arc in straight pieces.
void emit_move(const Block& move, const Joints& from, const ArcWords* arc, std::vector<Block>& blocks) {
  if (arc == nullptr) return blocks.push_back(move);
  const ArcWay way(from, move.target, *arc);
  const int pieces = way.pieces();
  Block piece = move;
  if (move.inverse_time) piece.feed *= pieces;
  for (int i = 1; i <= pieces; ++i) {
    piece.target = way.at(static_cast<double>(i) / pieces);
    piece.goes_on = i < pieces;
    piece.exact_stop = move.exact_stop && i == pieces;
    blocks.push_back(piece);
  }
}

/// T chooses, M6 changes. Before any M6 the tool in the spindle is taken to be what T says: some controls
/// change at once, and others have been told in advance what is there.
void resolve_tool(const Words& words, ModalState& modal) {
  if (words.has('T')) modal.selected = static_cast<int>(std::min(words['T'], kMostTool));
  modal.tool_changed |= words.code[kToolChange] != kAbsent;
  if (words.code[kToolChange] != kAbsent || !modal.tool_changed) modal.tool = modal.selected;
}

/// The line's blocks in order of execution: tool change, spindle, coolant, dwell, motion, stop.
void emit(const Words& words, bool axes, const Joints& before, const ModalState& modal, std::uint32_t line,
          const ArcWords* arc, std::vector<Block>& blocks) {
  Block block;
  block.target = before;
  block.spindle = modal.spindle;
  block.line = line;
  block.tool = modal.tool;
  const auto add_m = [&](Group group) {
    if (words.code[group] == kAbsent) return;
    block.op = Op::kMCode;
    block.m_code = words.code[group];
    blocks.push_back(block);
    block.m_code = -1;
  };
  add_m(kToolChange);
  add_m(kSpindle);
  add_m(kCoolant);
  if (words.code[kNonModal] == 40) {
    block.op = Op::kDwell;
    block.feed = words['P'];
    blocks.push_back(block);
    block.feed = 0.0;
  }
  if (axes) {
    Block move = block;
    const bool feed_move = is_feed(modal.motion);
    move.target = modal.at;
    move.op = feed_move ? Op::kFeed : Op::kRapid;
    move.feed = feed_move ? modal.feed : 0.0;
    move.inverse_time = feed_move && modal.inverse_time;
    move.exact_stop = modal.exact_stop;
    move.placed = modal.placed == kAllPlaced;
    move.off_path = modal.off_path;
    emit_move(move, before, arc, blocks);
  }
  block.target = modal.at;
  add_m(kStopping);
}

}  // namespace

Result<void> GcodeReader::read_line(std::string_view line, std::vector<Block>& blocks) {
  ++lines_;
  fault_ = Fault::kNone;
  while (line.ends_with('\r') || line.ends_with('\n')) line.remove_suffix(1);
  const auto refuse = [&](Check& bad) {
    fault_ = bad->fault;
    return fail(Code::kInput, std::move(bad->message));
  };
  Words words;
  if (!take_plain_words(line, tilt_, rotary_, relative_known_, words)) {
    words.clear();
    if (Check bad = strip(line, text_)) return refuse(bad);
    if (text_ == "%") return {};
    std::string_view rest = text_;
    while (!rest.empty())
      if (Check bad = take_word(rest, tilt_, rotary_, relative_known_, words)) return refuse(bad);
  }
  if (words.empty()) return {};

  ModalState next = modal_;
  next.motion = motion_mode(words, modal_.motion);
  const bool axes = has_axes(words, tilt_, rotary_);
  if (Check bad = check_use(words, axes, next.motion)) return refuse(bad);
  if (Check bad = resolve_feed(words, axes && is_feed(next.motion), next)) return refuse(bad);
  if (words.code[kPlane] != kAbsent) next.plane = words.code[kPlane] / 10;
  if (words.code[kPathControl] != kAbsent) next.exact_stop = words.code[kPathControl] != 640;
  if (words.has('S')) next.spindle = words['S'];
  resolve_tool(words, next);
  if (words.code[kDistance] != kAbsent) next.relative = words.code[kDistance] == kRelative;
  const double kept = next.relative ? 1.0 : 0.0;
  if (words.has('X')) next.at.x = words['X'] + kept * next.at.x;
  if (words.has('Y')) next.at.y = words['Y'] + kept * next.at.y;
  const bool machine = words.code[kNonModal] == kMachinePlace;
  if (words.has('Z')) next.at.z = words['Z'] + (machine ? top_ : kept * next.at.z);
  next.placed |= (words.has('X') ? 1U : 0U) | (words.has('Y') ? 2U : 0U) | (words.has('Z') ? 4U : 0U);
  // A feed move goes from a known place, whatever the program said.
  if (axes && is_feed(next.motion)) next.placed = kAllPlaced;
  next.off_path = next.off_path || machine;
  const auto turned = [&](RotaryWord counting, char letter, double at) {
    return next.relative ? at + words[letter] : turned_to(counting, words[letter], at);
  };
  if (words.has(tilt_)) next.at.a = turned(tilt_word_, tilt_, modal_.at.a);
  if (words.has(rotary_)) next.at.c = turned(rotary_word_, rotary_, modal_.at.c);

  const bool turns = axes && is_arc(next.motion);
  ArcWords arc;
  if (turns)
    if (Check bad = resolve_arc(words, modal_, next, arc)) return refuse(bad);
  emit(words, axes, modal_.at, next, words.has('N') ? static_cast<std::uint32_t>(words['N']) : lines_,
       turns ? &arc : nullptr, blocks);
  modal_ = next;
  if (words.has('Z') && !machine) modal_.off_path = false;
  if (words.code[kStopping] == 2 || words.code[kStopping] == 30) {
    ended_ = true;
    modal_.inverse_time = modal_.relative = false;  // the end of a program restores G1, G90 and G94
    modal_.feed = 0.0;
    modal_.motion = MotionMode::kFeed;
    modal_.plane = 17;
  }
  return {};
}

Result<std::vector<Block>> GcodeReader::read_line(std::string_view line) {
  std::vector<Block> blocks;
  if (auto read = read_line(line, blocks); !read) return tl::unexpected<Error>(std::move(read.error()));
  return blocks;
}

double turned_to(RotaryWord counting, double word, double at) {
  if (counting == RotaryWord::kAccumulate) return word;
  if (counting == RotaryWord::kShortest) return at + std::remainder(word - at, 360.0);
  // The place of the word on the turn that `at` is on; the next or the one before where that is behind.
  const double on = 360.0 * std::floor(at / 360.0) + std::abs(word);
  if (std::signbit(word)) return on > at ? on - 360.0 : on;
  return on < at ? on + 360.0 : on;
}

Result<std::vector<Block>> read_program(std::istream& in, const std::string& name, char tilt_letter,
                                        char rotary_letter) {
  return read_program(in, name, GcodeReader(tilt_letter, rotary_letter));
}

Result<std::vector<Block>> read_program(std::istream& in, const std::string& name, GcodeReader reader) {
  std::vector<Block> blocks;
  auto read = read_program(in, name, std::move(reader), [&](const Block& block) { blocks.push_back(block); });
  if (!read) return tl::unexpected(std::move(read.error()));
  return blocks;
}

Result<void> read_program(std::istream& in, const std::string& name, GcodeReader reader,
                          const std::function<void(const Block&)>& take) {
  Lines lines(in);
  std::vector<Block> blocks;
  std::uint64_t number = 0;
  int percents = 0;
  while (!reader.ended() && percents < 2) {
    const auto line = lines.next();
    if (!line) break;
    ++number;
    const std::size_t first = line->find_first_not_of(" \t");
    if (first != std::string::npos && (*line)[first] == '%') ++percents;
    blocks.clear();
    if (auto read = reader.read_line(*line, blocks); !read)
      return fail(read.error().code, name + ":" + std::to_string(number) + ": " + read.error().message);
    for (const Block& block : blocks) take(block);
  }
  if (in.bad()) return fail(Code::kIo, name + ": cannot be read to its end");
  return {};
}

}  // namespace tiltfeed::sim
