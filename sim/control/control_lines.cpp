// ControlReader's lines that are no list of words.

#include "sim/control/control_reader.h"
#include "sim/control/smoothing_words.h"

namespace tiltfeed::sim {

/// Lines that are no list of words; true: it was one.
bool ControlReader::whole_line(std::string_view line, Wrong& wrong, std::vector<ControlBlock>& blocks) {
  const auto is = [&](std::string_view head) { return line.starts_with(head); };
  const bool plain = dialect_ == config::Dialect::kHeidenhain,
             iso = dialect_ == config::Dialect::kHeidenhainIso;
  if (line.front() == '%') {
    const bool pair = !iso && dialect_ != config::Dialect::kSiemens;
    if (iso && percents_ == 0) wrong = other_unit(line.find(" G70") != line.npos);
    if (++percents_ == 2 && (pair || iso)) ended_ = true;
    return true;
  }
  if (is("PLANE")) {
    wrong = plane_line(line);
    return true;
  }
  if (is("Q") && (plain || iso)) return true;
  if (smooths(line, dialect_)) return true;
  if (!plain) return counts_points_ && (is("O") || is(":"));
  if (is("TOOL DEF ")) return true;  // makes the next tool ready
  if (is("BEGIN PGM")) wrong = other_unit(line.ends_with(" INCH"));
  if (is("END PGM")) ended_ = true;
  if (is("BEGIN PGM") || is("END PGM") || is("BLK FORM") || is("CYCL DEF 247") || is("CYCL DEF 9.0") ||
      is("CYCL DEF 10.0"))
    return true;
  if (is("CYCL DEF 10.1")) {
    if (line != "CYCL DEF 10.1 ROT+0") wrong = "a turned part is refused";
    return true;
  }
  if (is("CYCL DEF 9.1 DWELL ")) {
    ControlWords words;
    if (auto bad = take_apart("P" + std::string(line.substr(19)), words))
      wrong = bad;
    else
      wrong = dwell(words, blocks);
    return true;
  }
  if (!is("TOOL CALL")) return false;
  wrong = tool_call(line, blocks);
  return true;
}

}  // namespace tiltfeed::sim
