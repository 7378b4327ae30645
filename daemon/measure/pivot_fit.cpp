#include "daemon/measure/pivot_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "kinematics/basics/decimal.h"

namespace tiltfeed::daemon {
namespace {

// A singular value below this share of the largest is none [Golub, Van Loan].
constexpr double kRankCut = 1e-6;
constexpr int kMostSteps = 60, kMostHalvings = 12;
constexpr double kStill = 1e-8;  // mm
// Touches whose sphere is this flat do not tell its centre.
constexpr double kFlat = 0.05;
constexpr int kLeastFreedom = 3;
// What is left falls to a third without a wrong place; by chance it falls by a tenth.
constexpr double kWrongPlace = 3.0;
constexpr int kFreedomToDoubt = 6;
// Larger than any machine that is worth being measured leaves, mm.
constexpr double kMostNoise = 0.1;
// Another sign has to fit so much better, as variance.
constexpr double kOtherSign = 100.0;
// A value whose slope along what cannot be told is less is told.
constexpr double kTold = 1e-4;

struct Place {
  BallPlace at;
  std::vector<Vec3> axes;  ///< touches, or one centre
};

/// Readings against a model, and the Gauss-Newton way to the best one.
class Adjustment {
 public:
  Adjustment(std::vector<Place> places, std::vector<Unknown> unknowns, bool touches)
      : places_(std::move(places)), unknowns_(std::move(unknowns)), touches_(touches) {}

  const std::vector<Unknown>& unknowns() const { return unknowns_; }

  Eigen::VectorXd rest(const BallMachine& machine) const {
    std::vector<double> all;
    for (const Place& place : places_) {
      const Vec3 centre = reading_at(machine, place.at);
      for (const Vec3 axes : place.axes) {
        const Vec3 off = axes - centre;
        if (touches_)
          all.push_back(length(off) - machine.radius);
        else
          all.insert(all.end(), {off.x, off.y, off.z});
      }
    }
    return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
  }

  /// How the rest falls with each unknown.
  Eigen::MatrixXd slopes(const BallMachine& machine) const {
    Eigen::MatrixXd all(rest(machine).size(), static_cast<Eigen::Index>(unknowns_.size()));
    for (std::size_t i = 0; i < unknowns_.size(); ++i)
      all.col(static_cast<Eigen::Index>(i)) =
          (rest(moved(machine, unknowns_[i], -kSlopeStep)) - rest(moved(machine, unknowns_[i], kSlopeStep))) /
          (2.0 * kSlopeStep);
    return all;
  }

  BallMachine best(BallMachine machine) const {
    double square = rest(machine).squaredNorm();
    for (int step = 0; step < kMostSteps; ++step) {
      Eigen::JacobiSVD<Eigen::MatrixXd> svd(slopes(machine), Eigen::ComputeThinU | Eigen::ComputeThinV);
      svd.setThreshold(kRankCut);
      Eigen::VectorXd way = svd.solve(rest(machine));
      for (int i = 0; i < kMostHalvings; ++i, way *= 0.5) {
        const BallMachine next = after(machine, way);
        const double now = rest(next).squaredNorm();
        if (!(now <= square)) continue;
        machine = next, square = now;
        break;
      }
      if (way.norm() < kStill) break;
    }
    return machine;
  }

 private:
  BallMachine after(BallMachine machine, const Eigen::VectorXd& way) const {
    for (std::size_t i = 0; i < unknowns_.size(); ++i)
      machine = moved(machine, unknowns_[i], way[static_cast<Eigen::Index>(i)]);
    return machine;
  }

  std::vector<Place> places_;
  std::vector<Unknown> unknowns_;
  bool touches_;
};

/// The centre of the sphere through touches; nothing where they lie in one plane.
std::optional<Vec3> centre_of(const std::vector<Vec3>& touches, double& radius) {
  const Vec3 from = touches.front();
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(touches.size()), 4);
  Eigen::VectorXd square(rows.rows());
  double widest = 0.0;
  for (const Vec3 t : touches) widest = std::max(widest, length(t - from));
  if (widest == 0.0) return std::nullopt;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const Vec3 t = (touches[static_cast<std::size_t>(i)] - from) / widest;
    rows.row(i) << t.x, t.y, t.z, 1.0;
    square[i] = squared_length(t);
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows, Eigen::ComputeThinU | Eigen::ComputeThinV);
  if (svd.singularValues()[3] < kFlat * svd.singularValues()[0]) return std::nullopt;
  const Eigen::VectorXd found = svd.solve(square);
  const Vec3 centre{found[0] / 2, found[1] / 2, found[2] / 2};
  radius = widest * std::sqrt(std::max(0.0, found[3] + squared_length(centre)));
  return from + centre * widest;
}

/// The centre of touches whose sphere's radius is known, near `centre`.
Vec3 centre_with(const std::vector<Vec3>& touches, double radius, Vec3 centre) {
  for (int step = 0; step < 20; ++step) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Vec3 t : touches) {
      const double off = length(t - centre);
      const Eigen::Vector3d n((t.x - centre.x) / off, (t.y - centre.y) / off, (t.z - centre.z) / off);
      normal += n * n.transpose();
      right += n * (off - radius);
    }
    const Eigen::Vector3d way = normal.ldlt().solve(right);
    centre = centre + Vec3{way.x(), way.y(), way.z()};
    if (way.norm() < kStill) break;
  }
  return centre;
}

struct Measurement {
  std::vector<Place> places, centres;
  double radius = 0.0;
  bool spindle = false;
  double tool_length = 0.0;
};

Result<Measurement> measurement_of(const BallReadings& readings) {
  Measurement m;
  m.places.resize(readings.places.size());
  double shortest = 1e300, longest = -1e300;
  for (const BallReading& one : readings.all) {
    Place& place = m.places[static_cast<std::size_t>(one.place)];
    place.at = one.at;
    place.axes.push_back(one.axes);
    shortest = std::min(shortest, one.at.tool_length);
    longest = std::max(longest, one.at.tool_length);
    m.tool_length += one.at.tool_length / static_cast<double>(readings.all.size());
  }
  m.spindle = longest - shortest >= kTwoLengths;
  m.centres = m.places;
  for (std::size_t i = 0; readings.touches && i < m.centres.size(); ++i) {
    double radius = 0.0;
    const auto centre = centre_of(m.places[i].axes, radius);
    if (!centre)
      return fail(Code::kInput,
                  "the touches of place " + readings.places[i] +
                      " lie in one plane, so they do not tell the ball's centre; touch it from the "
                      "sides and from above");
    m.centres[i].axes = {*centre};
    m.radius += radius / static_cast<double>(m.centres.size());
  }
  return m;
}

/// The best machine from the profile's values; from other signs, where they explain the readings and its own
/// do not.
BallMachine best_of_signs(const MachineModel& before, const Measurement& m) {
  const Adjustment all(m.centres, unknowns_of(before, m.spindle, false), false);
  std::vector<Unknown> lengths;
  for (const Unknown u : all.unknowns())
    if (u.what != Sought::kRotary && u.what != Sought::kTilt && u.what != Sought::kSpindle)
      lengths.push_back(u);
  const Adjustment straight(m.centres, lengths, false);
  std::optional<BallMachine> best;
  double square = 0.0;
  for (const int turned : {0, 1, 2, 3}) {
    if ((turned & 1 && !before.tilt.present) || (turned & 2 && !before.rotary.present)) continue;
    BallMachine start{before, {}, m.radius};
    if (turned & 1) start.machine.tilt.direction = -before.tilt.direction;
    if (turned & 2) start.machine.rotary.direction = -before.rotary.direction;
    const BallMachine found = all.best(straight.best(start));
    const double now = all.rest(found).squaredNorm();
    if (best && now * kOtherSign >= square) continue;
    best = found, square = now;
  }
  return *best;
}

PivotFit fitted(const MachineModel& before, const Measurement& m, bool touches, const BallMachine& start) {
  const Adjustment all(m.places, unknowns_of(before, m.spindle, touches), touches);
  PivotFit fit;
  fit.found = all.best(start);
  fit.spindle = m.spindle;
  fit.tool_length = m.tool_length;
  fit.known.unknowns = all.unknowns();
  const Eigen::MatrixXd slopes = all.slopes(fit.found);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(slopes);
  const Eigen::VectorXd& singular = svd.singularValues();
  for (Eigen::Index i = 0; i < singular.size(); ++i) fit.rank += singular[i] > kRankCut * singular[0] ? 1 : 0;
  fit.full_rank = static_cast<int>(all.unknowns().size()) - gauges_of(before);
  if (fit.rank >= fit.full_rank) fit.condition = singular[0] / singular[fit.full_rank - 1];
  const Eigen::VectorXd rest = all.rest(fit.found);
  fit.freedom = static_cast<int>(rest.size()) - fit.rank;
  fit.noise = fit.freedom > 0 ? std::sqrt(rest.squaredNorm() / fit.freedom) : 0.0;
  // Readings without any noise still have the digits that they were written with.
  const double noise = std::max(fit.noise, 1e-7);
  const Eigen::MatrixXd information = slopes.transpose() * slopes / (noise * noise);
  fit.known.information.assign(information.data(), information.data() + information.size());
  return fit;
}

void add_places(PivotFit& fit, const Measurement& m, bool touches) {
  for (std::size_t i = 0; i < m.places.size(); ++i) {
    const Vec3 fits = reading_at(fit.found, m.places[i].at);
    const Vec3 centre =
        touches ? centre_with(m.places[i].axes, fit.found.radius, m.centres[i].axes[0]) : m.places[i].axes[0];
    const double size = length(centre - fits);
    fit.places.push_back(
        {m.places[i].at, centre - fits, fit.noise > 0 ? size / (fit.noise * std::sqrt(3.0)) : 0});
  }
}

/// The place without which the rest fits much better.
std::optional<std::size_t> wrong_place(const MachineModel& before, const Measurement& m, bool touches,
                                       const PivotFit& fit) {
  std::optional<std::size_t> wrong;
  double least = fit.noise / kWrongPlace;
  for (std::size_t i = 0; i < m.places.size(); ++i) {
    Measurement less = m;
    less.places.erase(less.places.begin() + static_cast<std::ptrdiff_t>(i));
    less.centres.erase(less.centres.begin() + static_cast<std::ptrdiff_t>(i));
    const PivotFit without = fitted(before, less, touches, fit.found);
    if (without.rank < fit.rank || without.freedom < kFreedomToDoubt || without.noise >= least) continue;
    wrong = i, least = without.noise;
  }
  return wrong;
}

Result<void> check_rest(const MachineModel& before, const Measurement& m, const BallReadings& readings,
                        const PivotFit& fit) {
  if (fit.freedom < kLeastFreedom)
    return fail(Code::kInput, std::to_string(readings.places.size()) + " places give " +
                                  std::to_string(fit.freedom + fit.rank) + " readings for " +
                                  std::to_string(fit.rank) +
                                  " numbers, so their spread is not known; measure at more places");
  if (const auto wrong = wrong_place(before, m, readings.touches, fit)) {
    const auto line = std::find_if(readings.all.begin(), readings.all.end(), [&](const BallReading& one) {
      return one.place == static_cast<int>(*wrong);
    });
    return fail(
        Code::kInput,
        "place " + readings.places[*wrong] + " (line " + std::to_string(line->line) +
            ") does not fit the others: with it the readings lie " + decimal(fit.noise, 4) +
            " mm from any such machine, without it less than a third; measure it again or take it out");
  }
  if (fit.noise > kMostNoise)
    return fail(Code::kInput, "the readings lie " + decimal(fit.noise, 3) +
                                  " mm (standard deviation) from the best machine of this structure; look at "
                                  "structure, words, units and tool lengths");
  return {};
}

Eigen::Map<const Eigen::MatrixXd> matrix_of(const Knowledge& known) {
  const auto n = static_cast<Eigen::Index>(known.unknowns.size());
  return {known.information.data(), n, n};
}

}  // namespace

std::vector<ValueSpread> spreads(const PivotFit& fit, const MachineModel& before) {
  const auto values = [&](const BallMachine& machine) {
    return measured_values(settled(machine, before, fit.spindle, fit.tool_length), before, fit.spindle);
  };
  std::vector<ValueSpread> all;
  for (MeasuredValue& value : values(fit.found)) all.push_back({std::move(value), {}, true});
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(matrix_of(fit.known));
  const double cut = kRankCut * kRankCut * axes.eigenvalues().maxCoeff();
  const auto n = static_cast<Eigen::Index>(fit.known.unknowns.size());
  std::vector<std::vector<Eigen::VectorXd>> slopes(all.size());
  for (std::size_t i = 0; i < all.size(); ++i)
    slopes[i].assign(all[i].value.parts.size(), Eigen::VectorXd::Zero(n));
  for (Eigen::Index j = 0; j < n; ++j) {
    const Unknown unknown = fit.known.unknowns[static_cast<std::size_t>(j)];
    const auto up = values(moved(fit.found, unknown, kSlopeStep)),
               down = values(moved(fit.found, unknown, -kSlopeStep));
    for (std::size_t i = 0; i < all.size(); ++i)
      for (std::size_t k = 0; k < slopes[i].size(); ++k)
        slopes[i][k][j] = (up[i].parts[k] - down[i].parts[k]) / (2.0 * kSlopeStep);
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const Eigen::VectorXd& slope : slopes[i]) {
      const Eigen::VectorXd along = axes.eigenvectors().transpose() * slope;
      double variance = 0.0;
      for (Eigen::Index j = 0; j < n; ++j) {
        if (axes.eigenvalues()[j] > cut)
          variance += along[j] * along[j] / axes.eigenvalues()[j];
        else
          all[i].told = all[i].told && std::abs(along[j]) < kTold;
      }
      all[i].spread.push_back(std::sqrt(variance));
    }
  }
  return all;
}

Explanation explained(const BallMachine& start, const BallReadings& readings,
                      const std::vector<Unknown>& free) {
  std::vector<Place> places;
  for (const BallReading& one : readings.all) places.push_back({one.at, {one.axes}});
  Explanation all{Adjustment(places, free, false).best(start), {}};
  for (const BallReading& one : readings.all)
    all.rests.push_back(length(one.axes - reading_at(all.machine, one.at)));
  return all;
}

Result<PivotFit> fit_pivots(const MachineModel& before, const BallReadings& readings) {
  if (!before.tilt.present && !before.rotary.present)
    return fail(Code::kInput, before.name + " has no rotary axis, so there is no pivot to measure");
  const Result<Measurement> m = measurement_of(readings);
  if (!m) return tl::unexpected<Error>(m.error());
  PivotFit fit = fitted(before, *m, readings.touches, best_of_signs(before, *m));
  if (const Result<void> fits = check_rest(before, *m, readings, fit); !fits)
    return tl::unexpected<Error>(fits.error());
  for (const ValueSpread& one : spreads(fit, before))
    if (!one.told) fit.untold.push_back(one.value.key);
  add_places(fit, *m, readings.touches);
  return fit;
}

}  // namespace tiltfeed::daemon
