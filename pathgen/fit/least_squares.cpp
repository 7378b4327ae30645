#include "pathgen/fit/least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tiltfeed::pathgen {

namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr int kMostSteps = 200;
/// Parameters are of the order of 1: central differences of this step are right to some 1e-10.
constexpr double kDifference = 1e-6;
/// A step that changes the parameters by less than this ends the search.
constexpr double kLeastStep = 1e-14;
/// Marquardt's damping: where it starts, how it shrinks and grows, where it is given up.
constexpr double kDamping = 1e-4, kEased = 0.2, kStiffened = 5.0, kMostDamping = 1e12;
/// A step that makes the sum larger by no more than this share of it has met its rounding.
constexpr double kSumRounding = 1e-14;
/// Residuals below this are the rounding of doubles of the order of 1.
constexpr double kNothing = 1e-14;
/// What changes the residuals by less than this share of the strongest parameter has no say.
constexpr double kNoSay = 1e-13;

std::span<const double> span_of(const Vector& v) { return {v.data(), static_cast<std::size_t>(v.size())}; }

class Problem {
 public:
  Problem(std::size_t residuals, const Residuals& of)
      : count_(static_cast<Eigen::Index>(residuals)), of_(of) {}

  Vector residuals(const Vector& at) const {
    Vector r(count_);
    of_(span_of(at), {r.data(), static_cast<std::size_t>(r.size())});
    return r;
  }
  Matrix jacobian(const Vector& at) const {
    Matrix j(count_, at.size());
    for (Eigen::Index k = 0; k < at.size(); ++k) {
      Vector above = at, below = at;
      above[k] += kDifference, below[k] -= kDifference;
      j.col(k) = (residuals(above) - residuals(below)) / (above[k] - below[k]);
    }
    return j;
  }

 private:
  Eigen::Index count_;
  const Residuals& of_;
};

/// The damped step: least squares of J and, under it, the damping's rows; by QR, as J^T J would halve the
/// digits of short arcs.
Vector damped_step(const Matrix& j, const Vector& r, double damping) {
  const Eigen::Index n = j.cols();
  Matrix tall(j.rows() + n, n);
  Vector right(j.rows() + n);
  tall.topRows(j.rows()) = j, right.head(j.rows()) = -r;
  Vector scale = j.colwise().norm().transpose();
  scale = scale.cwiseMax(kNoSay * std::max(scale.maxCoeff(), 1e-300));
  tall.bottomRows(n) = (std::sqrt(damping) * scale).asDiagonal();
  right.tail(n).setZero();
  return tall.colPivHouseholderQr().solve(right);
}

Matrix covariance_of(const Matrix& j) {
  const Eigen::JacobiSVD<Matrix> svd(
      Matrix(j.householderQr().matrixQR().topRows(j.cols()).triangularView<Eigen::Upper>()),
      Eigen::ComputeFullV);
  Vector inverse = svd.singularValues();
  for (double& s : inverse) s = s > kNoSay * svd.singularValues()[0] ? 1.0 / (s * s) : 0.0;
  return svd.matrixV() * inverse.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

LeastSquares least_squares(std::vector<double> start, std::size_t residuals, const Residuals& of) {
  const Problem problem(residuals, of);
  Vector at = Eigen::Map<const Vector>(start.data(), static_cast<Eigen::Index>(start.size()));
  Vector r = problem.residuals(at);
  Matrix j = problem.jacobian(at);
  double damping = kDamping;
  LeastSquares result;
  for (int step = 0; step < kMostSteps && !result.settled; ++step) {
    const Vector way = damped_step(j, r, damping);
    const Vector there = at + way, r_there = problem.residuals(there);
    const double sum = r.squaredNorm(), sum_there = r_there.squaredNorm();
    const bool tiny = way.norm() <= kLeastStep * (1.0 + at.norm());
    if (!(sum_there < sum)) {
      damping *= kStiffened;
      result.settled = tiny || damping > kMostDamping || sum_there - sum <= kSumRounding * sum;
      continue;
    }
    result.settled = tiny || sum_there <= kNothing * kNothing * static_cast<double>(residuals);
    at = there, r = r_there, j = problem.jacobian(at);
    damping = std::max(damping * kEased, 1e-20);
  }
  result.at.assign(at.data(), at.data() + at.size());
  result.sum = r.squaredNorm();
  const Matrix covariance = covariance_of(j);
  result.covariance.assign(covariance.data(), covariance.data() + covariance.size());
  return result;
}

EigenPairs eigen_pairs(std::span<const double> matrix, std::size_t size) {
  const auto n = static_cast<Eigen::Index>(size);
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(Eigen::Map<const Matrix>(matrix.data(), n, n));
  EigenPairs pairs;
  for (Eigen::Index i = 0; i < n; ++i) {
    pairs.values.push_back(solver.eigenvalues()[i]);
    const Vector v = solver.eigenvectors().col(i);
    pairs.vectors.emplace_back(v.data(), v.data() + n);
  }
  return pairs;
}

}  // namespace tiltfeed::pathgen
