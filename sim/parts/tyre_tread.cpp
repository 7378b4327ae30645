#include "sim/parts/tyre_tread.h"

#include <algorithm>
#include <cmath>

namespace tiltfeed::sim {
namespace {

constexpr double kDraft = 5.0;
constexpr double kWallRho = 86.5;  ///< of the middle of the walls: converts the draft to angles
constexpr double kShear = 9.0;  ///< mm, of the chevron from Phi = 0 to the edge, in the middle of the sector
constexpr double kTreadRadius = kCircleRadius + kSectionRadius;
constexpr double kRibHeight = 8.0;      ///< of the circumferential ribs
constexpr double kRibHalfWidth = 2.96;  ///< degrees of Phi, at the foot: 9.3 mm
constexpr double kRibPhi[] = {11.0, 33.0};
/// Degrees of Phi that a wall 1 mm high is wide.
const double kPhiPerHeight = std::tan(kDraft * kDegree) / kWallRho / kDegree;

/// Height of a rib between `from` and `to` at x if it had no top; its walls are `width_per_height` wide.
double rise(double x, double from, double to, double width_per_height) {
  return std::min(x - from, to - x) / width_per_height;
}

}  // namespace

Tread::Row Tread::make_row(double phi, std::vector<Blade> blades,
                           const std::vector<std::pair<int, int>>& ranges) {
  const double radius = kCircleRadius + kWallRho * std::cos(phi * kDegree);
  const double cell = radius * 2.0 * kTheta * kDegree / kThetaCells;
  Row row{std::tan(kDraft * kDegree) / cell, std::move(blades), {{0, 0.0}}};
  for (std::size_t b = 0; b < row.blades.size(); ++b) {
    const Blade& blade = row.blades[b];
    const auto [first, last] = ranges[b];
    const double wall = blade.height * row.cells_per_height;
    row.lines.push_back({first, blade.cell_from});
    row.lines.push_back({first + 1, blade.cell_from + wall});
    row.lines.push_back({last - 1, blade.cell_to - wall});
    row.lines.push_back({last, blade.cell_to});
  }
  row.lines.push_back({kPitchCells, kPitchCells});
  return row;
}

double Tread::height_at(double cells, double phi) const {
  const double side = std::abs(phi);
  double height = 0.0;
  for (const double middle : kRibPhi) {
    const double up = rise(side, middle - kRibHalfWidth, middle + kRibHalfWidth, kPhiPerHeight);
    height = std::max(height, std::min(kRibHeight, up));
  }
  const Row& row = rows_[side < kRibPhi[0] ? 0 : side < kRibPhi[1] ? 1 : 2];
  const double in_pitch = cells - kPitchCells * std::floor(cells / kPitchCells);
  for (const Blade& blade : row.blades) {
    const double up = std::min(rise(in_pitch, blade.cell_from, blade.cell_to, row.cells_per_height),
                               rise(side, blade.phi_from, blade.phi_to, kPhiPerHeight));
    height = std::max(height, std::min(blade.height, up));
  }
  return height;
}

double Tread::line_in_row(const Row& row, int line) {
  std::size_t knot = 1;
  while (row.lines[knot].first < line) ++knot;
  const auto [line_from, cell_from] = row.lines[knot - 1];
  const auto [line_to, cell_to] = row.lines[knot];
  return cell_from + (cell_to - cell_from) * (line - line_from) / (line_to - line_from);
}

double Tread::line_at(int i, double phi) const {
  const int pitch = std::min(i / kPitchCells, kPitches - 1), line = i - pitch * kPitchCells;
  const double side = std::abs(phi), half_top = kRibHalfWidth - kRibHeight * kPhiPerHeight;
  double cells = line_in_row(rows_[0], line);
  // From one row's places to the next one's on the top of the rib between them.
  for (int rib = 0; rib < 2; ++rib) {
    const double across = std::clamp((side - kRibPhi[rib] + half_top) / (2.0 * half_top), 0.0, 1.0);
    cells += across * (line_in_row(rows_[rib + 1], line) - cells);
  }
  return pitch * kPitchCells + cells;
}

double Tread::theta_of(double cells, double phi) {
  const double straight = (cells / kThetaCells - 0.5) * 2.0 * kTheta;
  const double fade = std::cos(0.5 * std::numbers::pi * straight / kTheta);
  // The chevron fades to nothing at the sector faces.
  const double shear = kShear * (std::abs(phi) / kPhi - 0.5) * fade * fade;
  return straight + shear / kTreadRadius / kDegree;
}

std::vector<Tread::PhiLine> Tread::phi_lines() {
  struct Span {
    double to;
    int cells;
    bool coarse;  ///< its last line
  };
  const double w = kPhiPerHeight, half = kRibHalfWidth, rib = kRibPhi[0], outer_rib = kRibPhi[1];
  const Span spans[] = {{rib - half, 9, true},
                        {rib - half + 5.0 * w, 1, false},
                        {rib - half + 8.0 * w, 1, false},
                        {rib + half - 8.0 * w, 5, false},
                        {rib + half - 7.0 * w, 1, false},
                        {rib + half, 1, true},
                        {18.0, 5, true},
                        {18.0 + 4.0 * w, 1, false},
                        {26.0 - 4.0 * w, 8, false},
                        {26.0, 1, true},
                        {outer_rib - half, 5, true},
                        {outer_rib - half + 7.0 * w, 1, false},
                        {outer_rib - half + 8.0 * w, 1, false},
                        {outer_rib + half - 8.0 * w, 5, false},
                        {outer_rib + half - 7.0 * w, 1, false},
                        {outer_rib + half, 1, true},
                        {40.0, 5, true},
                        {40.0 + 4.0 * w, 1, false},
                        {50.0 - 4.0 * w, 10, false},
                        {50.0, 1, true},
                        {51.6 - 7.0 * w, 2, false},
                        {51.6, 1, true},
                        {kPhi, 4, true}};
  std::vector<PhiLine> upper;
  double from = 0.0;
  for (const Span& span : spans) {
    for (int cell = 1; cell < span.cells; ++cell)
      upper.push_back({from + (span.to - from) * cell / span.cells, true});
    upper.push_back({span.to, span.coarse});
    from = span.to;
  }
  std::vector<PhiLine> lines;
  for (auto line = upper.rbegin(); line != upper.rend(); ++line) lines.push_back({-line->phi, line->coarse});
  lines.push_back({0.0, true});
  lines.insert(lines.end(), upper.begin(), upper.end());
  return lines;
}

}  // namespace tiltfeed::sim
