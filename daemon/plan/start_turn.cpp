#include "daemon/plan/start_turn.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include "daemon/plan/formatted.h"
#include "daemon/post/dialect.h"
#include "daemon/post/tcp_start.h"
#include "kinematics/timing/tcp_path.h"

namespace tiltfeed::daemon {
namespace {

// Places of a block at which the tip's height is taken, the end of the block before not counted.
constexpr int kPlaces = 4;
// Directions that differ by less are one.
constexpr double kSameDirection = 1e-12;
// A start so near to the end of Z's travel cannot be stated higher, mm.
constexpr double kAtTheEnd = 1.0;
constexpr const char* kTop = " the top of the";

/// The highest of some points along a direction, remembered for the next of that direction.
class Top {
 public:
  explicit Top(const pathgen::Mesh& mesh) : mesh_(mesh) {}
  double along(Vec3 up) {
    if (length(up - up_) < kSameDirection) return top_;
    up_ = up, top_ = -std::numeric_limits<double>::infinity();
    for (const Point<Part>& v : mesh_.vertices) top_ = std::max(top_, dot(from_origin(v), up));
    return top_;
  }

 private:
  const pathgen::Mesh& mesh_;
  Vec3 up_;
  double top_ = 0.0;
};

/// Where the machine's Z goes up, as the part sees it.
Vec3 machine_up(const MachineModel& machine, const Setup& setup, const Joints& axes) {
  Joints higher = axes;
  higher.z += 1.0;
  return from_origin(forward(machine, setup, higher).tip) - from_origin(forward(machine, setup, axes).tip);
}

std::string over_text(const StartTurn& turn, const config::Job& job, const char* top) {
  return formatted("tip %.1f mm %s%s %s", std::abs(turn.height), turn.height < 0.0 ? "under" : "over", top,
                   job.plan.fixtures ? "part and fixtures" : "part");
}

}  // namespace

std::optional<StartTurn> start_turn(const pathgen::Mesh& held, const config::Job& job, const Joints& first) {
  const MachineModel& machine = job.machine.model;
  const std::vector<Joints> start = tcp_start(job.machine, job.setup, first);
  if (start.empty()) return std::nullopt;
  StartTurn turn{std::numeric_limits<double>::infinity(), start.size()};
  Top top(held);
  for (std::size_t i = 0; i < start.size(); ++i)
    for (int k = i == 0 ? kPlaces : 1; k <= kPlaces; ++k) {
      const Joints &from = start[i > 0 ? i - 1 : 0], &to = start[i];
      const double f = static_cast<double>(k) / kPlaces;
      Joints words;
      for (double Joints::*word : {&Joints::x, &Joints::y, &Joints::z, &Joints::a, &Joints::c})
        words.*word = from.*word + f * (to.*word - from.*word);
      const Vec3 up = machine_up(machine, job.setup, axes_under_tcp(machine, job.setup, words));
      const Vec3 tip = from_origin(pose_under_tcp(machine, job.setup, words).tip);
      turn.height = std::min(turn.height, dot(tip, up) - top.along(up));
    }
  return turn;
}

std::string start_turn_text(const StartTurn& turn, const config::Job& job) {
  const bool low = turn.height < job.plan.links.clearance;
  return std::string(low ? "warning: " : "") +
         "where TCP begins the table turns from home to its place, the " + over_text(turn, job, kTop) +
         (low ? ": state a smaller program.tcp_start_below_mm" : "") + "\n";
}

std::string start_turn_comment(const StartTurn& turn, const config::Job& job) {
  return "table turns, " + over_text(turn, job, "");
}

std::string start_turn_advice(const StartTurn& turn, const config::Job& job, std::string_view head,
                              const std::string& message, const std::string& name) {
  const config::ProgramFormat& format = job.machine.format;
  const std::string_view words = table_of(format.dialect).tcp_length;
  const std::size_t begin = head.find(words.substr(0, words.find(' '))), at = message.find(name + ":");
  if (begin == head.npos || at == message.npos) return "";
  const auto first = static_cast<std::size_t>(
      1 + std::count(head.begin(), head.begin() + static_cast<std::ptrdiff_t>(begin), '\n'));
  const std::size_t line = std::strtoull(message.c_str() + at + name.size() + 1, nullptr, 10);
  if (line < first || line >= first + turn.blocks) return "";
  const bool highest = format.tcp_start_below <= kAtTheEnd;
  return "; there the table turns from home to its place, the " + over_text(turn, job, kTop) + ": " +
         (highest ? "program.tcp_start_below_mm has it at the end of Z's travel, so "
                  : formatted("state a smaller program.tcp_start_below_mm than %.4g in %s, ",
                              format.tcp_start_below, job.machine.path.c_str())) +
         "put the part lower, take a shorter tool, or post without tcp";
}

}  // namespace tiltfeed::daemon
