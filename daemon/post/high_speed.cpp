#include "daemon/post/high_speed.h"

#include <algorithm>
#include <cmath>

#include "daemon/post/dialect.h"
#include "kinematics/basics/decimal.h"
#include "kinematics/basics/units.h"

namespace tiltfeed::daemon {
namespace {

constexpr int kDecimals = 4, kInchDecimals = 5;

/// {mode}. A Sinumerik's has a ten where degrees are stated besides.
int mode_of(config::Dialect dialect, config::Smoothing smoothing, bool turning) {
  const bool rough = smoothing == config::Smoothing::kRough, semi = smoothing == config::Smoothing::kSemi;
  if (dialect == config::Dialect::kHaas) return rough ? 1 : semi ? 2 : 3;
  if (dialect == config::Dialect::kSiemens) return (turning ? 10 : 0) + (rough ? 3 : semi ? 2 : 1);
  return rough ? 1 : 0;  // Heidenhain: 1 is roughing
}

/// With the last decimal no more than `value`, and not 0.
std::string at_most(double value, int decimals) {
  const double scale = decimal_scale(decimals);
  return decimal(std::max(std::floor(value * scale + 1e-9), 1.0) / scale, decimals);
}

bool turns_in_cuts(const std::vector<JointMove>& moves) {
  for (std::size_t i = 1; i < moves.size(); ++i) {
    const Joints &from = moves[i - 1].joints, &to = moves[i].joints;
    if (moves[i].kind != MoveKind::kRapid && (to.a != from.a || to.c != from.c)) return true;
  }
  return false;
}

}  // namespace

std::vector<std::string> high_speed_lines(const Posting& posting, const Operation& op) {
  const DialectTable& table = table_of(posting.machine.format.dialect);
  const bool turning = turns_in_cuts(op.words->moves);
  const double half = 0.5 * op.smoothing_tolerance;
  const config::ProgramFormat& format = posting.machine.format;
  const double within = (turning ? half : 2.0 * half) / config::unit_of(format);
  // Without degrees a Sinumerik's call ends with a 1.
  const bool none = table.dialect == config::Dialect::kSiemens && !turning;
  const std::string leans = at_most(Angle::from_radians(half / op.tool.length).degrees(), kDecimals);
  const Filling filling{{"mode", std::to_string(mode_of(table.dialect, op.smoothing, turning))},
                        {"within", at_most(within, format.inches ? kInchDecimals : kDecimals)},
                        {"leans", none ? "1" : leans}};
  return filled(table.smooth_on, filling);
}

}  // namespace tiltfeed::daemon
