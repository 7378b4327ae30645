#include "kinematics/cl_text/apt_cycle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

namespace tiltfeed {
namespace {

// How far above the last depth a deep hole is entered again, and how far the tool is drawn back to break a
// chip: at most half a step, mm.
constexpr double kReEntry = 1.0;
constexpr double kChip = 0.5;
constexpr double kMostSteps = 10'000;

constexpr std::array<std::string_view, 6> kFeedUnits{"MMPM", "IPM", "MMPR", "IPR", "PERMIN", "PERREV"};
constexpr std::array<std::pair<std::string_view, CycleKind>, 10> kKinds{{{"DRILL", CycleKind::kDrill},
                                                                         {"FACE", CycleKind::kDrill},
                                                                         {"SPOT", CycleKind::kDrill},
                                                                         {"DEEP", CycleKind::kDeep},
                                                                         {"DEEP2", CycleKind::kDeep},
                                                                         {"BRKCHP", CycleKind::kBreakChip},
                                                                         {"BRKCHP2", CycleKind::kBreakChip},
                                                                         {"TAP", CycleKind::kTap},
                                                                         {"BORE", CycleKind::kBore},
                                                                         {"REAM", CycleKind::kBore}}};

/// Reads the words behind the slash one after the other.
class CycleWords {
 public:
  CycleWords(const AptRecord& record, AptCycle& cycle) : record_(record), cycle_(cycle) {}
  AptVerdict read();

 private:
  bool kind();
  AptVerdict couple();
  AptVerdict value(std::string_view word, double& out);
  AptVerdict feed(std::string_view unit);
  AptVerdict dwell();
  AptVerdict check() const;
  /// The number that stands next, taken.
  std::optional<double> next_number() {
    if (at_ == record_.words.size()) return std::nullopt;
    const auto number = apt_number(record_.words[at_]);
    if (number) ++at_;
    return number;
  }
  AptMistake wrong(const std::string& what) const {
    const std::size_t at = std::min(at_, record_.words.size()) - 1;
    return mistake("CYCLE/" + record_.words.front() + ": " + what, record_.places[at]);
  }

  const AptRecord& record_;
  AptCycle& cycle_;
  std::size_t at_ = 0;
  bool depth_by_position_ = false;
};

/// The kinds in front: DRILL, or DRILL,DEEP.
bool CycleWords::kind() {
  bool found = record_.words.front() == "ON";
  if (found) ++at_;
  for (; at_ < record_.words.size(); ++at_) {
    const auto known = std::find_if(kKinds.begin(), kKinds.end(),
                                    [&](const auto& one) { return one.first == record_.words[at_]; });
    if (known == kKinds.end()) break;
    if (!found) cycle_ = {};
    cycle_.kind = known->second;
    found = true;
  }
  return found;
}

AptVerdict CycleWords::value(std::string_view word, double& out) {
  const auto number = next_number();
  if (!number || !std::isfinite(*number)) return wrong(std::string(word) + " has no number");
  out = *number;
  return std::nullopt;
}

/// A feed, and by position the clearance behind it: where the depth is by position, too.
AptVerdict CycleWords::feed(std::string_view unit) {
  cycle_.feed_unit = unit;
  if (auto bad = value(unit, cycle_.feed)) return bad;
  if (!(cycle_.feed > 0.0)) return wrong("the feed is not above 0");
  if (!depth_by_position_) return std::nullopt;
  if (const auto clear = next_number()) cycle_.rapid_to = *clear;
  return std::nullopt;
}

AptVerdict CycleWords::dwell() {
  cycle_.dwell_turns = at_ < record_.words.size() && record_.words[at_] == "REV";
  if (cycle_.dwell_turns) ++at_;
  if (auto bad = value("DWELL", cycle_.dwell)) return bad;
  if (!(cycle_.dwell >= 0.0)) return wrong("DWELL wants a time of 0 or more");
  return std::nullopt;
}

/// A word and its numbers.
AptVerdict CycleWords::couple() {
  const std::string& word = record_.words[at_++];
  double number = 0.0;
  if (std::find(kFeedUnits.begin(), kFeedUnits.end(), word) != kFeedUnits.end()) return feed(word);
  if (word == "DWELL") return dwell();
  if (word == "FEDTO" || word == "DEPTH") {
    if (auto bad = value(word, number)) return bad;
    cycle_.depth = std::abs(number);  // NX counts it upwards, others downwards
  } else if (word == "CLEAR" || word == "RAPTO") {
    if (auto bad = value(word, number)) return bad;
    // With both the tool feeds from the higher.
    cycle_.rapid_to = std::max(number, cycle_.rapid_to.value_or(number));
  } else if (word == "RTRCTO" || word == "RETURN") {
    cycle_.to_start = at_ < record_.words.size() && record_.words[at_] == "AUTO";
    cycle_.retract.reset();
    if (cycle_.to_start) return ++at_, std::nullopt;
    if (auto bad = value(word, number)) return bad;
    cycle_.to_start = word == "RETURN" && number == 0.0;
    if (!cycle_.to_start) cycle_.retract = number;
  } else if (word == "STEP" || word == "INCR" || word == "PECK" || word == "1STPECK") {
    if (auto bad = value(word, number)) return bad;
    cycle_.steps = {number};
    while (const auto more = next_number()) cycle_.steps.push_back(*more);
  } else if (word == "SUBPECK") {
    if (auto bad = value(word, number)) return bad;
    cycle_.steps.push_back(number);
  } else {
    return wrong("\"" + word + "\" is not understood; let the CAM system write the moves themselves");
  }
  return std::nullopt;
}

AptVerdict CycleWords::check() const {
  if (!cycle_.depth || !(*cycle_.depth > 0.0)) return wrong("no depth (FEDTO or DEPTH)");
  if (!cycle_.rapid_to || !(*cycle_.rapid_to >= 0.0))
    return wrong("no clearance of 0 or more (RAPTO or CLEAR)");
  if (cycle_.kind != CycleKind::kDeep && cycle_.kind != CycleKind::kBreakChip) return std::nullopt;
  if (cycle_.steps.empty()) return wrong("no step (STEP or 1STPECK)");
  for (const double step : cycle_.steps)
    if (!(step > 0.0 && (*cycle_.rapid_to + *cycle_.depth) / step < kMostSteps))
      return wrong("a step wants a length, and no more than 10000 of them for the hole");
  return std::nullopt;
}

AptVerdict CycleWords::read() {
  if (record_.words.empty() || !kind()) {
    at_ = std::max<std::size_t>(at_, 1);
    if (record_.words.empty()) return mistake("CYCLE/ has no kind");
    return wrong("only DRILL, FACE, SPOT, DEEP, BRKCHP, TAP, BORE and REAM are understood");
  }
  cycle_.rapid_to = record_.has("CLEAR") || record_.has("RAPTO") ? std::nullopt : cycle_.rapid_to;
  if (const auto depth = next_number()) {
    cycle_.depth = std::abs(*depth);
    depth_by_position_ = true;
  }
  while (at_ < record_.words.size()) {
    if (apt_number(record_.words[at_])) {
      ++at_;
      return wrong("what the number " + record_.words[at_ - 1] +
                   " means is not clear; let the CAM system write words in front of the numbers");
    }
    if (auto bad = couple()) return bad;
  }
  return check();
}

}  // namespace

AptVerdict read_cycle(const AptRecord& record, AptCycle& cycle) { return CycleWords(record, cycle).read(); }

std::vector<CycleStep> steps_of(const AptCycle& cycle, double retract, double unit_mm) {
  const double top = *cycle.rapid_to, bottom = -*cycle.depth;
  std::vector<CycleStep> steps;
  const bool pecks = cycle.kind == CycleKind::kDeep || cycle.kind == CycleKind::kBreakChip;
  double at = top;
  for (std::size_t i = 0; pecks; ++i) {
    const double step = cycle.steps[std::min(i, cycle.steps.size() - 1)];
    at -= step;
    if (at <= bottom) break;
    steps.push_back({at, false, CycleThen::kNothing});
    const double gap = std::min((cycle.kind == CycleKind::kDeep ? kReEntry : kChip) / unit_mm, step / 2.0);
    if (cycle.kind == CycleKind::kDeep) steps.push_back({top, true, CycleThen::kNothing});
    steps.push_back({at + gap, true, CycleThen::kNothing});
  }
  const bool taps = cycle.kind == CycleKind::kTap, bores = cycle.kind == CycleKind::kBore;
  const CycleThen dwell = cycle.dwell > 0.0 ? CycleThen::kDwell : CycleThen::kNothing;
  steps.push_back({bottom, false, taps ? CycleThen::kReverse : dwell});
  if (taps || bores) steps.push_back({top, false, taps ? CycleThen::kForward : CycleThen::kNothing});
  if ((!taps && !bores) || retract > top) steps.push_back({retract, true, CycleThen::kNothing});
  return steps;
}

}  // namespace tiltfeed
