#include "kinematics/apt_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <istream>
#include <optional>
#include <string_view>

#include "kinematics/apt_notes.h"
#include "kinematics/apt_record.h"
#include "kinematics/decimal.h"

namespace tiltfeed {
namespace {

constexpr double kInch = 25.4;  // mm, exactly
// A tool axis shorter than this says nothing of a direction.
constexpr double kNoLength = 1e-9;

using Mistake = std::optional<std::string>;

class Reader {
 public:
  Reader(std::string name, const AptOptions& options)
      : name_(std::move(name)),
        unit_(options.unit_mm > 0.0 ? options.unit_mm : 1.0),
        known_(options.unit_mm > 0.0) {
    length_ = options.tool_length;
    program_.operations.emplace_back();
    program_.operations.back().path.tool.length = length_;
  }

  Result<void> read(const AptRecord& record);
  bool ended() const { return ended_; }
  Result<AptProgram> finish(std::uint32_t line);

 private:
  AptOperation& operation() { return program_.operations.back(); }
  tl::unexpected<Error> wrong(std::uint32_t line, const std::string& what) const {
    return fail(Code::kInput, name_ + ":" + std::to_string(line) + ": " + what);
  }
  void event(EventKind kind, double value, const std::string& text = "") {
    operation().events.push_back({operation().path.moves.size(), kind, value, text});
  }
  Mistake dispatch(const AptRecord& record);
  Mistake go(const AptRecord& record);
  Mistake go_by(const AptRecord& record);
  Mistake move_to(Point<Part> tip, std::uint32_t line);
  Mistake set_axis(double i, double j, double k);
  Mistake feed(const AptRecord& record);
  Mistake spindle(const AptRecord& record);
  Mistake coolant(const AptRecord& record);
  Mistake tool(const AptRecord& record);
  Mistake cutter(AptRecord record);
  Mistake units(const AptRecord& record);
  Mistake dwell(const AptRecord& record);
  void note(const AptRecord& record, const std::string& what) { notes_.add(record.line, what); }

  std::string name_;
  AptProgram program_;
  AptNotes notes_;
  double unit_;
  bool known_;  ///< the unit is stated
  double length_ = 0.0, feed_ = 0.0, rpm_ = 0.0, turn_ = 1.0;
  bool per_turn_ = false, rapid_ = false, ended_ = false, closed_ = false;
  Point<Part> at_{};
  Vec3 axis_{0.0, 0.0, 1.0};
  ToolData cutter_{};
};

Mistake Reader::set_axis(double i, double j, double k) {
  const Vec3 axis{i, j, k};
  if (!(length(axis) > kNoLength))
    return "the tool axis (" + decimal(i, 9) + ", " + decimal(j, 9) + ", " + decimal(k, 9) +
           ") has no length; state a direction";
  axis_ = normalized(axis);
  return std::nullopt;
}

Mistake Reader::move_to(Point<Part> tip, std::uint32_t line) {
  at_ = tip;
  ToolPath& path = operation().path;
  const bool rapid = rapid_ || path.moves.empty();
  rapid_ = closed_ = false;
  if (!rapid) {
    const double rate = per_turn_ ? feed_ * rpm_ : feed_;
    if (!(feed_ > 0.0)) return "no FEDRAT/ yet for this feed move; state one before it, or RAPID";
    if (!(rate > 0.0)) return "the feed per turn needs a spindle speed; state SPINDL/ before it";
    const Feed now = Feed::from_mm_per_min(rate);
    if (path.feeds.empty()) path.cut_feed = path.plunge_feed = now;
    if (path.feeds.empty() || path.feeds.back().feed != now)
      path.feeds.push_back({static_cast<std::uint32_t>(path.moves.size()), now});
  }
  path.moves.push_back({{tip, axis_}, rapid ? MoveKind::kRapid : MoveKind::kCut, kNoFacet});
  operation().lines.push_back(line);
  return std::nullopt;
}

Mistake Reader::go(const AptRecord& record) {
  std::array<double, 9> v{};
  std::size_t count = 0;
  if (auto bad = record.numbers(v, count)) return bad;
  if (count != 3 && count != 6 && count != 9)
    return record.word + "/ has " + std::to_string(count) + " numbers; expected x,y,z or x,y,z,i,j,k";
  if (count == 9) note(record, "GOTO/ with 9 numbers: the last three are not used");
  if (count > 3) {
    if (auto bad = set_axis(v[3], v[4], v[5])) return bad;
  }
  const Point<Part> tip{v[0] * unit_, v[1] * unit_, v[2] * unit_};
  if (record.word == "GOTO") return move_to(tip, record.line);
  at_ = tip;  // FROM/: where the tool is
  return std::nullopt;
}

Mistake Reader::go_by(const AptRecord& record) {
  std::array<double, 3> v{};
  std::size_t count = 0;
  if (auto bad = record.numbers(v, count)) return bad;
  if (count == 1) return move_to(at_ + axis_ * (v[0] * unit_), record.line);
  if (count != 3) return "GODLTA/ wants dx,dy,dz, or a distance along the tool axis";
  return move_to(at_ + Vec3{v[0], v[1], v[2]} * unit_, record.line);
}

Mistake Reader::feed(const AptRecord& record) {
  const auto value = record.first_number();
  if (!value) return "FEDRAT/ has no number";
  if (!std::isfinite(*value) || !(*value > 0.0)) return "FEDRAT/ wants a feed above 0";
  const bool inch = record.has("IPM") || record.has("IPR"), mm = record.has("MMPM") || record.has("MMPR");
  if (record.has("INVERS") || record.has("FPM") || record.has("MPM"))
    return "FEDRAT/ is understood in MMPM, IPM, MMPR or IPR; post the file with one of these";
  if (inch && !known_)
    return "the feed is in inches and nothing states the unit of the file; put UNITS/INCHES or UNITS/MM "
           "before it, "
           "or say --units";
  per_turn_ = record.has("IPR") || record.has("MMPR") || record.has("PERREV");
  feed_ = *value * (inch ? kInch : (mm ? 1.0 : unit_));
  return std::nullopt;
}

Mistake Reader::spindle(const AptRecord& record) {
  if (record.has("OFF")) {
    event(EventKind::kSpindle, 0.0);
    return std::nullopt;
  }
  if (record.has("SFM") || record.has("SMM") || record.has("MAXRPM"))
    return "SPINDL/ is understood in RPM; a surface speed is not";
  const auto value = record.first_number();
  if (value && (!std::isfinite(*value) || *value < 0.0)) return "SPINDL/ wants a speed of 0 or more";
  if (value) rpm_ = *value;
  if (record.has("CLW")) turn_ = 1.0;
  if (record.has("CCLW")) turn_ = -1.0;
  event(EventKind::kSpindle, rpm_ * turn_);
  return std::nullopt;
}

Mistake Reader::coolant(const AptRecord& record) {
  const bool off = record.has("OFF"), mist = record.has("MIST");
  const bool flood = record.has("ON") || record.has("FLOOD");
  if (!off && !mist && !flood)
    note(record, "COOLNT/" + (record.words.empty() ? "" : record.words.front()) + " is posted as flood");
  event(EventKind::kCoolant, off ? 0.0 : (mist ? 2.0 : 1.0));
  return std::nullopt;
}

Mistake Reader::tool(const AptRecord& record) {
  double number = 0.0, length = length_;
  if (const auto value = record.first_number()) number = *value;
  if (const auto value = record.number_after("LENGTH")) length = *value * unit_;
  if (!std::isfinite(number) || number < 0.0 || number > 9999.0 || number != std::floor(number))
    return record.word + "/ wants a tool number from 0 to 9999";
  if (!std::isfinite(length) || length < 0.0) return record.word + "/ wants a LENGTH of 0 or more";
  if (!operation().path.moves.empty()) {
    program_.operations.emplace_back();
    operation().path.tool = cutter_;
  }
  operation().tool_number = static_cast<int>(number);
  operation().path.tool.length = length;
  return std::nullopt;
}

/// CUTTER/d,r,... or TLDATA/MILL,d,r,...
Mistake Reader::cutter(AptRecord record) {
  if (record.has("MILL")) record.words.erase(record.words.begin());
  std::array<double, 12> v{};
  std::size_t count = 0;
  if (auto bad = record.numbers(v, count)) return bad;
  if (count == 0 || v[0] < 0.0 || v[1] < 0.0) return "CUTTER/ wants diameter[,corner radius]";
  cutter_.diameter = v[0] * unit_;
  cutter_.corner_radius = std::min(v[1], v[0] / 2.0) * unit_;
  if (!operation().path.moves.empty()) return std::nullopt;  // that of the next LOADTL/
  operation().path.tool.diameter = cutter_.diameter;
  operation().path.tool.corner_radius = cutter_.corner_radius;
  return std::nullopt;
}

Mistake Reader::units(const AptRecord& record) {
  known_ = true;
  if (record.has("MM"))
    unit_ = 1.0;
  else if (record.has("INCHES") || record.has("INCH"))
    unit_ = kInch;
  else if (record.has("CM"))
    unit_ = 10.0;
  else
    return "UNITS/ wants MM, CM or INCHES";
  return std::nullopt;
}

Mistake Reader::dwell(const AptRecord& record) {
  const auto value = record.first_number();
  if (!value || !std::isfinite(*value) || *value < 0.0) return "DELAY/ wants seconds of 0 or more";
  if (record.has("REV")) return "DELAY/ is understood in seconds; revolutions are not";
  event(EventKind::kDwell, *value);
  return std::nullopt;
}

Mistake Reader::dispatch(const AptRecord& r) {
  if (r.word == "GOTO" || r.word == "FROM") return go(r);
  if (r.word == "GODLTA") return go_by(r);
  if (r.word == "FEDRAT") return feed(r);
  if (r.word == "SPINDL") return spindle(r);
  if (r.word == "COOLNT") return coolant(r);
  if (r.word == "LOADTL" || r.word == "TOOLNO" || r.word == "TURRET" || (r.word == "LOAD" && r.has("TOOL")))
    return tool(r);
  if (r.word == "CUTTER" || (r.word == "TLDATA" && r.has("MILL"))) return cutter(r);
  if (r.word == "UNITS") return units(r);
  if (r.word == "DELAY") return dwell(r);
  if (r.word == "TLAXIS") {
    std::array<double, 3> v{};
    std::size_t count = 0;
    if (auto bad = r.numbers(v, count)) return bad;
    if (count != 3) return "TLAXIS/ wants i,j,k";
    return set_axis(v[0], v[1], v[2]);
  }
  if (r.word == "RAPID") {
    rapid_ = true;
  } else if (r.word == "STOP") {
    event(EventKind::kStop, 0.0);
  } else if (r.word == "OPSTOP") {
    event(EventKind::kOptionalStop, 0.0);
  } else if (r.word == "PPRINT") {
    if (!r.text.starts_with("TILTFEED")) event(EventKind::kRemark, 0.0, r.text);
  } else if (r.word == "PARTNO") {
    program_.name = r.text;
  } else if (r.word == "FINI" || r.word == "END") {
    ended_ = true;
  } else if (r.word == "END-OF-PATH") {
    closed_ = true;  // another may follow
  } else if (bends_path(r)) {
    return r.word +
           " asks for more than straight lines between the points; let the CAM system write GOTO/ alone "
           "(linear output, cycles and arcs expanded)";
  } else if (!only_informs(r)) {
    note(r, r.word + " is not understood and was left out");
  }
  return std::nullopt;
}

Result<void> Reader::read(const AptRecord& record) {
  if (auto bad = dispatch(record)) return wrong(record.line, *bad);
  return {};
}

Result<AptProgram> Reader::finish(std::uint32_t line) {
  if (!ended_ && !closed_)
    return wrong(line, "the file ends without FINI, END or END-OF-PATH: it is cut short");
  if (operation().path.moves.empty() && program_.operations.size() > 1) program_.operations.pop_back();
  if (operation().path.moves.empty()) return wrong(line, "no GOTO/ before the end");
  if (!known_)
    program_.notes.push_back(name_ + ": no UNITS/: its numbers are taken as mm (else: --units inch)");
  notes_.append_to(program_.notes, name_);
  for (AptOperation& op : program_.operations) op.path.name = program_.name;
  return std::move(program_);
}

}  // namespace

Result<AptProgram> read_apt(std::istream& in, const std::string& name, const AptOptions& options) {
  Reader reader(name, options);
  AptRecords records(in);
  AptRecord record;
  while (!reader.ended()) {
    if (!records.next(record)) break;
    if (auto read = reader.read(record); !read) return tl::unexpected(read.error());
  }
  if (in.bad()) return fail(Code::kIo, name + ": cannot be read");
  return reader.finish(records.line());
}

}  // namespace tiltfeed
