#include "daemon/block.h"

#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <charconv>
#include <cmath>
#include <optional>
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
// Blocks that one thread prints at a time, the room that most of them need, and how many such pieces of text
// may be under way: what is printed but not yet written.
constexpr std::size_t kPieceBlocks = 2048;
constexpr std::size_t kUsualLine = 72;
constexpr std::size_t kPieces = 32;
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

/// A piece of the program, and what is to be said of it.
struct Piece {
  std::string text;
  std::string too_long;  ///< the first line that is
  std::uint64_t blocks = 0, clamped_feeds = 0;
};

/// The lines of one piece.
class Lines {
 public:
  /// `numbered`: lines with a number before this piece.
  Lines(const ProgramFormat& format, std::uint64_t numbered, Piece& piece)
      : format_(format), numbered_(numbered), piece_(piece) {}
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  /// "(TILTFEED before NAME after)"; the name is cut where the comment would be too long.
  void comment(std::string_view before, std::string_view name, const std::string& after);
  void add(std::string_view words);
  /// Room for the words of a motion line, its line number already there; closed by `end_line`.
  char* begin_line();
  void end_line(const char* end, std::uint64_t block);

 private:
  void put(std::string_view line, std::uint64_t block);

  const ProgramFormat& format_;
  std::uint64_t numbered_;
  Piece& piece_;
  std::array<char, kLineSpace> line_;
};

void Lines::put(std::string_view line, std::uint64_t block) {
  if (line.size() > static_cast<std::size_t>(std::max(format_.max_line_length, 0)) && piece_.too_long.empty())
    piece_.too_long = "block " + std::to_string(block) + " is " + std::to_string(line.size()) +
                      " bytes long, the control takes " + std::to_string(format_.max_line_length) + ": \"" +
                      std::string(line) +
                      "\"; print fewer decimals or no line numbers, or raise the profile's limit";
  piece_.text.append(line);
  piece_.text += '\n';
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

/// One program, printed piece by piece in any order.
class ProgramText {
 public:
  ProgramText(const JointPath& path, const Job& job)
      : moves_(path.moves), seconds_(path.report.seconds), job_(job), format_(job.machine.format) {
    while (first_feed_ < moves_.size() && moves_[first_feed_].kind == MoveKind::kRapid) ++first_feed_;
  }

  std::size_t pieces() const { return (moves_.size() + kPieceBlocks - 1) / kPieceBlocks; }
  Piece piece(std::size_t index) const;

 private:
  /// The modal words in force.
  struct Modal {
    Joints at;
    bool any = false, rapid = true;
  };
  bool spindle() const { return job_.spindle_rpm > 0.0; }
  bool feeds() const { return first_feed_ < moves_.size(); }
  void header(Lines& lines) const;
  void block(std::size_t index, Modal& modal, Lines& lines, Piece& piece) const;
  char* feed(char* out, double seconds, Piece& piece) const;

  const std::vector<JointMove>& moves_;
  double seconds_;
  const Job& job_;
  const ProgramFormat& format_;
  std::size_t first_feed_ = 0;  ///< the block that G93 precedes
};

void ProgramText::header(Lines& lines) const {
  const std::string length = decimal(job_.setup.tool_length, 4);
  lines.comment("part ", job_.plan.name, " D" + decimal(job_.plan.cutter.diameter, 4) + " L" + length);
  lines.comment("machine ", job_.machine.model.name, "");
  lines.comment("tool length " + length + " mm is in the words, use G49", "", "");
  lines.comment("blocks " + std::to_string(moves_.size()), "", " time " + decimal(seconds_, 1) + " s");
  lines.add("G21 G90 G17 G40 G49 G54");
  if (spindle()) lines.add("S" + decimal(job_.spindle_rpm, 3) + " M3");
}

char* axis(char* out, char letter, double value, int decimals) {
  assert(round_decimal(value, decimals) == value);
  *out++ = ' ';
  *out++ = letter;
  return write_decimal(out, value, decimals);
}

char* ProgramText::feed(char* out, double seconds, Piece& piece) const {
  // (K10) G93: F = 1/T in 1/min.
  double f = 60.0 / seconds;
  if (!(f <= format_.max_inverse_time)) {
    f = format_.max_inverse_time;
    ++piece.clamped_feeds;
  }
  f = std::max(f, kLeastInverseTime);
  *out++ = ' ';
  *out++ = 'F';
  return write_decimal(out, f, feed_decimals(f));
}

void ProgramText::block(std::size_t index, Modal& modal, Lines& lines, Piece& piece) const {
  const JointMove& move = moves_[index];
  const bool rapid = move.kind == MoveKind::kRapid;
  if (index == first_feed_) lines.add("G93");
  const RotaryAxis &tilt = job_.machine.model.tilt, &rotary = job_.machine.model.rotary;
  const int linear = format_.linear_decimals, angular = format_.rotary_decimals;
  const Joints &q = move.joints, &at = modal.at;
  char* const begin = lines.begin_line();
  char* out = begin;
  if (!modal.any || rapid != modal.rapid) {
    *out++ = 'G';
    *out++ = rapid ? '0' : '1';
  }
  if (!modal.any || q.x != at.x) out = axis(out, 'X', q.x, linear);
  if (!modal.any || q.y != at.y) out = axis(out, 'Y', q.y, linear);
  if (!modal.any || q.z != at.z) out = axis(out, 'Z', q.z, linear);
  if (!modal.any || q.a != at.a)
    out = axis(out, tilt.letter, control_word(tilt.word, q.a, at.a, angular), angular);
  if (!modal.any || q.c != at.c)
    out = axis(out, rotary.letter, control_word(rotary.word, q.c, at.c, angular), angular);
  if (!rapid) out = feed(out, move.seconds, piece);
  if (*begin == ' ') out = std::copy(begin + 1, out, begin);  // no G word in front
  lines.end_line(out, index + 1);
  modal = {q, true, rapid};
  ++piece.blocks;
}

Piece ProgramText::piece(std::size_t index) const {
  const std::size_t first = index * kPieceBlocks, last = std::min(first + kPieceBlocks, moves_.size());
  // Lines with a number before this piece: of the header, G93, a block each.
  const std::uint64_t opening = first > 0 ? (spindle() ? 2 : 1) + (first_feed_ < first ? 1 : 0) : 0;
  Piece piece;
  piece.text.reserve(kPieceBlocks * kUsualLine);
  Lines lines(format_, opening + first, piece);
  if (first == 0) header(lines);
  Modal modal;
  if (first > 0) modal = {moves_[first - 1].joints, true, moves_[first - 1].kind == MoveKind::kRapid};
  for (std::size_t i = first; i < last; ++i) block(i, modal, lines, piece);
  if (last < moves_.size()) return piece;
  if (feeds()) lines.add("G94");
  if (spindle()) lines.add("M5");
  lines.add("M2");
  return piece;
}

/// Takes the pieces in their order.
class Sink {
 public:
  Sink(std::ostream& out, std::size_t pieces, const StageProgress& progress)
      : out_(out), pieces_(pieces), progress_(progress) {}

  void take(const Piece& piece) {
    if (error_) return;
    if (!piece.too_long.empty()) return fail_with(Code::kLimit, piece.too_long);
    out_.write(piece.text.data(), static_cast<std::streamsize>(piece.text.size()));
    if (!out_) return fail_with(Code::kIo, "the program could not be written: the stream refused it");
    report_.bytes += piece.text.size();
    report_.blocks += piece.blocks;
    report_.clamped_feeds += piece.clamped_feeds;
    const double done = static_cast<double>(++taken_) / static_cast<double>(pieces_);
    if (progress_ && !progress_(done)) fail_with(Code::kCancelled, "cancelled; nothing was written");
  }
  /// Nothing more is wanted; asked from any thread.
  bool stopped() const { return stopped_; }
  Result<ProgramReport> result() const {
    if (error_) return tl::unexpected(*error_);
    return report_;
  }

 private:
  void fail_with(Code code, const std::string& message) {
    error_ = {code, message};
    stopped_ = true;
  }

  std::ostream& out_;
  std::size_t pieces_, taken_ = 0;
  const StageProgress& progress_;
  std::optional<Error> error_;
  std::atomic<bool> stopped_ = false;
  ProgramReport report_;
};

}  // namespace

Result<ProgramReport> write_program(const JointPath& path, const Job& job, std::ostream& out,
                                    const StageProgress& progress) {
  if (path.moves.empty()) return fail(Code::kInput, "the joint path has no block");
  assert(path.moves.front().kind == MoveKind::kRapid);
  const ProgramText text(path, job);
  Sink sink(out, text.pieces(), progress);
  std::size_t next = 0;
  const auto order = [&](tbb::flow_control& flow) {
    if (next == text.pieces() || sink.stopped()) flow.stop();
    return next++;
  };
  tbb::parallel_pipeline(
      kPieces, tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, order) &
                   tbb::make_filter<std::size_t, Piece>(
                       tbb::filter_mode::parallel, [&](std::size_t index) { return text.piece(index); }) &
                   tbb::make_filter<Piece, void>(tbb::filter_mode::serial_in_order,
                                                 [&](const Piece& piece) { sink.take(piece); }));
  return sink.result();
}

}  // namespace tiltfeed
