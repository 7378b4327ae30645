#include "daemon/block.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <ostream>
#include <string_view>

#include "kinematics/decimal.h"

namespace tiltfeed {
namespace {

// A user's text in a comment: so many characters of [A-Za-z0-9 ._-], and the whole comment no longer than the
// shortest control keeps.
constexpr std::size_t kMaxName = 40;
constexpr std::size_t kMaxComment = 70;
// F has so many significant digits, so its error is at most half of 1e-4 of it.
constexpr int kFeedDigits = 5;
// The least F that kMaxDecimals can print with kFeedError: blocks of up to 69 days.
constexpr double kLeastInverseTime = 1e-5;
// Grbl counts N words up to here, then the count starts again.
constexpr std::uint64_t kMaxLineNumber = 9'999'999;
// Bytes gathered before they go to the stream.
constexpr std::size_t kChunk = 1 << 16;
// The longest motion line: a line number, seven words of kDecimalSpace.
constexpr std::size_t kLineSpace = 8 * kDecimalSpace;

std::string plain(std::string_view text) {
  std::string kept;
  for (const char c : text) {
    const bool allowed = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
                         c == ' ' || c == '.' || c == '_' || c == '-';
    if (allowed && kept.size() < kMaxName) kept += c;
  }
  return kept;
}

/// Decimals that give `value` kFeedDigits significant digits.
int feed_decimals(double value) {
  int decimals = kFeedDigits - 1;
  for (double scaled = value; scaled >= 10.0 && decimals > 0; scaled /= 10.0) --decimals;
  for (double scaled = value; scaled < 1.0 && decimals < kMaxDecimals; scaled *= 10.0) ++decimals;
  return decimals;
}

/// Program lines; without a stream they are measured only.
class Lines {
 public:
  Lines(const ProgramFormat& format, std::ostream* out) : format_(format), out_(out) {}
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  /// "(TILTFEED before NAME after)"; the name is cut where the comment would be too long.
  void comment(std::string_view before, std::string_view name, const std::string& after);
  void add(std::string_view words);
  /// Room for the words of a motion line, its line number already there; closed by `end_line`.
  char* begin_line();
  void end_line(const char* end, std::uint64_t block);
  void flush();

  std::uint64_t bytes() const { return bytes_; }
  const std::string& too_long() const { return too_long_; }

 private:
  void put(std::string_view line, std::uint64_t block);

  const ProgramFormat& format_;
  std::ostream* out_;
  std::string text_;
  std::array<char, kLineSpace> line_;
  std::uint64_t bytes_ = 0, numbered_ = 0;
  std::string too_long_;  ///< the first line that is
};

void Lines::put(std::string_view line, std::uint64_t block) {
  if (line.size() > static_cast<std::size_t>(std::max(format_.max_line_length, 0)) && too_long_.empty())
    too_long_ = "block " + std::to_string(block) + " is " + std::to_string(line.size()) +
                " bytes long, the control takes " + std::to_string(format_.max_line_length) + ": \"" +
                std::string(line) +
                "\"; print fewer decimals or no line numbers, or raise the profile's limit";
  bytes_ += line.size() + 1;
  if (!out_) return;
  text_.append(line);
  text_ += '\n';
  if (text_.size() >= kChunk) flush();
}

void Lines::flush() {
  if (out_) out_->write(text_.data(), static_cast<std::streamsize>(text_.size()));
  text_.clear();
}

void Lines::comment(std::string_view before, std::string_view name, const std::string& after) {
  const std::string head = "(TILTFEED " + std::string(before);
  const auto limit = std::min(kMaxComment, static_cast<std::size_t>(std::max(format_.max_line_length, 0)));
  const std::size_t fixed = head.size() + after.size() + 1;
  put(head + plain(name).substr(0, fixed < limit ? limit - fixed : 0) + after + ")", 0);
}

char* Lines::begin_line() {
  char* out = line_.data();
  if (!format_.line_numbers) return out;
  *out++ = 'N';
  out = std::to_chars(out, out + 20, numbered_++ % kMaxLineNumber + 1).ptr;
  *out++ = ' ';
  return out;
}

void Lines::end_line(const char* end, std::uint64_t block) {
  put({line_.data(), static_cast<std::size_t>(end - line_.data())}, block);
}

void Lines::add(std::string_view words) {
  char* out = begin_line();
  end_line(std::copy(words.begin(), words.end(), out), 0);
}

/// One program, written into Lines.
class ProgramText {
 public:
  ProgramText(const JointPath& path, const Job& job, Lines& lines)
      : path_(path), job_(job), format_(job.machine.format), lines_(lines) {}

  ProgramReport write();

 private:
  void header();
  void block(std::size_t index);
  char* axis(char* out, char letter, double value, double before, int decimals) const;
  char* feed(char* out, double seconds);

  const JointPath& path_;
  const Job& job_;
  const ProgramFormat& format_;
  Lines& lines_;
  Joints at_;
  bool any_ = false, rapid_ = true, inverse_time_ = false;
  ProgramReport report_;
};

void ProgramText::header() {
  const std::string length = decimal(job_.setup.tool_length, 4);
  lines_.comment("part ", job_.plan.name, " D" + decimal(job_.plan.cutter.diameter, 4) + " L" + length);
  lines_.comment("machine ", job_.machine.model.name, "");
  lines_.comment("tool length " + length + " mm is in the words, use G49", "", "");
  lines_.comment("blocks " + std::to_string(path_.moves.size()), "",
                 " time " + decimal(path_.report.seconds, 1) + " s");
  lines_.add("G21 G90 G17 G40 G49 G54");
  if (job_.spindle_rpm > 0.0) lines_.add("S" + decimal(job_.spindle_rpm, 3) + " M3");
}

char* ProgramText::axis(char* out, char letter, double value, double before, int decimals) const {
  if (any_ && value == before) return out;
  assert(round_decimal(value, decimals) == value);
  *out++ = ' ';
  *out++ = letter;
  return write_decimal(out, value, decimals);
}

char* ProgramText::feed(char* out, double seconds) {
  // (K10) G93: F = 1/T in 1/min.
  double f = 60.0 / seconds;
  if (!(f <= format_.max_inverse_time)) {
    f = format_.max_inverse_time;
    ++report_.clamped_feeds;
  }
  f = std::max(f, kLeastInverseTime);
  *out++ = ' ';
  *out++ = 'F';
  return write_decimal(out, f, feed_decimals(f));
}

void ProgramText::block(std::size_t index) {
  const JointMove& move = path_.moves[index];
  const bool rapid = move.kind == MoveKind::kRapid;
  if (!rapid && !inverse_time_) {
    lines_.add("G93");
    inverse_time_ = true;
  }
  const RotaryAxis &tilt = job_.machine.model.tilt, &rotary = job_.machine.model.rotary;
  const Joints& q = move.joints;
  char* const begin = lines_.begin_line();
  char* out = begin;
  if (!any_ || rapid != rapid_) {
    *out++ = 'G';
    *out++ = rapid ? '0' : '1';
  }
  out = axis(out, 'X', q.x, at_.x, format_.linear_decimals);
  out = axis(out, 'Y', q.y, at_.y, format_.linear_decimals);
  out = axis(out, 'Z', q.z, at_.z, format_.linear_decimals);
  out = axis(out, tilt.letter, q.a, at_.a, format_.rotary_decimals);
  out = axis(out, rotary.letter, q.c, at_.c, format_.rotary_decimals);
  if (!rapid) out = feed(out, move.seconds);
  if (*begin == ' ') out = std::copy(begin + 1, out, begin);  // no G word in front
  lines_.end_line(out, index + 1);
  at_ = q;
  rapid_ = rapid;
  any_ = true;
  ++report_.blocks;
}

ProgramReport ProgramText::write() {
  header();
  for (std::size_t i = 0; i < path_.moves.size(); ++i) block(i);
  if (inverse_time_) lines_.add("G94");
  if (job_.spindle_rpm > 0.0) lines_.add("M5");
  lines_.add("M2");
  lines_.flush();
  report_.bytes = lines_.bytes();
  return report_;
}

}  // namespace

Result<ProgramReport> write_program(const JointPath& path, const Job& job, std::ostream& out) {
  if (path.moves.empty()) return fail(Code::kInput, "the joint path has no block");
  assert(path.moves.front().kind == MoveKind::kRapid);
  Lines measured(job.machine.format, nullptr);
  const ProgramReport report = ProgramText(path, job, measured).write();
  if (!measured.too_long().empty()) return fail(Code::kLimit, measured.too_long());
  Lines lines(job.machine.format, &out);
  ProgramText(path, job, lines).write();
  if (!out) return fail(Code::kIo, "the program could not be written: the stream refused it");
  return report;
}

}  // namespace tiltfeed
