#include "kinematics/cl_text/apt_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <istream>
#include <utility>

#include "kinematics/basics/decimal.h"
#include "kinematics/cl_text/apt_reader.h"
#include "kinematics/cl_text/apt_vocabulary.h"

namespace tiltfeed {
namespace {

// Places nearer than this are one: files print six decimals of their unit.
constexpr double kSamePlace = 2e-6;
// Of a point on a circle that a file states, mm.
constexpr double kOnCircle = 0.01;
// A direction with four decimals or more is unit to this.
constexpr double kUnitAxis = 0.01;

bool is_motion(const AptRecord& record) {
  return record.word == "GOTO" || record.word == "GODLTA" || record.word == "GOHOME" ||
         record.word == "CIRCLE";
}

/// Whole numbers without a point: "1,5,2" may be 1.5 and 2.
bool all_whole(const AptRecord& record) {
  return std::all_of(record.words.begin(), record.words.end(),
                     [](const std::string& one) { return one.find_first_of(".ED") == std::string::npos; });
}

constexpr const char* kElsewhere =
    "FROM/ states another place than the last point, so that this motion begins at a place that is not "
    "known; "
    "state a GOTO/ before it";
constexpr const char* kComma = " (is a comma used as decimal point?)";

}  // namespace

AptReader::AptReader(std::string name, const AptOptions& options)
    : name_(std::move(name)),
      options_(options),
      unit_(options.unit_mm > 0.0 ? options.unit_mm : 1.0),
      known_(options.unit_mm > 0.0),
      length_(options.tool_length),
      feed_(options.feed) {
  program_.operations.emplace_back();
  program_.operations.back().path.tool.length = length_;
}

tl::unexpected<Error> AptReader::wrong(AptPlace place, const std::string& what) const {
  const std::string column = place.column > 0 ? ":" + std::to_string(place.column) : "";
  return fail(Code::kInput, name_ + ":" + std::to_string(place.line) + column + ": " + what);
}

AptVerdict AptReader::feed_in_force(double& rate) const {
  if (!(feed_ > 0.0))
    return mistake(
        "no FEDRAT/ yet for this feed move; state one before it, or RAPID, or say --feed MM_PER_MIN");
  rate = per_turn_ ? feed_ * rpm_ : feed_;
  if (!(rate > 0.0)) return mistake("the feed per turn needs a spindle speed; state SPINDL/ before it");
  return std::nullopt;
}

/// One move of the tool; `feed` is that of a feed move, mm/min.
AptVerdict AptReader::put(Point<Part> tip, bool rapid, double feed, std::uint32_t line) {
  at_ = tip;
  low_ = elsewhere_ = false;
  ToolPath& path = operation().path;
  if (!rapid) {
    const Feed now = Feed::from_mm_per_min(feed);
    if (path.feeds.empty()) path.cut_feed = path.plunge_feed = now;
    if (path.feeds.empty() || path.feeds.back().feed != now)
      path.feeds.push_back({static_cast<std::uint32_t>(path.moves.size()), now});
  }
  path.moves.push_back({{tip, axis_P()}, rapid ? MoveKind::kRapid : MoveKind::kCut, kNoFacet});
  operation().lines.push_back(line);
  moved_ = true;
  closed_ = false;
  return std::nullopt;
}

/// To the place that the file states: straight, along an arc, or to drill there.
AptVerdict AptReader::reach(Point<Part> tip, std::uint32_t line) {
  if (cycling_) return hole(tip, line);
  if (arc_ && arc_->points > 0 &&
      !(arc_->goes_on && lies_on(*arc_, frame_.turn * (arc_->centre * unit_) + frame_.origin,
                                 frame_.turn * arc_->axis, tip, kOnCircle)))
    arc_.reset();
  if (arc_) return along_arc(tip, line);
  const bool rapid = std::exchange(rapid_, false) || operation().path.moves.empty();
  double rate = 0.0;
  if (!rapid)
    if (auto bad = feed_in_force(rate)) return bad;
  return put(tip, rapid, rate, line);
}

AptVerdict AptReader::along_arc(Point<Part> tip, std::uint32_t line) {
  if (elsewhere_) return mistake(kElsewhere);
  const std::vector<Move>& moves = operation().path.moves;
  if (rapid_ || moves.empty())
    return mistake("an arc in rapid; state FEDRAT/ and a start point before CIRCLE/");
  if (length(moves.back().pose.axis - axis_P()) > kUnitAxis)
    return mistake("the tool axis turns along the arc; let the CAM system write straight moves");
  double rate = 0.0;
  if (auto bad = feed_in_force(rate)) return bad;
  std::vector<Point<Part>> corners;
  const Vec3 centre = frame_.turn * (arc_->centre * unit_) + frame_.origin;
  if (auto bad = chords(*arc_, centre, frame_.turn * arc_->axis, at_, tip, options_.chord_error,
                        kSamePlace * unit_, corners))
    return bad;
  program_.chord_error = options_.chord_error;
  for (const Point<Part>& corner : corners) put(corner, false, rate, line);
  if (!arc_->goes_on) arc_.reset();
  return std::nullopt;
}

/// Above the point, never lower than the tool comes from; then the cycle's steps.
AptVerdict AptReader::hole(Point<Part> tip, std::uint32_t line) {
  if (rapid_) return mistake("RAPID while a CYCLE/ is on; end it with CYCLE/OFF");
  if (elsewhere_) return mistake(kElsewhere);
  const Vec3 up = axis_P();
  if (low_ && length(operation().path.moves.back().pose.axis - up) > kUnitAxis)
    return mistake(
        "the tool axis turns between two holes, and the tool is no higher than CLEAR above the last one; "
        "state where it may turn: RTRCTO in CYCLE/, or CYCLE/OFF and points between");
  double rate = 0.0;
  bool per_turn = false;
  if (!cycle_.feed_unit.empty()) {
    if (auto bad = this->rate(cycle_.feed_unit, cycle_.feed, rate, per_turn)) return bad;
    if (per_turn && !((rate *= rpm_) > 0.0))
      return mistake("the feed per turn needs a spindle speed; state SPINDL/ before it");
  } else if (auto bad = feed_in_force(rate)) {
    return bad;
  }
  if ((cycle_.kind == CycleKind::kTap || cycle_.dwell_turns) && !(rpm_ > 0.0))
    return mistake("the cycle needs a spindle speed; state SPINDL/ before it");
  const double top = *cycle_.rapid_to * unit_;
  double retract = std::max(top, cycle_.retract.value_or(0.0) * unit_);
  if (cycle_.to_start) retract = std::max(top, dot(cycle_start_ - tip, up));
  const std::vector<Move>& moves = operation().path.moves;
  double level = retract;
  if (!moves.empty() && length(moves.back().pose.axis - up) < kUnitAxis) {
    const double height = dot(at_ - tip, up);
    level = std::max(height, retract);
    if (level - height > kSamePlace) put(at_ + up * (level - height), true, 0.0, line);
  }
  for (const double height : {level, top})
    if (moves.empty() || distance(at_, tip + up * height) > kSamePlace)
      put(tip + up * height, true, 0.0, line);
  for (const CycleStep& step : steps_of(cycle_, retract / unit_, unit_)) {
    if (distance(at_, tip + up * (step.height * unit_)) > kSamePlace)
      put(tip + up * (step.height * unit_), step.rapid, rate, line);
    if (step.then == CycleThen::kDwell)
      event(EventKind::kDwell, cycle_.dwell_turns ? cycle_.dwell / rpm_ * 60.0 : cycle_.dwell);
    if (step.then == CycleThen::kReverse) event(EventKind::kSpindle, -rpm_ * turn_);
    if (step.then == CycleThen::kForward) event(EventKind::kSpindle, rpm_ * turn_);
  }
  low_ = !cycle_.retract && !cycle_.to_start;
  return std::nullopt;
}

/// The place that a record states; its direction becomes the tool axis.
AptVerdict AptReader::place_of(const AptRecord& record, Point<Part>& tip) {
  std::array<double, 9> v{};
  std::size_t count = 0;
  if (auto bad = record.numbers(v, count)) return bad;
  if (count != 3 && count != 6 && count != 9)
    return mistake(record.word + "/ has " + std::to_string(count) +
                   " numbers; expected x,y,z or x,y,z,i,j,k" + (count > 3 ? kComma : ""));
  if (count > 3) {
    const bool unit = std::abs(length({v[3], v[4], v[5]}) - 1.0) < kUnitAxis;
    if (!unit && (count == 9 || all_whole(record)) && length({v[3], v[4], v[5]}) > 0.0)
      return mistake("the tool axis (" + record.words[3] + ", " + record.words[4] + ", " + record.words[5] +
                         ") is not of length 1" + kComma,
                     record.places[3]);
    if (one_axis_)
      return mistake("a direction after MULTAX/OFF; state MULTAX/ON, or leave it out", record.places[3]);
    if (auto bad = set_axis(v[3], v[4], v[5])) return mistake(bad->what, record.places[3]);
  }
  if (count == 9) note(record, "GOTO/ with 9 numbers: the last three are not used");
  const Vec3 at = frame_.turn * (Vec3{v[0], v[1], v[2]} * unit_) + frame_.origin;
  tip = {at.x, at.y, at.z};
  return std::nullopt;
}

AptVerdict AptReader::go(const AptRecord& record) {
  Point<Part> tip;
  if (auto bad = place_of(record, tip)) return bad;
  if (record.word != "FROM") return reach(tip, record.place.line);
  elsewhere_ = !operation().path.moves.empty() && distance(at_, tip) > kOnCircle;
  if (!elsewhere_) at_ = tip;  // where the tool is
  return std::nullopt;
}

AptVerdict AptReader::go_by(const AptRecord& record) {
  std::array<double, 3> v{};
  std::size_t count = 0;
  if (auto bad = record.numbers(v, count)) return bad;
  if (elsewhere_) return mistake(kElsewhere);
  if (cycling_) return mistake("GODLTA/ while a CYCLE/ is on; end it with CYCLE/OFF");
  if (count == 1) return reach(at_ + axis_P() * (v[0] * unit_), record.place.line);
  if (count != 3) return mistake("GODLTA/ wants dx,dy,dz, or a distance along the tool axis");
  return reach(at_ + frame_.turn * (Vec3{v[0], v[1], v[2]} * unit_), record.place.line);
}

/// Words that say how the file goes on.
bool AptReader::flows(const AptRecord& r) {
  if (r.word == "RAPID") {
    rapid_ = true;
  } else if (r.word == "STOP") {
    event(EventKind::kStop, 0.0);
  } else if (r.word == "OPSTOP") {
    event(EventKind::kOptionalStop, 0.0);
  } else if (r.word == "PPRINT") {
    if (options_.own_remarks || !r.text.starts_with("TILTFEED")) event(EventKind::kRemark, 0.0, r.text);
  } else if (r.word == "PARTNO") {
    program_.name = r.text;
  } else if (r.word == "FINI" || r.word == "END") {
    ended_ = true;
  } else if (r.word == "END-OF-PATH") {
    closed_ = true;  // another may follow
  } else {
    return false;
  }
  return true;
}

AptVerdict AptReader::leave_out(const AptRecord& r) {
  if (only_informs(r)) return std::nullopt;
  if (auto bad = must_not_be_dropped(r)) return bad;
  note(r, r.word + " is not understood and was left out");
  return std::nullopt;
}

AptVerdict AptReader::dispatch(const AptRecord& r) {
  const auto ignored = std::find(options_.ignored.begin(), options_.ignored.end(), r.word);
  if (ignored != options_.ignored.end() && !is_motion_word(r.word)) {
    note(r, r.word + " was left out, as asked");
    return std::nullopt;
  }
  if (arc_ && arc_->points == 0 && r.word != "GOTO" && r.word != "FEDRAT" && r.word != "PPRINT")
    return mistake("CIRCLE/ without GOTO/ behind it");
  if (r.word == "GOTO" || r.word == "FROM" || r.word == "GOHOME") return go(r);
  if (r.word == "GODLTA") return go_by(r);
  if (arc_ && arc_->points > 0) arc_.reset();
  AptVerdict verdict;
  if (settings(r, verdict)) return verdict;
  return flows(r) ? std::nullopt : leave_out(r);
}

Result<void> AptReader::read(const AptRecord& record) {
  if (const auto bad = dispatch(record))
    return wrong(bad->place.line > 0 ? bad->place : record.place, bad->what);
  return {};
}

Result<AptProgram> AptReader::finish(std::uint32_t line) {
  if (!ended_ && !closed_)
    return wrong({line, 0}, "the file ends without FINI, END or END-OF-PATH: it is cut short");
  if (operation().path.moves.empty() && program_.operations.size() > 1) program_.operations.pop_back();
  if (operation().path.moves.empty()) return wrong({line, 0}, "no GOTO/ before the end");
  if (!known_)
    program_.notes.push_back(name_ + ": no UNITS/: its numbers are taken as mm (else: --units inch)");
  notes_.append_to(program_.notes, name_);
  for (AptOperation& op : program_.operations) op.path.name = program_.name;
  return std::move(program_);
}

Result<AptProgram> read_apt(std::istream& in, const std::string& name, const AptOptions& options) {
  AptReader reader(name, options);
  AptRecords records(in);
  std::vector<AptRecord> head;
  for (AptRecord record; records.next(record);) {
    head.push_back(record);
    if (is_motion(record) || record.word == "FINI" || record.word == "END") break;
  }
  if (auto unit = reader.take_unit(head); !unit) return tl::unexpected(unit.error());
  for (const AptRecord& one : head)
    if (auto read = reader.read(one); !read) return tl::unexpected(read.error());
  AptRecord record;
  while (!reader.ended()) {
    if (!records.next(record)) break;
    if (auto read = reader.read(record); !read) return tl::unexpected(read.error());
  }
  const std::uint32_t end = records.line();
  while (reader.ended() && records.next(record))
    if (is_motion(record))
      return fail(Code::kInput, name + ":" + std::to_string(record.place.line) + ":" +
                                    std::to_string(record.place.column) + ": " + record.word +
                                    "/ stands behind the file's end (FINI or END) in line " +
                                    std::to_string(end) + "; post what follows as a file of its own");
  if (in.bad()) return fail(Code::kIo, name + ": cannot be read");
  return reader.finish(end);
}

}  // namespace tiltfeed
