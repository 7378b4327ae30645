#include "sim/program.h"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <span>

namespace tiltfeed::sim {
namespace {

struct Mistake {
  Fault fault = Fault::kNone;
  std::string message;
};
using Check = std::optional<Mistake>;

Check mistake(Fault fault, std::string message) { return Mistake{fault, std::move(message)}; }

// The modal groups of RS274; one code of each may stand on a line.
enum Group {
  kNonModal,
  kMotion,
  kPlane,
  kDistance,
  kFeedMode,
  kUnits,
  kCutterRadius,
  kToolLength,
  kOffset,
  kPathControl,
  kSpindleMode,
  kStopping,
  kToolChange,
  kSpindle,
  kCoolant,
  kGroups
};

constexpr int kAbsent = -1;
constexpr double kLargestLineNumber = 4294967295.0;  // Block::line is 32 bits wide
constexpr double kLargestCode = 9999.0;              // beyond any G, M or T number; keeps the int casts exact

/// The words of one line. G codes are kept in tenths (G61.1 = 611).
struct Words {
  std::array<double, 26> value{};
  std::uint32_t seen = 0;  ///< bit per letter
  std::array<int, kGroups> code;

  Words() { code.fill(kAbsent); }
  bool has(char letter) const { return (seen >> (letter - 'A') & 1U) != 0; }
  double operator[](char letter) const { return value[static_cast<std::size_t>(letter - 'A')]; }
};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return c >= 'A' && c <= 'Z'; }
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

/// Drops blanks and comments, turns to upper case.
Check strip(std::string_view line, std::string& text) {
  text.clear();
  bool in_comment = false;
  for (const char c : line) {
    if (in_comment) {
      if (c == '(') return mistake(Fault::kNoLetter, "a comment inside a comment; remove the inner '('");
      in_comment = c != ')';
      continue;
    }
    if (c == ';') break;
    if (c == '(') {
      in_comment = true;
    } else if (c != ' ' && c != '\t' && c != '\r' && c != '\n') {
      text.push_back(upper(c));
    }
  }
  if (in_comment) return mistake(Fault::kNoLetter, "the comment has no ')'");
  return std::nullopt;
}

/// The word that starts at `text`, for messages.
std::string word_at(std::string_view text) {
  std::size_t end = 1;
  while (end < text.size() && !is_letter(text[end])) ++end;
  return "'" + std::string(text.substr(0, end)) + "'";
}

struct Known {
  int code;  ///< G in tenths
  Group group;
};
constexpr Known kGCodes[] = {
    {0, kMotion},         {10, kMotion},      {40, kNonModal},  {170, kPlane},       {210, kUnits},
    {400, kCutterRadius}, {490, kToolLength}, {540, kOffset},   {550, kOffset},      {560, kOffset},
    {570, kOffset},       {580, kOffset},     {590, kOffset},   {610, kPathControl}, {611, kPathControl},
    {640, kPathControl},  {800, kMotion},     {900, kDistance}, {930, kFeedMode},    {940, kFeedMode},
    {970, kSpindleMode}};
constexpr Known kMCodes[] = {{0, kStopping}, {1, kStopping}, {2, kStopping}, {30, kStopping},
                             {3, kSpindle},  {4, kSpindle},  {5, kSpindle},  {6, kToolChange},
                             {7, kCoolant},  {8, kCoolant},  {9, kCoolant}};

struct RefusedCode {
  int tenths;
  const char* why;
};
constexpr RefusedCode kRefusedGCodes[] = {
    {20, "arcs are refused; use G1 blocks"},
    {30, "arcs are refused; use G1 blocks"},
    {180, "only the plane G17 is known"},
    {190, "only the plane G17 is known"},
    {200, "inches are refused; use G21 and mm"},
    {280, "going home is refused, its way is not in the program"},
    {300, "going home is refused, its way is not in the program"},
    {434, "tool centre control is not in this machine; post without it"},
    {910, "incremental words are refused; use G90"}};

constexpr int kRelative = 910;

/// The group of a code, or the reason why it is refused.
Check find_group(char letter, int code, const std::string_view rest, bool relative_known, Group& group) {
  if (letter == 'G' && code == kRelative && relative_known) {
    group = kDistance;
    return std::nullopt;
  }
  const std::span<const Known> known = letter == 'G' ? std::span<const Known>(kGCodes) : kMCodes;
  for (const Known& entry : known) {
    if (entry.code != code) continue;
    group = entry.group;
    return std::nullopt;
  }
  if (letter == 'G')
    for (const RefusedCode& refused : kRefusedGCodes)
      if (refused.tenths == code) return mistake(Fault::kUnsupported, word_at(rest) + ": " + refused.why);
  return mistake(Fault::kUnsupported, word_at(rest) + ": this machine has no such code");
}

Check take_code(char letter, double value, std::string_view rest, bool relative_known, Words& words) {
  const double scaled = letter == 'G' ? value * 10.0 : value;
  if (value < 0.0 || value > kLargestCode || std::abs(scaled - std::round(scaled)) > 1e-6)
    return mistake(Fault::kNotInteger, word_at(rest) + ": not a code number");
  const int number = static_cast<int>(std::lround(scaled));
  Group group = kNonModal;
  if (Check bad = find_group(letter, number, rest, relative_known, group)) return bad;
  if (words.code[group] != kAbsent)
    return mistake(Fault::kModalConflict, word_at(rest) + ": a second code of the same modal group");
  words.code[group] = number;
  return std::nullopt;
}

Check take_value(char letter, double value, std::string_view rest, Words& words) {
  const std::uint32_t bit = 1U << (letter - 'A');
  if ((words.seen & bit) != 0) return mistake(Fault::kRepeatedWord, word_at(rest) + ": the letter twice");
  const bool whole = value == std::floor(value);
  if (letter == 'N' && (!whole || value < 0.0 || value > kLargestLineNumber))
    return mistake(Fault::kLineNumber, word_at(rest) + ": line numbers are whole, 0 to 4294967295");
  if (letter == 'T' && !whole) return mistake(Fault::kNotInteger, word_at(rest) + ": not a tool number");
  if (value < 0.0 && (letter == 'F' || letter == 'S' || letter == 'T' || letter == 'P'))
    return mistake(Fault::kNegative, word_at(rest) + ": must not be negative");
  words.seen |= bit;
  words.value[static_cast<std::size_t>(letter - 'A')] = value;
  return std::nullopt;
}

Check take_word(std::string_view& rest, char tilt, char rotary, bool relative_known, Words& words) {
  const char letter = rest[0];
  if (!is_letter(letter)) return mistake(Fault::kNoLetter, word_at(rest) + ": a letter is expected");
  const bool code = letter == 'G' || letter == 'M';
  const bool axis = letter == 'X' || letter == 'Y' || letter == 'Z' || letter == tilt || letter == rotary;
  const bool other = letter == 'N' || letter == 'F' || letter == 'S' || letter == 'T' || letter == 'P';
  if (!code && !axis && !other)
    return mistake(Fault::kUnsupported, word_at(rest) + ": this machine has no word " + letter);
  const char* first = rest.data() + 1;
  const char* const last = rest.data() + rest.size();
  if (first != last && *first == '+') ++first;
  const char* const digits = first != last && *first == '-' ? first + 1 : first;
  double value = 0.0;
  // from_chars would also take "inf", "nan" and, after our '+', a '-'.
  const bool starts_well =
      digits != last && (is_digit(*digits) || *digits == '.') && (digits == first || *(first - 1) != '+');
  const auto [end, error] = starts_well ? std::from_chars(first, last, value, std::chars_format::fixed)
                                        : std::from_chars_result{first, std::errc::invalid_argument};
  const bool exponent = end != last && *end == 'E';
  if (error != std::errc() || exponent || (end != last && !is_letter(*end)))
    return mistake(Fault::kBadNumber, word_at(rest) + ": the number is malformed (digits, one point, no E)");
  Check bad =
      code ? take_code(letter, value, rest, relative_known, words) : take_value(letter, value, rest, words);
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return bad;
}

bool has_axes(const Words& words, char tilt, char rotary) {
  return words.has('X') || words.has('Y') || words.has('Z') || words.has(tilt) || words.has(rotary);
}

/// P belongs to G4 or G64, S, F, T and N to anything.
Check check_use(const Words& words, bool axes, MotionMode motion) {
  const bool dwell = words.code[kNonModal] == 40;
  const bool blend = words.code[kPathControl] == 640;
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

/// The line's blocks in order of execution: tool change, spindle, coolant, dwell, motion, stop.
void emit(const Words& words, bool axes, const Joints& before, const ModalState& modal, std::uint32_t line,
          std::vector<Block>& blocks) {
  Block block;
  block.target = before;
  block.spindle = modal.spindle;
  block.line = line;
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
    const bool feed_move = modal.motion == MotionMode::kFeed;
    move.target = modal.at;
    move.op = feed_move ? Op::kFeed : Op::kRapid;
    move.feed = feed_move ? modal.feed : 0.0;
    move.inverse_time = feed_move && modal.inverse_time;
    move.exact_stop = modal.exact_stop;
    blocks.push_back(move);
  }
  block.target = modal.at;
  add_m(kStopping);
}

}  // namespace

Result<void> GcodeReader::read_line(std::string_view line, std::vector<Block>& blocks) {
  ++lines_;
  fault_ = Fault::kNone;
  const auto refuse = [&](Check& bad) {
    fault_ = bad->fault;
    return fail(Code::kInput, std::move(bad->message));
  };
  if (Check bad = strip(line, text_)) return refuse(bad);
  if (text_.empty() || text_ == "%") return {};

  Words words;
  std::string_view rest = text_;
  while (!rest.empty())
    if (Check bad = take_word(rest, tilt_, rotary_, relative_known_, words)) return refuse(bad);

  ModalState next = modal_;
  next.motion = motion_mode(words, modal_.motion);
  const bool axes = has_axes(words, tilt_, rotary_);
  if (Check bad = check_use(words, axes, next.motion)) return refuse(bad);
  if (Check bad = resolve_feed(words, axes && next.motion == MotionMode::kFeed, next)) return refuse(bad);
  if (words.code[kPathControl] != kAbsent) next.exact_stop = words.code[kPathControl] != 640;
  if (words.has('S')) next.spindle = words['S'];
  if (words.code[kDistance] != kAbsent) next.relative = words.code[kDistance] == kRelative;
  const double kept = next.relative ? 1.0 : 0.0;
  if (words.has('X')) next.at.x = words['X'] + kept * next.at.x;
  if (words.has('Y')) next.at.y = words['Y'] + kept * next.at.y;
  if (words.has('Z')) next.at.z = words['Z'] + kept * next.at.z;
  const auto turned = [&](RotaryWord counting, char letter, double at) {
    return next.relative ? at + words[letter] : turned_to(counting, words[letter], at);
  };
  if (words.has(tilt_)) next.at.a = turned(tilt_word_, tilt_, modal_.at.a);
  if (words.has(rotary_)) next.at.c = turned(rotary_word_, rotary_, modal_.at.c);

  emit(words, axes, modal_.at, next, words.has('N') ? static_cast<std::uint32_t>(words['N']) : lines_,
       blocks);
  modal_ = next;
  if (words.code[kStopping] == 2 || words.code[kStopping] == 30) {
    ended_ = true;
    modal_.inverse_time = modal_.relative = false;  // the end of a program restores G1, G90 and G94
    modal_.feed = 0.0;
    modal_.motion = MotionMode::kFeed;
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
  std::string line;
  std::uint64_t number = 0;
  int percents = 0;
  while (!reader.ended() && percents < 2 && std::getline(in, line)) {
    ++number;
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first != std::string::npos && line[first] == '%') ++percents;
    if (auto read = reader.read_line(line, blocks); !read)
      return fail(read.error().code, name + ":" + std::to_string(number) + ": " + read.error().message);
  }
  if (in.bad()) return fail(Code::kIo, name + ": cannot be read to its end");
  return blocks;
}

}  // namespace tiltfeed::sim
