#include "daemon/post/block_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "config/table_home.h"
#include "daemon/post/comment_text.h"
#include "daemon/post/high_speed.h"
#include "daemon/post/plane_offsets.h"
#include "daemon/post/printed_words.h"
#include "daemon/post/program_filling.h"
#include "daemon/post/tcp_start.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/basics/units.h"
#include "kinematics/timing/timing.h"

namespace tiltfeed::daemon {
namespace {

// A comment is no longer than the shortest control keeps.
constexpr std::size_t kMaxComment = 70;
constexpr double kUsualPlane = 17.0;  // G17, that of X and Y

class Writer {
 public:
  explicit Writer(const Posting& posting);
  Layout write();

 private:
  void line(const std::string& text);
  void lines(const char* words);
  /// "(TILTFEED before NAME after)"; the name is cut where the comment would be too long.
  void comment(std::string_view before, std::string_view name, const std::string& after);
  void remark(const std::string& text);
  void header();
  void begin(const Operation& op, bool first);
  void turn(const Operation& op);
  void call_length(const Operation& op);
  void call_offset(const Operation& op);
  void preselect(const Operation& op);
  void tool_comments(const Operation& op);
  void modes();
  void retract();
  using WordsOf = char* (PrintedWords::*)(char*, const Joints&) const;
  void positions(const Operation& op);
  void go_to(const PrintedWords& words, WordsOf say, const Joints& to);
  bool swing(const Operation& op, const PrintedWords& words, const Joints& first);
  void event(const PathEvent& event);
  void coolant(double kind);
  void cutter_side(const char* words, const Filling& filling);
  void motion(const Operation& op);
  void leave();
  void finish();
  void clamp(const Operation& op, std::size_t index);
  void before_arc(const PrintedArc& arc, const Joints& from);
  void usual_plane();
  std::string first_words() const;
  Joints first_place_of(const Operation& op) const;
  std::size_t blocks() const;

  const Posting& posting_;
  const config::ProgramFormat& format_;
  const DialectTable& table_;
  Filling filling_;
  Layout layout_;
  std::size_t at_ = 0;               ///< the block that lines stand before
  std::vector<PlaneOffset> planes_;  ///< that have work offsets of their own
  int offset_;                       ///< the work offset that is called
  double spindle_ = 0.0, coolant_ = 0.0, plane_ = kUsualPlane;
  bool smooth_ = false;         ///< the high-speed function is on
  const char* side_ = nullptr;  ///< a word of cutter compensation that is still to be said
  bool fed_ = false, compensated_ = false, shorter_ = false, tilt_clamped_ = false, rotary_clamped_ = false;
};

Writer::Writer(const Posting& posting)
    : posting_(posting),
      format_(posting.machine.format),
      table_(table_of(format_.dialect)),
      filling_(filling_of(posting)),
      planes_(plane_offsets(posting).value_or(std::vector<PlaneOffset>{})),
      offset_(posting.data.work_offset) {}

void Writer::line(const std::string& text) {
  const bool numbered = std::string_view(table_.unnumbered).find(text.front()) == std::string_view::npos;
  layout_.inserts.push_back({at_, text, numbered});
}

void Writer::lines(const char* words) {
  for (const std::string& text : filled(words, filling_)) line(text);
}

void Writer::comment(std::string_view before, std::string_view name, const std::string& after) {
  const std::string head = table_.comment_open + ("TILTFEED " + std::string(before));
  const std::string close = after + table_.comment_close;
  const auto limit = std::min(kMaxComment, static_cast<std::size_t>(std::max(format_.max_line_length, 0)));
  const std::size_t fixed = head.size() + close.size();
  line(head + plain(name).substr(0, fixed < limit ? limit - fixed : 0) + close);
}

void Writer::remark(const std::string& text) {
  if (!plain(text).empty()) line(table_.comment_open + plain(text) + table_.comment_close);
}

void Writer::header() {
  if (format_.percent) line("%");
  lines(table_.open);
  const Operation& first = posting_.operations.front();
  fill_tool(filling_, first);
  comment("part ", posting_.name,
          " D" + decimal(first.tool.diameter, 4) + " L" + decimal(first.tool.length, 4));
  comment("machine ", posting_.machine.model.name, "");
  tool_comments(first);
  if (format_.tcp && !config::table_turns(posting_.machine.model).empty()) {
    comment("X Y Z are fixed to the table at home", "", "");
    if (*table_.tcp_frame != '\0') comment(table_.tcp_frame, "", "");
    if (!posting_.start.empty()) comment(posting_.start, "", "");
  }
  for (const std::string& text : offset_remarks(planes_, posting_.machine)) comment(text, "", "");
  double seconds = 0.0;
  for (const Operation& op : posting_.operations) seconds += op.words->report.seconds;
  seconds = posting_.seconds.value_or(seconds);
  comment("blocks " + std::to_string(blocks()), "", " time " + decimal(seconds, 1) + " s");
  if (!posting_.proof.empty()) comment(posting_.proof, "", "");
  lines(table_.setup);
}

void Writer::tool_comments(const Operation& op) {
  if (!op.name.name.empty())
    comment("operation " + std::to_string(op.name.number) + " of " + std::to_string(op.name.count) + " ",
            op.name.name, "");
  const std::string length = decimal(op.tool.length, 4);
  const char* const use = op.tool_number > 0 ? table_.length_in_tool : table_.length_alone;
  if (format_.tcp || op.plane)
    comment("tool length " + length + " mm is planned, " + (op.plane ? "planes take" : "TCP takes") +
                " the control's",
            "", "");
  else
    comment("tool length " + length + " mm is in the words" + filled_line(use, filling_), "", "");
  comment("part zero " + triple(op.setup.part_zero, 6) + " mm", "", "");
  if (turns(op.setup.fixture))
    comment("fixture " + triple(fixture_degrees(op.setup.fixture), 9) + " deg", "", "");
}

/// That of the operation's plane, where it has another: the rotaries and X Y go to their place by it.
void Writer::call_offset(const Operation& op) {
  const int own = offset_of(planes_, posting_, op);
  if (own == std::exchange(offset_, own)) return;
  for (const std::string& text :
       filled(table_.plane_offset, {{"offset", work_offset_word(format_.dialect, own)}}))
    line(text);
}

/// Between two planes of one tool, or two of its stretches.
void Writer::turn(const Operation& op) {
  if (shorter_) lines(table_.shorter_off);
  shorter_ = false;
  usual_plane();
  if (fed_) lines(table_.per_minute_on);
  fed_ = false;
  if (format_.tcp) lines(table_.tcp_off);
  retract();
  if (op.plane) lines(table_.plane_done);
  call_length(op);
  call_offset(op);
  for (const std::string& open :
       {tilt_clamped_ ? format_.unclamp_tilt : "", rotary_clamped_ ? format_.unclamp_rotary : ""})
    if (!open.empty()) line(open);
  tilt_clamped_ = rotary_clamped_ = false;
}

/// Where the control adds the tool's length, its register's too, and a retract ends that.
void Writer::call_length(const Operation& op) {
  if (format_.tcp || op.plane || op.tool_number > 0) lines(table_.edge);
}

/// The next operation's tool, where it is another.
void Writer::preselect(const Operation& op) {
  const auto after = std::find_if(posting_.operations.begin() + (&op - posting_.operations.data()),
                                  posting_.operations.end(),
                                  [&](const Operation& one) { return one.tool_number != op.tool_number; });
  if (after == posting_.operations.end() || after->tool_number == 0) return;
  for (const std::string& text : filled(table_.preselect, {{"next", std::to_string(after->tool_number)}}))
    line(text);
}

/// Before an operation: the tool taken off along the machine's Z from wherever it is, its tool; before the
/// first: the modes, too.
void Writer::begin(const Operation& op, bool first) {
  fill_tool(filling_, op);
  if (op.goes_on) return turn(op);
  if (!first) leave();
  retract();
  if (first) lines(table_.plane_off);
  // What others left on, where the words above do not end it.
  const bool ended =
      first && (*table_.plane_off == '\0' ? table_.numbering != Numbering::kOptional
                                          : table_.plane_off == std::string_view(table_.plane_done));
  if (op.plane && !ended) lines(table_.plane_done);
  if (smooth_) lines(table_.smooth_off);
  if (!first) tool_comments(op);
  if (op.keeps_tool)
    lines(table_.edge);
  else if (op.tool_number > 0)
    lines(table_.tool);
  else
    call_length(op);
  if (format_.preselects && !op.keeps_tool) preselect(op);
  call_offset(op);
  for (const std::string& open : {format_.unclamp_tilt, format_.unclamp_rotary})
    if (!open.empty()) line(open);
  tilt_clamped_ = rotary_clamped_ = false;
  if (first) {
    modes();
    for (const std::string& own : format_.start) line(own);
  }
  smooth_ = op.smoothing != config::Smoothing::kNone;
  if (smooth_)
    for (const std::string& text : high_speed_lines(posting_, op)) line(text);
}

/// The control's own tool length ends up there: ended below, the next Z would be deeper by it.
void Writer::retract() {
  if (format_.retract == "default")
    lines(table_.retract);
  else if (format_.retract != "none" && !format_.retract.empty())
    line(format_.retract);
  lines(table_.length_off);
}

void Writer::modes() {
  if (format_.path_control != config::PathControl::kControl) lines(table_.exact);
  if (format_.tcp || format_.feed_mode != config::FeedMode::kPerMinute) return;
  lines(table_.per_minute_on);
  if (format_.feed_measure == config::FeedMeasure::kDegrees) lines(table_.degrees);
  if (format_.feed_measure == config::FeedMeasure::kRadius) lines(table_.radius);
}

std::string Writer::first_words() const {
  const std::string words = filled_line(format_.tcp ? table_.tcp_length : table_.length, filling_);
  return words.empty() ? "" : " " + words;
}

Joints Writer::first_place_of(const Operation& op) const {
  const Joints& words = op.words->moves.front().joints;
  if (op.plane) return place_above(posting_.machine, op.setup, from_plane(*op.plane, words));
  return first_place(posting_.machine, op.setup, words);
}

void Writer::go_to(const PrintedWords& words, WordsOf say, const Joints& to) {
  std::array<char, 3 * kDecimalSpace> room;
  char* const end = (words.*say)(room.data(), to);
  line(std::string(table_.rapid) + std::string(room.data(), end) + table_.first_end + table_.rapid_end);
}

/// To the first place by the operation's own way; false: it has none.
bool Writer::swing(const Operation& op, const PrintedWords& words, const Joints& first) {
  if (&op == posting_.operations.data() || op.way == SwingWay{}) return false;
  const Joints& before = (&op - 1)->words->moves.back().joints;
  if (before.a == first.a && before.c == first.c) return false;
  // X and Y before may be of another kind of words: they are stated whatever they were.
  Joints at{first.x - 1.0, first.y, first.z, before.a, before.c};
  for (const Joints& to : swing_places(posting_.machine.model, at, first, op.way)) {
    go_to(words, to.x != at.x ? &PrintedWords::place : &PrintedWords::rotaries, to);
    at = to;
  }
  return true;
}

/// From the retract the rotaries turn, then X and Y go to their place; the operation's first block goes down.
/// TCP begins there: before, the tip's way is not a line. Or it begins high up, and the table turns under it.
void Writer::positions(const Operation& op) {
  const MachineModel& machine = posting_.machine.model;
  const PrintedWords words(format_, machine);
  const auto go = [&](WordsOf say, const Joints& to) { go_to(words, say, to); };
  const Joints first = first_place_of(op);
  const std::vector<Joints> start = tcp_start(posting_.machine, op.setup, first);
  const bool swings = swing(op, words, first);
  if (!swings && (machine.tilt.present || machine.rotary.present))
    go(&PrintedWords::rotaries, start.empty() ? first : start.front());
  // Not before: the shorter way from an unknown place may leave the limits of an axis that has some.
  shorter_ = machine.tilt.word == RotaryWord::kShortest || machine.rotary.word == RotaryWord::kShortest;
  if (shorter_) lines(table_.shorter_on);
  if (!swings) go(&PrintedWords::place, first);
  if (format_.tcp) lines(table_.tcp_on);
  if (op.plane) {
    Filling filling = filling_;
    filling.insert(filling.end(), op.plane->words.begin(), op.plane->words.end());
    for (const std::string& text : filled(table_.plane_on, filling)) line(text);
  }
  Joints from{};
  for (const Joints& to : start) {
    std::array<char, 5 * kDecimalSpace> room;
    char* const end = words.axes(room.data(), from, to, true);
    line(table_.rapid + std::exchange(layout_.spans.back().first_words, {}) + std::string(room.data(), end));
    from = to;
  }
}

/// Of all operations, those in which the table turns to its place under TCP among them.
std::size_t Writer::blocks() const {
  std::size_t count = layout_.blocks;
  for (const Operation& op : posting_.operations)
    count += tcp_start(posting_.machine, op.setup, first_place_of(op)).size();
  return count;
}

void Writer::event(const PathEvent& event) {
  Filling filling = filling_;
  const auto put = [&](const char* words) {
    for (const std::string& text : filled(words, filling)) line(text);
  };
  switch (event.kind) {
    case EventKind::kRemark:
      return remark(event.text);
    case EventKind::kSpindle:
      spindle_ = event.value;
      filling.emplace_back("rpm", decimal(std::abs(event.value), 3));
      filling.emplace_back("turn", event.value < 0.0 ? "4" : "3");
      return put(event.value == 0.0 ? table_.spindle_off : table_.spindle);
    case EventKind::kCoolant:
      return coolant(event.value);
    case EventKind::kDwell:
      filling.emplace_back("seconds", decimal(event.value, 3));
      filling.emplace_back("milliseconds", decimal(event.value * 1000.0, 0));
      return put(table_.dwell);
    case EventKind::kStop:
      return put(table_.stop);
    case EventKind::kOptionalStop:
      return put(table_.optional_stop);
    case EventKind::kCutterLeft:
    case EventKind::kCutterRight:
      compensated_ = true;
      filling.emplace_back("cutter", event.value > 0.0 ? decimal(event.value, 0) : filling_.back().second);
      return cutter_side(event.kind == EventKind::kCutterLeft ? table_.cutter_left : table_.cutter_right,
                         filling);
    case EventKind::kCutterOff:
      compensated_ = false;
      return cutter_side(table_.cutter_off, filling);
    case EventKind::kPlane:
      plane_ = event.value;
      return line("G" + decimal(event.value, 0));
  }
}

/// As PathEvent::value.
void Writer::coolant(double kind) {
  constexpr double kThrough = 3.0;
  const bool was_through = std::exchange(coolant_, kind) == kThrough;
  if (was_through && kind != kThrough) line(format_.through_off);
  if (kind == kThrough) return line(format_.through_on);
  lines(kind == 0.0 ? table_.coolant_off : (kind == 1.0 ? table_.flood : table_.mist));
}

/// A line now, or a word of the next block that moves X or Y: only there such a control takes it.
void Writer::cutter_side(const char* words, const Filling& filling) {
  if (table_.sides != Sides::kLine) {
    side_ = words;
    return;
  }
  for (const std::string& text : filled(words, filling)) line(text);
}

/// Clamps close before a cut in which their axis stands still, and open before a block that turns it.
void Writer::clamp(const Operation& op, std::size_t index) {
  const std::vector<JointMove>& moves = op.words->moves;
  if (index == 0) return;
  const Joints &from = moves[index - 1].joints, &to = moves[index].joints;
  if (tilt_clamped_ && to.a != from.a) line(format_.unclamp_tilt), tilt_clamped_ = false;
  if (rotary_clamped_ && to.c != from.c) line(format_.unclamp_rotary), rotary_clamped_ = false;
  const bool begins = moves[index].kind != MoveKind::kRapid && moves[index - 1].kind == MoveKind::kRapid;
  if (!begins) return;
  bool tilt_still = true, rotary_still = true;
  for (std::size_t i = index; i < moves.size() && moves[i].kind != MoveKind::kRapid; ++i) {
    tilt_still = tilt_still && moves[i].joints.a == from.a;
    rotary_still = rotary_still && moves[i].joints.c == from.c;
  }
  if (!format_.clamp_tilt.empty() && tilt_still && !tilt_clamped_)
    line(format_.clamp_tilt), tilt_clamped_ = true;
  if (!format_.clamp_rotary.empty() && rotary_still && !rotary_clamped_)
    line(format_.clamp_rotary), rotary_clamped_ = true;
}

void Writer::usual_plane() {
  if (plane_ != kUsualPlane) line("G" + decimal(kUsualPlane, 0));
  plane_ = kUsualPlane;
}

/// The plane stays in force until another arc or the tool's retract: straight blocks do not ask for it.
void Writer::before_arc(const PrintedArc& arc, const Joints& from) {
  if (table_.arc_planes && plane_ != arc.plane) line("G" + decimal(arc.plane, 0));
  if (table_.arc_planes) plane_ = arc.plane;
  if (*table_.pole_letters == '\0') return;
  std::array<char, 2 * kDecimalSpace> room;
  line(table_.pole +
       std::string(room.data(), PrintedWords(format_, posting_.machine.model).pole(room.data(), from, arc)));
}

void Writer::motion(const Operation& op) {
  const std::vector<JointMove>& moves = op.words->moves;
  const bool inverse = !format_.tcp && format_.feed_mode == config::FeedMode::kInverseTime;
  const bool clamps = !format_.clamp_tilt.empty() || !format_.clamp_rotary.empty();
  const bool blends = format_.path_control == config::PathControl::kBlend;
  const std::vector<bool> blended = blends ? blends_corners(moves) : std::vector<bool>(moves.size(), false);
  const std::size_t first = at_;
  auto next = op.events.begin();
  fed_ = false;
  side_ = nullptr;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    at_ = first + i;
    for (; next != op.events.end() && next->move <= moves[i].move; ++next) event(*next);
    if (i == 0) positions(op);
    if (blended[i] && !blended[i - 1]) lines(table_.blend);
    if (i > 0 && !blended[i] && blended[i - 1]) lines(table_.exact);
    if (clamps) clamp(op, i);
    const auto moves_in_plane = [&] {
      const Joints &from = moves[i - 1].joints, &to = moves[i].joints;
      return to.x != from.x || to.y != from.y;
    };
    if (side_ != nullptr && i > 0 && moves_in_plane())
      layout_.spans.back().sides.emplace_back(i, std::exchange(side_, nullptr));
    if (inverse && !fed_ && moves[i].kind != MoveKind::kRapid) lines(table_.inverse_on), fed_ = true;
    if (const PrintedArc* const arc = op.arc(i)) before_arc(*arc, moves[i - 1].joints);
  }
  at_ = first + moves.size();
  for (; next != op.events.end(); ++next) event(*next);
}

/// After an operation: what must not be in force while the tool is changed, or at the end.
void Writer::leave() {
  // Such a control's retract ends it.
  if (compensated_ && table_.sides == Sides::kLine) lines(table_.cutter_off);
  usual_plane();
  if (fed_) lines(table_.per_minute_on);
  fed_ = compensated_ = false;
  if (format_.tcp) lines(table_.tcp_off);
  if (shorter_) lines(table_.shorter_off);
  shorter_ = false;
  if (coolant_ != 0.0) coolant(0.0);
  if (spindle_ != 0.0) lines(table_.spindle_off);
  coolant_ = spindle_ = 0.0;
}

void Writer::finish() {
  leave();
  retract();
  if (posting_.operations.back().plane) lines(table_.plane_done);
  if (smooth_) lines(table_.smooth_off);
  for (const std::string& own : format_.end) line(own);
  lines(table_.end);
  if (format_.percent) line("%");
}

Layout Writer::write() {
  for (const Operation& op : posting_.operations) layout_.blocks += op.words->moves.size();
  header();
  for (const Operation& op : posting_.operations) {
    begin(op, layout_.spans.empty());
    layout_.spans.push_back({at_, at_ + op.words->moves.size(), first_words()});
    motion(op);
  }
  finish();
  return std::move(layout_);
}

}  // namespace

Layout lay_out(const Posting& posting) { return Writer(posting).write(); }

}  // namespace tiltfeed::daemon
