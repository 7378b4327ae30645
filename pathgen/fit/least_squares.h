#pragma once
// Nonlinear least squares of a few parameters, by Levenberg and Marquardt. (H2) in pathgen/fit/README.md.

#include <functional>
#include <span>
#include <vector>

namespace tiltfeed::pathgen {

/// Writes the residuals, all of them, of these parameters.
using Residuals = std::function<void(std::span<const double> parameters, std::span<double> residuals)>;

struct LeastSquares {
  std::vector<double> at;          ///< the parameters
  double sum = 0.0;                ///< of the squares of the residuals
  std::vector<double> covariance;  ///< of the parameters, row by row, for residuals of variance 1
  bool settled = false;            ///< no step makes the sum less; else the steps ran out
};

/// Requires: parameters and residuals of the order of 1, at least as many residuals as parameters. What no
/// residual depends on stays as it is, and has a variance of 0.
LeastSquares least_squares(std::vector<double> start, std::size_t residuals, const Residuals& of);

/// Eigenvalues of a symmetric matrix, given row by row, the smallest first, and their unit eigenvectors.
struct EigenPairs {
  std::vector<double> values;
  std::vector<std::vector<double>> vectors;
};
EigenPairs eigen_pairs(std::span<const double> matrix, std::size_t size);

}  // namespace tiltfeed::pathgen
