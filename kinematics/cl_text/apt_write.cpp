#include <array>
#include <cmath>
#include <ostream>
#include <string>

#include "kinematics/basics/decimal.h"
#include "kinematics/cl_text/apt_file.h"

namespace tiltfeed {
namespace {

constexpr int kTipDecimals = 6;
constexpr int kAxisDecimals = 9;
constexpr int kFeedDecimals = 6;

constexpr double kMistCoolant = 2.0;

}  // namespace

void append_event(std::string& text, const PathEvent& event) {
  switch (event.kind) {
    case EventKind::kRemark:
      text += "PPRINT " + event.text + "\n";
      return;
    case EventKind::kSpindle:
      text += event.value == 0.0 ? std::string("SPINDL/OFF\n")
                                 : "SPINDL/" + decimal(std::abs(event.value), 3) +
                                       (event.value < 0.0 ? ",RPM,CCLW\n" : ",RPM,CLW\n");
      return;
    case EventKind::kCoolant:
      text += event.value == 0.0            ? "COOLNT/OFF\n"
              : event.value == 1.0          ? "COOLNT/FLOOD\n"
              : event.value == kMistCoolant ? "COOLNT/MIST\n"
                                            : "COOLNT/THRU\n";
      return;
    case EventKind::kDwell:
      text += "DELAY/" + decimal(event.value, 3) + "\n";
      return;
    case EventKind::kStop:
      text += "STOP\n";
      return;
    case EventKind::kOptionalStop:
      text += "OPSTOP\n";
      return;
    case EventKind::kCutterLeft:
    case EventKind::kCutterRight:
      text += event.kind == EventKind::kCutterLeft ? "CUTCOM/LEFT" : "CUTCOM/RIGHT";
      if (event.value > 0.0) text += "," + decimal(event.value, 0);
      text += "\n";
      return;
    case EventKind::kCutterOff:
      text += "CUTCOM/OFF\n";
      return;
    case EventKind::kPlane:
      return;
  }
}

void append_move(std::string& text, const Move& move) {
  if (move.kind == MoveKind::kRapid) text += "RAPID\n";
  text += "GOTO/";
  std::array<char, kDecimalSpace + 1> digits;
  const auto add = [&](double value, int decimals, char behind) {
    char* end = write_decimal(digits.data(), value, decimals);
    *end++ = behind;
    text.append(digits.data(), end);
  };
  for (const double value : {move.pose.tip.x, move.pose.tip.y, move.pose.tip.z})
    add(value, kTipDecimals, ',');
  add(move.pose.axis.x, kAxisDecimals, ',');
  add(move.pose.axis.y, kAxisDecimals, ',');
  add(move.pose.axis.z, kAxisDecimals, '\n');
}

void write_apt(const AptProgram& program, std::ostream& out) {
  out << "PARTNO " << program.name << "\nUNITS/MM\nMULTAX\n";
  for (const AptOperation& op : program.operations) {
    const ToolPath& path = op.path;
    out << "CUTTER/" << decimal(path.tool.diameter, kTipDecimals) << ","
        << decimal(path.tool.corner_radius, kTipDecimals) << "\nLOADTL/" << op.tool_number << ",LENGTH,"
        << decimal(path.tool.length, kTipDecimals);
    if (op.length_register > 0) out << ",ADJUST," << op.length_register;
    out << "\n";
    auto event = op.events.begin();
    Feed feed;
    std::string text;
    for (std::size_t i = 0; i < path.moves.size(); ++i) {
      text.clear();
      for (; event != op.events.end() && event->move <= i; ++event) append_event(text, *event);
      if (path.moves[i].kind != MoveKind::kRapid && feed_of(path, i) != feed) {
        feed = feed_of(path, i);
        text += "FEDRAT/" + decimal(feed.mm_per_min(), kFeedDecimals) + ",MMPM\n";
      }
      append_move(text, path.moves[i]);
      out << text;
    }
    text.clear();
    for (; event != op.events.end(); ++event) append_event(text, *event);
    out << text;
  }
  out << "FINI\n";
}

}  // namespace tiltfeed
