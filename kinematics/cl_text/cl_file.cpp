#include "kinematics/cl_text/cl_file.h"

#include <array>
#include <charconv>
#include <istream>
#include <optional>
#include <ostream>
#include <string_view>
#include <tuple>
#include <utility>

#include "kinematics/basics/decimal.h"
#include "kinematics/cl_text/apt_file.h"
#include "kinematics/cl_text/apt_record.h"

namespace tiltfeed {
namespace {

// Bytes gathered before they go to the stream.
constexpr std::size_t kChunk = 1 << 16;

constexpr std::string_view kFeedsRemark = "TILTFEED FEEDS CUT,PLUNGE ";
constexpr std::string_view kPlungeRemark = "TILTFEED PLUNGE";
constexpr std::string_view kCutRemark = "TILTFEED CUT";

/// The shortest text that reads back as the same double.
std::string exact(double value) {
  std::array<char, kDecimalSpace> digits;
  const auto end =
      std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed).ptr;
  return {digits.data(), end};
}

/// Of a remark "TILTFEED FEEDS CUT,PLUNGE 800,200" the two feeds, mm/min; nothing where they are no feeds.
std::optional<std::pair<Feed, Feed>> feeds_in(std::string_view remark) {
  remark.remove_prefix(kFeedsRemark.size());
  const std::size_t comma = remark.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const auto cut = apt_number(remark.substr(0, comma)), plunge = apt_number(remark.substr(comma + 1));
  if (!cut || !plunge || !(*cut >= 0.0) || !(*plunge >= 0.0)) return std::nullopt;
  return std::pair{Feed::from_mm_per_min(*cut), Feed::from_mm_per_min(*plunge)};
}

/// Tells cuts and plunges apart by their feeds, and by remarks where both feeds are the same. What is wrong
/// is text behind the line that it is about.
std::optional<std::string> tell_kinds_apart(AptOperation& operation) {
  ToolPath& path = operation.path;
  bool cut_known = false, plunge_known = false;
  for (const PathEvent& event : operation.events) {
    if (!event.text.starts_with(kFeedsRemark)) continue;
    const auto feeds = feeds_in(event.text);
    if (!feeds)
      return std::to_string(operation.lines.front()) + ": the feeds remark wants two feeds in mm/min";
    std::tie(path.cut_feed, path.plunge_feed) = *feeds;
    cut_known = plunge_known = true;
  }
  MoveKind kind = MoveKind::kCut;
  auto change = path.feeds.begin();
  auto remark = operation.events.begin();
  for (std::size_t i = 0; i < path.moves.size(); ++i) {
    if (change != path.feeds.end() && change->move == i) {
      const Feed feed = (change++)->feed;
      if (!std::exchange(cut_known, true)) path.cut_feed = feed;
      if (feed != path.cut_feed && !std::exchange(plunge_known, true)) path.plunge_feed = feed;
      if (feed != path.cut_feed && feed != path.plunge_feed)
        return std::to_string(operation.lines[i]) + ": a third feed, " + decimal(feed.mm_per_min(), 6) +
               " mm/min; a path has a cutting feed and a plunge feed";
      kind = feed == path.cut_feed ? MoveKind::kCut : MoveKind::kPlunge;
    }
    for (; remark != operation.events.end() && remark->move <= i; ++remark) {
      if (remark->text == kPlungeRemark) kind = MoveKind::kPlunge;
      if (remark->text == kCutRemark) kind = MoveKind::kCut;
    }
    if (path.moves[i].kind != MoveKind::kRapid) path.moves[i].kind = kind;
  }
  path.feeds.clear();
  return std::nullopt;
}

}  // namespace

namespace {

/// Text that goes to the stream piece by piece.
class ClText {
 public:
  explicit ClText(std::ostream& out) : out_(out) {}
  void add(std::string_view text) { text_ += text; }
  void add(const Move& move) {
    append_move(text_, move);
    if (text_.size() > kChunk) flush();
  }
  void flush() {
    out_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
    text_.clear();
  }

 private:
  std::ostream& out_;
  std::string text_;
};

/// Tool, spindle, coolant, feeds and moves. `coolant`: that of the operation before.
void put_operation(const ClOperation& operation, double coolant, ClText& text) {
  const ToolPath& path = *operation.path;
  text.add("CUTTER/" + exact(path.tool.diameter) + "," + exact(path.tool.corner_radius) + "\nLOADTL/" +
           std::to_string(operation.tool) + ",LENGTH," + exact(path.tool.length) +
           (operation.length_register > 0 ? ",ADJUST," + std::to_string(operation.length_register) : "") +
           "\n");
  std::string events;
  if (operation.spindle_rpm != 0.0) append_event(events, {0, EventKind::kSpindle, operation.spindle_rpm, ""});
  if (operation.coolant != coolant) append_event(events, {0, EventKind::kCoolant, operation.coolant, ""});
  text.add(events + "PPRINT " + std::string(kFeedsRemark) + exact(path.cut_feed.mm_per_min()) + "," +
           exact(path.plunge_feed.mm_per_min()) + "\n");
  const bool same_feeds = path.cut_feed == path.plunge_feed;
  std::optional<MoveKind> kind;  // of the feed in force
  for (const Move& move : path.moves) {
    if (move.kind != MoveKind::kRapid && kind != move.kind) {
      const bool plunge = move.kind == MoveKind::kPlunge;
      if (!kind || !same_feeds)
        text.add("FEDRAT/" + exact((plunge ? path.plunge_feed : path.cut_feed).mm_per_min()) + ",MMPM\n");
      if (same_feeds) text.add("PPRINT " + std::string(plunge ? kPlungeRemark : kCutRemark) + "\n");
      kind = move.kind;
    }
    text.add(move);
  }
}

}  // namespace

void write_cl(const std::vector<ClOperation>& operations, std::ostream& out) {
  ClText text(out);
  text.add("PARTNO " + operations.front().path->name + "\nUNITS/MM\nMULTAX\n");
  double coolant = 0.0;
  for (const ClOperation& operation : operations) {
    put_operation(operation, coolant, text);
    coolant = operation.coolant;
  }
  text.add("FINI\n");
  text.flush();
}

void write_cl(const ToolPath& path, std::ostream& out) { write_cl({{&path, 1}}, out); }

Result<ToolPath> read_cl(std::istream& in, const std::string& name) {
  AptOptions options;
  options.unit_mm = 1.0;
  options.own_remarks = true;
  auto program = read_apt(in, name, options);
  if (!program) return tl::unexpected(program.error());
  if (!program->notes.empty()) return fail(Code::kInput, program->notes.front());
  if (program->operations.size() > 1)
    return fail(Code::kInput, name + ":" + std::to_string(program->operations[1].lines.front()) +
                                  ": a second tool; a path has one");
  AptOperation& operation = program->operations.front();
  if (const auto bad = tell_kinds_apart(operation)) return fail(Code::kInput, name + ":" + *bad);
  return std::move(operation.path);
}

}  // namespace tiltfeed
