#include "daemon/measure/tip_spread.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tiltfeed::daemon {
namespace {

// What is believed before any reading, mm (of angles at kLever): a profile that was measured badly. It makes
// what no reading tells large, not infinite.
constexpr double kBelieved = 2.0;
constexpr int kTilts = 5, kTurns = 6;                    // of the poses
constexpr double kGridTilt = 90.0;                       // degrees from home: further a stylus hardly gets
constexpr int kGridTilts = 7, kGridTurns = 8;            // of the places
constexpr double kBallSide = 120.0, kBallHeight = 80.0;  // mm: where a ball is put first

/// Words over the limits, at most `most` degrees from home; of an endless axis a whole turn.
std::vector<double> words_of(const RotaryAxis& axis, int count, double most) {
  if (!axis.present) return {axis.zero};
  double low = std::max(axis.min, axis.zero - most), high = std::min(axis.max, axis.zero + most);
  const bool whole = high - low >= 360.0;
  if (whole) low = axis.zero, high = axis.zero + 360.0;
  std::vector<double> words;
  for (int i = 0; i < count; ++i)
    words.push_back(low + (high - low) * i / (whole ? count : std::max(1, count - 1)));
  return words;
}

/// The numbers' slopes of the tip's place on the part at each pose, three columns a pose.
Eigen::MatrixXd tip_slopes(const PivotFit& fit, const MachineModel& before,
                           const std::vector<Unknown>& unknowns) {
  struct At {
    Point<Part> tip;
    double tilt, rotary;
  };
  const double side_x = std::min(kWorkSide, (before.x.max - before.x.min) / 2);
  const double side_y = std::min(kWorkSide, (before.y.max - before.y.min) / 2);
  const double height = std::min(kWorkHeight, before.z.max - before.z.min);
  std::vector<At> poses;
  for (const double tilt : words_of(before.tilt, kTilts, kWorkTilt))
    for (const double rotary : words_of(before.rotary, kTurns, 180.0))
      for (const double x : {-side_x, side_x})
        for (const double y : {-side_y, side_y})
          for (const double z : {0.0, height}) poses.push_back({{x, y, z}, tilt, rotary});
  // The part stands where it stands: what is measured is where the axes are under it.
  const auto settle = [&](const BallMachine& machine) {
    return settled(machine, before, fit.spindle, fit.tool_length);
  };
  const Vec3 centre = from_origin(settle(fit.found).table_centre);
  const auto words = [&](const MachineModel& m, const At& at) {
    Setup setup;
    setup.part_zero = centre - from_origin(m.table_centre);
    setup.tool_length = fit.tool_length;
    const Joints q = solve_linear(m, setup, at.tip, at.tilt, at.rotary);
    return Eigen::Vector3d(q.x, q.y, q.z);
  };
  Eigen::MatrixXd slopes(static_cast<Eigen::Index>(unknowns.size()),
                         3 * static_cast<Eigen::Index>(poses.size()));
  for (std::size_t j = 0; j < unknowns.size(); ++j) {
    const MachineModel up = settle(moved(fit.found, unknowns[j], kSlopeStep));
    const MachineModel down = settle(moved(fit.found, unknowns[j], -kSlopeStep));
    for (std::size_t i = 0; i < poses.size(); ++i)
      slopes.block<1, 3>(static_cast<Eigen::Index>(j), 3 * static_cast<Eigen::Index>(i)) =
          ((words(up, poses[i]) - words(down, poses[i])) / (2.0 * kSlopeStep)).transpose();
  }
  return slopes;
}

/// The largest root mean square error of a pose.
double largest(const Eigen::MatrixXd& information, const Eigen::MatrixXd& slopes) {
  const Eigen::MatrixXd half = information.llt().matrixL().solve(slopes);
  double most = 0.0;
  for (Eigen::Index i = 0; i < half.cols(); i += 3) {
    const Eigen::Matrix3d variance = half.middleCols<3>(i).transpose() * half.middleCols<3>(i);
    most = std::max(most, variance.trace());
  }
  return std::sqrt(most);
}

Eigen::MatrixXd believed(const Knowledge& known) {
  const auto n = static_cast<Eigen::Index>(known.unknowns.size());
  Eigen::MatrixXd all = Eigen::Map<const Eigen::MatrixXd>(known.information.data(), n, n);
  all.diagonal().array() += 1.0 / (kBelieved * kBelieved);
  return all;
}

Eigen::MatrixXd information_of(const BallMachine& machine, const std::vector<Unknown>& unknowns,
                               const BallPlace& place, double noise) {
  Eigen::MatrixXd slopes(3, static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t j = 0; j < unknowns.size(); ++j) {
    const Vec3 slope = (reading_at(moved(machine, unknowns[j], kSlopeStep), place) -
                        reading_at(moved(machine, unknowns[j], -kSlopeStep), place)) /
                       (2.0 * kSlopeStep);
    slopes.col(static_cast<Eigen::Index>(j)) << slope.x, slope.y, slope.z;
  }
  return slopes.transpose() * slopes / (noise * noise);
}

}  // namespace

double tip_spread(const PivotFit& fit, const MachineModel& before, const Knowledge& known) {
  return largest(believed(known), tip_slopes(fit, before, known.unknowns));
}

std::vector<NextPlace> next_places(const PivotFit& fit, const MachineModel& before, double noise,
                                   double wanted, int most) {
  const std::vector<Unknown>& unknowns = fit.known.unknowns;
  const Eigen::MatrixXd slopes = tip_slopes(fit, before, unknowns);
  struct Candidate {
    BallPlace at;
    Eigen::MatrixXd tells;
  };
  std::vector<Candidate> grid;
  for (const double tilt : words_of(before.tilt, kGridTilts, kGridTilt))
    for (const double rotary : words_of(before.rotary, kGridTurns, 180.0)) {
      const BallPlace at{std::round(tilt), std::round(rotary), fit.tool_length};
      grid.push_back({at, information_of(fit.found, unknowns, at, noise)});
    }
  std::vector<NextPlace> chosen;
  Eigen::MatrixXd information = believed(fit.known);
  double now = largest(information, slopes);
  while (static_cast<int>(chosen.size()) < most && now > wanted) {
    const Candidate* best = nullptr;
    double least = 0.0;
    for (const Candidate& one : grid) {
      const double then = largest(information + one.tells, slopes);
      if (best == nullptr || then < least) best = &one, least = then;
    }
    information += best->tells;
    now = least;
    chosen.push_back({best->at, now});
  }
  return chosen;
}

PivotFit nothing_measured(const MachineModel& before, double tool_length, bool spindle) {
  PivotFit fit;
  const double side =
      std::min(kBallSide, std::min(before.x.max - before.x.min, before.y.max - before.y.min) / 4);
  fit.found = {before, {side, side / 2, kBallHeight}, 0.0};
  fit.tool_length = tool_length;
  fit.spindle = spindle;
  fit.known.unknowns = unknowns_of(before, spindle, false);
  fit.known.information.assign(fit.known.unknowns.size() * fit.known.unknowns.size(), 0.0);
  return fit;
}

}  // namespace tiltfeed::daemon
