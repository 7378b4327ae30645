#include "daemon/post/block.h"

#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <charconv>
#include <optional>
#include <ostream>
#include <string_view>

#include "daemon/post/arc_fit.h"
#include "daemon/post/block_layout.h"
#include "daemon/post/plane_offsets.h"
#include "daemon/post/printed_path.h"
#include "daemon/post/printed_words.h"
#include "daemon/post/tcp_start.h"
#include "kinematics/basics/tolerance_budget.h"
#include "kinematics/timing/tcp_path.h"

namespace tiltfeed::daemon {
namespace {

// Blocks that one thread prints at a time, the room that most of them need, and how many such pieces of text
// may be under way: what is printed but not yet written.
constexpr std::size_t kPieceBlocks = 2048;
constexpr std::size_t kUsualLine = 72;
constexpr std::size_t kPieces = 32;
// The longest motion line: a line number, words of the dialect, seven words of kDecimalSpace.
constexpr std::size_t kLineSpace = 9 * kDecimalSpace;

/// A piece of the program, and what is to be said of it.
struct Piece {
  std::string text;
  std::string too_long;  ///< the first line that is
  std::uint64_t blocks = 0, clamped_feeds = 0;
};

/// One program, printed piece by piece in any order.
class ProgramText {
 public:
  explicit ProgramText(const Posting& posting)
      : posting_(posting),
        format_(posting.machine.format),
        table_(table_of(format_.dialect)),
        words_(format_, posting.machine.model),
        layout_(lay_out(posting)) {}

  std::size_t pieces() const { return (layout_.blocks + kPieceBlocks - 1) / kPieceBlocks; }
  std::size_t blocks() const { return layout_.blocks; }
  Piece piece(std::size_t index) const;

 private:
  /// What a piece knows while it is printed.
  struct State {
    std::uint64_t numbered = 0;  ///< lines with a number before
    std::size_t insert = 0, operation = 0;
    std::string feed;  ///< the F word in force; empty: to be stated
    std::array<char, kLineSpace> line;
  };
  State begin(std::size_t first) const;
  void put(std::string_view text, bool numbered, std::size_t block, State& state, Piece& piece) const;
  void block(std::size_t index, State& state, Piece& piece) const;
  char* feed(char* out, const Operation& op, std::size_t index, State& state, Piece& piece) const;
  double tip_feed(const Operation& op, const JointMove& move) const;

  const Posting& posting_;
  const config::ProgramFormat& format_;
  const DialectTable& table_;
  PrintedWords words_;
  Layout layout_;
};

/// Appends a line, its number in front.
void ProgramText::put(std::string_view text, bool numbered, std::size_t block, State& state,
                      Piece& piece) const {
  const std::size_t start = piece.text.size();
  if (numbered && (table_.numbering != Numbering::kOptional || format_.line_numbers)) {
    const auto step = static_cast<std::uint64_t>(format_.line_number_step);
    const std::uint64_t count = (table_.last_number - table_.first_number) / step + 1;
    if (table_.numbering != Numbering::kPlain) piece.text += 'N';
    piece.text += std::to_string(table_.first_number + state.numbered++ % count * step);
    piece.text += ' ';
  }
  piece.text.append(text);
  if (numbered) piece.text += table_.block_end;
  const std::size_t size = piece.text.size() - start;
  if (size > static_cast<std::size_t>(std::max(format_.max_line_length, 0)) && piece.too_long.empty())
    piece.too_long = "block " + std::to_string(block) + " is " + std::to_string(size) +
                     " bytes long, the control takes " + std::to_string(format_.max_line_length) + ": \"" +
                     piece.text.substr(start) +
                     "\"; print fewer decimals or no line numbers, or raise the profile's limit";
  piece.text += format_.crlf ? "\r\n" : "\n";
}

/// The feed that the path asks for, mm/min.
double ProgramText::tip_feed(const Operation& op, const JointMove& move) const {
  const auto after =
      std::upper_bound(op.feeds.begin(), op.feeds.end(), move.move,
                       [](std::uint32_t m, const FeedChange& change) { return m < change.move; });
  const Feed feed = after != op.feeds.begin()        ? std::prev(after)->feed
                    : move.kind == MoveKind::kPlunge ? op.plunge_feed
                                                     : op.cut_feed;
  return feed.mm_per_min() * move.speed;
}

char* ProgramText::feed(char* out, const Operation& op, std::size_t index, State& state, Piece& piece) const {
  const JointMove& move = op.words->moves[index];
  const PrintedArc* const arc = op.arc(index);
  const FeedWord f = words_.feed_of({op.words->moves[index - 1].joints, move.joints, move.seconds,
                                     tip_feed(op, move), arc != nullptr ? arc->length : 0.0});
  if (f.clamped) ++piece.clamped_feeds;
  char* const end = words_.feed(out, f.value);
  if (words_.feed_always()) return end;
  const std::string_view word(out, static_cast<std::size_t>(end - out));
  if (word == state.feed) return out;
  state.feed = word;
  return end;
}

void ProgramText::block(std::size_t index, State& state, Piece& piece) const {
  while (index >= layout_.spans[state.operation].last) ++state.operation;
  const Span& span = layout_.spans[state.operation];
  const Operation& op = posting_.operations[state.operation];
  const std::vector<JointMove>& moves = op.words->moves;
  const std::size_t at = index - span.first;
  const JointMove& move = moves[at];
  const bool first = at == 0, rapid = move.kind == MoveKind::kRapid;
  const PrintedArc* const arc = op.arc(at);
  // An arc's own block says all that it needs, and so does the one behind it: a program may be entered there.
  const bool restate = first || !table_.modal_motion || arc != nullptr || op.arc(at - 1) != nullptr;
  char* out = state.line.data();
  if (restate || rapid != (moves[at - 1].kind == MoveKind::kRapid)) {
    const std::string_view word = arc != nullptr ? (arc->clockwise ? table_.clockwise : table_.counter)
                                  : rapid        ? table_.rapid
                                                 : table_.feed;
    out = std::copy(word.begin(), word.end(), out);
  }
  if (first) out = std::copy(span.first_words.begin(), span.first_words.end(), out);
  const std::string_view side = span.sides.empty() ? "" : span.side(at);
  if (table_.sides == Sides::kBefore) out = std::copy(side.begin(), side.end(), out);
  if (arc != nullptr)
    out = words_.arc(out, move.joints, *arc);
  else if (first && op.plane)
    out = words_.height(words_.place(out, move.joints), move.joints);
  else if (first && !format_.tcp)
    out = words_.height(out, move.joints);
  else
    out = words_.axes(out, first ? Joints{} : moves[at - 1].joints, move.joints, first);
  const std::string_view end = arc != nullptr ? (arc->clockwise ? table_.clockwise_end : table_.counter_end)
                               : rapid        ? table_.rapid_end
                                              : "",
                         first_end = first ? table_.first_end : "";
  if (table_.sides == Sides::kBehind) out = std::copy(side.begin(), side.end(), out);
  out = std::copy(first_end.begin(), first_end.end(), out);
  out = std::copy(end.begin(), end.end(), out);
  if (!rapid) out = feed(out, op, at, state, piece);
  std::string_view text(state.line.data(), static_cast<std::size_t>(out - state.line.data()));
  if (text.front() == ' ') text.remove_prefix(1);  // no motion word in front
  put(text, true, index + 1, state, piece);
  ++piece.blocks;
}

ProgramText::State ProgramText::begin(std::size_t first) const {
  State state;
  const std::vector<Insert>& inserts = layout_.inserts;
  for (; state.insert < inserts.size() && inserts[state.insert].block < first; ++state.insert)
    if (inserts[state.insert].numbered) ++state.numbered;
  state.numbered += first;
  return state;
}

Piece ProgramText::piece(std::size_t index) const {
  const std::size_t first = index * kPieceBlocks, last = std::min(first + kPieceBlocks, layout_.blocks);
  Piece piece;
  piece.text.reserve(kPieceBlocks * kUsualLine);
  State state = begin(first);
  const auto insert_to = [&](std::size_t block) {
    for (; state.insert < layout_.inserts.size() && layout_.inserts[state.insert].block <= block;
         ++state.insert) {
      const Insert& line = layout_.inserts[state.insert];
      put(line.text, line.numbered, block + 1, state, piece);
      state.feed.clear();
    }
  };
  for (std::size_t i = first; i < last; ++i) {
    insert_to(i);
    block(i, state, piece);
  }
  if (last == layout_.blocks) insert_to(last);
  return piece;
}

/// Takes the pieces in their order.
class Sink {
 public:
  Sink(std::ostream& out, std::size_t pieces, int max_bytes, const StageProgress& progress)
      : out_(out), pieces_(pieces), max_bytes_(max_bytes), progress_(progress) {}

  void take(const Piece& piece) {
    if (error_) return;
    if (!piece.too_long.empty()) return fail_with(Code::kLimit, piece.too_long);
    out_.write(piece.text.data(), static_cast<std::streamsize>(piece.text.size()));
    if (!out_) return fail_with(Code::kIo, "the program could not be written: the stream refused it");
    report_.bytes += piece.text.size();
    if (max_bytes_ > 0 && report_.bytes > static_cast<std::uint64_t>(max_bytes_))
      return fail_with(Code::kLimit,
                       "the program is longer than the " + std::to_string(max_bytes_) +
                           " bytes that the control takes; allow a coarser tolerance, print fewer "
                           "decimals, divide the job, or raise the profile's max_program_bytes");
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
  int max_bytes_;
  const StageProgress& progress_;
  std::optional<Error> error_;
  std::atomic<bool> stopped_ = false;
  ProgramReport report_;
};

/// What the axis may lean moves the shank's end by no more than the tip may stray.
TcpOptions tcp_options(const config::Job& job) {
  TcpOptions options;
  const config::ProgramFormat& format = job.machine.format;
  options.linear_decimals = format.inches ? kTcpDecimals : format.linear_decimals;
  const double lean =
      Angle::from_radians(ToleranceBudget(job.plan.tolerance).words() / job.plan.cutter.shank_length)
          .degrees();
  if (lean > 0.0) options.axis_tolerance = std::min(options.axis_tolerance, lean);
  return options;
}

Result<void> check(const Posting& posting) {
  const config::ProgramFormat& format = posting.machine.format;
  if (posting.operations.empty()) return fail(Code::kInput, "the program has no operation");
  if (auto begins = tcp_can_begin(posting.machine, posting.operations.size()); !begins) return begins;
  std::size_t blocks = 0;
  for (const Operation& op : posting.operations) {
    if (op.words->moves.empty()) return fail(Code::kInput, "the joint path has no block");
    assert(op.words->moves.front().kind == MoveKind::kRapid);
    blocks += op.words->moves.size();
    const DialectTable& table = table_of(format.dialect);
    if (op.tool_number == 0 && *(format.tcp ? table.tcp_length : op.plane ? table.length : "") != '\0')
      return fail(Code::kInput,
                  std::string(format.tcp ? "TCP in " : "a tilted plane in ") +
                      config::name_of(format.dialect).name +
                      " needs a tool number for its H word; state program.tool, or LOADTL/ in the CL file");
  }
  if (format.max_blocks > 0 && blocks > static_cast<std::size_t>(format.max_blocks))
    return fail(Code::kLimit,
                "the program has " + std::to_string(blocks) + " blocks, the control takes " +
                    std::to_string(format.max_blocks) +
                    "; allow a coarser tolerance, divide the job, or raise the profile's max_blocks");
  if (const auto planes = plane_offsets(posting); !planes) return tl::unexpected(planes.error());
  return {};
}

/// One of the stretches between retracts, alone.
JointPath stretch_of(const JointPath& path, const AxisRun& run) {
  JointPath part;
  part.moves.assign(path.moves.begin() + static_cast<std::ptrdiff_t>(run.first),
                    path.moves.begin() + static_cast<std::ptrdiff_t>(run.last));
  part.moves.front().seconds = 0.0;
  for (const JointMove& move : part.moves) part.report.seconds += move.seconds;
  return part;
}

}  // namespace

Result<ProgramReport> write_program(const Posting& posting, std::ostream& out,
                                    const StageProgress& progress) {
  if (auto valid = check(posting); !valid) return tl::unexpected(valid.error());
  const ProgramText text(posting);
  Sink sink(out, text.pieces(), posting.machine.format.max_bytes, progress);
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
  Result<ProgramReport> result = sink.result();
  for (const Operation& op : posting.operations)
    for (const PrintedArc& arc : op.arcs)
      if (result) ++result->arcs, result->arcs_stand_for += arc.stands_for;
  if (result)
    result->planes =
        static_cast<std::uint64_t>(std::count_if(posting.operations.begin(), posting.operations.end(),
                                                 [](const Operation& op) { return op.plane.has_value(); }));
  if (result) result->plane_offsets = *plane_offsets(posting);
  return result;
}

double coolant_value(config::Coolant coolant) {
  return coolant == config::Coolant::kFlood ? 1.0 : coolant == config::Coolant::kMist ? 2.0 : 3.0;
}

PlannedProgram planned_program(const JointPath& path, const std::vector<AxisRun>& runs,
                               const config::Job& job, const HeaderFacts& header) {
  const config::ProgramFormat& format = job.machine.format;
  const pathgen::Cutter& cutter = job.plan.cutter;
  PlannedProgram program{
      {}, {job.plan.name, job.machine, job.program, {}, header.proof, header.seconds, header.start}};
  Operation op;
  op.words = &path;
  op.setup = job.setup;
  op.tool = {cutter.diameter, 0.0, job.setup.tool_length};
  op.tool_number = job.program.tool;
  op.length_register = job.program.length_register;
  op.name = job.operation;
  op.smoothing = job.program.smoothing, op.smoothing_tolerance = job.program.smoothing_tolerance;
  op.cut_feed = job.plan.cut_feed;
  op.plunge_feed = job.plan.plunge_feed;
  if (job.spindle_rpm > 0.0) op.events.push_back({0, EventKind::kSpindle, job.spindle_rpm, ""});
  if (job.program.coolant != config::Coolant::kOff)
    op.events.push_back({0, EventKind::kCoolant, coolant_value(job.program.coolant), ""});
  const auto put = [&] {
    Operation with_arcs = op;
    put_arcs(with_arcs, format, job.program.arc_tolerance, program.words);
    program.posting.operations.push_back(std::move(with_arcs));
  };
  const auto keep = [&](JointPath words) {
    program.words.push_back(std::make_unique<JointPath>(std::move(words)));
    op.words = program.words.back().get();
    put();
  };
  const auto put_words = [&](const JointPath& joints) {
    JointPath words;
    if (format.tcp) words = words_under_tcp(joints, job.machine.model, job.setup, tcp_options(job));
    if (format.inches) words = printed_path(format.tcp ? std::move(words) : joints, format);
    keep(format.tcp || format.inches ? std::move(words) : joints);
  };
  for (const AxisRun& run : runs) {
    op.way = run.way;
    if (format.tilted_planes) {
      const Joints& at = path.moves[run.first].joints;
      op.plane = tilted_plane(job.machine, at.a, at.c);
      keep(words_in_plane(path, run, job.machine, job.setup, *op.plane));
    } else {
      put_words(stretch_of(path, run));
    }
    op.goes_on = true;
    op.events.clear();
  }
  if (!runs.empty()) return program;
  if (format.tcp || format.inches)
    put_words(path);
  else
    put();
  return program;
}

void PlannedProgram::add(PlannedProgram next) {
  const int tool = posting.operations.back().tool_number;
  next.posting.operations.front().keeps_tool = next.posting.operations.front().tool_number == tool;
  for (auto& one : next.words) words.push_back(std::move(one));
  for (Operation& op : next.posting.operations) posting.operations.push_back(std::move(op));
}

Result<ProgramReport> write_program(const JointPath& path, const config::Job& job, std::ostream& out,
                                    const StageProgress& progress) {
  return write_program(planned_program(path, {}, job, {}).posting, out, progress);
}

}  // namespace tiltfeed::daemon
