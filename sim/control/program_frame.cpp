#include "sim/control/program_frame.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <deque>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/control/control_words.h"
#include "sim/control/smoothing_words.h"
#include "sim/gcode/lines.h"

namespace tiltfeed::sim {
namespace {

using config::Dialect;
using Wrong = std::optional<std::string>;

// What ends all that others may have left in force, a line's words as they are printed.
constexpr std::array<std::string_view, 5> kSafeRs274{"G21", "G90", "G17", "G40", "G49"};
constexpr std::array<std::string_view, 8> kSafeFanuc{"G21", "G90", "G17", "G40", "G80", "G94", "G49", "G69"};
constexpr std::array<std::string_view, 9> kSafeSiemens{"TRAFOOF", "TOROTOF", "PAROTOF", "TRANS", "G710",
                                                       "G90",     "G17",     "G40",     "G94"};
constexpr std::array<std::string_view, 5> kSafeTnc{"M129", "PLANE RESET", "CYCL DEF 10.0 ROTATION",
                                                   "CYCL DEF 10.1 ROT+0", "M127"};
constexpr std::array<std::string_view, 7> kSafeTncIso{"M129", "PLANE RESET", "G73", "M127",
                                                      "G90",  "G17",         "G40"};

std::span<const std::string_view> safe_words(Dialect dialect) {
  switch (dialect) {
    case Dialect::kRs274:
    case Dialect::kGrbl:
      return kSafeRs274;
    case Dialect::kFanuc:
    case Dialect::kHaas:
      return kSafeFanuc;
    case Dialect::kSiemens:
      return kSafeSiemens;
    case Dialect::kHeidenhain:
      return kSafeTnc;
    case Dialect::kHeidenhainIso:
      break;
  }
  return kSafeTncIso;
}

/// Whether the line has these words, whole.
bool says(std::string_view line, std::string_view words) {
  const auto part_of_word = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || c == '.';
  };
  for (std::size_t at = line.find(words); at != line.npos; at = line.find(words, at + 1)) {
    const std::size_t end = at + words.size();
    const bool begins = at == 0 || !part_of_word(line[at - 1]);
    if (begins && (end == line.size() || !part_of_word(line[end]))) return true;
  }
  return false;
}

/// Whether the program ends there.
bool is_last(std::string_view line) {
  return line.starts_with("END PGM") || says(line, "M2") || says(line, "M02") || says(line, "M30");
}

/// The whole number behind `words`; -1: the line has none there.
int number_after(std::string_view line, std::string_view words) {
  const std::size_t at = line.find(words);
  if (at == line.npos) return -1;
  const std::string digits(line.substr(at + words.size(), 8));
  char* end = nullptr;
  const long number = std::strtol(digits.c_str(), &end, 10);
  return end == digits.c_str() ? -1 : static_cast<int>(number);
}

}  // namespace

class FrameCheck::Frame {
 public:
  explicit Frame(const config::Job& job)
      : job_(job), format_(job.machine.format), retracts_(format_.retract != "none") {
    const auto safe = safe_words(format_.dialect);
    missing_.assign(safe.begin(), safe.end());
    letters_ = {'X', 'Y', 'Z', job.machine.model.tilt.letter, job.machine.model.rotary.letter};
    clamps_ = bare({format_.clamp_tilt, format_.unclamp_tilt, format_.clamp_rotary, format_.unclamp_rotary});
    start_ = bare(format_.start);
    end_ = bare(format_.end);
    if (format_.retract != "default") own_retract_ = bare_line(format_.retract, format_.dialect, room_);
  }

  Wrong take(std::string_view text);
  Wrong end() const {
    if (!posted_ || (ended_ && (closed_ || closing().empty()))) return std::nullopt;
    if (!ended_) return "the program has no end: it was cut off";
    return "the file ends without " + std::string(closing()) + ", which such a control wants: it was cut off";
  }
  /// Nothing behind here is looked at.
  std::uint64_t line() const { return line_; }
  bool done() const { return (ended_ && (closed_ || closing().empty() || !posted_)) || (moved_ && !posted_); }

 private:
  bool tnc() const {
    return format_.dialect == Dialect::kHeidenhain || format_.dialect == Dialect::kHeidenhainIso;
  }
  bool counts_length() const {
    return format_.dialect == Dialect::kFanuc || format_.dialect == Dialect::kHaas;
  }
  /// The lines without comments; those that are comments alone say nothing.
  std::vector<std::string> bare(const std::vector<std::string>& lines) {
    std::vector<std::string> kept;
    for (const std::string& line : lines)
      if (const std::string_view words = bare_line(line, format_.dialect, room_); !words.empty())
        kept.emplace_back(words);
    return kept;
  }
  Wrong read(std::string_view line);
  Wrong read_waiting(std::size_t but);
  Wrong last(std::string_view line);
  bool set_up() const;
  bool left() const;
  /// What the text stands between, beyond the program's own end; empty: nothing.
  std::string_view closing() const;
  void opening(std::string_view line);
  Wrong not_opened() const;
  void header(std::string_view text);
  Wrong tcp_begins(const ControlWords& words);
  Wrong offset(std::string_view line, const ControlWords& words);
  Wrong tool(std::string_view line, const ControlWords& words);
  Wrong planes(std::string_view line, const ControlWords& words);
  Wrong length_register(const ControlWords& words);
  Wrong goes_down(const ControlWords& words) const;
  /// Grbl has no registers, a Heidenhain control takes the length with the tool.
  bool wants_length() const { return tool_ > 0 && !tnc() && format_.dialect != Dialect::kGrbl; }
  Wrong at_end() const;
  Wrong first_move() const;

  const config::Job& job_;
  const config::ProgramFormat& format_;
  const bool retracts_;
  std::vector<std::string_view> missing_;
  std::array<char, 5> letters_;
  std::vector<std::string> clamps_, start_, end_;  ///< the profile's own lines
  std::size_t started_ = 0;                        ///< lines of `start_` that have come
  /// A line that waits until as many as the profile's end has stand behind it, or the end.
  struct Waiting {
    std::string line;
    std::uint64_t number;
  };
  std::deque<Waiting> waiting_;
  std::uint64_t count_ = 0, line_ = 0;  ///< of lines; the one that is looked at
  std::string own_retract_, room_;
  std::vector<int> registers_;  ///< that the header names
  int offset_ = 0, tool_ = 0;
  /// Letters of axes, by place in `letters_`, that have been sent to a place since the last tool change.
  std::array<bool, 5> placed_{};
  bool preset_cycle_ = false;  ///< the line before calls a TNC's preset
  bool changed_ = false;       ///< the tool that is selected has been changed for, or stopped for
  bool linear_rotaries_ = false;
  bool percent_ = false, opened_ = false, begun_ = false, closed_ = false;
  bool length_on_ = false, relative_ = false, tcp_place_ = false;
  bool names_part_ = false, posted_ = false, length_called_ = false, inverse_ = false, tcp_ = false,
       frames_dropped_ = false, moved_ = false, retracted_ = false, ended_ = false, smooth_ = false,
       plane_ = false,
       in_planes_ = false;  ///< a plane is in force; the header says that all moves are in one
};

std::string_view FrameCheck::Frame::closing() const {
  if (format_.dialect == Dialect::kHeidenhain) return "END PGM";
  if (format_.dialect == Dialect::kHeidenhainIso) return "its second % line";
  return format_.percent ? "a second %" : "";
}

/// The lines that a control knows a file of programs by.
void FrameCheck::Frame::opening(std::string_view line) {
  if (line == "%" && !std::exchange(percent_, true) && counts_length()) return;
  begun_ = true;
  if (format_.dialect == Dialect::kHeidenhain)
    opened_ = line.starts_with("BEGIN PGM") && line.ends_with(" MM");
  else if (format_.dialect == Dialect::kHeidenhainIso)
    opened_ = line.front() == '%' && says(line, "G71");
  else
    opened_ = line.front() == 'O' || line.front() == ':' || !counts_length();
}

Wrong FrameCheck::Frame::not_opened() const {
  if (format_.percent && !percent_)
    return "the file does not begin with %: such a control passes over its first line, or takes none of it "
           "(the profile's program.percent)";
  if (opened_) return std::nullopt;
  if (format_.dialect == Dialect::kHeidenhain)
    return "the program does not begin with BEGIN PGM and MM: the control takes no such file, or in inches";
  if (format_.dialect == Dialect::kHeidenhainIso)
    return "the program does not begin with % and G71: the control takes no such file, or in inches";
  return "the program has no O number in front: the control does not take it, or under another number";
}

/// Where TCP begins every word is stated: what is left out stays where the control has the tip, which its
/// parameters and its registers decide.
Wrong FrameCheck::Frame::tcp_begins(const ControlWords& words) {
  const bool in_block = words.has_g(434) || words.has_g(2340);
  if (!in_block && !tcp_place_) return std::nullopt;
  const auto missing = std::find_if(letters_.begin(), letters_.end(),
                                    [&](char letter) { return letter != kNoLetter && !words.has(letter); });
  const bool all_missing =
      std::none_of(letters_.begin(), letters_.end(), [&](char letter) { return words.has(letter); });
  if (!in_block && all_missing) return std::nullopt;
  tcp_place_ = false;
  if (missing == letters_.end()) return std::nullopt;
  return std::string("TCP begins in a block without ") + *missing + ": where the tip is then is not known";
}

/// What every header of a posted program says, and the register in ", H4 too".
void FrameCheck::Frame::header(std::string_view text) {
  names_part_ = names_part_ || text.find("TILTFEED part ") != text.npos;
  posted_ = posted_ || (names_part_ && text.find("TILTFEED blocks ") != text.npos);
  if (text.find("TILTFEED tool length") == text.npos) return;
  in_planes_ = text.find(", planes take the control's") != text.npos;
  for (const std::string_view letter : {", H", ", D"})
    if (const int number = number_after(text, letter); number > 0) registers_.push_back(number);
}

Wrong FrameCheck::Frame::offset(std::string_view line, const ControlWords& words) {
  if (tnc()) {
    const bool called = std::exchange(preset_cycle_, line.starts_with("CYCL DEF 247"));
    const int preset = number_after(line, "Q339=");
    if (preset >= 0 && !called && !line.starts_with("G247")) return "a preset's number without its cycle";
    if (preset >= 0) offset_ = preset;
  } else {
    for (std::size_t i = 0; i < words.g_count; ++i) {
      const int code = words.g[i] / 10;
      const int tenths = words.g[i], p = words.has('P') ? static_cast<int>(words['P']) : 0;
      int called = 0;
      if (code >= 54 && code <= 59) called = code - 53;
      if (tenths >= 591 && tenths <= 593) called = 6 + tenths % 10;
      if (format_.dialect == Dialect::kSiemens && code >= 505 && code <= 599) called = code - 500;
      if (tenths == 541 || tenths == 1540) {
        if (p < 1) return "a further work offset is called without P, its number";
        called = 6 + p;
      }
      if (called > 0) offset_ = called, frames_dropped_ = false;
    }
  }
  if (offset_ == 0 || offset_ == job_.program.work_offset) return std::nullopt;
  return "work offset " + std::to_string(offset_) + " is called, the job's program.work_offset is " +
         std::to_string(job_.program.work_offset);
}

Wrong FrameCheck::Frame::length_register(const ControlWords& words) {
  const bool edge = format_.dialect == Dialect::kSiemens;
  const char letter = edge ? 'D' : 'H';
  if (tnc() || !words.has(letter)) return std::nullopt;
  const bool jobs = job_.program.length_register > 0 && tool_ == job_.program.tool;
  const int stated = static_cast<int>(words[letter]),
            wanted = jobs ? job_.program.length_register : (edge ? 1 : tool_);
  const bool named = std::find(registers_.begin(), registers_.end(), stated) != registers_.end();
  const bool in_force = edge || words.has_g(430) || words.has_g(434) || words.has_g(2340);
  if (edge || in_force) length_called_ = stated != 0;
  if (stated == 0 || wanted == 0 || stated == wanted || (named && !jobs)) return std::nullopt;
  return std::string("the length of register ") + letter + std::to_string(stated) +
         " is called, that of the tool is " + letter + std::to_string(wanted);
}

/// A tilted plane begins before the tool's length counts, where a control nests the two, and ends when the
/// tool is retracted.
Wrong FrameCheck::Frame::planes(std::string_view line, const ControlWords& words) {
  const bool cycle = line.starts_with("CYCLE800("), plane = tnc() && line.starts_with("PLANE ");
  const bool ends = words.has_g(690) || words.has_g(2550) || line == "CYCLE800()" ||
                    (plane && line.starts_with("PLANE RESET"));
  const bool begins = !ends && (words.has_g(682) || words.has_g(2540) || cycle || plane);
  if (!ends && !begins) return std::nullopt;
  const bool in_force = std::exchange(plane_, begins);
  const bool length_on = length_on_ && counts_length();
  if (ends && in_force) placed_ = {};
  if (begins && in_force) return "a tilted plane begins while another is in force";
  if (length_on) return "a tilted plane begins or ends with the tool's length in force: G49 is missing";
  if (retracts_ && !retracted_ && (begins || in_force))
    return "a tilted plane begins or ends before the tool is retracted along the machine's Z";
  return std::nullopt;
}

Wrong FrameCheck::Frame::tool(std::string_view line, const ControlWords& words) {
  const bool call = format_.dialect == Dialect::kHeidenhain;
  const int number = call             ? number_after(line, "TOOL CALL ")
                     : words.has('T') ? static_cast<int>(std::clamp(words['T'], 0.0, 1e6))
                                      : -1;
  if (number < 0) return std::nullopt;
  const bool length_left = std::exchange(length_on_, false) && counts_length();
  tool_ = number, length_called_ = false;
  changed_ = tnc();  // there the call is the change
  placed_ = {};      // a changer may have moved the axes
  if (retracts_ && !retracted_) return "a tool change without a retract along the machine's Z before it";
  if (length_left) return "a tool change with the length of the tool before in force: G49 is missing";
  return std::nullopt;
}

/// Before Z moves from a retract the tool is there, and the other axes have been sent to its place.
Wrong FrameCheck::Frame::goes_down(const ControlWords& words) const {
  if (!words.has('Z')) return std::nullopt;
  if (tool_ > 0 && !changed_)
    return std::string("tool ") + std::to_string(tool_) +
           " is selected, and the change of tools is missing (" +
           (format_.dialect == Dialect::kGrbl ? "M0" : "M6") + ")";
  if (wants_length() && !length_called_) return "Z moves before the register of the tool's length is called";
  if ((tcp_ || plane_) && format_.dialect == Dialect::kSiemens && !length_called_)
    return "Z moves before the tool's length is called again (D): the retract has ended it";
  if (tcp_ && format_.dialect == Dialect::kSiemens && !linear_rotaries_)
    return "TRAORI without ORIMKS ORIAXES: how the rotaries turn within a block is the machine's setting";
  if (job_.program.smoothing != config::Smoothing::kNone && !smooth_)
    return "Z moves before the control is told the job's program.smoothing";
  if (in_planes_ && !plane_) return "Z moves before the tilted plane is called";
  if (!retracts_ || !retracted_) return std::nullopt;
  for (const std::size_t i : {std::size_t{3}, std::size_t{4}, std::size_t{0}, std::size_t{1}})
    if (letters_[i] != kNoLetter && !placed_[i])
      return std::string("Z moves from the retract before ") + letters_[i] + " is at its place";
  return std::nullopt;
}

Wrong FrameCheck::Frame::first_move() const {
  if (auto wrong = not_opened()) return wrong;
  if (!missing_.empty())
    return "the first move comes before " + std::string(missing_.front()) +
           ", which every posted program has";
  if (tool_ == 0 && job_.program.tool > 0) return "the first move comes before a tool is called";
  if (offset_ == 0) return "the first move comes before a work offset is called";
  if (retracts_ && !retracted_) return "the first move comes before a retract along the machine's Z";
  if (started_ < start_.size())
    return "the first move comes before \"" + start_[started_] +
           "\" of the profile's program.start, which stands behind the post's own lines";
  return std::nullopt;
}

/// All that the post says before the profile's start lines has been said. A line that is equal to one of
/// these is the post's own before.
bool FrameCheck::Frame::set_up() const {
  const bool tool_there =
      tool_ > 0 ? changed_ && (length_called_ || counts_length() || !wants_length()) : job_.program.tool == 0;
  return missing_.empty() && offset_ != 0 && !relative_ && tool_there && (retracted_ || !retracts_);
}

/// All that the post says before the profile's end lines has been said.
bool FrameCheck::Frame::left() const {
  const bool length_left = length_on_ && counts_length();
  return moved_ && !inverse_ && !relative_ && !tcp_ && !plane_ && !length_left && (retracted_ || !retracts_);
}

Wrong FrameCheck::Frame::at_end() const {
  if (retracts_ && !retracted_) return "the program ends without a retract along the machine's Z";
  if (inverse_) return "the program ends with G93 in force";
  if (relative_) return "the program ends with G91 in force: the next words would be taken as ways";
  if (smooth_ && job_.program.smoothing != config::Smoothing::kNone)
    return "the program ends with the job's program.smoothing in force";
  if (plane_) return "the program ends with a tilted plane in force: the next words would be taken as in it";
  if (length_on_ && counts_length())
    return "the program ends with the tool's length in force: G49 is missing, and the next tool has another";
  return std::nullopt;
}

Wrong FrameCheck::Frame::take(std::string_view text) {
  line_ = ++count_;
  const std::string_view line = bare_line(text, format_.dialect, room_);
  if (line.empty()) {
    if (text.find("TILTFEED ") != text.npos) header(text);
    return std::nullopt;
  }
  if (ended_) {
    closed_ = closed_ || line.front() == '%' || line.starts_with("END PGM");
    return std::nullopt;
  }
  if (!begun_) opening(line);
  // A block of axis words and F, of which there are many.
  const bool plain_block = line.find_first_of("GMTHDSPQRN=(") == line.npos && line.front() != 'L';
  if (plain_block)
    if (auto wrong = read_waiting(0)) return wrong;
  if (plain_block && moved_ && !retracted_) return std::nullopt;
  if (!moved_ && started_ < start_.size() && line == start_[started_] && set_up()) {
    ++started_;
    return std::nullopt;
  }
  if (is_last(line)) return last(line);
  if (!moved_ || end_.empty()) return read(line);
  waiting_.push_back({std::string(line), count_});
  return read_waiting(end_.size());
}

/// Reads what waits but for so many lines.
Wrong FrameCheck::Frame::read_waiting(std::size_t but) {
  while (waiting_.size() > but) {
    const Waiting next = std::move(waiting_.front());
    waiting_.pop_front();
    line_ = next.number;
    if (auto wrong = read(next.line)) return wrong;
  }
  line_ = count_;
  return std::nullopt;
}

/// The lines before the end are the profile's where the post has said all of its own before them.
Wrong FrameCheck::Frame::last(std::string_view line) {
  const bool own =
      left() && std::equal(waiting_.begin(), waiting_.end(), end_.begin(), end_.end(),
                           [](const Waiting& one, const std::string& end) { return one.line == end; });
  if (own) waiting_.clear();
  if (auto wrong = read_waiting(0)) return wrong;
  ended_ = true;
  closed_ = line.starts_with("END PGM");
  if (!posted_) return std::nullopt;
  if (auto wrong = at_end()) return wrong;
  if (own) return std::nullopt;
  return "the program ends without the lines of the profile's program.end behind the post's own lines";
}

Wrong FrameCheck::Frame::read(std::string_view line) {
  if (std::find(clamps_.begin(), clamps_.end(), line) != clamps_.end()) return std::nullopt;
  std::erase_if(missing_, [&](std::string_view words) { return says(line, words); });
  if (const auto smoothing = smoothing_after(line, format_.dialect)) smooth_ = *smoothing;
  ControlWords words;
  const bool dialogue = format_.dialect == Dialect::kHeidenhain && !line.starts_with("L ") && line[0] != 'M';
  // Where a line cannot be taken apart the reader of its words says what is wrong.
  if (!dialogue && take_apart(line, words)) return std::nullopt;
  if (auto wrong = offset(line, words); wrong && posted_) return wrong;
  if (auto wrong = tool(line, words); wrong && posted_) return wrong;
  if (auto wrong = length_register(words); wrong && posted_) return wrong;
  if (words.has_g(900) || words.has_g(910)) relative_ = words.has_g(910);
  if (auto wrong = planes(line, words); wrong && posted_) return wrong;
  if (words.has_g(490)) length_on_ = length_called_ = false;
  if (words.has_g(430) || words.has_g(434) || words.has_g(2340)) length_on_ = true;
  if (words.has_m(6) || (format_.dialect == Dialect::kGrbl && words.has_m(0))) changed_ = true;
  if (words.named("TRAORI")) frames_dropped_ = true, linear_rotaries_ = false;
  if (words.named("ORIMKS") && words.named("ORIAXES")) linear_rotaries_ = true;
  if (words.named("TRAORI") || words.named("TRAFOOF")) tcp_ = words.named("TRAORI");
  if (tnc() && (words.has_m(128) || words.has_m(129))) tcp_ = words.has_m(128);
  if (words.has_g(930) || words.has_g(940)) inverse_ = words.has_g(930);
  if (auto wrong = tcp_begins(words); wrong && posted_) return wrong;
  tcp_place_ = tcp_place_ || words.named("TRAORI") || (tnc() && words.has_m(128));
  if (posted_ && counts_length() && words.has_g(430) && !words.has('Z'))
    return "G43 in a block without Z: by how much Z moves there is a parameter of the control";
  const bool axes = std::any_of(letters_.begin(), letters_.end(),
                                [&](char letter) { return letter != kNoLetter && words.has(letter); });
  if (!axes || words.has_g(40) || words.has_g(682)) return std::nullopt;
  if (words.has_g(530) || words.has_g(280) || words.named("SUPA") ||
      (tnc() && (words.has_m(91) || words.has_m(92)))) {
    retracted_ = retracted_ || words.has('Z');
    if (posted_ && tcp_) return "a move in machine coordinates comes before TCP is ended";
    if (posted_ && line != own_retract_ && words.named("SUPA") && words.has('Z') &&
        !(words.has('D') && words['D'] == 0.0))
      return "a retract without D0: the tool's length counts there, too";
    return std::nullopt;
  }
  if (posted_ && frames_dropped_) return "TRAORI has dropped the work offset, and it is not called again";
  const bool first = !std::exchange(moved_, true);
  if (first && posted_)
    if (auto wrong = first_move()) return wrong;
  if (posted_)
    if (auto wrong = goes_down(words)) return wrong;
  for (std::size_t i = 0; i < letters_.size(); ++i)
    placed_[i] = placed_[i] || (letters_[i] != kNoLetter && words.has(letters_[i]));
  // Until it goes down it stands there.
  if (words.has('Z')) retracted_ = false;
  return std::nullopt;
}

FrameCheck::FrameCheck(std::string name, const config::Job& job)
    : name_(std::move(name)), frame_(std::make_unique<Frame>(job)) {}
FrameCheck::FrameCheck(FrameCheck&&) noexcept = default;
FrameCheck::~FrameCheck() = default;

tl::unexpected<Error> FrameCheck::wrong(const std::string& what) const {
  return fail(Code::kInput, name_ + ":" + std::to_string(frame_->line()) + ": " + what);
}

Result<void> FrameCheck::take(std::string_view line) {
  if (const auto what = frame_->take(line)) return wrong(*what);
  return {};
}

bool FrameCheck::done() const { return frame_->done(); }

Result<void> FrameCheck::take_rest(Lines& lines) {
  while (!done()) {
    const auto line = lines.next();
    if (!line) break;
    if (auto sound = take(*line); !sound) return sound;
  }
  if (const auto what = frame_->end()) return wrong(*what);
  return {};
}

Result<void> check_frame(std::istream& in, const std::string& name, const config::Job& job) {
  Lines lines(in);
  return FrameCheck(name, job).take_rest(lines);
}

}  // namespace tiltfeed::sim
