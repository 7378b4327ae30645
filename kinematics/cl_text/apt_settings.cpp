#include <algorithm>
#include <array>
#include <cmath>

#include "kinematics/basics/decimal.h"
#include "kinematics/cl_text/apt_reader.h"

namespace tiltfeed {
namespace {

constexpr double kInch = 25.4;  // mm, exactly
// A tool axis shorter than this says nothing of a direction.
constexpr double kNoLength = 1e-9;
constexpr double kMostNumber = 9999.0;  // of tools and registers

bool is_unit(const std::string& word) { return word == "UNITS" || word == "UNIT"; }

bool is_number(double value) { return value >= 0.0 && value <= kMostNumber && value == std::floor(value); }

/// A record of one number has two: 1,5 may be 1.5.
AptVerdict one_number(const AptRecord& record) {
  AptPlace second;
  if (record.count_numbers(&second) < 2) return std::nullopt;
  return mistake(record.word + "/ has more than one number (is a comma used as decimal point?)", second);
}

}  // namespace

Result<void> AptReader::take_unit(const std::vector<AptRecord>& head) {
  bool stated = false;
  for (const AptRecord& record : head) {
    if (!is_unit(record.word)) continue;
    double unit = 0.0;
    if (const auto bad = units(record, unit)) return wrong(record.place, bad->what);
    if (stated && unit != unit_) return wrong(record.place, "two units are stated before the first motion");
    unit_ = unit;
    stated = known_ = true;
  }
  return {};
}

AptVerdict AptReader::units(const AptRecord& record, double& unit_mm) const {
  if (record.has("MM"))
    unit_mm = 1.0;
  else if (record.has("INCHES") || record.has("INCH"))
    unit_mm = kInch;
  else if (record.has("CM"))
    unit_mm = 10.0;
  else
    return mistake(record.word + "/ wants MM, CM or INCHES");
  if (moved_ && (!known_ || unit_mm != unit_))
    return mistake(record.word + "/ stands behind the first motion, which was read in " +
                   (known_ ? "another unit" : "mm") + "; state the unit before it");
  return std::nullopt;
}

AptVerdict AptReader::set_axis(double i, double j, double k) {
  const Vec3 axis{i, j, k};
  if (!(length(axis) > kNoLength))
    return mistake("the tool axis (" + decimal(i, 9) + ", " + decimal(j, 9) + ", " + decimal(k, 9) +
                   ") has no length; state a direction");
  axis_ = normalized(axis);
  return std::nullopt;
}

AptVerdict AptReader::tool_axis(const AptRecord& record) {
  std::array<double, 3> v{};
  std::size_t count = 0;
  if (auto bad = record.numbers(v, count)) return bad;
  if (count != 3) return mistake("TLAXIS/ wants i,j,k");
  return set_axis(v[0], v[1], v[2]);
}

/// A feed in mm/min, or in mm a turn.
AptVerdict AptReader::rate(std::string_view unit, double value, double& feed, bool& per_turn) const {
  const bool inch = unit == "IPM" || unit == "IPR", mm = unit == "MMPM" || unit == "MMPR";
  if (inch && !known_)
    return mistake(
        "the feed is in inches and nothing states the unit of the file; put UNITS/INCHES or "
        "UNITS/MM before it, or say --units");
  per_turn = unit == "IPR" || unit == "MMPR" || unit == "PERREV";
  feed = value * (inch ? kInch : (mm ? 1.0 : unit_));
  return std::nullopt;
}

AptVerdict AptReader::feed(const AptRecord& record) {
  const auto value = record.first_number();
  if (!value) return mistake("FEDRAT/ has no number");
  if (!std::isfinite(*value) || !(*value > 0.0)) return mistake("FEDRAT/ wants a feed above 0");
  if (auto bad = one_number(record)) return bad;
  if (record.has("INVERS") || record.has("FPM") || record.has("MPM"))
    return mistake("FEDRAT/ is understood in MMPM, IPM, MMPR or IPR; post the file with one of these");
  std::string_view unit;
  for (const std::string_view one : {"IPM", "MMPM", "IPR", "MMPR", "PERREV"})
    if (record.has(one)) unit = one;
  return rate(unit, *value, feed_, per_turn_);
}

AptVerdict AptReader::spindle(const AptRecord& record) {
  if (record.has("OFF")) {
    event(EventKind::kSpindle, 0.0);
    return std::nullopt;
  }
  if (record.has("SFM") || record.has("SMM") || record.has("MAXRPM"))
    return mistake("SPINDL/ is understood in RPM; a surface speed is not");
  const auto value = record.first_number();
  if (value && (!std::isfinite(*value) || *value < 0.0)) return mistake("SPINDL/ wants a speed of 0 or more");
  if (const auto second = record.number_behind_number())
    return mistake("SPINDL/ has two numbers in a row (is a comma used as decimal point?)", *second);
  if (value) rpm_ = *value;
  if (record.has("CLW")) turn_ = 1.0;
  if (record.has("CCLW")) turn_ = -1.0;
  event(EventKind::kSpindle, rpm_ * turn_);
  return std::nullopt;
}

AptVerdict AptReader::coolant(const AptRecord& record) {
  const bool off = record.has("OFF"), mist = record.has("MIST");
  const bool flood = record.has("ON") || record.has("FLOOD");
  bool through = false;
  for (const char* const word : {"THRU", "THRUSP", "THROUGH"}) through = through || record.has(word);
  if (!off && !mist && !flood && !through)
    note(record, "COOLNT/" + (record.words.empty() ? "" : record.words.front()) + " is posted as flood");
  event(EventKind::kCoolant, off ? 0.0 : through ? 3.0 : mist ? 2.0 : 1.0);
  return std::nullopt;
}

AptVerdict AptReader::tool(const AptRecord& record) {
  double number = 0.0, length = length_, adjust = 0.0;
  if (const auto value = record.first_number()) number = *value;
  if (const auto value = record.number_after("LENGTH")) length = *value * unit_;
  const bool own =
      std::find(options_.ignored.begin(), options_.ignored.end(), "ADJUST") != options_.ignored.end();
  if (const auto value = record.number_after("ADJUST"); value && !own) adjust = *value;
  if (!is_number(number)) return mistake(record.word + "/ wants a tool number from 0 to 9999");
  if (!is_number(adjust)) return mistake(record.word + "/ wants a register from 0 to 9999 behind ADJUST");
  if (!std::isfinite(length) || length < 0.0) return mistake(record.word + "/ wants a LENGTH of 0 or more");
  const auto length_of = std::find(record.words.begin(), record.words.end(), "LENGTH");
  if (const auto behind = record.number_behind_number(); behind && length_of != record.words.end())
    return mistake(record.word + "/ has two numbers in a row (is a comma used as decimal point?)", *behind);
  if (compensated_) return mistake("the tool is changed while CUTCOM/ is on; end it with CUTCOM/OFF");
  if (cycling_)
    return mistake(
        "the tool is changed while CYCLE/ is on; end it with CYCLE/OFF before it, and state it again where "
        "the "
        "next tool drills, too");
  if (!operation().path.moves.empty()) {
    program_.operations.emplace_back();
    low_ = false;
    operation().path.tool = cutter_;
  }
  operation().tool_number = static_cast<int>(number);
  operation().length_register = static_cast<int>(adjust);
  operation().path.tool.length = length;
  return std::nullopt;
}

/// CUTTER/d,r,... or TLDATA/kind,d,r,...
AptVerdict AptReader::cutter(AptRecord record) {
  while (record.word == "TLDATA" && !record.words.empty() && !apt_number(record.words.front())) {
    record.words.erase(record.words.begin());
    record.places.erase(record.places.begin());
  }
  std::array<double, 12> v{};
  std::size_t count = 0;
  if (auto bad = record.numbers(v, count)) return bad;
  if (count == 0 || v[0] < 0.0 || v[1] < 0.0)
    return mistake(record.word + "/ wants diameter[,corner radius]");
  cutter_.diameter = v[0] * unit_;
  cutter_.corner_radius = std::min(v[1], v[0] / 2.0) * unit_;
  if (!operation().path.moves.empty()) return std::nullopt;  // that of the next LOADTL/
  operation().path.tool.diameter = cutter_.diameter;
  operation().path.tool.corner_radius = cutter_.corner_radius;
  return std::nullopt;
}

AptVerdict AptReader::dwell(const AptRecord& record) {
  const auto value = record.first_number();
  if (!value || !std::isfinite(*value) || *value < 0.0) return mistake("DELAY/ wants seconds of 0 or more");
  if (auto bad = one_number(record)) return bad;
  if (record.has("REV")) return mistake("DELAY/ is understood in seconds; revolutions are not");
  event(EventKind::kDwell, *value);
  return std::nullopt;
}

/// CUTCOM/LEFT[,register], RIGHT or OFF.
AptVerdict AptReader::compensation(const AptRecord& record) {
  if (record.has("OFF")) {
    if (compensated_) event(EventKind::kCutterOff, 0.0);
    compensated_ = false;
    return std::nullopt;
  }
  double number = 0.0;
  for (std::size_t i = 0; i < record.words.size(); ++i) {
    const std::string& one = record.words[i];
    const auto value = apt_number(one);
    if (value) number = *value;
    if (!value && one != "LEFT" && one != "RIGHT" && one != "XYPLAN" && one != "ADJUST")
      return mistake("CUTCOM/: \"" + one + "\" is not understood; LEFT, RIGHT and OFF are", record.places[i]);
  }
  if (record.has("LEFT") == record.has("RIGHT")) return mistake("CUTCOM/ wants LEFT, RIGHT or OFF");
  if (!is_number(number)) return mistake("CUTCOM/ wants a register from 0 to 9999");
  event(record.has("LEFT") ? EventKind::kCutterLeft : EventKind::kCutterRight, number);
  compensated_ = true;
  return std::nullopt;
}

AptVerdict AptReader::cycle(const AptRecord& record) {
  const bool off = record.has("OFF") || record.has("NOMORE") || record.has("INIT");
  if (off) {
    cycling_ = false;
    return std::nullopt;
  }
  if (rapid_) return mistake("RAPID and no point before CYCLE/");
  if (!cycling_) cycle_start_ = at_;
  if (auto bad = read_cycle(record, cycle_)) return bad;
  if (cycle_.kind == CycleKind::kTap)
    note(record, "CYCLE/TAP is written as moves and spindle turns: it wants a floating tap holder");
  cycling_ = true;
  return std::nullopt;
}

AptVerdict AptReader::circle(const AptRecord& record) {
  if (cycling_) return mistake("CIRCLE/ while a CYCLE/ is on; end it with CYCLE/OFF");
  AptArc arc;
  if (auto bad = read_circle(record, arc)) return bad;
  arc.radius *= unit_;
  arc_ = arc;
  return std::nullopt;
}

/// MSYS/ holds for what follows. Points under TRNTYP/WORLD,0,0,0 are the part's: CSYS/ then says only where a
/// set-up stands, and which tool axis a point without one has.
AptVerdict AptReader::frame(const AptRecord& record) {
  const std::string leave = "; if the points are the part's, say --ignore " + record.word;
  if (record.word == "TRNTYP") {
    world_ = record.words == std::vector<std::string>{"WORLD", "0", "0", "0"};
    if (!world_) return mistake("TRNTYP/ is understood as WORLD,0,0,0" + leave);
    return std::nullopt;
  }
  AptFrame stated;
  const bool msys = record.word == "MSYS";
  if (auto bad = msys ? read_msys(record, unit_, stated) : read_csys(record, unit_, stated)) return bad;
  const bool none = stated.turn == Rotation{} && stated.origin == Vec3{};
  if (msys) {
    frame_ = stated;
    if (!none) note(record, "MSYS/: points are shifted and turned into the part's frame");
    return std::nullopt;
  }
  if (!none && !world_)
    return mistake(
        "CSYS/: nothing states whether the points are in this frame (TRNTYP/WORLD,0,0,0: they are "
        "the part's)" +
        leave);
  if (!none) note(record, "CSYS/ states a set-up; the points are the part's (TRNTYP/WORLD)");
  axis_ = transposed(frame_.turn) * (stated.turn * Vec3{0, 0, 1});
  return std::nullopt;
}

/// MULTAX, MODE/ and SET/.
AptVerdict AptReader::mode(const AptRecord& record) {
  if (record.word == "MULTAX") {
    one_axis_ = record.has("OFF");
    return std::nullopt;
  }
  if (record.has("INCR") || record.has("INCREM"))
    return mistake(record.word + "/ asks for incremental points; let the CAM system write absolute ones");
  if (record.word == "MODE" && !record.has("ABSOL"))
    return mistake("MODE/ is understood as ABSOL; if it means nothing here, say --ignore MODE");
  if (!record.has("ABSOL")) note(record, record.word + " is not understood and was left out");
  return std::nullopt;
}

bool AptReader::settings(const AptRecord& r, AptVerdict& verdict) {
  double unit = 0.0;
  if (r.word == "FEDRAT") return verdict = feed(r), true;
  if (r.word == "SPINDL") return verdict = spindle(r), true;
  if (r.word == "COOLNT") return verdict = coolant(r), true;
  if (r.word == "LOADTL" || r.word == "TOOLNO" || r.word == "TURRET" || (r.word == "LOAD" && r.has("TOOL")))
    return verdict = tool(r), true;
  if (r.word == "CUTTER" || r.word == "TLDATA") return verdict = cutter(r), true;
  if (is_unit(r.word)) return verdict = units(r, unit), true;
  if (r.word == "DELAY") return verdict = dwell(r), true;
  if (r.word == "CUTCOM") return verdict = compensation(r), true;
  if (r.word == "CYCLE") return verdict = cycle(r), true;
  if (r.word == "CIRCLE") return verdict = circle(r), true;
  if (r.word == "MSYS" || r.word == "CSYS" || r.word == "TRNTYP") return verdict = frame(r), true;
  if (r.word == "MULTAX" || r.word == "MODE" || r.word == "SET") return verdict = mode(r), true;
  if (r.word == "TLAXIS") return verdict = tool_axis(r), true;
  return false;
}

}  // namespace tiltfeed
