#include "daemon/post/unpost.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "config/table_home.h"
#include "daemon/post/cutter_side.h"
#include "daemon/post/nc_arcs.h"
#include "daemon/post/nc_rules.h"
#include "daemon/post/tcp_start.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/machine/spindle_frame.h"
#include "kinematics/timing/tcp_path.h"

namespace tiltfeed::daemon {
namespace {

// A block is halved at most this often.
constexpr int kMaxHalvings = 20;
// Places inside a block where its way is compared with the straight line.
constexpr std::array<double, 3> kSamples{0.25, 0.5, 0.75};
// Places that are further apart than this, degrees, miss a turn of an axis between them.
constexpr double kSampledTurn = 120.0;
// A feed is stated anew where it differs by more than this share: words are rounded, so that block times are.
constexpr double kSameFeed = 2e-3;
// A start of TCP in which the table turns has so many blocks at least.
constexpr std::size_t kLeastStart = 2;
// A tip's way shorter than this says nothing of a feed, mm.
constexpr double kNoWay = 1e-6;

Joints on_line(const Joints& p, const Joints& q, double f) {
  return {p.x + f * (q.x - p.x), p.y + f * (q.y - p.y), p.z + f * (q.z - p.z), p.a + f * (q.a - p.a),
          p.c + f * (q.c - p.c)};
}

class Unposter {
 public:
  Unposter(const TextOperation& text, const NcProgram& program, const config::MachineProfile& machine,
           const Setup& setup, const UnpostOptions& options)
      : text_(text),
        planes_(program.planes),
        arcs_(program.arcs),
        machine_(machine),
        setup_(setup),
        options_(options) {}

  /// Errors: a word beyond its axis's travel; more points than kMostTextPoints.
  Result<AptOperation> run(std::size_t points);

 private:
  /// The words at a share of the way to `to`.
  Joints between(const TextBlock& from, const TextBlock& to, double share) const {
    if (to.arc != 0) return along_arc(arcs_[to.arc - 1], from.words, to.words, share);
    return on_line(from.words, to.words, share);
  }
  /// Of words that are said as those of `block`.
  Pose pose(const Joints& words, const TextBlock& block) const {
    return commanded_pose(machine_.model, setup_, planes_, block, words);
  }
  std::optional<std::string> beyond(const TextBlock& block) const;
  bool turns_before(std::size_t path) const;
  std::size_t behind_start() const;
  tl::unexpected<Error> too_many(std::uint32_t line) const;
  void cut(const TextBlock& from, const TextBlock& to, double f0, const Pose& p0, double f1, const Pose& p1,
           int halvings);
  void put(const Pose& pose, const TextBlock& block);
  /// An event before `block`, a shift to a side as the tool's own; false where its plane is not the tool's.
  bool put(PathEvent event, const TextBlock& block);
  double tip_feed(const TextBlock& from, const TextBlock& to, double way) const;

  const TextOperation& text_;
  const std::vector<TextPlane>& planes_;
  const std::vector<TextArc>& arcs_;
  const config::MachineProfile& machine_;
  const Setup& setup_;
  const UnpostOptions& options_;
  std::size_t most_ = 0;  ///< points
  int plane_ = 17;
  AptOperation out_;
};

void Unposter::put(const Pose& pose, const TextBlock& block) {
  out_.path.moves.push_back({pose, block.rapid ? MoveKind::kRapid : MoveKind::kCut, kNoFacet});
  out_.lines.push_back(block.line);
}

bool Unposter::put(PathEvent event, const TextBlock& block) {
  if (event.kind == EventKind::kPlane) {
    plane_ = static_cast<int>(event.value);
    return true;
  }
  const bool left = event.kind == EventKind::kCutterLeft;
  if (left || event.kind == EventKind::kCutterRight) {
    // In its plane the tool is along Z.
    const auto plane =
        block.plane != 0 ? ShiftPlane{17, false} : shift_plane(machine_.model, setup_, block.words);
    if (!plane || plane->code != plane_) return false;
    if (plane->backward) event.kind = left ? EventKind::kCutterRight : EventKind::kCutterLeft;
  }
  event.move = out_.path.moves.size();
  out_.events.push_back(std::move(event));
  return true;
}

/// Points from f0 (already there) to f1 of a block.
void Unposter::cut(const TextBlock& from, const TextBlock& to, double f0, const Pose& p0, double f1,
                   const Pose& p1, int halvings) {
  if (out_.path.moves.size() > most_) return;
  double tip = 0.0, axis = 0.0;
  for (const double s : kSamples) {
    const Pose real = pose(between(from, to, f0 + s * (f1 - f0)), to);
    tip = std::max(tip, distance_to_segment(real.tip, p0.tip, p1.tip));
    axis = std::max(axis, angle_between(real.axis, slerp(p0.axis, p1.axis, s)));
  }
  const double turned =
      (f1 - f0) * std::max(std::abs(to.words.a - from.words.a), std::abs(to.words.c - from.words.c));
  const bool fits = turned <= kSampledTurn && tip <= options_.tolerance &&
                    axis <= Angle::from_degrees(options_.axis_tolerance).radians();
  if (fits || halvings >= kMaxHalvings) return put(p1, to);
  const double middle = 0.5 * (f0 + f1);
  const Pose at = pose(between(from, to, middle), to);
  cut(from, to, f0, p0, middle, at, halvings + 1);
  cut(from, to, middle, at, f1, p1, halvings + 1);
}

/// Of a block whose tip travels `way`, mm/min; 0: it says nothing of one.
double Unposter::tip_feed(const TextBlock& from, const TextBlock& to, double way) const {
  if (way < kNoWay) return 0.0;
  if (to.inverse_time) return way * to.feed;
  const Joints &p = from.words, &q = to.words;
  const double linear = to.arc != 0 ? arc_length(arcs_[to.arc - 1], p, q)
                                    : std::hypot(q.x - p.x, q.y - p.y, q.z - p.z),
               turned = std::hypot(q.a - p.a, q.c - p.c);
  if (to.tcp || to.plane != 0) return linear > 0.0 ? to.feed : 0.0;
  const config::ProgramFormat& format = machine_.format;
  double measured = linear > 0.0 ? linear : turned;
  if (format.feed_measure == config::FeedMeasure::kDegrees) measured = std::hypot(linear, turned);
  if (format.feed_measure == config::FeedMeasure::kRadius)
    measured = std::hypot(linear, Angle::from_degrees(turned).radians() * format.feed_radius);
  return measured > 0.0 ? to.feed * way / measured : 0.0;
}

/// The travel that a block breaks, if any: under TCP that of the words which the control makes of the tip.
std::optional<std::string> Unposter::beyond(const TextBlock& block) const {
  if (!block.tcp && block.plane == 0) return broken_limit(machine_.model, block.words);
  const Pose at = pose(block.words, block);
  return broken_limit(machine_.model,
                      solve_linear(machine_.model, setup_, at.tip, block.words.a, block.words.c));
}

tl::unexpected<Error> Unposter::too_many(std::uint32_t line) const {
  return fail(Code::kLimit, "line " + std::to_string(line) + ": the tool path has more than " +
                                std::to_string(kMostTextPoints) +
                                " points; divide the program, or allow a coarser tolerance");
}

/// Whether the table turns from home to its place in the blocks before `path`, as tcp_start() has them: in
/// equal steps, the slides standing, and `path` goes down with the rotaries as they are.
bool Unposter::turns_before(std::size_t path) const {
  const std::vector<TextBlock>& blocks = text_.blocks;
  const auto digit = [](int decimals) { return 1.0 / decimal_scale(decimals); };
  const double step = digit(machine_.format.rotary_decimals);
  const auto nearly = [&](double word, double wanted) { return std::abs(word - wanted) <= 1.01 * step; };
  const Joints &home = blocks.front().words, &place = blocks[path].words;
  double turn = 0.0;
  for (const config::TableTurn& one : config::table_turns(machine_.model)) {
    const double word = home.*one.word;
    if (!nearly(std::remainder(word - one.axis->zero, 360.0), 0.0)) return false;
    turn += std::abs(place.*one.word - word);
  }
  const auto last = static_cast<double>(path - 1);
  if (turn > last * kStartStep + step || turn <= (last - 1.0) * kStartStep - step) return false;
  // Words are rounded: those of the tip, and the rotaries' at the end of its lever.
  const Vec3 at = from_origin(pose(home, blocks.front()).tip) + setup_.part_zero;
  const double lever = length(at) + length(machine_.model.rotary_to_tilt);
  const double stands = 2.0 * (digit(machine_.format.linear_decimals) * config::unit_of(machine_.format) +
                               Angle::from_degrees(step).radians() * lever);
  const Joints start = axes_under_tcp(machine_.model, setup_, home);
  for (std::size_t i = 1; i <= path; ++i) {
    const double share = std::min(static_cast<double>(i) / last, 1.0);
    const Joints axes = axes_under_tcp(machine_.model, setup_, blocks[i].words);
    for (double Joints::*word : {&Joints::a, &Joints::c})
      if (!nearly(axes.*word, home.*word + share * (place.*word - home.*word))) return false;
    const double down = i < path ? std::abs(axes.z - start.z) : std::max(axes.z - start.z, 0.0);
    if (std::hypot(axes.x - start.x, axes.y - start.y) > stands || down > stands) return false;
  }
  return blocks[path - 1].words.a == place.a && blocks[path - 1].words.c == place.c;
}

/// The first block of the path itself. Before it TCP may begin with the table at home: the table turns to its
/// place in rapids while the slides stand, and `post` puts that in anew.
std::size_t Unposter::behind_start() const {
  if (!config::begins_at_home(machine_.format.dialect)) return 0;
  for (std::size_t i = 0; i < text_.blocks.size() && text_.blocks[i].tcp && text_.blocks[i].rapid; ++i)
    if (i >= kLeastStart && turns_before(i)) return i;
  return 0;
}

Result<AptOperation> Unposter::run(std::size_t points) {
  most_ = points;
  ToolPath& path = out_.path;
  out_.tool_number = text_.tool_number;
  out_.length_register = text_.length_register;
  path.tool = {text_.diameter.value_or(0.0), 0.0, setup_.tool_length};
  auto event = text_.events.begin();
  const std::size_t begin = behind_start();
  for (std::size_t i = 0; i < text_.blocks.size(); ++i) {
    const TextBlock& block = text_.blocks[i];
    for (; event != text_.events.end() && event->move <= i; ++event)
      if (!put(*event, block))
        return fail(Code::kInput,
                    "line " + std::to_string(block.line) +
                        ": the tool is not square to the plane in which the control is to shift it");
    if (const auto broken = beyond(block))
      return fail(Code::kInput, "line " + std::to_string(block.line) + ": " + *broken);
    if (path.moves.size() > most_) return too_many(block.line);
    if (i < begin) continue;
    const Pose end = pose(block.words, block);
    if (i == begin || block.tcp != text_.blocks[i - 1].tcp || block.plane != text_.blocks[i - 1].plane) {
      put(end, block);
      continue;
    }
    const TextBlock& before = text_.blocks[i - 1];
    const std::size_t first = path.moves.size();
    Pose at = pose(before.words, before);
    cut(before, block, 0.0, at, 1.0, end, 0);
    if (block.rapid) continue;
    double way = 0.0;
    for (std::size_t k = first; k < path.moves.size(); at = path.moves[k++].pose)
      way += distance(at.tip, path.moves[k].pose.tip);
    const double feed = tip_feed(before, block, way);
    const double now = path.feeds.empty() ? 0.0 : path.feeds.back().feed.mm_per_min();
    if (feed > 0.0 && std::abs(feed - now) > kSameFeed * now)
      path.feeds.push_back({static_cast<std::uint32_t>(first), Feed::from_mm_per_min(feed)});
    // A turn in place before any feed is known: that of axis words alone.
    if (path.feeds.empty())
      path.feeds.push_back({static_cast<std::uint32_t>(first), Feed::from_mm_per_min(1.0)});
  }
  if (path.moves.size() > most_) return too_many(text_.blocks.back().line);
  for (; event != text_.events.end(); ++event) put(*event, text_.blocks.back());
  if (!path.feeds.empty()) path.cut_feed = path.plunge_feed = path.feeds.front().feed;
  return std::move(out_);
}

}  // namespace

Pose commanded_pose(const MachineModel& machine, const Setup& setup, const std::vector<TextPlane>& planes,
                    const TextBlock& block, const Joints& words) {
  if (block.plane != 0) {
    const TextPlane& plane = planes[block.plane - 1];
    const Rotation frame = plane.frame ? *plane.frame : spindle_frame(machine, words.a, words.c);
    const Vec3 tip = plane.origin + frame * Vec3{words.x, words.y, words.z};
    return pose_under_tcp(machine, setup, {tip.x, tip.y, tip.z, words.a, words.c});
  }
  return block.tcp ? pose_under_tcp(machine, setup, words) : forward(machine, setup, words);
}

Rotation fixture_of(Vec3 degrees) {
  const auto turn = [](Vec3 axis, double angle) {
    const double quarters = std::round(angle / 90.0);
    Rotation r = rotation_about(axis, Angle::from_degrees(angle).radians());
    if (angle != quarters * 90.0) return r;
    for (Vec3& row : r.rows) row = {std::round(row.x), std::round(row.y), std::round(row.z)};
    return r;
  };
  return turn({0, 0, 1}, degrees.z) * turn({0, 1, 0}, degrees.y) * turn({1, 0, 0}, degrees.x);
}

Result<AptProgram> unpost(const NcProgram& program, const config::MachineProfile& machine,
                          const UnpostOptions& options) {
  AptProgram out;
  std::size_t points = 0;
  out.name = program.name;
  out.notes = program.notes;
  std::optional<Vec3> zero = options.part_zero, turned = options.fixture_deg;
  std::optional<double> length = options.tool_length;
  for (const TextOperation& op : program.operations) {
    if (op.part_zero && !options.part_zero) zero = op.part_zero;
    if (op.fixture_deg && !options.fixture_deg) turned = op.fixture_deg;
    if (op.tool_length && !options.tool_length) length = op.tool_length;
    if (!zero)
      return fail(Code::kInput,
                  "the program does not state where the part's zero is; state it: --part-zero X,Y,Z");
    if (!length)
      return fail(Code::kInput, "the program does not state the tool's length; state it: --tool-length L");
    const Setup setup{*zero, fixture_of(turned.value_or(Vec3{})), *length};
    auto made = Unposter(op, program, machine, setup, options)
                    .run(kMostTextPoints - std::min(points, kMostTextPoints));
    if (!made) return tl::unexpected(made.error());
    points += made->path.moves.size();
    out.operations.push_back(std::move(*made));
    out.operations.back().path.name = program.name;
  }
  return out;
}

}  // namespace tiltfeed::daemon
