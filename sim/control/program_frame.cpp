#include "sim/control/program_frame.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "sim/control/frame_rules.h"
#include "sim/control/smoothing_words.h"
#include "sim/gcode/lines.h"

namespace tiltfeed::sim {
namespace {

using config::Dialect;

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

/// Whether the program ends there.
bool is_last(std::string_view line) {
  return line.starts_with("END PGM") || says(line, "M2") || says(line, "M02") || says(line, "M30");
}

}  // namespace

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

Frame::Frame(std::span<const config::Job> operations)
    : operations_(operations),
      marked_(!operations.front().operation.name.empty()),
      job_(&operations.front()),
      format_(job_->machine.format),
      retracts_(format_.retract != "none") {
  const auto safe = safe_words(format_.dialect);
  missing_.assign(safe.begin(), safe.end());
  if (format_.inches)
    for (std::string_view& word : missing_) word = word == "G21" ? "G20" : word == "G710" ? "G700" : word;
  letters_ = {'X', 'Y', 'Z', job_->machine.model.tilt.letter, job_->machine.model.rotary.letter};
  clamps_ = bare({format_.clamp_tilt, format_.unclamp_tilt, format_.clamp_rotary, format_.unclamp_rotary});
  start_ = bare(format_.start);
  end_ = bare(format_.end);
  if (format_.retract != "default") own_retract_ = bare_line(format_.retract, format_.dialect, room_);
}

Frame::Wrong Frame::take(std::string_view text) {
  line_ = ++count_;
  const std::string_view line = bare_line(text, format_.dialect, room_);
  if (line.empty()) {
    return text.find("TILTFEED ") != text.npos ? header(text) : std::nullopt;
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
  const bool stands = !spindle_ && job_->spindle_rpm > 0.0;
  if (plain_block && moved_ && !retracted_ && !stands) return std::nullopt;
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
Frame::Wrong Frame::read_waiting(std::size_t but) {
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
Frame::Wrong Frame::last(std::string_view line) {
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

Frame::Wrong Frame::read(std::string_view line) {
  if (std::find(clamps_.begin(), clamps_.end(), line) != clamps_.end()) return std::nullopt;
  std::erase_if(missing_, [&](std::string_view words) { return says(line, words); });
  if (auto wrong = smoothing(line); wrong && posted_) return wrong;
  ControlWords words;
  const bool dialogue = format_.dialect == Dialect::kHeidenhain && !line.starts_with("L ") &&
                        !line.starts_with("C ") && line[0] != 'M';
  // Where a line cannot be taken apart the reader of its words says what is wrong.
  if (!dialogue && take_apart(line, words)) return std::nullopt;
  if (auto wrong = offset(line, words); wrong && posted_) return wrong;
  if (auto wrong = tool(line, words); wrong && posted_) return wrong;
  if (auto wrong = length_register(words); wrong && posted_) return wrong;
  if (auto wrong = arc_plane(words); wrong && posted_) return wrong;
  if (words.has_g(900) || words.has_g(910)) relative_ = words.has_g(910);
  if (auto wrong = planes(line, words); wrong && posted_) return wrong;
  if (posted_ && counts_length() && words.has_g(490) && moved_ && !retracted_ && length_on_)
    return "the tool's length ends before the tool is retracted";
  if (posted_ && words.has_m(4) && job_->spindle_rpm > 0.0)
    return "the spindle turns counter-clockwise (M4), and the job's turns clockwise (M3)";
  if (words.has_m(3) || words.has_m(4)) spindle_ = true;
  if (words.has_m(5)) spindle_ = false;
  if (words.has_g(490)) length_on_ = length_called_ = false;
  if (words.has_g(430) || words.has_g(434) || words.has_g(2340)) length_on_ = true;
  if (words.has_m(6) || (format_.dialect == Dialect::kGrbl && words.has_m(0)))
    changed_ = true, next_tool_ = false;
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
    return retract(line, words);
  }
  if (posted_ && !spindle_ && job_->spindle_rpm > 0.0)
    return "axes move while the spindle stands, and the job's feeds.spindle_rpm is not 0";
  if (posted_ && frames_dropped_) return "TRAORI has dropped the work offset, and it is not called again";
  const bool first = !std::exchange(moved_, true);
  if (first && !posted_ && operations_.size() > 1)
    return "the program does not say where the job's operations begin: verify each operation's program by "
           "itself (--operation)";
  if (first && posted_)
    if (auto wrong = first_move()) return wrong;
  if (posted_)
    if (auto wrong = goes_down(words)) return wrong;
  for (std::size_t i = 0; i < letters_.size(); ++i) {
    if (letters_[i] == kNoLetter || !words.has(letters_[i])) continue;
    placed_[i] = true;
    words_[i] = words[letters_[i]];
  }
  // Until it goes down it stands there.
  if (words.has('Z')) retracted_ = false;
  return std::nullopt;
}

FrameCheck::FrameCheck(std::string name, std::span<const config::Job> operations)
    : name_(std::move(name)), frame_(std::make_unique<Frame>(operations)) {}
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

std::size_t FrameCheck::operation() const { return frame_->operation(); }

Result<void> FrameCheck::take_rest(Lines& lines) {
  while (!done()) {
    const auto line = lines.next();
    if (!line) break;
    if (auto sound = take(*line); !sound) return sound;
  }
  if (const auto what = frame_->end()) return wrong(*what);
  return {};
}

Result<void> check_frame(std::istream& in, const std::string& name, std::span<const config::Job> operations) {
  Lines lines(in);
  return FrameCheck(name, operations).take_rest(lines);
}

}  // namespace tiltfeed::sim
